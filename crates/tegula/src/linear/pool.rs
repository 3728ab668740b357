//! Memory that is lent for a while: what waits in a factorisation, and the sums of a solution.

use std::sync::{Mutex, PoisonError};

use super::FactorError;

/// Pieces of memory that are not in use. As long as there are any, no more is asked for than they give up.
#[derive(Default)]
pub(super) struct Pool {
    free: Mutex<Vec<Vec<f64>>>,
}

impl Pool {
    /// At least `n` numbers, whatever they are.
    pub fn take(&self, n: usize) -> Result<Vec<f64>, FactorError> {
        if n == 0 {
            return Ok(Vec::new());
        }
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let fits = |piece: &Vec<f64>| (n..=2 * n).contains(&piece.len());
        let best = (0..free.len()).filter(|&i| fits(&free[i])).min_by_key(|&i| free[i].len());
        if let Some(best) = best {
            return Ok(free.swap_remove(best));
        }
        free.sort_unstable_by_key(Vec::len);
        let mut given_up = 0;
        while given_up < n
            && let Some(piece) = free.pop()
        {
            given_up += piece.len();
        }
        drop(free);
        zeros(n)
    }

    /// Takes a piece back.
    pub fn put(&self, piece: Vec<f64>) {
        if !piece.is_empty() {
            self.free.lock().unwrap_or_else(PoisonError::into_inner).push(piece);
        }
    }

    /// Gives back all that is not in use.
    pub fn release(&self) {
        *self.free.lock().unwrap_or_else(PoisonError::into_inner) = Vec::new();
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
        // Nothing fits: both make room.
        assert_eq!(pool.take(1050).unwrap().len(), 1050);
        assert_eq!(pool.free.lock().unwrap().len(), 0);
        assert!(pool.take(0).unwrap().is_empty());
    }
}
