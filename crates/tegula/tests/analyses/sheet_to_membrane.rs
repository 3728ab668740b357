//! Flat sheets between clamped edges whose deflection is many times their thickness: from plates they become membranes.
//!
//! Strip between two clamped edges under a uniform load q, in cylindrical bending (S. Timoshenko, S. Woinowsky-Krieger,
//! *Theory of Plates and Shells*, 2nd ed., McGraw-Hill 1959, Art. 3: built-in edges). With the axial force S per width,
//! `u² = S L²/(4 D)`, `D = E h³/(12 (1 − ν²))` and `t = 1 − 2x/L`
//!
//! ```text
//! w' = C (t − sinh(ut)/sinh u),  C = q L³/(8 u² D)
//! w_max = q L⁴/(16 u⁴ D) (u²/2 + u/sinh u − u/tanh u)
//! S (1 − ν²)/(E h) = ½ ∫ w'² dx / L = ¼ C² (2/3 − 3/(u tanh u) + 4/u² − 1/sinh² u)
//! ```

use crate::common::{Notes, compile, displacement, model, on, plate, static_options, vector_load};
use tegula::analysis::statics;
use tegula::model::*;

const KINDS: [ElementKind; 5] =
    [ElementKind::Ems, ElementKind::Cm, ElementKind::Mitc4, ElementKind::SolidShell, ElementKind::AncfFull];
const YOUNG: f64 = 1e9;
const POISSON: f64 = 0.3;

/// Elements for a slenderness and a kind of load. A pressure on very thin sheets needs hundreds of iterations, for which `ancf-full` with its fifty
/// points of integration takes most of the time of all tests.
fn kinds(slenderness: f64, follower: bool) -> Vec<ElementKind> {
    let quick = slenderness == 1e3 || (slenderness == 1e5 && !follower);
    KINDS.into_iter().filter(|&kind| quick || kind != ElementKind::AncfFull).collect()
}

/// Deflection in the middle of the strip of length 1.
fn deflection(h: f64, q: f64) -> f64 {
    let d = YOUNG * h.powi(3) / (12.0 * (1.0 - POISSON * POISSON));
    let stretch = |u: f64| {
        let c = q / (8.0 * u * u * d);
        let shape = 2.0 / 3.0 - 3.0 / (u * u.tanh()) + 4.0 / (u * u) - 1.0 / u.sinh().powi(2);
        0.25 * c * c * shape - 4.0 * u * u * d * (1.0 - POISSON * POISSON) / (YOUNG * h)
    };
    let (mut low, mut high) = (0.1_f64, 1e6_f64);
    for _ in 0..200 {
        let u = (low * high).sqrt();
        if stretch(u) > 0.0 { low = u } else { high = u }
    }
    let u = low;
    q / (16.0 * u.powi(4) * d) * (0.5 * u * u + u / u.sinh() - u / u.tanh())
}

/// A quarter of a sheet with symmetry at `u_min` and `v_min`, clamped at `u_max`.
fn quarter(size: [f64; 2], elements: [u32; 2], h: f64, element: ElementKind, load: Load) -> Model {
    let mut m = model(plate(size, elements, 0.0), YOUNG, h);
    m.sections[0].element = element;
    let plane = |on: &str, normal| Condition::Symmetry(SymmetryPlane { on: on.into(), normal });
    m.conditions =
        vec![plane("u_min", [1.0, 0.0, 0.0]), plane("v_min", [0.0, 1.0, 0.0]), Condition::Clamp(on("u_max"))];
    m.loads = vec![load];
    m
}

/// A load across the sheet: constant in direction, or a pressure that follows it.
fn across(q: f64, follower: bool) -> Load {
    if follower {
        Load::Pressure(PressureLoad { on: "all".into(), value: -q, amplitude: None, distribution: None })
    } else {
        Load::Traction(vector_load("all", [0.0, 0.0, q]))
    }
}

/// Deflection of the middle with default settings, and what was noted.
fn middle(m: &Model) -> (f64, Notes) {
    let (mesh, system) = compile(m);
    let mut notes = Notes::default();
    let outcome = statics::run(&system, &static_options(m), None, &mut notes).unwrap();
    assert_eq!(outcome.state.time, 1.0);
    (displacement(&mesh, &system, &outcome.state.u, "u_min_v_min").z, notes)
}

#[test]
#[ignore = "long"]
fn strips_between_clamped_edges_deflect_as_in_closed_form() {
    for slenderness in [1e3, 1e4, 1e5] {
        for follower in [false, true] {
            for element in kinds(slenderness, follower) {
                let h = 1.0 / slenderness;
                // Deflections of 1 % of the length: slopes squared, which the closed form neglects, are below 0.2 %.
                let q = 3e-5 * YOUNG * h;
                let mut m = quarter([0.5, 0.02], [32, 1], h, element, across(q, follower));
                let far = SymmetryPlane { on: "v_max".into(), normal: [0.0, 1.0, 0.0] };
                m.conditions.push(Condition::Symmetry(far));
                let (w, _) = middle(&m);
                // `ancf-full` has no remedies against locking.
                let tolerance = if element == ElementKind::AncfFull { 1.2e-2 } else { 1e-3 };
                let error = w / deflection(h, q) - 1.0;
                assert!(error.abs() < tolerance, "L/h {slenderness} {element:?} {follower}: {error:e}");
            }
        }
    }
}

#[test]
#[ignore = "long"]
fn square_sheets_become_membranes_with_every_element() {
    for slenderness in [1e3, 1e4, 1e5] {
        for follower in [false, true] {
            let kinds = kinds(slenderness, follower);
            let deflections: Vec<f64> = kinds
                .iter()
                .map(|&element| {
                    let load = across(1000.0, follower);
                    let mut m = quarter([0.5, 0.5], [8, 8], 1.0 / slenderness, element, load);
                    m.conditions.push(Condition::Clamp(on("v_max")));
                    middle(&m).0
                })
                .collect();
            for (w, element) in deflections.iter().zip(kinds) {
                let tolerance = if element == ElementKind::AncfFull { 0.06 } else { 4e-3 };
                let off = w / deflections[0] - 1.0;
                assert!(off.abs() < tolerance, "{slenderness} {follower} {element:?}: {deflections:?}");
            }
            // A membrane deflects with the cube root of load over thickness.
            let scale = (1000.0 * slenderness / YOUNG).cbrt();
            assert!((0.25..0.35).contains(&(deflections[0] / scale)), "{slenderness}: {deflections:?}");
        }
    }
}
