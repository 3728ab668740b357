//! Failure of a load step: limit points, bifurcation points and other reasons why no equilibrium is found, and remedies.

use super::{State, enhanced};
use crate::analysis::modal::is_preloaded;
use crate::analysis::newton::{Cause, Diverged, SoftestMode};
use crate::analysis::path;
use crate::analysis::solver::SINGULAR;
use crate::element::Nodal;
use crate::model::{LinearSolver, NewtonMethod, PathAnalysis, StaticAnalysis};
use crate::system::{System, VectorKind, dot};

/// Energy of the softest mode over that of the whole response above which a critical point is a limit point: at a
/// bifurcation the loads do no work on the mode, but for round-off, which its softness amplifies.
const EXCITED: f64 = 1e-3;
/// Evidence of a limit point where a tangent of the iteration has negative pivots: the tangent at the last equilibrium
/// is this much softer than on the average of the path, and the softest mode is this share of its response, nearly the
/// whole.
const SOFTENED: f64 = 2.0;
const DOMINANT: f64 = 0.9;
/// Inverse of the largest part of the nodal vectors that a load may act on for its displacement to be prescribed
/// instead.
const FEW: usize = 4;

/// Kind of failure of a load step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// The iteration did not converge.
    Iteration(Cause),
    /// An element is inverted.
    Inverted,
    /// The equilibrium is unstable.
    Unstable,
    /// The tangent of the unloaded structure has negative pivots.
    Rounding,
    /// No stable path connects the equilibrium with the last one (snap-through).
    Leap,
}

/// Failure of a load step.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Failure {
    pub kind: Kind,
    /// Reason, as text.
    pub reason: String,
    /// Largest number of negative pivots of a tangent of the iteration.
    pub negative_pivots: usize,
}

impl From<Diverged> for Failure {
    fn from(d: Diverged) -> Self {
        Self::new(Kind::Iteration(d.cause), d.reason, d.most_negative_pivots)
    }
}

/// Limit or bifurcation point next to the last equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CriticalPoint {
    /// Whether it is a limit point; else it is a bifurcation point.
    limit: bool,
    mode: Vec<Nodal>,
    /// Share of the stiffness of the mode that enhanced strains remove, where it is known.
    enhanced: Option<f64>,
}

impl CriticalPoint {
    /// Critical point that a failure, the softest mode at the last equilibrium and the compliance there over that of
    /// the whole path indicate; `None` where they indicate none.
    pub fn of(failure: &Failure, mode: SoftestMode, softened: f64) -> Option<Self> {
        let proved = matches!(failure.kind, Kind::Unstable | Kind::Leap);
        let likely = softened > SOFTENED && mode.excited > DOMINANT;
        let limit = mode.energy > EXCITED;
        (proved || likely).then_some(Self { limit, mode: mode.shape, enhanced: None })
    }

    /// Finds the share of the enhanced strains of the elements in the stiffness of the mode.
    pub fn look_at_enhanced_strains(&mut self, system: &System, state: &State) {
        self.enhanced = enhanced::share(system, &state.u, &self.mode);
    }

    /// Text about the share of the enhanced strains in the mode.
    fn of_enhanced_strains(&self) -> String {
        match self.enhanced {
            Some(share) if share > enhanced::NOTEWORTHY => format!(
                "; enhanced strains remove {:.1} % of the material stiffness of this mode, which may be an hourglass mode \
                 of the elements: compare with `membrane = \"displacement\"` or a finer mesh",
                100.0 * share
            ),
            _ => String::new(),
        }
    }
}

impl Failure {
    pub fn new(kind: Kind, reason: String, negative_pivots: usize) -> Self {
        Self { kind, reason, negative_pivots }
    }

    /// Failure of a structure whose tangent has negative pivots without any stress, from round-off.
    pub fn of_rounding(system: &System, negative_pivots: usize) -> Self {
        let cause = if is_preloaded(system, &State::first(system)) {
            "which springs with forces from the start (`length`, `force`, `free`) can cause: they make the reference configuration unstable"
        } else if system.joints.is_empty() {
            "an effect of round-off: the matrix is ill-conditioned"
        } else {
            "an effect of round-off: joints leave a motion free that no stiffness resists (a mechanism), or the matrix is ill-conditioned"
        };
        let reason = format!(
            "the stiffness matrix of the unloaded structure has {negative_pivots} negative pivot(s), {cause}"
        );
        Self::new(Kind::Rounding, reason, 0)
    }

    /// Failure at a limit point of the equilibrium path.
    pub fn of_limit(load: f64) -> Self {
        let reason = format!(
            "the equilibrium path from the last equilibrium has a limit point at load factor {load:.6}"
        );
        Self::new(Kind::Leap, reason, 1)
    }

    /// Failure at a critical point of the equilibrium path, where this one is a singular tangent behind equilibria with regular ones.
    pub fn of_singular_equilibrium(&self, state: &State) -> Option<Self> {
        if self.kind != Kind::Iteration(Cause::Tangent) || self.reason != SINGULAR || state.step == 0 {
            return None;
        }
        let reason = format!(
            "the tangent is singular at or just behind load factor {:.6}, and regular at smaller loads: a limit point or bifurcation \
             point (buckling) is there",
            state.time
        );
        Some(Self::new(Kind::Unstable, reason, 0))
    }

    /// Whether the other form of Newton's method may find an equilibrium where this one has found none.
    pub fn depends_on_the_form(&self) -> bool {
        use Cause::{Flight, Iterations, Material, Stagnation};
        matches!(self.kind, Kind::Iteration(Flight | Iterations | Material | Stagnation))
    }

    /// Reason, with the negative pivots and the critical point between the last equilibrium and a load factor.
    pub fn told(
        &self,
        system: &System,
        state: &State,
        target: f64,
        critical: Option<&CriticalPoint>,
    ) -> String {
        let pivots = match self.negative_pivots {
            0 => String::new(),
            1 => "1 negative pivot".into(),
            n => format!("{n} negative pivots"),
        };
        let Some(critical) = critical else {
            return if pivots.is_empty() {
                self.reason.clone()
            } else {
                format!("{}; tangents of the iteration had up to {pivots}", self.reason)
            };
        };
        let what = if critical.limit { "limit point" } else { "bifurcation point (buckling)" };
        let with = if pivots.is_empty() { String::new() } else { format!("{pivots} of the tangent, ") };
        let largest = match place(system, &state.u) {
            Some((size, at)) => format!("the largest displacement is {size:.4e} {at}"),
            None => "all displacements are 0".into(),
        };
        let mode = place(system, &critical.mode)
            .map_or(String::new(), |(_, at)| format!(", its mode is largest {at}"));
        format!(
            "{what}: {with}between load factors {:.6} and {target:.6}; at {:.6} {largest}{mode}{}. The last attempt: {}",
            state.time,
            state.time,
            critical.of_enhanced_strains(),
            self.reason
        )
    }

    /// Advice that fits the model: nothing that is in use already, nothing that cannot be done.
    pub fn remedy(
        &self,
        system: &System,
        options: &StaticAnalysis,
        critical: Option<&CriticalPoint>,
    ) -> String {
        if let Some(critical) = critical {
            return if critical.limit {
                beyond_limit_point(system, options)
            } else {
                beyond_bifurcation(options)
            };
        }
        let cause = match self.kind {
            Kind::Inverted | Kind::Iteration(Cause::Material) => {
                return "Look at the loads and the thickness of this element, and at their units: a load \
                        beyond the load-carrying capacity of the shell inverts elements, too."
                    .into();
            }
            Kind::Unstable | Kind::Leap => return beyond_bifurcation(options),
            Kind::Rounding if !system.joints.is_empty() => {
                return "Check joints, bodies and beams: a modal analysis of the model shows motions that they leave free as modes of \
                        frequency zero. Without such modes look at elements of extreme aspect ratio, at moduli and at their units."
                    .into();
            }
            Kind::Rounding => {
                return "Look at elements of extreme aspect ratio (`tegula check` prints the largest), at thicknesses and at \
                        moduli, and at their units."
                    .into();
            }
            Kind::Iteration(cause) => cause,
        };
        if cause == Cause::Tangent {
            return match options.linear_solver {
                LinearSolver::Direct => {
                    "The model may have a mechanism: check the supports and joints, bodies and beams that they leave free to move, and \
                     sheets that share only one node."
                        .into()
                }
                LinearSolver::Iterative => {
                    "The direct solver (`linear_solver = \"direct\"`) counts negative pivots and distinguishes a critical \
                     point from missing supports."
                        .into()
                }
            };
        }
        let mut advice = Vec::new();
        if system.linear {
            advice.push(
                "The stiffness matrix is ill-conditioned: stiffnesses differ too much, or a part is nearly unsupported."
                    .to_owned(),
            );
        } else {
            if cause == Cause::Iterations {
                advice.push(format!(
                    "More iterations may suffice (`max_iterations`, now {}).",
                    options.max_iterations
                ));
            }
            if options.method.is_some() {
                advice.push(
                    "Without `method` the solver tries both mixed and displacement-based Newton.".into(),
                );
            }
            if options.max_cutbacks < 12 {
                advice.push(format!(
                    "Shorter steps may help (`load_steps`, now {}; `max_cutbacks`, now {}).",
                    options.load_steps, options.max_cutbacks
                ));
            }
        }
        advice.push("Look at the supports, loads and units at the place that is named.".into());
        advice.join(" ")
    }
}

/// Advice on how to pass a limit point, or the abrupt buckling of a nearly perfect structure.
fn beyond_limit_point(system: &System, options: &StaticAnalysis) -> String {
    let mut advice = past_the_limit(system);
    if path::outside_of_scope(system, &PathAnalysis::default()).is_none() {
        advice.push_str(
            " `continue = \"path\"` goes on along the equilibrium path to load factor 1; an analysis of `type = \"path\"` follows all \
             equilibria.",
        );
    }
    if options.max_cutbacks < 25 {
        advice.push_str(
            " A structure with a very small imperfection buckles almost as abruptly: use a larger imperfection, or more \
             `max_cutbacks`.",
        );
    }
    advice
}

/// Advice on how to pass a limit point of the path.
fn past_the_limit(system: &System) -> String {
    if !system.dofs().prescribed.is_empty() {
        return "Beyond it the structure snaps even under displacement control (snap-back); a transient analysis with some \
                damping follows the snap."
            .into();
    }
    let few = |load: &crate::system::DeadLoad| {
        let loaded = load.force.iter().filter(|f| dot(&[**f], &[**f]) > 0.0).count();
        !load.gravity && FEW * loaded <= load.force.len()
    };
    if !system.has_follower_loads() && system.dead_loads.iter().all(few) {
        "To pass it prescribe the displacement where the load acts (`prescribe`) instead of the force, or follow the snap \
         with a transient analysis with some damping."
            .into()
    } else {
        "A transient analysis with some damping follows the snap beyond it.".into()
    }
}

/// Advice on how to continue beyond a bifurcation point.
fn beyond_bifurcation(options: &StaticAnalysis) -> String {
    let mut advice = String::from(
        "Real structures leave the primary path there: add a small imperfection or side load to follow the secondary \
         (buckled) path.",
    );
    if options.linear_solver == LinearSolver::Direct && !options.allow_unstable {
        advice.push_str(" `allow_unstable = true` accepts the unstable equilibria of the primary path.");
    }
    advice
}

/// Size and place of the largest displacement of a field.
fn place(system: &System, field: &[Nodal]) -> Option<(f64, String)> {
    let size = |v: usize| dot(&[field[v]], &[field[v]]).sqrt();
    let positions = (0..field.len()).filter(|&v| system.coordinates.kinds[v] == VectorKind::Position);
    let v = positions.max_by(|&a, &b| size(a).total_cmp(&size(b)))?;
    (size(v) > 0.0).then(|| (size(v), format!("at {}", system.place_name(v))))
}

/// Name of a form of Newton's method in messages.
pub(super) fn name(form: NewtonMethod) -> &'static str {
    match form {
        NewtonMethod::Mixed => "mixed Newton",
        NewtonMethod::Displacement => "displacement-based Newton",
    }
}
