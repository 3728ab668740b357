"""Supports, loads, masses and functions of time of the model file as classes; written by `scripts/python_classes.py` from `tegula schema`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from .._part import Keys, Number, Numbers, Part


class FieldName(Part):
    """Array of the mesh file, by its name.

    Args:
        field: Name of an array with one number for each point or cell of the mesh file; values of points are
            interpolated within the elements.
    """

    field: str


Distribution = str | FieldName | Keys
"""Factor that varies over the surface."""


Ground = Literal["stands", "turns"]
"""Motion of the ground of a model that turns.

`stands`: It stands still, as a bearing.
`turns`: It turns with the model, as a hub.
"""


class ForceLoad(Part, type="force"):
    """A force on every node of a set.

    Args:
        on: Name of the set: nodes for force and moment, edges for edge loads, quads (or `"all"`) for traction.
        value: The load as a vector `[x, y, z]` in global axes: force, moment, or either per length or area.
        distribution: Factor on the value in each place: a formula in the coordinates `x`, `y` and `z` of the reference
            configuration, such as `"1 - z/2"`, or an array of the mesh file, such as `{ field = "p" }`.
        amplitude: Name of an amplitude; without one the load grows with the load factor in statics and is constant in
            transients.
    """

    on: str
    value: Numbers
    distribution: Distribution | None = None
    amplitude: str | None = None


class MomentLoad(Part, type="moment"):
    """A moment on every node of a set; it rotates the director and stays constant in space. Its drilling component
    (along the director) is dropped, but on nodes that are attached to a body, which takes all components.

    Args:
        on: Name of the set: nodes for force and moment, edges for edge loads, quads (or `"all"`) for traction.
        value: The load as a vector `[x, y, z]` in global axes: force, moment, or either per length or area.
        distribution: Factor on the value in each place: a formula in the coordinates `x`, `y` and `z` of the reference
            configuration, such as `"1 - z/2"`, or an array of the mesh file, such as `{ field = "p" }`.
        amplitude: Name of an amplitude; without one the load grows with the load factor in statics and is constant in
            transients.
    """

    on: str
    value: Numbers
    distribution: Distribution | None = None
    amplitude: str | None = None


class FollowerForceLoad(Part, type="follower-force"):
    """A force on every node of a set, or on a body, that turns with it; its components are those in the reference
    configuration.

    Args:
        on: Name of the set: nodes for force and moment, edges for edge loads, quads (or `"all"`) for traction.
        value: The load as a vector `[x, y, z]` in global axes: force, moment, or either per length or area.
        distribution: Factor on the value in each place: a formula in the coordinates `x`, `y` and `z` of the reference
            configuration, such as `"1 - z/2"`, or an array of the mesh file, such as `{ field = "p" }`.
        amplitude: Name of an amplitude; without one the load grows with the load factor in statics and is constant in
            transients.
    """

    on: str
    value: Numbers
    distribution: Distribution | None = None
    amplitude: str | None = None


class FollowerMomentLoad(Part, type="follower-moment"):
    """A moment on every node of a set, or on a body, that turns with it; its components are those in the reference
    configuration.

    Args:
        on: Name of the set: nodes for force and moment, edges for edge loads, quads (or `"all"`) for traction.
        value: The load as a vector `[x, y, z]` in global axes: force, moment, or either per length or area.
        distribution: Factor on the value in each place: a formula in the coordinates `x`, `y` and `z` of the reference
            configuration, such as `"1 - z/2"`, or an array of the mesh file, such as `{ field = "p" }`.
        amplitude: Name of an amplitude; without one the load grows with the load factor in statics and is constant in
            transients.
    """

    on: str
    value: Numbers
    distribution: Distribution | None = None
    amplitude: str | None = None


class EdgeLoad(Part, type="edge"):
    """A force per length of an edge.

    Args:
        on: Name of the set: nodes for force and moment, edges for edge loads, quads (or `"all"`) for traction.
        value: The load as a vector `[x, y, z]` in global axes: force, moment, or either per length or area.
        distribution: Factor on the value in each place: a formula in the coordinates `x`, `y` and `z` of the reference
            configuration, such as `"1 - z/2"`, or an array of the mesh file, such as `{ field = "p" }`.
        amplitude: Name of an amplitude; without one the load grows with the load factor in statics and is constant in
            transients.
    """

    on: str
    value: Numbers
    distribution: Distribution | None = None
    amplitude: str | None = None


class EdgeMomentLoad(Part, type="edge-moment"):
    """A moment per length of an edge, constant in space with all components.

    Args:
        on: Name of the set: nodes for force and moment, edges for edge loads, quads (or `"all"`) for traction.
        value: The load as a vector `[x, y, z]` in global axes: force, moment, or either per length or area.
        distribution: Factor on the value in each place: a formula in the coordinates `x`, `y` and `z` of the reference
            configuration, such as `"1 - z/2"`, or an array of the mesh file, such as `{ field = "p" }`.
        amplitude: Name of an amplitude; without one the load grows with the load factor in statics and is constant in
            transients.
    """

    on: str
    value: Numbers
    distribution: Distribution | None = None
    amplitude: str | None = None


class TractionLoad(Part, type="traction"):
    """A force per reference area, constant in direction.

    Args:
        on: Name of the set: nodes for force and moment, edges for edge loads, quads (or `"all"`) for traction.
        value: The load as a vector `[x, y, z]` in global axes: force, moment, or either per length or area.
        distribution: Factor on the value in each place: a formula in the coordinates `x`, `y` and `z` of the reference
            configuration, such as `"1 - z/2"`, or an array of the mesh file, such as `{ field = "p" }`.
        amplitude: Name of an amplitude; without one the load grows with the load factor in statics and is constant in
            transients.
    """

    on: str
    value: Numbers
    distribution: Distribution | None = None
    amplitude: str | None = None


class PressureLoad(Part, type="pressure"):
    """A pressure that follows the surface; positive pushes against the director.

    Args:
        value: Pressure [force/area]; positive pushes against the director.
        on: Name of a quad set, or `"all"`.
        distribution: Factor on the value in each place: a formula in the coordinates `x`, `y` and `z` of the reference
            configuration, such as `"1 - z/2"`, or an array of the mesh file, such as `{ field = "p" }`.
        amplitude: Name of an amplitude.
    """

    value: Number
    on: str | None = None
    distribution: Distribution | None = None
    amplitude: str | None = None


class GravityLoad(Part, type="gravity"):
    """Gravity on all masses.

    Args:
        value: Acceleration of gravity [length/time²], such as `[0, 0, -9.81]`.
        amplitude: Name of an amplitude.
    """

    value: Numbers
    amplitude: str | None = None


class CentrifugalLoad(Part, type="centrifugal"):
    """Centrifugal forces on all masses of a model that turns at a constant angular velocity, for static and modal
    analyses in the frame that turns with it.

    Args:
        axis: Direction of the axis. Or an axis of a marker, such as "NAME.z" or "-NAME.z".
        velocity: Angular velocity Ω [rad/time].
        at: Point of the axis (length). Or the name of a marker.
        ground: Whether supports, the ground of joints and that of springs stand still, or turn with the model. Modes
            about an equilibrium need a ground that turns, or one that holds the model on its axis in the same way in
            all directions. Values: `stands`, `turns`.
        amplitude: Name of an amplitude, by which the forces, and so Ω², are multiplied.
    """

    axis: Numbers | str
    velocity: Number
    at: Numbers | str | None = None
    ground: Ground | None = None
    amplitude: str | None = None


Load = (
    ForceLoad
    | MomentLoad
    | FollowerForceLoad
    | FollowerMomentLoad
    | EdgeLoad
    | EdgeMomentLoad
    | TractionLoad
    | PressureLoad
    | GravityLoad
    | CentrifugalLoad
)
"""A load."""


Axis = Literal["x", "y", "z"]
"""Components of a vector.

`x`: First.
`y`: Second.
`z`: Third.
"""


NodalVector = Literal["position", "director", "first-gradient", "second-gradient"]
"""The vectors of a shell node.

`position`: Position of the mid-surface.
`director`: Director (transverse gradient); at a fold the first one of the node, with which the others turn.
`first-gradient`: Gradient along the first tangent of the surface (`ancf-full` only).
`second-gradient`: Gradient along the second tangent of the surface (`ancf-full` only).
"""


class Clamp(Part, type="clamp"):
    """Positions and directors fixed: no displacement, no rotation.

    Args:
        on: Name of a node or edge set.
    """

    on: str


class Hinge(Part, type="hinge"):
    """Positions fixed along an edge, rotation about it free.

    Args:
        on: Name of a node or edge set.
    """

    on: str


class SphericalSupport(Part, type="spherical"):
    """Positions fixed, directors free: a ball joint to the ground.

    Args:
        on: Name of a node or edge set.
    """

    on: str


class SymmetryPlane(Part, type="symmetry"):
    """Symmetry plane: position and director do not move along its normal.

    Args:
        on: Name of a node or edge set that lies in the plane.
        normal: Normal of the plane, of any length and direction. Or an axis of a marker, such as "NAME.z" or "-NAME.z".
    """

    on: str
    normal: Numbers | str


class Fix(Part, type="fix"):
    """Chosen components of position and director fixed.

    Args:
        on: Name of a node or edge set.
        position: Components of position that are fixed. Values: `x`, `y`, `z`.
        director: Components of the director that are fixed. Values: `x`, `y`, `z`.
    """

    on: str
    position: Sequence[Axis] | None = None
    director: Sequence[Axis] | None = None


class PrescribedMotion(Part, type="prescribe"):
    """One component of position or director prescribed as a function of time.

    Args:
        on: Name of a node or edge set.
        component: Which component. Values: `x`, `y`, `z`.
        value: Change of the component from its reference value [length, or none for directors], times the amplitude.
        of: Which vector of the nodes. Values: `position`, `director`, `first-gradient`, `second-gradient`.
        amplitude: Name of an amplitude; without one the value grows with the load factor in statics and holds from the
            start in transients.
    """

    on: str
    component: Axis
    value: Number
    of: NodalVector | None = None
    amplitude: str | None = None


Condition = Clamp | Hinge | SphericalSupport | SymmetryPlane | Fix | PrescribedMotion
"""A support or a prescribed motion."""


class ThermalStrain(Part, type="thermal"):
    """Thermal strain `α (T + z T′)` of the materials' `expansion`.

    Args:
        on: Name of a quad set, or `"all"`.
        temperature: Change T of the temperature of the mid-surface (temperature).
        gradient: Gradient T′ along the director [temperature/length].
        distribution: Factor on the values in each element: the mean over it of a formula in the coordinates `x`, `y`
            and `z` of the reference configuration, or of an array of the mesh file, such as `{ field = "T" }`.
        amplitude: Name of an amplitude.
    """

    on: str | None = None
    temperature: Number | None = None
    gradient: Number | None = None
    distribution: Distribution | None = None
    amplitude: str | None = None


class NaturalStrain(Part, type="natural"):
    """Natural strain and curvature of the mid-surface: the stress-free shape of the sheet.

    Args:
        on: Name of a quad set, or `"all"`.
        strain: Strains ε_xx, ε_yy, 2ε_xy of the mid-surface.
        curvature: Curvatures κ_xx, κ_yy, 2κ_xy [1/length], above 0 where the surface bends towards its director.
        direction: Direction of the components' x axis; its projection on the surface is taken. Or an axis of a marker,
            such as "NAME.z" or "-NAME.z".
        distribution: Factor on the values in each element: the mean over it of a formula in the coordinates `x`, `y`
            and `z` of the reference configuration, or of an array of the mesh file, such as `{ field = "T" }`.
        amplitude: Name of an amplitude.
    """

    on: str | None = None
    strain: Numbers | None = None
    curvature: Numbers | None = None
    direction: Numbers | str | None = None
    distribution: Distribution | None = None
    amplitude: str | None = None


class Prestress(Part, type="prestress"):
    """Resultants that act at the reference configuration.

    Args:
        on: Name of a quad set, or `"all"`.
        membrane: Membrane resultants n_xx, n_yy, n_xy [force/length].
        bending: Bending resultants m_xx, m_yy, m_xy (force); positive moments put the bottom in tension.
        direction: Direction of the components' x axis; its projection on the surface is taken. Or an axis of a marker,
            such as "NAME.z" or "-NAME.z".
        distribution: Factor on the values in each element: the mean over it of a formula in the coordinates `x`, `y`
            and `z` of the reference configuration, or of an array of the mesh file, such as `{ field = "T" }`.
        amplitude: Name of an amplitude.
    """

    on: str | None = None
    membrane: Numbers | None = None
    bending: Numbers | None = None
    direction: Numbers | str | None = None
    distribution: Distribution | None = None
    amplitude: str | None = None


PrescribedStrain = ThermalStrain | NaturalStrain | Prestress
"""A strain that the material takes on without stress, or a stress that acts at the reference. Prescribed strains grow
with the load factor in statics and are constant in transients unless they have an amplitude."""


class InitialVelocity(Part):
    """Velocity field at time 0: that of a rigid motion of the nodes of a set, of a body, of a beam or of the model.

    Args:
        on: Name of a node, edge or quad set, of a body or of a beam; `"all"` are all nodes of the mesh, `"model"` all
            of these and all bodies and beams.
        velocity: Translation [length/time].
        angular_velocity: Rotation [1/time].
        center: Point about which it turns (length). Or the name of a marker.
    """

    on: str | None = None
    velocity: Numbers | None = None
    angular_velocity: Numbers | None = None
    center: Numbers | str | None = None


class PointMass(Part, type="point"):
    """A mass at every node of a set (mass).

    Args:
        on: Name of the set.
        value: The mass, not negative.
    """

    on: str
    value: Number


class EdgeMass(Part, type="edge"):
    """A mass per length of an edge [mass/length].

    Args:
        on: Name of the set.
        value: The mass, not negative.
    """

    on: str
    value: Number


class AreaMass(Part, type="area"):
    """A mass per area of a quad set [mass/area].

    Args:
        on: Name of the set.
        value: The mass, not negative.
    """

    on: str
    value: Number


AddedMass = PointMass | EdgeMass | AreaMass
"""Mass in addition to that of the sections; it moves with the mid-surface."""


class Damping(Part):
    """Rayleigh damping of the whole model.

    Args:
        mass: Rayleigh factor of the mass matrix [1/time]: force −α M v.
        stiffness: Rayleigh factor of the stiffness (time). It acts on strain rates, so rigid motion is not damped; for
            small motions it is −β K v. Added to `retardation_time` of each section.
    """

    mass: Number | None = None
    stiffness: Number | None = None


class PointFoundation(Part, type="point"):
    """A spring at every node of a set [force/length].

    Args:
        on: Name of the set.
        stiffness: Stiffness along the axes of space, not negative.
        retardation_time: Retardation time τ of its damping: forces `k (u + τ u̇)`.
    """

    on: str
    stiffness: Numbers
    retardation_time: Number | None = None


class EdgeFoundation(Part, type="edge"):
    """Springs per length of an edge [force/length²].

    Args:
        on: Name of the set.
        stiffness: Stiffness along the axes of space, not negative.
        retardation_time: Retardation time τ of its damping: forces `k (u + τ u̇)`.
    """

    on: str
    stiffness: Numbers
    retardation_time: Number | None = None


class AreaFoundation(Part, type="area"):
    """Springs per area of a quad set [force/length³].

    Args:
        on: Name of the quad set, or `"all"`.
        stiffness: Stiffness along the axes of space, not negative.
        normal: Stiffness along the normals of the reference surface, in addition to `stiffness`.
        retardation_time: Retardation time τ of its damping: forces `k (u + τ u̇)`.
    """

    on: str | None = None
    stiffness: Numbers | None = None
    normal: Number | None = None
    retardation_time: Number | None = None


Foundation = PointFoundation | EdgeFoundation | AreaFoundation
"""Elastic foundation of E. Winkler: springs without mass between a set and its places in the reference configuration."""


class ConstantAmplitude(Part, type="constant"):
    """One value at all times.

    Args:
        value: The value.
    """

    value: Number


class RampAmplitude(Part, type="ramp"):
    """From 0 at `start` linearly to 1 at `end`, constant before and after.

    Args:
        end: Time at which the ramp reaches 1.
        start: Time at which the ramp leaves 0.
    """

    end: Number
    start: Number | None = None


class TableAmplitude(Part, type="table"):
    """Straight lines between given points, constant before and after.

    Args:
        times: Times, ascending.
        values: Values at those times.
    """

    times: Numbers
    values: Numbers


class SplineAmplitude(Part, type="spline"):
    """Smooth curve (cubic spline) through given points.

    Args:
        times: Times, ascending.
        values: Values at those times.
        rates: Rates at the first and the last time, with which the curve continues straight before and after.
    """

    times: Numbers
    values: Numbers
    rates: Numbers | None = None


class ExpressionAmplitude(Part, type="expression"):
    """A formula in `t`.

    Args:
        expression: Formula such as `"sin(2*PI*t)"`; operators `+ - * / ^`, functions `sin cos tan exp ln sqrt tanh …`,
            constants `PI`, `E`.
    """

    expression: str


Amplitude = ConstantAmplitude | RampAmplitude | TableAmplitude | SplineAmplitude | ExpressionAmplitude
"""A function of time (of the load factor 0…1 in statics)."""
