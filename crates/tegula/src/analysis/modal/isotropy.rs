//! Whether supports, joints and springs that stand in the fixed frame let a model turn about an axis, and hold it in the same way in all
//! directions across the axis. Else there is no relative equilibrium, and the coefficients of small motions depend on the time.

use super::problem::Problem;
use super::spinning::Spin;
use super::strain_energy::tangent_energy;
use crate::analysis::State;
use crate::analysis::constraints::Rates;
use crate::constraint::Quantity;
use crate::element::{Motion, Nodal, TangentWeights};
use crate::norm::larger;
use crate::system::dof_map::CONSTRAINED;
use crate::system::{System, VectorKind};
use crate::{Error, Mat3, Result, Vec3};
use tegula_sparse::gmres::noise;

/// Rotation at which the model is held as at the start (rad): not a part of a full turn, as supports may have such symmetries.
const TURN: f64 = 1.0;
/// Difference over its size that is round-off.
const SAME: f64 = 1e-7;
/// Random motions that are compared.
const SAMPLES: usize = 3;

/// Refuses what holds a turning model in the fixed frame.
///
/// # Errors
/// Names a support, a joint or springs.
pub(super) fn refuse(problem: &mut Problem, spin: &Spin) -> Result<()> {
    let found = support(problem, spin).or_else(|| joint(problem, spin)).or_else(|| springs(problem, spin));
    match found {
        None => Ok(()),
        Some(what) => Err(Error::model(
            "loads",
            format!("the model turns, but {what}"),
            "where this turns with the model, say `ground = \"turns\"` in the load \"centrifugal\"; else hold the model on its axis, in the same \
             way in all directions across it",
        )),
    }
}

/// Velocities `A q` of the rotation by a unit angular velocity.
fn generator(system: &System, spin: &Spin, state: &State) -> Vec<Nodal> {
    let current = |v: usize| Vec3::from(system.coordinates.reference[v]) + Vec3::from(state.u[v]);
    let arm = |v: usize| match system.coordinates.kinds[v] {
        VectorKind::Position => current(v) - spin.at,
        _ => current(v),
    };
    (0..system.vectors()).map(|v| spin.axis.cross(&arm(v)).into()).collect()
}

fn largest(field: &[Nodal]) -> f64 {
    field.as_flattened().iter().map(|x| x.abs()).fold(0.0, larger)
}

/// A support that does not let the model turn, or holds it in some directions across the axis only.
fn support(problem: &mut Problem, spin: &Spin) -> Option<String> {
    let Problem { system, newton, state, .. } = problem;
    newton.assembly.follow(system, &state.point(system));
    let frames = &newton.assembly.frames;
    let velocities = generator(system, spin, state);
    let mut held = vec![[0.0; 3]; velocities.len()];
    frames.constrained_part(&velocities, &mut held);
    let size = larger(largest(&velocities), system.length);
    if let Some(v) = (0..held.len()).find(|v| !(Vec3::from(held[*v]).norm() <= SAME * size)) {
        return Some(format!(
            "a support holds {}, which would have to turn about the axis",
            system.place_name(v)
        ));
    }
    let turn = spin.axis.cross_matrix();
    let dofs = system.dofs();
    let anisotropic = |v: &usize| {
        let unit = dofs.unit.iter().find(|unit| unit.vector as usize == *v);
        let mut fixed = Mat3::zeros();
        match unit {
            Some(unit) => unit.fixed.iter().for_each(|e| fixed += e * e.transpose()),
            None => {
                for (i, _) in frames.of(*v).into_iter().enumerate().filter(|(_, n)| *n == CONSTRAINED) {
                    let e = Vec3::from(
                        frames.to_global(*v, std::array::from_fn(|k| f64::from(u8::from(k == i)))),
                    );
                    fixed += e * e.transpose();
                }
            }
        }
        !((fixed * turn - turn * fixed).amax() <= SAME)
    };
    let of_body = |v: &usize| {
        dofs.triads.as_flattened().contains(&(*v as u32))
            || dofs.attached.iter().any(|a| a.vector as usize == *v)
    };
    let found = (0..system.vectors()).filter(|v| !of_body(v)).find(anisotropic)?;
    Some(format!(
        "a support holds {} in some of the directions across the axis only, or its director",
        system.place_name(found)
    ))
}

/// A joint whose ground side holds a point beside the axis, or some of the directions across it only. Joints may hold the rotation itself,
/// as a drive at constant velocity.
fn joint(problem: &mut Problem, spin: &Spin) -> Option<String> {
    problem.newton.constraints.as_ref()?;
    let (system, velocities) = (problem.system, generator(problem.system, spin, &problem.state));
    let at_rest = problem.state.u.clone();
    let (turned, rotation) = turned(system, spin, &problem.state);
    let mut fields = vec![(at_rest, velocities.clone(), true)];
    for (random, n) in samples(problem.pattern.size()).into_iter().zip(0..SAMPLES) {
        let mut free = random;
        free.rotate_left(n);
        problem.constrain(&mut free);
        let mut field = vec![[0.0; 3]; system.vectors()];
        problem.newton.assembly.frames.expand(&free, &mut field);
        let field: Vec<Nodal> = field.iter().map(|x| (rotation * Vec3::from(*x)).into()).collect();
        fields.push((turned.clone(), field, false));
    }
    let time = problem.state.time;
    let constraints = problem.newton.constraints.as_mut()?;
    for (u, field, positions) in &fields {
        let size = SAME * larger(largest(field), f64::MIN_POSITIVE);
        let rates =
            constraints.rates(system, (&Motion::State { u, velocity: None }, time), Rates::Along(field));
        for joint in system.joints.iter() {
            let held = |(rate, row): (&f64, &crate::constraint::Row)| {
                let turns = *positions && row.keeps == Quantity::Axes;
                !(turns || rate.abs() <= size * larger(row.size, 1.0))
            };
            if rates[joint.multipliers()].iter().zip(&joint.rows).any(held) {
                return Some(format!(
                    "the joint \"{}\" holds a point beside the axis, or the model in some of the directions across the axis only",
                    joint.name
                ));
            }
        }
    }
    None
}

/// Springs, bushings or foundations on the ground whose forces or stiffness do not turn with the model.
fn springs(problem: &mut Problem, spin: &Spin) -> Option<String> {
    let Problem { system, state, .. } = problem;
    let (u, rotation) = turned(system, spin, state);
    let after = State { u, ..state.clone() };
    let factors: Vec<f64> = system.factors(state.time).collect();
    for (number, group, _) in system.numbered_groups().filter(|(_, group, _)| group.acts_on_ground()) {
        if group.name() == "joint" {
            continue;
        }
        let mut stiffness = 0.0;
        for sample in samples(3 * system.vectors()) {
            let (vectors, _) = sample.as_chunks::<3>();
            let rotated: Vec<Nodal> = vectors.iter().map(|x| (rotation * Vec3::from(*x)).into()).collect();
            let energy = |state: &State, field: &[Nodal]| {
                let k = state.point(system).of_group(system, number, &factors);
                tangent_energy(group, &k, TangentWeights::STATIC, field)
            };
            let [first, second] = [energy(state, vectors), energy(&after, &rotated)];
            stiffness = larger(stiffness, larger(first.abs(), second.abs()));
            if !((first - second).abs() <= SAME * stiffness) {
                return Some(format!(
                    "elements of the kind \"{}\" do not hold it to the ground in the same way in all directions across the axis",
                    group.name()
                ));
            }
        }
        let forces = |state: &State| {
            let mut out = vec![0.0; 3 * group.vectors_per_element() * group.len()];
            group.evaluate(&state.point(system).of_group(system, number, &factors), 0, &mut out, None);
            out
        };
        let [first, second] = [forces(state), forces(&after)];
        let pairs = first.as_chunks::<3>().0.iter().zip(second.as_chunks::<3>().0);
        let changes = pairs.map(|(a, b)| (rotation * Vec3::from(*a) - Vec3::from(*b)).norm());
        if !(tegula_sparse::norm::max_norm(changes) <= SAME * stiffness * system.length) {
            return Some(format!(
                "elements of the kind \"{}\" between it and the ground wind up, as they act beside the axis or about it",
                group.name()
            ));
        }
    }
    None
}

/// Random vectors of a length.
fn samples(size: usize) -> Vec<Vec<f64>> {
    let mut noise = noise();
    (0..SAMPLES).map(|_| noise.by_ref().take(size).collect()).collect()
}

/// Displacements of a state that has turned about the axis, and the rotation.
fn turned(system: &System, spin: &Spin, state: &State) -> (Vec<Nodal>, Mat3) {
    let rotation = *nalgebra::Rotation3::new(spin.axis * TURN).matrix();
    let of = |v: usize| -> Nodal {
        let reference = Vec3::from(system.coordinates.reference[v]);
        let centre =
            if system.coordinates.kinds[v] == VectorKind::Position { spin.at } else { Vec3::zeros() };
        (centre + rotation * (reference + Vec3::from(state.u[v]) - centre) - reference).into()
    };
    ((0..system.vectors()).map(of).collect(), rotation)
}
