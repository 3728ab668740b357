//! Assembly where there are several closed positions: the nearest one, also from parts in one line and from opposite axes.

use crate::assembly::{CRANK, INERTIA, LINKS, Z, ball, built, four_bar, freudenstein, gaps, hinge, moved};
use crate::multibody::{axis_joint, body, machine, pose, revolute, spring};
use tegula::System;
use tegula::analysis::State;
use tegula::model::*;
use tegula::norm::max_norm;

/// A bar drawn in line with its pin can slide to it by 2 or turn half round: the mean square displacement is 2 m or 2 J there, and increments
/// from the line do not leave it.
#[test]
fn parts_in_one_line_come_to_the_nearest_position() {
    let joint = hinge("pin", "ground", "bar", [[0.0; 3], [2.0, 0.0, 0.0]]);
    let bar = body("bar", [1.0, 0.0, 0.0], 1.0, Some([0.1; 3]));
    let system = built(&machine(1.0, 0.1, vec![bar], vec![joint]));
    let (displacement, angle) = moved(&system, 0);
    assert!(
        displacement.norm() < 1e-9 && (angle.abs() - std::f64::consts::PI).abs() < 1e-9,
        "{displacement} {angle}"
    );
    // A crank of length 1 and a rod of length 2 along x, whose end is to lie at 2.5: a triangle, on either side of the line.
    let crank = body("crank", [0.5, 0.0, 0.0], 1.0, Some([0.1; 3]));
    let rod = body("rod", [2.0, 0.0, 0.0], 1.0, Some([0.1; 3]));
    let joints = vec![
        revolute("O", "ground", "crank", [0.0; 3], Z),
        revolute("A", "crank", "rod", [1.0, 0.0, 0.0], Z),
        ball("S", "ground", "rod", [2.5, 0.0, 0.0], [3.0, 0.0, 0.0]),
    ];
    let system = built(&machine(1.0, 0.1, vec![crank, rod], joints));
    let (_, angle) = moved(&system, 0);
    // Law of cosines.
    let expected = ((1.0 + 2.5 * 2.5 - 4.0) / (2.0 * 2.5_f64)).acos();
    assert!((angle.abs() - expected).abs() < 1e-9, "{angle} {expected}");
    assert!(max_norm(gaps(&system, &State::first(&system))) < 1e-10);
}

/// Exactly opposite axes close by half a turn of a free body.
#[test]
fn opposite_axes_close_by_half_a_turn() {
    let keys =
        AxisJoint { second_axis: Some([0.0, 0.0, -1.0]), ..axis_joint("r", "ground", "p", [0.0; 3], Z) };
    let plate = body("p", [0.2, 0.1, 0.0], 1.0, Some([0.3, 0.1, 0.35]));
    let joint = Joint::Revolute(AxisJoint { second_at: Some([0.3, 0.0, 0.0]), ..keys }.into());
    let system = built(&machine(1.0, 0.1, vec![plate], vec![joint]));
    let state = State::first(&system);
    let (_, axes) = pose(&system, &state, 0);
    assert!((axes[(2, 2)] + 1.0).abs() < 1e-9, "{axes}");
    assert!(max_norm(gaps(&system, &state)) < 1e-10);
}

/// A four-bar linkage whose crank is held has two positions, with the angles of the rocker by Freudenstein: that is taken in which coupler and
/// rocker move less, though increments from where they are drawn may lead to the other one.
#[test]
fn the_nearer_of_two_positions_of_a_linkage_is_taken() {
    let [d, a, b, c] = LINKS;
    let pin = [a * CRANK.cos(), a * CRANK.sin()];
    let mut farther = 0;
    for number in 0..24 {
        let turned = -3.0 + 0.25 * f64::from(number);
        let place = [3.0 + 2.0 * (1.7 * turned).sin(), 2.0 * (2.3 * turned).cos()];
        let system = built(&four_bar(1.0, (place, turned), LINKS, true));
        assert!(max_norm(gaps(&system, &State::first(&system))) < 1e-10);
        let cost = |mass: f64, from: [f64; 2], to: [f64; 2], angle: f64| {
            let square = (to[0] - from[0]).powi(2) + (to[1] - from[1]).powi(2);
            0.5 * mass * square + INERTIA[2] * (1.0 - angle.cos())
        };
        let costs = freudenstein(CRANK, LINKS).map(|psi| {
            let top = [d + c * psi.cos(), c * psi.sin()];
            let centre = [0, 1].map(|i| 0.5 * (pin[i] + top[i]));
            let angle = (top[1] - pin[1]).atan2(top[0] - pin[0]);
            assert!(((top[0] - pin[0]).hypot(top[1] - pin[1]) - b).abs() < 1e-12);
            let middle = [d + 0.5 * c * psi.cos(), 0.5 * c * psi.sin()];
            cost(2.0, place, centre, angle - turned)
                + cost(1.5, [d, 0.5 * c], middle, psi - std::f64::consts::FRAC_PI_2)
        });
        let [coupler, rocker] = [1, 2].map(|body| moved(&system, body));
        let found = 0.5 * 2.0 * coupler.0.norm_squared()
            + INERTIA[2] * (1.0 - turn_of(&system, 1, turned).cos())
            + 0.5 * 1.5 * rocker.0.norm_squared()
            + INERTIA[2] * (1.0 - turn_of(&system, 2, std::f64::consts::FRAC_PI_2).cos());
        let least = costs[0].min(costs[1]);
        assert!((found - least).abs() < 1e-9 * (1.0 + least), "{number}: {found} {costs:?}");
        farther += usize::from((costs[0] - costs[1]).abs() > 1e-3);
    }
    assert!(farther > 20);
}

/// A spring that the assembly stretches acts in a static analysis without loads.
#[test]
fn springs_that_the_assembly_stretches_act() {
    let slide =
        AxisJoint { second_at: Some([0.4, 0.0, 0.0]), ..axis_joint("slide", "ground", "bar", [0.0; 3], Z) };
    let bar = body("bar", [0.9, 0.0, 0.0], 1.0, Some([0.1; 3]));
    let mut model = machine(1.0, 0.1, vec![bar], vec![Joint::Revolute(slide.into())]);
    let ends = [[0.0, 1.0, 0.0], [0.9, 0.0, 0.0]];
    model.springs = vec![spring("spring", ["ground", "bar"], ends, 10.0)];
    model.analysis = Analysis::Static(StaticAnalysis::default());
    assert!(built(&model).closed_gaps.is_some());
}

/// Angle about z by which a body has turned that is drawn at an angle.
fn turn_of(system: &System, body: usize, drawn: f64) -> f64 {
    moved(system, body).1 - drawn
}
