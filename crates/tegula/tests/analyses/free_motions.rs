//! Free motions beside slow ones: what springs, bushings and foundations do not resist is rigid, and nothing else is.

use crate::bushings::bushing;
use crate::common::Random;
use crate::modes_with_joints::{modal, modes, omegas, to_ground};
use crate::multibody::{between, body, revolute, spring};
use nalgebra::{DMatrix, DVector};
use tegula::model::*;

/// A bushing that is stiff but against one rotation is a hinge with a soft spring: its body has a slow mode and no rigid one.
#[test]
fn stiff_bushings_that_are_soft_in_one_rotation_have_a_slow_mode() {
    let (mass, inertia) = (785.0, [65.0, 66.0, 130.0]);
    let turning = inertia[1] + mass * 0.25;
    for (stiff, soft) in [(1e9, 1e-4), (1e12, 1.0), (1e13, 10.0)] {
        let mount = Bushing {
            axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            stiffness: Some([stiff, stiff, stiff, stiff, soft, stiff]),
            ..bushing(["ground", "box"], [0.0; 3])
        };
        let bodies = vec![body("box", [0.5, 0.0, 0.0], mass, Some(inertia))];
        let mut model = Model::of_bodies(modal(2, false), bodies, Vec::new());
        model.bushings = vec![mount];
        let exact = (soft / turning).sqrt();
        let mode = &modes(&model).1.modes[0];
        assert!(
            !mode.rigid && (mode.omega / exact - 1.0).abs() < 1e-6,
            "{stiff:e} {soft:e}: {} {exact}",
            mode.omega
        );
    }
}

/// A point mass on a bushing askew to the axes of space, which is stiff along one of its axes, soft along another one, and leaves the third one free.
#[test]
fn bushings_askew_leave_one_direction_free_and_another_one_soft() {
    for (stiff, soft) in [(1e9, 1e-4), (1e12, 1.0), (1e13, 1.0)] {
        let mount = Bushing {
            stiffness: Some([stiff, soft, 0.0, 0.0, 0.0, 0.0]),
            ..bushing(["ground", "mass"], [0.0; 3])
        };
        let mut model =
            Model::of_bodies(modal(3, false), vec![body("mass", [0.0; 3], 2.0, None)], Vec::new());
        model.bushings = vec![mount];
        let found = modes(&model).1;
        let omegas: Vec<f64> = found.modes.iter().map(|mode| mode.omega).collect();
        assert!(omegas[0] == 0.0 && found.modes[0].rigid, "{omegas:?}");
        assert!((omegas[1] / f64::sqrt(0.5 * soft) - 1.0).abs() < 1e-6, "{omegas:?}");
        assert!((omegas[2] / f64::sqrt(0.5 * stiff) - 1.0).abs() < 1e-9, "{omegas:?}");
    }
}

/// Point masses on bushings that are linked by springs along one axis: each axis vibrates by itself, that of the springs as a chain. A rotation about the
/// line of the masses moves none of them, and is no rigid mode.
#[test]
fn point_masses_on_a_line_of_springs_have_the_modes_of_a_chain() {
    let masses = [2.0, 1.0, 1.7];
    let held = [[800.0, 900.0, 1000.0], [10.0, 400.0, 500.0], [310.0, 120.0, 77.0]];
    for count in [2, 3] {
        for axis in 0..3 {
            let at = |i: usize| std::array::from_fn(|j| if j == axis { i as f64 } else { 0.0 });
            let name = |i: usize| format!("mass {i}");
            let bodies = (0..count).map(|i| body(&name(i), at(i), masses[i], None)).collect();
            let mut model = Model::of_bodies(modal(3 * count as u32, false), bodies, Vec::new());
            let mount = |i: usize| Bushing {
                name: format!("mount {i}"),
                between: between("ground", &name(i)),
                at: at(i),
                axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
                stiffness: Some(std::array::from_fn(|j| if j < 3 { held[i][j] } else { 0.0 })),
                stiffness_matrix: None,
                damping: None,
                damping_matrix: None,
                free: [0.0; 6],
            };
            model.bushings = (0..count).map(mount).collect();
            let link =
                |i: usize| spring(&format!("link {i}"), [&name(i), &name(i + 1)], [at(i), at(i + 1)], 300.0);
            model.springs = (0..count - 1).map(link).collect();
            let mut exact = Vec::new();
            for direction in 0..3 {
                let chain = nalgebra::DMatrix::from_fn(count, count, |i, j| {
                    let links = usize::from(i > 0) + usize::from(i + 1 < count);
                    let k = match (i.abs_diff(j), direction == axis) {
                        (0, true) => held[i][direction] + 300.0 * links as f64,
                        (0, false) => held[i][direction],
                        (1, true) => -300.0,
                        _ => 0.0,
                    };
                    k / (masses[i] * masses[j]).sqrt()
                });
                exact.extend(chain.symmetric_eigenvalues().iter().map(|x| x.sqrt()));
            }
            exact.sort_by(f64::total_cmp);
            let (_, found) = modes(&model);
            assert_eq!(found.modes.len(), exact.len());
            for (mode, exact) in found.modes.iter().zip(&exact) {
                assert!((mode.omega / exact - 1.0).abs() < 1e-9, "{count} {axis}: {} {exact}", mode.omega);
                assert!(!mode.rigid && mode.residual < 1e-12);
            }
        }
    }
}

/// Three point masses with springs along an axis and nothing across it, free or held at one end: all motions across are free.
#[test]
fn chains_of_springs_alone_are_free_across_their_axis() {
    for held in [false, true] {
        let at = |i: usize| [i as f64, 0.0, 0.0];
        let name = |i: usize| format!("mass {i}");
        let bodies = (1..4).map(|i| body(&name(i), at(i), 1.0, None)).collect();
        let mut model = Model::of_bodies(modal(9, false), bodies, Vec::new());
        let link = |i: usize| spring(&format!("link {i}"), [&name(i), &name(i + 1)], [at(i), at(i + 1)], 1e3);
        model.springs = (1..3).map(link).collect();
        if held {
            model.springs.push(spring("wall", ["ground", "mass 1"], [at(0), at(1)], 1e3));
        }
        let stretched: Vec<f64> = if held {
            (1..4).map(|i| 4e3 * (std::f64::consts::PI * (f64::from(i) - 0.5) / 7.0).sin().powi(2)).collect()
        } else {
            vec![1e3, 3e3]
        };
        let (_, found) = modes(&model);
        let free = 9 - stretched.len();
        for (i, mode) in found.modes.iter().enumerate() {
            let exact = if i < free { 0.0 } else { stretched[i - free].sqrt() };
            assert!(
                (mode.omega - exact).abs() <= 1e-9 * exact && mode.rigid == (i < free),
                "{held} {i}: {mode:?}"
            );
        }
    }
}

/// A plate oblique to the axes of space on a foundation normal to it alone: three motions in its plane are free, and no other ones.
#[test]
fn oblique_plates_on_normal_foundations_move_freely_in_their_planes() {
    for angle in [0.0_f64, 0.3, 0.9] {
        let mut model = crate::common::model(crate::common::plate([1.0, 0.4], [6, 3], 0.0), 2.1e11, 0.01);
        model.conditions.clear();
        if let MeshSource::Plate(plate) = &mut model.mesh {
            plate.v_axis = [0.0, angle.cos(), angle.sin()];
        }
        model.foundations = vec![Foundation::Area(AreaFoundation {
            on: "all".into(),
            stiffness: [0.0; 3],
            normal: 1e6,
            retardation_time: 0.0,
        })];
        model.analysis = modal(4, false);
        let (_, found) = modes(&model);
        let rigid: Vec<bool> = found.modes.iter().map(|mode| mode.rigid).collect();
        assert_eq!(rigid, [true, true, true, false], "{angle}");
    }
}

/// Two bodies on springs that are too few to hold them, at random places: frequencies against `Σ k b bᵀ φ = ω² M φ` with the change b of each
/// spring's length. Springs without stress in the reference configuration have no geometric stiffness, not even by round-off.
#[test]
fn bodies_on_few_springs_have_the_frequencies_of_their_elongations() {
    let mut random = Random::new(11);
    let mut free = 0;
    for _ in 0..40 {
        let at = [0, 1].map(|_| random.vector() * 3.0);
        let masses = [0, 1].map(|_| 1.0 + 4.0 * random.next().abs());
        let inertias = masses.map(|m| [0.1 * m, 0.11 * m, 0.12 * m]);
        let bodies = vec![
            body("b0", at[0].into(), masses[0], Some(inertias[0])),
            body("b1", at[1].into(), masses[1], Some(inertias[1])),
        ];
        let mut model = Model::of_bodies(modal(12, false), bodies, Vec::new());
        let mut stiffness = DMatrix::<f64>::zeros(12, 12);
        for number in 0..8 {
            let sides = [[0, 1], [0, 2], [1, 2]][number % 3];
            let places = sides.map(|side| match side {
                2 => random.vector() * 4.0,
                body => at[body] + random.vector(),
            });
            let k = 100.0 * (1.0 + random.next().abs());
            let names = sides.map(|side| ["b0", "b1", "ground"][side]);
            model.springs.push(spring(&format!("s{number}"), names, places.map(Into::into), k));
            let along = (places[1] - places[0]).normalize();
            let mut change = DVector::<f64>::zeros(12);
            for (i, sign) in [(0, -1.0), (1, 1.0)] {
                if sides[i] == 2 {
                    continue;
                }
                let arm = (places[i] - at[sides[i]]).cross(&along);
                for j in 0..3 {
                    change[6 * sides[i] + j] += sign * along[j];
                    change[6 * sides[i] + 3 + j] += sign * arm[j];
                }
            }
            stiffness += k * &change * change.transpose();
        }
        let root = |i: usize| match (i / 6, i % 6) {
            (body, 0..3) => masses[body].sqrt(),
            (body, j) => inertias[body][j - 3].sqrt(),
        };
        let scaled = DMatrix::from_fn(12, 12, |i, j| stiffness[(i, j)] / (root(i) * root(j)));
        let mut exact: Vec<f64> = scaled.symmetric_eigenvalues().iter().copied().collect();
        exact.sort_by(f64::total_cmp);
        let largest = exact[11];
        let found = modes(&model).1;
        assert_eq!(found.modes.len(), 12);
        for (mode, exact) in found.modes.iter().zip(exact) {
            let square = mode.omega * mode.omega;
            assert!((square - exact).abs() < 1e-9 * largest, "{square} {exact}");
            assert_eq!(mode.rigid, exact < 1e-9 * largest, "{square} {exact}");
            free += usize::from(mode.rigid);
        }
    }
    // Eight springs leave four motions of twelve.
    assert_eq!(free, 160);
}

/// Two arms on hinges with springs to the ground have the frequencies of `|K − ω² M| = 0` in the angles of the arms, whatever the units of length,
/// mass and time: modes of modal mass 1 are minute where the numbers of lengths and masses are large.
#[test]
fn frequencies_of_arms_on_springs_do_not_depend_on_units() {
    // M = [1.7, 0.4; 0.4, 0.26] and K = [69, 10; 10, 5] in kg m² and N m.
    let (a, b, c) = (1.7 * 0.26 - 0.4 * 0.4, 69.0 * 0.26 + 1.7 * 5.0 - 2.0 * 10.0 * 0.4, 69.0 * 5.0 - 100.0);
    let root = f64::sqrt(b * b - 4.0 * a * c);
    let exact = [b - root, b + root].map(|x| (x / (2.0 * a)).sqrt());
    let units = [
        [1.0; 3],
        [1e3, 1e-3, 1.0],
        [1e6, 1e12, 1e6],
        [1e6, 1e15, 1e6],
        [1e9, 1e18, 1.0],
        [1e6, 1e18, 1e6],
        [1e-6, 1e-3, 1e3],
    ];
    for [length, mass, time] in units {
        let inertia = |of: [f64; 3]| Some(of.map(|x| x * mass * length * length));
        let place = |x: f64, y: f64| [x * length, y * length, 0.0];
        let bodies = vec![
            body("a", place(0.5, 0.0), 2.0 * mass, inertia([0.1, 0.3, 0.2])),
            body("b", place(1.4, 0.0), mass, inertia([0.05, 0.1, 0.1])),
        ];
        let hinges = vec![
            revolute("A", "ground", "a", place(0.0, 0.0), [0.0, 0.0, 1.0]),
            revolute("B", "a", "b", place(1.0, 0.0), [0.0, 0.0, 1.0]),
        ];
        let mut model = Model::of_bodies(modal(2, false), bodies, hinges);
        let stiffness = mass / (time * time);
        model.springs = vec![
            to_ground("s", "a", [place(0.7, 1.0), place(0.7, 0.0)], 100.0 * stiffness),
            to_ground("t", "b", [place(1.5, 2.0), place(1.5, 0.0)], 20.0 * stiffness),
        ];
        let found = omegas(&model);
        for (found, exact) in found.iter().zip(exact) {
            let error = (found * time / exact - 1.0).abs();
            assert!(error < 1e-12, "units {length} {mass} {time}: {found} for {exact}");
        }
    }
}
