//! How the cost of explicit steps grows with the mesh: processor time per step and memory per element.
//!
//! ```text
//! cargo run --release --example growth_explicit -- [STEPS [SIDES...]]
//! ```
//!
//! A clamped square plate of SIDES × SIDES elements (32, 128, 512 and 1000 unless given) vibrates for STEPS steps (20
//! unless given) at 0.9 of the critical step. Each mesh is computed in a process of its own, so that its peak memory is
//! its own. Times are of all threads, user and system, with the energies of every tenth step but without set-up; the exponent
//! is that of the least-squares line through the logarithms of time per step and number of elements.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

#[path = "growth/mod.rs"]
mod growth;

use std::time::Instant;

use growth::{child, cpu_seconds, peak_memory, refuse, slope};
use tegula::Result;
use tegula::analysis::{Observer, Step, dynamics};
use tegula::mesh::generators::generate;
use tegula::model::{
    Analysis, Condition, ExplicitScheme, Grid, InitialVelocity, Isotropic, MeshSource, Model, OnSet,
    PlateMesh, Scheme, TransientAnalysis,
};

fn main() {
    let mut arguments = std::env::args().skip(1);
    if let Some("--child") = std::env::args().nth(1).as_deref() {
        let numbers: Vec<u32> = std::env::args().skip(2).map(|a| a.parse().unwrap()).collect();
        return measure(numbers[0], u64::from(numbers[1]));
    }
    let number = |a: String| match a.parse::<u32>() {
        Ok(n) if n > 0 => n,
        _ => refuse(&format!("\"{a}\" is no number of steps, or of elements along a side")),
    };
    let steps = u64::from(arguments.next().map_or(20, number));
    let mut sides: Vec<u32> = arguments.map(number).collect();
    if sides.is_empty() {
        sides = vec![32, 128, 512, 1000];
    }
    println!(
        "| elements | set-up [s] | steps | CPU per step [s] | per element [µs] | peak memory [MB] | per element [kB] |"
    );
    println!("|---|---|---|---|---|---|---|");
    let mut points = Vec::new();
    for side in sides {
        // Small meshes take as many steps as make their time measurable.
        let elements = f64::from(side) * f64::from(side);
        let many = steps.max((2e6 / elements) as u64);
        let [setup, taken, cpu, memory] = child(&[&side.to_string(), &many.to_string()], None);
        println!(
            "| {elements:.0} | {setup:.2} | {taken:.0} | {cpu:.4e} | {:.3} | {:.0} | {:.2} |",
            1e6 * cpu / elements,
            memory / 1e6,
            1e-3 * memory / elements
        );
        points.push((elements.ln(), cpu.ln()));
    }
    if points.len() > 1 {
        println!("CPU per step grows with the number of elements to the power {:.3}", slope(&points));
    }
}

/// Processor time between the reports of an analysis.
#[derive(Default)]
struct Clock {
    /// Steps and processor time at the end of each report.
    reports: Vec<(u64, f64)>,
}

impl Observer for Clock {
    fn on_step(&mut self, step: &Step) -> Result<()> {
        self.reports.push((step.state.step, cpu_seconds()));
        Ok(())
    }
}

fn measure(side: u32, steps: u64) {
    let started = Instant::now();
    let mesh = MeshSource::Plate(PlateMesh {
        origin: [0.0; 3],
        u_axis: [1.0, 0.0, 0.0],
        v_axis: [0.0, 1.0, 0.0],
        size: [1.0, 1.0],
        grid: Grid::uniform(side, side),
    });
    let scheme = Scheme::Explicit(ExplicitScheme::default());
    let options = TransientAnalysis { scheme, ..TransientAnalysis::new(1.0) };
    let mut model = Model::new(mesh, Analysis::Transient(options), Isotropic::new(2.1e11, 0.3, 7850.0), 0.01);
    model.conditions = vec![Condition::Clamp(OnSet { on: "u_min".into() })];
    model.initial_velocities = vec![InitialVelocity {
        on: "all".into(),
        velocity: [0.0; 3],
        angular_velocity: [0.0, -1.0, 0.0],
        center: [0.0; 3],
    }];
    let system = tegula::compile::build(&model, &generate(&model.mesh).unwrap()).unwrap();
    let setup = started.elapsed().as_secs_f64();
    let Analysis::Transient(options) = &mut model.analysis else { return };
    // One step to learn its length, in a time that is shorter than any.
    options.end_time = 1e-12;
    let critical = dynamics::run(&system, options, None, &mut tegula::analysis::Silent)
        .unwrap()
        .statistics
        .critical_step;
    options.end_time = 0.9 * critical * steps as f64;
    let mut clock = Clock::default();
    let outcome = dynamics::run(&system, options, None, &mut clock).unwrap();
    let ((first, start), (last, end)) = (clock.reports[0], clock.reports[clock.reports.len() - 1]);
    println!(
        "{setup} {} {} {}",
        outcome.statistics.steps,
        (end - start) / (last - first) as f64,
        peak_memory()
    );
}
