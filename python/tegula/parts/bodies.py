"""Bodies, beams, springs and ties of the model file as classes; written by `scripts/python_classes.py` from `tegula schema`."""

from __future__ import annotations

from collections.abc import Sequence

from .._part import Integer, Integers, Keys, Number, Numbers, Part, Rows


class BoxShape(Part, type="box"):
    """Box with sides along the axes.

    Args:
        size: Sides along the axes 1, 2, 3 (length).
    """

    size: Numbers


class CylinderShape(Part, type="cylinder"):
    """Cylinder or, with `inner_radius`, tube about axis 1.

    Args:
        radius: Outer radius (length).
        length: Length along axis 1.
        inner_radius: Inner radius (length); 0 unless given.
    """

    radius: Number
    length: Number
    inner_radius: Number | None = None


class SphereShape(Part, type="sphere"):
    """Ball.

    Args:
        radius: Radius (length).
    """

    radius: Number


class RodShape(Part, type="rod"):
    """Rod along axis 1 without inertia about it.

    Args:
        length: Length along axis 1.
    """

    length: Number


class STLShape(Part, type="stl"):
    """Solid within the closed surface of triangles in an STL file.

    Args:
        file: Path of the file, relative to the model file; ASCII or binary.
        scale: Factor on all coordinates of the file: 0.001 turns millimetres into metres.
    """

    file: str
    scale: Number | None = None


BodyShape = BoxShape | CylinderShape | SphereShape | RodShape | STLShape
"""Homogeneous body, by its axes 1, 2, 3."""


class RigidBody(Part):
    """A rigid body, or with `mass` alone, without `inertia`, `shape`, `attached` and `distributed`, a point mass.

    Args:
        name: Name of the body in joints and results.
        at: Mass centre in the reference configuration; of a body with the shape `stl` the place of the origin of the
            file, from which the mass centre follows (length). Or the name of a marker.
        mass: Mass; of a body with a shape this or `density`. Kinematic analyses need none.
        inertia: Moments of inertia J11, J22, J33 about the mass centre, along the axes of the body [mass·length²].
        products_of_inertia: Components J12, J13, J23 of the inertia tensor, `J12 = −∫ρ X1 X2 dV` [mass·length²]; 0
            unless given.
        shape: Shape, from which the inertia is computed.
        density: Density of a body with a shape [mass/length³].
        axes: Direction of the first axis of the body, and a second direction in the plane of the first two axes; the
            axes of space unless given.
        attached: Node sets of the mesh whose nodes are fixed in the body, with their directors: a rigid patch of the
            shell. The body needs no mass of its own then.
        distributed: Sets of the mesh whose weighted mean motion the body follows, and to whose nodes it distributes its
            forces and moments: a distributing coupling (RBE3), which does not stiffen the shell. Nodes have the lengths
            or areas around them as weights. The body needs no mass of its own then.
        weights: Weights of the nodes of the `distributed` sets, a number for each set, in place of the lengths or areas
            around them. A node of several sets has the sum of their weights.
        velocity: Velocity of the mass centre at the start [length/time].
        angular_velocity: Angular velocity at the start, along the axes of space [rad/time].
    """

    name: str
    at: Numbers | str
    mass: Number | None = None
    inertia: Numbers | None = None
    products_of_inertia: Numbers | None = None
    shape: BodyShape | Keys | None = None
    density: Number | None = None
    axes: Sequence[Numbers | str] | None = None
    attached: Sequence[str] | None = None
    distributed: Sequence[str] | None = None
    weights: Numbers | None = None
    velocity: Numbers | None = None
    angular_velocity: Numbers | None = None


class RectangleBeamSection(Part, type="rectangle"):
    """Rectangle.

    Args:
        size: Sides along the axes 1 and 2 (length).
    """

    size: Numbers


class CircleBeamSection(Part, type="circle"):
    """Circle, or ring with an inner radius.

    Args:
        radius: Outer radius (length).
        inner_radius: Inner radius (length); 0 unless given.
    """

    radius: Number
    inner_radius: Number | None = None


class BoxBeamSection(Part, type="box"):
    """Rectangular hollow section with walls of one thickness (box).

    Args:
        size: Outer sides along the axes 1 and 2 (length).
        thickness: Thickness of the walls (length).
    """

    size: Numbers
    thickness: Number


class ConstantsBeamSection(Part, type="constants"):
    """Section constants.

    Args:
        axial: Axial stiffness EA \\[force\\].
        shear: Shear stiffness kGA along the axes 1 and 2 \\[force\\].
        bending: Bending stiffness EI about the axes 1 and 2 [force·length²].
        torsion: Torsional stiffness GJ [force·length²].
        mass: Mass per length; it may be 0 in statics.
        inertia: Moments of inertia per length about the axes 1 and 2 [mass·length]; that about the axis of the beam is
            their sum. They may be 0 in statics.
    """

    axial: Number
    shear: Numbers
    bending: Numbers
    torsion: Number
    mass: Number
    inertia: Numbers


BeamSection = RectangleBeamSection | CircleBeamSection | BoxBeamSection | ConstantsBeamSection
"""Cross-section of a beam."""


class Beam(Part):
    """A shear-deformable beam. Its nodes are rigid cross-sections: joints, loads and springs name them `beam.start`,
    `beam.1`, `beam.2`, …, `beam.end` for a beam called `beam`.

    Args:
        name: Name of the beam in results, and first part of the names of its nodes.
        points: Axis of the beam in the reference configuration: both ends of a straight beam, or all nodes of a curved
            one (length).
        direction: Direction of axis 1 of the cross-section at the start; it is projected across the axis of the beam.
            Axis 3 is the tangent from the first to the last point, axis 2 completes a right-handed base. Or an axis of
            a marker, such as "NAME.z" or "-NAME.z".
        section: Cross-section: a shape of the `material`, or section constants.
        elements: Number of elements of a straight beam.
        twist: Rotation of the cross-section about the tangent from the start to the end (degrees), in proportion to the
            length.
        material: Name of an isotropic material; needed by sections of a shape.
        attached: Names of sets of shell nodes, such as a line of the mesh, that move with the cross-sections of the
            beam: each with the node of the beam beside which it lies, at any distance across the axis. The beam
            stiffens the shell.
        velocity: Velocity of the first point at the start [length/time].
        angular_velocity: Angular velocity of the whole beam about its first point at the start, along the axes of space
            [rad/time].
        retardation_time: Retardation time τ of Kelvin–Voigt damping, `n = C (ε + τ ε̇)`.
        history: Nodes whose motion appears in the history, counted from 0; both ends unless given.
    """

    name: str
    points: Sequence[Numbers | str]
    direction: Numbers | str
    section: BeamSection | Keys
    elements: Integer | None = None
    twist: Number | None = None
    material: str | None = None
    attached: Sequence[str] | None = None
    velocity: Numbers | None = None
    angular_velocity: Numbers | None = None
    retardation_time: Number | None = None
    history: Integers | None = None


class SpringDamper(Part):
    """A spring with a damper between two points.

    Args:
        name: Name of the spring in messages.
        between: Both sides: names of bodies, of sets with one node or of sets of elements (the point of one of them),
            or `ground`.
        points: Point of the first and point of the second one, in the reference configuration (length).
        stiffness: Stiffness [force/length].
        damping: Damping: force per rate of the length [force·time/length].
        force: Force that draws the points together, as a formula in the elongation `x` (length), its rate `v` and the
            time `t`, in place of `stiffness` and `damping`. A formula in `t` is an actuator.
        across: Direction of an axis through the first point, which moves with the first side, in the reference
            configuration. The length of the spring is then the distance of the second point from this axis, and its
            force acts across it. Or an axis of a marker, such as "NAME.z" or "-NAME.z".
        length: Length from which the elongation counts, without force where `stiffness` acts; the distance of the
            points unless given.
    """

    name: str
    between: Sequence[str]
    points: Sequence[Numbers | str]
    stiffness: Number | None = None
    damping: Number | None = None
    force: str | None = None
    across: Numbers | str | None = None
    length: Number | None = None


class TorsionSpring(Part):
    """A torsion spring with a damper about the common axis of two bodies, beside a joint that lets them turn about it.

    Args:
        name: Name of the spring in messages and results.
        between: Both sides: names of bodies or of nodes of beams, or `ground`.
        axis: Direction of the axis in the reference configuration. Or an axis of a marker, such as "NAME.z" or
            "-NAME.z".
        stiffness: Stiffness [force·length/rad].
        damping: Damping: moment per rate of the angle [force·length·time/rad].
        moment: Moment that turns the sides back, as a formula in the angle `x` from the free angle (rad), its rate `v`
            (rad/time) and the time `t`, in place of `stiffness` and `damping`. A formula in `t` is an actuator.
        free_angle: Angle from which that of the spring counts, without moment where `stiffness` acts: of the second
            side relative to the first one and right-handed about the axis (degrees); 0 is the reference configuration.
    """

    name: str
    between: Sequence[str]
    axis: Numbers | str
    stiffness: Number | None = None
    damping: Number | None = None
    moment: str | None = None
    free_angle: Number | None = None


class Bushing(Part):
    """A bushing between two bodies: forces and moments that depend linearly on the displacement of its points, its
    rotation vector and their rates, along axes that move with the first side. The order of all sixes is: displacement
    along the axes 1, 2, 3, rotation about the axes 1, 2, 3.

    Args:
        name: Name of the bushing in messages and results.
        between: Both sides: names of bodies or of nodes of beams, or `ground`. The axes move with the first one. The
            second one may be a point mass or a set with one node where the bushing has no stiffness and damping of
            rotations.
        at: Place of the bushing in the reference configuration: the point of both sides whose distance it resists
            (length). Or the name of a marker.
        axes: Direction of the first axis, and a second direction in the plane of the first two axes, in the reference
            configuration; the axes of space unless given.
        stiffness: Stiffness of displacements [force/length] and of rotations [force·length/rad].
        stiffness_matrix: Full stiffness matrix instead of `stiffness`, by rows: symmetric, without negative
            eigenvalues.
        damping: Damping of displacements [force·time/length] and of rotations [force·length·time/rad].
        damping_matrix: Full damping matrix instead of `damping`, by rows: symmetric, without negative eigenvalues.
        free: Displacement (length) and rotation vector (degrees) at which the springs have no force: a preload; zero
            unless given.
    """

    name: str
    between: Sequence[str]
    at: Numbers | str
    axes: Sequence[Numbers | str] | None = None
    stiffness: Numbers | None = None
    stiffness_matrix: Rows | None = None
    damping: Numbers | None = None
    damping_matrix: Rows | None = None
    free: Numbers | None = None


class Tie(Part):
    """A tie: nodes follow the elements of another mesh, which need not have nodes there.

    Args:
        name: Name of the tie in messages and results.
        on: Name of a node or edge set whose nodes follow: of the two meshes that of the finer one.
        to: Name of the set of elements that they follow, in or on which they lie.
        rotations: Whether rotations follow, too; else the tie is a hinge.
    """

    name: str
    on: str
    to: str
    rotations: bool | None = None
