//! Memory that is lent for a while: what waits in a factorisation, and the sums of a solution.
//!
//! Pieces are mapped for themselves and not taken from the heap, where large pieces of all sizes that come and go in all
//! threads leave gaps: on two threads and 395 000 unknowns 50 MB beside the 60 MB that wait.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, MutexGuard, PoisonError};

use memmap2::{MmapMut, MmapOptions};

use super::FactorError;

/// Numbers that may be wasted in a piece, whatever its size: 2 MB.
const SPARE: usize = 1 << 18;

/// A piece of memory for numbers.
#[derive(Debug, Default)]
pub(super) struct Buffer(Option<MmapMut>);

impl Buffer {
    /// For some numbers, at first zero.
    fn new(n: usize) -> Result<Self, FactorError> {
        let bytes = n.checked_mul(size_of::<f64>()).ok_or(FactorError::TooLarge)?;
        // All of it is going to be written: its pages may come at once.
        let map = MmapOptions::new().len(bytes).populate().map_anon().map_err(|_| FactorError::TooLarge)?;
        Ok(Self(Some(map)))
    }
}

impl Deref for Buffer {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        self.0.as_ref().map_or(&[], |map| bytemuck::cast_slice(map))
    }
}

impl DerefMut for Buffer {
    fn deref_mut(&mut self) -> &mut [f64] {
        self.0.as_mut().map_or(&mut [], |map| bytemuck::cast_slice_mut(map))
    }
}

/// Pieces of memory that are not in use, and how much is.
#[derive(Debug, Default)]
struct Store {
    /// By size.
    free: Vec<Buffer>,
    /// Numbers in the free pieces, in those that are lent, and in the latter at most so far.
    idle: usize,
    in_use: usize,
    peak: usize,
}

impl Store {
    fn remove(&mut self, i: usize) -> Buffer {
        let piece = self.free.remove(i);
        self.idle -= piece.len();
        piece
    }

    fn count_use(&mut self, size: usize) {
        self.in_use += size;
        self.peak = self.peak.max(self.in_use);
    }
}

/// Lends pieces. Together they are never more than was lent at a time.
#[derive(Debug, Default)]
pub(super) struct WorkspacePool {
    store: Mutex<Store>,
    /// Little is not put into large pieces, so that less is lent.
    low_memory: bool,
}

impl WorkspacePool {
    /// Without any pieces.
    pub fn new(low_memory: bool) -> Self {
        Self { store: Mutex::default(), low_memory }
    }

    /// Nothing is lent any more: what a failed factorisation held is gone.
    pub fn begin(&self) {
        self.store().in_use = 0;
    }

    fn store(&self) -> MutexGuard<'_, Store> {
        self.store.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// At least `n` numbers, whatever they are: the smallest piece that is large enough; where memory is spared, it is not
    /// half as large again.
    pub fn take(&self, n: usize) -> Result<Buffer, FactorError> {
        self.take_if(n, |size| !self.low_memory || size - n <= SPARE.max(n / 2))
    }

    /// The same where no other piece is in use: any that is large enough will do.
    pub fn take_alone(&self, n: usize) -> Result<Buffer, FactorError> {
        self.take_if(n, |_| true)
    }

    fn take_if(&self, n: usize, fits: impl Fn(usize) -> bool) -> Result<Buffer, FactorError> {
        if n == 0 {
            return Ok(Buffer::default());
        }
        let mut store = self.store();
        let best = store.free.partition_point(|piece| piece.len() < n);
        if store.free.get(best).is_some_and(|piece| fits(piece.len())) {
            let piece = store.remove(best);
            store.count_use(piece.len());
            return Ok(piece);
        }
        store.count_use(n);
        // Given up: the smallest one that makes enough room, or the largest.
        let mut given_up = Vec::new();
        while store.in_use + store.idle > store.peak && !store.free.is_empty() {
            let room = store.in_use + store.idle - store.peak;
            let enough = store.free.partition_point(|piece| piece.len() < room);
            let last = store.free.len() - 1;
            given_up.push(store.remove(enough.min(last)));
        }
        drop(store);
        drop(given_up);
        Buffer::new(n)
    }

    /// Takes a piece back.
    pub fn put(&self, piece: Buffer) {
        if !piece.is_empty() {
            let mut store = self.store();
            store.in_use = store.in_use.saturating_sub(piece.len());
            store.idle += piece.len();
            let at = store.free.partition_point(|p| p.len() < piece.len());
            store.free.insert(at, piece);
        }
    }

    /// Gives back all that is not in use.
    pub fn release(&self) {
        *self.store() = Store::default();
    }
}

/// Memory that is not touched before it is used.
pub fn zeros(n: usize) -> Result<Vec<f64>, FactorError> {
    // Asks first: where there is not enough, `vec!` would end the program.
    Vec::<f64>::new().try_reserve_exact(n).map_err(|_| FactorError::TooLarge)?;
    Ok(vec![0.0; n])
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    const MANY: usize = 8 * SPARE;

    fn sizes(pool: &WorkspacePool) -> Vec<usize> {
        pool.store().free.iter().map(|piece| piece.len()).collect()
    }

    #[test]
    fn pieces_are_lent_again() {
        let pool = WorkspacePool::default();
        let (a, b) = (pool.take(100).unwrap(), pool.take(1000).unwrap());
        let at = b.as_ptr();
        pool.put(a);
        pool.put(b);
        let again = pool.take(600).unwrap();
        assert_eq!((again.as_ptr(), again.len()), (at, 1000));
        assert_eq!(sizes(&pool), [100]);
        assert!(pool.take(0).unwrap().is_empty());
    }

    #[test]
    fn pieces_are_never_more_than_was_lent_at_a_time() {
        let pool = WorkspacePool::new(true);
        let (a, b) = (pool.take(MANY).unwrap(), pool.take(2 * MANY).unwrap());
        pool.put(a);
        pool.put(b);
        // Nothing is large enough: one makes room that suffices.
        let c = pool.take(2 * MANY + MANY / 2).unwrap();
        assert_eq!((c.len(), sizes(&pool)), (2 * MANY + MANY / 2, vec![]));
        pool.put(c);
        // Large pieces are not for little: a new one, as there is room for it.
        let d = pool.take(MANY / 2).unwrap();
        assert_eq!((d.len(), sizes(&pool)), (MANY / 2, vec![2 * MANY + MANY / 2]));
        let e = pool.take_alone(MANY).unwrap();
        assert_eq!(e.len(), 2 * MANY + MANY / 2);
    }

    #[test]
    fn the_smallest_that_makes_room_is_given_up() {
        let pool = WorkspacePool::default();
        let pieces = [1, 2, 4].map(|k| pool.take(k * MANY).unwrap());
        pieces.into_iter().for_each(|piece| pool.put(piece));
        let a = pool.take(4 * MANY).unwrap();
        assert_eq!(sizes(&pool), [MANY, 2 * MANY]);
        let b = pool.take(3 * MANY).unwrap();
        assert_eq!((b.len(), sizes(&pool)), (3 * MANY, vec![]));
        pool.put(a);
        pool.release();
        assert!(sizes(&pool).is_empty());
    }

    #[test]
    fn memory_that_nobody_has_is_refused() {
        assert_eq!(WorkspacePool::default().take(usize::MAX).err(), Some(FactorError::TooLarge));
        assert_eq!(WorkspacePool::default().take(1 << 58).err(), Some(FactorError::TooLarge));
    }
}
