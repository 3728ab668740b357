//! Sparsity pattern of the tangent and the mass of an analysis step.

use super::Compiler;
use crate::Result;
use crate::load::FollowerLoad;
use crate::system::pattern::{BATCH, PatternBuilder};
use crate::system::{LocalFrames, Pattern, Procedure, Reduction};

/// Follower loads, with their reduction to the degrees of freedom of rigid bodies.
pub(super) struct ReducedLoads<'a> {
    pub loads: &'a [FollowerLoad],
    pub reduction: Option<&'a Reduction>,
}

impl Compiler<'_> {
    /// Sparsity pattern of the tangent, and the consistent mass. Explicit steps have but the diagonal, for the lumped
    /// mass, and the inertia of rigid bodies; the iterative solver takes the elements' own blocks.
    pub(super) fn pattern(
        &self,
        procedure: Procedure,
        frames: &LocalFrames,
        (reductions, followers): (&[Option<Reduction>], ReducedLoads),
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
                let element = |e: usize| (group.vectors(e), group.mass(e));
                add_batches(&mut builder, group.len(), reduction.as_ref(), element);
            }
            let ReducedLoads { loads, reduction } = followers;
            add_batches(&mut builder, loads.len(), reduction, |load| (loads[load].vectors(), &[]));
            for &(a, b, m) in added {
                builder.mass(a, b, m);
            }
        }
        builder.build(self.vectors.coordinates.reference.len(), frames)
    }
}

/// Adds a number of contributions, given by their nodal vectors and masses, in batches; reduced ones of a batch lie behind it.
fn add_batches<'a>(
    builder: &mut PatternBuilder,
    number: usize,
    reduction: Option<&Reduction>,
    contribution: impl Fn(usize) -> (&'a [u32], &'a [f64]),
) {
    for first in (0..number).step_by(BATCH) {
        let batch = first..number.min(first + BATCH);
        for e in batch.clone() {
            let (vectors, mass) = contribution(e);
            if reduction.is_some_and(|reduction| reduction.contains(e)) {
                builder.pass_over(vectors, mass);
            } else {
                builder.element(vectors, mass);
            }
        }
        for vectors in reduction.iter().flat_map(|reduction| reduction.vectors(batch.clone())) {
            builder.reduced(vectors);
        }
        builder.end_batch();
    }
}
