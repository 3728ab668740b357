//! Drilling components of moments during a run.
//!
//! A single director resists no rotation about itself, so a moment that is constant in space loses its component along
//! the director as the shell turns. The user is told how much.

use super::Observer;
use crate::Vec3;
use crate::element::Nodal;
use crate::load::FollowerLoad;
use crate::system::System;

/// Lost share of a moment that is reported first.
const FIRST: f64 = 0.01;
/// It is reported again when it has grown by this factor.
const GROWTH: f64 = 2.0;

/// Reports lost shares of moments, each time that they have grown.
pub(super) struct DrillingWatch {
    /// Share from which on the next report is due.
    next: f64,
}

impl DrillingWatch {
    /// Nothing is reported yet.
    pub fn new() -> Self {
        Self { next: FIRST }
    }

    /// Looks at a state; `at` says for people where it is.
    pub fn look(
        &mut self,
        system: &System,
        (u, time): (&[Nodal], f64),
        observer: &mut dyn Observer,
        at: impl Fn() -> String,
    ) {
        if system.linear {
            return;
        }
        let share = |load: &FollowerLoad| match load {
            FollowerLoad::Moment { vector, .. } if system.amplitude(load.amplitude(), time) != 0.0 => {
                let v = *vector as usize;
                Some((load.lost_share(&[Vec3::from(system.reference[v]) + Vec3::from(u[v])]), v))
            }
            _ => None,
        };
        let shares = || system.followers.iter().filter_map(share);
        let Some((largest, vector)) = shares().max_by(|a, b| a.0.total_cmp(&b.0)) else { return };
        if largest < self.next {
            return;
        }
        self.next = GROWTH * largest;
        observer.on_event(&format!(
            "{}: {:.0} % of the moment at node {} lies along its director, which nothing resists, and is lost \
             ({} moment(s) lose 1 % or more); an `edge-moment` keeps it",
            at(),
            100.0 * largest,
            system.node_label(system.nodes[vector]),
            shares().filter(|(share, _)| *share >= FIRST).count()
        ));
    }
}
