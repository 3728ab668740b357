"""The mesh of the present model of Gmsh as the `mesh` of a model."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._mesh import Indices, arrays_of

_POINT, _LINE, _QUAD = 15, 1, 3
"""Types of elements of Gmsh that a mesh may have."""


def from_gmsh() -> dict[str, Any]:
    """The key `mesh` of a model, of type `arrays`, from the present model of Gmsh's Python interface.

    It is what the file of `gmsh.write("part.msh")` would give: quadrilaterals become elements, physical surfaces sets of elements, physical curves sets of
    edges, physical points sets of nodes; groups without a name are called by their number. Once there are physical groups, elements in none of them are
    left out, unless the option `Mesh.SaveAll` is set; elements of a surface in a group of negative sign are reversed. Nodes are in the order of their
    numbers in Gmsh, without those of no element. Coordinates are lengths, in the unit of the model.

    Returns:
        The key: a dictionary with arrays, whose elements and nodes are counted from 0.

    Raises:
        ImportError: the package gmsh is not installed.
        ValueError: there is no model with quadrilaterals, it has other cells, such as triangles, or a physical point or curve is not of their nodes and sides.
    """
    import gmsh  # type: ignore[import-not-found, import-untyped, unused-ignore]

    if not gmsh.isInitialized():
        raise ValueError("Gmsh has no model: call gmsh.initialize(), make a geometry, and mesh it with gmsh.model.mesh.generate(2)")
    model = gmsh.model
    every = bool(gmsh.option.getNumber("Mesh.SaveAll")) or not model.getPhysicalGroups()
    cells: dict[int, list[Indices]] = {_POINT: [], _LINE: [], _QUAD: []}
    members: dict[int, list[tuple[str, Indices]]] = {_POINT: [], _LINE: [], _QUAD: []}
    others: dict[str, int] = {}
    count = 0
    for dimension, entity in model.getEntities():
        groups = [int(group) for group in model.getPhysicalGroupsForEntity(dimension, entity)]
        if not (groups or every):
            continue
        for kind, tags, nodes in zip(*model.mesh.getElements(dimension, entity)):
            if kind not in cells:
                name = str(model.mesh.getElementProperties(kind)[0])
                others[name] = others.get(name, 0) + len(tags)
                continue
            of_kind: Indices = np.asarray(nodes, dtype=np.int64).reshape(len(tags), -1)
            chosen: Indices = of_kind
            if kind == _QUAD:
                # Files of format 2.2 have them reversed; those of format 4.1 the sign.
                of_kind = of_kind[:, [0, 3, 2, 1]] if groups and groups[0] < 0 else of_kind
                chosen = np.arange(count, count + len(tags))
                count += len(tags)
            cells[kind].append(of_kind)
            for group in groups:
                name = model.getPhysicalName(dimension, abs(group)) or str(abs(group))
                members[kind].append((name, chosen))
    return _mesh(gmsh, cells, members, others)


def _mesh(
    gmsh: Any, cells: dict[int, list[Indices]], members: dict[int, list[tuple[str, Indices]]], others: dict[str, int]
) -> dict[str, Any]:
    """Nodes, elements and sets, of elements by their nodes in Gmsh."""
    if others:
        found = ", ".join(f"{number} of type {name}" for name, number in others.items())
        raise ValueError(
            f"the model of Gmsh has other elements than quadrilaterals of 4 nodes: {found}; for quadrilaterals set the option Mesh.RecombineAll to 1 (where triangles "
            "remain, Mesh.SubdivisionAlgorithm, too) and Mesh.ElementOrder to 1; write a layer of hexahedra by gmsh.write, and read it as a mesh file"
        )
    if not cells[_QUAD]:
        raise ValueError(
            "the model of Gmsh has no quadrilaterals: set the option Mesh.RecombineAll to 1 and call gmsh.model.mesh.generate(2); "
            "once there are physical groups, give the surfaces one, too"
        )
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    # A node may be given for each of the entities that it bounds.
    tags, first = np.unique(np.asarray(tags, dtype=np.int64), return_index=True)
    used = np.unique(np.concatenate(cells[_QUAD]))
    if missing := np.setdiff1d(used, tags).tolist():
        raise ValueError(f"an element of the model of Gmsh has the node {missing[0]}, which does not exist: mesh it again")
    points = np.asarray(coordinates, dtype=np.float64).reshape(-1, 3)[first][np.searchsorted(tags, used)]
    points = points * gmsh.option.getNumber("Mesh.ScalingFactor")
    quads = np.searchsorted(used, np.concatenate(cells[_QUAD]))
    sets: tuple[dict[str, list[Indices]], ...] = ({}, {}, {})
    for name, nodes in members[_POINT]:
        lost = np.setdiff1d(nodes, used).tolist()
        if lost:
            raise ValueError(f"node {lost[0]} of the physical point {name!r} belongs to no element: embed the point into its surface, or take it out of the group")
        sets[0].setdefault(name, []).append(np.searchsorted(used, nodes.ravel()))
    sides = {(min(a, b), max(a, b)) for a, b in np.concatenate([quads[:, [i, (i + 1) % 4]] for i in range(4)]).tolist()}
    for name, lines in members[_LINE]:
        edges = np.searchsorted(used, lines)
        for (a, b), ends in zip(edges.tolist(), lines.tolist()):
            if not np.isin(ends, used).all() or (min(a, b), max(a, b)) not in sides:
                raise ValueError(
                    f"the line from node {ends[0]} to node {ends[1]} of the physical curve {name!r} is not the side of an element: "
                    "embed the curve into its surface, or take it out of the group"
                )
        sets[1].setdefault(name, []).append(edges)
    for name, numbers in members[_QUAD]:
        sets[2].setdefault(name, []).append(numbers)
    return arrays_of(points, quads, tuple({name: [_distinct(np.concatenate(of))] for name, of in named.items()} for named in sets))


def _distinct(members: Indices) -> Indices:
    """Members without repetition, each where it first stands; edges in either direction are the same."""
    _, first = np.unique(np.sort(members.reshape(len(members), -1), axis=1), axis=0, return_index=True)
    return members[np.sort(first)]
