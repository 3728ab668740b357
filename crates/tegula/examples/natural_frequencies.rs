//! Natural frequencies of a strip between two hinges, without and with tension.
//!
//! `cargo run --release -p tegula --example natural_frequencies`
//!
//! Under the tension N the first one is `ω² = (π/L)² (N + E I (π/L)²)/(ρ A)`.

use std::f64::consts::PI;

use tegula::analysis::{Silent, modal, statics};
use tegula::compile::Compiler;
use tegula::mesh::generators::generate;
use tegula::model::{
    Analysis, AnalysisStep, Axis, Condition, FixComponents, Isotropic, Load, MeshSource, ModalAnalysis,
    Model, OnSet, PlateMesh, StaticAnalysis, VectorLoad,
};

const LENGTH: f64 = 1.0;
const THICKNESS: f64 = 0.01;
const YOUNG: f64 = 2.1e11;
const DENSITY: f64 = 7850.0;
/// Tension per width of the strip (N/m).
const TENSION: f64 = 2e5;

fn main() -> tegula::Result<()> {
    let mesh = MeshSource::Plate(PlateMesh::new([LENGTH, 0.1], [40, 4]));
    let options = StaticAnalysis::default();
    let steel = Isotropic::new(YOUNG, 0.0, DENSITY);
    let mut model = Model::new(mesh, Analysis::Static(options.clone()), steel, THICKNESS);
    let slides = FixComponents { on: "u_max".into(), position: vec![Axis::Y, Axis::Z], director: vec![] };
    model.conditions = vec![Condition::Hinge(OnSet::new("u_min")), Condition::Fix(slides)];
    let three = Analysis::Modal(ModalAnalysis::new(3));
    let pulled = AnalysisStep {
        loads: vec![Load::Edge(VectorLoad::new("u_max", [TENSION, 0.0, 0.0]))],
        ..AnalysisStep::new("tension", Analysis::Static(options.clone()))
    };
    model.steps =
        vec![AnalysisStep::new("unloaded", three.clone()), pulled, AnalysisStep::new("under tension", three)];

    let mesh = generate(&model.mesh)?;
    let compiler = Compiler::new(&model, &mesh)?;
    let unloaded = modal::run(&compiler.system(0, None)?, 3, None, &mut Silent)?;
    let end = statics::run(&compiler.system(1, None)?, &options, None, &mut Silent)?.state;
    let system = compiler.system(2, Some(end.end_of_step()))?;
    let stretched = modal::run(&system, 3, Some(&end), &mut Silent)?;

    for (name, tension, found) in [("unloaded", 0.0, unloaded), ("under tension", TENSION, stretched)] {
        let k2 = (PI / LENGTH).powi(2);
        let bending = YOUNG * THICKNESS.powi(3) / 12.0;
        let exact = (k2 * (tension + bending * k2) / (DENSITY * THICKNESS)).sqrt() / (2.0 * PI);
        let first = found.modes[0].frequency_hz;
        println!("{name:14} first frequency {first:8.3} Hz, beam theory {exact:8.3} Hz");
        assert!((first / exact - 1.0).abs() < 5e-3);
    }
    Ok(())
}
