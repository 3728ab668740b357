//! The verification cases that take seconds run with the tests.

use tegula_verify::verify::{Case, Cost, cases, run};

/// The package has no files beside it; two of its models are examples.
#[test]
fn models_that_are_examples_are_those_of_the_folder_of_examples() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    for name in ["quarter_cylinder_pendulum.toml", "stress_wave.toml"] {
        let read = |path: &str| std::fs::read_to_string(folder.join(path).join(name)).unwrap();
        assert_eq!(read("models/examples"), read("../examples"), "{name}");
    }
}

#[test]
fn fast_cases_pass() {
    let fast: Vec<&Case> = cases().filter(|c| c.cost == Cost::Fast).collect();
    fast.iter().for_each(|case| println!("contract: case {}", case.name));
    let report = run(&fast, None, &mut |_| {});
    let missed: Vec<_> = report.rows().iter().filter(|r| !r.pass).collect();
    assert!(report.rows().len() > 100, "only {} rows", report.rows().len());
    assert!(missed.is_empty(), "{missed:#?}");
}
