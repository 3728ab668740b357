//! Sparsity pattern of the tangent and the mass of an analysis step.

use super::Compiler;
use crate::Result;
use crate::load::FollowerLoad;
use crate::system::pattern::{BATCH, PatternBuilder};
use crate::system::{LocalFrames, Pattern, Procedure, Reduction};

impl Compiler<'_> {
    /// Sparsity pattern of the tangent, and the consistent mass. Explicit steps have but the diagonal, for the lumped
    /// mass, and the inertia of rigid bodies; the iterative solver takes the elements' own blocks.
    pub(super) fn pattern(
        &self,
        procedure: Procedure,
        frames: &LocalFrames,
        (followers, reductions): (&[FollowerLoad], &[Option<Reduction>]),
        added: &[(u32, u32, f64)],
    ) -> Result<Pattern> {
        let mut builder = PatternBuilder::new(procedure.has_tangent_pattern());
        for body in &self.vectors.coordinates.bodies {
            builder.mass(body.centre, body.centre, body.mass);
            if let Some(directors) = body.directors {
                builder.body(directors, &body.euler);
            }
        }
        if procedure != Procedure::Explicit {
            for (group, reduction) in self.groups.iter().zip(reductions) {
                for first in (0..group.len()).step_by(BATCH) {
                    let batch = first..group.len().min(first + BATCH);
                    for e in batch.clone() {
                        if reduction.as_ref().is_some_and(|reduction| reduction.contains(e)) {
                            builder.pass_over(group.vectors(e), group.mass(e));
                        } else {
                            builder.element(group.vectors(e), group.mass(e));
                        }
                    }
                    for vectors in reduction.iter().flat_map(|reduction| reduction.vectors(batch.clone())) {
                        builder.reduced(vectors);
                    }
                    builder.end_batch();
                }
            }
            for load in followers {
                builder.element(load.vectors(), &[]);
            }
            for &(a, b, m) in added {
                builder.mass(a, b, m);
            }
        }
        builder.build(self.vectors.coordinates.reference.len(), frames)
    }
}
