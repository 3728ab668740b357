//! Layers at free edges, as wide as the sheet is thick, and stabilised transverse shear on meshes that are too coarse
//! for them.

use crate::common::{displacement, model, plate, solve, vector_load};
use tegula::model::*;
use tegula::result::plies::recover_plies;
use tegula::result::recovery::recover;

const YOUNG: f64 = 2.1e11;
const LENGTH: f64 = 1.0;
const WIDTH: f64 = 0.2;
const THICKNESS: f64 = 0.01;
const TORQUE: f64 = 1.0;

/// A strip that is clamped at one end and twisted at the other, `n` elements over its width.
fn strip(element: ElementKind, n: u32, shear_stabilization: f64) -> Model {
    let mut m = model(plate([LENGTH, WIDTH], [5 * n, n], 0.0), YOUNG, THICKNESS);
    if let MeshSource::Plate(p) = &mut m.mesh {
        for (name, x) in [("near", 0.4), ("far", 0.6)] {
            for (side, y) in [("left", 0.0), ("right", WIDTH)] {
                p.grid.points.insert(format!("{name}_{side}"), [x, y, 0.0]);
            }
        }
    }
    (m.sections[0].element, m.sections[0].shear_stabilization) = (element, shear_stabilization);
    let force = |on, z| Load::Force(vector_load(on, [0.0, 0.0, z]));
    m.loads = vec![force("u_max_v_max", TORQUE / WIDTH), force("u_max_v_min", -TORQUE / WIDTH)];
    m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
    m
}

/// Twist per length in the middle of the strip, relative to the exact one: J = b h³ / 3 · (1 − 0.630 h / b), S. Timoshenko,
/// J. N. Goodier, *Theory of Elasticity*, 2nd ed. (1951), Art. 94.
fn twist(m: &Model) -> f64 {
    let (mesh, system, outcome) = solve(m);
    let w = |set: &str| displacement(&mesh, &system, &outcome.state.u, set).z;
    let angle = |section| (w(&format!("{section}_right")) - w(&format!("{section}_left"))) / WIDTH;
    let constant = WIDTH * THICKNESS.powi(3) / 3.0 * (1.0 - 0.63 * THICKNESS / WIDTH);
    (angle("far") - angle("near")) / 0.2 * constant * YOUNG / 2.6 / TORQUE
}

#[test]
#[ignore = "long"]
fn stabilised_shear_twists_strips_right_on_coarse_meshes() {
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        for (n, plain, stabilised) in
            [(4, 0.025, 0.01), (8, 0.0195, 0.0125), (16, 0.011, 0.0085), (48, 0.0035, 0.0035)]
        {
            for (alpha, most) in [(0.0, plain), (0.1, stabilised)] {
                let error = twist(&strip(element, n, alpha)) - 1.0;
                assert!(error.abs() < most, "{element:?}, {n} elements, {alpha}: {error:.5}");
            }
        }
    }
    // What the coefficient cures is there.
    assert!(twist(&strip(ElementKind::Ems, 4, 0.0)) < 0.98);
}

/// The tip of a cantilever sinks by F L / (c G A) more, and its shear force remains that of equilibrium.
#[test]
fn only_the_shear_stiffness_is_reduced() {
    let (width, h, force, alpha) = (0.1, 0.02, 3.0, 0.1);
    let factor = h * h / (h * h + alpha * width * width);
    let sheet = Layup { stacking: Some("[0]".into()), material: Some("m".into()), ..Layup::default() };
    let laminate = Layup { ply_thickness: Some(h), ..sheet };
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        for layup in [None, Some(laminate.clone())] {
            let run = |shear_stabilization: f64| {
                let mut m = model(plate([LENGTH, width], [10, 1], 0.0), YOUNG, h);
                m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(YOUNG, 0.0, 1.0)));
                let s = &mut m.sections[0];
                (s.element, s.shear_stabilization, s.layup) = (element, shear_stabilization, layup.clone());
                if layup.is_some() {
                    (s.material, s.thickness) = (String::new(), 0.0);
                }
                m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 0.0, force / width]))];
                m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
                let (mesh, system, outcome) = solve(&m);
                for shell in recover(&system, &outcome.state) {
                    assert!((shell.shear[0].abs() / (force / width) - 1.0).abs() < 1e-8, "{:?}", shell.shear);
                }
                for plies in recover_plies(&system, &outcome.state) {
                    let middle = plies[0].stress[1].shear[0].abs();
                    assert!((middle / (1.5 * force / width / h) - 1.0).abs() < 1e-8, "{middle}");
                }
                displacement(&mesh, &system, &outcome.state.u, "u_max_v_max").z
            };
            let compliance = LENGTH / (5.0 / 6.0 * YOUNG / 2.0 * width * h);
            let more = (run(alpha) - run(0.0)) / (force * compliance * (1.0 / factor - 1.0));
            assert!((more - 1.0).abs() < 1e-6, "{element:?}: {more}");
        }
    }
}
