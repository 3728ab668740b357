//! Follower loads: follower pressure, and a moment that is constant in space.

use tegula::analysis::{Observer, Step};
use tegula::model::{Analysis, Load, StaticAnalysis, VectorLoad};
use tegula::{Result, Vec3};

use super::model::{Compiled, material, read, refine, section};
use super::reference::records;
use super::report::Report;
use super::{Case, Cost};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[Case {
    name: "follower-loads",
    about: "strip under follower pressure, strip rolled up by a moment constant in space",
    cost: Cost::Normal,
    run: all,
}];

const MODEL: &str = include_str!("../../models/follower_strip.toml");
const REFERENCE: &str = include_str!("../../reference/follower_strip.csv");
const CASE: &str = "follower-loads";
/// Digits of the reference.
const DIGITS: f64 = 1e-5;
/// Turns of the strip that is rolled up.
const TURNS: f64 = 4.0;

#[derive(Default)]
struct Iterations {
    most: u32,
    steps: u32,
}

impl Observer for Iterations {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.most = u32::max(self.most, step.iterations);
        self.steps += 1;
        Ok(())
    }
}

/// Comparison of positions with the references, and iterations of a step, which show whether the tangent contains the
/// load stiffness.
pub fn all(report: &mut Report) -> Result<()> {
    report.element("ems");
    pressure(report)?;
    roll_up(report)
}

fn pressure(report: &mut Report) -> Result<()> {
    let model = read(MODEL)?;
    let compiled = Compiled::new(&model)?;
    let corner = compiled.point("u_max_v_max")?;
    let mut iterations = Iterations::default();
    let outcome = compiled.statics_watched(&model, &mut iterations)?;
    let end = Vec3::from(compiled.system.coordinates.reference[corner]) + Vec3::from(outcome.state.u[corner]);
    for row in records(REFERENCE) {
        let axis = row.text("axis");
        let found = if axis == "x" { end.x } else { end.z };
        report.absolute(
            CASE,
            &format!("pressure: {axis} of the end"),
            "40x2",
            found,
            row.number("position"),
            DIGITS,
        );
    }
    report.at_most(CASE, "pressure: iterations of a step", "40x2", f64::from(iterations.most), 8.0);
    report.at_most(CASE, "pressure: repeated steps", "40x2", outcome.statistics.cutbacks as f64, 0.0);
    Ok(())
}

/// Pure bending to four circles, κ = M/(EI): the end returns to the clamp, for a thin strip (up to (κh)² = 0.0025) and up to
/// the chords of elements that turn by 9°.
fn roll_up(report: &mut Report) -> Result<()> {
    let mut model = read(MODEL)?;
    refine(&mut model, [160, 2]);
    for m in model.materials.values_mut() {
        if let tegula::model::Material::Isotropic(m) = m {
            m.poisson = 0.0;
        }
    }
    let thickness = 0.02_f64;
    section(&mut model)?.thickness = thickness;
    let young = material(&model)?.young;
    let moment = young * thickness.powi(3) / 12.0 * TURNS * std::f64::consts::TAU / 10.0;
    model.analysis = Analysis::Static(StaticAnalysis { load_steps: 80, ..StaticAnalysis::default() });
    model.loads = vec![Load::EdgeMoment(VectorLoad {
        on: "u_max".into(),
        value: [0.0, moment, 0.0],
        amplitude: None,
        distribution: None,
    })];
    let compiled = Compiled::new(&model)?;
    let corner = compiled.point("u_max_v_max")?;
    let mut iterations = Iterations::default();
    let outcome = compiled.statics_watched(&model, &mut iterations)?;
    let end = Vec3::from(compiled.system.coordinates.reference[corner]) + Vec3::from(outcome.state.u[corner]);
    for (axis, found) in [("x", end.x), ("z", end.z)] {
        report.absolute(CASE, &format!("four turns: {axis} of the end"), "160x2", found, 0.0, 0.06);
    }
    report.at_most(CASE, "four turns: repeated steps", "160x2", outcome.statistics.cutbacks as f64, 0.0);
    Ok(())
}
