"""Analyses that are advanced step by step."""

from __future__ import annotations

import os
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._equations import Equations, State
from ._errors import warn
from ._tegula import Steps


class Energies(NamedTuple):
    """Energies at the end of a step, in the unit force × length of the model."""

    kinetic: float
    """Kinetic energy; 0 in statics."""
    strain: float
    """Strain energy."""
    potential: float
    """Potential of gravity (in statics: of all dead loads)."""
    work: float
    """Work of the other loads."""
    dissipated: float
    """Energy that damping and plastic flow have dissipated since the start."""
    total: float
    """kinetic + strain + potential + dissipated − work, which an exact integration keeps constant."""


class Statistics(NamedTuple):
    """Run counters."""

    steps: int
    """Finished steps."""
    iterations: int
    """Iterations of all steps."""
    factorizations: int
    """Factorisations of the tangent."""
    cutbacks: int
    """Steps that were repeated with a smaller step size."""


class Simulation:
    """A static, path or transient analysis that is advanced step by step; made by `Model.simulation`.

    Nothing is written to files, and stop conditions of the model do not end it. Arrays are copies: they stay as they are
    when the simulation goes on. Nodes are rows in the order of the mesh.

    In a step the simulation has no state: a function of a load or material law that reads it or advances it gets a `RuntimeError`. Other threads
    wait for the end of the step.
    """

    __slots__ = ("__weakref__", "_made", "_process")

    def __init__(self, steps: Steps) -> None:
        self._made = steps
        self._process = os.getpid()

    @property
    def _steps(self) -> Steps:
        if self._process != os.getpid():
            raise RuntimeError("this simulation belongs to the process that this one was forked from, with its threads")
        return self._made

    def advance(self, steps: int = 1) -> int:
        """Takes steps. A step of an explicit scheme is a number of time steps.

        Warnings of the analysis are `ModelWarning`s. Other threads of Python run meanwhile; Ctrl-C is noticed between steps.

        Args:
            steps: Number of steps, at least 1.

        Returns:
            The iterations of the last step.

        Raises:
            AnalysisError: a step fails; the state is still that before it.
            ValueError: the analysis has come to its end, or `steps` is less than 1.
        """
        if steps < 1:
            raise ValueError(f"advance takes at least one step, not {steps}")
        iterations, found = self._steps.advance(steps)
        warn(found, 2)
        return iterations

    def repeat(self) -> None:
        """Undoes the last step, to take it again with other signals.

        The step ends at the same time when it is taken again, so another program can be coupled by iterations within each step; it ends earlier
        only where a body then hits a stop or begins to stick.

        Raises:
            ValueError: no step has been taken, or the last step has already been undone.
        """
        self._steps.repeat()

    def set(self, signal: str, value: float) -> None:
        """Sets the value of a signal for the steps to come; `values` still refers to the last step.

        Args:
            signal: Name of a signal, one of `signals`.
            value: Value of the amplitude for loads, motions and drives, constant within a step.

        Raises:
            KeyError: there is no such signal.
            ValueError: the value is not finite.
        """
        self._steps.set_signal(signal, value)

    def signal(self, name: str) -> float:
        """Present value of a signal.

        Raises:
            KeyError: there is no such signal.
        """
        return self._steps.signal_value(name)

    @property
    def signals(self) -> list[str]:
        """Names of the signals."""
        return self._steps.signals()

    @property
    def state(self) -> State:
        """Present state, a copy: it can be pickled, evaluated by `equations`, and be the `start` of another simulation."""
        return State._of(self._steps.state())

    @property
    def equations(self) -> Equations:
        """Equations of motion: residual, tangent stiffness and mass matrix of a state, with the present values of the signals."""
        return Equations(self._steps.equations())

    @property
    def time(self) -> float:
        """Time (load factor) reached."""
        return self._steps.time()[0]

    @property
    def end(self) -> float:
        """Time (load factor) at which the analysis ends."""
        return self._steps.time()[1]

    @property
    def finished(self) -> bool:
        """Whether the analysis has come to an end: at its `end`, or of a path where its keys end it."""
        return self._steps.finished()

    @property
    def energies(self) -> Energies:
        """Energies of the present state (force × length): kinetic, strain and potential energy, work, dissipation, and their sum."""
        return Energies(*self._steps.energies())

    @property
    def statistics(self) -> Statistics:
        """Run counters so far: steps, iterations, factorisations and cut-backs."""
        return Statistics(*self._steps.statistics())

    @property
    def columns(self) -> list[str]:
        """Names of the columns of the history, those of `values`."""
        return self._steps.columns()

    def values(self) -> dict[str, float]:
        """All columns of the history for the present state: points, energies, momenta, reactions, bodies, joints, sensors.

        Raises:
            ValueError: the last step has been undone by `repeat`, and forces belong to a step.
        """
        return dict(zip(self._steps.columns(), self._steps.row().tolist(), strict=True))

    def nodes_on(self, set: str) -> NDArray[np.uint32]:
        """Nodes of a set of the mesh, of any kind, in ascending order: rows of `positions`, `velocities` and the other arrays.

        Args:
            set: Name of a set of nodes, edges or elements, or `all`.

        Returns:
            The rows, counted from 0.

        Raises:
            KeyError: the mesh has no such set.
        """
        return self._steps.nodes_on(set)

    @property
    def displacements(self) -> NDArray[np.float64]:
        """Displacements of the nodes from the reference configuration (length), n × 3, a copy."""
        return self._steps.displacements()

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions of the nodes (length), n × 3, a copy."""
        return self._steps.positions()

    @property
    def directors(self) -> NDArray[np.float64]:
        """Directors of the nodes (no unit), n × 3, a copy; zero where a node has none."""
        return self._steps.directors()

    @property
    def velocities(self) -> NDArray[np.float64]:
        """Velocities of the nodes (length/time), n × 3, a copy; zero in statics."""
        return self._steps.velocities()

    @property
    def quads(self) -> NDArray[np.uint32]:
        """Quadrilaterals of the mesh by the rows of their nodes, m × 4, counted from 0."""
        return self._steps.quads()

    def __reduce__(self) -> tuple[Any, ...]:
        raise TypeError(
            "simulations are not pickled or copied: pickle the model and `simulation.state`, and continue by "
            "model.simulation(start=state)"
        )

    def __repr__(self) -> str:
        steps = self._steps
        try:
            time, end = steps.time()
        except RuntimeError:
            return "<tegula.Simulation in the middle of a step>"
        return f"<tegula.Simulation at {time:g} of {end:g}>"
