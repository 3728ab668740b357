"""Loads and material laws that are functions of the caller."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._tegula import Own

Array = NDArray[np.float64]

# Arguments of the functions of a load.
_ARGUMENTS = ("time", "positions", "velocities")
# Characters of names of sets that those of loads do not have.
_NOT_IN_NAMES = re.compile(r"""[,;"'`\x00-\x1f\x7f-\x9f]""")


def _arguments(what: str, function: object) -> int:
    """Number of arguments with which a function is called: those without a default."""
    if not callable(function):
        raise TypeError(f"{what}: a function is expected, not {type(function).__name__}")
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError) as error:
        raise ValueError(f"{what}: the arguments of {function!r} are unknown: wrap it in a function of (time, positions)") from error
    positional = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    number = sum(p.kind in positional and p.default is p.empty for p in parameters)
    if any(p.kind is p.KEYWORD_ONLY and p.default is p.empty for p in parameters) or not 1 <= number <= 3:
        raise ValueError(
            f"{what}: a function of (time), (time, positions) or (time, positions, velocities) is expected; other arguments have defaults"
        )
    return number


class NodalForce:
    """Forces on the nodes of a set, or on a body, as a function of time and motion.

    Args:
        on: Name of a set of the mesh, or of a body of the model.
        force: Function that gives the force on each node (force), an array n × 3. Its arguments are those of `(time)`, `(time, positions)` or
            `(time, positions, velocities)`: the time (in static analyses and on paths the load factor), positions (length) and velocities
            (length/time) of the nodes, arrays n × 3, in ascending order of the nodes, as `Simulation.nodes_on` has them. On a body n is 1, the mass centre. Arguments with a
            default are not given to it.
        stiffness: Function of the same arguments that gives the blocks −∂f_a/∂x_a of each node (force/length), an array n × 3 × 3. They need not
            be symmetric. Without it they are differences of the forces, three calls more for each new tangent.
        damping: Function of the same arguments that gives the blocks −∂f_a/∂v_a (force·time/length), n × 3 × 3, where `force` depends on velocities and
            `stiffness` is given.
        name: Name in messages and in the columns `load.NAME.fx` … of the history; `python.SET` unless given. It is not that of a load of the model, and
            has no commas, quotes and control characters.

    A function is called once for all nodes, several times in each step, and again where a step is repeated. It depends on its arguments
    alone: forces that depend on the past do not converge. In a static analysis the forces are multiplied by the load factor, as
    all loads without an amplitude. Forces on a node that depend on the motion of other nodes are right, but not in the tangent: then
    the iteration converges more slowly.

    Raises:
        ValueError: the function has other arguments, or `stiffness` and `damping` do not fit it.
    """

    __slots__ = ("_arguments", "damping", "force", "name", "on", "stiffness")

    def __init__(
        self,
        on: str,
        force: Callable[..., Any],
        *,
        stiffness: Callable[..., Any] | None = None,
        damping: Callable[..., Any] | None = None,
        name: str | None = None,
    ) -> None:
        if not isinstance(on, str):
            raise TypeError(f"on: the name of a set or body is expected, not {type(on).__name__}")
        if name is not None and not isinstance(name, str):
            raise TypeError(f"name: a text is expected, not {type(name).__name__}")
        self.on = on
        self.name = f"python.{_NOT_IN_NAMES.sub('_', on)}" if name is None else name
        self.force = force
        self.stiffness = stiffness
        self.damping = damping
        what = f"load {self.name!r}"
        self._arguments = _arguments(f"{what}, force", force)
        for key, function in (("stiffness", stiffness), ("damping", damping)):
            if function is not None and _arguments(f"{what}, {key}", function) != self._arguments:
                raise ValueError(f"{what}: {key} has the arguments of force: {', '.join(_ARGUMENTS[: self._arguments])}")
        if stiffness is not None and self._arguments == 1:
            raise ValueError(f"{what}: forces that depend on the time alone have no stiffness")
        if (damping is None) == (self._arguments == 3 and stiffness is not None):
            raise ValueError(
                f"{what}: a force that depends on velocities has both stiffness and damping, or neither; another one has no damping"
            )

    def _spec(self) -> tuple[str, str, int, Callable[..., Any], Callable[..., Any] | None, Callable[..., Any] | None]:
        return self.name, self.on, self._arguments, self.force, self.stiffness, self.damping

    def __repr__(self) -> str:
        return f"<tegula.NodalForce {self.name!r} on {self.on!r}, of {', '.join(_ARGUMENTS[: self._arguments])}>"


class ElasticLaw:
    """An elastic material as a function of strains, in place of a nonlinear material of the model (`neo-hookean`, `mooney-rivlin`, `plastic`).

    Args:
        function: Function of Green–Lagrange strains, an array n × 6 of components xx, yy, 2xy, zz, 2xz, 2yz, that gives a tuple: the
            stored energy per reference volume (force/area), n; second Piola–Kirchhoff stresses xx, yy, xy, zz, xz, yz (force/area), n × 6, the
            derivative of the energy; tangents, n × 6 × 6, the derivative of the stress by these strains, symmetric. Rows of NaN say that the law cannot be evaluated: the step is then
            repeated with a smaller one. There is no stress without strain.
            Differences at a small strain check once whether the parts are derivatives of each other.
        rubber: Whether elastic strains are large: elements then take the membrane part `assumed-shear`.

    The function is called once for all points of up to 4096 elements and each iteration of their enhanced parameters. Axes are those of the cross-section frame of each element, which depends on the order of its nodes; plies with angles or a direction are refused. It is a pure function, without memory:
    a material that yields is written in Rust. Elements are `cm` and `solid-shell`, whose stresses have six components. Density, and the stiffness at zero strain for estimates, are those
    of the material that the law replaces.
    """

    __slots__ = ("function", "rubber")

    def __init__(self, function: Callable[[Array], Any], *, rubber: bool = False) -> None:
        if not callable(function):
            raise TypeError(f"a function of strains is expected, not {type(function).__name__}")
        self.function = function
        self.rubber = rubber

    def __repr__(self) -> str:
        return f"<tegula.ElasticLaw {self.function!r}{', rubber' if self.rubber else ''}>"


Materials = Mapping[str, "ElasticLaw | Callable[[Array], Any]"]


def own_parts(loads: Iterable[NodalForce] | None, materials: Materials | None) -> Own:
    """Loads and laws for the compiled part."""
    if loads is None:
        loads = []
    elif isinstance(loads, NodalForce):
        loads = [loads]
    elif isinstance(loads, str) or not isinstance(loads, Iterable):
        raise TypeError(f"loads: a list of tegula.NodalForce is expected, not {type(loads).__name__}")
    loads = list(loads)
    for load in loads:
        if not isinstance(load, NodalForce):
            raise TypeError(f"loads: a tegula.NodalForce is expected, not {type(load).__name__}")
    if materials is None:
        materials = {}
    elif not isinstance(materials, Mapping):
        raise TypeError(f"materials: a dictionary of laws by the names of their materials is expected, not {type(materials).__name__}")
    laws = {}
    for name, law in materials.items():
        if not isinstance(name, str):
            raise TypeError(f"materials: the name of a material is a text, not {type(name).__name__}")
        if not isinstance(law, ElasticLaw) and not callable(law):
            raise TypeError(f"materials: the law of {name!r} is a function of strains or a tegula.ElasticLaw, not {type(law).__name__}")
        laws[name] = law if isinstance(law, ElasticLaw) else ElasticLaw(law)
    return Own([load._spec() for load in loads], [(name, law.function, law.rubber) for name, law in laws.items()])
