//! The tables of the paper with all elements side by side.
//!
//! Tables 1–3: deflection of cantilever plates (Sect. 5.1) over the converged plate theory. Fig. 7: convergence of
//! the quarter cylinder. Table 4: frequencies of the free plate (Sect. 5.3).

use std::f64::consts::PI;

use tegula::Result;
use tegula::analysis::Silent;

use super::model::{Compiled, material, read, refine, section, switch};
use super::plate;
use super::quarter_cylinder;
use super::reference::records;
use super::report::{Report, Table};
use super::statistics::run_modal;
use super::{Case, Cost};

/// Cases of this file.
pub(super) const CASES: &[Case] = &[Case {
    name: "paper-tables",
    about: "Tables 1-4 and Fig. 7 of the paper with all elements side by side",
    cost: Cost::Normal,
    run: tables,
}];

const CASE: &str = "paper-tables";
const CONVERGED: &str = include_str!("../../reference/plate_converged.csv");
const FREQUENCIES: &str = include_str!("../../reference/free_plate.csv");
/// Columns of Tables 1–3; the elements with three-dimensional stresses carry no shear correction.
const ELEMENTS: [&str; 4] = ["EMS", "CM eas4+4", "MITC4", "solid-shell EAS8"];

/// All tables.
pub fn tables(report: &mut Report) -> Result<()> {
    plates(report)?;
    locking(report)?;
    cylinder(report)?;
    frequencies(report)?;
    report.element("ems");
    Ok(())
}

/// Deflections of the corner and the middle of the free edge by plate theory.
pub fn theory(h: f64) -> [f64; 2] {
    let all = records(CONVERGED);
    let row = all
        .iter()
        .filter(|r| r.text("model").starts_with("p-version") && r.number("H_m") == h)
        .max_by(|a, b| a.number("order").total_cmp(&b.number("order")));
    row.map_or([f64::NAN; 2], |r| ["uz_corner_m", "uz_midedge_m"].map(|c| r.number(c)))
}

/// Frequencies of the free plate by a Ritz series of Mindlin's plate.
pub fn series(slenderness: f64) -> Vec<f64> {
    let all = records(FREQUENCIES);
    let row = all
        .iter()
        .filter(|r| r.text("model") == "truth Mindlin ks=0.833" && r.number("L/H") == slenderness)
        .max_by(|a, b| a.number("n").total_cmp(&b.number("n")));
    (1..=5).map(|i| row.map_or(f64::NAN, |r| r.number(&format!("Omega{i}")))).collect()
}

fn plates(report: &mut Report) -> Result<()> {
    for (number, h) in [1e-3, 1e-2, 1e-1].into_iter().enumerate() {
        let [corner, middle] = theory(h);
        let slenderness = (1.0 / h).round();
        let mut table = Table::new(
            &format!("paper-table-{}", number + 1),
            &format!(
                "Table {}: cantilever plate, L/H = {slenderness}, deflection of the free edge",
                number + 1
            ),
            &["elements", "where", "EMS", "CM", "MITC4", "solid shell", "plate theory"],
        );
        for n in [2, 4, 8, 16, 32] {
            let mut of_element = Vec::new();
            for variant in ELEMENTS {
                of_element.push(plate::deflections(variant, n, h)?);
            }
            let [ems, mitc4] = [0, 2].map(|i| of_element[i]);
            for (place, theory, name) in [(0, corner, "corner"), (1, middle, "middle")] {
                let mut row = vec![format!("{n}x{n}"), name.to_owned()];
                row.extend(of_element.iter().map(|w| format!("{:.6e}", w[place])));
                row.push(format!("{theory:.6e}"));
                table.cells.push(row);
            }
            let mesh = format!("{n}x{n}");
            report.element("mitc4");
            report.relative(
                CASE,
                &format!("L/H = {slenderness}: MITC4 = EMS"),
                &mesh,
                mitc4[0],
                ems[0],
                1e-8,
            );
        }
        report.table(table);
    }
    Ok(())
}

/// Rows that show locking without the remedies.
fn locking(report: &mut Report) -> Result<()> {
    // Cylindrical bending of the plate by eq. 38, F L³/(3 D W).
    let strip = 8.6667e-4;
    let locked = -plate::deflections("CM no thickness EAS", 32, 1e-2)?[0] / strip;
    report.element("cm no thickness eas");
    report.absolute(
        CASE,
        "L/H = 100: deflection without thickness EAS over eq. 38",
        "32x32",
        locked,
        0.86,
        0.005,
    );
    let shear = plate::deflections("EMS no ANS shear", 16, 1e-3)?[0];
    report.element("ems no ans shear");
    report.at_most(
        CASE,
        "L/H = 1000: share of the deflection without ANS shear",
        "16x16",
        shear / theory(1e-3)[0],
        0.01,
    );
    Ok(())
}

fn cylinder(report: &mut Report) -> Result<()> {
    let mut table = Table::new(
        "paper-figure-7",
        "Fig. 7: quarter cylinder, deflection u_z at the force and its error against the finest mesh",
        &["elements", "EMS", "error", "CM", "error"],
    );
    let meshes = [4, 8, 16, 32, 64];
    let mut found = Vec::new();
    for variant in ["EMS", "CM eas4+4"] {
        let values: Vec<f64> =
            meshes.iter().map(|&n| quarter_cylinder::deflection(variant, n)).collect::<Result<_>>()?;
        // Second order: Richardson's limit of the two finest meshes.
        let limit = values[4] + (values[4] - values[3]) / 3.0;
        found.push((values, limit));
    }
    for (i, n) in meshes.into_iter().enumerate() {
        let mut row = vec![format!("{n}x{n}")];
        for (values, limit) in &found {
            row.push(format!("{:.9}", values[i]));
            row.push(format!("{:.1e}", ((values[i] - limit) / limit).abs()));
        }
        table.cells.push(row);
    }
    report.element("cm");
    report.relative(CASE, "Fig. 7: limits of CM and EMS", "", found[1].1, found[0].1, 5e-3);
    report.table(table);
    Ok(())
}

fn frequencies(report: &mut Report) -> Result<()> {
    let mut table = Table::new(
        "paper-table-4",
        "Table 4: free square plate, Ω = ω/(π²√(D/ρHL⁴)), first five elastic frequencies",
        &["L/H", "element", "mesh", "Ω1", "Ω2", "Ω3", "Ω4", "Ω5"],
    );
    for slenderness in [1000.0, 100.0, 10.0] {
        let truth = series(slenderness);
        for (variant, meshes) in
            [("EMS", &[16, 32][..]), ("CM eas4+4", &[16, 32]), ("ancf-full", &[4, 8, 16])]
        {
            for &n in meshes {
                let omegas = free_plate(variant, n, 1.0 / slenderness)?;
                let mut row = vec![format!("{slenderness}"), variant.into(), format!("{n}x{n}")];
                row.extend(omegas.iter().take(5).map(|o| format!("{o:.4}")));
                table.cells.push(row);
                report.element(variant);
                if variant == "ancf-full" {
                    let lower = omegas[0] / truth[0];
                    let what = format!("L/H = {slenderness}: truth over locked frequency Omega 1");
                    report.at_most(CASE, &what, &format!("{n}x{n}"), 1.0 / lower, 1.0);
                }
            }
        }
        let mut row = vec![format!("{slenderness}"), "Mindlin (Ritz)".into(), String::new()];
        row.extend(truth.iter().map(|o| format!("{o:.4}")));
        table.cells.push(row);
    }
    report.table(table);
    Ok(())
}

const FREE_PLATE: &str = include_str!("../../models/free_plate.toml");

/// Elastic frequencies of the free plate.
fn free_plate(variant: &str, n: u32, h: f64) -> Result<Vec<f64>> {
    let mut model = read(FREE_PLATE)?;
    refine(&mut model, [n, n]);
    switch(&mut model, variant);
    section(&mut model)?.thickness = h;
    let m = material(&model)?.clone();
    let compiled = Compiled::new(&model)?;
    let outcome = run_modal(&compiled.system, 12, &mut Silent)?;
    let plate_stiffness = m.young * h.powi(3) / 12.0 / (1.0 - m.poisson * m.poisson);
    let unit = PI * PI * (plate_stiffness / (m.density * h)).sqrt();
    Ok(outcome.modes.iter().filter(|m| !m.rigid).map(|m| m.omega / unit).collect())
}
