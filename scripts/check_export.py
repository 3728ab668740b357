#!/usr/bin/env python3
"""Check what `tegula convert` writes of results with the programs that the formats belong to.

    python scripts/check_export.py LIST.pvd FILE.vtkhdf
    python scripts/check_export.py TABLE.csv FILE.parquet

Reads a VTKHDF file with VTK's reader, instant by instant, and compares times, points, cells and all arrays with those of the VTU files of the list, bit
by bit; the mesh must stand in the file once. Reads a Parquet file with Apache Arrow and compares names and numbers with those of the table, bit by
bit. The exit code is 1 if anything differs.

Needs: pip install vtk h5py (VTKHDF), pip install pyarrow (Parquet)
"""

import csv
import pathlib
import sys
import xml.etree.ElementTree as ET

import numpy as np


def same(a, b):
    """Whether two arrays have the same type, shape and bits."""
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


def arrays(data):
    """Arrays of a vtkDataSetAttributes or vtkFieldData by name."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}


def contents(grid):
    """Everything that a vtkUnstructuredGrid has, by name."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    cells = grid.GetCells()
    out = {
        "points": vtk_to_numpy(grid.GetPoints().GetData()),
        "connectivity": vtk_to_numpy(cells.GetConnectivityArray()).astype(np.int64),
        "offsets": vtk_to_numpy(cells.GetOffsetsArray()).astype(np.int64),
        "types": np.array([grid.GetCellType(i) for i in range(grid.GetNumberOfCells())]),
    }
    for kind, data in [
        ("point", grid.GetPointData()),
        ("cell", grid.GetCellData()),
        ("field", grid.GetFieldData()),
    ]:
        out |= {f"{kind} array `{name}`": values for name, values in arrays(data).items()}
    return out


def check_vtkhdf(listing, path):
    """Problems of a VTKHDF file, and its summary."""
    import h5py
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
    from vtkmodules.vtkIOHDF import vtkHDFReader
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    entries = [
        (float(entry.attrib["timestep"]), listing.parent / entry.attrib["file"])
        for entry in ET.parse(listing).getroot().iter("DataSet")
    ]
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    information = reader.GetOutputInformation(0)
    key = vtkStreamingDemandDrivenPipeline.TIME_STEPS()
    times = [information.Get(key, i) for i in range(information.Length(key))]
    problems = []
    # VTK has no list of times where there is one.
    if not entries or len(times) > 1 and times != sorted(time for time, _ in entries):
        problems.append(f"VTK sees {len(times)} times, the list has {len(entries)}, or they differ")
    compared = 0
    # And back to the first one.
    for time, file in [*entries, *entries[:1]]:
        frames = vtkXMLUnstructuredGridReader()
        frames.SetFileName(str(file))
        frames.Update()
        reader.UpdateTimeStep(time)
        expected, found = contents(frames.GetOutput()), contents(reader.GetOutputDataObject(0))
        # VTK's reader adds the time of the instant, where there are several.
        if list(found.pop("field array `Time`", [] if len(entries) > 1 else [time])) != [time]:
            problems.append(f"{file.name}: its time is not {time}")
        if set(expected) != set(found):
            problems.append(f"{file.name}: {sorted(expected)} became {sorted(found)}")
        for name in sorted(set(expected) & set(found)):
            compared += expected[name].size
            if not same(expected[name], found[name]):
                problems.append(f"{file.name}: {name} differs")
    with h5py.File(path) as file:
        grid = file["VTKHDF"]
        if list(grid["Steps/Values"]) != sorted(time for time, _ in entries):
            problems.append("its times are not those of the list")
        cells = frames.GetOutput().GetNumberOfCells()
        if grid["Types"].shape != (cells,):
            problems.append(f"the cells stand {grid['Types'].shape} times in the file, not ({cells},)")
        kind = grid.attrs.get_id("Type").get_type()
        if kind.is_variable_str() or grid.attrs["Type"] != b"UnstructuredGrid":
            problems.append("its attribute `Type` is not the fixed text `UnstructuredGrid`")
    return problems, f"{len(entries)} instants, {compared} numbers compared: they have the same bits as in the VTU files"


def check_parquet(table, path):
    """Problems of a Parquet file, and its summary."""
    import pyarrow.parquet

    with open(table, newline="", encoding="utf-8") as file:
        names, *rows = csv.reader(file)
    expected = np.array([[float(x) for x in row] for row in rows]).reshape(len(rows), len(names))
    found = pyarrow.parquet.read_table(path)
    problems = []
    if found.column_names != names:
        problems.append(f"it has the columns {found.column_names}, the table {names}")
    for i, name in enumerate(names):
        column = found.column(i)
        if column.null_count or str(column.type) != "double":
            problems.append(f"the column `{name}` has the type {column.type} and {column.null_count} nulls")
        elif not same(column.to_numpy(), np.ascontiguousarray(expected[:, i])):
            problems.append(f"the column `{name}` differs")
    return problems, f"{expected.shape[1]} columns, {expected.shape[0]} rows with the same bits as in the table"


def main():
    """Compare the two files."""
    if len(sys.argv) != 3:
        print(__doc__)
        return 2
    source, path = map(pathlib.Path, sys.argv[1:])
    problems, summary = (check_vtkhdf if path.suffix == ".vtkhdf" else check_parquet)(source, path)
    print(f"{path.name}: {'PROBLEM: ' + '; '.join(problems[:5]) if problems else 'ok: ' + summary}")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
