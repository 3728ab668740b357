"""Progress of a run: its steps, and a bar that shows them in a notebook or on a terminal."""

from __future__ import annotations

import contextlib
import html
import math
import os
import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, NamedTuple, Protocol

_SHORTEST = 0.1
"""Shortest time between two updates of a bar (s)."""
_WIDTH = 20
"""Characters of the bar on a terminal."""


class Progress(NamedTuple):
    """A finished step, or the course of a search for modes."""

    step: int
    """Number of the step; in a search for modes that of the vectors of its basis."""
    time: float
    """Time (load factor) at its end; in a search for modes the number that is found."""
    end: float
    """Time (load factor) at which the analysis ends; in a search for modes the number that is wanted."""
    step_size: float
    """Length of the step; 1 in a search for modes."""
    iterations: int
    """Iterations of the step; in a search for modes the vectors of its basis."""
    parameter: str = "time"
    """Meaning of `time`: `"time"`, `"load factor"`, `"time (load factor)"` where several analyses follow each other, or `"modes"`."""


class _Display(Protocol):
    """A place where a bar is shown."""

    def show(self, part: float, text: str) -> None:
        """Shows the finished part, 0 to 1, with a text, in place of what is there."""

    def close(self) -> None:
        """Leaves the bar as it is."""


class _Terminal:
    """A line of a terminal."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream
        self._begun = False

    def show(self, part: float, text: str) -> None:
        marks = round(part * _WIDTH)
        line = f"[{'#' * marks}{'.' * (_WIDTH - marks)}] {100 * part:3.0f} %  {text}"
        try:
            # A terminal that does not know its size says 0.
            columns = os.get_terminal_size(self._stream.fileno()).columns or 80
        except (OSError, ValueError, AttributeError):
            columns = 80
        # A line that is wrapped could not be replaced.
        self._stream.write("\r" + line[: max(columns, 20) - 1] + "\x1b[K")
        self._stream.flush()
        self._begun = True

    def close(self) -> None:
        if self._begun:
            self._stream.write("\n")
            self._stream.flush()


class _Notebook:
    """An output of a notebook."""

    def __init__(self, display: Callable[..., Any]) -> None:
        self._display = display
        self._handle: Any = None

    def show(self, part: float, text: str) -> None:
        shown = {
            "text/html": f'<progress value="{part:.4f}" max="1" style="width: 16em; vertical-align: middle"></progress> '
            f'<span style="font-variant-numeric: tabular-nums">{100 * part:.0f} % &ensp;{html.escape(text)}</span>',
            "text/plain": f"{100 * part:.0f} %  {text}",
        }
        if self._handle is None:
            self._handle = self._display(shown, raw=True, display_id=True)
        else:
            self._handle.update(shown, raw=True)

    def close(self) -> None:
        pass


def _place() -> _Display | None:
    """Where a bar can be shown: in the notebook, on the terminal of standard error, or nowhere."""
    if "IPython" in sys.modules:
        from IPython import get_ipython  # type: ignore[import-not-found, unused-ignore]
        from IPython.display import display  # type: ignore[import-not-found, unused-ignore]

        if getattr(get_ipython(), "kernel", None) is not None:
            return _Notebook(display)
    stream = sys.stderr
    return _Terminal(stream) if stream is not None and stream.isatty() else None


def _duration(seconds: float) -> str:
    whole = int(seconds)
    if whole < 60:
        return f"{seconds:.2g} s" if whole < 10 else f"{whole} s"
    return f"{whole // 60} min {whole % 60:02} s" if whole < 3600 else f"{whole // 3600} h {whole // 60 % 60:02} min"


class Bar:
    """Bar of the progress of a run, to be called with each finished step; a context that ends with the run.

    It is updated ten times a second at most. A bar that cannot be shown, or no longer, does not disturb the run.
    """

    def __init__(self) -> None:
        self._display: _Display | None = None
        self._last: Progress | None = None
        self._start = 0.0
        self._begun = self._updated = 0.0
        self._iterations = 0

    def __enter__(self) -> Bar:
        with contextlib.suppress(Exception):
            self._display = _place()
        return self

    def __call__(self, progress: Progress) -> None:
        now = time.monotonic()
        if self._last is None or progress.step <= self._last.step or progress.parameter != self._last.parameter:
            # The first analysis, or the next one of several.
            self._begun, self._start, self._iterations = now, progress.time, 0
            self._updated = -math.inf
        self._last = progress
        self._iterations = progress.iterations if progress.parameter == "modes" else self._iterations + progress.iterations
        if self._display is not None and now - self._updated >= _SHORTEST:
            self._updated = now
            self._show(self._text(progress, now))

    def _text(self, progress: Progress, now: float) -> str:
        if progress.parameter == "modes":
            return f"{progress.time:.0f} of {progress.end:.0f} modes, basis of {progress.step} vectors"
        done, rest = progress.time - self._start, progress.end - progress.time
        left = f", {_duration((now - self._begun) * rest / done)} left" if done > 0 and rest > 0 else ""
        iterations = "1 iteration" if progress.iterations == 1 else f"{progress.iterations} iterations"
        return (
            f"{progress.parameter} {progress.time:.5g} of {progress.end:.5g}, step {progress.step}, "
            f"step size {progress.step_size:.3g}, {iterations}{left}"
        )

    def _show(self, text: str) -> None:
        progress = self._last
        assert progress is not None and self._display is not None
        first = min(self._start, 0.0)
        length = progress.end - first
        part = (progress.time - first) / length if length > 0 else 1.0
        try:
            self._display.show(min(max(part, 0.0), 1.0), text)
        except Exception:
            self._display = None

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._display is None or self._last is None:
            return
        last = self._last
        elapsed = _duration(time.monotonic() - self._begun)
        how = "" if kind is None else "interrupted at " if issubclass(kind, KeyboardInterrupt) else "failed after "
        if last.parameter == "modes":
            self._close(f"{how}{self._text(last, 0.0)}, {elapsed}")
            return
        steps = "1 step" if last.step == 1 else f"{last.step} steps"
        iterations = "1 iteration" if self._iterations == 1 else f"{self._iterations} iterations"
        end = f" of {last.end:.5g}" if last.time < last.end else ""
        self._close(f"{how}{last.parameter} {last.time:.5g}{end}, {steps}, {iterations}, {elapsed}")

    def _close(self, text: str) -> None:
        self._show(text)
        with contextlib.suppress(Exception):
            if self._display is not None:
                self._display.close()
