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

use rayon::prelude::*;

use crate::Mat3;
use crate::element::Nodal;
use crate::element::ems::point_resultants;
use crate::element::geometry::{covariant_base, cross_section_frame};
use crate::system::{Shell, System};

/// Quantities of one shell element.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ShellResult {
    /// Membrane resultants n_xx, n_yy, n_xy [force/length].
    pub membrane: [f64; 3],
    /// Bending resultants m_xx, m_yy, m_xy (force); above 0 the bottom surface is pulled.
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
}

/// The quantities of all shells at displacements `u`, in the order of [`System::shells`].
pub fn recover(system: &System, u: &[Nodal]) -> Vec<ShellResult> {
    system.shells.par_iter().map(|shell| element(system, shell, u)).collect()
}

/// One element. Its geometry was valid when the system was built, so nothing fails here;
/// if it did, the element would be all zero.
fn element(system: &System, shell: &Shell, u: &[Nodal]) -> ShellResult {
    let section = &system.sections[shell.section];
    let (group, member) = shell.member;
    let samples = system.groups[group].sampled_strains(member, &system.reference, u, system.linear);
    let mut out = ShellResult::default();
    let Ok((_, alpha)) = shell.element.stiffness(&shell.geometry, &section.stiffness) else {
        return out;
    };
    let base = covariant_base(&shell.geometry.positions, &shell.geometry.directors, 0.0, 0.0);
    let Some(centre) = cross_section_frame(&base) else { return out };
    for point in 0..4 {
        let Ok(strains) = shell.element.point_strains(&shell.geometry, point) else { continue };
        let (r, energy) = point_resultants(&strains, &alpha, &section.stiffness, &samples);
        let turn = Turn::between(&strains.frame, &centre);
        let membrane = turn.tensor([r[0], r[1], r[2]]);
        let bending = turn.tensor([r[6], r[7], r[8]]);
        let shear = turn.vector([r[4], r[5]]);
        for i in 0..3 {
            out.membrane[i] += 0.25 * membrane[i];
            out.bending[i] += 0.25 * bending[i];
        }
        for i in 0..2 {
            out.shear[i] += 0.25 * shear[i];
        }
        out.energy_density += energy * strains.area;
        out.area += strains.area;
    }
    if out.area > 0.0 {
        out.energy_density /= out.area;
    }
    stresses(&mut out, section.thickness);
    out
}

/// In-plane turn from one frame to another. Frames of a warped element also tilt, which is left out:
/// components are carried along with the surface.
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

/// Stresses from resultants.
fn stresses(r: &mut ShellResult, h: f64) {
    let middle: [f64; 3] = std::array::from_fn(|i| r.membrane[i] / h);
    let bending: [f64; 3] = std::array::from_fn(|i| 6.0 * r.bending[i] / (h * h));
    r.stress_top = std::array::from_fn(|i| middle[i] - bending[i]);
    r.stress_bottom = std::array::from_fn(|i| middle[i] + bending[i]);
    let shear = r.shear.map(|q| 1.5 * q / h);
    r.von_mises = von_mises(middle, shear)
        .max(von_mises(r.stress_top, [0.0; 2]))
        .max(von_mises(r.stress_bottom, [0.0; 2]));
}

/// Von Mises stress of in-plane stresses σ_xx, σ_yy, σ_xy and transverse shear stresses:
/// `√(σxx² + σyy² − σxx σyy + 3 (σxy² + τxz² + τyz²))`.
pub fn von_mises(plane: [f64; 3], shear: [f64; 2]) -> f64 {
    let [x, y, xy] = plane;
    (x * x + y * y - x * y + 3.0 * (xy * xy + shear[0] * shear[0] + shear[1] * shear[1])).sqrt()
}

#[cfg(test)]
mod tests;
