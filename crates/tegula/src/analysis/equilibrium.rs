//! Residual, tangent stiffness and mass of a model as functions of a system and a state alone.
//!
//! Analyses keep factors and buffers from call to call; these functions are for programs that solve the equations in their
//! own way, and for tests. Vectors and matrices belong to the free degrees of freedom, along the axes of the local frames of
//! the state ([`frames`]).

use super::State;
use super::constraints::{Gradient, Schur, gradients_at, product, values_at};
use super::newton::retract;
use crate::Result;
use crate::constraint::{Quantity, Row};
use crate::element::{Motion, Nodal, TangentWeights};
use crate::system::assembly::{TangentCoefficients, add_follower_loads};
use crate::system::dof_map::{CONSTRAINED, DofMap};
use crate::system::{Assembly, EvaluationPoint, LocalFrames, System, VectorKind, add_multiple};
use std::collections::BTreeSet;
use tegula_sparse::SymmetricPattern;
use tegula_sparse::norm::larger;

/// Weight of the augmented Lagrangian over the largest force and the size of a model that has no stiffness but that of its loads.
const STIFFER: f64 = 10.0;

/// Local frames of a state: they transform fields of nodal vectors to free degrees of freedom and back.
pub fn frames(system: &System, state: &State) -> LocalFrames {
    let mut assembly = Assembly::for_forces(system);
    assembly.follow(system, &state.point(system));
    assembly.frames
}

/// Residual `F − f_int(u, v) − M (a + α v)` of the equations of motion at a state: external minus internal, inertia and
/// damping forces \[force\]. It vanishes at equilibria. Rates that the state lacks are zero.
pub fn residual(system: &System, state: &State) -> Vec<f64> {
    let mut assembly = Assembly::for_forces(system);
    let mut free = vec![0.0; system.unknowns()];
    let unbalanced = unbalanced(system, &mut assembly, state);
    assembly.frames.reduce(&unbalanced, &mut free);
    free
}

/// Tangent stiffness `∂(f_int − F)/∂u` at a state \[force/length\]: pattern and values of the lower triangle by columns. Of the
/// load stiffness of follower loads it holds the symmetric part;
/// [`CirculatoryStiffness`](crate::system::CirculatoryStiffness) is the skew one.
///
/// # Errors
/// The system was compiled for an analysis without a tangent: explicit steps, or statics with the iterative solver.
pub fn tangent(system: &System, state: &State) -> Result<(SymmetricPattern, Vec<f64>)> {
    system.require_tangent()?;
    let mut assembly = Assembly::new(system);
    assemble_tangent(system, &mut assembly, (state, 0.0), &external(system, &state.point(system)));
    Ok((system.tangent_pattern(), assembly.values))
}

/// Mass matrix at a state: values of the lower triangle in the pattern of [`tangent`].
///
/// # Errors
/// As for [`tangent`].
pub fn mass(system: &System, state: &State) -> Result<Vec<f64>> {
    system.require_tangent()?;
    let mut values = vec![0.0; system.pattern.values()];
    system.pattern.mass_values(&frames(system, state), &mut values);
    Ok(values)
}

/// Value `g(u)` of every constraint of joints at a state, in the order of [`State::multipliers`], with its gradient with respect to
/// the free degrees of freedom: their numbers, each once, and values. Constraint forces are `−Gᵀλ`. Relative coordinates with
/// friction or stops, whose constraints a force law may replace, have the value 0 and no gradient.
pub fn constraints(system: &System, state: &State) -> Vec<(f64, Gradient)> {
    let gradients = gradients_at(system, &frames(system, state), state);
    values_at(system, state).into_iter().zip(gradients).collect()
}

/// Displacements of the nodal vectors behind an increment of the free degrees of freedom from a state. Inextensible directors and
/// rigid bodies turn by the exponential map; in linear models the increment is added.
pub fn moved(system: &System, state: &State, increment: &[f64]) -> Vec<Nodal> {
    let frames = frames(system, state);
    let mut change = vec![[0.0; 3]; system.vectors()];
    frames.expand(increment, &mut change);
    if !system.linear {
        retract(system, &frames, &Motion::State { u: &state.u, velocity: None }, &mut change);
    }
    add_multiple(&mut change, 1.0, &state.u);
    change
}

/// Tangent stiffness at a state under the external forces `loads`, which act on inextensible directors and on bodies: values of the
/// assembly, whose local frames follow the state. `penalty` is the weight of the augmented Lagrangian of joints.
pub(super) fn assemble_tangent(
    system: &System,
    assembly: &mut Assembly,
    (state, penalty): (&State, f64),
    loads: &[Nodal],
) {
    assemble_parts(system, assembly, state, TangentWeights { penalty, ..TangentWeights::STATIC }, loads);
}

/// Geometric stiffness at a state: of stresses, of multipliers of joints, of the external forces `loads` and of follower loads.
pub(super) fn assemble_geometric(system: &System, assembly: &mut Assembly, state: &State, loads: &[Nodal]) {
    assemble_parts(system, assembly, state, TangentWeights::GEOMETRIC, loads);
}

fn assemble_parts(
    system: &System,
    assembly: &mut Assembly,
    state: &State,
    weights: TangentWeights,
    loads: &[Nodal],
) {
    let k = state.point(system);
    assembly.follow(system, &k);
    let parts = TangentCoefficients { weights, mass: 0.0, time: state.time };
    let mut internal = vec![[0.0; 3]; system.vectors()];
    assembly.forces_and_tangent(system, &k, &parts, false, None, &mut internal);
    assembly.add_curvature(system, &k, &parts.weights, loads);
    assembly.add_body_curvature(system, &k, &parts.weights, (false, loads));
}

/// Weight of the augmented Lagrangian of joints (force/length): mean stiffness of the free positions at a state, else that with which springs
/// resist displacements of joints by rotations, else one of the loads. It does not change the solution, but lets the tangent of parts that
/// joints alone hold have a factor.
pub(super) fn penalty(system: &System, assembly: &mut Assembly, state: &State) -> f64 {
    if system.joints.is_empty() {
        return 0.0;
    }
    if let Some(stiffness) = mean_stiffness(system, assembly, state) {
        return stiffness;
    }
    if let Some(stiffness) = stiffness_of_rotations(system, assembly, state) {
        return stiffness;
    }
    // Of bodies without springs loads alone make the stiffness. That of centrifugal forces, up to −Ω² M, must not cancel this weight.
    let forces = external(system, &EvaluationPoint::at_rest(system, &state.u, 1.0, state.internal()));
    let largest = forces.as_flattened().iter().map(|x| x.abs()).fold(0.0, larger);
    if largest > 0.0 && !system.centrifugal.is_empty() { STIFFER * largest / system.length } else { 1.0 }
}

/// Mean stiffness of the free positions at a state (force/length), if there is some.
pub(super) fn mean_stiffness(system: &System, assembly: &mut Assembly, state: &State) -> Option<f64> {
    assemble_tangent(system, assembly, (state, 0.0), &vec![[0.0; 3]; system.vectors()]);
    let (mut sum, mut count) = (0.0, 0);
    for number in unknowns_of(system, system.dofs(), VectorKind::Position) {
        sum += diagonal(system, assembly, number);
        count += 1;
    }
    (sum > 0.0).then(|| sum / f64::from(count))
}

/// Square of the size of a model over the shortest arms of joints that count.
const SHORT_ARMS: f64 = 1e6;

/// Free degrees of freedom of the vectors of a kind.
pub(super) fn unknowns_of<'a>(
    system: &'a System,
    dofs: &'a DofMap,
    kind: VectorKind,
) -> impl Iterator<Item = u32> + 'a {
    let vectors = (0..system.vectors()).filter(move |&v| system.coordinates.kinds[v] == kind);
    vectors.flat_map(move |v| dofs.of(v)).filter(|number| *number != CONSTRAINED)
}

fn diagonal(system: &System, assembly: &Assembly, number: u32) -> f64 {
    assembly.values[system.pattern.column_pointers[number as usize]].abs()
}

/// Stiffness with which bodies whose rotations alone are held by springs resist displacements of their joints; `None` without such bodies:
/// the harmonic mean of `1/Σ gᵢ²/kᵢ` over the constraints of positions, with the entries g of their gradients for rotations and the
/// diagonal k of the tangent. The arms of the joints decide. The square of the size of the model in place of the arms would make
/// it too small for short ones, and their constraints would look dependent.
fn stiffness_of_rotations(system: &System, assembly: &Assembly, state: &State) -> Option<f64> {
    let rotations: BTreeSet<u32> = unknowns_of(system, system.dofs(), VectorKind::Director).collect();
    let gradients = gradients_at(system, &assembly.frames, state);
    let rows = system.joints.iter().flat_map(|joint| joint.multipliers().zip(&joint.rows));
    let of_places = rows.filter(|(_, row)| row.keeps == Quantity::Position);
    let compliance = |(i, _): (usize, &Row)| {
        let of_entry = |(number, g): &(u32, f64)| {
            let stiffness =
                if rotations.contains(number) { diagonal(system, assembly, *number) } else { 0.0 };
            if stiffness > 0.0 { g * g / stiffness } else { 0.0 }
        };
        gradients[i].iter().map(of_entry).sum::<f64>()
    };
    let found: Vec<f64> = of_places.map(compliance).filter(|compliance| *compliance > 0.0).collect();
    let stiffnesses: Vec<f64> =
        rotations.iter().map(|number| diagonal(system, assembly, *number)).filter(|k| *k > 0.0).collect();
    if stiffnesses.is_empty() {
        return None;
    }
    let mean = stiffnesses.iter().sum::<f64>() / stiffnesses.len() as f64;
    let over_size = mean / (system.length * system.length);
    if found.is_empty() {
        return Some(over_size);
    }
    // Of joints in mass centres the arms are round-off.
    Some((found.len() as f64 / found.iter().sum::<f64>()).clamp(over_size, SHORT_ARMS * over_size))
}

/// Unbalanced forces over those that joints must balance, above which a state is no equilibrium; and over the stiffness times the size of the
/// model, below which they are round-off.
const UNBALANCED: [f64; 2] = [1e-9, 1e-12];

/// Finds the multipliers of joints that balance forces `unbalanced` on all nodal vectors of a state best: springs that are stressed in the
/// reference configuration load the joints there. The local frames of `assembly` follow the state. Returns whether joints balance the
/// forces, of which those below the round-off of a stiffness `penalty` are none.
pub(super) fn find_multipliers(
    system: &System,
    assembly: &Assembly,
    state: &mut State,
    (unbalanced, penalty): (&[Nodal], f64),
) -> bool {
    let mut free = vec![0.0; system.unknowns()];
    assembly.frames.reduce(unbalanced, &mut free);
    // Forces times the length of the model and moments count alike.
    let mut scales = vec![1.0; free.len()];
    for number in unknowns_of(system, assembly.frames.dofs(), VectorKind::Position) {
        scales[number as usize] = system.length * system.length;
    }
    let size = |x: &[f64]| x.iter().zip(&scales).map(|(x, s)| x * x * s).sum::<f64>().sqrt();
    let whole = size(&free);
    if whole == 0.0 {
        return true;
    }
    let gradients = gradients_at(system, &assembly.frames, state);
    let m = gradients.len();
    let mut schur = Schur::new(m);
    let mut right = vec![0.0; m];
    let weighted: Vec<f64> = free.iter().zip(&scales).map(|(x, s)| x * s).collect();
    let mut dense = vec![0.0; free.len()];
    for (i, gradient) in gradients.iter().enumerate() {
        gradient.iter().for_each(|&(n, g)| dense[n as usize] = g * scales[n as usize]);
        for (j, other) in gradients.iter().enumerate() {
            schur.matrix[i * m + j] = product(other, &dense);
        }
        right[i] = product(gradient, &weighted);
        gradient.iter().for_each(|&(n, _)| dense[n as usize] = 0.0);
    }
    if m > 0 {
        schur.factor();
        schur.solve(&mut right, &[], &mut state.multipliers);
    }
    for (gradient, multiplier) in gradients.iter().zip(&state.multipliers) {
        gradient.iter().for_each(|&(n, g)| free[n as usize] -= g * multiplier);
    }
    let round_off = UNBALANCED[1] * penalty * system.length * system.length;
    size(&free) <= larger(UNBALANCED[0] * whole, round_off)
}

/// Unbalanced forces `F − f_int(u, v) − M (a + α v)` of a state on all nodal vectors. The assembly's local frames follow the
/// state.
pub(super) fn unbalanced(system: &System, assembly: &mut Assembly, state: &State) -> Vec<Nodal> {
    let k = state.point_with_rates(system);
    assembly.follow(system, &k);
    let mut internal = vec![[0.0; 3]; system.vectors()];
    assembly.forces(system, &k, &mut internal);
    let mut out = external(system, &k);
    for (factor, rate) in [(-1.0, &state.a), (-system.mass_damping, &state.v)] {
        if !rate.is_empty() {
            system.pattern.add_mass_product(factor, rate, &mut out);
        }
    }
    for (out, internal) in out.as_flattened_mut().iter_mut().zip(internal.as_flattened()) {
        *out -= internal;
    }
    out
}

/// Unbalanced force of a state over its forces, where it is above `least`, and above the round-off of the forces that are yet to come, whose product with the
/// size of the model is `to_come`; `None` where the state is an equilibrium.
pub(super) fn imbalance(
    system: &System,
    assembly: &mut Assembly,
    state: &State,
    (least, to_come): (f64, f64),
) -> Option<f64> {
    let unbalanced = unbalanced(system, assembly, state);
    let external = external(system, &state.point(system));
    let mut free = vec![0.0; system.unknowns()];
    assembly.frames.reduce(&unbalanced, &mut free);
    let mut internal = external.clone();
    add_multiple(&mut internal, -1.0, &unbalanced);
    let size = larger(system.force_norm(&external), system.force_norm(&internal));
    let mut left = unbalanced;
    assembly.frames.expand(&free, &mut left);
    let largest = system.force_norm(&left);
    if largest <= larger(least * size, UNBALANCED[1] * to_come) {
        return None;
    }
    // Without stress, as where prescribed strains have bent the model freely, all forces are round-off.
    let stiffness = mean_stiffness(system, assembly, state).unwrap_or(0.0);
    let is_equilibrium = largest <= UNBALANCED[1] * stiffness * system.length * system.length;
    (!is_equilibrium).then_some(largest / size)
}

/// External forces at an evaluation point.
pub(super) fn external(system: &System, k: &EvaluationPoint) -> Vec<Nodal> {
    let mut out = vec![[0.0; 3]; system.vectors()];
    system.add_dead_loads(k.time, 1.0, &mut out);
    add_follower_loads(system, &k.motion, k.time, 1.0, &mut out);
    out
}
