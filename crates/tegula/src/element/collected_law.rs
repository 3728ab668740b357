//! Material laws that are evaluated at many points in one call.
//!
//! Elements evaluate their laws point by point, and find their enhanced parameters by an iteration of their own. A law that is
//! [`is_collected`](MaterialLaw::is_collected) answers from a table instead: elements run until strains are missing there, all missing
//! strains are evaluated in one call, and the elements run again, until none is missing. So there is one call for each iteration of
//! the enhanced parameters, for all points of a batch of elements. Strains are found in the table by their bits.

use std::collections::{BTreeSet, HashMap};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError, RwLock};

use nalgebra::{Matrix6, Vector6};

use crate::material::{Law, Response, Strain};

/// Number of a law and bits of a strain.
type Key = (u32, [u64; 6]);

/// Responses of the laws of a group that are evaluated together.
#[derive(Debug, Default)]
pub struct Collector {
    /// Number of evaluations of the group that are under way, in several threads.
    active: AtomicUsize,
    /// Count of strains that were not in the table.
    misses: AtomicU64,
    known: RwLock<HashMap<Key, Option<Response>>>,
    missing: Mutex<BTreeSet<Key>>,
}

/// Evaluation under way.
struct Active<'a>(&'a AtomicUsize);

impl Drop for Active<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

impl Collector {
    /// Runs an evaluation of elements again and again, until the responses at all of its points are known.
    pub fn run(&self, laws: &[Law], work: &mut dyn FnMut()) {
        // Locks are held for single accesses only: laws may take other ones, and threads that wait may begin other evaluations.
        if self.active.fetch_add(1, Ordering::SeqCst) == 0 {
            self.known.write().unwrap_or_else(PoisonError::into_inner).clear();
        }
        let _active = Active(&self.active);
        loop {
            let before = self.misses.load(Ordering::SeqCst);
            work();
            if self.misses.load(Ordering::SeqCst) == before {
                return;
            }
            self.evaluate_missing(laws);
        }
    }

    /// Response from the table; NaN where it is not known yet. `None`: no evaluation is under way.
    pub fn respond(&self, law: u32, strain: &Strain) -> Option<Option<Response>> {
        if self.active.load(Ordering::SeqCst) == 0 {
            return None;
        }
        let key = (law, std::array::from_fn(|i| strain[i].to_bits()));
        if let Some(known) = self.known.read().unwrap_or_else(PoisonError::into_inner).get(&key) {
            return Some(known.clone());
        }
        self.missing.lock().unwrap_or_else(PoisonError::into_inner).insert(key);
        self.misses.fetch_add(1, Ordering::SeqCst);
        Some(Some(Response {
            stress: Vector6::repeat(f64::NAN),
            tangent: Matrix6::repeat(f64::NAN),
            energy: f64::NAN,
            dissipation: f64::NAN,
        }))
    }

    /// Evaluates all missing strains, each law in one call.
    fn evaluate_missing(&self, laws: &[Law]) {
        let missing = std::mem::take(&mut *self.missing.lock().unwrap_or_else(PoisonError::into_inner));
        let mut missing: Vec<Key> = missing.into_iter().collect();
        // Elements at rest and elements of one shape have equal strains: each strain is evaluated once.
        while let Some(&(number, _)) = missing.last() {
            let of_law = missing.split_off(missing.partition_point(|(law, _)| *law < number));
            let strain = |(_, bits): &Key| Vector6::from_fn(|i, _| f64::from_bits(bits[i]));
            let strains: Vec<Strain> = of_law.iter().map(strain).collect();
            let responses = match laws.get(number as usize) {
                // A strain that is no number has no response.
                Some(law) => {
                    let finite: Vec<Strain> =
                        strains.iter().filter(|s| s.iter().all(|x| x.is_finite())).copied().collect();
                    let mut found = law.respond_many(&finite).into_iter();
                    let of = |s: &Strain| s.iter().all(|x| x.is_finite()).then(|| found.next().flatten());
                    strains.iter().map(of).map(Option::flatten).collect()
                }
                None => vec![None; strains.len()],
            };
            self.known
                .write()
                .unwrap_or_else(PoisonError::into_inner)
                .extend(of_law.into_iter().zip(responses));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::AtomicUsize;

    use super::*;
    use crate::material::{MaterialLaw, OwnLaw};

    /// Hooke's law `S = E` with the number of its calls.
    #[derive(Debug, Default)]
    struct Counted(AtomicUsize);

    impl MaterialLaw for Counted {
        fn respond(&self, strain: &Strain, _: &[f64], _: &mut [f64]) -> Option<Response> {
            self.respond_many(&[*strain]).pop().flatten()
        }

        fn is_collected(&self) -> bool {
            true
        }

        fn respond_many(&self, strains: &[Strain]) -> Vec<Option<Response>> {
            self.0.fetch_add(1, Ordering::SeqCst);
            let of = |s: &Strain| Response {
                stress: *s,
                tangent: Matrix6::identity(),
                energy: 0.5 * s.norm_squared(),
                dissipation: 0.0,
            };
            strains.iter().map(|s| Some(of(s))).collect()
        }
    }

    #[test]
    fn strains_of_all_points_are_evaluated_in_one_call_for_each_of_two_dependent_evaluations() {
        let counted = Arc::new(Counted::default());
        let laws = [Law::Own(OwnLaw(counted.clone()))];
        let collector = Collector::default();
        let mut sum = 0.0;
        collector.run(&laws, &mut || {
            sum = 0.0;
            for point in 0..100 {
                let first = Vector6::repeat(f64::from(point));
                let first = collector.respond(0, &first).unwrap().unwrap();
                // The second strain depends on the first stress.
                if first.energy.is_finite() {
                    sum += collector.respond(0, &(first.stress * 2.0)).unwrap().unwrap().energy;
                }
            }
        });
        // Σ ½ · 6 · (2p)² = 12 Σ p², p < 100: 12 · 328350.
        assert_eq!(sum, 3_940_200.0);
        assert_eq!(counted.0.load(Ordering::SeqCst), 2);
        assert!(collector.respond(0, &Vector6::zeros()).is_none());
    }

    #[test]
    fn a_strain_that_is_no_number_has_no_response() {
        let laws = [Law::Own(OwnLaw(Arc::new(Counted::default())))];
        let collector = Collector::default();
        let mut found = [None, None];
        collector.run(&laws, &mut || {
            found = [f64::NAN, 1.0].map(|x| collector.respond(0, &Vector6::repeat(x)).unwrap());
        });
        let [without, with] = found;
        assert!(without.is_none());
        assert_eq!(with.unwrap().stress, Vector6::repeat(1.0));
    }
}
