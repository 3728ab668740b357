//! Checkpoints: every number of a run is kept, and they serve their own model only.

use tegula::System;
use tegula::analysis::State;
use tegula::analysis::newton::PathTangent;
use tegula::analysis::path::{ArcStart, CriticalKind, CriticalPoint, ExpansionPoint, PathState};

use super::*;

/// A path with `n` nodal vectors in which no two numbers are equal.
fn distinct_path(n: usize, field: &mut dyn FnMut(usize) -> Vec<[f64; 3]>) -> PathState {
    let [position, load, _] = field(1)[0];
    let [start, expected, _] = field(1)[0];
    let (number, bifurcations) = (77, 78);
    let expansion = ExpansionPoint {
        position: start,
        u: field(n),
        load,
        direction: field(n),
        expected,
        number,
        bifurcations,
    };
    let [at, factor, _] = field(1)[0];
    let kind = CriticalKind::Bifurcation;
    let point = CriticalPoint { kind, load: factor, position: at, change: -2, u: field(n), mode: field(n) };
    let [rate, work, length] = field(1)[0];
    let tangent = PathTangent {
        direction: field(n),
        multipliers: field(1)[0].to_vec(),
        load: rate,
        work,
        determinant_sign: -1,
        crossings: Some(2),
    };
    PathState {
        position,
        load_rate: load,
        expansion,
        arc: Some(ArcStart { tangent, length }),
        direction: field(n),
        critical: vec![point],
        loads: [80.0, 81.0],
        flutters: true,
        finished: true,
    }
}

/// A memory in which no two numbers are equal.
fn distinct(system: &System) -> CheckpointData {
    let mut number = 0.0;
    let mut next = || {
        number += 1.0;
        number
    };
    let mut field =
        |count: usize| -> Vec<[f64; 3]> { (0..count).map(|_| [next(), next(), next()]).collect() };
    let (n, mut memory) = (system.vectors(), CheckpointData::default());
    let history = State::at_rest(system).history.len();
    assert!(history > 0);
    let state = &mut memory.state;
    for nodal in [
        &mut state.u,
        &mut state.v,
        &mut state.a,
        &mut state.mean_a,
        &mut state.scheme_v,
        &mut state.acceleration_lag,
        &mut state.mean_loads,
        &mut state.scheme_loads,
    ] {
        *nodal = field(n);
    }
    state.mean_rates = [field(n), field(n)];
    state.history = field(history).into_flattened()[..history].to_vec();
    [state.time, state.next_step, state.last_step] = field(1)[0];
    [state.work, state.dissipated, state.energy_scale] = field(1)[0];
    let tangent = &mut state.tangent;
    (tangent.u, tangent.v, tangent.valid) = (field(n), field(n), true);
    tangent.history = field(history).into_flattened()[..history].to_vec();
    [tangent.time, tangent.dt, _] = field(1)[0];
    (state.step, tangent.steps, tangent.iterations) = (71, 72, 73);
    (tangent.last, tangent.pause, tangent.next_pause) = (74, 75, 76);
    state.path = Some(Box::new(distinct_path(n, &mut field)));
    let balance = &mut memory.balance;
    [balance.kinetic, balance.strain, balance.potential] = field(1)[0];
    [balance.work, balance.dissipated, balance.total] = field(1)[0];
    (balance.momentum, balance.angular_momentum) = (field(1)[0], field(1)[0]);
    for _ in 0..2 {
        let values = field(1)[0].to_vec();
        let [time, place, _] = field(1)[0];
        memory.kept.push(StoredSnapshot { time, place, displacements: field(n), values });
    }
    let notes = &mut memory.notes;
    (notes.rows, notes.frames, notes.iterations, notes.factorizations) = (61, 62, 63, 64);
    (notes.cutbacks, notes.linear_iterations, notes.cpu_s) = (65, 66, Some(67.0));
    (notes.wall_s, notes.last_frame) = (68.0, 69.0);
    memory
}

#[test]
fn a_checkpoint_keeps_every_number_of_a_run() {
    let yielding = "type = \"plastic\"\nyield_stress = 1e4";
    let text = SWING.replace("SCHEME", "newmark").replacen("type = \"isotropic\"", yielding, 1);
    let prepared = prepare(&Deck::parse("swing.toml", text).unwrap()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("checkpoint.bin");
    let mut memory = distinct(&prepared.system);
    for valid in [true, false] {
        if !valid {
            let counts = &mut memory.state.tangent;
            (counts.valid, counts.u, counts.v, counts.history) = (false, vec![], vec![], vec![]);
        }
        memory.save(&path, 5).unwrap();
        let found = CheckpointData::load(&path, 5, &prepared.system).unwrap();
        assert!(found == memory, "{found:?}\nfor\n{memory:?}");
    }
}

#[test]
fn a_checkpoint_serves_its_own_model_only() {
    let folder = tempfile::tempdir().unwrap();
    run(&deck("newmark"), &options(folder.path(), false), &mut stop_after(3)).unwrap_err();
    let error = run(&deck("hht"), &options(folder.path(), true), &mut Unwatched).unwrap_err();
    assert!(error.to_string().contains("another model"), "{error}");
    // Refused before anything was touched.
    assert_eq!(Summary::read(folder.path()).unwrap().status, Status::Interrupted);
}
