"""Joints of the model file as classes; written by `scripts/python_classes.py` from `tegula schema`."""

from __future__ import annotations

from collections.abc import Sequence

from .._part import Keys, Number, Numbers, Part


class JointFriction(Part):
    """Coulomb friction of a joint: the friction force of a prismatic joint is at most `μ |N| + preload`, the friction
    torque of a revolute joint `μ r |N| + preload`, with the reaction force N of the joint across its axis.

    Args:
        coefficient: Coefficient μ of sliding friction.
        static_coefficient: Coefficient of static friction, not below that of sliding friction, to which it is equal
            unless given.
        radius: Radius r of the bearing of a revolute joint (length).
        preload: Constant part of the friction force (force), or torque (force·length), whatever the reaction of the
            joint.
    """

    coefficient: Number | None = None
    static_coefficient: Number | None = None
    radius: Number | None = None
    preload: Number | None = None


class JointStops(Part):
    """Stops of a joint: limits of the displacement of the second side relative to the first one along the axis, or of
    its angle about the axis, both zero in the reference configuration.

    Args:
        lower: Smallest displacement (length), or angle (degrees); none unless given.
        upper: Largest displacement (length), or angle (degrees); none unless given.
        restitution: Coefficient of restitution e, from 0 (plastic impact) to 1: the relative velocity behind an impact
            is −e times that before.
    """

    lower: Number | None = None
    upper: Number | None = None
    restitution: Number | None = None


class FixedJoint(Part, type="fixed"):
    """No relative motion.

    Args:
        name: Name of the joint in messages and results.
        between: Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them),
            or `ground`.
        at: Point of the joint in the reference configuration (length). Or the name of a marker.
        second_at: Point of the joint on the second side, in the reference configuration (length); that of the first one
            unless given. Where both do not meet, the model is assembled at the start. Or the name of a marker.
    """

    name: str
    between: Sequence[str]
    at: Numbers | str
    second_at: Numbers | str | None = None


class SphericalJoint(Part, type="spherical"):
    """Ball joint: the points coincide.

    Args:
        name: Name of the joint in messages and results.
        between: Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them),
            or `ground`.
        at: Point of the joint in the reference configuration (length). Or the name of a marker.
        second_at: Point of the joint on the second side, in the reference configuration (length); that of the first one
            unless given. Where both do not meet, the model is assembled at the start. Or the name of a marker.
    """

    name: str
    between: Sequence[str]
    at: Numbers | str
    second_at: Numbers | str | None = None


class RevoluteJoint(Part, type="revolute"):
    """Hinge: rotation about the axis.

    Args:
        name: Name of the joint in messages and results.
        between: Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them),
            or `ground`.
        at: Point of the joint in the reference configuration (length). Or the name of a marker.
        axis: Direction of the axis in the reference configuration. Or an axis of a marker, such as "NAME.z" or
            "-NAME.z".
        second_at: Point of the joint on the second side, in the reference configuration (length); that of the first one
            unless given. Where both do not meet, the model is assembled at the start. Or the name of a marker.
        second_axis: Direction of the axis on the second side, in the reference configuration; that of the first one
            unless given. Or an axis of a marker, such as "NAME.z" or "-NAME.z".
        friction: Coulomb friction of the relative motion; in transient analyses with the scheme `energy-momentum`.
        stops: Stops of the relative motion; in transient analyses with the scheme `energy-momentum`.
    """

    name: str
    between: Sequence[str]
    at: Numbers | str
    axis: Numbers | str
    second_at: Numbers | str | None = None
    second_axis: Numbers | str | None = None
    friction: JointFriction | Keys | None = None
    stops: JointStops | Keys | None = None


class UniversalJoint(Part, type="universal"):
    """Cardan joint: the points coincide, the two axes stay perpendicular.

    Args:
        name: Name of the joint in messages and results.
        between: Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them),
            or `ground`.
        at: Point of the joint in the reference configuration (length). Or the name of a marker.
        axes: Axis fixed in the first body and axis fixed in the second one, perpendicular to each other, in the
            reference configuration.
        second_at: Point of the joint on the second side, in the reference configuration (length); that of the first one
            unless given. Where both do not meet, the model is assembled at the start. Or the name of a marker.
    """

    name: str
    between: Sequence[str]
    at: Numbers | str
    axes: Sequence[Numbers | str]
    second_at: Numbers | str | None = None


class CylindricalJoint(Part, type="cylindrical"):
    """Rotation about the axis and sliding along it.

    Args:
        name: Name of the joint in messages and results.
        between: Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them),
            or `ground`.
        at: Point of the joint in the reference configuration (length). Or the name of a marker.
        axis: Direction of the axis in the reference configuration. Or an axis of a marker, such as "NAME.z" or
            "-NAME.z".
        second_at: Point of the joint on the second side, in the reference configuration (length); that of the first one
            unless given. Where both do not meet, the model is assembled at the start. Or the name of a marker.
        second_axis: Direction of the axis on the second side, in the reference configuration; that of the first one
            unless given. Or an axis of a marker, such as "NAME.z" or "-NAME.z".
    """

    name: str
    between: Sequence[str]
    at: Numbers | str
    axis: Numbers | str
    second_at: Numbers | str | None = None
    second_axis: Numbers | str | None = None


class ScrewJoint(Part, type="screw"):
    """Rotation about the axis, and sliding along it by the pitch in each turn.

    Args:
        name: Name of the joint in messages and results.
        between: Both sides: names of bodies, or `ground`.
        at: Point of the joint in the reference configuration (length). Or the name of a marker.
        axis: Direction of the axis in the reference configuration. Or an axis of a marker, such as "NAME.z" or
            "-NAME.z".
        pitch: Displacement of the second side relative to the first one along the axis per turn, right-handed about the
            axis (length); negative for left-hand threads.
        second_at: Point of the joint on the second side, in the reference configuration (length); that of the first one
            unless given. Where both do not meet, the model is assembled at the start. Or the name of a marker.
        second_axis: Direction of the axis on the second side, in the reference configuration; that of the first one
            unless given. Or an axis of a marker, such as "NAME.z" or "-NAME.z".
    """

    name: str
    between: Sequence[str]
    at: Numbers | str
    axis: Numbers | str
    pitch: Number
    second_at: Numbers | str | None = None
    second_axis: Numbers | str | None = None


class RackAndPinionJoint(Part, type="rack-and-pinion"):
    """The pinion, the second side, rolls on the rack, the first one: it moves along it by the radius times its angle.

    Args:
        name: Name of the joint in messages and results.
        between: Rack and pinion: names of bodies, or `ground`.
        at: Centre of the pinion in the reference configuration (length). Or the name of a marker.
        axis: Direction of the axis of the pinion in the reference configuration. Or an axis of a marker, such as
            "NAME.z" or "-NAME.z".
        direction: Direction of the rack in the reference configuration, perpendicular to the axis. Or an axis of a
            marker, such as "NAME.z" or "-NAME.z".
        radius: Radius of the pitch circle: displacement of the centre relative to the rack along its direction per
            radian, right-handed about the axis (length per rad); negative where the rack lies on the other side.
    """

    name: str
    between: Sequence[str]
    at: Numbers | str
    axis: Numbers | str
    direction: Numbers | str
    radius: Number


class GearJoint(Part, type="gear"):
    """Gears: the angles of two wheels about their axes in a carrier have a constant ratio.

    Args:
        name: Name of the joint in messages and results.
        between: Both wheels: names of bodies, or `ground`.
        axes: Directions of the axes of both wheels in the reference configuration; they are fixed in the carrier.
            Angles are right-handed about them.
        carrier: Body in which the hinges of both wheels lie, and relative to which their angles count: the name of a
            body, or `ground`.
        radii: Radii of the pitch circles (length), or numbers of teeth, of which only the ratio counts: the first
            angular velocity is minus the second radius over the first one times the second one. A negative radius is
            that of a wheel with internal teeth. Parallel axes point in the same direction, those of bevel gears both
            away from their apex, or both towards it.
        ratio: Ratio of the angular velocities, that of the first wheel over that of the second one, in place of
            `radii`; negative where they turn in opposite senses.
    """

    name: str
    between: Sequence[str]
    axes: Sequence[Numbers | str]
    carrier: str | None = None
    radii: Numbers | None = None
    ratio: Number | None = None


class PointOnCurveJoint(Part, type="point-on-curve"):
    """A point of the second side moves along a smooth curve that is fixed in the first one.

    Args:
        name: Name of the joint in messages and results.
        between: Side in which the curve is fixed, a body or `ground`, and side of the point: the name of a body or of a
            set with one node.
        at: Point of the second side in the reference configuration, on the curve (length); any of `points` is. Or the
            name of a marker.
        points: Points through which the curve goes in the reference configuration, in this order (length): it is a
            cubic spline, whose curvature is continuous.
        closed: Whether the curve is closed: a smooth piece connects its last point with the first one.
    """

    name: str
    between: Sequence[str]
    at: Numbers | str
    points: Sequence[Numbers | str]
    closed: bool | None = None


class PrismaticJoint(Part, type="prismatic"):
    """Sliding along the axis without rotation.

    Args:
        name: Name of the joint in messages and results.
        between: Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them),
            or `ground`.
        at: Point of the joint in the reference configuration (length). Or the name of a marker.
        axis: Direction of the axis in the reference configuration. Or an axis of a marker, such as "NAME.z" or
            "-NAME.z".
        second_at: Point of the joint on the second side, in the reference configuration (length); that of the first one
            unless given. Where both do not meet, the model is assembled at the start. Or the name of a marker.
        second_axis: Direction of the axis on the second side, in the reference configuration; that of the first one
            unless given. Or an axis of a marker, such as "NAME.z" or "-NAME.z".
        friction: Coulomb friction of the relative motion; in transient analyses with the scheme `energy-momentum`.
        stops: Stops of the relative motion; in transient analyses with the scheme `energy-momentum`.
    """

    name: str
    between: Sequence[str]
    at: Numbers | str
    axis: Numbers | str
    second_at: Numbers | str | None = None
    second_axis: Numbers | str | None = None
    friction: JointFriction | Keys | None = None
    stops: JointStops | Keys | None = None


class PlanarJoint(Part, type="planar"):
    """Motion in the plane across the axis, and rotation about it.

    Args:
        name: Name of the joint in messages and results.
        between: Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them),
            or `ground`.
        at: Point of the joint in the reference configuration (length). Or the name of a marker.
        axis: Direction of the axis in the reference configuration. Or an axis of a marker, such as "NAME.z" or
            "-NAME.z".
        second_at: Point of the joint on the second side, in the reference configuration (length); that of the first one
            unless given. Where both do not meet, the model is assembled at the start. Or the name of a marker.
        second_axis: Direction of the axis on the second side, in the reference configuration; that of the first one
            unless given. Or an axis of a marker, such as "NAME.z" or "-NAME.z".
    """

    name: str
    between: Sequence[str]
    at: Numbers | str
    axis: Numbers | str
    second_at: Numbers | str | None = None
    second_axis: Numbers | str | None = None


class DrivenAngleJoint(Part, type="driven-angle"):
    """Prescribed rotation about an axis, beside a revolute or cylindrical joint.

    Args:
        name: Name of the joint in messages and results.
        between: Both sides: names of bodies, or `ground`.
        axis: Direction of the axis in the reference configuration, about which another joint lets the two sides turn.
            Or an axis of a marker, such as "NAME.z" or "-NAME.z".
        angle: Rotation of the second side relative to the first one per unit of the amplitude, right-handed about the
            axis (degrees). It begins where the joint stands at the start of the analysis step.
        amplitude: Name of the amplitude, of whose change the motion is a multiple.
    """

    name: str
    between: Sequence[str]
    axis: Numbers | str
    angle: Number
    amplitude: str


class DrivenLengthJoint(Part, type="driven-length"):
    """Prescribed displacement along an axis, beside a prismatic or cylindrical joint.

    Args:
        name: Name of the joint in messages and results.
        between: Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them),
            or `ground`.
        at: Point of both sides in the reference configuration (length). Or the name of a marker.
        axis: Direction of the axis in the reference configuration; it is fixed in the first side. Or an axis of a
            marker, such as "NAME.z" or "-NAME.z".
        length: Displacement of the second side relative to the first one along the axis per unit of the amplitude
            (length). It begins where the joint stands at the start of the analysis step.
        amplitude: Name of the amplitude, of whose change the motion is a multiple.
    """

    name: str
    between: Sequence[str]
    at: Numbers | str
    axis: Numbers | str
    length: Number
    amplitude: str


class DirectorAlignmentJoint(Part, type="director-alignment"):
    """The director of a shell node stays parallel to an axis of the other side.

    Args:
        name: Name of the joint in messages and results.
        between: Both sides: the name of a set with one node of a shell, and that of a body or `ground`.
    """

    name: str
    between: Sequence[str]


class ClampedDirectorJoint(Part, type="clamped-director"):
    """The points coincide and the director of a shell node stays parallel to an axis of the other side: fixed but for
    drilling.

    Args:
        name: Name of the joint in messages and results.
        between: Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them),
            or `ground`.
        at: Point of the joint in the reference configuration (length). Or the name of a marker.
        second_at: Point of the joint on the second side, in the reference configuration (length); that of the first one
            unless given. Where both do not meet, the model is assembled at the start. Or the name of a marker.
    """

    name: str
    between: Sequence[str]
    at: Numbers | str
    second_at: Numbers | str | None = None


class DistanceJoint(Part, type="distance"):
    """Rod without mass: the distance of two points is constant.

    Args:
        name: Name of the joint in messages and results.
        between: Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them),
            or `ground`.
        points: Point of the first and point of the second one, in the reference configuration (length).
    """

    name: str
    between: Sequence[str]
    points: Sequence[Numbers | str]


Joint = (
    FixedJoint
    | SphericalJoint
    | RevoluteJoint
    | UniversalJoint
    | CylindricalJoint
    | ScrewJoint
    | RackAndPinionJoint
    | GearJoint
    | PointOnCurveJoint
    | PrismaticJoint
    | PlanarJoint
    | DrivenAngleJoint
    | DrivenLengthJoint
    | DirectorAlignmentJoint
    | ClampedDirectorJoint
    | DistanceJoint
)
"""A joint between two bodies, nodes or the ground."""
