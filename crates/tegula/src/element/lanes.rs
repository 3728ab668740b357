//! SIMD across elements: one element per lane of a vector register, one source for every register width.
//!
//! Element data is stored in batches of [`BATCH`] elements, value by value (array of structures of arrays): a register
//! of 8, 4, 2 or 1 lanes takes a whole batch or a part of it. The layout therefore does not depend on the machine.

use pulp::{Arch, Simd, WithSimd, bytemuck};

/// Elements per batch: as many as the widest registers have lanes.
pub const BATCH: usize = 8;

/// Copies values stored element by element into the batch layout.
pub fn in_batches(values: &[f64], per_element: usize) -> Vec<f64> {
    if per_element == 0 {
        return Vec::new();
    }
    let elements = values.len() / per_element;
    let mut out = vec![0.0; elements.div_ceil(BATCH) * BATCH * per_element];
    for (e, own) in values.chunks_exact(per_element).enumerate() {
        let batch = e / BATCH * BATCH * per_element;
        for (i, &value) in own.iter().enumerate() {
            out[batch + i * BATCH + e % BATCH] = value;
        }
    }
    out
}

/// Registers of one instruction set that hold the elements from `first` on.
#[derive(Clone, Copy)]
pub struct Lanes<S: Simd> {
    /// Instruction set.
    pub simd: S,
    /// First element of the register.
    pub first: usize,
}

impl<S: Simd> Lanes<S> {
    /// Lanes of a register.
    pub const LANES: usize = S::F64_LANES;
    /// Registers per batch.
    pub const PARTS: usize = BATCH / S::F64_LANES;

    /// Broadcast of one number to all lanes.
    #[inline(always)]
    pub fn splat(self, value: f64) -> S::f64s {
        self.simd.splat_f64s(value)
    }

    /// `a + b`.
    #[inline(always)]
    pub fn add(self, a: S::f64s, b: S::f64s) -> S::f64s {
        Self::count(1);
        self.simd.add_f64s(a, b)
    }

    /// `a − b`.
    #[inline(always)]
    pub fn sub(self, a: S::f64s, b: S::f64s) -> S::f64s {
        Self::count(1);
        self.simd.sub_f64s(a, b)
    }

    /// `a b`.
    #[inline(always)]
    pub fn mul(self, a: S::f64s, b: S::f64s) -> S::f64s {
        Self::count(1);
        self.simd.mul_f64s(a, b)
    }

    /// `a b + c`.
    #[inline(always)]
    pub fn mul_add(self, a: S::f64s, b: S::f64s, c: S::f64s) -> S::f64s {
        Self::count(2);
        self.simd.mul_add_e_f64s(a, b, c)
    }

    /// Counts floating-point operations of every lane in tests; does nothing otherwise.
    #[inline(always)]
    fn count(_operations: usize) {
        #[cfg(test)]
        operations::add(_operations * Self::LANES);
    }

    /// Batch of these lanes in an array of `per_element` values per element; entry i is at [`part`](Self::part)`(i)`.
    #[inline(always)]
    pub fn batch(self, values: &[f64], per_element: usize) -> &[S::f64s] {
        self.batch_at(values, per_element, self.first / BATCH)
    }

    /// Batch `number` of an array of `per_element` values per element.
    #[inline(always)]
    pub fn batch_at(self, values: &[f64], per_element: usize, number: usize) -> &[S::f64s] {
        let size = per_element * BATCH;
        S::as_simd_f64s(&values[number * size..(number + 1) * size]).0
    }

    /// Index of an entry in a [`batch`](Self::batch).
    #[inline(always)]
    pub fn part(self, entry: usize) -> usize {
        entry * Self::PARTS + self.first % BATCH / Self::LANES
    }

    /// Register filled lane by lane with `of_lane(lane)`.
    #[inline(always)]
    pub fn gather(self, of_lane: impl Fn(usize) -> f64) -> S::f64s {
        let values: [f64; BATCH] = std::array::from_fn(of_lane);
        S::as_simd_f64s(&values[..Self::LANES]).0[0]
    }

    /// Reads `count` values per element, stored element by element, into lanes.
    #[inline(always)]
    pub fn read(self, values: &[f64], count: usize, to: &mut [S::f64s]) {
        let flat: &mut [f64] = bytemuck::cast_slice_mut(to);
        let own = values[self.first * count..].chunks_exact(count).take(Self::LANES);
        for (lane, own) in own.enumerate() {
            for i in 0..count {
                flat[i * Self::LANES + lane] = own[i];
            }
        }
    }

    /// Writes lanes back element by element, `count` values each.
    #[inline(always)]
    pub fn write(self, from: &[S::f64s], count: usize, out: &mut [f64]) {
        let flat: &[f64] = bytemuck::cast_slice(from);
        for (lane, own) in out.chunks_exact_mut(count).enumerate() {
            for i in 0..count {
                own[i] = flat[i * Self::LANES + lane];
            }
        }
    }
}

/// Runs `work` on `count` elements from `first` on, one register at a time; `first` begins a batch.
#[inline]
pub fn run(arch: Arch, first: usize, count: usize, work: impl LaneWork) {
    debug_assert_eq!(first % BATCH, 0);
    #[cfg(test)]
    let arch = operations::arch().unwrap_or(arch);
    arch.dispatch(Dispatch { first, count, work });
}

/// Kernel that processes the elements of a task, one register at a time.
pub trait LaneWork {
    /// Workspace that the registers of a task use one after another.
    type Space<S: Simd>;
    /// New workspace of a task.
    fn space<S: Simd>(simd: S) -> Self::Space<S>;
    /// Processes the elements in `lanes`, which begin `offset` elements behind the first of the task.
    fn work<S: Simd>(&mut self, lanes: Lanes<S>, offset: usize, space: &mut Self::Space<S>);
}

struct Dispatch<F> {
    first: usize,
    count: usize,
    work: F,
}

impl<F: LaneWork> WithSimd for Dispatch<F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let mut space = F::space(simd);
        for offset in (0..self.count).step_by(S::F64_LANES) {
            self.work.work(Lanes { simd, first: self.first + offset }, offset, &mut space);
        }
    }
}

/// Count of the floating-point operations of this thread.
#[cfg(test)]
pub mod operations {
    use std::cell::Cell;

    use super::Arch;

    thread_local! {
        static COUNT: Cell<usize> = const { Cell::new(0) };
        static ARCH: Cell<Option<Arch>> = const { Cell::new(None) };
    }

    /// Adds operations to the count of this thread.
    pub fn add(operations: usize) {
        COUNT.set(COUNT.get() + operations);
    }

    /// Instruction set that replaces the machine's, where a test asks for one.
    pub fn arch() -> Option<Arch> {
        ARCH.get()
    }

    /// Floating-point operations of `work` on this thread, with a given instruction set or the machine's own.
    pub fn of(arch: Option<Arch>, work: impl FnOnce()) -> usize {
        ARCH.set(arch);
        let before = COUNT.get();
        work();
        ARCH.set(None);
        COUNT.get() - before
    }
}
