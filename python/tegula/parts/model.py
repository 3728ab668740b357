"""The whole model of the model file as classes; written by `scripts/python_classes.py` from `tegula schema`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypedDict

from .._part import Keys, Part
from .analysis import Analysis, AnalysisStep
from .bodies import Beam, Bushing, RigidBody, SpringDamper, Tie, TorsionSpring
from .joints import Joint
from .loads import AddedMass, Amplitude, Condition, Damping, Foundation, InitialVelocity, Load, PrescribedStrain
from .mesh import Imperfection, Marker, MeshSet, MeshSource
from .output import Output, Sensor
from .sections import Material, Section


class Model(Part):
    """A whole model: mesh, materials, sections, conditions, loads, analysis, output.

    Args:
        title: One line that describes the model; it appears in results and pictures.
        analysis: Analysis to run; a model has this or `steps`.
        steps: Analyses that follow one another, each from the state at the end of the one before: preload, then modes,
            then motion.
        mesh: The mid-surface: a generator or a mesh file; none in models of bodies alone.
        sets: Sets of nodes, elements and edges in addition to those of the mesh.
        materials: Materials by name.
        sections: Which elements, material and thickness the parts of the mesh have.
        bodies: Rigid bodies and point masses.
        beams: Beams.
        joints: Joints between bodies, nodes and the ground.
        springs: Springs with dampers.
        conditions: Supports and prescribed motions.
        loads: Loads.
        torsion_springs: Torsion springs with dampers.
        bushings: Bushings: stiffness and damping of all six relative motions of two bodies.
        ties: Ties of meshes whose nodes do not match.
        foundations: Elastic foundations.
        sensors: Sensors: quantities of the motion that are recorded.
        masses: Masses in addition to those of the sections.
        initial_velocities: Velocities at the start of a transient analysis.
        damping: Rayleigh damping of the whole model.
        prescribed_strains: Strains without stress (heat, growth), and stresses without strain.
        imperfections: Deviations of the reference geometry of the mesh from the nominal one.
        amplitudes: Functions of time by name, used by loads and prescribed motions.
        output: Results to write.
        markers: Points and axes with names, by which other keys give points and directions.
    """

    title: str | None = None
    analysis: Analysis | Keys | None = None
    steps: Sequence[AnalysisStep | Keys] | None = None
    mesh: MeshSource | Keys | None = None
    sets: Sequence[MeshSet | Keys] | None = None
    materials: Mapping[str, Material | Keys] | None = None
    sections: Sequence[Section | Keys] | None = None
    bodies: Sequence[RigidBody | Keys] | None = None
    beams: Sequence[Beam | Keys] | None = None
    joints: Sequence[Joint | Keys] | None = None
    springs: Sequence[SpringDamper | Keys] | None = None
    conditions: Sequence[Condition | Keys] | None = None
    loads: Sequence[Load | Keys] | None = None
    torsion_springs: Sequence[TorsionSpring | Keys] | None = None
    bushings: Sequence[Bushing | Keys] | None = None
    ties: Sequence[Tie | Keys] | None = None
    foundations: Sequence[Foundation | Keys] | None = None
    sensors: Sequence[Sensor | Keys] | None = None
    masses: Sequence[AddedMass | Keys] | None = None
    initial_velocities: Sequence[InitialVelocity | Keys] | None = None
    damping: Damping | Keys | None = None
    prescribed_strains: Sequence[PrescribedStrain | Keys] | None = None
    imperfections: Sequence[Imperfection | Keys] | None = None
    amplitudes: Mapping[str, Amplitude | Keys] | None = None
    output: Output | Keys | None = None
    markers: Sequence[Marker | Keys] | None = None


class ModelKeys(TypedDict, total=False):
    """Tables of the model, as the keywords of `tegula.Model`."""

    title: str | None
    analysis: Analysis | Keys | None
    steps: Sequence[AnalysisStep | Keys] | None
    mesh: MeshSource | Keys | None
    sets: Sequence[MeshSet | Keys] | None
    materials: Mapping[str, Material | Keys] | None
    sections: Sequence[Section | Keys] | None
    bodies: Sequence[RigidBody | Keys] | None
    beams: Sequence[Beam | Keys] | None
    joints: Sequence[Joint | Keys] | None
    springs: Sequence[SpringDamper | Keys] | None
    conditions: Sequence[Condition | Keys] | None
    loads: Sequence[Load | Keys] | None
    torsion_springs: Sequence[TorsionSpring | Keys] | None
    bushings: Sequence[Bushing | Keys] | None
    ties: Sequence[Tie | Keys] | None
    foundations: Sequence[Foundation | Keys] | None
    sensors: Sequence[Sensor | Keys] | None
    masses: Sequence[AddedMass | Keys] | None
    initial_velocities: Sequence[InitialVelocity | Keys] | None
    damping: Damping | Keys | None
    prescribed_strains: Sequence[PrescribedStrain | Keys] | None
    imperfections: Sequence[Imperfection | Keys] | None
    amplitudes: Mapping[str, Amplitude | Keys] | None
    output: Output | Keys | None
    markers: Sequence[Marker | Keys] | None
