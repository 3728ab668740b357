"""Models: read, checked, run."""

from __future__ import annotations

import contextlib
import html
from collections.abc import Callable, Iterable, Iterator, Mapping
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

from ._equations import Equations, State, compiled, equations_of
from ._errors import AnalysisError, OutputError, TegulaError, warn
from ._folder import TemporaryFolder
from ._own import Materials, NodalForce, own_parts
from ._part import Keys, Part, plain
from ._process import use_threads
from ._progress import Bar, Progress
from ._result import MOST_IN_NOTEBOOK, Result, framed
from ._simulation import Simulation
from ._tegula import Deck

if TYPE_CHECKING:
    from . import parts


@contextlib.contextmanager
def _reported(
    progress: Callable[[Progress], object] | bool | None, parameter: str
) -> Iterator[Callable[..., object] | None]:
    """What the compiled part calls after each step, while a bar is shown where one is wanted."""
    if progress is None or progress is False:
        yield None
    elif progress is True:
        with Bar() as bar:
            yield lambda *step: bar(_progress(step, parameter))
    else:
        yield lambda *step: progress(_progress(step, parameter))


def _progress(of: tuple[Any, ...], parameter: str) -> Progress:
    """Progress of a step, whose `time` has this meaning, or of a search for modes, which tells its own."""
    return Progress._make((*of, parameter)[:6])


class Model:
    """A model, from the tables of a model file: as objects of `tegula.parts`, as a dictionary, or as keywords.

    Args:
        keys: A `parts.Model`, or a dictionary with the keys of a model file. Its tables are objects or dictionaries; numbers and arrays of
            NumPy are taken as numbers and lists; a key with the value None is left out.
        folder: The place that mesh files and the like are relative to.
        tables: The same keys by keywords, in place of `keys`: `Model(analysis=…, mesh=…)`.

    Raises:
        ModelError: keys and values are wrong. What needs the mesh, such as the names of sets, is checked by `check`, `run` and `simulation`.
        TypeError: a keyword is no key of a model, or a value has no counterpart in a model file.
    """

    __slots__ = ("__weakref__", "_deck")
    _deck: Deck

    def __init__(
        self,
        keys: parts.Model | Keys | None = None,
        *,
        folder: str | PathLike[str] = "",
        **tables: Unpack[parts.ModelKeys],
    ) -> None:
        base = Path(folder).absolute() if fspath(folder) else Path()
        self._deck = Deck.parse(base / "<dict>", Deck.text_of(_table(keys, tables)))

    @classmethod
    def read(cls, path: str | PathLike[str]) -> Model:
        """Reads a model file (TOML).

        Args:
            path: The file. Files that the model names, such as meshes, are relative to its folder.

        Raises:
            ModelError: there is no such file, or its keys and values are wrong.
        """
        return cls._of(Deck.read(path))

    @classmethod
    def from_toml(cls, text: str, *, path: str | PathLike[str] = "<text>") -> Model:
        """Reads the text of a model file (TOML).

        Args:
            text: The text.
            path: Path that appears in errors, and beside which files lie that the model names; it need not exist.

        Raises:
            ModelError: keys and values are wrong.
        """
        return cls._of(Deck.parse(path, text))

    @classmethod
    def _of(cls, deck: Deck) -> Model:
        model = cls.__new__(cls)
        model._deck = deck
        return model

    @property
    def title(self) -> str:
        """Title of the model; the empty text where it has none."""
        return self._deck.title

    @property
    def path(self) -> Path:
        """Path of the model file; of a model from a dictionary or a text, a name in angle brackets beside its files."""
        return self._deck.path

    @property
    def text(self) -> str:
        """Text of the model file."""
        return self._deck.text

    def keys(self) -> dict[str, Any]:
        """Keys of the model file as a dictionary, a copy: change it and make another model of it, with the same files:

        `tegula.Model(keys, folder=model.path.parent)`.
        """
        return self._deck.as_dict()

    def check(self) -> list[str]:
        """Checks the model without running it: reads its mesh, and finds sets, supports and materials.

        Returns:
            Warnings, whole sentences.

        Raises:
            ModelError: with everything that is wrong.
        """
        use_threads()
        return self._deck.check()

    def run(
        self,
        out: str | PathLike[str] | None = None,
        *,
        resume: bool = False,
        force: bool = False,
        progress: Callable[[Progress], object] | bool | None = None,
        loads: Iterable[NodalForce] | None = None,
        materials: Materials | None = None,
        _stacklevel: int = 2,
    ) -> Result:
        """Runs the model, as `tegula run` does.

        Warnings of the run are `ModelWarning`s at its end. Other threads of Python run meanwhile. Ctrl-C ends the run after the step with `KeyboardInterrupt`.

        Args:
            out: The result folder; without it the results are in a temporary folder that lasts as long as the `Result`.
            resume: Whether an interrupted run restarts from its checkpoint in `out`.
            force: Whether the results of another model in `out` are replaced.
            progress: `True` shows a bar in a notebook, or on the terminal of standard error; elsewhere nothing. A function is called with a `Progress` at the
                start (step 0) and after each step; an exception in it ends the run after that step, and where `out` is given the run can
                be resumed. Outside Python's main thread it is called in a thread of the computation. In modal and buckling analyses it is called
                while the modes are searched for; those of a few hundred unknowns are found at once.
            loads: Forces that are functions. They act in all of the `[[steps]]`; a run that is resumed takes the same ones.
            materials: Laws that are functions, by the names of the materials that they replace, each an `ElasticLaw` or its function.

        Returns:
            The results.

        Raises:
            ModelError: the model is wrong; nothing was run.
            AnalysisError: the analysis failed; its `result` has what was found up to the last finished step.
            OutputError: the folder cannot be used, or a result cannot be written.
            ValueError: `resume` without `out`, or functions do not fit the model. An exception in a function is raised as it is.
        """
        use_threads()
        own = own_parts(loads, materials)
        temporary = None
        if out is not None and not fspath(out):
            raise ValueError("the result folder `out` is an empty text; leave it out for a temporary folder")
        if out is None:
            if resume:
                raise ValueError("a run is resumed in its result folder: give `out`")
            temporary = TemporaryFolder()
            out = temporary.path / "result"
        try:
            with _reported(progress, self._deck.parameter) as report:
                found = self._deck.run(fspath(out), resume, force, report, own)
        except AnalysisError as error:
            with contextlib.suppress(OutputError):
                error.result = Result(out, _keep=temporary)
            raise
        except KeyboardInterrupt:
            if temporary is not None:
                raise KeyboardInterrupt("interrupted: the results were in a temporary folder") from None
            raise
        warn(found, _stacklevel)
        return Result(out, _keep=temporary)

    def simulation(
        self,
        *,
        signals: Iterable[str] = (),
        start: State | None = None,
        loads: Iterable[NodalForce] | None = None,
        materials: Materials | None = None,
    ) -> Simulation:
        """Begins the static, path or transient analysis of the model, to be advanced step by step.

        Args:
            signals: Names of amplitudes whose values are set between the steps: loads, motions and drives that follow such an
                amplitude take the value that `Simulation.set` gives it, constant within a step. They act in transient analyses with
                the scheme `energy-momentum`.
            start: A state that another simulation has reached, of the same model or of one with other loads or another end, from
                which this one continues: of the same model to the last bit (on paths up to round-off). Both have the same kind of analysis
                with the same scheme. Signals are to be set again, and `loads` and `materials` to be given again.
            loads: Forces that are functions, as those of `run`.
            materials: Laws that are functions, as those of `run`.

        Raises:
            ModelError: the model is wrong.
            KeyError: an amplitude of `signals` is unknown.
            ValueError: the analysis has no steps, or the state belongs to another model.
        """
        use_threads()
        if isinstance(signals, str):
            signals = [signals]
        own = own_parts(loads, materials)
        steps = self._deck.steps(list(signals), None if start is None else compiled(start), own)
        warn(steps.warnings(), 2)
        return Simulation(steps)

    def equations(self, *, loads: Iterable[NodalForce] | None = None, materials: Materials | None = None) -> Equations:
        """Equations of motion of the model: residual, tangent stiffness, mass matrix and constraints as functions of a state.

        Of a model with `[[steps]]` they are those of the first one. Those of a simulation, with its signals, are `Simulation.equations`.

        Args:
            loads: Forces that are functions, as those of `run`.
            materials: Laws that are functions, as those of `run`.

        Raises:
            ModelError: the model is wrong.
        """
        use_threads()
        return equations_of(self._deck.equations(own_parts(loads, materials)), 2)

    def report(self, path: str | PathLike[str]) -> Path:
        """Writes a report of the model: one HTML file for a browser, without network, with mesh, supports, loads and sets.

        Args:
            path: The file.

        Returns:
            The path of the file.

        Raises:
            ModelError: the model is wrong.
            OutputError: the report cannot be written.
        """
        use_threads()
        self._deck.write_report(path)
        return Path(path)

    def _repr_html_(self) -> str:
        """The report in a notebook; of a wrong model its mistakes."""
        try:
            use_threads()
            return framed(self._deck.report_page(MOST_IN_NOTEBOOK))
        except (TegulaError, RuntimeError) as error:
            return f"<pre>{html.escape(f'{self!r}: {error}')}</pre>"

    def __repr__(self) -> str:
        title = f" {self.title!r}" if self.title else ""
        return f"<tegula.Model{title} from {self._deck.path}>"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Model):
            return NotImplemented
        return (self._deck.path, self.text) == (other._deck.path, other.text)

    def __hash__(self) -> int:
        return hash((self._deck.path, self.text))

    def __reduce__(self) -> tuple[Any, ...]:
        return _from_text, (self.text, fspath(self._deck.path))


def _table(keys: object, tables: Any) -> dict[str, Any]:
    """Dictionary of a model that is given as an object, a dictionary or keywords."""
    if keys is None:
        from . import parts

        keys = parts.Model(**tables)
    elif tables:
        raise TypeError(f"a model is given by one argument or by keywords: put {', '.join(tables)} into the argument")
    if isinstance(keys, Part) and type(keys).__name__ != "Model":
        raise TypeError(f"a tegula.parts.Model is expected, not {type(keys).__name__}, which is one table of a model")
    if not isinstance(keys, (Mapping, Part)):
        raise TypeError(f"a dictionary or a tegula.parts.Model is expected, not {type(keys).__name__}; Model.read reads a file")
    table: dict[str, Any] = plain(keys)
    return table


def _from_text(text: str, path: str) -> Model:
    return Model.from_toml(text, path=path)


def as_model(model: str | PathLike[str] | parts.Model | Keys | Model) -> Model:
    """A model from the path of its file, a dictionary with its keys or a `parts.Model`; a `Model` as it is."""
    if isinstance(model, Model):
        return model
    return Model(model) if isinstance(model, (Mapping, Part)) else Model.read(model)


def run(
    model: str | PathLike[str] | parts.Model | Keys | Model,
    out: str | PathLike[str] | None = None,
    *,
    resume: bool = False,
    force: bool = False,
    progress: Callable[[Progress], object] | bool | None = None,
    loads: Iterable[NodalForce] | None = None,
    materials: Materials | None = None,
) -> Result:
    """Runs a model.

    Args:
        model: Path of a model file, a dictionary with its keys, a `parts.Model`, or a `Model`.
        out: The result folder; without it the results are in a temporary folder that lasts as long as the `Result`.
        resume: Whether an interrupted run restarts from its checkpoint in `out`.
        force: Whether the results of another model in `out` are replaced.
        progress: A bar (`True`) or a function, as that of `Model.run`.
        loads: Forces that are functions.
        materials: Laws that are functions, by the names of the materials that they replace.

    Returns:
        The results.

    Raises:
        ModelError: the model is wrong; nothing was run.
        AnalysisError: the analysis failed; its `result` has what was found up to the last finished step.
        OutputError: the folder cannot be used, or a result cannot be written.
        ValueError: `resume` without `out`, or functions do not fit the model.
    """
    return as_model(model).run(
        out, resume=resume, force=force, progress=progress, loads=loads, materials=materials, _stacklevel=3
    )
