//! Times the factorisation of a shell's tangent and writes the matrix for other programs.
//!
//! ```text
//! cargo run --release --example factor_times -- ELEMENTS THREADS [FILE]
//! ```
//!
//! It prints the number of unknowns, seconds of analysis, factorisation and solution, entries of the factor, and seconds
//! of the factorisation with as much off the diagonal that a few pivots are negative; and how many operations of the
//! factorisation take as long as one entry of the factor in a solution. Times but that of the analysis are the least of
//! five.
//!
//! The matrix is the reference tangent of the quarter cylinder of Sect. 5.2 with ELEMENTS × ELEMENTS elements. FILE gets
//! its lower triangle in compressed columns, little-endian: size n and number of entries, n + 1 column pointers, rows
//! (u64 each), values (f64).
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use common::loaded_quarter_cylinder;
use tegula::element::TangentWeights;
use tegula::model::ElementKind;
use tegula::system::assembly::TangentCoefficients;
use tegula::system::{Assembly, EvaluationPoint};
use tegula_sparse::{Factor, SparseLdlt};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize| arguments.get(k).and_then(|a| a.parse::<u32>().ok());
    let (Some(elements), Some(threads)) = (number(0), number(1)) else {
        eprintln!("give the number of elements along a side and the number of threads");
        std::process::exit(1);
    };
    rayon::ThreadPoolBuilder::new().num_threads(threads as usize).build_global().unwrap();
    let system = loaded_quarter_cylinder(elements, ElementKind::Ems);
    let mut assembly = Assembly::new(&system);
    let u = vec![[0.0; 3]; system.vectors()];
    let mut forces = u.clone();
    let weights = TangentWeights::STATIC;
    let parts = TangentCoefficients { weights, mass: 0.0, time: 1.0 };
    let k = EvaluationPoint::at_rest(&system, &u, 1.0, &[]);
    assembly.forces_and_tangent(&system, &k, &parts, false, None, &mut forces);
    let pattern = system.tangent_pattern();
    let (pointers, rows) = pattern.columns();
    if let Some(file) = arguments.get(2) {
        let mut bytes = Vec::new();
        let sizes = [system.unknowns(), rows.len()];
        for value in sizes.iter().chain(pointers.iter()) {
            bytes.extend((*value as u64).to_le_bytes());
        }
        for row in rows.iter() {
            bytes.extend(u64::from(*row).to_le_bytes());
        }
        bytes.extend(assembly.values.iter().flat_map(|v| v.to_le_bytes()));
        std::fs::write(file, bytes).unwrap();
    }
    let start = Instant::now();
    let mut solver = SparseLdlt::new(&pattern).unwrap();
    let analysis = start.elapsed().as_secs_f64();
    let best = |times: &mut dyn FnMut()| {
        (0..5)
            .map(|_| {
                let start = Instant::now();
                times();
                start.elapsed().as_secs_f64()
            })
            .fold(f64::INFINITY, f64::min)
    };
    let factor = best(&mut || assert_eq!(solver.factor(&assembly.values).unwrap().negative, 0));
    let mut x = vec![1.0; system.unknowns()];
    let solve = best(&mut || solver.solve(&mut x));
    // The softest motions made unstable, until there are negative pivots.
    let mut shift = f64::EPSILON * tegula::norm::max_norm(&assembly.values);
    let mut shifted;
    let negative = loop {
        shifted = assembly.values.clone();
        for j in 0..system.unknowns() {
            shifted[pointers[j]] -= shift;
        }
        match solver.factor(&shifted).unwrap().negative {
            0 => shift *= 4.0,
            n => break n,
        }
    };
    let indefinite = best(&mut || assert_eq!(solver.factor(&shifted).unwrap().negative, negative));
    println!(
        "{} {analysis:.6} {factor:.6} {solve:.6} {} {indefinite:.6} {:.0}",
        system.unknowns(),
        solver.factor_entries(),
        solver.operations() / solver.factor_entries() as f64 * solve / factor
    );
}
