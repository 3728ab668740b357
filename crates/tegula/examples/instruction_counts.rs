//! Does a part of the element work of a Newton iteration a number of times, for instruction counts by callgrind.
//!
//! ```text
//! valgrind --tool=callgrind --callgrind-out-file=/dev/null target/release/examples/instruction_counts tangent 20
//! ```
//!
//! `scripts/count_instructions.py` takes the difference of two numbers of repetitions, which leaves out the set-up,
//! for each part, and compares with `benches/instructions.json`. Valgrind knows vector registers up to AVX2.
#![allow(clippy::unwrap_used)]

#[path = "../tests/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::loaded_quarter_cylinder;
use tegula::element::TangentWeights;
use tegula::model::ElementKind;
use tegula::system::assembly::TangentCoefficients;
use tegula::system::{Assembly, EvaluationPoint, System};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let part = arguments.next().unwrap();
    let times: usize = arguments.next().unwrap().parse().unwrap();
    let element = if part == "tangent-cm" { ElementKind::Cm } else { ElementKind::Ems };
    let system = loaded_quarter_cylinder(16, element);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().unwrap();
    pool.install(|| repeat(&system, &part, times));
}

fn repeat(system: &System, part: &str, times: usize) {
    let mut assembly = Assembly::new(system);
    let u = vec![[1e-3; 3]; system.vectors()];
    let mut forces = vec![[0.0; 3]; system.vectors()];
    let weights = TangentWeights::STATIC;
    let parts = TangentCoefficients { weights, mass: 0.0, time: 1.0 };
    let k = EvaluationPoint::at_rest(system, &u, 1.0, &[]);
    for _ in 0..times {
        match part {
            "force" => assembly.forces(system, black_box(&k), &mut forces),
            "tangent" | "tangent-cm" => assembly.element_work(system, black_box(&k), &parts, &mut forces),
            "tangent-and-scatter" => {
                assembly.forces_and_tangent(system, black_box(&k), &parts, true, None, &mut forces);
            }
            other => panic!("there is no part {other}"),
        }
    }
}
