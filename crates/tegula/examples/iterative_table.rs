//! Iterations of the iterative linear solver for shells of many kinds: the table of the book.
//!
//! ```text
//! cargo run --release --example iterative_table -- [SIDES...]
//! ```
//!
//! SIDES × SIDES elements (32, 64, 128 and 256 unless given; a minute) of a square plate, the same with its inner nodes
//! shifted by 0.3 elements, and a quarter cylinder, clamped at one edge and loaded at the other. The tangent of the
//! reference is solved to an error of 1e-10 in the energy norm. In brackets stands the condition that the coefficients
//! of the iteration show; the last line has the largest difference from the solution of the direct solver.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "growth/mod.rs"]
mod growth;

use common::{compile, edge_loaded_shell};
use growth::refuse;
use tegula::System;
use tegula::bddc::{Convergence, Options, StoppingCriterion};
use tegula::element::TangentWeights;
use tegula::system::assembly::TangentCoefficients;
use tegula::system::{Assembly, EvaluationPoint};
use tegula_sparse::{Factor as _, SparseLdlt};

const WANTED: StoppingCriterion =
    StoppingCriterion { relative: 1e-10, absolute: 0.0, share: 1.0, iterations: 500 };

fn main() {
    let side = |a: String| a.parse::<u32>().ok().filter(|&n| n > 0).ok_or(a);
    let mut sides: Vec<u32> = std::env::args()
        .skip(1)
        .map(|a| {
            side(a).unwrap_or_else(|a| refuse(&format!("\"{a}\" is no number of elements along a side")))
        })
        .collect();
    if sides.is_empty() {
        sides = vec![32, 64, 128, 256];
    }
    let heads: Vec<String> = sides.iter().map(|n| format!("{n} × {n}")).collect();
    println!("| | L/h | {} |\n|---|---:|{}", heads.join(" | "), "---:|".repeat(sides.len()));
    let mut largest = 0.0_f64;
    for (what, curved, distortion) in [
        ("plate", false, 0.0),
        ("plate, inner nodes shifted by 0.3 elements", false, 0.3),
        ("quarter cylinder", true, 0.0),
    ] {
        for slenderness in [10.0, 100.0, 1000.0] {
            let mut cells = Vec::new();
            for &n in &sides {
                let (convergence, difference) =
                    solve(&compile(&edge_loaded_shell(curved, n, slenderness, distortion)).1);
                cells.push(format!("{} ({:.1})", convergence.iterations, convergence.condition));
                largest = largest.max(difference);
            }
            println!("| {what} | {slenderness} | {} |", cells.join(" | "));
        }
    }
    println!("\nlargest difference from the direct solution, in the energy norm: {largest:.1e}");
}

/// Solves with the tangent of the reference; how it converged, and the difference from the direct solution over its
/// size, in the energy norm.
fn solve(system: &System) -> (Convergence, f64) {
    let u = vec![[0.0; 3]; system.vectors()];
    let mut field = u.clone();
    let mut load = vec![0.0; system.unknowns()];
    system.add_dead_loads(1.0, 1.0, &mut field);
    system.frames.reduce(&field, &mut load);

    let weights = TangentWeights::STATIC;
    let parts = TangentCoefficients { weights, mass: 0.0, time: 1.0 };
    let k = EvaluationPoint::at_rest(system, &u, 1.0, &[]);
    let mut assembly = Assembly::new(system);
    let mut pieces = system.bddc(&Options::default()).unwrap();
    pieces.begin();
    let mut term = 0;
    assembly.forces_and_blocks(system, &k, &parts, (false, None), &mut field, |blocks| {
        pieces.put(term, blocks);
        term += 1;
    });
    pieces.factor(&system.frames).unwrap();
    let mut x = load.clone();
    let convergence = pieces.solve(&mut x, &WANTED).unwrap();

    assembly.forces_and_tangent(system, &k, &parts, false, None, &mut field);
    let pattern = system.tangent_pattern();
    let mut direct = SparseLdlt::new(&pattern).unwrap();
    direct.factor(&assembly.values).unwrap();
    let mut exact = load;
    direct.solve(&mut exact);
    let energy = |x: &[f64]| {
        let mut y = vec![0.0; x.len()];
        pattern.add_product(&assembly.values, x, &mut y);
        x.iter().zip(&y).map(|(x, y)| x * y).sum::<f64>()
    };
    let error: Vec<f64> = x.iter().zip(&exact).map(|(a, b)| a - b).collect();
    (convergence, (energy(&error).abs() / energy(&exact)).sqrt())
}
