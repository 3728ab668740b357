//! Times two ways to solve with the unsymmetric tangent of follower loads: the symmetric factor with GMRES, and an
//! unsymmetric factorisation.
//!
//! ```text
//! cargo run --release --manifest-path benches/faer/Cargo.toml --example follower_solvers
//! ```
//!
//! The model is a strip of 10 × 1 × 0.1 under a pressure that follows it, in 20 load steps. For each mesh it prints a row of a
//! table: unknowns, Newton iterations, additional solutions that GMRES takes in one of them, additional solutions of a step
//! that decide on stability, and, for the tangent at the full load, milliseconds of the symmetric factorisation, of one
//! solution, and of a sparse LU factorisation of the whole tangent with faer (its analysis is left out). One thread; times
//! are the least of three.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

#[path = "../../../crates/tegula/tests/common/mod.rs"]
mod common;

use std::time::Instant;

use common::{compile, model, plate};
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMat, Triplet};
use tegula::analysis::{Observer, Step, statics};
use tegula::element::TangentWeights;
use tegula::model::*;
use tegula::system::assembly::{TangentCoefficients, add_follower_loads};
use tegula::system::{Assembly, CirculatoryStiffness, EvaluationPoint};
use tegula_sparse::{Factor, SparseLdlt};

const PRESSURE: f64 = 5.0;
const REPETITIONS: usize = 3;

/// Newton iterations and all additional solutions so far, step by step.
#[derive(Default)]
struct Counts(Vec<(u64, u64)>);

impl Observer for Counts {
    fn on_step(&mut self, step: &Step) -> tegula::Result<()> {
        self.0.push((step.statistics.iterations, step.statistics.linear_iterations));
        Ok(())
    }
}

/// Steps before the one from which on the symmetric part of the tangent has a negative pivot.
const DEFINITE: usize = 14;

fn least(mut run: impl FnMut()) -> f64 {
    let time = |_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..REPETITIONS).map(time).min_by(f64::total_cmp).unwrap()
}

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().unwrap();
    faer::set_global_parallelism(faer::Par::Seq);
    for elements in [[40, 2], [80, 8], [160, 16], [320, 32]] {
        let mut m = model(plate([10.0, 1.0], elements, 0.0), 1.2e6, 0.1);
        m.loads = vec![Load::Pressure(PressureLoad {
            on: "all".into(),
            value: PRESSURE,
            amplitude: None,
            distribution: None,
        })];
        let options = StaticAnalysis { load_steps: 20, ..Default::default() };
        m.analysis = Analysis::Static(options.clone());
        let (_, system) = compile(&m);
        let mut counts = Counts::default();
        let outcome = statics::run(&system, &options, None, &mut counts).unwrap();

        let weights = TangentWeights::STATIC;
        let parts = TangentCoefficients { weights, mass: 0.0, time: 1.0 };
        let k = EvaluationPoint::at_rest(&system, &outcome.state.u, 1.0, &[]);
        let mut assembly = Assembly::new(&system);
        assembly.follow(&system, &k);
        let (mut forces, mut loads) = (vec![[0.0; 3]; system.vectors()], vec![[0.0; 3]; system.vectors()]);
        assembly.forces_and_tangent(&system, &k, &parts, false, None, &mut forces);
        add_follower_loads(&system, &k.motion, 1.0, 1.0, &mut loads);
        assembly.add_curvature(&system, &k, &weights, &loads);
        let mut skew = CirculatoryStiffness::new(&system);
        skew.take(&system, &k.motion, &parts);

        let pattern = system.tangent_pattern();
        let mut solver = SparseLdlt::new(&pattern).unwrap();
        let factorisation = least(|| {
            let _ = solver.factor(&assembly.values).unwrap();
        });
        let right = vec![1.0; system.unknowns()];
        let mut x = right.clone();
        let solution = least(|| {
            x.copy_from_slice(&right);
            solver.solve(&mut x);
        });

        // The whole tangent.
        let n = system.unknowns();
        let (pointers, rows) = pattern.columns();
        let mut entries = Vec::new();
        for column in 0..n {
            for at in pointers[column]..pointers[column + 1] {
                let row = rows[at] as usize;
                entries.push(Triplet::new(row, column, assembly.values[at]));
                if row != column {
                    entries.push(Triplet::new(column, row, assembly.values[at]));
                }
            }
        }
        let (mut unit, mut product) = (vec![0.0; n], vec![0.0; n]);
        for &column in skew.support() {
            unit[column as usize] = 1.0;
            skew.product(&assembly.frames, &unit, &mut product);
            unit[column as usize] = 0.0;
            let nonzero = product.iter().enumerate().filter(|(_, v)| **v != 0.0);
            entries.extend(nonzero.map(|(row, v)| Triplet::new(row, column as usize, *v)));
        }
        let whole = SparseColMat::try_new_from_triplets(n, n, &entries).unwrap();
        let symbolic = SymbolicLu::try_new(whole.symbolic()).unwrap();
        let mut factor = None;
        let unsymmetric =
            least(|| factor = Some(Lu::try_new_with_symbolic(symbolic.clone(), whole.as_ref()).unwrap()));
        // The factor is one of the whole tangent: its backward error is rounding.
        let b = faer::Col::from_fn(n, |i| right[i]);
        let y = factor.unwrap().solve(&b);
        let rest = &b - &whole * &y;
        let size = tegula::norm::max_norm(whole.val()) * y.norm_l2();
        assert!(rest.norm_l2() <= 1e-12 * size, "backward error {:e}", rest.norm_l2() / size);
        let (early, all) = (counts.0[DEFINITE - 1], counts.0[counts.0.len() - 1]);
        let each = early.1 as f64 / early.0 as f64;
        let late = (counts.0.len() - DEFINITE) as f64;
        let search = ((all.1 - early.1) as f64 - each * (all.0 - early.0) as f64) / late;
        println!(
            "| {} × {} | {n} | {} | {each:.1} | {search:.0} | {:.2} | {:.2} | {:.1} |",
            elements[0],
            elements[1],
            all.0,
            1e3 * factorisation,
            1e3 * solution,
            1e3 * unsymmetric,
        );
    }
}
