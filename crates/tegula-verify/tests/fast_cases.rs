//! The verification cases that take seconds run with the tests.

use tegula_verify::verify::{Case, Cost, cases, run};

#[test]
fn fast_cases_pass() {
    let fast: Vec<&Case> = cases().filter(|c| c.cost == Cost::Fast).collect();
    fast.iter().for_each(|case| println!("contract: case {}", case.name));
    let report = run(&fast, None, &mut |_| {});
    let missed: Vec<_> = report.rows().iter().filter(|r| !r.pass).collect();
    assert!(report.rows().len() > 100, "only {} rows", report.rows().len());
    assert!(missed.is_empty(), "{missed:#?}");
}
