//! Nearest positions in which the joints of a model are closed: their independence of order and units, and right angles and orientations of sides.

use crate::assembly::{Z, built, gaps};
use crate::multibody::{axis_joint, between, body, machine, pose, run};
use tegula::analysis::{Silent, State};
use tegula::model::*;
use tegula::{Mat3, Vec3};

/// Three boxes of masses 1, 1e-6 and 1000 and sizes 1, 0.01 and 30 on two hinges of other axes: an open chain, which can be closed whatever its masses.
/// Its nearest position is the same whichever side of a hinge is named first, also in other units, and at rest.
#[test]
fn the_nearest_position_depends_neither_on_the_order_of_sides_nor_on_units() {
    let chain = |swapped: [bool; 2], size: f64| {
        let at = |x: [f64; 3]| x.map(|x| x * size);
        let solid = |name: &str, place: [f64; 3], mass: f64, length: f64| {
            let [a, b, c] = [1.0, 0.6, 0.3].map(|part| (part * length * size).powi(2) * mass / 12.0);
            body(name, at(place), mass, Some([b + c, a + c, a + b]))
        };
        let bodies = vec![
            solid("a", [0.5, 0.0, 0.0], 1.0, 1.0),
            solid("b", [1.5, 0.3, 0.2], 1e-6, 0.01),
            solid("c", [3.0, -1.0, 0.5], 1e3, 30.0),
        ];
        type Side = ([f64; 3], [f64; 3]);
        let pin = |name: &str, sides: [&str; 2], places: [Side; 2], swapped: bool| {
            let [first, second] = if swapped { [1, 0] } else { [0, 1] };
            Joint::Revolute(
                AxisJoint {
                    second_at: Some(at(places[second].0)),
                    second_axis: Some(places[second].1),
                    ..axis_joint(name, sides[first], sides[second], at(places[first].0), places[first].1)
                }
                .into(),
            )
        };
        let joints = vec![
            pin("J1", ["a", "b"], [([1.0, 0.0, 0.0], Z), ([1.4, 0.3, 0.2], [0.0, 1.0, 0.0])], swapped[0]),
            pin("J2", ["b", "c"], [([1.6, 0.3, 0.2], Z), ([2.8, -1.0, 0.5], [0.0, 0.0, -1.0])], swapped[1]),
        ];
        let (system, state) = run(&machine(0.05, 0.01, bodies, joints), &mut Silent);
        assert!(gaps(&system, &state).iter().all(|gap| *gap < 1e-9 * size));
        let (place, axes) = pose(&system, &state, 0);
        (place / size, axes)
    };
    let (place, axes) = chain([false; 2], 1.0);
    for (swapped, size) in
        [([true, false], 1.0), ([false, true], 1.0), ([true; 2], 1.0), ([false; 2], 1e3), ([true; 2], 1e-3)]
    {
        let (other, turned) = chain(swapped, size);
        assert!(
            (place - other).norm() < 1e-7 && (axes - turned).norm() < 1e-7,
            "{swapped:?} {place} {other}"
        );
    }
}

/// Both sides of a fixed joint keep the orientation in which they are drawn, also where a third of a turn about a diagonal of its axes would bring the points together
/// by a shorter way.
#[test]
fn the_sides_of_a_fixed_joint_do_not_turn() {
    for at in [[1.0, 0.4, 0.0], [0.3, 0.9, -0.2], [0.7, -0.8, 0.5], [-0.4, 0.6, 0.9]] {
        for (second, inertia) in [([0.0, 1.0, 0.4], 1e-3), ([0.4, 0.0, 1.0], 1e-3), ([-0.8, 0.5, 0.7], 0.3)] {
            let joint = Joint::Fixed(PointJoint {
                name: "weld".into(),
                between: between("ground", "part"),
                at,
                second_at: Some(second),
            });
            let part = body("part", [0.1, 0.0, 0.0], 2.0, Some([inertia; 3]));
            let system = built(&machine(1.0, 0.1, vec![part], vec![joint]));
            let (place, axes) = pose(&system, &State::first(&system), 0);
            let expected = Vec3::new(0.1, 0.0, 0.0) + Vec3::from(at) - Vec3::from(second);
            assert!((axes - Mat3::identity()).norm() < 1e-10, "{at:?} {second:?} {axes}");
            assert!((place - expected).norm() < 1e-10, "{at:?} {second:?} {place}");
        }
    }
}

/// A part that was drawn in another plane: its hinge's axis is at a right angle to that of the ground, where the product of both has no gradient.
#[test]
fn axes_a_right_angle_apart_are_closed() {
    for second_axis in [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]] {
        for off in [[0.0; 3], [0.5, 1.5, -0.2], [0.5, 0.0, 0.0]] {
            let keys = AxisJoint {
                second_at: Some([3.0, 1.0, 2.0]),
                second_axis: Some(second_axis),
                ..axis_joint("hinge", "ground", "part", [0.0; 3], Z)
            };
            let at = std::array::from_fn(|i| [3.0, 1.0, 2.0][i] + off[i]);
            let part = body("part", at, 2.0, Some([0.1, 0.2, 0.25]));
            let system = built(&machine(1.0, 0.1, vec![part], vec![Joint::Revolute(keys.into())]));
            let (place, axes) = pose(&system, &State::first(&system), 0);
            assert!(
                (axes * Vec3::from(second_axis) - Vec3::z()).norm() < 1e-10,
                "{second_axis:?} {off:?} {axes}"
            );
            assert!((place - axes * Vec3::from(off)).norm() < 1e-9, "{second_axis:?} {off:?} {place}");
            if off == [0.0; 3] {
                // About the mass centre it turns by no more than the right angle.
                assert!((axes.trace() - 1.0).abs() < 1e-10, "{axes}");
            }
        }
    }
}
