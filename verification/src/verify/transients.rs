//! Transient benchmarks: hinged plate pendulum (T5), oscillating clamped plate (T6).
//!
//! The published histories start from zero acceleration although the load acts at once, with
//! steps of 10 ms (T5) and 1 s (T6): they lag by half a step. They are compared at the same
//! steps with a load that grows over the first one, which is equivalent for a step: no load at its start, the
//! full load at its end. The initial accelerations of the program satisfy the equations of motion; a comparison with the
//! rigid pendulum verifies this.

use tegula::Result;
use tegula::model::{Amplitude, Analysis, Load, Model, RampAmplitude};
use tegula::norm::max_norm;

use super::history::{History, range};
use super::model::{read, section};
use super::reference::records;
use super::report::Report;
use super::{Case, Cost};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[
    Case {
        name: "hinged-plate",
        about: "T5: plate hinged along an edge, released horizontal",
        cost: Cost::Normal,
        run: hinged_plate,
    },
    Case {
        name: "oscillating-plate",
        about: "T6: clamped plate under sudden pressure, linear",
        cost: Cost::Normal,
        run: oscillating_plate,
    },
];

const HINGED: &str = include_str!("../../models/hinged_plate.toml");
const OSCILLATING: &str = include_str!("../../models/oscillating_plate.toml");
const REFERENCE: &str = include_str!("../../reference/transients.csv");
/// The free corner that is watched.
const TIP: &str = "u_max_v_min";

/// T5: the published history, and the rigid pendulum.
pub fn hinged_plate(report: &mut Report) -> Result<()> {
    let mut model = read(HINGED)?;
    late_load(&mut model, 0.01);
    published(report, "hinged-plate", &model, "T5")?;

    let mut model = read(HINGED)?;
    let h = section(&mut model)?.thickness;
    let history = History::of(&model, TIP)?;
    let rigid = rigid_pendulum(9.8, 1.0, h, 2.5);
    let worst = max_norm(rigid.iter().map(|(t, z)| history.at(*t).z - z));
    report.at_most("hinged-plate", "automatic steps against the rigid pendulum / length", "8x8", worst, 0.01);
    Ok(())
}

/// T6: the published history.
pub fn oscillating_plate(report: &mut Report) -> Result<()> {
    let mut model = read(OSCILLATING)?;
    late_load(&mut model, 1.0);
    published(report, "oscillating-plate", &model, "T6")
}

/// Constant steps, and loads that are not there at time 0 but from the end of the first step on.
fn late_load(model: &mut Model, step: f64) {
    if let Analysis::Transient(t) = &mut model.analysis {
        t.time_step = Some(step);
    }
    let ramp = RampAmplitude { start: 0.0, end: step };
    model.amplitudes.insert("late".into(), Amplitude::Ramp(ramp));
    for load in &mut model.loads {
        match load {
            Load::Gravity(g) => g.amplitude = Some("late".into()),
            Load::Pressure(p) => p.amplitude = Some("late".into()),
            _ => {}
        }
    }
}

/// Tip of a rigid plate of length `l` and thickness `h` on a hinge, released horizontal: (t, −l sin θ) by
/// the classical Runge–Kutta method, every 0.05.
fn rigid_pendulum(g: f64, l: f64, h: f64, end: f64) -> Vec<(f64, f64)> {
    let stiffness = g * 0.5 * l / (l * l / 3.0 + h * h / 12.0);
    let rate = |y: [f64; 2]| [y[1], stiffness * y[0].cos()];
    let dt = 1e-4;
    let mut y = [0.0_f64, 0.0];
    let mut out = Vec::new();
    for step in 0..=(end / dt).round() as usize {
        if step % 500 == 0 {
            out.push((step as f64 * dt, -l * y[0].sin()));
        }
        let add = |k: [f64; 2], f: f64| [y[0] + f * k[0], y[1] + f * k[1]];
        let k1 = rate(y);
        let k2 = rate(add(k1, 0.5 * dt));
        let k3 = rate(add(k2, 0.5 * dt));
        let k4 = rate(add(k3, dt));
        y = std::array::from_fn(|i| y[i] + dt / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    out
}

fn published(report: &mut Report, case: &str, model: &Model, prefix: &str) -> Result<()> {
    let history = History::of(model, TIP)?;
    let reference: Vec<(f64, f64)> = records(REFERENCE)
        .iter()
        .filter(|r| r.text("case").starts_with(prefix))
        .map(|r| (r.number("time_s"), r.number("value")))
        .collect();
    let moved = range(std::iter::once(0.0).chain(reference.iter().map(|r| r.1)));
    let worst = max_norm(reference.iter().map(|(t, x)| (history.at(*t).z - x) / moved));
    report.at_most(case, "corner deflection, largest difference / range", "", worst, 0.01);
    Ok(())
}
