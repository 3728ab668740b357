"""Materials and sections of the model file as classes; written by `scripts/python_classes.py` from `tegula schema`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from .._part import Integer, Keys, Number, Numbers, Part
from .loads import Distribution


class Strengths(Part):
    """Strengths of a ply in its own axes; all of them positive numbers.

    Args:
        xt: Tensile strength along the fibre X_t [force/area], above 0.
        xc: Compressive strength along the fibre X_c [force/area], above 0.
        yt: Tensile strength across the fibre Y_t [force/area], above 0.
        yc: Compressive strength across the fibre Y_c [force/area], above 0.
        s12: Shear strength in the plane S_12 [force/area], above 0.
        tsai_wu_interaction: Interaction F12* = F12/√(F11 F22) of the Tsai–Wu criterion, above −1 and below 1 (−1/2
            unless given).
    """

    xt: Number
    xc: Number
    yt: Number
    yc: Number
    s12: Number
    tsai_wu_interaction: Number | None = None


NeoHookeanForm = Literal["split", "coupled"]
"""Which neo-Hookean energy.

`split`: `μ/2 (J^(−2/3) I1 − 3) + κ/2 (J − 1)²`: shape and volume apart.
`coupled`: `μ/2 (I1 − 3) − μ ln J + λ/2 (ln J)²` with λ = κ − 2μ/3.
"""


class IsotropicMaterial(Part, type="isotropic"):
    """Isotropic linear elastic (St. Venant–Kirchhoff).

    Args:
        young: Young's modulus E [force/area], above 0.
        poisson: Poisson's ratio ν, above −1 and below 0.5.
        density: Density ρ [mass/volume]; needed by transient and modal analysis and by gravity.
        expansion: Thermal expansion α [1/temperature].
        strength: Strengths, for failure indices.
    """

    young: Number
    poisson: Number
    density: Number | None = None
    expansion: Number | None = None
    strength: Strengths | Keys | None = None


class OrthotropicMaterial(Part, type="orthotropic"):
    """Orthotropic linear elastic, such as a fibre-reinforced ply.

    Args:
        young: Young's moduli E1, E2, E3 [force/area], above 0.
        poisson: Poisson's ratios ν12, ν13, ν23: contraction along the second axis under stress along the first.
        shear: Shear moduli G12, G13, G23 [force/area], above 0.
        density: Density ρ [mass/volume]; needed by transient and modal analysis and by gravity.
        expansion: Thermal expansions α1, α2, α3 [1/temperature].
        strength: Strengths, for failure indices.
    """

    young: Numbers
    poisson: Numbers
    shear: Numbers
    density: Number | None = None
    expansion: Numbers | None = None
    strength: Strengths | Keys | None = None


class NeoHookeanMaterial(Part, type="neo-hookean"):
    """Hyperelastic, neo-Hooke; for `cm` and `solid-shell`.

    Args:
        shear: Shear modulus μ [force/area], above 0.
        bulk: Bulk modulus κ [force/area], above 0; a thousand times μ is nearly incompressible.
        density: Density ρ [mass/volume]; needed by transient and modal analysis and by gravity.
        form: Which energy. Values: `split`, `coupled`.
    """

    shear: Number
    bulk: Number
    density: Number | None = None
    form: NeoHookeanForm | None = None


class MooneyRivlinMaterial(Part, type="mooney-rivlin"):
    """Hyperelastic, Mooney–Rivlin; for `cm` and `solid-shell`.

    Args:
        c10: Constant c10 [force/area].
        c01: Constant c01 [force/area]; c10 + c01 above 0 is half the shear modulus.
        bulk: Bulk modulus κ [force/area], above 0.
        density: Density ρ [mass/volume]; needed by transient and modal analysis and by gravity.
    """

    c10: Number
    c01: Number
    bulk: Number
    density: Number | None = None


class PlasticMaterial(Part, type="plastic"):
    """Plastic with von Mises' yield condition; small strains, any rotation.

    Args:
        young: Young's modulus E [force/area], above 0.
        poisson: Poisson's ratio ν, above −1 and below 0.5.
        yield_stress: Yield stress y₀ [force/area], above 0.
        hardening: Linear isotropic hardening modulus H: slope of the yield stress over the plastic strain [force/area].
        saturation: Stress y∞ at which hardening saturates [force/area]; no saturation unless given.
        saturation_rate: Rate δ of saturation: y = y₀ + H p + (y∞ − y₀)(1 − exp(−δ p)).
        kinematic: Kinematic hardening modulus H_k [force/area].
        density: Density ρ [mass/volume]; needed by transient and modal analysis and by gravity.
        expansion: Thermal expansion α [1/temperature].
    """

    young: Number
    poisson: Number
    yield_stress: Number
    hardening: Number | None = None
    saturation: Number | None = None
    saturation_rate: Number | None = None
    kinematic: Number | None = None
    density: Number | None = None
    expansion: Number | None = None


Material = IsotropicMaterial | OrthotropicMaterial | NeoHookeanMaterial | MooneyRivlinMaterial | PlasticMaterial
"""A material."""


ElementKind = Literal["ems", "cm", "mitc4", "solid-shell", "ancf-full"]
"""Element types.

`ems`: Shear-deformable bilinear shell of the absolute nodal coordinate formulation, elastic middle surface.
`cm`: `ems` with three-dimensional stresses integrated over the thickness: continuum mechanics based shell.
`mitc4`: Bilinear shell with directors of unit length (MITC4 with enhanced membrane strains).
`solid-shell`: Eight-node solid shell: positions at the bottom and the top of the thickened mid-surface.
`ancf-full`: Fully parameterized plate with 48 coordinates; it locks and serves for comparison.
"""


Membrane = Literal["eas", "stable-eas", "mitc4+", "assumed-shear", "displacement"]
"""Membrane parts of the bilinear elements.

`eas`: Four enhanced assumed strains (the paper's). Stretched elements lose stability in bending.
`stable-eas`: `eas` with a limited geometric stiffness of the hourglass motion in elements longer than twice their
    width.
`mitc4+`: Membrane strains of MITC4+ with four enhanced strains: `eas` on flat elements, no membrane locking of warped
    ones.
`assumed-shear`: Assumed in-plane shear without parameters, for rubber in tension.
`displacement`: Strains of the displacements alone; too stiff in in-plane bending.
"""


class LayupPly(Part):
    """A ply of a layup.

    Args:
        material: Name of a material; that of the layup unless given.
        angle: Angle from the 0° direction to the fibre, about the director (degrees).
        thickness: Thickness (length), above 0; `ply_thickness` of the layup unless given.
    """

    material: str | None = None
    angle: Number | None = None
    thickness: Number | None = None


class Layup(Part):
    """Plies of a laminate, from the bottom (against the director) to the top: one by one in `plies`, or in the compact
    notation `stacking` with one material and thickness.

    Args:
        plies: The plies from the bottom to the top. Give either these or `stacking`.
        stacking: Stacking sequence such as `"[0/90/±45]2s"`: angles in degrees from the bottom to the top; `_2` repeats
            a ply, `(…)2` a group, the number after `]` all, and `s` mirrors the result. `±` may be written `+-`.
        material: Name of the material of plies that do not name their own.
        ply_thickness: Thickness of plies that do not give their own (length), above 0.
        symmetric: The plies, repeats included, are the lower half; their mirror image lies on top.
        repeat: How often the plies follow each other, at least 1.
        direction: Direction of the angle 0° in space, projected on the surface. Angles are counted from it about the
            director, counter-clockwise if the director points to the viewer. It must not be normal to the surface. Or
            an axis of a marker, such as "NAME.z" or "-NAME.z".
        offset: Height of the laminate's middle above the mesh, along the director (length).
    """

    plies: Sequence[LayupPly | Keys] | None = None
    stacking: str | None = None
    material: str | None = None
    ply_thickness: Number | None = None
    symmetric: bool | None = None
    repeat: Integer | None = None
    direction: Numbers | str | None = None
    offset: Number | None = None


class Section(Part):
    """Element type, material and thickness of a part of the mesh.

    Args:
        on: Name of a quad set, or `"all"`.
        element: Element type. Values: `ems`, `cm`, `mitc4`, `solid-shell`, `ancf-full`.
        material: Name of a material; needed unless there is a `layup`.
        thickness: Thickness h (length), above 0; needed unless there is a `layup`.
        thickness_distribution: Factor on the thickness of all layers in each element: the mean over it of a formula in
            the coordinates `x`, `y` and `z` of the reference configuration, or of an array of the mesh file, such as `{
            field = "t" }`; above 0. Not for `ancf-full`.
        layup: Plies of a laminate, instead of `material` and `thickness`.
        shear_correction: Transverse shear correction factors c_xz, c_yz. Unless given: 5/6 each for one layer, the
            layup's own for a laminate, 1 for the elements with three-dimensional stresses (`cm`, `solid-shell`,
            `ancf-full`).
        shear_stabilization: Coefficient α of stabilised transverse shear: the shear stiffness of an element is
            multiplied by h²/(h² + α l²), l its longest edge. 0.1 is usual; makes `ems` and `mitc4` more exact where
            elements are longer than h.
        ans_shear: Assumed natural strain for transverse shear; off: the element locks when thin.
        ans_thickness: Assumed natural strain for the thickness; off: curved elements lock.
        eas: Enhanced assumed strain in the plane (4 parameters); off: in-plane bending is too stiff.
        membrane: Membrane part of the bilinear elements. Unless given: `stable-eas`, for rubber `assumed-shear`, with
            `eas = false` `displacement`. Values: `eas`, `stable-eas`, `mitc4+`, `assumed-shear`, `displacement`.
        thickness_eas: Enhanced parameters of the thickness strain of `cm` and `solid-shell`: 0, 1, 3 or 4; with 0
            bending locks, with 1 distorted meshes fail the bending patch test.
        thickness_points: Integration points over the thickness (of each layer): by default 2, and 5 for plastic
            materials.
        total_mass: Total mass of the section (mass); given, the density is scaled to meet it on the mesh.
        retardation_time: Retardation time τ of Kelvin–Voigt damping (time): the stress is that of the strain `ε + τ
            dε/dt`.
    """

    on: str | None = None
    element: ElementKind | None = None
    material: str | None = None
    thickness: Number | None = None
    thickness_distribution: Distribution | None = None
    layup: Layup | Keys | None = None
    shear_correction: Numbers | None = None
    shear_stabilization: Number | None = None
    ans_shear: bool | None = None
    ans_thickness: bool | None = None
    eas: bool | None = None
    membrane: Membrane | None = None
    thickness_eas: Integer | None = None
    thickness_points: Integer | None = None
    total_mass: Number | None = None
    retardation_time: Number | None = None
