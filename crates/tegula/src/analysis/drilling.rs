//! Monitor of the drilling components of moments during a run.
//!
//! A single director has no drilling stiffness. As the shell rotates, a moment that is constant in space gets a drilling
//! component, the one along the director, which is dropped. The monitor tells the user how much that is.

use super::Observer;
use crate::Vec3;
use crate::element::Nodal;
use crate::load::FollowerLoad;
use crate::system::System;

/// Ratio of the drilling component to the moment that triggers the first report.
const FIRST: f64 = 0.01;
/// Growth factor of this ratio that triggers the next report.
const GROWTH: f64 = 2.0;

/// Drilling monitor: reports the drilling components of moments each time that they have grown.
pub(super) struct DrillingWatch {
    /// Ratio of the drilling component to the moment that triggers the next report.
    next: f64,
}

impl DrillingWatch {
    /// Monitor without any report yet.
    pub fn new() -> Self {
        Self { next: FIRST }
    }

    /// Checks a state; `at` gives its time or load factor as text.
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
            FollowerLoad::Moment { vector, .. } if system.factor(load.factor(), time) != 0.0 => {
                let v = *vector as usize;
                Some((load.lost_share(&[Vec3::from(system.coordinates.reference[v]) + Vec3::from(u[v])]), v))
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
            "{}: {:.0} % of the moment at node {} is a drilling moment (along the director), for which a node has no \
             stiffness, and is dropped ({} moment(s) with 1 % or more); an `edge-moment` transfers it",
            at(),
            100.0 * largest,
            system.node_label(system.coordinates.nodes[vector]),
            shares().filter(|(share, _)| *share >= FIRST).count()
        ));
    }
}
