//! Sect. 5.3: frequencies of a free square plate.

use std::f64::consts::PI;

use tegula::Result;
use tegula::analysis::Silent;

use super::model::{Compiled, material, read, refine, section, switch};
use super::reference::records;
use super::report::Report;
use super::statistics::run_modal;
use super::{Case, Cost};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[
    Case {
        name: "frequencies",
        about: "Sect. 5.3: free plate, ten frequencies, L/H = 1000, 100, 10",
        cost: Cost::Normal,
        run: all,
    },
    Case { name: "frequencies-fast", about: "Sect. 5.3 up to n = 8", cost: Cost::Fast, run: fast },
];

const MODEL: &str = include_str!("../../models/free_plate.toml");
const REFERENCE: &str = include_str!("../../reference/free_plate.csv");
const CASE: &str = "frequencies";

pub fn all(report: &mut Report) -> Result<()> {
    compare(report, 64)
}

pub fn fast(report: &mut Report) -> Result<()> {
    compare(report, 8)
}

/// First frequency Ω₁ of the plate of L/H = 100 with n × n elements of a variant.
pub fn lowest(variant: &str, n: u32) -> Result<f64> {
    let mut model = read(MODEL)?;
    refine(&mut model, [n, n]);
    let h: f64 = 0.01;
    switch(&mut model, variant);
    section(&mut model)?.thickness = h;
    let m = material(&model)?.clone();
    let compiled = Compiled::new(&model)?;
    let outcome = run_modal(&compiled.system, 8, &mut Silent)?;
    let plate_stiffness = m.young * h.powi(3) / 12.0 / (1.0 - m.poisson * m.poisson);
    let unit = PI * PI * (plate_stiffness / (m.density * h)).sqrt();
    Ok(outcome.modes.iter().find(|m| !m.rigid).map_or(f64::NAN, |m| m.omega / unit))
}

fn compare(report: &mut Report, finest: u32) -> Result<()> {
    for record in records(REFERENCE).iter().filter(|r| !r.text("model").starts_with("truth")) {
        let n = record.number("n") as u32;
        if n > finest {
            continue;
        }
        let slenderness = record.number("L/H");
        let mut model = read(MODEL)?;
        refine(&mut model, [n, n]);
        let h = 1.0 / slenderness;
        switch(&mut model, record.text("model"));
        report.element(record.text("model"));
        section(&mut model)?.thickness = h;
        let m = material(&model)?.clone();
        let compiled = Compiled::new(&model)?;
        let outcome = run_modal(&compiled.system, 16, &mut Silent)?;
        let plate_stiffness = m.young * h.powi(3) / 12.0 / (1.0 - m.poisson * m.poisson);
        let unit = PI * PI * (plate_stiffness / (m.density * h)).sqrt();
        let mesh = format!("{n}x{n}");
        let elastic: Vec<f64> = outcome.modes.iter().filter(|m| !m.rigid).map(|m| m.omega / unit).collect();
        let rigid = outcome.modes.len() - elastic.len();
        report.absolute(CASE, &format!("L/H = {slenderness}: rigid modes"), &mesh, rigid as f64, 6.0, 0.0);
        for i in 1..=10 {
            let value = elastic.get(i - 1).copied().unwrap_or(f64::NAN);
            let reference = record.number(&format!("Omega{i}"));
            report.relative(CASE, &format!("L/H = {slenderness}: Omega {i}"), &mesh, value, reference, 1e-6);
        }
        let unchecked = if outcome.sturm_checked { 0.0 } else { 1.0 };
        report.absolute(CASE, &format!("L/H = {slenderness}: Sturm count wrong"), &mesh, unchecked, 0.0, 0.0);
    }
    report.element("ems");
    Ok(())
}
