//! Eigenvalue problem `K φ = −λ K_σ φ` of linear buckling: matrices, factorisation, operators.

use super::increment::Increment;
use crate::analysis::newton::Newton;
use crate::analysis::{Observer, State, equilibrium, modal};
use crate::element::{Motion, Nodal, TangentWeights};
use crate::model::NewtonMethod;
use crate::system::assembly::LoadIncrement;
use crate::system::{EvaluationPoint, System};
use crate::{Error, Result};
use tegula_sparse::lanczos::SymmetricOperator;
use tegula_sparse::{Factor as _, SymmetricPattern};

/// Load factors between which the loads of the analysis grow. At the first one all loads and prescribed strains are those of the base state.
pub(super) const TIMES: [f64; 2] = [-1.0, 1.0];

/// Product `x·K_σ x` of a mode over the size of the loads and the square of that of the mode, below which it is round-off. Of a load that goes through the
/// structure it is about the inverse of the root of the number of nodes.
const WITHOUT_STRESS: f64 = 1e-13;

/// Error of a base state in which springs are stressed that joints do not balance.
fn out_of_balance() -> Error {
    Error::Singular {
        what: "Springs, torsion springs or bushings have forces where the analysis begins, which joints and supports do not balance: the \
               state is no equilibrium."
            .into(),
        help: "Let a static step find the equilibrium before this one, or give springs the `length` and torsion springs the \
               `free_angle` that they have at the start."
            .into(),
    }
}

/// Stiffness and geometric stiffness of the free degrees of freedom about the base state.
pub(super) struct Problem<'a> {
    pub system: &'a System,
    pub newton: Newton,
    pub pattern: SymmetricPattern,
    /// Tangent K of the base state, with the augmented Lagrangian of joints.
    pub stiffness: Vec<f64>,
    /// Geometric stiffness K_σ of the loads; empty before [`load`](Self::load).
    pub stress_stiffness: Vec<f64>,
    /// Base state.
    pub state: State,
    /// Applications of the inverse so far.
    pub applications: u64,
    /// Weight of the augmented Lagrangian of joints.
    penalty: f64,
    /// Size of the loads ([`Increment::size`]).
    load_size: f64,
    /// Whether the strain energy of a small motion is ½ δs·H δs: about a stress-free reference of linear materials, without springs.
    stress_free: bool,
    values: Vec<f64>,
}

impl<'a> Problem<'a> {
    /// Tangent of the state at which the analysis step starts.
    ///
    /// # Errors
    /// The factor does not fit in memory.
    pub fn new(system: &'a System) -> Result<Self> {
        let mut newton = Newton::new(system, Some(NewtonMethod::Displacement))?;
        let mut state = State { time: TIMES[0], ..State::first(system) };
        newton.count_turns(system, &state);
        let penalty = equilibrium::penalty(system, &mut newton.assembly, &state);
        if !system.continues() && modal::has_springs(system) {
            let unbalanced = equilibrium::unbalanced(system, &mut newton.assembly, &state);
            if !equilibrium::find_multipliers(system, &newton.assembly, &mut state, (&unbalanced, penalty)) {
                return Err(out_of_balance());
            }
        }
        let loads = equilibrium::external(system, &state.point(system));
        equilibrium::assemble_tangent(system, &mut newton.assembly, (&state, penalty), &loads);
        let stiffness = newton.assembly.values.clone();
        let linear = system.sections.iter().all(|s| s.section.is_linear());
        let stress_free = system.start.is_none() && linear && !modal::has_springs(system);
        Ok(Self {
            system,
            pattern: system.tangent_pattern(),
            values: vec![0.0; stiffness.len()],
            newton,
            stiffness,
            stress_stiffness: Vec::new(),
            state,
            applications: 0,
            penalty,
            load_size: 0.0,
            stress_free,
        })
    }

    /// Computes the linear response to the loads and its geometric stiffness, with the factor of K.
    ///
    /// # Errors
    /// The loads are zero or have no potential, or the geometric stiffness is not finite.
    pub fn load(&mut self) -> Result<()> {
        let increment = Increment::of(self)?;
        self.load_size = increment.size;
        let Self { system, newton, state, .. } = self;
        let increment = LoadIncrement {
            displacements: &increment.displacements,
            multipliers: &increment.multipliers,
            forces: &increment.forces,
            times: TIMES,
        };
        newton.assembly.stress_stiffness(system, &state.point(system), &increment);
        self.stress_stiffness = self.newton.assembly.values.clone();
        if self.stress_stiffness.iter().all(|x| x.is_finite()) {
            return Ok(());
        }
        Err(Error::Singular {
            what: "The geometric stiffness of the loads is not finite.".into(),
            help: "Check the values of loads and materials.".into(),
        })
    }

    /// Factors `K + s K_σ`; returns the number of its negative eigenvalues on the null space of the constraints, that of the load factors
    /// between 0 and s. `None` where the factorisation fails.
    pub fn factor(&mut self, s: f64) -> Option<usize> {
        self.values.copy_from_slice(&self.stiffness);
        if s != 0.0 {
            self.values.iter_mut().zip(&self.stress_stiffness).for_each(|(k, stress)| *k += s * stress);
        }
        let inertia = self.newton.solver.factor(&self.values).ok().filter(|i| i.zero == 0)?;
        let Newton { solver, constraints, assembly, .. } = &mut self.newton;
        let Some(constraints) = constraints else { return Some(inertia.negative) };
        let weights = TangentWeights { penalty: self.penalty, ..TangentWeights::STATIC };
        let at = (&self.state.point(self.system), &weights);
        constraints.take(self.system, at, &assembly.frames, solver).ok()?;
        inertia.negative.checked_sub(constraints.negative_eigenvalues())
    }

    /// Number of modes: free degrees of freedom that joints do not take.
    pub fn size(&self) -> usize {
        let constraints = self.newton.constraints.iter().flat_map(|constraints| constraints.independent());
        self.pattern.size().saturating_sub(constraints.count())
    }

    /// Changes a vector to one that keeps the joints closed.
    pub fn constrain(&mut self, x: &mut [f64]) {
        if let Some(constraints) = &mut self.newton.constraints {
            constraints.constrain(x);
        }
    }

    /// Solves with the present factor, with the joints closed.
    fn solve(&mut self, x: &mut [f64]) {
        self.newton.solver.solve(x);
        self.constrain(x);
        self.applications += 1;
    }

    /// Strain energy of a small motion from the base state, summed from its strains without cancellation; `None` where it is not
    /// known so.
    pub fn strain_energy(&mut self, shape: &[Nodal]) -> Option<f64> {
        let motion = Motion::State { u: shape, velocity: None };
        let k =
            EvaluationPoint { motion, linear: true, time: TIMES[0], internal: (&self.state.history).into() };
        self.stress_free.then(|| self.newton.assembly.strain_energy(self.system, &k))
    }

    /// Product `x·K_σ x`.
    pub fn stress_product(&self, x: &[f64]) -> f64 {
        let mut product = vec![0.0; x.len()];
        self.pattern.add_product(&self.stress_stiffness, x, &mut product);
        product.iter().zip(x).map(|(k, x)| k * x).sum()
    }

    /// Whether the product `x·K_σ x` of a mode, which is `shape` in all nodal vectors, is round-off of the loads: joints and supports take them without stress in
    /// the parts that the mode moves.
    pub fn is_without_stress(&self, x: &[f64], shape: &[Nodal]) -> bool {
        let size = self.load_size * self.system.inner_product(shape, shape);
        !(self.stress_product(x).abs() > WITHOUT_STRESS * size)
    }

    /// Round-off of `x·K x` over its value.
    pub fn round_off(&self, x: &[f64]) -> f64 {
        let sizes: Vec<f64> = x.iter().map(|x| x.abs()).collect();
        let stiffness: Vec<f64> = self.stiffness.iter().map(|k| k.abs()).collect();
        let (mut largest, mut product) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        self.pattern.add_product(&stiffness, &sizes, &mut largest);
        self.pattern.add_product(&self.stiffness, x, &mut product);
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        f64::EPSILON * sum(&largest, &sizes) / sum(&product, x)
    }
}

/// Operator in the inner product of K, with the present factor.
pub(super) struct Operator<'b, 'a> {
    pub problem: &'b mut Problem<'a>,
    /// `(K + σ K_σ)⁻¹ K` where the factor is shifted; else `−K⁻¹ K_σ`, whose eigenvalues are 1/λ.
    pub shifted: bool,
    pub watch: &'b dyn Observer,
}

impl SymmetricOperator for Operator<'_, '_> {
    fn size(&self) -> usize {
        self.problem.pattern.size()
    }

    fn apply(&mut self, k_x: &[f64], out: &mut [f64]) {
        out.copy_from_slice(k_x);
        self.problem.solve(out);
        if self.shifted {
            return;
        }
        let x = out.to_vec();
        out.fill(0.0);
        self.problem.pattern.add_product(&self.problem.stress_stiffness, &x, out);
        out.iter_mut().for_each(|y| *y = -*y);
        self.problem.solve(out);
    }

    fn inner(&self, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        self.problem.pattern.add_product(&self.problem.stiffness, x, out);
    }

    fn stopped(&self) -> bool {
        self.watch.interrupted()
    }
}
