//! Result files against closed forms: each kind of analysis and field, read from the folder that a run leaves.
//!
//! The other cases take numbers from the library. Here a model file is run as `tegula run` does, and the numbers are
//! read from `summary.json`, `history.csv`, `modes.csv` and the VTU files (`Results`), at named places. Constant
//! states of stress are exact on any mesh; the tolerances elsewhere are the discretisation error of their mesh.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};
use tegula::Result;
use tegula::norm::larger;

use super::files::{Frame, Results};
use super::report::Report;
use super::{Case, Cost};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[Case {
    name: "results",
    about: "files of a run against closed forms: stresses, plies, frequencies, histories",
    cost: Cost::Fast,
    run: all,
}];

const CASE: &str = "results";
/// Equal up to the rounding of a linear solution.
const ROUNDING: f64 = 1e-7;
/// A coordinate of a place that does not count: flat models are drawn where they have bent to.
const ANY: f64 = f64::NAN;
/// Young's modulus, Poisson's ratio and thickness of the strips and the sheet.
const SHEET: (f64, f64, f64) = (2e6, 0.3, 0.02);

/// All of them.
pub fn all(report: &mut Report) -> Result<()> {
    for element in ["ems", "mitc4", "cm"] {
        report.element(element);
        bent_strip(report, element)?;
        stretched_sheet(report, element)?;
        guided_strip(report, element)?;
        pressurised_cylinder(report, element)?;
        yielding_sheet(report, element)?;
    }
    for element in ["ems", "mitc4"] {
        report.element(element);
        laminate(report, element)?;
    }
    report.element("ems");
    supported_strip(report)?;
    thrown_plate(report)?;
    pulled_bar(report)
}

macro_rules! model {
    ($name:literal) => {
        include_str!(concat!("../../models/results/", $name, ".toml"))
    };
}

/// Runs a model with another element.
fn run(text: &str, element: &str) -> Result<Results> {
    Results::of(&text.replace("element = \"ems\"", &format!("element = \"{element}\"")))
}

/// Compares several components with a closed form, relative to a scale.
fn compare<const N: usize>(
    report: &mut Report,
    quantity: &str,
    (found, exact): ([f64; N], [f64; N]),
    (scale, tolerance): (f64, f64),
) {
    for (i, (found, exact)) in found.into_iter().zip(exact).enumerate() {
        report.absolute(
            CASE,
            &format!("{quantity}, component {}", i + 1),
            "",
            found,
            exact,
            tolerance * scale,
        );
    }
}

/// Cylindrical bending: m_yy = ν m_xx, σ = ∓6 m/h², w = M L²/(2 D) at the tip.
///
/// S. P. Timoshenko, S. Woinowsky-Krieger, *Theory of Plates and Shells*, 2nd ed., McGraw-Hill 1959, Sect. 1 and 2.
fn bent_strip(report: &mut Report, element: &str) -> Result<()> {
    let results = run(model!("bent_strip"), element)?;
    let frame = results.last_frame("fields.pvd")?;
    let ((young, nu, h), moment, place) = (SHEET, 3.0, [1.125, 0.375, ANY]);
    let rigidity = young * h.powi(3) / 12.0 / (1.0 - nu * nu);
    let stress = 6.0 * moment / (h * h);
    // The moment turns the director (0, 0, 1) towards +x: the top is pulled.
    let exact = [-moment, -nu * moment, 0.0];
    compare(report, "bent strip: moments", (frame.in_cell("bending", place), exact), (moment, ROUNDING));
    let top = [stress, nu * stress, 0.0];
    compare(
        report,
        "bent strip: stress at the top",
        (frame.in_cell("stress_top", place), top),
        (stress, ROUNDING),
    );
    let bottom = top.map(|s| -s);
    let found = frame.in_cell("stress_bottom", place);
    compare(report, "bent strip: stress at the bottom", (found, bottom), (stress, ROUNDING));
    let equivalent = stress * (1.0 - nu + nu * nu).sqrt();
    scalar(report, "bent strip: von Mises stress", frame.in_cell("von_mises", place), equivalent);
    let energy = 0.5 * moment * moment / rigidity;
    scalar(report, "bent strip: energy per area", frame.in_cell("energy_density", place), energy);
    let deflection = -0.5 * moment * 4.0 / rigidity;
    let found = results.summary("/points/tip/displacement/2")?;
    report.relative(CASE, "bent strip: deflection of the tip, summary", "8x4", found, deflection, ROUNDING);
    let [_, _, found] = frame.at_point("displacement", [2.0, 0.0, ANY]);
    report.relative(CASE, "bent strip: deflection of the tip, field", "8x4", found, deflection, ROUNDING);
    report.relative(
        CASE,
        "bent strip: strain energy, summary",
        "8x4",
        results.summary("/energy/strain")?,
        2.0 * energy,
        ROUNDING,
    );
    Ok(())
}

fn scalar(report: &mut Report, quantity: &str, [found]: [f64; 1], exact: f64) {
    report.relative(CASE, quantity, "", found, exact, ROUNDING);
}

/// Constant membrane forces: ε by Hooke's law of plane stress (Timoshenko, Goodier, *Theory of Elasticity*, 3rd ed.,
/// McGraw-Hill 1970, Sect. 11).
fn stretched_sheet(report: &mut Report, element: &str) -> Result<()> {
    let results = run(model!("stretched_sheet"), element)?;
    let frame = results.last_frame("fields.pvd")?;
    let ((young, nu, h), place) = (SHEET, [0.625, 0.625, ANY]);
    let forces @ [x, y, xy] = [50.0, -20.0, 10.0];
    let scale = (50.0, ROUNDING);
    compare(report, "sheet: membrane forces", (frame.in_cell("membrane", place), forces), scale);
    for surface in ["stress_top", "stress_bottom"] {
        let name = format!("sheet: {surface}");
        compare(report, &name, (frame.in_cell(surface, place), forces.map(|n| n / h)), (50.0 / h, ROUNDING));
    }
    let equivalent = (x * x + y * y - x * y + 3.0 * xy * xy).sqrt() / h;
    scalar(report, "sheet: von Mises stress", frame.in_cell("von_mises", place), equivalent);
    let energy = (x * x + y * y - 2.0 * nu * x * y + 2.0 * (1.0 + nu) * xy * xy) / (2.0 * young * h);
    scalar(report, "sheet: energy per area", frame.in_cell("energy_density", place), energy);
    // The side along x keeps its direction: u = ε_x x + γ y, v = ε_y y.
    let strain = [(x - nu * y) / (young * h), (y - nu * x) / (young * h)];
    let shear = 2.0 * (1.0 + nu) * xy / (young * h);
    for (component, exact) in [("x", 2.0 * strain[0] + shear), ("y", strain[1])] {
        let column = format!("corner.u{component}");
        let history = results.table("history.csv")?;
        let found = history.last().map_or(f64::NAN, |row| row.number(&column));
        report.relative(CASE, &format!("sheet: {column}, history"), "8x4", found, exact, ROUNDING);
    }
    Ok(())
}

/// Transverse shear where the moment vanishes: q = Q, τ = 1.5 Q/h in the middle of the thickness
/// (J. M. Gere, S. P. Timoshenko, *Mechanics of Materials*, 4th ed., PWS 1997, Sect. 5.8), von Mises √3 τ.
fn guided_strip(report: &mut Report, element: &str) -> Result<()> {
    let results = run(model!("guided_strip"), element)?;
    let frame = results.last_frame("fields.pvd")?;
    let (h, middle) = (SHEET.2, [0.9, 0.375, ANY]);
    // The force −1 on the face of normal +x; the clamp holds the moment M(x) = x − L/2.
    let scale = (1.0, ROUNDING);
    compare(report, "guided strip: shear forces", (frame.in_cell("shear", middle), [-1.0, 0.0]), scale);
    compare(
        report,
        "guided strip: moments in the middle",
        (frame.in_cell("bending", middle), [0.0; 3]),
        scale,
    );
    let quarter = frame.in_cell("bending", [0.3, 0.375, ANY]);
    compare(report, "guided strip: moments at a sixth", (quarter, [-0.6, 0.0, 0.0]), scale);
    let equivalent = 3.0_f64.sqrt() * 1.5 / h;
    scalar(
        report,
        "guided strip: von Mises stress in the middle",
        frame.in_cell("von_mises", middle),
        equivalent,
    );
    Ok(())
}

/// Boiler formula N = p R around the tube, the pull along it, and the growth of the radius
/// (p R − ν N_x) R/(E h) (Timoshenko, Woinowsky-Krieger, Sect. 106).
fn pressurised_cylinder(report: &mut Report, element: &str) -> Result<()> {
    let results = run(model!("pressurised_cylinder"), element)?;
    let frame = results.last_frame("fields.pvd")?;
    let (young, nu, h, radius, pull) = (2e7, 0.3, 5e-4, 0.5, 0.3);
    let hoop = 2.0 * radius;
    // A polygon of chords over the angle δ carries p R cos(δ/2), and directors lean by δ/(2√3) at the integration points:
    // less by δ²/8 + δ²/12.
    let chords = (0.5 * PI / 32.0_f64).powi(2) / 4.0;
    // Changes of curvature are defined up to ε/R only, moments up to N h²/(12 R) (W. T. Koiter, in: The Theory of Thin
    // Elastic Shells, North-Holland 1960, 12–33).
    let curved = 0.25 * h / radius;
    for degrees in [15.0_f64, 70.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let place = [radius * sin, 0.3, radius * cos];
        let name = |quantity: &str| format!("tube at {degrees}°: {quantity}");
        let forces = [hoop, pull, 0.0];
        let found: [f64; 3] = frame.in_cell("membrane", place);
        compare(report, &name("membrane forces"), (found, forces), (hoop, chords));
        let found: [f64; 3] = frame.in_cell("bending", place);
        compare(report, &name("moments"), (found, [0.0; 3]), (hoop * h, curved));
        let found: [f64; 3] = frame.in_cell("stress_top", place);
        let (stress, tolerance) = (forces.map(|n| n / h), chords + 6.0 * curved);
        compare(report, &name("outer stress"), (found, stress), (hoop / h, tolerance));
        let exact = (hoop * hoop - hoop * pull + pull * pull).sqrt() / h;
        let [found] = frame.in_cell("von_mises", place);
        report.relative(CASE, &name("von Mises stress"), "32x16", found, exact, tolerance);
    }
    let growth = (hoop - nu * pull) * radius / (young * h);
    let found = results.summary("/points/crown/displacement/2")?;
    report.relative(CASE, "tube: growth of the radius, summary", "32x16", found, growth, chords + curved);
    Ok(())
}

/// Uniaxial stress beyond yield: S = y + H p with the stress S = N/(λ h) of the Green–Lagrange strain S/E + p and the
/// stretch λ that belongs to it; y p is dissipated per volume (J. C. Simo, T. J. R. Hughes, *Computational Inelasticity*,
/// Springer 1998, Sect. 1.2).
fn yielding_sheet(report: &mut Report, element: &str) -> Result<()> {
    let results = run(model!("yielding_sheet"), element)?;
    let frame = results.last_frame("fields.pvd")?;
    let (young, yields, hardening, h, force, place) = (2e5, 250.0, 1e5, 0.02, 6.0, [0.625, 0.625, ANY]);
    let (mut stretch, mut stress, mut plastic) = (1.0_f64, 0.0, 0.0);
    for _ in 0..50 {
        stress = force / (stretch * h);
        plastic = (stress - yields) / hardening;
        stretch = (1.0 + 2.0 * (stress / young + plastic)).sqrt();
    }
    let [found] = frame.in_cell("plastic_strain", place);
    report.relative(CASE, "yielding sheet: plastic strain", "", found, plastic, ROUNDING);
    let found: [f64; 3] = frame.in_cell("stress_top", place);
    compare(report, "yielding sheet: stress at the top", (found, [stress, 0.0, 0.0]), (stress, ROUNDING));
    let history = results.table("history.csv")?;
    let column = |name: &str| history.last().map_or(f64::NAN, |row| row.number(name));
    let dissipated = yields * plastic * 2.0 * h;
    report.relative(
        CASE,
        "yielding sheet: dissipated, history",
        "",
        column("dissipated"),
        dissipated,
        ROUNDING,
    );
    let moved = 2.0 * (stretch - 1.0);
    report.relative(CASE, "yielding sheet: end.ux, history", "", column("end.ux"), moved, ROUNDING);
    Ok(())
}

/// Classical lamination theory: ε = A⁻¹ N, κ = D⁻¹ M, σ = Q̄ (ε − z κ) rotated to the axes of each ply; reserve by
/// Tsai and Wu. R. M. Jones, *Mechanics of Composite Materials*, 2nd ed., Taylor & Francis 1999, Sect. 2.6, 4.2, 2.9.4.
fn laminate(report: &mut Report, element: &str) -> Result<()> {
    let frame: Frame = run(model!("laminate"), element)?.last_frame("fields.pvd")?;
    let (force, moment, ply, place) = (1000.0, 2.0, 0.001, [1.125, 0.375, ANY]);
    let angles = [30.0, 90.0, 90.0, 30.0_f64];
    let (mut a, mut d) = (Matrix3::zeros(), Matrix3::zeros());
    for (k, angle) in angles.into_iter().enumerate() {
        let (bottom, top) = (ply * (k as f64 - 2.0), ply * (k as f64 - 1.0));
        let t = strain_turn(angle);
        let q = t.transpose() * reduced_stiffness() * t;
        a += q * (top - bottom);
        d += q * ((top.powi(3) - bottom.powi(3)) / 3.0);
    }
    let solve = |m: Matrix3<f64>, x: f64| {
        m.try_inverse().map_or(Vector3::repeat(f64::NAN), |inverse| inverse * Vector3::new(x, 0.0, 0.0))
    };
    let (strain, curvature) = (solve(a, force), solve(d, moment));
    let mut least = (f64::INFINITY, 0.0);
    for (k, angle) in angles.into_iter().enumerate() {
        for (i, height) in ["bottom", "middle", "top"].into_iter().enumerate() {
            let z = ply * (k as f64 - 2.0 + 0.5 * i as f64);
            let stress = reduced_stiffness() * strain_turn(angle) * (strain - curvature * z);
            let found = frame.in_cell(&format!("ply_{}_{height}", k + 1), place);
            let name = format!("laminate: ply {} ({angle}°), {height}", k + 1);
            compare(report, &name, (found, stress.into()), (stress.norm(), ROUNDING));
            let reserve = tsai_wu_reserve(stress);
            if reserve < least.0 {
                least = (reserve, (k + 1) as f64);
            }
        }
    }
    scalar(report, "laminate: least reserve factor", frame.in_cell("reserve_factor", place), least.0);
    scalar(report, "laminate: its ply", frame.in_cell("critical_ply", place), least.1);
    Ok(())
}

/// Q of the ply's axes: E1 = 140, E2 = 10, G12 = 5 GPa, ν12 = 0.3.
fn reduced_stiffness() -> Matrix3<f64> {
    let (e1, e2, g, nu) = (140e9, 10e9, 5e9, 0.3);
    let s = 1.0 / (1.0 - nu * nu * e2 / e1);
    Matrix3::new(s * e1, s * nu * e2, 0.0, s * nu * e2, s * e2, 0.0, 0.0, 0.0, g)
}

/// Strains (ε, ε, γ) in axes that are rotated by an angle (degrees).
fn strain_turn(angle: f64) -> Matrix3<f64> {
    let (s, c) = angle.to_radians().sin_cos();
    Matrix3::new(c * c, s * s, s * c, s * s, c * c, -s * c, -2.0 * s * c, 2.0 * s * c, c * c - s * s)
}

/// Multiple of a stress at which the index of Tsai and Wu is 1, with F12 = −½ √(F11 F22).
fn tsai_wu_reserve(s: Vector3<f64>) -> f64 {
    let (xt, xc, yt, yc, s12) = (1500e6, 1200e6, 50e6, 250e6, 70e6);
    let (f11, f22) = (1.0 / (xt * xc), 1.0 / (yt * yc));
    let linear = (1.0 / xt - 1.0 / xc) * s.x + (1.0 / yt - 1.0 / yc) * s.y;
    let interaction = -(f11 * f22).sqrt() * s.x * s.y;
    let square = f11 * s.x * s.x + f22 * s.y * s.y + (s.z / s12).powi(2) + interaction;
    (-linear + (linear * linear + 4.0 * square).sqrt()) / (2.0 * square)
}

/// Frequencies of a supported strip in cylindrical bending with shear and rotary inertia: the lower root of
/// (ρh ω² − G k²)(ρh³/12 ω² − D k² − G) = (G k)², G = 5/6 μ h (R. D. Mindlin, J. Appl. Mech. 18 (1951) 31–38).
fn supported_strip(report: &mut Report) -> Result<()> {
    let results = run(model!("supported_strip"), "ems")?;
    let modes = results.table("modes.csv")?;
    let (young, nu, h, density, n) = (2.1e11, 0.3, 0.01, 7850.0, 64.0);
    let rigidity = young * h * h * h / 12.0 / (1.0 - nu * nu);
    let shear = 5.0 / 6.0 * young * h / (2.0 * (1.0 + nu));
    let (mass, rotary) = (density * h, density * h * h * h / 12.0);
    for number in 1..=4_u32 {
        let k = f64::from(number) * PI;
        let (a, b) = (mass * rotary, mass * (rigidity * k * k + shear) + rotary * shear * k * k);
        let c = shear * k * k * rigidity * k * k;
        let omega = (2.0 * c / (b + (b * b - 4.0 * a * c).sqrt())).sqrt();
        // Elements of length l with slopes θ = 2 w tan(k l/2)/l, curvatures 2 θ sin(k l/2)/l and linear masses are stiffer
        // by (k l)²/4: by half of it in ω, to which orders above add a little.
        let tolerance = (k / n).powi(2) / 7.0;
        let row = modes.get(number as usize - 1);
        let column = |name: &str| row.map_or(f64::NAN, |r| r.number(name));
        let name = |what: &str| format!("supported strip: mode {number}, {what}");
        report.relative(CASE, &name("omega"), "64x2", column("omega"), omega, tolerance);
        report.relative(
            CASE,
            &name("frequency_hz"),
            "64x2",
            column("frequency_hz"),
            omega / (2.0 * PI),
            tolerance,
        );
        let listed = results.summary(&format!("/frequencies_hz/{}", number - 1))?;
        report.relative(CASE, &name("summary"), "64x2", listed, column("frequency_hz"), 1e-12);
    }
    let shape = results.frame("modes/0002.vtu")?;
    let w = |x: f64| shape.at_point::<3>("displacement", [x, 0.0, ANY])[2];
    report.relative(
        CASE,
        "supported strip: mode 2, w(L/8)/w(L/4)",
        "64x2",
        w(0.125) / w(0.25),
        0.5_f64.sqrt(),
        1e-4,
    );
    report.relative(CASE, "supported strip: mode 2, w(3L/4)/w(L/4)", "64x2", w(0.75) / w(0.25), -1.0, 1e-4);
    Ok(())
}

/// A parabola, which the trapezoidal rule follows exactly: u = v₀ t + ½ g t², v = v₀ + g t, kinetic energy ½ m v².
fn thrown_plate(report: &mut Report) -> Result<()> {
    let results = run(model!("thrown_plate"), "ems")?;
    let (start, g, mass, scale) = (Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.0, 0.0, -9.81), 0.8, 5.0);
    let history = results.table("history.csv")?;
    report.absolute(CASE, "thrown plate: rows of the history", "", history.len() as f64, 11.0, 0.0);
    for row in history.iter().skip(1).step_by(3) {
        let t = row.number("time");
        let name = |what: &str| format!("thrown plate at {t:.1}: {what}");
        let exact = start * t + g * (0.5 * t * t);
        let found = ["x", "y", "z"].map(|c| row.number(&format!("corner.u{c}")));
        compare(report, &name("displacement, history"), (found, exact.into()), (scale, ROUNDING));
        let velocity = start + g * t;
        let kinetic = 0.5 * mass * velocity.norm_squared();
        report.relative(CASE, &name("kinetic energy"), "", row.number("kinetic"), kinetic, ROUNDING);
        let found = ["px", "py", "pz"].map(|c| row.number(c));
        compare(report, &name("momentum"), (found, (velocity * mass).into()), (mass * scale, ROUNDING));
    }
    let total = |row: Option<&super::reference::Record>| row.map_or(f64::NAN, |r| r.number("total"));
    let (first, last) = (total(history.first()), total(history.last()));
    report.absolute(
        CASE,
        "thrown plate: total energy, last less first",
        "",
        last - first,
        0.0,
        ROUNDING * mass * 50.0,
    );
    let frame = results.last_frame("fields.pvd")?;
    let found = frame.at_point("velocity", [0.0; 3]);
    compare(report, "thrown plate at 1.0: velocity, field", (found, (start + g).into()), (scale, ROUNDING));
    let found = frame.at_point("displacement", [0.0; 3]);
    compare(
        report,
        "thrown plate at 1.0: displacement, field",
        (found, (start + g * 0.5).into()),
        (scale, ROUNDING),
    );
    let found = frame.at_point("director", [0.0; 3]);
    compare(report, "thrown plate at 1.0: director, field", (found, [0.0, 0.0, 1.0]), (1.0, ROUNDING));
    Ok(())
}

/// A bar pulled suddenly: d'Alembert's waves, u = σ/(ρ c) (t − (L − x)/c) behind the front (K. F. Graff, *Wave Motion in
/// Elastic Solids*, Ohio State University Press 1975, Sect. 2.1–2.4), by explicit steps.
fn pulled_bar(report: &mut Report) -> Result<()> {
    let results = Results::of(include_str!("../../models/examples/stress_wave.toml"))?;
    let (stress, young, density) = (1e8, 2.1e11, 7850.0_f64);
    let speed = (young / density).sqrt();
    let history = results.table("history.csv")?;
    // Finite strains of 5e-4 and waves that 200 elements cannot carry: less than 0.2 % of the last displacement.
    let scale = stress / (density * speed) * 2.4e-4;
    for (point, from_end) in [("end", 0.0), ("middle", 0.5)] {
        for wanted in [0.8e-4, 1.6e-4, 2.4e-4] {
            let row = history.iter().find(|r| r.number("time") >= wanted);
            let column = |name: &str| row.map_or(f64::NAN, |r| r.number(name));
            let t = column("time");
            let exact = stress / (density * speed) * larger(t - from_end / speed, 0.0);
            let found = column(&format!("{point}.ux"));
            let name = format!("pulled bar: {point}.ux near {wanted:.1e} s, history");
            report.absolute(CASE, &name, "200x2", found, exact, 2e-3 * scale);
        }
    }
    Ok(())
}
