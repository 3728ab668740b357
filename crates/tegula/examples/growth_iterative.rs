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
//! processor time is that of all threads, user and system. The exponents are those of the least-squares lines
//! through the logarithms.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

use std::process::Command;
use std::time::Instant;

use tegula::analysis::{Silent, statics};
use tegula::mesh::generators::generate;
use tegula::model::{
    Analysis, Condition, CylinderMesh, Grid, Isotropic, LinearSolver, Load, MeshSource, Model, OnSet,
    PlateMesh, StaticAnalysis, VectorLoad, build,
};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument = |k: usize, otherwise: &str| arguments.get(k).cloned().unwrap_or(otherwise.into());
    if argument(0, "") == "--child" {
        let (slenderness, side) = (arguments[2].parse().unwrap(), arguments[4].parse().unwrap());
        return measure(&arguments[1], slenderness, &arguments[3], side);
    }
    let (shape, slenderness, solver) = (argument(0, "plate"), argument(1, "100"), argument(2, "iterative"));
    let mut sides: Vec<u32> = arguments.iter().skip(3).map(|a| a.parse().unwrap()).collect();
    if sides.is_empty() {
        sides = vec![128, 256, 512, 1000];
    }
    println!(
        "| elements | unknowns | set-up [s] | time [s] | CPU [s] | CPU per element [µs] | Newton | CG | peak memory [MB] |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut points = [Vec::new(), Vec::new(), Vec::new()];
    for side in sides {
        let child = Command::new(std::env::current_exe().unwrap())
            .args(["--child", &shape, &slenderness, &solver, &side.to_string()])
            .env("RAYON_NUM_THREADS", "2")
            .output()
            .unwrap();
        let text = String::from_utf8(child.stdout).unwrap();
        let found: Vec<f64> = text.split_whitespace().filter_map(|w| w.parse().ok()).collect();
        let [unknowns, setup, time, cpu, newton, linear, memory] = found[..] else {
            eprintln!("{side} × {side}: {}", String::from_utf8_lossy(&child.stderr));
            std::process::exit(1);
        };
        let elements = f64::from(side).powi(2);
        println!(
            "| {elements:.0} | {unknowns:.0} | {setup:.2} | {time:.2} | {cpu:.2} | {:.1} | {newton} | {linear} | {:.0} |",
            1e6 * cpu / elements,
            memory / 1e6
        );
        for (points, value) in points.iter_mut().zip([time, cpu, memory]) {
            points.push((elements.ln(), value.ln()));
        }
    }
    if points[0].len() > 1 {
        for (points, what) in points.iter().zip(["time", "CPU", "peak memory"]) {
            println!("{what} grows with the number of elements to the power {:.3}", slope(points));
        }
    }
}

/// Slope of the least-squares line.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (x, y) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let sum = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>();
    sum(&|p| (p.0 - x) * (p.1 - y)) / sum(&|p| (p.0 - x).powi(2))
}

fn mesh(shape: &str, side: u32) -> MeshSource {
    let grid = Grid::uniform(side, side);
    if shape == "plate" {
        let (u_axis, v_axis) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        return MeshSource::Plate(PlateMesh { origin: [0.0; 3], u_axis, v_axis, size: [1.0, 1.0], grid });
    }
    MeshSource::Cylinder(CylinderMesh {
        center: [0.0, 0.0, 1.0],
        axis: [0.0, 1.0, 0.0],
        start: [0.0, 0.0, -1.0],
        radius: 1.0,
        angles: [0.0, -90.0],
        length: 1.0,
        grid,
    })
}

fn measure(shape: &str, slenderness: f64, solver: &str, side: u32) {
    let started = Instant::now();
    let linear_solver = match solver {
        "direct" => LinearSolver::Direct,
        _ => LinearSolver::Iterative,
    };
    let options = StaticAnalysis { linear: true, linear_solver, ..Default::default() };
    let material = Isotropic::new(2.1e11, 0.3, 1.0);
    let analysis = Analysis::Static(options.clone());
    let mut model = Model::new(mesh(shape, side), analysis, material, 1.0 / slenderness);
    model.conditions = vec![Condition::Clamp(OnSet { on: "u_min".into() })];
    let value = [0.0, 1.0, -1.0];
    model.loads = vec![Load::Edge(VectorLoad { on: "u_max".into(), value, amplitude: None })];
    let system = build::build(&model, &generate(&model.mesh).unwrap()).unwrap();
    let setup = started.elapsed().as_secs_f64();
    let (before, started) = (cpu_seconds(), Instant::now());
    let outcome = statics::run(&system, &options, None, &mut Silent).unwrap();
    println!(
        "{} {setup} {} {} {} {} {}",
        system.unknowns(),
        started.elapsed().as_secs_f64(),
        cpu_seconds() - before,
        outcome.statistics.iterations,
        outcome.statistics.linear_iterations,
        peak_memory()
    );
}

/// Processor time of all threads, user and system (s): `/proc/self/stat`, in hundredths of a second.
fn cpu_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap();
    let after_name = text.rsplit(')').next().unwrap();
    let ticks: f64 = after_name.split_whitespace().skip(11).take(2).map(|t| t.parse::<f64>().unwrap()).sum();
    ticks / 100.0
}

/// Largest memory of the process (bytes).
fn peak_memory() -> f64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = text.lines().find(|l| l.starts_with("VmHWM")).unwrap();
    1024.0 * line.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap()
}
