//! Memory that is lent for a while: what waits in a factorisation, and the sums of a solution.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::FactorError;

/// Pieces of memory that are not in use. As long as there are any, no more is asked for than they give up.
#[derive(Default)]
pub(super) struct Pool {
    free: Mutex<Vec<Vec<f64>>>,
    /// Sizes of the pieces that it begins with.
    planned: Vec<usize>,
}

/// What is done where a piece is wanted.
enum Choice {
    /// This one is taken.
    Take(usize),
    /// These, as many as there are from this one on, are given up for a new one.
    GiveUp(usize),
}

/// Chooses among the sizes of free pieces, ascending.
fn choose(free: impl DoubleEndedIterator<Item = usize> + ExactSizeIterator + Clone, n: usize) -> Choice {
    if let Some(best) = free.clone().position(|size| size >= n) {
        return Choice::Take(best);
    }
    let mut kept = free.len();
    let mut given_up = 0;
    for size in free.rev() {
        if given_up >= n {
            break;
        }
        given_up += size;
        kept -= 1;
    }
    Choice::GiveUp(kept)
}

/// Pieces that would be lent in a course of events, and come back: sizes only.
#[derive(Default)]
pub(super) struct Rehearsal {
    free: Vec<usize>,
}

impl Rehearsal {
    /// Size of the piece that [`Pool::take`] would find.
    pub fn take(&mut self, n: usize) -> usize {
        if n == 0 {
            return 0;
        }
        match choose(self.free.iter().copied(), n) {
            Choice::Take(i) => self.free.remove(i),
            Choice::GiveUp(kept) => {
                self.free.truncate(kept);
                n
            }
        }
    }

    /// It comes back.
    pub fn put(&mut self, size: usize) {
        if size > 0 {
            let at = self.free.partition_point(|s| *s < size);
            self.free.insert(at, size);
        }
    }
}

impl Pool {
    /// With the pieces that are free at the end of a rehearsal.
    pub fn rehearsed(rehearsal: Rehearsal) -> Self {
        Self { planned: rehearsal.free, ..Self::default() }
    }

    /// Takes the memory that was planned, if none is held.
    pub fn prepare(&self) -> Result<(), FactorError> {
        let mut free = self.free();
        if free.is_empty() {
            *free = self.planned.iter().map(|&n| zeros(n)).collect::<Result<_, _>>()?;
        }
        Ok(())
    }

    fn free(&self) -> MutexGuard<'_, Vec<Vec<f64>>> {
        self.free.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// At least `n` numbers, whatever they are: the smallest piece that is large enough.
    pub fn take(&self, n: usize) -> Result<Vec<f64>, FactorError> {
        if n == 0 {
            return Ok(Vec::new());
        }
        let mut free = self.free();
        let choice = choose(free.iter().map(Vec::len), n);
        match choice {
            Choice::Take(i) => return Ok(free.remove(i)),
            Choice::GiveUp(kept) => free.truncate(kept),
        }
        drop(free);
        zeros(n)
    }

    /// The same where no other piece is in use: none is given up, and any that is large enough will do.
    pub fn take_alone(&self, n: usize) -> Result<Vec<f64>, FactorError> {
        let mut free = self.free();
        let at = free.partition_point(|piece| piece.len() < n);
        if at < free.len() {
            return Ok(free.remove(at));
        }
        drop(free);
        zeros(n)
    }

    /// Takes a piece back.
    pub fn put(&self, piece: Vec<f64>) {
        if !piece.is_empty() {
            let mut free = self.free();
            let at = free.partition_point(|p| p.len() < piece.len());
            free.insert(at, piece);
        }
    }

    /// Gives back all that is not in use.
    pub fn release(&self) {
        *self.free() = Vec::new();
    }
}

/// Memory that is not touched before it is used.
pub(super) fn zeros(n: usize) -> Result<Vec<f64>, FactorError> {
    // Asks first: where there is not enough, `vec!` would end the program.
    Vec::<f64>::new().try_reserve_exact(n).map_err(|_| FactorError::TooLarge)?;
    Ok(vec![0.0; n])
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_lent_again() {
        let pool = Pool::default();
        let (a, b) = (pool.take(100).unwrap(), pool.take(1000).unwrap());
        let at = b.as_ptr();
        pool.put(a);
        pool.put(b);
        let again = pool.take(600).unwrap();
        assert_eq!((again.as_ptr(), again.len()), (at, 1000));
        pool.put(again);
        // Nothing is large enough: both make room.
        assert_eq!(pool.take(1050).unwrap().len(), 1050);
        assert_eq!(pool.free().len(), 0);
        assert!(pool.take(0).unwrap().is_empty());
    }

    #[test]
    fn nothing_is_given_up_for_a_piece_that_is_used_alone() {
        let pool = Pool::default();
        pool.put(vec![0.0; 100]);
        let rows = pool.take_alone(200).unwrap();
        pool.put(rows);
        assert_eq!(pool.free().iter().map(Vec::len).collect::<Vec<_>>(), [100, 200]);
    }

    #[test]
    fn what_was_rehearsed_is_there() {
        let mut rehearsal = Rehearsal::default();
        let (a, b) = (rehearsal.take(10), rehearsal.take(20));
        rehearsal.put(a);
        let c = rehearsal.take(7);
        assert_eq!((a, b, c), (10, 20, 10));
        rehearsal.put(b);
        rehearsal.put(c);
        let pool = Pool::rehearsed(rehearsal);
        pool.prepare().unwrap();
        let sizes = [7, 20].map(|n| pool.take(n).unwrap().len());
        assert_eq!(sizes, [10, 20]);
    }
}
