"""Exceptions and warnings."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._result import Result


class TegulaError(Exception):
    """Base of all exceptions of the package."""


@dataclass(frozen=True)
class Diagnostic:
    """One mistake in a model: where, what, and what to do."""

    file: str
    """File of the mistake; of a model from a dictionary `<dict>`."""
    line: int
    """Line in the text of the model file, from 1 (of a model from a dictionary: in `Model.text`); 0 for the file as a whole."""
    column: int
    """Column in that line, from 1; 0 for the file as a whole."""
    key: str
    """Path of the key, such as `loads[2].on`."""
    message: str
    """What is wrong."""
    help: str
    """What to do."""

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}:{self.column}: " if self.line else f"{self.file}: "
        key = f"{self.key}: " if self.key else ""
        remedy = f" ({self.help})" if self.help else ""
        return f"{place}{key}{self.message}{remedy}"


class ModelError(TegulaError):
    """The model is wrong; nothing was run."""

    diagnostics: list[Diagnostic]
    """Everything that is wrong with the model."""

    def __init__(self, found: list[tuple[str, int, int, str, str, str]]) -> None:
        super().__init__(found)
        self.diagnostics = [Diagnostic(*row) for row in found]

    def __str__(self) -> str:
        number = len(self.diagnostics)
        head = "the model has 1 error" if number == 1 else f"the model has {number} errors"
        return "\n  ".join([f"{head}:", *map(str, self.diagnostics)])


class AnalysisError(TegulaError):
    """The analysis failed: no equilibrium, a step that fails, a matrix that is singular."""

    folder: Path | None
    """Result folder of a run; None of a `Simulation`."""
    result: Result | None
    """What a run found up to its last finished step; None of a `Simulation`, and in a copy from another process."""

    def __init__(self, message: str, folder: str | None = None) -> None:
        super().__init__(message, folder)
        self.folder = None if folder is None else Path(folder)
        self.result = None

    def __reduce__(self) -> tuple[Any, ...]:
        return AnalysisError, self.args

    def __str__(self) -> str:
        return str(self.args[0])


class OutputError(TegulaError):
    """A result could not be written or read, or the result folder cannot be used."""


class ModelWarning(UserWarning):
    """Warning of a model that can be computed but is most likely not what was meant, or of unreliable results."""


def warn(messages: list[str], stacklevel: int) -> None:
    """Gives warnings at the place of a caller, `stacklevel` calls above."""
    for message in messages:
        warnings.warn(message, ModelWarning, stacklevel=stacklevel + 1)
