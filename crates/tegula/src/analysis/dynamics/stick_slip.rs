//! Joints at rest that friction holds together: which of them slide, and in which directions.
//!
//! In a step, the displacements of the relative coordinates are `s = s₀ − W λ` with those without friction, s₀, the compliance W of the
//! mechanism at the coordinates, and the friction forces λ. Those of Coulomb's law, `|λᵢ| ≤ Tᵢ` and `λᵢ = Tᵢ sign sᵢ` where a joint slides,
//! minimise
//!
//! ```text
//! ½ λᵀ W λ − λᵀ s₀,   |λᵢ| ≤ Tᵢ
//! ```
//!
//! (principle of maximum dissipation). W is singular where several joints act on one motion: the forces are not unique then, but the motion
//! is. A joint whose force is at its limit sticks where others hold it. J. J. Moreau, *Unilateral contact and dry friction in finite freedom
//! dynamics* (1988); the projected Gauss–Seidel method as in M. Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999) 235–257.

use crate::norm::larger;

/// Most sweeps, and the change of a force over its limit at which they end.
const MOST_SWEEPS: u32 = 5000;
const CLOSE: f64 = 1e-12;

/// Force over its limit, less 1, that is round-off of the sweeps.
const STICKS: f64 = 1e-9;

/// Forces that hold the joints, or would hold those that slide: the friction and the force of the displacement that is left,
/// `λᵢ + sᵢ/Wᵢᵢ`. Joints whose force exceeds its limit slide. `displacements` are those without friction, `compliance` is W by rows.
pub(super) fn holding_forces(displacements: &[f64], compliance: &[f64], limits: &[f64]) -> Vec<f64> {
    let n = displacements.len();
    let acts = |i: usize| compliance[i * n + i] > 0.0 && limits[i] > 0.0;
    let mut forces = vec![0.0; n];
    let wanted = |forces: &[f64], i: usize| {
        let row = &compliance[i * n..][..n];
        let slip = displacements[i] - row.iter().zip(forces).map(|(w, x)| w * x).sum::<f64>();
        forces[i] + slip / row[i]
    };
    for _ in 0..MOST_SWEEPS {
        let mut change = 0.0;
        for i in (0..n).filter(|&i| acts(i)) {
            let new = wanted(&forces, i).clamp(-limits[i], limits[i]);
            change = larger(change, (new - forces[i]).abs() / limits[i]);
            forces[i] = new;
        }
        if change <= CLOSE {
            break;
        }
    }
    let with_rest = |i: usize| if acts(i) { wanted(&forces, i) } else { forces[i] };
    (0..n).map(with_rest).collect()
}

/// Directions in which the joints slide, and 0 for those that stick: signs of the [forces](holding_forces) that exceed their limits.
pub(super) fn directions(displacements: &[f64], compliance: &[f64], limits: &[f64]) -> Vec<f64> {
    let n = displacements.len();
    let forces = holding_forces(displacements, compliance, limits);
    let direction = |i: usize| {
        let without_friction = !(compliance[i * n + i] > 0.0 && limits[i] > 0.0);
        let slides = forces[i].abs() - limits[i] > STICKS * larger(limits[i], forces[i].abs());
        match slides {
            _ if without_friction => displacements[i].signum(),
            true => forces[i].signum(),
            false => 0.0,
        }
    };
    (0..n).map(direction).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_slides_where_its_limit_is_exceeded() {
        assert_eq!(directions(&[2.0, -3.0], &[1.0, 0.0, 0.0, 2.0], &[1.5, 2.0]), [1.0, 0.0]);
    }

    /// One motion q, with the displacements q and −2 q and unit stiffness: the force f slides it where |f| > T₁ + 2 T₂.
    #[test]
    fn joints_on_one_motion_share_its_force_and_slide_together() {
        let compliance = [1.0, -2.0, -2.0, 4.0];
        let of_force = |f: f64| directions(&[f, -2.0 * f], &compliance, &[1.0, 0.5]);
        assert!(of_force(1.9).contains(&0.0), "{:?}", of_force(1.9));
        assert_eq!(of_force(2.1), [1.0, -1.0]);
        assert_eq!(of_force(-2.1), [-1.0, 1.0]);
    }
}
