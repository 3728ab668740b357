//! Rigid bodies within surfaces of triangles: mass, motion and outline.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::common::Notes;
use crate::multibody::{gravity, machine, revolute, run};
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::{Mat3, Vec3, compile, mesh};

/// Surface of a box with its corner of lowest coordinates at `low`.
fn cuboid(low: [f64; 3], size: [f64; 3]) -> TriangulatedSurface {
    let corner = |i: usize| std::array::from_fn(|k| low[k] + if i >> k & 1 == 1 { size[k] } else { 0.0 });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
    let corners: Vec<[[f64; 3]; 3]> = faces.into_iter().flat_map(halves).map(|t| t.map(corner)).collect();
    TriangulatedSurface::new(&corners).unwrap()
}

fn within(surface: TriangulatedSurface, scale: f64) -> Option<BodyShape> {
    let surface = Some(Arc::new(surface));
    Some(BodyShape::Stl(StlShape { file: "part.stl".into(), scale, surface }))
}

/// The box as a shape, and as a surface in thousandths whose origin is the lowest corner, with rotated axes.
fn both() -> [RigidBody; 2] {
    let (size, at) = ([0.2, 0.1, 0.05], Vec3::new(0.3, -0.4, 0.5));
    let axes = [[0.6, 0.8, 0.0], [0.0, 0.0, 1.0]];
    let second = Vec3::z();
    let first = Vec3::new(0.6, 0.8, 0.0);
    let columns = Mat3::from_columns(&[first, second, first.cross(&second)]);
    let (velocity, angular_velocity) = ([0.1, 0.2, 0.3], [3.0, -1.0, 2.0]);
    let body = RigidBody {
        mass: None,
        density: Some(7800.0),
        axes,
        velocity,
        angular_velocity,
        ..RigidBody::new("part", at.into(), 1.0, None)
    };
    let centre = at + columns * Vec3::from(size) * 0.5;
    let of_file = cuboid([0.0; 3], size.map(|x| 1e3 * x));
    [
        RigidBody { shape: Some(BodyShape::Box(BoxShape { size })), at: centre.into(), ..body.clone() },
        RigidBody { shape: within(of_file, 1e-3), ..body },
    ]
}

#[test]
fn surface_of_a_box_has_the_inertia_and_the_motion_of_the_box() {
    let of = |body: RigidBody| {
        let hinge = revolute("hinge", "ground", "part", [0.3, -0.4, 0.6], [0.0, 0.0, 1.0]);
        let mut model = machine(0.5, 0.01, vec![body.clone()], Vec::new());
        let free = run(&model, &mut Notes::default());
        let still = RigidBody { velocity: [0.0; 3], angular_velocity: [0.0; 3], ..body };
        (model.bodies, model.joints, model.loads) = (vec![still], vec![hinge], gravity([0.0, -9.81, 0.0]));
        [free, run(&model, &mut Notes::default())]
    };
    let [as_shape, as_surface] = both().map(of);
    for ((system, state), (other, found)) in as_shape.iter().zip(&as_surface) {
        let [a, b] = [system, other].map(|system| &system.coordinates.bodies[0]);
        assert!((a.mass / b.mass - 1.0).abs() < 1e-12, "{} {}", a.mass, b.mass);
        assert!((a.euler - b.euler).norm() < 1e-12 * a.euler.norm(), "{} {}", a.euler, b.euler);
        let differences = |list: [&[[f64; 3]]; 2]| {
            max_norm(list[0].iter().zip(list[1]).map(|(a, b)| (Vec3::from(*a) - Vec3::from(*b)).norm()))
        };
        assert!(differences([&system.coordinates.reference, &other.coordinates.reference]) < 1e-12);
        assert!(max_norm(state.u.iter().map(|u| Vec3::from(*u).norm())) > 0.1, "it moves");
        assert!(differences([&state.u, &found.u]) < 1e-9, "{}", differences([&state.u, &found.u]));
    }
}

/// The outline is the surface, which moves with the body.
#[test]
fn outline_of_a_surface_is_closed_and_lies_on_the_box() {
    let [shape, surface] = both().map(|body| {
        let model = machine(0.5, 0.01, vec![body], Vec::new());
        let (system, state) = run(&model, &mut Notes::default());
        let points = system.outline.positions(&system.coordinates.reference, &state.u, 1.0);
        (system.outline.clone(), points.into_iter().map(Vec3::from).collect::<Vec<_>>())
    });
    let ((_, corners), (outline, points)) = (shape, surface);
    assert_eq!((points.len(), outline.quads.len(), outline.owner_of_quad.len()), (8, 12, 12));
    for x in &points {
        assert!(corners.iter().any(|corner| (corner - x).norm() < 1e-9), "{x}");
    }
    let mut sides = BTreeMap::new();
    for [a, b, c, d] in &outline.quads {
        assert_eq!(c, d);
        for (a, b) in [(a, b), (b, c), (c, a)] {
            *sides.entry((a.min(b), a.max(b))).or_insert(0) += 1;
        }
    }
    assert_eq!((sides.len(), sides.values().filter(|n| **n == 2).count()), (18, 18));
}

#[test]
fn surfaces_with_wrong_keys_are_refused() {
    let refused = |body: RigidBody| {
        let model = machine(1.0, 0.1, vec![body], Vec::new());
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        compile::build(&model, &mesh).err().expect("the model is wrong").to_string()
    };
    let [_, body] = both();
    let unread = BodyShape::Stl(StlShape { file: "part.stl".into(), scale: 1.0, surface: None });
    let message = refused(RigidBody { shape: Some(unread), ..body.clone() });
    assert!(message.contains("bodies[0].shape.file") && message.contains("has not been read"), "{message}");
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let message = refused(RigidBody { shape: within(cuboid([0.0; 3], [1.0; 3]), scale), ..body.clone() });
        assert!(message.contains("bodies[0].shape.scale"), "{message}");
    }
    let message = refused(RigidBody { shape: within(cuboid([0.0; 3], [1.0; 3]), 1e40), ..body.clone() });
    assert!(message.contains("the volume of the surface"), "{message}");
    let message = refused(RigidBody { inertia: Some([1.0; 3]), ..body.clone() });
    assert!(message.contains("has a shape and an inertia"), "{message}");
    let message = refused(RigidBody { density: None, ..body });
    assert!(message.contains("has no mass"), "{message}");
}
