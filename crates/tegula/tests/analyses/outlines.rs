//! Outlines of bodies, beams and springs: shapes are closed surfaces of the right size that move with their bodies.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use crate::multibody::{between, body, gravity, machine, revolute, run};
use tegula::model::*;
use tegula::norm::larger;
use tegula::system::Outline;
use tegula::{System, Vec3, compile, mesh};

fn system(model: &Model) -> System {
    compile::build(model, &mesh::generators::generate(&model.mesh).unwrap()).unwrap()
}

fn shaped(name: &str, at: [f64; 3], shape: BodyShape) -> RigidBody {
    RigidBody { shape: Some(shape), ..RigidBody::new(name, at, 1.0, None) }
}

/// Points of the outline in the reference configuration.
fn reference(system: &System) -> Vec<Vec3> {
    let points = system.outline.positions(&system.coordinates.reference, &[], 0.0);
    points.into_iter().map(Vec3::from).collect()
}

/// Area of the faces of a part, and the number of sides that do not belong to exactly two of its faces.
fn area_and_open_sides(outline: &Outline, points: &[Vec3], part: u32) -> (f64, usize) {
    let (mut area, mut sides) = (0.0, BTreeMap::new());
    for (quad, [owner, _]) in outline.quads.iter().zip(&outline.owner_of_quad) {
        if *owner != part {
            continue;
        }
        let [a, b, c, d] = quad.map(|corner| points[corner as usize]);
        area += 0.5 * (c - a).cross(&(d - b)).norm();
        for i in 0..4 {
            let (a, b) = (quad[i], quad[(i + 1) % 4]);
            *sides.entry((a.min(b), a.max(b))).or_insert(0) += 1;
        }
    }
    (area, sides.values().filter(|count| **count != 2).count())
}

/// Area of a regular polygon of 24 corners, and its circumference.
fn polygon(radius: f64) -> [f64; 2] {
    let half = PI / 24.0;
    [24.0 * radius * radius * half.sin() * half.cos(), 48.0 * radius * half.sin()]
}

#[test]
fn shapes_are_closed_surfaces_of_their_size() {
    let cylinder =
        |inner_radius| BodyShape::Cylinder(CylinderShape { radius: 0.3, inner_radius, length: 2.0 });
    let bodies = vec![
        shaped("box", [1.0, 2.0, 3.0], BodyShape::Box(BoxShape { size: [0.2, 0.4, 0.6] })),
        shaped("cylinder", [0.0; 3], cylinder(0.0)),
        shaped("tube", [0.0; 3], cylinder(0.2)),
        shaped("ball", [0.0, 5.0, 0.0], BodyShape::Sphere(SphereShape { radius: 0.5 })),
        shaped("rod", [0.0, 0.0, 1.0], BodyShape::Rod(RodShape { length: 4.0 })),
    ];
    let system = system(&machine(1.0, 0.1, bodies, Vec::new()));
    let (outline, points) = (&system.outline, reference(&system));
    assert_eq!(outline.parts, ["box", "cylinder", "tube", "ball", "rod"]);
    let ([outer, around], [inner, around_hole]) = (polygon(0.3), polygon(0.2));
    let expected = [
        2.0 * (0.2 * 0.4 + 0.4 * 0.6 + 0.6 * 0.2),
        2.0 * outer + 2.0 * around,
        2.0 * (outer - inner) + 2.0 * (around + around_hole),
    ];
    for (part, expected) in (0..).zip(expected) {
        let (area, open) = area_and_open_sides(outline, &points, part);
        assert!((area - expected).abs() < 1e-12 && open == 0, "{part}: {area} {expected} {open}");
    }
    let (area, open) = area_and_open_sides(outline, &points, 3);
    assert!((area / PI - 1.0).abs() < 0.03 && open == 0, "{area} {open}");
    let of_ball: Vec<&Vec3> = outline
        .quads
        .iter()
        .zip(&outline.owner_of_quad)
        .filter(|(_, owner)| owner[0] == 3)
        .flat_map(|(quad, _)| quad.iter().map(|corner| &points[*corner as usize]))
        .collect();
    assert!(of_ball.iter().all(|x| ((*x - Vec3::new(0.0, 5.0, 0.0)).norm() - 0.5).abs() < 1e-12));
    let ends = outline.lines[0].map(|end| points[end as usize]);
    assert_eq!((outline.lines.len(), outline.owner_of_line[0]), (1, [4, 0]));
    assert!((ends[1] - ends[0] - Vec3::x() * 4.0).norm() < 1e-12, "{ends:?}");
}

/// A body without a shape has a line to each of its joints and springs; springs and rods without mass are lines.
#[test]
fn bodies_without_a_shape_reach_from_their_mass_centre_to_their_joints() {
    let inertia = Some([0.1; 3]);
    let bodies = vec![body("bar", [0.5, 0.0, 0.0], 1.0, inertia), body("mass", [2.0, 0.0, 0.0], 1.0, None)];
    let joints = vec![
        revolute("hinge", "ground", "bar", [0.0; 3], [0.0, 0.0, 1.0]),
        Joint::Distance(DistanceJoint {
            name: "rod".into(),
            between: between("bar", "mass"),
            points: [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
        }),
    ];
    let mut model = machine(0.3, 0.01, bodies, joints);
    model.loads = gravity([0.0, -9.81, 0.0]);
    model.springs = vec![SpringDamper {
        across: None,
        name: "spring".into(),
        between: between("ground", "bar"),
        points: [[0.0, 3.0, 0.0], [1.0, 0.0, 0.0]],
        stiffness: 1.0,
        damping: 0.0,
        force: None,
        length: None,
    }];
    let (system, state) = run(&model, &mut crate::common::Notes::default());
    let outline = &system.outline;
    assert_eq!(outline.parts, ["bar", "mass", "rod", "spring"]);
    let owners: Vec<u32> = outline.owner_of_line.iter().map(|owner| owner[0]).collect();
    assert_eq!(owners, [0, 0, 2, 0, 3]);
    let points = outline.positions(&system.coordinates.reference, &state.u, 1.0);
    let line = |i: usize| outline.lines[i].map(|end| Vec3::from(points[end as usize]));
    // The lines of the bar keep their length, and meet in its centre; the first one ends at the hinge, the rod at the mass.
    assert!(line(0)[1].norm() < 1e-12 && (line(0)[0].norm() - 0.5).abs() < 1e-9, "{:?}", line(0));
    assert!(line(0)[0].y < -0.01, "{:?}", line(0));
    assert!((line(1)[1] - line(2)[0]).norm() < 1e-12 && (line(1)[1] - line(0)[0] * 2.0).norm() < 1e-9);
    assert!(((line(2)[1] - line(2)[0]).norm() - 1.0).abs() < 1e-9, "{:?}", line(2));
    let mass = system.coordinates.bodies[1].centre as usize;
    let place = Vec3::from(system.coordinates.reference[mass]) + Vec3::from(state.u[mass]);
    assert!((line(2)[1] - place).norm() < 1e-12);
    assert_eq!(line(4)[0], Vec3::new(0.0, 3.0, 0.0));
}

/// The faces of a beam belong to its elements, and its ends are closed.
#[test]
fn beams_have_the_faces_of_their_sections() {
    let mut model = machine(1.0, 0.1, Vec::new(), Vec::new());
    let section = BeamSection::Rectangle(RectangularSection { size: [0.1, 0.2] });
    let ring = BeamSection::Circle(CircularSection { radius: 0.3, inner_radius: 0.2 });
    let steel = Isotropic { young: 2.1e11, poisson: 0.3, density: 7800.0, expansion: 0.0, strength: None };
    let beam = |name: &str, y: f64, section| Beam {
        material: Some("steel".into()),
        ..Beam::straight(name, [[0.0, y, 0.0], [2.0, y, 0.0]], 5, [0.0, 1.0, 0.0], section)
    };
    let hollow = BeamSection::Box(BoxSection { size: [0.2, 0.4], thickness: 0.05 });
    model.beams = vec![beam("flat", 0.0, section), beam("round", 4.0, ring), beam("hollow", 8.0, hollow)];
    model.materials.insert("steel".into(), Material::Isotropic(steel));
    let system = system(&model);
    let (outline, points) = (&system.outline, reference(&system));
    let ([outer, around], [inner, around_hole]) = (polygon(0.3), polygon(0.2));
    let of_box = 2.0 * (0.2 * 0.4 - 0.1 * 0.3) + 2.0 * (2.0 * 0.6 + 2.0 * 0.4);
    for (part, expected) in [
        (0, 2.0 * 0.1 * 0.2 + 2.0 * 2.0 * 0.3),
        (1, 2.0 * (outer - inner) + 2.0 * (around + around_hole)),
        (2, of_box),
    ] {
        let (area, open) = area_and_open_sides(outline, &points, part);
        assert!((area - expected).abs() < 1e-12 && open == 0, "{part}: {area} {expected} {open}");
    }
    for (quad, [_, element]) in outline.quads.iter().zip(&outline.owner_of_quad) {
        let middle = quad.iter().map(|corner| points[*corner as usize].x).sum::<f64>() / 4.0;
        // The faces that close the far end belong to the last element, too.
        let expected = if middle > 1.99 { 4 } else { (middle / 0.4) as u32 };
        assert_eq!(*element, expected, "{middle}");
    }
    let widest = points.iter().map(|x| x.z.abs()).fold(0.0, larger);
    assert!((widest - 0.3).abs() < 1e-12, "{widest}");
}
