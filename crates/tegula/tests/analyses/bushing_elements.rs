//! Energy, forces and tangent of a bushing as an element, against independent formulas and differences.

use nalgebra::{Rotation3, Vector6};

use crate::bushings::{askew, bushing, full, rows};
use crate::multibody::{body, machine};
use tegula::constraint::BushingGroup;
use tegula::element::{
    ElementGroup, GroupPoint, InternalVariables, Motion, Nodal, TangentRequest, TangentWeights,
};
use tegula::model::Bushing;
use tegula::norm::larger;
use tegula::{Mat3, System, Vec3, compile};

const CENTRES: [[f64; 3]; 2] = [[-0.4, 0.0, 0.1], [0.3, 0.2, 0.0]];
const AT: [f64; 3] = [0.1, -0.2, 0.3];

/// Two bodies with a bushing between them.
fn system(free: [f64; 6]) -> System {
    let bodies = ["a", "b"].into_iter().zip(CENTRES);
    let bodies = bodies.map(|(name, at)| body(name, at, 1.0, Some([0.2, 0.3, 0.4]))).collect();
    let mut model = machine(1.0, 0.1, bodies, Vec::new());
    model.bushings = vec![Bushing { stiffness_matrix: rows(&full()), free, ..bushing(["a", "b"], AT) }];
    compile::build(&model, &tegula::Mesh::default()).unwrap()
}

/// Group of the bushing.
fn group(system: &System) -> &dyn ElementGroup {
    system.groups.iter().find(|group| group.name() == BushingGroup::NAME).unwrap().as_ref()
}

/// Displacements of the nodal vectors of the bodies at these places with these rotations.
fn displaced(system: &System, poses: &[(Vec3, Mat3); 2]) -> Vec<Nodal> {
    let mut u = vec![[0.0; 3]; system.vectors()];
    for (body, (place, rotation)) in system.coordinates.bodies.iter().zip(poses) {
        let reference = |v: u32| Vec3::from(system.coordinates.reference[v as usize]);
        u[body.centre as usize] = (place - reference(body.centre)).into();
        for d in body.directors.unwrap() {
            u[d as usize] = (rotation * reference(d) - reference(d)).into();
        }
    }
    u
}

fn point<'a>(system: &'a System, motion: Motion<'a>, history: &'a [f64]) -> GroupPoint<'a> {
    GroupPoint {
        reference: &system.coordinates.reference,
        motion,
        linear: false,
        interior: InternalVariables { history, factors: &[] },
        inextensible: &[],
        multipliers: &[],
        time: 0.0,
        drives: &[],
        preload: 1.0,
    }
}

/// Strains by rotation matrices: displacement along the axes of the first body, logarithm of the relative rotation.
fn strains([(x, a), (y, b)]: &[(Vec3, Mat3); 2]) -> Vector6<f64> {
    let arm = |i: usize| Vec3::from(AT) - Vec3::from(CENTRES[i]);
    let (first, second) = (a * askew(), b * askew());
    let u = first.transpose() * (y + b * arm(1) - x - a * arm(0));
    let phi = Rotation3::from_matrix_unchecked(first.transpose() * second).scaled_axis();
    Vector6::new(u.x, u.y, u.z, phi.x, phi.y, phi.z)
}

fn poses(turn: f64) -> [(Vec3, Mat3); 2] {
    let rotation = |axis: [f64; 3]| Rotation3::new(Vec3::from(axis) * turn).into_inner();
    [
        (Vec3::new(0.3, -0.5, 1.0), rotation([0.5, -0.3, 0.8])),
        (Vec3::new(0.9, 0.1, 0.7), rotation([-0.4, 0.9, 0.1])),
    ]
}

/// The energy is ½ ε·K ε of the strains by rotation matrices, and a rigid motion of both bodies by a large angle does not change it.
#[test]
fn the_energy_is_that_of_the_rotation_vector_whatever_the_rigid_motion() {
    let system = system([0.0; 6]);
    for turn in [0.0, 1e-3, 0.3, 1.0, 1.6] {
        let poses = poses(turn);
        let strain = strains(&poses);
        let expected = 0.5 * strain.dot(&(full() * strain));
        let history: [f64; 3] = std::array::from_fn(|i| strain[3 + i]);
        for rigid in [Vec3::zeros(), Vec3::new(2.0, -1.0, 0.5), Vec3::new(0.3, 2.4, 1.6)] {
            let r = Rotation3::new(rigid).into_inner();
            let moved = poses.map(|(x, rotation)| (r * x + rigid * 3.0, r * rotation));
            let u = displaced(&system, &moved);
            let mut energy = [0.0];
            let motion = Motion::State { u: &u, velocity: None };
            group(&system).energies(&point(&system, motion, &history), &mut energy);
            assert!((energy[0] - expected).abs() < 1e-12 * expected, "{turn}: {} {expected}", energy[0]);
        }
    }
}

/// The forces are the derivatives of the energy, the tangent that of the forces, at a large rotation and under a preload; the
/// derivatives go out of the manifold of rotations.
#[test]
fn forces_and_tangent_are_derivatives_of_the_energy() {
    let system = system([0.05, -0.1, 0.02, 10.0, -30.0, 20.0]);
    let group = group(&system);
    let n = group.vectors_per_element();
    let mut u = displaced(&system, &poses(1.1));
    for (i, x) in u.as_flattened_mut().iter_mut().enumerate() {
        *x += 0.03 * (i as f64 * 1.7 + 0.4).sin();
    }
    let strain = strains(&poses(1.1));
    let history: [f64; 3] = std::array::from_fn(|i| strain[3 + i]);
    let evaluate = |u: &[Nodal], request: Option<TangentRequest>| {
        let (mut forces, mut energy) = (vec![0.0; 3 * n], [0.0]);
        let k = point(&system, Motion::State { u, velocity: None }, &history);
        group.evaluate(&k, 0, &mut forces, request);
        group.energies(&k, &mut energy);
        (forces, energy[0])
    };
    let mut blocks = vec![0.0; 9 * n * (n + 1) / 2];
    let weights = TangentWeights::STATIC;
    let request = TangentRequest { weights, stress: None, prescribed: None, blocks: &mut blocks };
    let (forces, _) = evaluate(&u, Some(request));
    let entry = |row: usize, column: usize| {
        let (a, b) = (row / 3, column / 3);
        let at = |a: usize, b: usize, i: usize, j: usize| blocks[9 * (a * (a + 1) / 2 + b) + 3 * i + j];
        if a >= b { at(a, b, row % 3, column % 3) } else { at(b, a, column % 3, row % 3) }
    };
    let size = blocks.iter().map(|k| k.abs()).fold(0.0, larger);
    for column in 0..3 * n {
        let vector = group.vectors(0)[column / 3] as usize;
        let moved = |step: f64| {
            let mut u = u.clone();
            u[vector][column % 3] += step;
            evaluate(&u, None)
        };
        let ((more, high), (less, low)) = (moved(1e-5), moved(-1e-5));
        let slope = (high - low) / 2e-5;
        assert!((slope - forces[column]).abs() < 1e-7 * size, "{column}: {slope} {}", forces[column]);
        for row in 0..3 * n {
            let difference = (more[row] - less[row]) / 2e-5;
            assert!((difference - entry(row, column)).abs() < 1e-7 * size, "{row} {column}");
        }
    }
}

/// In a step of the energy–momentum scheme the force does the work of the energies of both ends, and neither a resultant nor a moment
/// acts, whatever the motion.
#[test]
fn forces_of_a_step_do_the_work_of_the_energy_and_have_no_resultant() {
    let system = system([0.05, -0.1, 0.02, 10.0, -30.0, 20.0]);
    let group = group(&system);
    let n = group.vectors_per_element();
    for [before, after] in [[0.2, 1.4], [1.0, 1.0 + 1e-9], [0.0, 0.7], [1.5, 0.3]] {
        let [old, new] = [before, after].map(|turn| displaced(&system, &poses(turn)));
        let strain = strains(&poses(before));
        let history: [f64; 3] = std::array::from_fn(|i| strain[3 + i]);
        let k = point(&system, Motion::Step { old: &old, new: &new, dt: 0.1 }, &history);
        let mut forces = vec![0.0; 3 * n];
        group.evaluate(&k, 0, &mut forces, None);
        let energy = |u: &[Nodal]| {
            let mut energy = [0.0];
            group.energies(&point(&system, Motion::State { u, velocity: None }, &history), &mut energy);
            energy[0]
        };
        let (mut work, mut resultant, mut moment) = (0.0, Vec3::zeros(), Vec3::zeros());
        for (&v, f) in group.vectors(0).iter().zip(forces.chunks(3)) {
            let v = v as usize;
            let (f, x) = (Vec3::from_column_slice(f), Vec3::from(system.coordinates.reference[v]));
            let [old, new] = [Vec3::from(old[v]), Vec3::from(new[v])];
            work += f.dot(&(new - old));
            moment += (x + (old + new) * 0.5).cross(&f);
            if system.coordinates.kinds[v] == tegula::system::VectorKind::Position {
                resultant += f;
            }
        }
        let size = forces.iter().map(|f| f.abs()).fold(0.0, larger);
        let change = energy(&new) - energy(&old);
        assert!((work - change).abs() < 1e-13 * size, "{before} {after}: {work} {change}");
        assert!(resultant.norm() < 1e-13 * size && moment.norm() < 1e-13 * size, "{resultant} {moment}");
    }
}
