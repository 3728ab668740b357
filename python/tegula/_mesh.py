"""Meshes of other packages as the `mesh` of a model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

Indices = npt.NDArray[np.int64]

_DIMENSIONS = {"vertex": 0, "line": 1, "quad": 2}
_KEYS = ("node_sets", "edge_sets", "quad_sets")
_VTK_PIXEL, _VTK_QUAD = 8, 9


def from_meshio(mesh: Any) -> dict[str, Any]:
    """The key `mesh` of a model, of type `arrays`, from a `meshio.Mesh`.

    Quadrilaterals become elements. Sets of points become node sets, without points of no element; sets and physical groups of quadrilaterals become sets of
    elements, of lines sets of edges, of vertices sets of nodes; groups without a name are called by their number. Coordinates are lengths, in the unit of the model.

    Args:
        mesh: The `meshio.Mesh`.

    Returns:
        The key: a dictionary with arrays, whose elements and nodes are counted from 0.

    Raises:
        ValueError: the mesh has other cells, such as triangles, or a set has cells that the mesh does not have.
    """
    counts = {"vertex": 0, "line": 0, "quad": 0}
    cells: dict[str, list[Indices]] = {"vertex": [], "line": [], "quad": []}
    # Number of the first cell of each block among all of its type.
    first = []
    for block in mesh.cells:
        if block.type not in counts and len(block.data):
            raise ValueError(_other_cells(len(block.data), block.type))
        first.append(counts.get(block.type, 0))
        if block.type not in counts:
            continue
        counts[block.type] += len(block.data)
        cells[block.type].append(np.asarray(block.data, dtype=np.int64))
    joined = {kind: np.concatenate(blocks) if blocks else np.zeros((0, 0), np.int64) for kind, blocks in cells.items()}
    sets: tuple[dict[str, list[Indices]], ...] = ({}, {}, {})

    def add(name: str, block: int, members: Any) -> None:
        kind = mesh.cells[block].type
        members = np.asarray(members, dtype=np.int64)
        if (members < 0).any() or (members >= len(mesh.cells[block].data)).any():
            raise ValueError(f"the set {name!r} has a cell that its block of {len(mesh.cells[block].data)} cells does not have")
        numbers = first[block] + members
        chosen = numbers if kind == "quad" else joined[kind][numbers]
        sets[_DIMENSIONS[kind]].setdefault(name, []).append(chosen.ravel() if kind == "vertex" else chosen)

    for name, of_blocks in mesh.cell_sets.items():
        for block, members in enumerate(of_blocks):
            # Names with a colon are notes of readers, such as the bounding entities of Gmsh.
            if members is not None and len(members) and ":" not in name:
                add(name, block, members)
    physical = mesh.cell_data.get("gmsh:physical")
    if physical is not None:
        fields = {name: np.ravel(field) for name, field in mesh.field_data.items()}
        names = {(int(field[1]), int(field[0])): name for name, field in fields.items() if len(field) == 2}
        for block, tags in enumerate(physical):
            for tag in np.unique(tags):
                dimension = _DIMENSIONS.get(mesh.cells[block].type)
                if dimension is None or tag == 0:
                    continue
                # A group without a name is called by its number, as by the reader of Gmsh files.
                name = names.get((dimension, int(tag)), str(tag))
                if name not in mesh.cell_sets:
                    add(name, block, np.flatnonzero(np.asarray(tags) == tag))
    for name, members in mesh.point_sets.items():
        if ":" in name:
            continue
        sets[0].setdefault(name, []).append(np.asarray(members, dtype=np.int64).ravel())
    return arrays_of(mesh.points, joined["quad"], sets)


def from_pyvista(dataset: Any) -> dict[str, Any]:
    """The key `mesh` of a model, of type `arrays`, from a PyVista data set of quadrilaterals.

    Arrays of truth values become sets: those at points node sets, without points of no element; those of cells sets of elements.
    Coordinates are lengths, in the unit of the model.

    Args:
        dataset: A data set of PyVista, such as `pyvista.PolyData`; not several blocks.

    Returns:
        The key: a dictionary with arrays, whose elements and nodes are counted from 0.

    Raises:
        ValueError: the data set has other cells, such as lines and triangles, or several blocks.
    """
    if not hasattr(dataset, "cast_to_unstructured_grid") or hasattr(dataset, "n_blocks"):
        raise ValueError(f"a {type(dataset).__name__} is no single data set: take one of its blocks, or `combine()` them")
    grid = dataset.cast_to_unstructured_grid()
    quads = np.zeros((grid.n_cells, 4), np.int64)
    for kind, cells in grid.cells_dict.items():
        if kind == _VTK_PIXEL:
            cells = cells[:, [0, 1, 3, 2]]
        elif kind != _VTK_QUAD:
            raise ValueError(_other_cells(len(cells), f"number {kind} of VTK"))
        quads[grid.celltypes == kind] = cells
    sets: tuple[dict[str, list[Indices]], ...] = ({}, {}, {})
    for arrays, out in ((grid.point_data, sets[0]), (grid.cell_data, sets[2])):
        for name in arrays.keys():
            values = np.asarray(arrays[name])
            if values.dtype == np.bool_ and values.ndim == 1 and values.any():
                out[name] = [np.flatnonzero(values)]
    return arrays_of(grid.points, quads, sets)


def _other_cells(count: int, kind: str) -> str:
    return (
        f"the mesh has {count} cells of type {kind}, and elements are quadrilaterals of 4 nodes: mesh the surface with "
        "quadrilaterals (in Gmsh: recombine), or take them out of the mesh"
    )


def arrays_of(points: Any, quads: Any, sets: tuple[Mapping[str, list[Indices]], ...]) -> dict[str, Any]:
    """The key `mesh` of points, elements and sets of nodes, edges and elements."""
    nodes = np.asarray(points, dtype=np.float64)
    if nodes.ndim != 2 or nodes.shape[1] not in (2, 3):
        raise ValueError(f"points have 2 or 3 coordinates, and the shape of their array is {nodes.shape}")
    if nodes.shape[1] == 2:
        nodes = np.column_stack([nodes, np.zeros(len(nodes))])
    out: dict[str, Any] = {"type": "arrays", "nodes": nodes, "quads": np.asarray(quads, dtype=np.int64)}
    for key, named in zip(_KEYS, sets):
        joined = {name: np.concatenate(members) for name, members in named.items()}
        if key == "node_sets":
            joined = {name: members[np.isin(members, quads)] for name, members in joined.items()}
        joined = {name: members for name, members in joined.items() if len(members)}
        if joined:
            out[key] = joined
    return out
