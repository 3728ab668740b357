//! Simply supported cross-ply plates against Navier's series of first-order shear deformation theory.
//!
//! SS1 supports let the sine series satisfy the equations term by term, coupling of stretching and bending
//! included. The series is summed here ([`Navier`]) and compared with the table. The elements with resultants (`ems`,
//! `mitc4`) are of this theory. `cm` and `solid-shell` integrate three-dimensional stresses with a thickness strain
//! that is linear over the whole laminate, where plies that contract differently would each need their own. With the
//! factor 5/6 instead of their own 1 they are comparable, and for these plies no difference is seen.

use std::f64::consts::PI;

use nalgebra::{SMatrix, SVector};
use tegula::analysis::Silent;
use tegula::compile::build;
use tegula::mesh::generators::generate;
use tegula::model::{Analysis, Load, ModalAnalysis, Model, VectorLoad};
use tegula::{Error, Result};

use super::model::{Compiled, read, refine, section, switch};
use super::reference::records;
use super::report::{Report, Table};
use super::statistics::run_modal;
use super::{Case, Cost};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[Case {
    name: "composites",
    about: "simply supported cross-ply plates against Navier's series",
    cost: Cost::Fast,
    run: all,
}];

const MODEL: &str = include_str!("../../models/composite_plate.toml");
const REFERENCE: &str = include_str!("../../reference/composites.csv");
const CASE: &str = "composites";
/// Length of an edge; the thickness is 1.
const A: f64 = 10.0;
const FACTOR: f64 = 5.0 / 6.0;
const QUANTITIES: [&str; 3] = ["sinusoidal", "uniform", "frequency"];

const ELEMENTS: [&str; 4] = ["ems", "mitc4", "cm", "solid-shell"];

/// Deflections and the first frequency of three laminates.
pub fn all(report: &mut Report) -> Result<()> {
    let table = records(REFERENCE);
    let mut shown = Table::new(
        "composites",
        "Cross-ply plates: value over Navier's series",
        &["layup", "element", "mesh", "sinusoidal load", "uniform load", "frequency"],
    );
    for (layup, angles) in [
        ("[0/90]", &[0.0, 90.0][..]),
        ("[0/90/90/0]", &[0.0, 90.0, 90.0, 0.0]),
        ("[0/90]4", &[0.0, 90.0, 0.0, 90.0, 0.0, 90.0, 0.0, 90.0]),
    ] {
        let exact = Navier::new(angles).values()?;
        report.element("series");
        for (quantity, value) in QUANTITIES.into_iter().zip(exact) {
            let row = table.iter().find(|r| r.text("layup") == layup && r.text("quantity") == quantity);
            let printed = row.map_or(f64::NAN, |r| r.number("value"));
            // Half a unit of the last of four decimals.
            report.absolute(CASE, &format!("{layup}: {quantity}"), "", value, printed, 0.51e-4);
        }
        for element in ELEMENTS {
            report.element(element);
            let coarse = values(layup, angles.len(), element, 8)?;
            let fine = values(layup, angles.len(), element, 16)?;
            let limit: [f64; 3] = std::array::from_fn(|i| (4.0 * fine[i] - coarse[i]) / 3.0);
            for (mesh, found) in [("16x16", coarse), ("32x32", fine), ("limit", limit)] {
                let mut row = vec![layup.to_string(), element.to_string(), mesh.to_string()];
                row.extend(found.iter().zip(exact).map(|(f, e)| format!("{:.4}", f / e)));
                shown.cells.push(row);
                let tolerance = match mesh {
                    "16x16" => continue,
                    "32x32" => 0.01,
                    _ => 1e-3,
                };
                for ((quantity, found), exact) in QUANTITIES.into_iter().zip(found).zip(exact) {
                    report.relative(CASE, &format!("{layup}: {quantity}"), mesh, found, exact, tolerance);
                }
            }
        }
    }
    report.table(shown);
    report.element("ems");
    Ok(())
}

/// The three values with n×n elements on a quarter of the plate.
fn values(layup: &str, plies: usize, element: &str, n: u32) -> Result<[f64; 3]> {
    let mut model = read(MODEL)?;
    refine(&mut model, [n, n]);
    switch(&mut model, element);
    let s = section(&mut model)?;
    s.shear_correction = Some([FACTOR; 2]);
    if let Some(l) = &mut s.layup {
        l.stacking = Some(layup.into());
        l.ply_thickness = Some(1.0 / plies as f64);
    }
    let deflection = |compiled: &Compiled, model: &Model| -> Result<f64> {
        let w = compiled.statics(model)?.state.u[compiled.point("u_max_v_max")?][2];
        Ok(100.0 * w / A.powi(4))
    };
    let mut sinusoidal = model.clone();
    let compiled = with_sine(&mut sinusoidal, n)?;
    let first = deflection(&compiled, &sinusoidal)?;
    let mut uniform = model.clone();
    let traction =
        VectorLoad { on: "all".into(), value: [0.0, 0.0, 1.0], amplitude: None, distribution: None };
    uniform.loads = vec![Load::Traction(traction)];
    let second = deflection(&Compiled::new(&uniform)?, &uniform)?;
    model.analysis = Analysis::Modal(ModalAnalysis::new(1));
    let compiled = Compiled::new(&model)?;
    let outcome = run_modal(&compiled.system, 1, &mut Silent)?;
    let mode = outcome.modes.first().ok_or_else(|| Error::Outside("no mode was found".into()))?;
    Ok([first, second, mode.omega * A * A])
}

/// Adds the nodal forces ∫ N sin(πx/a) sin(πy/a) dA, exactly: a product of integrals along x and y.
fn with_sine(model: &mut Model, n: u32) -> Result<Compiled> {
    let mut mesh = generate(&model.mesh)?;
    let k = PI / A;
    let step = 0.5 * A / f64::from(n);
    // The hat of a node takes 2 (1 − cos kΔ)/(k²Δ) sin kx of the sine; on the line of symmetry half of it is here.
    let along = |x: f64| {
        let share = if x > 0.5 * A - 0.5 * step { 0.5 } else { 1.0 };
        share * 2.0 * (1.0 - (k * step).cos()) / (k * k * step) * (k * x).sin()
    };
    for node in 0..mesh.positions.len() as u32 {
        let x = mesh.positions[node as usize];
        let name = format!("node-{node}");
        mesh.node_sets.insert(name.clone(), vec![node]);
        let value = [0.0, 0.0, along(x.x) * along(x.y)];
        model.loads.push(Load::Force(VectorLoad { on: name, value, amplitude: None, distribution: None }));
    }
    let system = build(model, &mesh)?;
    Ok(Compiled { mesh, system })
}

/// Navier's solution: u, φx ∝ cos αx sin βy; v, φy ∝ sin αx cos βy; w ∝ sin αx sin βy with α = mπ/a, β = nπ/a.
struct Navier {
    /// Resultants of (ε, κ, γ): A, B, D and the corrected transverse shear stiffness.
    stiffness: SMatrix<f64, 8, 8>,
}

impl Navier {
    fn new(angles: &[f64]) -> Self {
        let (e1, e2, g12, g13, g23, nu12) = (25.0, 1.0, 0.5, 0.5, 0.2, 0.25);
        let reduced = 1.0 - nu12 * nu12 * e2 / e1;
        let mut stiffness = SMatrix::zeros();
        let h = 1.0 / angles.len() as f64;
        for (i, angle) in angles.iter().enumerate() {
            let [bottom, top] = [i, i + 1].map(|i| -0.5 + i as f64 * h);
            // Along x and y: for 90° the axes of the ply change places.
            let turned = *angle == 90.0;
            let (qx, qy) = if turned { (e2, e1) } else { (e1, e2) };
            let (gx, gy) = if turned { (g23, g13) } else { (g13, g23) };
            let entries = [
                (0, 0, qx / reduced),
                (1, 1, qy / reduced),
                (0, 1, nu12 * e2 / reduced),
                (1, 0, nu12 * e2 / reduced),
                (2, 2, g12),
            ];
            let moments = [1, 2, 3].map(|p| (top.powi(p) - bottom.powi(p)) / f64::from(p));
            for (r, c, q) in entries {
                for (row, column, moment) in [(0, 0, 0), (0, 3, 1), (3, 0, 1), (3, 3, 2)] {
                    stiffness[(r + row, c + column)] += q * moments[moment];
                }
            }
            stiffness[(6, 6)] += FACTOR * gx * h;
            stiffness[(7, 7)] += FACTOR * gy * h;
        }
        Self { stiffness }
    }

    /// Stiffness of the amplitudes (u, v, w, φx, φy) of a term; its strains are all proportional to products of sines
    /// and cosines with the same mean square.
    fn term(&self, m: u32, n: u32) -> SMatrix<f64, 5, 5> {
        let [a, b] = [m, n].map(|m| f64::from(m) * PI / A);
        let strains = SMatrix::<f64, 8, 5>::from_row_slice(&[
            -a, 0.0, 0.0, 0.0, 0.0, // ε_x
            0.0, -b, 0.0, 0.0, 0.0, // ε_y
            b, a, 0.0, 0.0, 0.0, // γ_xy
            0.0, 0.0, 0.0, -a, 0.0, // κ_x
            0.0, 0.0, 0.0, 0.0, -b, // κ_y
            0.0, 0.0, 0.0, b, a, // κ_xy
            0.0, 0.0, a, 1.0, 0.0, // γ_xz
            0.0, 0.0, b, 0.0, 1.0, // γ_yz
        ]);
        strains.transpose() * self.stiffness * strains
    }

    /// Amplitude of w under a pressure of amplitude 1.
    fn compliance(&self, m: u32, n: u32) -> Result<f64> {
        let load = SVector::<f64, 5>::new(0.0, 0.0, 1.0, 0.0, 0.0);
        let solution = self.term(m, n).cholesky().map(|c| c.solve(&load));
        solution.map(|s| s[2]).ok_or_else(|| Error::Outside("a term of Navier's series is singular".into()))
    }

    /// Centre under the sinusoidal and the uniform load, and the first frequency, without dimension.
    fn values(&self) -> Result<[f64; 3]> {
        let scale = 100.0 / A.powi(4);
        let mut uniform = 0.0;
        for m in (1..200).step_by(2) {
            for n in (1..200).step_by(2) {
                let sign = if (m + n) % 4 == 2 { 1.0 } else { -1.0 };
                let q = 16.0 / (PI * PI * f64::from(m * n));
                uniform += sign * q * self.compliance(m, n)?;
            }
        }
        // Mass per area 1, rotary inertia 1/12.
        let roots = [1.0, 1.0, 1.0, 12.0_f64.sqrt(), 12.0_f64.sqrt()];
        let mass = SMatrix::<f64, 5, 5>::from_diagonal(&SVector::from(roots));
        let first = (mass * self.term(1, 1) * mass).symmetric_eigenvalues().min().sqrt();
        Ok([scale * self.compliance(1, 1)?, scale * uniform, first * A * A])
    }
}
