//! Parallel loops over chunks of the elements of a group.
//!
//! The functions take the work as a trait object, one call per chunk: the code of the thread pool is compiled once, not
//! for each type of element.

use rayon::prelude::*;

/// Elements per parallel task.
const CHUNK: usize = 64;

/// Calls `work` with the first element of each chunk and the part of `out` that belongs to its elements, `each` numbers
/// per element.
pub(super) fn for_each_chunk(out: &mut [f64], each: usize, work: &(dyn Fn(usize, &mut [f64]) + Sync)) {
    out.par_chunks_mut(CHUNK * each).enumerate().for_each(|(chunk, out)| work(chunk * CHUNK, out));
}

/// Work on a chunk, with its first element and its parts of two lists.
type WorkOnTwo<'a> = dyn Fn(usize, &mut [f64], &mut [f64]) + Sync + 'a;

/// [`for_each_chunk`] with two lists, and the numbers per element of each.
pub(super) fn for_each_chunk_of_two(
    (first, each_first): (&mut [f64], usize),
    (second, each_second): (&mut [f64], usize),
    work: &WorkOnTwo,
) {
    first
        .par_chunks_mut(CHUNK * each_first)
        .zip(second.par_chunks_mut(CHUNK * each_second))
        .enumerate()
        .for_each(|(chunk, (first, second))| work(chunk * CHUNK, first, second));
}
