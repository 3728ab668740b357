"""Meshes, sets and markers of the model file as classes; written by `scripts/python_classes.py` from `tegula schema`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .._part import Integer, IntegerRows, Integers, Keys, Number, Numbers, Part, Rows


class Grid(Part):
    """Grid of elements, common to all generators.

    Args:
        elements: Number of elements along u and v, at least 1 each.
        grading: Ratio of the last to the first element's length along u and v (1: all equal).
        distortion: Random shift of inner nodes within the surface, as a part of the element size (0…0.4).
        seed: Seed of the random shift; the same seed gives the same mesh.
        points: Names for further points: each becomes a node set with the node nearest to the position.
        merge_coincident: Nodes that coincide without being connected (the slit of a full ring): `true` merges them,
            `false` keeps them apart without a warning; unless given they stay apart with a warning.
    """

    elements: Integers
    grading: Numbers | None = None
    distortion: Number | None = None
    seed: Integer | None = None
    points: Mapping[str, Numbers | str] | None = None
    merge_coincident: bool | None = None


class NoMesh(Part, type="none"):
    """No shells: a model of bodies and joints alone."""


class PlateMesh(Part, type="plate"):
    """A rectangle; u along `u_axis`, v along `v_axis`.

    Args:
        size: Lengths along u and v (length).
        grid: Elements, grading, distortion, points.
        origin: Corner u = v = 0 (length). Or the name of a marker.
        u_axis: Direction of u. Or an axis of a marker, such as "NAME.z" or "-NAME.z".
        v_axis: Direction of v, not parallel to u; the director is u × v. Or an axis of a marker, such as "NAME.z" or
            "-NAME.z".
    """

    size: Numbers
    grid: Grid | Keys
    origin: Numbers | str | None = None
    u_axis: Numbers | str | None = None
    v_axis: Numbers | str | None = None


class CylinderMesh(Part, type="cylinder"):
    """A sector of a cylinder; u is the angle, v runs along the axis.

    Args:
        radius: Radius (length).
        angles: First and last angle (degrees), right-handed about the axis.
        length: Length along the axis (length).
        grid: Elements, grading, distortion, points.
        center: Point on the axis from which v is counted (length). Or the name of a marker.
        axis: Direction of the axis and of v. Or an axis of a marker, such as "NAME.z" or "-NAME.z".
        start: Radial direction of the angle 0; the part along the axis is ignored. Or an axis of a marker, such as
            "NAME.z" or "-NAME.z".
    """

    radius: Number
    angles: Numbers
    length: Number
    grid: Grid | Keys
    center: Numbers | str | None = None
    axis: Numbers | str | None = None
    start: Numbers | str | None = None


class AnnulusMesh(Part, type="annulus"):
    """A flat ring or sector of it in the plane z = 0; u is the radius, v the angle from the x axis.

    Args:
        radii: Inner and outer radius (length).
        grid: Elements, grading, distortion, points.
        center: Centre (length). Or the name of a marker.
        angles: First and last angle (degrees); a full turn leaves a slit.
    """

    radii: Numbers
    grid: Grid | Keys
    center: Numbers | str | None = None
    angles: Numbers | None = None


class SphereMesh(Part, type="sphere"):
    """A patch of a sphere about the z axis; u is the longitude from the x axis, v the latitude from the equator.

    Args:
        radius: Radius (length).
        latitudes: First and last latitude (degrees), within −90…90 but not at a pole.
        grid: Elements, grading, distortion, points.
        center: Centre (length). Or the name of a marker.
        longitudes: First and last longitude (degrees).
    """

    radius: Number
    latitudes: Numbers
    grid: Grid | Keys
    center: Numbers | str | None = None
    longitudes: Numbers | None = None


class ExtrusionMesh(Part, type="extrusion"):
    """A polyline swept along a direction; u runs along the polyline, v along the direction.

    Args:
        vertices: Vertices of the polyline (length), at least two; neighbours differ.
        sweep: Sweep (length).
        grid: Elements along the whole polyline (shared out by length, at least one a segment) and along the sweep;
            grading and distortion.
    """

    vertices: Sequence[Numbers | str]
    sweep: Numbers
    grid: Grid | Keys


class ArraysMesh(Part, type="arrays"):
    """Nodes, elements and sets in the model itself.

    Args:
        nodes: Position of each node (length). Nodes of no element are left out of the model.
        quads: Nodes of each element, counter-clockwise about its director.
        node_sets: Named sets of nodes.
        edge_sets: Named sets of sides of elements, each given by its two nodes.
        quad_sets: Named sets of elements; "all" stands for every element.
        points: Names for further points: each becomes a node set with the node nearest to the position.
        merge_coincident: Nodes that coincide without being connected, where parts were meshed apart: `true` merges
            them, `false` keeps them apart without a warning (a slit); unless given they stay apart with a warning.
        fold_angle: Angle (degrees), 1…180, from which on neighbouring elements form a fold and have directors of their
            own; 20 unless given.
    """

    nodes: Sequence[Numbers | str]
    quads: IntegerRows
    node_sets: Mapping[str, Integers] | None = None
    edge_sets: Mapping[str, IntegerRows] | None = None
    quad_sets: Mapping[str, Integers] | None = None
    points: Mapping[str, Numbers | str] | None = None
    merge_coincident: bool | None = None
    fold_angle: Number | None = None


class GmshMesh(Part, type="gmsh"):
    """A Gmsh file (`.msh`, format 2.2 or 4.1, ASCII or binary); physical groups become sets.

    Args:
        file: Path, relative to the model file.
        scale: Factor on all coordinates.
        points: Names for further points: each becomes a node set with the node nearest to the position.
        merge_coincident: Nodes that coincide without being connected, where parts were meshed apart: `true` merges
            them, `false` keeps them apart without a warning (a slit); unless given they stay apart with a warning.
        fold_angle: Angle (degrees), 1…180, from which on neighbouring elements form a fold and have directors of their
            own; 20 unless given.
    """

    file: str
    scale: Number | None = None
    points: Mapping[str, Numbers | str] | None = None
    merge_coincident: bool | None = None
    fold_angle: Number | None = None


class AbaqusMesh(Part, type="abaqus"):
    """An input file of Abaqus or CalculiX (`.inp`) with shells of four nodes; node and element sets become sets.

    Args:
        file: Path, relative to the model file.
        scale: Factor on all coordinates.
        points: Names for further points: each becomes a node set with the node nearest to the position.
        merge_coincident: Nodes that coincide without being connected, where parts were meshed apart: `true` merges
            them, `false` keeps them apart without a warning (a slit); unless given they stay apart with a warning.
        fold_angle: Angle (degrees), 1…180, from which on neighbouring elements form a fold and have directors of their
            own; 20 unless given.
    """

    file: str
    scale: Number | None = None
    points: Mapping[str, Numbers | str] | None = None
    merge_coincident: bool | None = None
    fold_angle: Number | None = None


class NastranMesh(Part, type="nastran"):
    """A bulk data file of Nastran (`.bdf`, `.nas`) with shells of four nodes; properties, supports and loads have sets.

    Args:
        file: Path, relative to the model file.
        scale: Factor on all coordinates.
        points: Names for further points: each becomes a node set with the node nearest to the position.
        merge_coincident: Nodes that coincide without being connected, where parts were meshed apart: `true` merges
            them, `false` keeps them apart without a warning (a slit); unless given they stay apart with a warning.
        fold_angle: Angle (degrees), 1…180, from which on neighbouring elements form a fold and have directors of their
            own; 20 unless given.
    """

    file: str
    scale: Number | None = None
    points: Mapping[str, Numbers | str] | None = None
    merge_coincident: bool | None = None
    fold_angle: Number | None = None


class VTUMesh(Part, type="vtu"):
    """A VTU file (`.vtu`) of VTK, ParaView or meshio with quadrilaterals; integer arrays become sets, numbers fields.

    Args:
        file: Path, relative to the model file.
        scale: Factor on all coordinates.
        points: Names for further points: each becomes a node set with the node nearest to the position.
        merge_coincident: Nodes that coincide without being connected, where parts were meshed apart: `true` merges
            them, `false` keeps them apart without a warning (a slit); unless given they stay apart with a warning.
        fold_angle: Angle (degrees), 1…180, from which on neighbouring elements form a fold and have directors of their
            own; 20 unless given.
    """

    file: str
    scale: Number | None = None
    points: Mapping[str, Numbers | str] | None = None
    merge_coincident: bool | None = None
    fold_angle: Number | None = None


MeshSource = (
    NoMesh
    | PlateMesh
    | CylinderMesh
    | AnnulusMesh
    | SphereMesh
    | ExtrusionMesh
    | ArraysMesh
    | GmshMesh
    | AbaqusMesh
    | NastranMesh
    | VTUMesh
)
"""The mid-surface."""


class BoxSet(Part, type="box"):
    """Everything in a box along the axes.

    Args:
        name: Name of the set.
        x: Range of x (length); everything unless given.
        y: Range of y (length); everything unless given.
        z: Range of z (length); everything unless given.
        within: Name of a set to choose from.
        tolerance: Distance up to which places outside count as inside (length); a millionth of the size of the mesh
            unless given.
    """

    name: str
    x: Numbers | None = None
    y: Numbers | None = None
    z: Numbers | None = None
    within: str | None = None
    tolerance: Number | None = None


class PlaneSet(Part, type="plane"):
    """Everything on a plane; edges inside the mesh, too.

    Args:
        name: Name of the set.
        at: A point of the plane (length). Or the name of a marker.
        normal: Direction normal to it. Or an axis of a marker, such as "NAME.z" or "-NAME.z".
        within: Name of a set to choose from.
        tolerance: Distance up to which places lie on the plane (length); a millionth of the size of the mesh unless
            given.
    """

    name: str
    at: Numbers | str
    normal: Numbers | str
    within: str | None = None
    tolerance: Number | None = None


class SphereSet(Part, type="sphere"):
    """Everything in a sphere, or between two.

    Args:
        name: Name of the set.
        at: Its centre (length). Or the name of a marker.
        radius: Its radius (length).
        inner_radius: Radius of a smaller sphere around the same centre that does not belong to it (length). Places on
            it do.
        within: Name of a set to choose from.
        tolerance: Distance up to which places outside count as inside (length); a millionth of the size of the mesh
            unless given.
    """

    name: str
    at: Numbers | str
    radius: Number
    inner_radius: Number | None = None
    within: str | None = None
    tolerance: Number | None = None


class CylinderSet(Part, type="cylinder"):
    """Everything in a cylinder, or between two.

    Args:
        name: Name of the set.
        at: A point of its axis (length). Or the name of a marker.
        axis: Direction of its axis. Or an axis of a marker, such as "NAME.z" or "-NAME.z".
        radius: Its radius (length).
        inner_radius: Radius of a smaller cylinder about the same axis that does not belong to it (length). Places on it
            do.
        within: Name of a set to choose from.
        tolerance: Distance up to which places outside count as inside (length); a millionth of the size of the mesh
            unless given.
    """

    name: str
    at: Numbers | str
    axis: Numbers | str
    radius: Number
    inner_radius: Number | None = None
    within: str | None = None
    tolerance: Number | None = None


class FormulaSet(Part, type="formula"):
    """Everything where inequalities in the coordinates hold.

    Args:
        name: Name of the set.
        where: Inequalities between formulas in `x`, `y` and `z` with `<`, `<=`, `>` and `>=`, joined by `and` and `or`,
            of which `and` binds first: `"0 <= x < 0.5 and sqrt(y^2 + z^2) >= 2"`.
        within: Name of a set to choose from.
        tolerance: Distance up to which places count as on the surface where both sides are equal (length); a millionth
            of the size of the mesh unless given.
    """

    name: str
    where: str
    within: str | None = None
    tolerance: Number | None = None


class NormalSet(Part, type="normal"):
    """Elements whose normal has a direction, and their nodes.

    Args:
        name: Name of the set.
        direction: Direction that the normals of the elements, on the side of the director, have. Or an axis of a
            marker, such as "NAME.z" or "-NAME.z".
        angle: Largest angle between the normal in the centre of an element and the direction (degrees).
        within: Name of a set to choose from.
    """

    name: str
    direction: Numbers | str
    angle: Number
    within: str | None = None


class BoundarySet(Part, type="boundary"):
    """Edges of the boundary, and their nodes.

    Args:
        name: Name of the set.
        near: A point (length): of the closed lines of the boundary, such as the rims of holes, the one with the node
            nearest to it. Without it the whole boundary. Or the name of a marker.
        within: Name of a set of elements, the boundary of which is meant.
    """

    name: str
    near: Numbers | str | None = None
    within: str | None = None


class UnionSet(Part, type="union"):
    """Everything in one of several sets.

    Args:
        name: Name of the set.
        of: Names of the sets: those of the mesh, and those that stand before this one.
    """

    name: str
    of: Sequence[str]


class IntersectionSet(Part, type="intersection"):
    """Everything in all of several sets.

    Args:
        name: Name of the set.
        of: Names of the sets: those of the mesh, and those that stand before this one.
    """

    name: str
    of: Sequence[str]


class DifferenceSet(Part, type="difference"):
    """Everything in the first of several sets that is in none of the others.

    Args:
        name: Name of the set.
        of: Names of the sets: those of the mesh, and those that stand before this one.
    """

    name: str
    of: Sequence[str]


MeshSet = (
    BoxSet
    | PlaneSet
    | SphereSet
    | CylinderSet
    | FormulaSet
    | NormalSet
    | BoundarySet
    | UnionSet
    | IntersectionSet
    | DifferenceSet
)
"""A named part of the mesh that conditions, loads, sections and results may use like those of the mesh. It holds nodes,
elements and edges: - the nodes in the part of space that its keys describe, - the elements with their centre in it, -
the edges of the boundary of the mesh with both ends and, up to a fifth of its length, the middle in it. Union,
intersection and difference combine the nodes, the elements and the edges of their sets, each by themselves. Places are
those of the mesh before imperfections."""


class ModeImperfection(Part, type="mode"):
    """Shape of a buckling mode of the nominal structure under the loads of the (first) analysis.

    Args:
        amplitude: Largest displacement of a node (length); its sign chooses the side.
        mode: Number of the mode in ascending order of the positive load factors, counted from 1.
    """

    amplitude: Number
    mode: Integer | None = None


class RandomImperfection(Part, type="random"):
    """Smooth random deviation along the normals.

    Args:
        amplitude: Largest displacement of a node along the normal (length).
        correlation_length: Correlation length ℓ (length): at the distance r the deviations have the correlation
            exp(−r²/2ℓ²).
        seed: Seed; the same seed gives the same deviations.
    """

    amplitude: Number
    correlation_length: Number
    seed: Integer | None = None


class WaveImperfection(Part, type="wave"):
    """Plane wave along the normals.

    Args:
        amplitude: Amplitude a (length); its sign chooses the side.
        direction: Direction d in which the wave changes; of any length but zero. Or an axis of a marker, such as
            "NAME.z" or "-NAME.z".
        wavelength: Wavelength ℓ (length).
        phase: Phase φ at the origin (degrees).
    """

    amplitude: Number
    direction: Numbers | str
    wavelength: Number
    phase: Number | None = None


class FileImperfection(Part, type="file"):
    """Displacements of nodes from a file.

    Args:
        file: Path of a table, relative to the model file: lines with the number of a node and its displacement,
            separated by commas, below an optional line `node,x,y,z`. Nodes that are not in it stay where they are.
        factor: Factor on all displacements.
    """

    file: str
    factor: Number | None = None


Imperfection = ModeImperfection | RandomImperfection | WaveImperfection | FileImperfection
"""Deviation of the reference geometry of the mesh from the nominal one, free of stress. Several of them add up."""


class Marker(Part):
    """Point with a name, and with axes x, y, z. Keys take the point as `"NAME"`, the directions of its axes as
    `"NAME.x"`, `"NAME.y"`, `"NAME.z"`, and the opposite ones as `"-NAME.x"`.

    Args:
        name: Name of the marker: letters, digits, blanks, `_` and `-`; it begins with a letter, a digit or `_`.
        at: Point in the reference configuration, along the axes of space, or of `on` from its origin (length).
        axes: Direction of the axis x, and a second direction in the plane of the axes x and y, along the axes of space
            or of `on`; these axes unless given. The axis z completes a right-handed base.
        on: Name of another marker or of a body, in whose frame `at` and `axes` are given.
    """

    name: str
    at: Numbers
    axes: Rows | None = None
    on: str | None = None
