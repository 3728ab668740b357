//! Joints as contributions: constraint forces `Gᵀλ`, and the weight `γ GᵀG` of the augmented Lagrangian.

use std::ops::Range;
use std::sync::Arc;

use super::{Attachment, Row};
use crate::Vec3;
use crate::element::{ElementGroup, GroupPoint, Motion, TangentRequest};

/// A joint: constraints of one pair of bodies, nodes or the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name of the joint in the model.
    pub name: String,
    /// Nodal vectors that the constraints contain.
    pub vectors: Vec<u32>,
    /// Whether each of the vectors belongs to the first end of the joint.
    pub of_first: Vec<bool>,
    /// Point of the joint, fixed in its second end, or in the first one where the second is the ground.
    pub point: Attachment,
    /// Constraints.
    pub rows: Vec<Row>,
    /// Number of the first constraint among those of all joints.
    pub first: usize,
}

impl Joint {
    /// Present place of the joint, for given nodal vectors.
    pub fn place(&self, value: impl Fn(u32) -> Vec3) -> Vec3 {
        let point = &self.point;
        point.terms.iter().fold(point.constant, |x, &(v, weight)| x + value(v) * weight)
    }

    /// Numbers of the joint's constraints among those of all joints.
    pub fn multipliers(&self) -> Range<usize> {
        self.first..self.first + self.rows.len()
    }
}

/// Joints of as many nodal vectors each. Their forces act in the configuration of the motion: in the middle of a step for
/// the energy–momentum scheme, where constraints that do not depend on time do no work, because
/// `G(q_mid)(q₁ − q₀) = g₁ − g₀` holds exactly for quadratic g.
pub struct JointGroup {
    joints: Arc<Vec<Joint>>,
    members: Vec<usize>,
    vectors: usize,
}

impl JointGroup {
    /// Groups of all joints, one for each number of nodal vectors.
    pub fn groups(joints: &Arc<Vec<Joint>>) -> Vec<Box<dyn ElementGroup>> {
        let mut sizes: Vec<usize> = joints.iter().map(|joint| joint.vectors.len()).collect();
        sizes.sort_unstable();
        sizes.dedup();
        let of_size = |size: usize| -> Box<dyn ElementGroup> {
            let members = (0..joints.len()).filter(|&j| joints[j].vectors.len() == size).collect();
            Box::new(Self { joints: Arc::clone(joints), members, vectors: size })
        };
        sizes.into_iter().map(of_size).collect()
    }

    /// Adds the blocks of `weight · Σ γ GᵀG` of a joint with these gradients: `3 · vectors` numbers for each constraint.
    fn augment(joint: &Joint, gradients: &[Vec3], weight: f64, blocks: &mut [f64]) {
        let n = joint.vectors.len();
        for (row, g) in joint.rows.iter().zip(gradients.chunks(n)) {
            let mut pair = 0;
            for a in 0..n {
                for b in 0..=a {
                    let k = g[a] * g[b].transpose() * (weight * row.inertia);
                    for i in 0..9 {
                        blocks[9 * pair + i] += k[(i / 3, i % 3)];
                    }
                    pair += 1;
                }
            }
        }
    }
}

/// Nodal vectors in the configuration in which the forces of a motion act.
fn configuration(k: &GroupPoint, vectors: &[u32], out: &mut Vec<Vec3>) {
    out.clear();
    out.extend(vectors.iter().map(|&v| {
        let v = v as usize;
        let x = Vec3::from(k.reference[v]);
        match k.motion {
            Motion::State { u, .. } => x + Vec3::from(u[v]),
            Motion::Step { old, new, .. } => x + (Vec3::from(old[v]) + Vec3::from(new[v])) * 0.5,
        }
    }));
}

impl ElementGroup for JointGroup {
    fn name(&self) -> &'static str {
        "joint"
    }

    fn len(&self) -> usize {
        self.members.len()
    }

    fn vectors(&self, element: usize) -> &[u32] {
        &self.joints[self.members[element]].vectors
    }

    fn vectors_per_element(&self) -> usize {
        self.vectors
    }

    fn evaluate(&self, k: &GroupPoint, first: usize, forces: &mut [f64], tangent: Option<TangentRequest>) {
        let n = self.vectors;
        let mut tangent = tangent;
        let (mut v, mut gradients, mut force) = (Vec::with_capacity(n), Vec::new(), vec![Vec3::zeros(); n]);
        for (e, out) in forces.chunks_mut(3 * n).enumerate() {
            let joint = &self.joints[self.members[first + e]];
            configuration(k, &joint.vectors, &mut v);
            gradients.clear();
            gradients.resize(n * joint.rows.len(), Vec3::zeros());
            for (row, g) in joint.rows.iter().zip(gradients.chunks_mut(n)) {
                row.add_gradient(1.0, &v, g);
            }
            force.fill(Vec3::zeros());
            for (i, g) in gradients.chunks(n).enumerate() {
                // Forces of unknown multipliers must not look like none.
                let multiplier = k.multipliers.get(joint.first + i).copied().unwrap_or(f64::NAN);
                force.iter_mut().zip(g).for_each(|(f, g)| *f += g * multiplier);
            }
            for (out, f) in out.chunks_mut(3).zip(&force) {
                out.copy_from_slice(f.as_slice());
            }
            if let Some(request) = &mut tangent {
                let size = 9 * n * (n + 1) / 2;
                let blocks = &mut request.blocks[e * size..(e + 1) * size];
                blocks.fill(0.0);
                Self::augment(joint, &gradients, request.weights.augmentation, blocks);
            }
        }
    }
}
