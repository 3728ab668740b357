//! Times two ways to solve with the unsymmetric tangent of follower loads: the symmetric factor with GMRES, and an
//! unsymmetric factorisation.
//!
//! ```text
//! cargo run --release --example follower_solvers
//! ```
//!
//! The model is a strip of 10 × 1 × 0.1 under a pressure that follows it, in 20 load steps. For each mesh it prints unknowns,
//! Newton iterations, additional solutions that GMRES takes in one of them, and, for the tangent at the full load, seconds of
//! the symmetric factorisation, of one solution, and of a sparse LU factorisation of the whole tangent with faer (its
//! analysis is left out). One thread; times are the least of three.
#![allow(missing_docs, clippy::unwrap_used, clippy::print_stdout)]

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use common::{compile, model, plate};
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMat, Triplet};
use tegula::analysis::statics::{self, state_kinematics};
use tegula::analysis::{Observer, Step};
use tegula::element::TangentWeights;
use tegula::linear::{Factor, SparseCholesky};
use tegula::model::*;
use tegula::system::assembly::{TangentParts, add_follower_loads};
use tegula::system::{Assembly, CirculatoryStiffness};

const PRESSURE: f64 = 5.0;
const REPETITIONS: usize = 3;

/// Counts Newton iterations.
#[derive(Default)]
struct Iterations(u32);

impl Observer for Iterations {
    fn on_step(&mut self, step: &Step) -> tegula::Result<()> {
        self.0 += step.iterations;
        Ok(())
    }
}

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
        m.loads = vec![Load::Pressure(PressureLoad { on: "all".into(), value: PRESSURE, amplitude: None })];
        let options = StaticAnalysis { load_steps: 20, ..Default::default() };
        m.analysis = Analysis::Static(options.clone());
        let (_, system) = compile(&m);
        let mut iterations = Iterations::default();
        let outcome = statics::run(&system, &options, None, &mut iterations).unwrap();

        let weights = TangentWeights { stress: 1.0, direction: 1.0, force: 1.0, rate: 0.0 };
        let parts = TangentParts { weights, mass: 0.0, time: 1.0 };
        let k = state_kinematics(&system, &outcome.state.u, 1.0);
        let mut assembly = Assembly::new(&system);
        assembly.follow(&system, &k);
        let (mut forces, mut loads) = (vec![[0.0; 3]; system.vectors()], vec![[0.0; 3]; system.vectors()]);
        assembly.forces_and_tangent(&system, &k, &parts, false, None, &mut forces);
        add_follower_loads(&system, &k, 1.0, 1.0, &mut loads);
        assembly.add_curvature(&system, &k, &weights, &loads);
        let mut skew = CirculatoryStiffness::new(&system);
        skew.take(&system, &k, &parts);

        let pattern = system.tangent_pattern();
        let mut solver = SparseCholesky::new(&pattern).unwrap();
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
            skew.product(&assembly.numbering, &unit, &mut product);
            unit[column as usize] = 0.0;
            let nonzero = product.iter().enumerate().filter(|(_, v)| **v != 0.0);
            entries.extend(nonzero.map(|(row, v)| Triplet::new(row, column as usize, *v)));
        }
        let whole = SparseColMat::try_new_from_triplets(n, n, &entries).unwrap();
        let symbolic = SymbolicLu::try_new(whole.symbolic()).unwrap();
        let mut factor = None;
        let unsymmetric =
            least(|| factor = Some(Lu::try_new_with_symbolic(symbolic.clone(), whole.as_ref()).unwrap()));
        // Both solve the same equations: K x + N x of the solution with LU is the right side.
        let b = faer::Col::from_fn(n, |i| right[i]);
        let y = factor.unwrap().solve(&b);
        let rest = &b - &whole * &y;
        assert!(rest.norm_l2() <= 1e-8 * b.norm_l2(), "residual {:e}", rest.norm_l2());
        println!(
            "{}x{}: {n} unknowns, {} iterations, {:.1} additional solutions each; factorisation {:.2} ms, solution {:.2} ms, \
             LU {:.1} ms",
            elements[0],
            elements[1],
            iterations.0,
            outcome.statistics.linear_iterations as f64 / f64::from(iterations.0),
            1e3 * factorisation,
            1e3 * solution,
            1e3 * unsymmetric,
        );
    }
}
