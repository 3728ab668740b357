"""Analyses of the model file as classes; written by `scripts/python_classes.py` from `tegula schema`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from .._part import Integer, Integers, Keys, Number, Numbers, Part
from .loads import Condition, InitialVelocity, Load, PrescribedStrain


NewtonMethod = Literal["mixed", "displacement"]
"""How equilibrium is iterated.

`mixed`: Newton with extrapolated stress resultants: few iterations and large steps on thin shells. Beyond yield the
    extrapolation misleads.
`displacement`: Displacement-based Newton.
"""


LinearSolver = Literal["direct", "iterative"]
"""Solver of the linear systems.

`direct`: Factors the matrix: fast while the factor fits in memory, and also for unstable equilibria.
`iterative`: Conjugate gradients preconditioned by BDDC on subdomains: for large meshes and stable equilibria. Memory
    grows in proportion to the number of elements, CPU time with its power 1.08.
"""


Crossing = Literal["rising", "falling", "either"]
"""Direction in which a value is crossed.

`rising`: From below.
`falling`: From above.
`either`: From below or from above.
"""


class StopCondition(Part):
    """Condition at which an analysis ends before its end: a column of the history crosses a value.

    Args:
        column: Name of a column of the history, such as `sensor.NAME.angle` or `body.NAME.y`.
        value: Value at which the analysis ends, in the unit of the column.
        direction: Direction in which the column crosses the value. Values: `rising`, `falling`, `either`.
    """

    column: str
    value: Number
    direction: Crossing | None = None


Continuation = Literal["path"]
"""How a static analysis continues behind a critical point.

`path`: Along the equilibrium path, whose load factor falls behind a limit point, by the arc-length method until load
    factor 1.
"""


PathMethod = Literal["series", "arc-length"]
"""Method that follows a path.

`series`: Power series (asymptotic numerical method): one factorisation a step, for linear materials, joints of
    quadratic constraints, and loads of constant direction in proportion to the load factor.
`arc-length`: Arc-length method: Newton's method on planes across the path, for all models.
"""


AllBranches = Literal["all"]
"""All bifurcations of a path.

`all`: All of them.
"""


Branches = Integer | AllBranches
"""Bifurcations of a path whose crossing paths are followed."""


PathEnd = Literal["limit-point", "bifurcation", "flutter", "critical-point"]
"""Kind of critical point at which a path ends.

`limit-point`: Limit point.
`bifurcation`: Bifurcation.
`flutter`: Onset of flutter under follower loads without a potential.
`critical-point`: Limit point, bifurcation or onset of flutter.
"""


FactorSigns = Literal["positive", "both"]
"""Signs of the load factors of a buckling analysis.

`positive`: Positive factors: the loads act in their own direction.
`both`: Factors of both signs: a negative one belongs to loads that are reversed.
"""


Spacing = Literal["logarithmic", "linear"]
"""Spacing of frequencies.

`logarithmic`: Equal ratios between neighbours.
`linear`: Equal distances between neighbours.
"""


class FrequencyResponse(Part):
    """Steady-state response to harmonic excitation over a range of frequencies.

    Args:
        from_: Lowest frequency [1/time].
        to: Highest frequency [1/time], not above the highest mode.
        points: Number of frequencies between the two. Natural frequencies of damped modes in the range and the flanks
            of their peaks are added.
        spacing: Spacing of these frequencies. Values: `logarithmic`, `linear`.
    """

    from_: Number
    to: Number
    points: Integer | None = None
    spacing: Spacing | None = None


class ResponseInput(Part):
    """Excitation of a model in its response to small motions: loads that act together, each multiplied by the same
    function of time.

    Args:
        name: Name of the input in the results.
        loads: Loads as in `loads`, without `amplitude`: their values are the amplitudes of the excitation. They add
            nothing to the state about which the model vibrates.
    """

    name: str
    loads: Sequence[Load | Keys]


class Newmark(Part, type="newmark"):
    """Newmark-β; β = 1/4, γ = 1/2 (trapezoidal rule) unless given.

    Args:
        beta: β, above 0; unconditionally stable (linear) for β ≥ γ/2 ≥ 1/4.
        gamma: γ; 1/2 is second order, above it is damped and first order.
    """

    beta: Number | None = None
    gamma: Number | None = None


class EnergyMomentum(Part, type="energy-momentum"):
    """Conserves energy and momenta exactly (Simo–Tarnow).

    Args:
        order: Order of accuracy: 2, or 4 by steps that are composed of five of second order. Order 4 needs a constant
            `time_step`, and a model without damping: one of the five goes back in time.
    """

    order: Integer | None = None


class HHT(Part, type="hht"):
    """Hilber–Hughes–Taylor α method: second order with numerical damping, also with bodies and joints.

    Args:
        alpha: α between −1/3 (most damping) and 0 (none).
    """

    alpha: Number | None = None


class GeneralizedAlpha(Part, type="generalized-alpha"):
    """Generalised-α method: second order with numerical damping, also with bodies and joints.

    Args:
        spectral_radius: Spectral radius ρ at high frequencies: 0 damps motions that the step does not resolve at once,
            1 (trapezoidal rule) not at all.
    """

    spectral_radius: Number | None = None


class BDF2(Part, type="bdf2"):
    """Backward differentiation formula of second order: strong numerical damping, for motions that settle."""


class Kinematic(Part, type="kinematic"):
    """Kinematic analysis of rigid bodies: positions from joints and drives alone, forces by inverse dynamics."""


class Explicit(Part, type="explicit"):
    """Central differences with lumped mass: no equations are solved, steps are small.

    Args:
        scale_director_inertia: Make directors heavier until they vibrate no faster than the membrane, so that the
            thickness does not limit the step.
    """

    scale_director_inertia: bool | None = None


Scheme = Newmark | EnergyMomentum | HHT | GeneralizedAlpha | BDF2 | Kinematic | Explicit
"""Time integration schemes."""


class Static(Part, type="static"):
    """Equilibrium under loads that grow from 0 to their full value.

    Args:
        linear: Small displacements: one solve with the tangent of the reference configuration.
        method: Iteration to equilibrium; unless given `mixed`, where a section yields `displacement`. Values: `mixed`,
            `displacement`.
        load_steps: Load steps to begin with; a step that does not converge is cut back by itself.
        max_iterations: Iterations after which a load step is cut back.
        max_cutbacks: Cut-backs after which the analysis ends.
        allow_unstable: Accept an equilibrium at which the structure would buckle (tangent with negative pivots).
        inertia_relief: Balance the loads of a model that supports do not hold by the inertia forces of its rigid
            acceleration.
        linear_solver: Solver of the linear systems. Values: `direct`, `iterative`.
        stop: Conditions at which the analysis ends before load factor 1.
        continue_: How the analysis continues behind a critical point, at which load steps end; left out: it ends there
            with an error. Values: `path`.
    """

    linear: bool | None = None
    method: NewtonMethod | None = None
    load_steps: Integer | None = None
    max_iterations: Integer | None = None
    max_cutbacks: Integer | None = None
    allow_unstable: bool | None = None
    inertia_relief: bool | None = None
    linear_solver: LinearSolver | None = None
    stop: Sequence[StopCondition | Keys] | None = None
    continue_: Continuation | None = None


class EquilibriumPath(Part, type="path"):
    """Equilibria along a path through limit points, under loads that grow and fall.

    Args:
        end_load: Load factor at which the path ends when it gets there; a negative one starts the path with falling
            loads.
        method: Method that follows the path; left out: power series where the model has some, else the arc-length
            method, and the run says why. Values: `series`, `arc-length`.
        max_steps: Steps, expansions into power series or arc-length steps, after which the path ends.
        order: Highest order of the power series.
        tolerance: Truncation error of the power series at the end of a step, over the displacement of the step.
        points: Points of the path that each expansion reports, its end included; an arc-length step reports its end.
        switch_at: Numbers of the bifurcations, counted from 1 along the path, at which it goes over to the crossing
            path, on the side of the critical mode; a negative number: on the other side.
        branches: Bifurcations whose crossing paths are followed behind this one, on both sides: a number, the first
            ones, or `"all"`. Values: `all`.
        end_at: Kind of critical point at the first of which the path ends. Values: `limit-point`, `bifurcation`,
            `flutter`, `critical-point`.
        stop: Conditions at which the path ends.
    """

    end_load: Number | None = None
    method: PathMethod | None = None
    max_steps: Integer | None = None
    order: Integer | None = None
    tolerance: Number | None = None
    points: Integer | None = None
    switch_at: Integers | None = None
    branches: Branches | None = None
    end_at: PathEnd | None = None
    stop: Sequence[StopCondition | Keys] | None = None


class Modal(Part, type="modal"):
    """Natural frequencies and mode shapes.

    Args:
        modes: Number of modes wanted, rigid ones counted.
        prestressed: Vibrate about the equilibrium under the loads instead of the reference configuration.
        speeds: Angular velocities of a model that turns, in place of that of its centrifugal load [rad/time]: the modes
            at each of them make a Campbell diagram, and those at the last one are the result.
        damping_ratio: Modal damping: ratio of the damping of each mode to its critical one, beside `[damping]` and
            dampers. It acts in the response to `inputs`, not on the modes.
        inputs: Excitations whose small-signal response is wanted: the model is linearised to a state space, with the
            recorded points and the bodies as outputs.
        frequency_response: Steady-state response to each of the inputs, harmonic in time.
    """

    modes: Integer
    prestressed: bool | None = None
    speeds: Numbers | None = None
    damping_ratio: Number | None = None
    inputs: Sequence[ResponseInput | Keys] | None = None
    frequency_response: FrequencyResponse | Keys | None = None


class Buckling(Part, type="buckling"):
    """Load factors of linear buckling and buckling modes.

    Args:
        factors: Number of load factors wanted, the lowest in magnitude.
        signs: Signs of the load factors wanted. Values: `positive`, `both`.
    """

    factors: Integer | None = None
    signs: FactorSigns | None = None


class Transient(Part, type="transient"):
    """Motion in time.

    Args:
        end_time: Time at which the analysis ends (time); it starts at 0.
        scheme: Time integration scheme; in a model file without it `newmark`, but where the model has bodies, beams,
            joints, ties or springs `energy-momentum`, or `generalized-alpha` if a material yields.
        tolerance: Tolerance of automatic steps: RMS error of position per step over the size of the model.
        time_step: Constant time step (time); given, steps are not chosen automatically.
        initial_step: First automatic step (time); chosen from the initial acceleration unless given.
        max_step: Largest automatic step (time).
        max_iterations: Iterations after which a time step is repeated smaller.
        linear: Small displacements: the tangent of the reference configuration throughout.
        stop: Conditions at which the analysis ends before `end_time`.
    """

    end_time: Number
    scheme: Scheme | Keys | None = None
    tolerance: Number | None = None
    time_step: Number | None = None
    initial_step: Number | None = None
    max_step: Number | None = None
    max_iterations: Integer | None = None
    linear: bool | None = None
    stop: Sequence[StopCondition | Keys] | None = None


Analysis = Static | EquilibriumPath | Modal | Buckling | Transient
"""Analysis to run."""


class AnalysisStep(Part):
    """One analysis of several that follow one another. It starts at the state in which the step before has ended.
    Conditions, loads and prescribed strains of the whole model act in every step, those of a step in this one only. A
    load that two steps in a row list with the same values continues. In a static step new loads grow from 0, and loads
    that only the step before had fall to 0; in a transient step new loads act from the start, and old ones are gone at
    once. Fixed components stay where they are at the start of the step. Joints of the model act in every step, but for
    those that a step releases; those that it locks do not move in it. A buckling step keeps all loads of the step
    before as they are; its own loads are those that the load factors multiply. Each step has its own load factor from 0
    to 1, or its own time from 0.

    Args:
        analysis: Analysis of the step. A modal one vibrates about the state of the step before, under its supports and
            loads.
        name: Name of the step, and of its folder among the results.
        conditions: Supports and prescribed motions of this step, beside those of the whole model.
        loads: Loads of this step, beside those of the whole model.
        prescribed_strains: Prescribed strains of this step, beside those of the whole model.
        initial_velocities: Velocities that a transient step adds to those of its first state.
        released: Names of joints that do not act in this step: latches that open, bolts that are gone, drives that are
            switched off. In a static step their forces fall to 0 with the load factor, in a transient step they are
            gone at once. A joint acts again in a later step that does not release it, and its sides must meet there.
        locked: Names of joints whose two sides do not move against each other in this step: they stay as they are at
            its start. A joint that moves there stops at once, in a plastic impact, whose loss of kinetic energy counts
            as dissipated. The types `revolute`, `universal`, `spherical`, `cylindrical`, `screw`, `prismatic` and
            `planar` can be locked.
        at: Times (load factors) at which a step ends and a field file is written, like `output.at`.
    """

    analysis: Analysis | Keys
    name: str | None = None
    conditions: Sequence[Condition | Keys] | None = None
    loads: Sequence[Load | Keys] | None = None
    prescribed_strains: Sequence[PrescribedStrain | Keys] | None = None
    initial_velocities: Sequence[InitialVelocity | Keys] | None = None
    released: Sequence[str] | None = None
    locked: Sequence[str] | None = None
    at: Numbers | None = None
