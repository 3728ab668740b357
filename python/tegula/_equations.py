"""Residual, tangent stiffness, mass matrix and constraints of a model as functions of a state."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from numpy.typing import NDArray

from ._errors import warn
from ._process import use_threads
from ._tegula import Equations as CompiledEquations
from ._tegula import State as CompiledState

if TYPE_CHECKING:
    from scipy.sparse import csc_array, csr_array  # type: ignore[import-not-found, import-untyped, unused-ignore]

    from ._tegula import _Compressed


def _sparse() -> Any:
    """The package `scipy.sparse`, which only matrices need."""
    try:
        import scipy.sparse  # type: ignore[import-not-found, import-untyped, unused-ignore]
    except ImportError as error:
        raise ImportError("sparse matrices need the package SciPy: pip install scipy") from error
    return scipy.sparse


def _array(name: str, values: npt.ArrayLike, dimensions: int) -> NDArray[np.float64]:
    """Values of a caller as an array."""
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != dimensions:
        expected = "(V, 3) with a row for each nodal vector" if dimensions == 2 else "(n,)"
        raise ValueError(f"{name}: the shape is {array.shape}, and {expected} is expected")
    return array


def _field(name: str, values: npt.ArrayLike | None) -> NDArray[np.float64] | None:
    """Values of the nodal vectors as an array, unless there are none."""
    return None if values is None else _array(name, values, 2)


class State:
    """A state of a model at a time: displacements and their rates, multipliers of joints, history variables of materials.

    States are made by `Equations.state`, `Equations.moved`, `Simulation.state` and `replace`, and never change: their arrays
    are read-only. They can be compared, copied and pickled. Fields have a row for each nodal vector of the model, V × 3, in the order of
    `Equations.nodes`: positions of nodes, directors, and positions and directors of bodies and beams. Displacements are those
    from `Equations.reference` in the unit of length of the model; those of directors have no unit.
    """

    __slots__ = ("__weakref__", "_state")
    _state: CompiledState

    def __init__(self) -> None:
        raise TypeError("states are made by Equations.state() and Simulation.state")

    @classmethod
    def _of(cls, state: CompiledState) -> State:
        made = cls.__new__(cls)
        made._state = state
        return made

    @property
    def time(self) -> float:
        """Time; in static analyses and on paths the load factor."""
        return self._state.time

    @property
    def step(self) -> int:
        """Number of the last finished step; 0 before the first one."""
        return self._state.step

    @property
    def displacements(self) -> NDArray[np.float64]:
        """Displacements of the nodal vectors (length), V × 3, read-only."""
        return self._state.displacements

    @property
    def velocities(self) -> NDArray[np.float64]:
        """Velocities of the nodal vectors (length/time), V × 3, read-only; zero where the state has none, as in statics."""
        return self._state.velocities

    @property
    def accelerations(self) -> NDArray[np.float64]:
        """Accelerations of the nodal vectors (length/time²), V × 3, read-only; zero where the state has none, as in statics."""
        return self._state.accelerations

    @property
    def multipliers(self) -> NDArray[np.float64]:
        """Lagrange multipliers of the constraints of joints, one for each entry of `Equations.joints`, read-only; constraint forces are −Gᵀλ."""
        return self._state.multipliers

    def replace(
        self,
        *,
        time: float | None = None,
        displacements: npt.ArrayLike | None = None,
        velocities: npt.ArrayLike | None = None,
        accelerations: npt.ArrayLike | None = None,
        multipliers: npt.ArrayLike | None = None,
    ) -> State:
        """A state with other values in place of those given; all else, such as history variables of materials, stays.

        Directors given for inextensible ones must have the length 1, and those of bodies must be orthonormal, as `Equations.moved` keeps them: simulations
        do not start elsewhere.

        Raises:
            ValueError: an array has another shape than that of the state, or a value is not finite.
        """
        return State._of(
            self._state.replaced(
                time,
                _field("displacements", displacements),
                _field("velocities", velocities),
                _field("accelerations", accelerations),
                None if multipliers is None else _array("multipliers", multipliers, 1),
            )
        )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, State):
            return NotImplemented
        return self._state.equals(other._state)

    __hash__ = None  # type: ignore[assignment]

    def __copy__(self) -> State:
        return self

    def __deepcopy__(self, memo: object) -> State:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return _loaded, self._state.dump()

    def __repr__(self) -> str:
        return f"<tegula.State at {self.time:g} after {self.step} steps, of {len(self.displacements)} nodal vectors>"


def _loaded(dump: bytes, middle: NDArray[np.float64], analysis: str, mesh: int) -> State:
    return State._of(CompiledState.load(dump, middle, analysis, mesh))


def compiled(state: object) -> CompiledState:
    """Compiled part of a state that a caller has given."""
    if not isinstance(state, State):
        raise TypeError(f"a tegula.State is expected, not {type(state).__name__}")
    return state._state


class Equations:
    """Equations of motion of a model as functions of a state; made by `Model.equations` and `Simulation.equations`.

    With external forces F, internal forces f and damping factor α, and with the constraints g of joints, their gradients G and
    multipliers λ:

        r = F − f(u, v) − Gᵀλ − M (a + α v) = 0,    g(u) = 0.

    Forces and matrices belong to the n free degrees of freedom: constrained ones are eliminated. `numbers` tells the number of the one that belongs to each component of each nodal
    vector. A nodal vector counts along the global axes, but for inclined supports, for inextensible directors (along two tangents of the
    sphere on which they move) and for rigid bodies, whose rotation (rad) along the global axes takes the place of the first of their three
    directors; of all these the matrix `expansion` tells the change of the nodal vectors.

    Units are those of the model: rows of positions are forces; rows of directors and of rotations are moments. Friction and stops of
    joints are not evaluated. History variables of materials are those that the state has, so that forces of yielding materials are those of a step from it.
    """

    __slots__ = ("__weakref__", "_made")

    def __init__(self, made: CompiledEquations) -> None:
        self._made = made

    @property
    def _equations(self) -> CompiledEquations:
        use_threads()
        return self._made

    @property
    def unknowns(self) -> int:
        """Number n of free degrees of freedom."""
        return self._made.unknowns

    @property
    def nodes(self) -> NDArray[np.int64]:
        """Node of each nodal vector, as a row of the mesh; −1 for those of bodies and beams."""
        return self._made.nodes()

    @property
    def bodies(self) -> list[str]:
        """Name of the body of each nodal vector, the empty text for those of nodes; nodes of beams are among the bodies."""
        return self._made.bodies()

    @property
    def kinds(self) -> list[str]:
        """Kind of each nodal vector: `position`, `director` or `gradient`."""
        return self._made.kinds()

    @property
    def reference(self) -> NDArray[np.float64]:
        """Nodal vectors of the reference configuration, V × 3."""
        return self._made.reference()

    @property
    def numbers(self) -> NDArray[np.int64]:
        """Numbers of the free degrees of freedom of each nodal vector along its axes, V × 3; −1 for constrained ones.

        Vectors that are fixed in a body have none of their own; those of the rotation of a body stand at its first director.
        """
        return self._made.numbers()

    @property
    def joints(self) -> list[str]:
        """Name of the joint of each of the m constraints."""
        return self._made.joints()

    def state(self, time: float = 0.0) -> State:
        """State at rest without deformation at a time (load factor), with the displacements that supports prescribe then.

        Raises:
            ValueError: the time is not finite.
        """
        return State._of(self._made.state(time))

    def moved(self, state: State, increment: npt.ArrayLike) -> State:
        """State behind an increment of the n free degrees of freedom; velocities, multipliers and time stay.

        Inextensible directors and rigid bodies turn by the exponential map; other nodal vectors move by `expansion(state) @ increment`.

        Raises:
            ValueError: the state belongs to another model, or the increment has another length or values that are not finite.
        """
        return State._of(self._equations.moved(compiled(state), _array("increment", increment, 1)))

    def residual(self, state: State) -> NDArray[np.float64]:
        """Residual r, n values: external less internal, constraint, inertia and damping forces.

        It vanishes at static equilibria. In a transient analysis it vanishes up to the error of the scheme: that of the energy–momentum
        scheme balances forces, and has the multipliers of joints, in the middle of a step.

        Raises:
            ValueError: the state belongs to another model.
            AnalysisError: forces are not finite, as those of inverted elements.
        """
        return self._equations.residual(compiled(state))

    def tangent(self, state: State) -> csc_array:
        """Tangent stiffness K = ∂(f + Gᵀλ − F)/∂u, n × n, of `scipy.sparse`: minus the derivative of the residual.

        Without follower loads it is symmetric, and its sparsity pattern does not depend on the state. Inertia and damping forces are left out. For inextensible directors, rigid bodies and beams it is the
        derivative at equilibria: elsewhere the residual changes by the rotation of its axes, too.

        Raises:
            ImportError: SciPy is not installed.
            ValueError: the state belongs to another model, or the analysis has no tangent (explicit steps, iterative linear solver).
            AnalysisError: stiffnesses are not finite.
        """
        symmetric, (rows, columns, values) = self._equations.tangent(compiled(state))
        matrix = self._square(symmetric)
        if len(values):
            shape = (self.unknowns, self.unknowns)
            matrix = (matrix + _sparse().coo_array((values, (rows, columns)), shape=shape)).tocsc()
        return matrix

    def mass(self, state: State) -> csc_array:
        """Mass matrix M, n × n, of `scipy.sparse`, symmetric, in the pattern of the tangent; that of rigid bodies depends on the state.

        Raises:
            ImportError: SciPy is not installed.
            ValueError: the state belongs to another model, or the analysis has no tangent (explicit steps, iterative linear solver).
            AnalysisError: masses are not finite.
        """
        return self._square(self._equations.mass(compiled(state)))

    def constraints(self, state: State) -> tuple[NDArray[np.float64], csr_array]:
        """Values g of the m constraints of joints, and their gradients G, m × n, of `scipy.sparse`.

        Constraints of positions are lengths, of directions products of unit vectors. An increment of a joint's motion is a solution of
        [K Gᵀ; G 0] [δ; Δλ] = [r; −g].

        Raises:
            ImportError: SciPy is not installed.
            ValueError: the state belongs to another model.
        """
        sparse = _sparse()
        values, (pointers, numbers, entries) = self._equations.constraints(compiled(state))
        return values, sparse.csr_array((entries, numbers, pointers), shape=(len(values), self.unknowns))

    def expansion(self, state: State) -> csr_array:
        """Matrix T, 3V × n, of `scipy.sparse`: changes of all components of the nodal vectors with the free degrees of freedom, du = T dx.

        Row 3v + i belongs to component i of nodal vector v. Forces on the nodal vectors have the part Tᵀ p along the free degrees of freedom.

        Raises:
            ImportError: SciPy is not installed.
            ValueError: the state belongs to another model.
        """
        sparse = _sparse()
        pointers, numbers, entries = self._equations.expansion(compiled(state))
        return sparse.csr_array((entries, numbers, pointers), shape=(len(pointers) - 1, self.unknowns))

    def _square(self, columns: _Compressed) -> Any:
        """Square matrix of its compressed columns."""
        pointers, rows, values = columns
        return _sparse().csc_array((values, rows, pointers), shape=(self.unknowns, self.unknowns))

    def __reduce__(self) -> tuple[Any, ...]:
        raise TypeError("equations are not pickled or copied: pickle the model and the states, and make them anew by Model.equations()")

    def __repr__(self) -> str:
        return f"<tegula.Equations of {self.unknowns} free degrees of freedom, {len(self.joints)} constraints>"


def equations_of(found: tuple[CompiledEquations, list[str]], stacklevel: int) -> Equations:
    """Equations of a model, with the warnings about it given `stacklevel` calls above."""
    made, warnings = found
    warn(warnings, stacklevel + 1)
    return Equations(made)
