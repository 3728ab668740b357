"""Sensors and output of the model file as classes; written by `scripts/python_classes.py` from `tegula schema`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from .._part import Integer, Integers, Keys, Number, Numbers, Part


class DistanceSensor(Part, type="distance"):
    """Distance of two points, and its rate.

    Args:
        name: Name of the sensor in results.
        between: Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them),
            or `ground`.
        points: Point of the first and point of the second one, in the reference configuration (length).
    """

    name: str
    between: Sequence[str]
    points: Sequence[Numbers | str]


class AngleSensor(Part, type="angle"):
    """Angle of one body relative to another about an axis, and its rate.

    Args:
        name: Name of the sensor in results.
        between: Both sides: names of bodies or of nodes of beams, or `ground`.
        axis: Direction of the axis in the reference configuration. The angle is that of the second side relative to the
            first one, right-handed about the axis and 0 in the reference configuration (degrees); it counts full turns.
            Or an axis of a marker, such as "NAME.z" or "-NAME.z".
    """

    name: str
    between: Sequence[str]
    axis: Numbers | str


class PointSensor(Part, type="point"):
    """Position, velocity and acceleration of a point.

    Args:
        name: Name of the sensor in results.
        on: Name of a body, of a set with one node or of a set of elements.
        at: Point of the body in the reference configuration (length); its mass centre unless given. Or the name of a
            marker.
    """

    name: str
    on: str
    at: Numbers | str | None = None


class ReactionSensor(Part, type="reaction"):
    """Magnitudes of the force and the moment in a joint.

    Args:
        name: Name of the sensor in results.
        joint: Name of the joint, or of a body with `distributed` nodes; the components are columns of the history
            without a sensor.
    """

    name: str
    joint: str


class VolumeSensor(Part, type="volume"):
    """Volume that a surface encloses, and its rate.

    Args:
        name: Name of the sensor in results.
        on: Name of a set of elements. A closed surface whose directors point outwards has a positive volume.
        tip: Tip of the cone over a surface that is open (length): its volume counts. On planes of symmetry that cut the
            surface the tip makes it that of the part on this side of them. Or the name of a marker.
    """

    name: str
    on: str
    tip: Numbers | str | None = None


class StrainSensor(Part, type="strain"):
    """Elongation of a material line of a shell, and its rate: a strain gauge.

    Args:
        name: Name of the sensor in results.
        on: Name of a set of elements.
        at: Point of one of the elements in the reference configuration (length), at any height between the faces: on a
            face for the strain there, on the mid-surface for that of the membrane. Or the name of a marker.
        direction: Direction of the line in the reference configuration; it is projected along the director onto the
            surface. Or an axis of a marker, such as "NAME.z" or "-NAME.z".
    """

    name: str
    on: str
    at: Numbers | str
    direction: Numbers | str


Sensor = DistanceSensor | AngleSensor | PointSensor | ReactionSensor | VolumeSensor | StrainSensor
"""Sensor: a quantity of the motion with columns `sensor.NAME.…` in the history, on which stop conditions may depend."""


class OutputPoint(Part):
    """A point whose motion is recorded.

    Args:
        name: Name of the point in histories, plots and `summary.json`.
        on: Name of a node set with exactly one node.
        at: Position in the reference configuration (length); the nearest node is taken. Or the name of a marker.
    """

    name: str
    on: str | None = None
    at: Numbers | str | None = None


class Cut(Part):
    """Cut along a line of the mesh, whose resultant force and moment are the columns `cut.NAME.fx` … `mz` of the
    history: the nodal forces of the elements of the set `of` at the nodes of the line, summed. They are the force and
    the moment that the rest of the model exerts on these elements across the line. Supports, joints, loads and inertia
    at the nodes of the line belong to the rest.

    Args:
        name: Name of the cut in histories and `summary.json`.
        on: Name of a set of nodes or edges: the line of the cut.
        of: Name of a set of elements: the part on one side of the line, on which the force and the moment act.
        about: Point of space about which the moment is taken (length); the mean of the line's nodes in the current
            configuration unless given, in linear analyses in the reference configuration. Or the name of a marker.
    """

    name: str
    on: str
    of: str
    about: Numbers | str | None = None


Field = Literal[
    "displacement",
    "director",
    "velocity",
    "reaction",
    "membrane",
    "bending",
    "shear",
    "surface-stress",
    "von-mises",
    "energy-density",
    "ply-stress",
    "failure",
    "plastic-strain",
    "principal-stress",
    "nodal-means",
    "axes",
    "numbers",
]
"""Fields of the result files.

`displacement`: Displacement of the nodes (length).
`director`: Director at the nodes.
`velocity`: Velocity of the nodes [length/time].
`reaction`: Reactions at the nodes: force, and moment of the forces on directors.
`membrane`: Membrane resultants n_xx, n_yy, n_xy in the element's cross-section frame [force/length].
`bending`: Bending resultants m_xx, m_yy, m_xy in the element's cross-section frame (force).
`shear`: Transverse shear resultants q_xz, q_yz in the element's cross-section frame [force/length].
`surface-stress`: In-plane stresses at the top and bottom surface [force/area].
`von-mises`: Greatest von Mises stress of top, middle and bottom [force/area].
`energy-density`: Strain energy per reference area [energy/area].
`ply-stress`: Stresses σ11, σ22, τ12 at the bottom, the middle and the top of each ply, in its axes [force/area].
`failure`: Tsai–Wu index, reserve factor and greatest stress over strength of the worst ply, and its number from the
    bottom; where materials have strengths.
`plastic-strain`: Greatest equivalent plastic strain; where materials are plastic.
`principal-stress`: Principal stresses in the plane at the top and bottom surface, the greater one first, and the angle
    from x to its direction [force/area, degrees].
`nodal-means`: Means over the elements at a node, weighted by area: von Mises stress, and the stresses at the top and
    bottom surface in the axes of space [force/area].
`axes`: Axes x, y, z of each element's cross-section frame at the reference.
`numbers`: Numbers of nodes and elements as messages use them, and number of the section from 1.
"""


class Still(Part):
    """Picture of the shape coloured by a field, drawn when the run is complete, as `tegula render` draws it.

    Args:
        file: Name of the file in the result folder, which ends with `.png` or `.svg`.
        field: Field that gives the colours, such as `von_mises`, `displacement.z` or `stress_top.1`; `none` for one
            colour. The von Mises stress unless given, or the size of the displacement where field files have no stress.
        at: State that is drawn: the one nearest to this time, load factor or position on the path; the last one unless
            given.
        mode: Number of the mode that is drawn; the first one unless given.
        view: Azimuth and elevation of the viewer (degrees): the angle from the x axis towards the y axis, and the
            height above the xy plane.
        scale: Factor on the displacements; 1 unless given, of modes a tenth of the size of the model over the largest
            displacement.
        range: Values at both ends of the colours; the smallest and the largest one unless given.
        size: Width and height (pixels).
    """

    file: str
    field: str | None = None
    at: Number | None = None
    mode: Integer | None = None
    view: Numbers | None = None
    scale: Number | None = None
    range: Numbers | None = None
    size: Integers | None = None


class Units(Part):
    """Names of the units of the model, such as `length = "mm"`: for the labels of pictures. Numbers do not change.

    Args:
        length: Unit of length.
        time: Unit of time.
        force: Unit of force.
        stress: Unit of stress; that of force over the square of that of length unless given.
        energy: Unit of energy; that of force times that of length unless given.
        frequency: Unit of frequency; one over that of time unless given.
    """

    length: str | None = None
    time: str | None = None
    force: str | None = None
    stress: str | None = None
    energy: str | None = None
    frequency: str | None = None


class Output(Part):
    """Results that a run writes.

    Args:
        points: Points whose motion is recorded at every step.
        cuts: Cuts whose section forces and moments are recorded at every step.
        fields: Fields in the VTU files; all but `ply-stress` unless given. Values: `displacement`, `director`,
            `velocity`, `reaction`, `membrane`, `bending`, `shear`, `surface-stress`, `von-mises`, `energy-density`,
            `ply-stress`, `failure`, `plastic-strain`, `principal-stress`, `nodal-means`, `axes`, `numbers`.
        interval: Time (load factor) between two field files; 0 writes every step. Unless this or `every` is given, at
            most 200 files are written, evenly in time. The first and the last state are always written.
        every: Number of steps from one field file to the next, instead of `interval`.
        at: Times (load factors) at which a step ends and a field file is written, whatever `interval` or `every` says.
        deformed: Field files hold the deformed mesh instead of the reference one, which *Warp By Vector* deforms.
        units: Names of units for the labels of pictures.
        pictures: Draw pictures (`*.png`) at the end of the run; true unless given.
        stills: Pictures whose field, view and scale are given, in addition to `pictures`.
    """

    points: Sequence[OutputPoint | Keys] | None = None
    cuts: Sequence[Cut | Keys] | None = None
    fields: Sequence[Field] | None = None
    interval: Number | None = None
    every: Integer | None = None
    at: Numbers | None = None
    deformed: bool | None = None
    units: Units | Keys | None = None
    pictures: bool | None = None
    stills: Sequence[Still | Keys] | None = None
