"""Results of a run, from its folder."""

from __future__ import annotations

import html
import json
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._errors import OutputError
from ._folder import TemporaryFolder
from ._tegula import FieldFile, read_table, report_page, write_report

MOST_IN_NOTEBOOK = 8_000_000
"""Characters of a report in a notebook, which keeps a copy of it."""


def framed(page: str) -> str:
    """A page in a frame of a notebook, which cannot reach the notebook."""
    return (
        f'<iframe srcdoc="{html.escape(page, quote=True)}" sandbox="allow-scripts allow-downloads" loading="lazy" '
        'style="width: 100%; height: 860px; border: 1px solid #ccc"></iframe>'
    )


class FieldArrays(Mapping[str, NDArray[np.float64]]):
    """Fields on points or cells by their names, each an array n, or n × c for fields with c components, which is read from the file when it is asked for."""

    __slots__ = ("_file", "_names", "_on_cells")

    def __init__(self, file: FieldFile, on_cells: bool) -> None:
        self._file = file
        self._on_cells = on_cells
        self._names = file.names()[on_cells]

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        if name not in self._names:
            raise KeyError(f"there is no field {name!r}; there are: {', '.join(self._names)}")
        return self._file.values(self._on_cells, name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __repr__(self) -> str:
        return f"<fields {', '.join(self._names)}>"


class Fields(NamedTuple):
    """Grid of one instant, with its fields."""

    points: NDArray[np.float64]
    """Positions of the points (length) in the reference configuration, n × 3."""
    quads: NDArray[np.uint32]
    """Quadrilaterals by the numbers of their points, m × 4; of a triangle the last one stands twice."""
    lines: NDArray[np.uint32]
    """Lines by the numbers of their points, l × 2; cells are the quadrilaterals and behind them the lines."""
    point_data: FieldArrays
    """Fields on the points."""
    cell_data: FieldArrays
    """Fields on the cells."""


@dataclass(frozen=True)
class Frame:
    """A file with the fields of one instant."""

    time: float
    """Time, load factor, or number of a mode, as in the list of the files."""
    path: Path
    """The VTU file."""
    _keep: TemporaryFolder | None = field(default=None, repr=False, compare=False)

    def read(self) -> Fields:
        """The grid with its fields as arrays; needs no other package.

        Raises:
            OutputError: the file cannot be read.
        """
        file = FieldFile.open(self.path)
        quads, lines = file.cells()
        return Fields(file.points(), quads, lines, FieldArrays(file, False), FieldArrays(file, True))

    def to_meshio(self) -> Any:
        """The mesh with its fields as a `meshio.Mesh`: displacements, stresses and others in `point_data` and `cell_data`.

        Raises:
            ImportError: the package meshio is not installed.
            meshio.ReadError: the file cannot be read.
        """
        import meshio  # type: ignore[import-not-found, import-untyped, unused-ignore]

        return meshio.read(self.path)

    def to_pyvista(self) -> Any:
        """The mesh with its fields as a `pyvista.UnstructuredGrid`, in the reference configuration unless the model has `output.deformed`.

        Raises:
            ImportError: the package pyvista is not installed.
            FileNotFoundError: there is no such file.
        """
        import pyvista  # type: ignore[import-not-found, import-untyped, unused-ignore]

        return pyvista.read(self.path)

    def __reduce__(self) -> tuple[Any, ...]:
        return _frame, (self.time, *_place(self.path, self._keep))


def _place(path: Path, keep: TemporaryFolder | None) -> tuple[Path, TemporaryFolder | None]:
    """Path for a pickle: relative to a temporary folder, which travels along, or absolute."""
    return (path.absolute() if keep is None else path.relative_to(keep.path)), keep


def _frame(time: float, path: Path, keep: TemporaryFolder | None) -> Frame:
    return Frame(time, path if keep is None else keep.path / path, keep)


def _result(path: Path, keep: TemporaryFolder | None) -> Result:
    return Result(path if keep is None else keep.path / path, _keep=keep)


class Table(Mapping[str, NDArray[np.float64]]):
    """Columns of a table by their names; each is a read-only array with an entry for each row.

    Units are those of the columns, as the page *Results* of the book lists them. An unknown name is a `KeyError` that lists the names.
    """

    def __init__(self, path: Path) -> None:
        self._columns = dict(read_table(path))

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        for column in self._columns.values():
            column.flags.writeable = False

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        try:
            column: NDArray[np.float64] = self._columns[name]
        except KeyError:
            raise KeyError(f"there is no column {name!r}; there are: {', '.join(self._columns)}") from None
        return column

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        rows = len(next(iter(self._columns.values()), []))
        return f"<{rows} rows of {', '.join(self._columns)}>"


class StateSpace(NamedTuple):
    """Linearisation ż = A z + B u, y = C z + D u; the states are the coordinates, modes first, and behind them their rates."""

    a: NDArray[np.float64]
    """System matrix A, s × s, with s states: twice the number of coordinates."""
    b: NDArray[np.float64]
    """Input matrix B, s × (number of inputs)."""
    c: NDArray[np.float64]
    """Output matrix C, (number of outputs) × s."""
    d: NDArray[np.float64]
    """Feedthrough matrix D, (number of outputs) × (number of inputs)."""
    inputs: list[str]
    """Names of the inputs u."""
    outputs: list[str]
    """Names of the outputs y, such as `tip.uz`."""
    omega: NDArray[np.float64]
    """Circular frequency of each coordinate (rad/time), s/2."""
    damping_ratio: NDArray[np.float64]
    """Damping ratio of each coordinate, s/2."""


def _matrix(path: Path) -> NDArray[np.float64]:
    """A dense matrix in the format Matrix Market."""
    with path.open(encoding="utf-8") as file:
        lines = [line for line in file if not line.startswith("%")]
    rows, columns = map(int, lines[0].split())
    return np.array(lines[1:], dtype=float).reshape(columns, rows).T


class Result:
    """Results of a run, from its folder.

    A run with `[[steps]]` has the results of each analysis in `analyses`; those of a failed or interrupted run are readable,
    too: look at `status`. A pickle of a result in a temporary folder holds its files; that of another one holds the path of its folder.

    Args:
        folder: The result folder, of `run` or of the program.

    Raises:
        OutputError: the folder is no result folder, or its `summary.json` is damaged.
    """

    folder: Path
    """The result folder."""
    summary: dict[str, Any]
    """Contents of `summary.json`: status, costs and results of the run."""

    def __init__(self, folder: str | PathLike[str], *, _keep: TemporaryFolder | None = None) -> None:
        self.folder = Path(folder)
        self._keep = _keep
        path = self.folder / "summary.json"
        try:
            self.summary = json.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise OutputError(f"{self.folder} is no result folder of a run: {error}") from error
        except ValueError as error:
            raise OutputError(f"{path} is damaged: {error}") from error
        if not (isinstance(self.summary, dict) and {"status", "analysis"} <= self.summary.keys()):
            raise OutputError(f"{path} is damaged: it has no status and no analysis")
        self._tables: dict[str, Table] = {}

    @property
    def status(self) -> str:
        """Status of the run: `complete`, `failed`, `interrupted` or `running`."""
        return str(self.summary["status"])

    @property
    def warnings(self) -> list[str]:
        """Warnings of the run, whole sentences."""
        return list(self.summary.get("warnings", []))

    def table(self, name: str) -> Table:
        """A table of the folder, which is read once.

        Args:
            name: File name of the table, such as `modes.csv`.

        Returns:
            A mapping of names of columns to arrays with an entry for each row.

        Raises:
            OutputError: there is no such table, or it cannot be read.
        """
        if name not in self._tables:
            self._tables[name] = Table(self.folder / name)
        return self._tables[name]

    @property
    def history(self) -> Table:
        """Columns of the history by their names, such as `time`, `tip.uz` and `kinetic`: arrays with an entry for each recorded step.

        Units are those of the model, or those that its `output.units` names.

        Raises:
            OutputError: the analysis has no history (modal and buckling analyses, runs of several analyses), or its file cannot be read.
        """
        if self.summary.get("analyses"):
            raise OutputError("each of several analyses has a history of its own: take one of `analyses`")
        if self.summary["analysis"] in ("modal", "buckling"):
            raise OutputError(f"a {self.summary['analysis']} analysis has no history: look at `modes`")
        return self.table("history.csv")

    @property
    def frequencies(self) -> NDArray[np.float64]:
        """Natural frequencies of a modal analysis (cycles per unit of time), one for each mode, in ascending order.

        Raises:
            OutputError: the run is no modal analysis.
        """
        return self._numbers("frequencies_hz", "natural frequencies: it is no modal analysis")

    @property
    def load_factors(self) -> NDArray[np.float64]:
        """Load factors of a buckling analysis, one for each mode: multiples of the loads under which the structure buckles.

        Raises:
            OutputError: the run is no buckling analysis.
        """
        return self._numbers("load_factors", "load factors: it is no buckling analysis")

    def _numbers(self, key: str, what: str) -> NDArray[np.float64]:
        if self.summary.get(key) is None:
            raise OutputError(f"the run in {self.folder} has no {what}")
        return np.array(self.summary[key], dtype=float)

    @property
    def frames(self) -> list[Frame]:
        """Files with the fields, in the order of time; none of modal and buckling analyses.

        Raises:
            OutputError: the list `fields.pvd` is damaged.
        """
        return self._frames("fields.pvd")

    @property
    def modes(self) -> list[Frame]:
        """Files with the mode shapes of a modal or buckling analysis, in the order of the modes; none of other analyses.

        Raises:
            OutputError: the list `modes.pvd` is damaged.
        """
        return self._frames("modes.pvd")

    def _frames(self, name: str) -> list[Frame]:
        path = self.folder / name
        if not path.exists():
            return []
        try:
            sets = ET.parse(path).getroot().iter("DataSet")
            return [Frame(float(s.attrib["timestep"]), self.folder / s.attrib["file"], self._keep) for s in sets]
        except (OSError, ET.ParseError, KeyError, ValueError) as error:
            raise OutputError(f"{path} cannot be read: {error}") from error

    @property
    def state_space(self) -> StateSpace:
        """Linearisation of a modal analysis with `inputs`: its matrices, and the names of inputs and outputs.

        Raises:
            OutputError: the run is no modal analysis with `inputs`, or a file of the matrices is damaged.
        """
        path = self.folder / "state_space.json"
        if not path.exists():
            raise OutputError(f"the run in {self.folder} has no state space: it is no modal analysis with inputs")
        try:
            names = json.loads(path.read_text(encoding="utf-8"))
            matrices = [_matrix(self.folder / f"state_space_{name}.mtx") for name in "abcd"]
            coordinates = names["coordinates"]
            omega, damping = (np.array([c[key] for c in coordinates]) for key in ("omega", "damping_ratio"))
            a, b, c, d = matrices
            return StateSpace(a, b, c, d, names["inputs"], names["outputs"], omega, damping)
        except (OSError, ValueError, KeyError, IndexError) as error:
            raise OutputError(f"the state space in {self.folder} cannot be read: {error}") from error

    @property
    def analyses(self) -> dict[str, Result]:
        """Results of the analyses of a run with `[[steps]]` by their names, without those that have not begun; empty of a run of one analysis.

        Raises:
            OutputError: the folder of an analysis is damaged.
        """
        steps = self.summary.get("analyses") or []
        return {s["name"]: Result(self.folder / s["folder"], _keep=self._keep) for s in steps if s.get("status")}

    @property
    def branches(self) -> dict[int, Result]:
        """Results of the paths that cross a path, by the number of the bifurcation; negative for the other side of its mode.

        Raises:
            OutputError: the folder of a path is damaged.
        """
        found = self.summary.get("branches") or []
        return {b["bifurcation"]: Result(self.folder / b["folder"], _keep=self._keep) for b in found if b.get("status")}

    def report(self, path: str | PathLike[str] | None = None) -> Path:
        """Writes a report: one HTML file for a browser, without network, with checks, moving shapes, curves and tables.

        Args:
            path: The file; `report.html` in the result folder unless given.

        Returns:
            The path of the file.

        Raises:
            OutputError: a result file is damaged, or the report cannot be written.
        """
        path = self.folder / "report.html" if path is None else Path(path)
        write_report(self.folder, path)
        return path

    def _repr_html_(self) -> str:
        """The report in a notebook."""
        try:
            return framed(report_page(self.folder, MOST_IN_NOTEBOOK))
        except OutputError as error:
            return f"<pre>{html.escape(f'{self!r}: {error}')}</pre>"

    def __copy__(self) -> Result:
        return Result(self.folder, _keep=self._keep)

    def __deepcopy__(self, memo: object) -> Result:
        return self.__copy__()

    def __reduce__(self) -> tuple[Any, ...]:
        return _result, _place(self.folder, self._keep)

    def __repr__(self) -> str:
        return f"<tegula.Result {self.summary['analysis']}, {self.status}, in {self.folder}>"
