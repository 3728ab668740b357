//! Workspace of factorisations and solutions, with a pool of reusable buffers for contribution blocks and for the row
//! sums of a solution.
//!
//! Buffers are mapped individually and not taken from the heap, where large buffers of all sizes, allocated and freed
//! by all threads, cause fragmentation: on two threads and 395 000 unknowns 50 MB beside the 60 MB in use.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, MutexGuard, PoisonError};

use memmap2::{MmapMut, MmapOptions};

use super::FactorError;
use super::dense::DiagonalBlock;

/// Numbers (`f64`) that may be wasted in a buffer, whatever its size: 2 MB.
const SPARE: usize = 1 << 18;

/// Buffer of `f64` numbers.
#[derive(Debug, Default)]
pub(super) struct Buffer(Option<MmapMut>);

impl Buffer {
    /// Maps a buffer of `n` numbers, initially zero.
    fn new(n: usize) -> Result<Self, FactorError> {
        let bytes = n.checked_mul(size_of::<f64>()).ok_or(FactorError::TooLarge)?;
        // The whole buffer is going to be written, so its pages are populated at once.
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

/// Free buffers, and the accounting of free and used memory.
#[derive(Debug, Default)]
struct Store {
    /// Free buffers, ascending by size.
    free: Vec<Buffer>,
    /// Numbers in the free buffers; `in_use` are those in the buffers in use, `peak` is the largest `in_use` so far.
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

/// Pool of workspace buffers. All buffers together are never larger than the peak of those in use at one time.
#[derive(Debug, Default)]
pub(super) struct WorkspacePool {
    store: Mutex<Store>,
    /// Low-memory mode: small requests do not get large buffers, so that less memory is in use.
    low_memory: bool,
}

impl WorkspacePool {
    /// Creates an empty pool.
    pub fn new(low_memory: bool) -> Self {
        Self { store: Mutex::default(), low_memory }
    }

    /// Resets the account of the buffers in use: those of a failed factorisation are gone.
    pub fn begin(&self) {
        self.store().in_use = 0;
    }

    fn store(&self) -> MutexGuard<'_, Store> {
        self.store.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Buffer of at least `n` numbers with arbitrary contents: the smallest free one that is large enough. In
    /// low-memory mode it exceeds `n` by half of it, or by 2 MB, at most.
    pub fn take(&self, n: usize) -> Result<Buffer, FactorError> {
        self.take_if(n, |size| !self.low_memory || size - n <= SPARE.max(n / 2))
    }

    /// Buffer of at least `n` numbers while no other buffer is in use: any free one that is large enough, in either
    /// mode.
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
        // Free buffers to be given up: the smallest one that makes enough room, or the largest.
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

    /// Returns a buffer to the pool.
    pub fn put(&self, piece: Buffer) {
        if !piece.is_empty() {
            let mut store = self.store();
            store.in_use = store.in_use.saturating_sub(piece.len());
            store.idle += piece.len();
            let at = store.free.partition_point(|p| p.len() < piece.len());
            store.free.insert(at, piece);
        }
    }

    /// Frees all buffers that are not in use.
    pub fn release(&self) {
        *self.store() = Store::default();
    }
}

/// Workspace of factorisations and solutions. One workspace may serve many matrices of any size, one after another; it
/// grows to the largest demand and holds no results.
#[derive(Default)]
pub struct Workspace {
    /// Buffers for contribution blocks and for the row sums of a solution.
    pub(super) pool: WorkspacePool,
    /// Workspace for a diagonal block, one for each thread.
    diagonal_blocks: Vec<Mutex<DiagonalBlock>>,
    /// Diagonal of the matrix that is factored.
    pub(super) diagonal: Vec<f64>,
    /// Vector of all columns in elimination order, for a solution.
    pub(super) columns: Vec<f64>,
    /// Panel of the interface, which holds the Schur complement after a sequential factorisation.
    pub(super) interface: Vec<f64>,
}

impl Workspace {
    /// Creates the workspace of several threads for matrices of order `n`.
    pub(super) fn new(threads: usize, n: usize, low_memory: bool) -> Result<Self, FactorError> {
        let mut out = Self { pool: WorkspacePool::new(low_memory), ..Self::default() };
        out.diagonal_blocks.extend((0..threads).map(|_| Mutex::new(DiagonalBlock::new())));
        for vector in [&mut out.diagonal, &mut out.columns] {
            vector.try_reserve_exact(n).map_err(|_| FactorError::TooLarge)?;
        }
        Ok(out)
    }

    /// Prepares a factorisation whose workspace holds the panel of the interface, with `interface` entries.
    pub(super) fn begin(&mut self, interface: usize) -> Result<(), FactorError> {
        self.pool.begin();
        let more = interface.saturating_sub(self.interface.len());
        self.interface.try_reserve_exact(more).map_err(|_| FactorError::TooLarge)?;
        self.interface.resize(interface, 0.0);
        if self.diagonal_blocks.is_empty() {
            self.diagonal_blocks.push(Mutex::new(DiagonalBlock::new()));
        }
        Ok(())
    }

    /// Number of threads that work at a time.
    pub(super) fn threads(&self) -> usize {
        self.diagonal_blocks.len()
    }

    /// Workspace of this thread for a diagonal block. The thread waits for no other work while it holds the lock.
    pub(super) fn diagonal_block(&self) -> MutexGuard<'_, DiagonalBlock> {
        let own = rayon::current_thread_index().unwrap_or(0);
        let block = &self.diagonal_blocks[own % self.diagonal_blocks.len()];
        block.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Vector of `n` zeros whose pages are not touched before they are used; an error where the memory does not suffice.
pub fn zeros(n: usize) -> Result<Vec<f64>, FactorError> {
    // The reservation fails with an error where `vec!` would abort the program.
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
        // No free buffer is large enough: free ones are given up to make room.
        let c = pool.take(2 * MANY + MANY / 2).unwrap();
        assert_eq!((c.len(), sizes(&pool)), (2 * MANY + MANY / 2, vec![]));
        pool.put(c);
        // A large buffer is not used for a small request: there is room for a new one.
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
