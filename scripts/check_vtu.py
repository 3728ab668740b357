#!/usr/bin/env python3
"""Check the fields of a result folder with two readers that tegula's authors did not write.

    python scripts/check_vtu.py RESULT_FOLDER [--series NAME] [--point NAME ...] [--cell NAME ...]

Reads `fields.pvd`, or the list of another series, and every VTU file it names with meshio and with PyVista (VTK's own reader), and checks that
both agree, that every number is finite, and that the point arrays named by --point (`displacement` and `director`
unless given) and the cell arrays named by --cell are there. Prints one line a file; the exit code is 1 if anything is wrong.

Needs: pip install meshio pyvista
"""

import argparse
import pathlib
import sys
import xml.etree.ElementTree as ET

import meshio
import numpy as np
import pyvista

POINT_ARRAYS = ["displacement", "director"]


def rows(array, count):
    """An array as a table with one row per point or cell."""
    return np.asarray(array).reshape(count, -1) if count else np.zeros((0, 1))


def compare(kind, count, ours, theirs, required, problems):
    """Compare the arrays of one kind; return the largest magnitude met."""
    if set(ours) != set(theirs):
        problems.append(f"{kind} arrays differ: meshio {sorted(ours)}, pyvista {sorted(theirs)}")
    for name in required:
        if name not in theirs:
            problems.append(f"no {kind} array `{name}` (there are: {', '.join(sorted(theirs)) or 'none'})")
    for name in sorted(set(ours) & set(theirs)):
        a, b = rows(ours[name], count), rows(theirs[name], count)
        bad = int(np.count_nonzero(~np.isfinite(b)))
        if bad:
            problems.append(f"{kind} array `{name}` has {bad} numbers that are not finite")
        if a.shape != b.shape or not np.array_equal(a, b, equal_nan=True):
            problems.append(f"{kind} array `{name}` differs between the readers")


def check(path, time, point_arrays, cell_arrays):
    """All problems of one file, and its summary."""
    problems = []
    first = meshio.read(path)
    second = pyvista.read(path)
    kinds = [block.type for block in first.cells]
    if kinds not in ([], ["quad"], ["line"], ["quad", "line"]):
        problems.append(f"cells other than quadrilaterals and lines: {kinds}")
    connectivity = [list(cell) for block in first.cells for cell in block.data]
    if not np.isfinite(second.points).all():
        problems.append("points that are not finite")
    if not np.array_equal(first.points, second.points):
        problems.append("points differ between the readers")
    if connectivity != [list(cell.point_ids) for cell in second.cell]:
        problems.append("cells differ between the readers")
    cell_data = {name: np.concatenate(blocks) for name, blocks in first.cell_data.items()}
    points, cells = second.n_points, second.n_cells
    compare("point", points, first.point_data, dict(second.point_data), point_arrays, problems)
    compare("cell", cells, cell_data, dict(second.cell_data), cell_arrays, problems)
    written = second.field_data.get("TimeValue", [None])[0]
    if written != time:
        problems.append(f"its time is {written}, but the series says {time}")
    largest = "-"
    if "displacement" in second.point_data and points:
        lengths = np.linalg.norm(rows(second.point_data["displacement"], points), axis=1)
        largest = f"{lengths.max():.6g}"
    summary = (
        f"t = {time:.6g}: {points} points, {cells} cells, largest displacement {largest}, "
        f"arrays {', '.join(list(second.point_data) + list(second.cell_data))}"
    )
    return problems, summary


def main():
    """Check every file of the series."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--series", default="fields", help="name of the series")
    parser.add_argument("--point", nargs="+", default=POINT_ARRAYS, help="point arrays that must exist")
    parser.add_argument("--cell", action="append", nargs="+", default=[], help="cell arrays that must exist")
    arguments = parser.parse_args()
    cell_arrays = [name for names in arguments.cell for name in names]
    series = arguments.folder / f"{arguments.series}.pvd"
    try:
        entries = [
            (float(entry.attrib["timestep"]), arguments.folder / entry.attrib["file"])
            for entry in ET.parse(series).getroot().iter("DataSet")
        ]
        known_to_vtk = pyvista.PVDReader(series).time_values
    except Exception as error:  # whatever a reader throws is a problem of the file
        print(f"{series}: cannot be read: {error}")
        return 1
    failed = False
    if not entries or list(known_to_vtk) != [time for time, _ in entries]:
        failed = True
        print(f"{series}: PROBLEM: it lists {len(entries)} files, VTK sees the times {known_to_vtk}")
    for time, path in entries:
        try:
            problems, summary = check(path, time, arguments.point, cell_arrays)
        except Exception as error:
            problems, summary = [f"cannot be read: {error!r}"], ""
        failed |= bool(problems)
        print(f"{path.name}: {'PROBLEM: ' + '; '.join(problems) if problems else 'ok: ' + summary}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
