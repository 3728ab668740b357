//! Work of driven joints.

use super::System;
use crate::Vec3;
use crate::constraint::joint::MOST_VECTORS;
use crate::element::Nodal;

impl System {
    /// Work that the drives of joints do on the model between the displacements `old` and `new`: that of the constraint forces
    /// `−Gᵀλ` with the gradients in the middle of the motion, where the drives have their values at `time`. Constraints that do
    /// not depend on time do no work, and are left out. `multiplier` gives λ of a constraint by its number.
    pub fn work_of_drives(
        &self,
        [old, new]: [&[Nodal]; 2],
        time: f64,
        multiplier: impl Fn(usize) -> f64,
    ) -> f64 {
        let mut work = 0.0;
        for joint in self.joints.iter().filter(|joint| joint.drive.is_some()) {
            let n = joint.vectors.len();
            let (mut vectors, mut gradients) = ([Vec3::zeros(); MOST_VECTORS], [Vec3::zeros(); MOST_VECTORS]);
            let (v, gradient) = (&mut vectors[..n], &mut gradients[..n]);
            for (v, &number) in v.iter_mut().zip(&joint.vectors) {
                let at = number as usize;
                *v = Vec3::from(self.coordinates.reference[at])
                    + (Vec3::from(old[at]) + Vec3::from(new[at])) * 0.5;
            }
            let drive = self.drive(joint, time).value;
            for (number, row) in joint.multipliers().zip(&joint.rows) {
                row.add_gradient(-multiplier(number), v, drive, gradient);
            }
            for (g, &number) in gradient.iter().zip(&joint.vectors) {
                let at = number as usize;
                work += g.dot(&(Vec3::from(new[at]) - Vec3::from(old[at])));
            }
        }
        work
    }
}
