//! Verification: the paper's examples and benchmarks of the literature, computed and compared.
//!
//! A case is a function that adds rows to a [`Report`]. Reference numbers are tables in
//! `verification/reference/`, models are model files in `verification/models/` (which has two motions of the study
//! [`precision`](crate::precision), too).
//! Adding a case: a function in a file of `verify/` and a line in [`CASES`].

mod benchmarks;
mod composites;
mod files;
mod follower_loads;
mod frequencies;
pub(crate) mod history;
mod inside;
mod large_cantilever;
mod macneal_beams;
mod macneal_plates;
mod membrane_parts;
pub(crate) mod model;
mod paper;
mod patch;
mod pendulum;
mod plate;
mod quarter_cylinder;
mod reference;
mod report;
mod results;
mod transients;
mod transients_literature;

use std::path::Path;

pub use report::{Report, Row, Table, Verdict};

/// How long a case takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cost {
    /// Seconds in all; runs with the tests too.
    Fast,
    /// Up to minutes; runs with `tegula verify`.
    Normal,
    /// Longer; runs with `tegula verify --all`.
    Long,
}

/// A verification case.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Name on the command line.
    pub name: &'static str,
    /// One line that describes the comparison.
    pub about: &'static str,
    /// How long it takes.
    pub cost: Cost,
    run: fn(&mut Report) -> tegula::Result<()>,
}

/// All cases.
pub const CASES: &[Case] = &[
    Case {
        name: "plate",
        about: "Sect. 5.1: cantilevered plates, three slendernesses, n = 1…32",
        cost: Cost::Normal,
        run: plate::all,
    },
    Case { name: "plate-fast", about: "Sect. 5.1 up to n = 8", cost: Cost::Fast, run: plate::fast },
    Case {
        name: "quarter-cylinder",
        about: "Sect. 5.2: large deformation, set-ups S1-S4, convergence",
        cost: Cost::Normal,
        run: quarter_cylinder::all,
    },
    Case {
        name: "quarter-cylinder-fast",
        about: "Sect. 5.2 up to 16x16",
        cost: Cost::Fast,
        run: quarter_cylinder::fast,
    },
    Case {
        name: "frequencies",
        about: "Sect. 5.3: free plate, ten frequencies, L/H = 1000, 100, 10",
        cost: Cost::Normal,
        run: frequencies::all,
    },
    Case {
        name: "frequencies-fast",
        about: "Sect. 5.3 up to n = 8",
        cost: Cost::Fast,
        run: frequencies::fast,
    },
    Case {
        name: "pendulum",
        about: "Sect. 5.4: quarter cylinder pendulum at 16x16 and 32x32",
        cost: Cost::Normal,
        run: pendulum::all,
    },
    Case {
        name: "pendulum-64",
        about: "Sect. 5.4: the pendulum at 64x64",
        cost: Cost::Normal,
        run: pendulum::fine,
    },
    Case {
        name: "pendulum-fast",
        about: "Sect. 5.4: the start of the pendulum at 8x8, energy-momentum",
        cost: Cost::Fast,
        run: pendulum::fast,
    },
    Case {
        name: "paper-tables",
        about: "Tables 1-4 and Fig. 7 of the paper with all elements side by side",
        cost: Cost::Normal,
        run: paper::tables,
    },
    Case {
        name: "patch",
        about: "patch tests of MacNeal and Harder for all elements",
        cost: Cost::Fast,
        run: patch::all,
    },
    Case {
        name: "linear-benchmarks",
        about: "Scordelis-Lo roof, pinched cylinder, pinched hemisphere",
        cost: Cost::Normal,
        run: benchmarks::linear,
    },
    Case {
        name: "sze",
        about: "Sze, Liu, Lo: strip under shear and moment, slit annulus, hemisphere",
        cost: Cost::Normal,
        run: benchmarks::sze,
    },
    Case {
        name: "sze-literature",
        about: "the same for EMS, CM and MITC4 against elastica, exact arc and literature",
        cost: Cost::Normal,
        run: benchmarks::sze_literature,
    },
    Case {
        name: "balloon",
        about: "sphere of neo-Hookean rubber under pressure, through its limit",
        cost: Cost::Normal,
        run: inside::balloon,
    },
    Case {
        name: "bimetal",
        about: "Timoshenko's bimetal strip: two layers that expand differently",
        cost: Cost::Fast,
        run: inside::bimetal,
    },
    Case {
        name: "follower-loads",
        about: "strip under follower pressure, strip rolled up by a moment constant in space",
        cost: Cost::Normal,
        run: follower_loads::all,
    },
    Case {
        name: "macneal-harder-beams",
        about: "MacNeal and Harder: straight, curved and twisted beams, coarse and fine",
        cost: Cost::Normal,
        run: macneal_beams::all,
    },
    Case {
        name: "macneal-harder-plates",
        about: "MacNeal and Harder: thin rectangular plates",
        cost: Cost::Normal,
        run: macneal_plates::all,
    },
    Case {
        name: "membrane-parts",
        about: "all values of the key membrane: accuracy, stability of stretched elements and of rubber",
        cost: Cost::Normal,
        run: membrane_parts::all,
    },
    Case {
        name: "results",
        about: "files of a run against closed forms: stresses, plies, frequencies, histories",
        cost: Cost::Fast,
        run: results::all,
    },
    Case {
        name: "composites",
        about: "simply supported cross-ply plates against Navier's series",
        cost: Cost::Fast,
        run: composites::all,
    },
    Case {
        name: "hinged-plate",
        about: "T5: plate hinged along an edge, released horizontal",
        cost: Cost::Normal,
        run: transients::hinged_plate,
    },
    Case {
        name: "oscillating-plate",
        about: "T6: clamped plate under sudden pressure, linear",
        cost: Cost::Normal,
        run: transients::oscillating_plate,
    },
    Case {
        name: "transients-literature",
        about: "T1-T3: clamped plate and laminated quarter cylinders, suddenly loaded, large motion",
        cost: Cost::Normal,
        run: transients_literature::all,
    },
    Case {
        name: "transients-literature-fine",
        about: "T1-T3 with the published meshes halved twice",
        cost: Cost::Long,
        run: transients_literature::fine,
    },
    Case {
        name: "large-cantilever",
        about: "A1: cantilever plate under a corner force against quadratic solids, large displacement",
        cost: Cost::Normal,
        run: large_cantilever::all,
    },
];

/// Runs cases into a report; a case that ends in an error becomes a failed row.
///
/// `pictures`: folder for the figures of the cases, none are drawn without it. `on_row` sees each row as it comes.
pub fn run(cases: &[&Case], pictures: Option<&Path>, on_row: &mut dyn FnMut(&Row)) -> Report {
    let mut report = Report::new(pictures);
    for case in cases {
        let before = report.rows().len();
        if let Err(error) = (case.run)(&mut report) {
            report.failed(case.name, &error.to_string());
        }
        report.rows()[before..].iter().for_each(&mut *on_row);
    }
    report
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn fast_cases_pass() {
        let fast: Vec<&Case> = CASES.iter().filter(|c| c.cost == Cost::Fast).collect();
        let report = run(&fast, None, &mut |_| {});
        let missed: Vec<_> = report.rows().iter().filter(|r| !r.pass).collect();
        assert!(report.rows().len() > 100, "only {} rows", report.rows().len());
        assert!(missed.is_empty(), "{missed:#?}");
    }

    #[test]
    fn a_wrong_value_is_a_miss() {
        let mut report = Report::new(None);
        report.relative("c", "q", "1x1", 1.001, 1.0, 1e-4);
        report.at_most("c", "q", "1x1", f64::NAN, 1.0);
        assert!(report.rows().iter().all(|r| !r.pass));
    }
}
