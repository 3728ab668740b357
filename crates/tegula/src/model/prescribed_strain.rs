//! Prescribed strains (eigenstrains): thermal and natural strains, and prestress.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Distribution;

/// A strain that the material takes on without stress, or a stress that acts at the reference.
///
/// Prescribed strains grow with the load factor in statics and are constant in transients unless they have an
/// amplitude.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "kebab-case")]
pub enum PrescribedStrain {
    /// Thermal strain `α (T + z T′)` of the materials' `expansion`.
    Thermal(ThermalStrain),
    /// Natural strain and curvature of the mid-surface: the stress-free shape of the sheet.
    Natural(NaturalStrain),
    /// Resultants that act at the reference configuration.
    Prestress(Prestress),
}

/// Change of temperature.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ThermalStrain {
    /// Name of a quad set, or `"all"`.
    #[serde(default = "super::all")]
    pub on: String,
    /// Change T of the temperature of the mid-surface (temperature).
    #[serde(default)]
    pub temperature: f64,
    /// Gradient T′ along the director [temperature/length].
    #[serde(default)]
    pub gradient: f64,
    /// Factor on the values in each element: the mean over it of a formula in the coordinates `x`, `y` and `z` of the reference configuration, or of an
    /// array of the mesh file, such as `{ field = "T" }`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distribution: Option<Distribution>,
    /// Name of an amplitude.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub amplitude: Option<String>,
}

/// Natural strain and curvature.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NaturalStrain {
    /// Name of a quad set, or `"all"`.
    #[serde(default = "super::all")]
    pub on: String,
    /// Strains ε_xx, ε_yy, 2ε_xy of the mid-surface.
    #[serde(default)]
    pub strain: [f64; 3],
    /// Curvatures κ_xx, κ_yy, 2κ_xy [1/length], above 0 where the surface bends towards its director.
    #[serde(default)]
    pub curvature: [f64; 3],
    /// Direction of the components' x axis; its projection on the surface is taken.
    #[serde(default = "x_axis")]
    #[schemars(extend("x-marker" = "direction"))]
    pub direction: [f64; 3],
    /// Factor on the values in each element: the mean over it of a formula in the coordinates `x`, `y` and `z` of the reference configuration, or of an
    /// array of the mesh file, such as `{ field = "T" }`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distribution: Option<Distribution>,
    /// Name of an amplitude.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub amplitude: Option<String>,
}

/// Resultants that act at the reference configuration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Prestress {
    /// Name of a quad set, or `"all"`.
    #[serde(default = "super::all")]
    pub on: String,
    /// Membrane resultants n_xx, n_yy, n_xy [force/length].
    #[serde(default)]
    pub membrane: [f64; 3],
    /// Bending resultants m_xx, m_yy, m_xy (force); positive moments put the bottom in tension.
    #[serde(default)]
    pub bending: [f64; 3],
    /// Direction of the components' x axis; its projection on the surface is taken.
    #[serde(default = "x_axis")]
    #[schemars(extend("x-marker" = "direction"))]
    pub direction: [f64; 3],
    /// Factor on the values in each element: the mean over it of a formula in the coordinates `x`, `y` and `z` of the reference configuration, or of an
    /// array of the mesh file, such as `{ field = "T" }`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distribution: Option<Distribution>,
    /// Name of an amplitude.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub amplitude: Option<String>,
}

impl PrescribedStrain {
    /// Name of the set it acts on.
    pub fn on(&self) -> &str {
        match self {
            Self::Thermal(s) => &s.on,
            Self::Natural(s) => &s.on,
            Self::Prestress(s) => &s.on,
        }
    }

    /// Direction of its components' x axis, if it has components.
    pub fn direction(&self) -> Option<[f64; 3]> {
        match self {
            Self::Thermal(_) => None,
            Self::Natural(s) => Some(s.direction),
            Self::Prestress(s) => Some(s.direction),
        }
    }

    /// Factor on its values over the surface.
    pub fn distribution(&self) -> Option<&Distribution> {
        match self {
            Self::Thermal(s) => s.distribution.as_ref(),
            Self::Natural(s) => s.distribution.as_ref(),
            Self::Prestress(s) => s.distribution.as_ref(),
        }
    }

    /// Its values times a factor.
    pub fn times(&self, factor: f64) -> Cow<'_, Self> {
        if factor == 1.0 {
            return Cow::Borrowed(self);
        }
        let mut out = self.clone();
        match &mut out {
            Self::Thermal(s) => [&mut s.temperature, &mut s.gradient].into_iter().for_each(|x| *x *= factor),
            Self::Natural(s) => s.strain.iter_mut().chain(&mut s.curvature).for_each(|x| *x *= factor),
            Self::Prestress(s) => s.membrane.iter_mut().chain(&mut s.bending).for_each(|x| *x *= factor),
        }
        Cow::Owned(out)
    }

    /// Strain without its amplitude.
    pub fn without_amplitude(&self) -> Self {
        let mut bare = self.clone();
        match &mut bare {
            Self::Thermal(s) => s.amplitude = None,
            Self::Natural(s) => s.amplitude = None,
            Self::Prestress(s) => s.amplitude = None,
        }
        bare
    }

    /// Name of its amplitude.
    pub fn amplitude(&self) -> Option<&String> {
        match self {
            Self::Thermal(s) => s.amplitude.as_ref(),
            Self::Natural(s) => s.amplitude.as_ref(),
            Self::Prestress(s) => s.amplitude.as_ref(),
        }
    }
}

/// Prescribed strains of an element, whose fields have the factors `acting`; `None` where that is 0. Without factors there are none.
pub(crate) fn acting_strains<'a>(
    fields: impl Iterator<Item = &'a PrescribedStrain>,
    acting: &[f64],
) -> Vec<Option<Cow<'a, PrescribedStrain>>> {
    fields.zip(acting).map(|(field, factor)| (*factor != 0.0).then(|| field.times(*factor))).collect()
}

pub(super) fn x_axis() -> [f64; 3] {
    [1.0, 0.0, 0.0]
}
