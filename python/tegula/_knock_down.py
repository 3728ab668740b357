"""Knock-down curve: the critical load of an equilibrium path over the amplitude of its imperfections."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._model import Model, as_model
from ._part import Keys
from ._result import Result

if TYPE_CHECKING:
    from . import parts


class KnockDown(NamedTuple):
    """Critical loads of paths over a factor on the amplitudes of all imperfections."""

    factors: NDArray[np.float64]
    """Factors on the amplitudes, as given (n)."""
    load_factors: NDArray[np.float64]
    """Load factor of the first limit point, bifurcation or onset of flutter of each path (n); NaN where the path ends without one."""
    kinds: list[str | None]
    """Kind of each critical point: `"limit"`, `"bifurcation"` or `"flutter"`; `None` where there is none."""
    results: list[Result]
    """Results of the paths, whose last state is the critical point: their histories have the reactions of supports where motions drive the path."""


def knock_down(
    model: str | PathLike[str] | parts.Model | Keys | Model,
    factors: Iterable[float],
    out: str | PathLike[str] | None = None,
    *,
    report: Callable[[float, float], object] | None = None,
) -> KnockDown:
    """Follows the equilibrium path of a model for several amplitudes of its imperfections, each to its first critical point.

    The analysis is a path, and the model has imperfections. Their amplitudes (of a file its factor) are multiplied by each factor; 0 leaves them out. The
    paths end at the first limit point or bifurcation (`end_at = "critical-point"`), whatever the model says, or where the model ends them before.

    Args:
        model: Path of a model file, a dictionary with its keys, a `parts.Model`, or a `Model`.
        factors: Factors on the amplitudes.
        out: A folder for the results, each in a folder `factor-…` in it; without it they last as long as the answer.
        report: Called with each factor and its load factor as soon as it is known.

    Returns:
        The critical load factors, and the results.

    Raises:
        ValueError: the analysis is no path, the model has no imperfections, or a factor is not finite.
        ModelError: the model is wrong, or too far from the nominal one with a factor; a note tells which.
        AnalysisError: a path could not be followed; a note tells the factor.
        OutputError: a result folder cannot be used.
    """
    nominal = as_model(model)
    keys = nominal.keys()
    values = np.array([float(factor) for factor in factors])
    if keys.get("steps") or keys["analysis"]["type"] != "path":
        raise ValueError('a knock-down curve needs the analysis `type = "path"`, without `[[steps]]`')
    if not keys.get("imperfections"):
        raise ValueError("a knock-down curve needs `imperfections`: the model has none")
    if not np.isfinite(values).all():
        raise ValueError("factors of a knock-down curve are finite numbers")
    found: list[float] = []
    kinds: list[str | None] = []
    results: list[Result] = []
    for factor in values:
        scaled = Model(_scaled(keys, float(factor)), folder=nominal.path.parent)
        try:
            result = scaled.run(None if out is None else Path(out) / f"factor-{np.format_float_positional(factor, trim='-')}", _stacklevel=3)
        except Exception as error:
            error.add_note(f"with the imperfections times {factor:g}")
            raise
        results.append(result)
        point = next(iter(result.summary.get("critical_points") or []), None)
        found.append(math.nan if point is None else float(point["load_factor"]))
        kinds.append(None if point is None else str(point["kind"]))
        if report is not None:
            report(float(factor), found[-1])
    return KnockDown(values, np.array(found), kinds, results)


def _scaled(keys: dict[str, Any], factor: float) -> dict[str, Any]:
    """Keys of the model with all imperfections times a factor, whose path ends at its first critical point."""

    def times(imperfection: dict[str, Any]) -> dict[str, Any]:
        amplitude = "factor" if imperfection["type"] == "file" else "amplitude"
        return {**imperfection, amplitude: imperfection.get(amplitude, 1.0) * factor}

    imperfections = [] if factor == 0.0 else [times(imperfection) for imperfection in keys["imperfections"]]
    return {**keys, "analysis": {**keys["analysis"], "end_at": "critical-point"}, "imperfections": imperfections}
