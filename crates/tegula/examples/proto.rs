//! How time and memory of the iterative solver grow with the number of elements.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

#[path = "../tests/common/mod.rs"]
mod common;


use common::{model, plate, quarter_cylinder, vector_load, compile};
use tegula::analysis::statics::state_kinematics;
use tegula::element::TangentWeights;
use tegula::linear::substructures::{Options, Scaling, Wanted};
use tegula::linear::{Factor, SparseCholesky, SymmetricPattern};
use tegula::model::*;
use tegula::system::Assembly;
use tegula::system::assembly::TangentParts;

fn main() {
    let a: Vec<String> = std::env::args().skip(1).collect();
    // shape slenderness side size reach scaling direct
    let shape = a[0].as_str();
    let slenderness: f64 = a[1].parse().unwrap();
    let n: u32 = a[2].parse().unwrap();
    let size: usize = a[3].parse().unwrap();
    let reach: usize = a[4].parse().unwrap();
    let scaling = match a[5].as_str() { "a" => Scaling::Alike, "s" => Scaling::Stiffness, _ => Scaling::Deluxe };
    rayon::ThreadPoolBuilder::new().num_threads(2).build_global().unwrap();
    let mut m = match shape {
        "plate" => model(plate([1.0, 1.0], [n, n], 0.0), 2.1e11, 0.01),
        "distorted" => model(plate([1.0, 1.0], [n, n], 0.3), 2.1e11, 0.01),
        _ => quarter_cylinder(n, 2.1e11),
    };
    m.sections[0].thickness = 1.0 / slenderness;
    m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 1.0, -1.0]))];
    m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
    let start = cpu();
    let system = compile(&m).1;
    let build = cpu() - start;
    let u = vec![[0.0; 3]; system.vectors()];
    let mut assembly = Assembly::new(&system);
    let weights = TangentWeights { stress: 1.0, direction: 1.0, force: 1.0, rate: 0.0 };
    let parts = TangentParts { weights, mass: 0.0, time: 1.0 };
    let k = state_kinematics(&system, &u, 1.0);
    let mut load = vec![0.0; system.unknowns()];
    let mut field = u.clone();
    system.add_dead_loads(1.0, 1.0, &mut field);
    system.numbering.reduce(&field, &mut load);
    let start = cpu();
    let mut s = system.substructures(&Options { size, reach, scaling }).unwrap();
    let setup = cpu() - start;
    let start = cpu();
    s.begin();
    let mut term = 0;
    let mut forces = u.clone();
    assembly.forces_and_blocks(&system, &k, &parts, (false, None), &mut forces, |blocks| {
        s.put(term, blocks);
        term += 1;
    });
    let assembled = cpu() - start;
    let start = cpu();
    s.factor(&system.numbering).unwrap();
    let factored = cpu() - start;
    let start = cpu();
    let mut x = load.clone();
    let c = s.solve(&mut x, &Wanted { relative: 1e-10, absolute: 0.0, share: 1.0, iterations: 200 });
    let solved = cpu() - start;
    println!(
        "{shape} {slenderness} {n} size {size} reach {reach} {scaling:?}: pieces {} border {} coarse {}; build {build:.2} setup {setup:.2} assemble {assembled:.2} factor {factored:.2} solve {solved:.2} {:.0} MB; {c:?}",
        s.pieces(), s.border_unknowns(), s.coarse_unknowns(), s.bytes() as f64 / 1e6
    );
    if a.len() > 6 {
        assembly.forces_and_tangent(&system, &k, &parts, false, None, &mut forces);
        let start = cpu();
        let mut direct = SparseCholesky::new(SymmetricPattern::new(system.pattern.column_pointers.clone(), system.pattern.row_indices.clone())).unwrap();
        let analysis = cpu() - start;
        direct.factor(&assembly.values).unwrap();
        let mut y = load.clone();
        direct.solve(&mut y);
        let time = cpu() - start;
        let e: Vec<f64> = x.iter().zip(&y).map(|(a, b)| a - b).collect();
        let energy = |v: &[f64]| { let mut w = vec![0.0; v.len()]; direct.pattern().add_product(&assembly.values, v, &mut w); v.iter().zip(&w).map(|(a, b)| a * b).sum::<f64>() };
        let residual = |v: &[f64]| { let mut w = vec![0.0; v.len()]; direct.pattern().add_product(&assembly.values, v, &mut w); w.iter().zip(&load).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt() / load.iter().map(|b| b*b).sum::<f64>().sqrt() };
        println!("   direct {time:.2} s (analysis {analysis:.2}), {:.0} MB, energy difference {:.1e}, residual {:.1e} direct {:.1e}", direct.factor_entries() as f64 * 8e-6, (energy(&e).abs() / energy(&y)).sqrt(), residual(&x), residual(&y));
    }
}

fn cpu() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap();
    let after_name = text.rsplit(')').next().unwrap();
    let ticks: f64 = after_name.split_whitespace().skip(11).take(2).map(|t| t.parse::<f64>().unwrap()).sum();
    ticks / 100.0
}
