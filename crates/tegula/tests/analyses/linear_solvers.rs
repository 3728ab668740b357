//! Linear solvers: iterations, accuracy and refusals of BDDC, and the cost of a factorisation.

use std::sync::{Arc, Barrier, Mutex};

use crate::common::{
    compile, edge_loaded_shell, irregular, loaded_quarter_cylinder, model, plate, vector_load,
};
use tegula::System;
use tegula::bddc::{Bddc, BddcError, Convergence, Options, Ranks, StoppingCriterion};
use tegula::compile::build;
use tegula::element::TangentWeights;
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::system::assembly::TangentCoefficients;
use tegula::system::{Assembly, EvaluationPoint};
use tegula_sparse::{Factor as _, SparseLdlt, SymmetricPattern};

const TIGHT: StoppingCriterion =
    StoppingCriterion { relative: 1e-10, absolute: 0.0, share: 1.0, iterations: 100 };

/// Stiffness by subdomains, load, and assembled stiffness.
struct Problem {
    system: System,
    bddc: Bddc,
    load: Vec<f64>,
    pattern: SymmetricPattern,
    values: Vec<f64>,
}

impl Problem {
    fn new(system: System, options: &Options) -> Self {
        Self::on_ranks(system, options, None)
    }

    fn on_ranks(system: System, options: &Options, ranks: Option<Arc<dyn Ranks>>) -> Self {
        let bddc = system.bddc_on_ranks(options, ranks).unwrap();
        let mut load = vec![0.0; system.unknowns()];
        let mut field = vec![[0.0; 3]; system.vectors()];
        system.add_dead_loads(1.0, 1.0, &mut field);
        system.frames.reduce(&field, &mut load);
        let mut assembly = Assembly::new(&system);
        let u = vec![[0.0; 3]; system.vectors()];
        let k = EvaluationPoint::at_rest(&system, &u, 1.0, &[]);
        assembly.forces_and_tangent(&system, &k, &parts(), false, None, &mut field);
        let pattern = system.tangent_pattern();
        let mut out = Self { bddc, load, pattern, values: assembly.values, system };
        out.assemble();
        out
    }

    /// Gives the element terms to BDDC; returns how many numbers each has.
    fn assemble(&mut self) -> Vec<usize> {
        let u = vec![[0.0; 3]; self.system.vectors()];
        let k = EvaluationPoint::at_rest(&self.system, &u, 1.0, &[]);
        let (mut size, mut forces) = (Vec::new(), u.clone());
        self.bddc.begin();
        let bddc = &mut self.bddc;
        let take = |blocks: &[f64]| {
            bddc.put(size.len(), blocks);
            size.push(blocks.len());
        };
        Assembly::new(&self.system).forces_and_blocks(
            &self.system,
            &k,
            &parts(),
            (false, None),
            &mut forces,
            take,
        );
        size
    }

    fn solve_factored(&mut self) -> Result<Vec<f64>, BddcError> {
        let mut x = self.load.clone();
        self.bddc.solve(&mut x, &TIGHT)?;
        Ok(x)
    }

    fn solve(&mut self, wanted: &StoppingCriterion) -> Result<(Vec<f64>, Convergence), BddcError> {
        self.bddc.factor(&self.system.frames)?;
        let mut x = self.load.clone();
        let convergence = self.bddc.solve(&mut x, wanted)?;
        Ok((x, convergence))
    }

    fn energy(&self, x: &[f64]) -> f64 {
        let mut y = vec![0.0; x.len()];
        self.pattern.add_product(&self.values, x, &mut y);
        x.iter().zip(&y).map(|(x, y)| x * y).sum()
    }

    /// Difference from the direct solution relative to it, in the energy norm.
    fn difference(&self, x: &[f64]) -> f64 {
        let mut direct = SparseLdlt::new(&self.pattern).unwrap();
        direct.factor(&self.values).unwrap();
        let mut exact = self.load.clone();
        direct.solve(&mut exact);
        let e: Vec<f64> = x.iter().zip(&exact).map(|(a, b)| a - b).collect();
        (self.energy(&e).abs() / self.energy(&exact)).sqrt()
    }
}

fn parts() -> TangentCoefficients {
    let weights = TangentWeights::STATIC;
    TangentCoefficients { weights, mass: 0.0, time: 1.0 }
}

fn problem(model: &Model) -> Problem {
    Problem::new(compile(model).1, &Options::default())
}

#[test]
#[ignore = "long"]
fn iterations_grow_neither_with_the_mesh_nor_with_slenderness() {
    for (curved, distortion) in [(false, 0.0), (false, 0.3), (true, 0.0)] {
        for slenderness in [10.0, 100.0, 1000.0] {
            for n in [24, 64] {
                let mut p = problem(&edge_loaded_shell(curved, n, slenderness, distortion));
                let (_, c) = p.solve(&TIGHT).unwrap();
                let what = format!("curved {curved}, distorted {distortion}, L/h {slenderness}, {n}: {c:?}");
                assert!(c.iterations <= 25 && c.condition < 8.0, "{what}");
            }
        }
    }
}

#[test]
fn the_error_is_what_was_wanted() {
    for relative in [1e-2, 1e-5, 1e-8] {
        let mut p = problem(&edge_loaded_shell(true, 48, 30.0, 0.0));
        let (x, c) = p.solve(&StoppingCriterion { relative, ..TIGHT }).unwrap();
        let found = p.difference(&x);
        assert!(found <= 1.1 * c.error / c.start && c.error <= relative * c.start, "{found:e} {c:?}");
    }
}

#[test]
fn rounding_of_very_thin_shells_is_accepted_and_told() {
    for (slenderness, limit) in [(1e3, 1.5e-8), (1e4, 1e-5)] {
        let mut p = problem(&edge_loaded_shell(true, 48, slenderness, 0.0));
        let (_, c) = p.solve(&TIGHT).unwrap();
        let reached = c.error / c.start;
        assert!(reached > TIGHT.relative && reached <= limit, "L/h {slenderness}: {c:?}");
    }
}

#[test]
fn subdomains_of_any_size_give_the_same_solution() {
    let mut m = model(plate([1.0, 1.0], [1, 1], 0.0), 2.1e11, 0.01);
    m.loads = vec![Load::Edge(vector_load("u_max", [0.0, 1.0, -1.0]))];
    let mesh = irregular(10);
    for (size, reach) in [(1, 1), (2, 3), (5, 1), (17, 2), (60, 9), (60, 1000), (10_000, 3)] {
        let options = Options { size, reach };
        let mut p = Problem::new(build(&m, &mesh).unwrap(), &options);
        let wanted = StoppingCriterion { iterations: 300, ..TIGHT };
        let (x, c) = p.solve(&wanted).unwrap_or_else(|e| panic!("size {size}, reach {reach}: {e}"));
        let off = p.difference(&x);
        assert!(off < 1e-8, "size {size}, reach {reach}: {off:e}, {c:?}");
    }
}

/// Ranks that are threads of this process.
struct Threads {
    rank: usize,
    all: Arc<(Barrier, Mutex<Vec<f64>>)>,
    size: usize,
}

impl Ranks for Threads {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn gather(&self, values: &mut [f64], begins: &[usize]) -> Result<(), String> {
        let (barrier, whole) = &*self.all;
        assert_eq!(begins.len(), self.size + 1);
        assert_eq!(begins[self.size], values.len());
        whole.lock().unwrap().resize(values.len(), f64::NAN);
        barrier.wait();
        let own = begins[self.rank]..begins[self.rank + 1];
        whole.lock().unwrap()[own.clone()].copy_from_slice(&values[own]);
        barrier.wait();
        values.copy_from_slice(&whole.lock().unwrap());
        barrier.wait();
        Ok(())
    }
}

/// Results of each of `size` ranks that are threads.
fn on_ranks<T: Send>(size: usize, find: impl Fn(Option<Arc<dyn Ranks>>) -> T + Sync) -> Vec<T> {
    let all = Arc::new((Barrier::new(size), Mutex::new(Vec::new())));
    std::thread::scope(|scope| {
        let ranks: Vec<_> = (0..size)
            .map(|rank| {
                let (find, all) = (&find, all.clone());
                scope.spawn(move || find(Some(Arc::new(Threads { rank, all, size }))))
            })
            .collect();
        ranks.into_iter().map(|rank| rank.join().unwrap()).collect()
    })
}

/// Problem of 12 subdomains, of which the ranks have some each.
fn in_subdomains(ranks: Option<Arc<dyn Ranks>>) -> Problem {
    let model = edge_loaded_shell(true, 24, 100.0, 0.2);
    Problem::on_ranks(compile(&model).1, &Options { size: 50, ..Options::default() }, ranks)
}

/// Subdomains are summed in their order wherever they are: all ranks have the solution of one process to the last bit, also where some have no subdomain.
#[test]
fn any_number_of_ranks_gives_the_same_bits() {
    let find = |ranks| {
        let mut p = in_subdomains(ranks);
        let first = p.solve(&TIGHT).unwrap();
        p.load.iter_mut().rev().step_by(3).for_each(|x| *x += 1.0);
        (first, p.solve_factored().unwrap())
    };
    let alone = find(None);
    assert!(alone.0.1.iterations > 5);
    for size in [1, 2, 3, 5, 20] {
        for found in on_ranks(size, find) {
            assert_eq!(found, alone, "{size} ranks");
        }
    }
}

/// A subdomain that one rank refuses ends all of them with one error, and the next matrix is solved. Blocks of a wrong size are seen by the rank alone that has
/// the subdomain, and all refuse the matrix.
#[test]
fn all_ranks_refuse_what_one_of_them_refuses() {
    let find = |ranks| {
        let mut p = in_subdomains(ranks);
        let (size, vectors) = (p.assemble(), p.system.vectors());
        let (mut errors, mut is_refused) = (Vec::new(), true);
        for term in [0, size.len() / 2, size.len() - 1] {
            p.assemble();
            p.bddc.put(term, &vec![f64::INFINITY; size[term]]);
            errors.push(p.bddc.factor(&p.system.frames).err());
            p.assemble();
            p.bddc.shift(vectors, (0..vectors).map(|v| (v, if v % 97 == term % 97 { -1e12 } else { 0.0 })));
            errors.push(p.bddc.factor(&p.system.frames).err());
            p.assemble();
            p.bddc.put(term, &[1.0]);
            is_refused &= p.bddc.factor(&p.system.frames).is_err();
        }
        p.assemble();
        (errors, is_refused, p.solve(&TIGHT).unwrap())
    };
    let alone = find(None);
    assert!(alone.0.iter().all(Option::is_some) && alone.1, "{:?}", alone.0);
    assert_eq!(alone.0[0], Some(BddcError::NotFinite));
    for found in on_ranks(3, find) {
        assert_eq!(found, alone);
    }
}

#[test]
fn units_do_not_change_the_iteration() {
    let metres = edge_loaded_shell(true, 40, 100.0, 0.0);
    let mut millimetres = metres.clone();
    if let MeshSource::Cylinder(c) = &mut millimetres.mesh {
        c.center = c.center.map(|x| 1000.0 * x);
        c.radius *= 1000.0;
        c.length *= 1000.0;
    }
    millimetres.sections[0].thickness *= 1000.0;
    let iterations = |model: &Model| {
        problem(model).solve(&StoppingCriterion { relative: 1e-8, ..TIGHT }).unwrap().1.iterations
    };
    assert_eq!(iterations(&metres), iterations(&millimetres));
}

#[test]
fn too_few_iterations_are_an_error_and_leave_the_right_side() {
    let mut p = problem(&edge_loaded_shell(false, 48, 100.0, 0.0));
    p.bddc.factor(&p.system.frames).unwrap();
    let mut x = p.load.clone();
    match p.bddc.solve(&mut x, &StoppingCriterion { iterations: 3, ..TIGHT }) {
        Err(BddcError::NotConverged { iterations: 3, residual, .. }) => {
            assert!(residual > 1e-10 && residual < 1.0);
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(x, p.load);
}

#[test]
#[ignore = "long"]
fn what_is_accepted_is_positive_definite() {
    let mut p = problem(&edge_loaded_shell(true, 40, 100.0, 0.0));
    let (stiffness, vectors) = (p.values.clone(), p.system.vectors());
    let scale = max_norm(p.pattern.diagonal(&stiffness));
    let (mut accepted, mut refused) = (0, 0);
    for exponent in 4..40 {
        let shift = -scale * 0.5_f64.powi(exponent);
        p.assemble();
        p.bddc.shift(vectors, (0..vectors).map(|v| (v, shift)));
        let found = p.solve(&TIGHT);
        let mut shifted = stiffness.clone();
        (0..vectors).for_each(|v| p.system.pattern.add_to_diagonal(v, shift, &p.system.frames, &mut shifted));
        let mut direct = SparseLdlt::new(&p.pattern).unwrap();
        let negative = direct.factor(&shifted).unwrap().negative;
        match found {
            Ok((x, _)) => {
                assert_eq!(negative, 0, "shift {shift:e}");
                p.values = shifted;
                let off = p.difference(&x);
                assert!(off < 1e-7, "shift {shift:e}: {off:e}");
                accepted += 1;
            }
            Err(BddcError::Indefinite(_)) => refused += 1,
            other => panic!("{other:?}"),
        }
    }
    assert!(accepted > 10 && refused > 10, "{accepted} {refused}");
}

#[test]
fn numbers_that_are_none_are_refused() {
    let mut p = problem(&edge_loaded_shell(false, 20, 100.0, 0.0));
    p.bddc.factor(&p.system.frames).unwrap();
    let mut x = vec![f64::NAN; p.load.len()];
    assert_eq!(p.bddc.solve(&mut x, &TIGHT), Err(BddcError::NotFinite));
    let size = p.assemble();
    p.bddc.put(7, &vec![f64::INFINITY; size[7]]);
    assert_eq!(p.bddc.factor(&p.system.frames), Err(BddcError::NotFinite));
    assert_eq!(p.solve_factored(), Err(BddcError::NotFactored));
    p.assemble();
    p.bddc.shift(p.system.vectors(), std::iter::once((0, f64::NAN)));
    assert_eq!(p.bddc.factor(&p.system.frames), Err(BddcError::NotFinite));
}

#[test]
fn nothing_is_solved_without_the_factors_of_a_whole_matrix() {
    let mut p = problem(&edge_loaded_shell(false, 20, 100.0, 0.0));
    let terms = p.assemble().len();
    let missing = |missing| Err(BddcError::Incomplete { missing, terms });
    // Assembled, but not factored.
    assert_eq!(p.solve_factored(), Err(BddcError::NotFactored));
    p.bddc.factor(&p.system.frames).unwrap();
    let first = p.solve_factored().unwrap();
    // What was given is used up; the factors are gone with the attempt.
    assert_eq!(p.bddc.factor(&p.system.frames), missing(terms));
    assert_eq!(p.solve_factored(), Err(BddcError::NotFactored));
    // Begun, and nothing or a part given.
    p.assemble();
    p.bddc.factor(&p.system.frames).unwrap();
    p.bddc.begin();
    assert_eq!(p.solve_factored(), Err(BddcError::NotFactored));
    assert_eq!(p.bddc.factor(&p.system.frames), missing(terms));
    let size = p.assemble();
    p.bddc.begin();
    p.bddc.put(3, &vec![0.0; size[3]]);
    assert_eq!(p.bddc.factor(&p.system.frames), missing(terms - 1));
    // An indefinite matrix leaves no factors, and no shift for the next one.
    p.assemble();
    let vectors = p.system.vectors();
    let scale = max_norm(p.pattern.diagonal(&p.values));
    p.bddc.shift(vectors, (0..vectors).map(|v| (v, -scale)));
    let refused = p.bddc.factor(&p.system.frames);
    assert!(matches!(refused, Err(BddcError::Indefinite(_))), "{refused:?}");
    assert_eq!(p.solve_factored(), Err(BddcError::NotFactored));
    p.assemble();
    p.bddc.factor(&p.system.frames).unwrap();
    assert_eq!(p.solve_factored().unwrap(), first);
}

#[test]
fn nothing_is_solved_that_was_never_given() {
    let (_, system) = compile(&edge_loaded_shell(false, 20, 100.0, 0.0));
    let mut bddc = system.bddc(&Options::default()).unwrap();
    let mut x = vec![1.0; system.unknowns()];
    assert_eq!(bddc.solve(&mut x, &TIGHT), Err(BddcError::NotFactored));
    let refused = bddc.factor(&system.frames);
    assert!(matches!(refused, Err(BddcError::Incomplete { missing, terms }) if missing == terms));
}

#[test]
fn what_belongs_to_another_mesh_is_refused() {
    let mut p = problem(&edge_loaded_shell(false, 20, 100.0, 0.0));
    let wrong = |what, found, expected| BddcError::WrongSize { what, found, expected };
    p.bddc.factor(&p.system.frames).unwrap();
    let unknowns = p.load.len();
    assert_eq!(p.bddc.solve(&mut [1.0], &TIGHT), Err(wrong("the right side", 1, unknowns)));
    let size = p.assemble();
    p.bddc.put(size.len(), &[1.0; 9]);
    let refused = wrong("the list of terms", size.len() + 1, size.len());
    assert_eq!(p.bddc.factor(&p.system.frames), Err(refused));
    for length in [9, size[7] + 9] {
        p.assemble();
        p.bddc.put(7, &vec![1.0; length]);
        assert_eq!(p.bddc.factor(&p.system.frames), Err(wrong("a term", length, size[7])));
    }
    let vectors = p.system.vectors();
    for (count, vector) in [(vectors - 1, 0), (vectors, vectors)] {
        p.assemble();
        p.bddc.shift(count, std::iter::once((vector, 1.0)));
        let refused = p.bddc.factor(&p.system.frames);
        assert!(matches!(refused, Err(BddcError::WrongSize { expected, .. }) if expected == vectors));
    }
    let (_, other) = compile(&edge_loaded_shell(false, 21, 100.0, 0.0));
    p.assemble();
    let refused = wrong("the degree-of-freedom map", other.unknowns(), unknowns);
    assert_eq!(p.bddc.factor(&other.frames), Err(refused));
}

/// Entries and operations of the factor of a tangent follow from ordering and supernodes alone: what grows here makes every
/// solution slower.
#[test]
fn a_factorisation_costs_what_is_known() {
    let system = loaded_quarter_cylinder(48, ElementKind::Ems);
    let factor = SparseLdlt::new(&system.tangent_pattern()).unwrap();
    let (entries, operations) = (factor.factor_entries() as f64, factor.operations());
    let near = |a: f64, b: f64| (a - b).abs() < 0.01 * b;
    assert!(near(entries, 2_392_424.0) && near(operations, 477_210_096.0), "{entries} {operations}");
}
