//! How time and memory of static analyses with the iterative linear solver grow with the mesh.
//!
//! ```text
//! cargo run --release --example growth_iterative -- [plate|cylinder [SLENDERNESS [iterative|direct [SIDES...]]]]
//! ```
//!
//! SIDES × SIDES elements (128, 256, 512 and 1000 unless given) of a square plate or a quarter cylinder, clamped at
//! one edge and loaded at the other, length over thickness SLENDERNESS (100 unless given), under small
//! displacements, with the iterative or, to compare, the direct solver. Each mesh is computed on two threads in a
//! process of its own, so that its peak memory is its own. Times are from the compiled model to equilibrium;
//! processor time is that of all threads, and how much of it was spent in the system, which provides and clears the
//! pages of memory. The exponents are those of the least-squares lines through the logarithms.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "growth/mod.rs"]
mod growth;

use std::time::Instant;

use common::{compile, edge_loaded_shell};
use growth::{child, cpu_parts, peak_memory, refuse, slope};
use tegula::analysis::{Silent, statics};
use tegula::model::{Analysis, LinearSolver, StaticAnalysis};

fn main() {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let is_child = arguments.first().is_some_and(|a| a == "--child");
    if is_child {
        arguments.remove(0);
    }
    let argument = |k: usize, otherwise: &str| arguments.get(k).cloned().unwrap_or(otherwise.into());
    let (shape, slenderness, solver) = (argument(0, "plate"), argument(1, "100"), argument(2, "iterative"));
    let curved = match shape.as_str() {
        "plate" => false,
        "cylinder" => true,
        other => refuse(&format!("\"{other}\" is no shape; write plate or cylinder")),
    };
    let linear_solver = match solver.as_str() {
        "iterative" => LinearSolver::Iterative,
        "direct" => LinearSolver::Direct,
        other => refuse(&format!("\"{other}\" is no solver; write iterative or direct")),
    };
    let Some(ratio) = slenderness.parse::<f64>().ok().filter(|&s| s > 0.0 && s.is_finite()) else {
        refuse(&format!("\"{slenderness}\" is no slenderness; write length over thickness, such as 100"));
    };
    let side = |a: &String| match a.parse::<u32>() {
        Ok(side) if side > 0 => side,
        _ => refuse(&format!("\"{a}\" is no number of elements along a side")),
    };
    let mut sides: Vec<u32> = arguments.iter().skip(3).map(side).collect();
    if is_child {
        return sides.iter().for_each(|&side| measure(curved, ratio, linear_solver, side));
    }
    if sides.is_empty() {
        sides = vec![128, 256, 512, 1000];
    }
    println!(
        "| elements | unknowns | set-up [s] | time [s] | CPU [s] | system [s] | CPU per element [µs] | Newton | CG | peak memory [MB] |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let mut points: [Vec<_>; 4] = Default::default();
    for side in sides {
        let [unknowns, setup, time, program, in_system, newton, linear, memory] =
            child(&[&shape, &slenderness, &solver, &side.to_string()], Some(2));
        let elements = f64::from(side).powi(2);
        let cpu = program + in_system;
        println!(
            "| {elements:.0} | {unknowns:.0} | {setup:.2} | {time:.2} | {cpu:.2} | {in_system:.2} | {:.1} | {newton} | {linear} | {:.0} |",
            1e6 * cpu / elements,
            memory / 1e6
        );
        for (points, value) in points.iter_mut().zip([time, cpu, program, memory]) {
            points.push((elements.ln(), value.ln()));
        }
    }
    if points[0].len() > 1 {
        for (points, what) in points.iter().zip(["time", "CPU", "CPU without the system", "peak memory"]) {
            println!("{what} grows with the number of elements to the power {:.3}", slope(points));
        }
    }
}

fn measure(curved: bool, slenderness: f64, linear_solver: LinearSolver, side: u32) {
    let started = Instant::now();
    let options = StaticAnalysis { linear: true, linear_solver, ..Default::default() };
    let mut model = edge_loaded_shell(curved, side, slenderness, 0.0);
    model.analysis = Analysis::Static(options.clone());
    let system = compile(&model).1;
    let setup = started.elapsed().as_secs_f64();
    let (before, started) = (cpu_parts(), Instant::now());
    let outcome = statics::run(&system, &options, None, &mut Silent).unwrap();
    let seconds = started.elapsed().as_secs_f64();
    let after = cpu_parts();
    println!(
        "{} {setup} {seconds} {} {} {} {} {}",
        system.unknowns(),
        after[0] - before[0],
        after[1] - before[1],
        outcome.statistics.iterations,
        outcome.statistics.linear_iterations,
        peak_memory()
    );
}
