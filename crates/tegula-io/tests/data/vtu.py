"""Writes the VTU files of the folder `vtu` by VTK and meshio: one plate in every encoding.

    pip install vtk==9.7.2 meshio==5.3.5 numpy && python3 vtu.py

The plate has 3 × 2 quadrilaterals of side 1 × 1 from the origin, and lines along its edge x = 0. Point arrays: `t` = 1 + x/2 + y/4, `ref` = 5 at x = 3 and else 0,
`velocity` with three components. Cell arrays: `p` = 1, 2, …, and `gmsh:physical` = 1 for cells with their centre at x < 1 (and the lines), else 2.
"""

from pathlib import Path

import meshio
import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk

FOLDER = Path(__file__).resolve().parent / "vtu"
NX, NY = 3, 2
POINTS = np.array([[i, j, 0.0] for j in range(NY + 1) for i in range(NX + 1)])
at = lambda i, j: j * (NX + 1) + i
QUADS = np.array([[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)] for j in range(NY) for i in range(NX)])
LINES = np.array([[at(0, j), at(0, j + 1)] for j in range(NY)])
T = 1 + POINTS[:, 0] / 2 + POINTS[:, 1] / 4
REF = np.where(POINTS[:, 0] == NX, 5, 0).astype(np.int32)
VELOCITY = np.outer(T, [0.1, 0.2, 0.3])
P = [np.arange(1.0, 7.0), np.array([7.0, 8.0])]
GROUP = [np.where(POINTS[QUADS].mean(axis=1)[:, 0] < 1, 1, 2).astype(np.int64), np.ones(len(LINES), np.int64)]


def by_meshio():
    def mesh(points=POINTS, real=np.float64, group=GROUP):
        return meshio.Mesh(
            points.astype(real),
            [("quad", QUADS), ("line", LINES)],
            point_data={"t": T.astype(real), "ref": REF, "velocity": VELOCITY.astype(real)},
            cell_data={"p": [p.astype(real) for p in P], "gmsh:physical": group},
        )

    mesh().write(FOLDER / "meshio-ascii.vtu", file_format="vtu", binary=False)
    mesh().write(FOLDER / "meshio-zlib.vtu", file_format="vtu", compression="zlib")
    mesh().write(FOLDER / "meshio-plain.vtu", file_format="vtu", compression=None)
    mesh(real=np.float32, group=[g.astype(np.int32) for g in GROUP]).write(FOLDER / "meshio-32-bit.vtu", file_format="vtu")
    # A group for each part that is named in Gmsh or by cell sets, as `meshio convert --sets-to-int-data` writes it.
    sets = meshio.Mesh(POINTS, [("quad", QUADS)], cell_sets={"left": [np.array([0, 3])], "right": [np.array([1, 2, 4, 5])]})
    sets.cell_sets_to_data()
    sets.write(FOLDER / "meshio-cell-sets.vtu", file_format="vtu")


def by_vtk():
    grid = vtk.vtkUnstructuredGrid()
    points = vtk.vtkPoints()
    points.SetDataTypeToDouble()
    for x in POINTS:
        points.InsertNextPoint(*x)
    grid.SetPoints(points)
    for kind, cells in ((vtk.VTK_QUAD, QUADS), (vtk.VTK_LINE, LINES)):
        for cell in cells:
            grid.InsertNextCell(kind, len(cell), [int(n) for n in cell])

    def array(name, values, to):
        found = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        found.SetName(name)
        to.AddArray(found)

    array("t", T, grid.GetPointData())
    array("ref", REF, grid.GetPointData())
    array("velocity", VELOCITY, grid.GetPointData())
    array("p", np.concatenate(P), grid.GetCellData())
    array("gmsh:physical", np.concatenate(GROUP), grid.GetCellData())

    def write(name, mode, compressor=None, header=64, big=False, encode=True, block=None, ids=64, pieces=1):
        writer = vtk.vtkXMLUnstructuredGridWriter()
        writer.SetInputData(grid)
        writer.SetFileName(str(FOLDER / name))
        getattr(writer, f"SetDataModeTo{mode}")()
        writer.SetCompressor(compressor)
        writer.SetHeaderType(vtk.vtkXMLWriter.UInt64 if header == 64 else vtk.vtkXMLWriter.UInt32)
        writer.SetIdType(vtk.vtkXMLWriter.Int64 if ids == 64 else vtk.vtkXMLWriter.Int32)
        (writer.SetByteOrderToBigEndian if big else writer.SetByteOrderToLittleEndian)()
        writer.SetEncodeAppendedData(encode)
        if block:
            writer.SetBlockSize(block)
        if pieces > 1:
            writer.SetNumberOfPieces(pieces)
        assert writer.Write() == 1

    zlib = vtk.vtkZLibDataCompressor()
    write("vtk-ascii.vtu", "Ascii")
    for name, compressor in (("plain", None), ("zlib", zlib)):
        write(f"vtk-binary-{name}.vtu", "Binary", compressor, header=32)
        write(f"vtk-binary-{name}-64.vtu", "Binary", compressor)
        write(f"vtk-appended-{name}.vtu", "Appended", compressor)
        write(f"vtk-raw-{name}.vtu", "Appended", compressor, encode=False)
        write(f"vtk-raw-{name}-32-big.vtu", "Appended", compressor, encode=False, header=32, big=True, ids=32)
        write(f"vtk-binary-{name}-big.vtu", "Binary", compressor, big=True)
    # Blocks of 64 bytes: several blocks and a part of one.
    write("vtk-raw-zlib-blocks.vtu", "Appended", zlib, encode=False, block=64)
    write("vtk-binary-zlib-blocks.vtu", "Binary", zlib, block=64)
    write("vtk-lz4.vtu", "Appended", vtk.vtkLZ4DataCompressor())


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    by_meshio()
    by_vtk()
