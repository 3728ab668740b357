//! Linear response of the base state to the loads of a buckling analysis: `K u₁ + Gᵀ λ₁ = ΔF − Δf(E) − K ū₁`, `G u₁ = 0`, with the change
//! of the external forces ΔF, of the internal forces under prescribed strains Δf(E), and prescribed displacements ū₁.

use super::problem::{Problem, TIMES};
use crate::analysis::constraints::Rates;
use crate::analysis::equilibrium;
use crate::analysis::newton::Newton;
use crate::analysis::potential::{Place, have_potential};
use crate::analysis::statics::{add, prescribed_increment};
use crate::element::{Motion, Nodal, TangentWeights};
use crate::norm::max_norm;
use crate::system::assembly::{TangentCoefficients, add_follower_stiffness};
use crate::system::{CirculatoryStiffness, EvaluationPoint, System};
use crate::{Error, Result};
use tegula_sparse::Factor as _;

/// Linear response to the loads.
pub(super) struct Increment {
    /// Displacements of all nodal vectors.
    pub displacements: Vec<Nodal>,
    /// Change of the multipliers of joints.
    pub multipliers: Vec<f64>,
    /// Change of the external forces.
    pub forces: Vec<Nodal>,
    /// Size of the right-hand side ([`System::force_norm`]) [force·length].
    pub size: f64,
}

impl Increment {
    /// Response of a problem whose stiffness is factored.
    ///
    /// # Errors
    /// The loads do not change, they do not belong to a buckling analysis, or the response is not finite.
    pub fn of(problem: &mut Problem) -> Result<Self> {
        let Problem { system, newton, state, .. } = problem;
        let system: &System = system;
        refuse(system)?;
        let [before, after] = TIMES.map(|time| EvaluationPoint { time, ..state.point(system) });
        let mut forces = equilibrium::external(system, &after);
        subtract(&mut forces, &equilibrium::external(system, &before));
        let mut right = forces.clone();
        let strained = strains_change(system);
        if strained {
            let mut internal = [before, after].map(|k| {
                let mut out = vec![[0.0; 3]; system.vectors()];
                newton.assembly.forces(system, &k, &mut out);
                out
            });
            let [of_base, of_end] = &mut internal;
            subtract(of_end, of_base);
            subtract(&mut right, of_end);
        }
        let mut displacements = vec![[0.0; 3]; system.vectors()];
        let moved = prescribed_increment(system, TIMES[1], &state.u, &mut displacements);
        if moved {
            newton.assembly.add_tangent_product(system, &before, &displacements, -1.0, &mut right);
            let parts = TangentCoefficients { weights: TangentWeights::STATIC, mass: 0.0, time: TIMES[0] };
            add_follower_stiffness(system, &before.motion, &parts, &displacements, &mut right);
        }
        if !moved && !strained && max_norm(forces.as_flattened()) == 0.0 {
            return Err(Error::Singular {
                what: "The loads of the buckling analysis are zero: there is nothing that load factors could multiply.".into(),
                help: "Check the values of the loads and of their amplitudes at load factor 1.".into(),
            });
        }
        refuse_circulatory_loads(system, newton, &state.u, &forces)?;
        let size = system.force_norm(&right);
        let mut free = vec![0.0; system.unknowns()];
        newton.assembly.frames.reduce(&right, &mut free);
        newton.solver.solve(&mut free);
        let mut multipliers = Vec::new();
        if let Some(constraints) = &mut newton.constraints {
            let at = (&before.motion, before.time);
            multipliers = constraints.project(system, at, Rates::Along(&displacements), &mut free).to_vec();
        }
        let mut response = vec![[0.0; 3]; system.vectors()];
        newton.assembly.frames.expand(&free, &mut response);
        add(&mut displacements, &response);
        if strained && relieved(system, newton, [&before, &after], &displacements) {
            return Err(Error::Singular {
                what: "The prescribed strains produce no stress under which the structure could buckle: it is free to follow them.".into(),
                help: "Support the structure so that it cannot expand, or leave the strains out.".into(),
            });
        }
        if !displacements.as_flattened().iter().chain(&multipliers).all(|x| x.is_finite()) {
            return Err(Error::Singular {
                what: "The linear response to the loads is not finite.".into(),
                help: "Check the values of loads and materials.".into(),
            });
        }
        Ok(Self { displacements, multipliers, forces, size })
    }
}

fn subtract(field: &mut [Nodal], other: &[Nodal]) {
    field.as_flattened_mut().iter_mut().zip(other.as_flattened()).for_each(|(x, y)| *x -= y);
}

/// Strain energy of a structure under prescribed strains over that of the same strains prevented, below which its stresses are round-off.
const RELIEVED: f64 = 1e-16;

/// Whether a structure that begins without stress follows the prescribed strains freely.
fn relieved(
    system: &System,
    newton: &mut Newton,
    [before, after]: [&EvaluationPoint; 2],
    displacements: &[Nodal],
) -> bool {
    let mut energy = |k: &EvaluationPoint| newton.assembly.strain_energy(system, k);
    let mut moved = displacements.to_vec();
    let (Motion::State { u, .. } | Motion::Step { new: u, .. }) = before.motion;
    add(&mut moved, u);
    let motion = Motion::State { u: &moved, velocity: None };
    let end = energy(&EvaluationPoint { motion, linear: true, ..*after });
    energy(before) == 0.0 && end <= RELIEVED * energy(after)
}

/// Whether prescribed strains are among the loads.
fn strains_change(system: &System) -> bool {
    let [before, after] = TIMES;
    let mut strains = system.prescribed_strains.iter();
    strains.any(|strain| system.factor(&strain.factor, before) != system.factor(&strain.factor, after))
}

/// Refuses motions and springs whose effect is no load of constant proportion.
fn refuse(system: &System) -> Result<()> {
    let [before, after] = TIMES;
    let driven = system.joints.iter().find(|j| system.drive_value(j, before) != system.drive_value(j, after));
    if let Some(joint) = driven {
        return Err(Error::Singular {
            what: format!(
                "The drive of joint \"{}\" moves: load factors cannot multiply such a motion.",
                joint.name
            ),
            help: "Let the drive move in a static step before the buckling step, in which it stays.".into(),
        });
    }
    if system.has_actuators() {
        return Err(Error::Singular {
            what: "Springs with formulas in the time are no loads that factors could multiply.".into(),
            help: "Replace them by springs and forces.".into(),
        });
    }
    Ok(())
}

/// Refuses follower loads that have no potential: with the skew part of their stiffness the factors need not be real. Moments on bodies are judged
/// by the modes.
fn refuse_circulatory_loads(system: &System, newton: &Newton, u: &[Nodal], forces: &[Nodal]) -> Result<()> {
    for time in TIMES {
        let place = Place { u, time, frames: &newton.assembly.frames };
        let skew = CirculatoryStiffness::without_moments_on_bodies(system);
        if !have_potential(system, &place, skew, forces) {
            return Err(Error::Singular {
                what: "The follower loads have no potential: their load stiffness is not symmetric, and load factors of buckling need not \
                       exist (flutter)."
                    .into(),
                help: "Use loads of constant direction (`traction`, `edge`, `force`), or pressures on surfaces whose edges are supported \
                       across their pressure, which have a potential; or run a transient analysis."
                    .into(),
            });
        }
    }
    Ok(())
}
