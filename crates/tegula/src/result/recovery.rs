//! Resultants, stresses and energy of shell elements.
//!
//! Each quantity is the mean of the four Gauss points, in the cross-section frame of the
//! element's centre (z along the normal, y along r,η, x = y × z). Resultants are conjugate to the
//! Green–Lagrange strains: forces and moments per *reference* length.
//!
//! The curvature of the element is κ = −d,ξ·r,ξ: with d·r,ξ = 0 it is d·r,ξξ, above 0 where
//! the surface bends *towards* the director. A fibre at the height z along the director
//! stretches by ε − z κ, so the stresses are
//!
//! ```text
//! top (z = h/2)      σ = n/h − 6 m/h²
//! bottom (z = −h/2)  σ = n/h + 6 m/h²
//! middle             σ = n/h,  τ = 1.5 q/h   (parabola over the thickness)
//! ```
//!
//! of the moments m about the middle of the sheet: where it lies at the height z₀ over the reference surface, these are
//! m + z₀ n of the moments m about the reference surface.
//!
//! Elements with three-dimensional stresses have σ_zz, too, which counts in the equivalent stress.

use std::sync::Arc;

use nalgebra::{DVector, Vector2, Vector6};
use rayon::prelude::*;

use super::inside::{Inside, Shape, Snapshot};
use super::plies::shear_of_equilibrium;
use crate::Mat3;
use crate::analysis::State;
use crate::element::geometry::{cross_section_frame, nodal_areas};
use crate::section::CompiledSection;
use crate::section::compiled::Layer;
use crate::section::ply::shear_turn;
use crate::system::{Shell, ShellSection, System};
use tegula_sparse::norm::larger;

/// Number of elements below which threads do not share the work.
pub(super) const CHUNK: usize = 64;

/// Quantities of one shell element.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ShellResult {
    /// Membrane resultants n_xx, n_yy, n_xy [force/length].
    pub membrane: [f64; 3],
    /// Bending resultants m_xx, m_yy, m_xy (force); above 0 the bottom surface is in tension.
    pub bending: [f64; 3],
    /// Transverse shear resultants q_xz, q_yz [force/length].
    pub shear: [f64; 2],
    /// In-plane stresses σ_xx, σ_yy, σ_xy at the top, the side that the director points to [force/area].
    pub stress_top: [f64; 3],
    /// In-plane stresses at the bottom [force/area].
    pub stress_bottom: [f64; 3],
    /// Greatest von Mises stress of top, middle and bottom [force/area].
    pub von_mises: f64,
    /// Strain energy per reference area [energy/area].
    pub energy_density: f64,
    /// Reference area (area).
    pub area: f64,
    /// Axes x, y, z of the frame of the components, in the reference configuration.
    pub axes: [[f64; 3]; 3],
    /// Where these axes are at the state, turned with the surface.
    pub current_axes: [[f64; 3]; 3],
}

/// Resultants, stresses and energy of all shells at a state, in the order of [`System::shells`].
pub fn recover(system: &System, state: &State) -> Vec<ShellResult> {
    shells(&Snapshot::new(system, state))
}

/// Resultants, stresses and energy of all shells of a snapshot, in the order of [`System::shells`].
///
/// For a small motion they are linear in its amplitude, but for the energy ½ δε·C δε per area, which is quadratic, and
/// the von Mises stress, which is homogeneous.
pub fn shells(snapshot: &Snapshot) -> Vec<ShellResult> {
    let energies = snapshot.stored_energies();
    let energy = |shell: &Shell| {
        shell.groups.clone().map(|g| energies.as_ref().map(|e| e[g][shell.member])).sum::<Option<f64>>()
    };
    let shells = &snapshot.system.shells;
    shells
        .par_iter()
        .with_min_len(CHUNK)
        .map_init(|| None, |last, shell| element(snapshot, shell, last, energy(shell)).unwrap_or_default())
        .collect()
}

/// Resultants, stresses and energy of one element. Its geometry was valid when the system was built, so nothing fails
/// here.
fn element(
    snapshot: &Snapshot,
    shell: &Shell,
    last: &mut Option<Arc<Shape>>,
    stored: Option<f64>,
) -> Option<ShellResult> {
    let of = &snapshot.system.sections[shell.section];
    let (section, shell_element) = (&of.section, of.element.as_ref());
    let geometry = snapshot.system.geometry(shell);
    let inside = Inside::after(snapshot, shell, last)?;
    let centre = cross_section_frame(&geometry.base(0.0, 0.0, 0.0))?;
    let current =
        cross_section_frame(&snapshot.system.current_geometry(shell, &snapshot.state.u).base(0.0, 0.0, 0.0))
            .unwrap_or(centre);
    let mut out = ShellResult { axes: centre.into(), current_axes: current.into(), ..ShellResult::default() };
    let points = shell_element.surface_points();
    let stresses = inside.point_stresses();
    let per_point = stresses.len() / points;
    let share = 1.0 / points as f64;
    for point in 0..points {
        let turn = Turn::between(&inside.shape.frames[point], &Mat3::identity());
        let r = resultants(
            section,
            shell_element.is_solid(),
            &stresses[point * per_point..(point + 1) * per_point],
        );
        let membrane = turn.tensor([r[0], r[1], r[2]]);
        let bending = turn.tensor([r[6], r[7], r[8]]);
        let shear = turn.vector([r[4], r[5]]);
        for i in 0..3 {
            out.membrane[i] += share * membrane[i];
            out.bending[i] += share * bending[i];
        }
        for i in 0..2 {
            out.shear[i] += share * shear[i];
        }
    }
    out.area = nodal_areas(&geometry.positions).iter().sum();
    if out.area > 0.0 {
        out.energy_density = stored.unwrap_or_else(|| inside.small_energy()) / out.area;
    }
    surface_stresses(&mut out, &inside, of, &centre, points);
    Some(out)
}

/// Resultants n, n_zz, q, m of a point of the mid-surface from the stresses of its integration points.
fn resultants(section: &CompiledSection, solid: bool, stresses: &[DVector<f64>]) -> [f64; 9] {
    let mut out = [0.0; 9];
    let mut integration_points = stresses.iter();
    if !solid && let Some(n) = integration_points.next() {
        for (out, n) in out.iter_mut().zip(n.iter()) {
            *out += n;
        }
    }
    let heights = section.layers.iter().flat_map(|l| l.points.iter().copied());
    for (s, (z, weight)) in integration_points.zip(heights) {
        for i in 0..6 {
            out[i] += weight * s[i];
        }
        for i in 0..3 {
            out[6 + i] -= weight * z * s[i];
        }
    }
    out
}

/// Stresses at the two surfaces and the greatest equivalent stress.
fn surface_stresses(
    out: &mut ShellResult,
    inside: &Inside,
    ShellSection { section, element, .. }: &ShellSection,
    centre: &Mat3,
    points: usize,
) {
    let sheet = section.layers.first().filter(|_| section.layers.len() == 1);
    let sheet = sheet.filter(|_| section.is_linear() && section.isotropic);
    if let Some(layer) = sheet.filter(|_| !element.is_solid()) {
        stresses(out, layer, [0.0; 3]);
        return;
    }
    let at_integration_points = inside.point_stresses();
    // The thickness strain of elements with stress resultants is one for the whole section: what it leaves in single layers, E (ε_zz − α ΔT),
    // is no stress of plane stress.
    let plane_stress = !element.is_solid() && !section.has_rubber();
    let per_point = at_integration_points.len() / points;
    let mean = |number: usize, layer: &Layer, z: f64| -> Option<Vector6<f64>> {
        let mut sum = Vector6::zeros();
        for point in 0..points {
            let (stress, frame) = match inside.stress(point, z, layer) {
                Some((s, at)) => (s, at.frame),
                None => inside.stress_of_nearest_point(point, z, points, &at_integration_points)?,
            };
            let turn = Turn::between(&frame, centre);
            let [xx, yy, xy] = turn.tensor([stress[0], stress[1], stress[2]]);
            let mut shear = [stress[4], stress[5]];
            if !element.is_solid() && section.is_linear() {
                // The shear strain of the section is an average; equilibrium distributes its forces.
                let of_section = &at_integration_points[point * per_point];
                let q = Vector2::new(of_section[4], of_section[5]);
                if let Some(of_layer) = shear_of_equilibrium(section, (number, layer), &frame, (&q, z)) {
                    shear = (shear_turn(-section.layer_axis(layer, &frame)) * of_layer).into();
                }
            }
            let [xz, yz] = turn.vector(shear);
            let zz = if plane_stress { 0.0 } else { stress[3] };
            sum += Vector6::new(xx, yy, xy, zz, xz, yz) / points as f64;
        }
        Some(sum)
    };
    if let Some(layer) = sheet {
        let across = |z: f64| mean(0, layer, z).map_or(f64::NAN, |s| s[3]);
        stresses(out, layer, [layer.bottom, 0.5 * (layer.bottom + layer.top), layer.top].map(across));
        return;
    }
    let plane = |s: &Vector6<f64>| [s[0], s[1], s[2]];
    if let (Some(bottom), Some(top)) = (section.layers.first(), section.layers.last()) {
        out.stress_bottom = mean(0, bottom, bottom.bottom).as_ref().map_or([0.0; 3], plane);
        out.stress_top = mean(section.layers.len() - 1, top, top.top).as_ref().map_or([0.0; 3], plane);
    }
    for (number, layer) in section.layers.iter().enumerate() {
        for z in [layer.bottom, 0.5 * (layer.bottom + layer.top), layer.top] {
            if let Some(s) = mean(number, layer, z) {
                out.von_mises = larger(out.von_mises, equivalent(&s));
            }
        }
    }
}

/// Von Mises stress of xx, yy, xy, zz, xz, yz.
fn equivalent(s: &Vector6<f64>) -> f64 {
    let normal = (s[0] - s[1]).powi(2) + (s[1] - s[3]).powi(2) + (s[3] - s[0]).powi(2);
    (0.5 * normal + 3.0 * (s[2] * s[2] + s[4] * s[4] + s[5] * s[5])).sqrt()
}

/// In-plane rotation from one frame to another. Frames of a warped element also tilt, which is neglected: components
/// are convected with the surface.
#[derive(Debug, Clone, Copy)]
struct Turn {
    cos: f64,
    sin: f64,
}

impl Turn {
    fn between(from: &Mat3, to: &Mat3) -> Self {
        let x = from.column(0);
        let (c, s) = (x.dot(&to.column(0)), x.dot(&to.column(1)));
        let size = c.hypot(s);
        if size > 0.0 { Self { cos: c / size, sin: s / size } } else { Self { cos: 1.0, sin: 0.0 } }
    }

    fn vector(self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.cos * x - self.sin * y, self.sin * x + self.cos * y]
    }

    /// Components xx, yy, xy of a symmetric tensor.
    fn tensor(self, [x, y, xy]: [f64; 3]) -> [f64; 3] {
        let Self { cos: c, sin: s } = self;
        [
            c * c * x + s * s * y - 2.0 * c * s * xy,
            s * s * x + c * c * y + 2.0 * c * s * xy,
            c * s * (x - y) + (c * c - s * s) * xy,
        ]
    }
}

/// Stresses of a homogeneous sheet from resultants, and from the stress σ_zz at its bottom, in its middle and at its top.
fn stresses(r: &mut ShellResult, sheet: &Layer, [bottom, centre, top]: [f64; 3]) {
    let (h, height) = (sheet.top - sheet.bottom, 0.5 * (sheet.bottom + sheet.top));
    let middle: [f64; 3] = std::array::from_fn(|i| r.membrane[i] / h);
    let bending: [f64; 3] = std::array::from_fn(|i| 6.0 * (r.bending[i] + height * r.membrane[i]) / (h * h));
    r.stress_top = std::array::from_fn(|i| middle[i] - bending[i]);
    r.stress_bottom = std::array::from_fn(|i| middle[i] + bending[i]);
    let shear = r.shear.map(|q| 1.5 * q / h);
    let of =
        |[x, y, xy]: [f64; 3], zz: f64, [xz, yz]: [f64; 2]| equivalent(&Vector6::new(x, y, xy, zz, xz, yz));
    r.von_mises = larger(
        of(middle, centre, shear),
        larger(of(r.stress_top, top, [0.0; 2]), of(r.stress_bottom, bottom, [0.0; 2])),
    );
}

#[cfg(test)]
mod tests;
