//! Compressed graph of supervariables and its fill-reducing ordering by approximate minimum degree.
//!
//! The unknowns of a node have one sparsity pattern: they are indistinguishable and form a supervariable. Ordering and
//! symbolic factorisation work on the compressed graph of supervariables, which makes both cheaper by an order of
//! magnitude.

use std::collections::HashMap;

use dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMat;
use faer::sparse::linalg::amd;

use super::FactorError;

/// Compressed graph: its vertices are supervariables, sets of indistinguishable unknowns (equal neighbours).
pub(super) struct CompressedGraph {
    /// Unknowns of each supervariable.
    pub supervariables: Vec<Vec<u32>>,
    /// Adjacent supervariables of each supervariable, without itself.
    pub neighbours: Vec<Vec<u32>>,
}

fn mix(x: u64) -> u64 {
    let mut z = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl CompressedGraph {
    /// Builds the compressed graph from the lower triangle in compressed columns.
    pub fn new(pointers: &[usize], rows: &[u32]) -> Self {
        let n = pointers.len() - 1;
        let column = |j: usize| &rows[pointers[j]..pointers[j + 1]];
        // Sums of two hashes over all neighbours of an unknown, itself included: equal for indistinguishable unknowns.
        // A collision of different neighbourhoods (one in 2^128) would be detected when the original entries are mapped
        // to the fronts.
        let mut hash: Vec<[u64; 2]> = (0..n as u64).map(|j| [mix(j), mix(!j)]).collect();
        for j in 0..n {
            for i in column(j).iter().map(|&i| i as usize).filter(|&i| i != j) {
                for (of, other) in [(i, j as u64), (j, i as u64)] {
                    hash[of][0] = hash[of][0].wrapping_add(mix(other));
                    hash[of][1] = hash[of][1].wrapping_add(mix(!other));
                }
            }
        }
        let mut known = HashMap::with_capacity(n / 3);
        let mut supervariables: Vec<Vec<u32>> = Vec::new();
        let mut group = Vec::with_capacity(n);
        for (j, h) in hash.into_iter().enumerate() {
            let g = *known.entry(h).or_insert(supervariables.len() as u32);
            if g as usize == supervariables.len() {
                supervariables.push(Vec::new());
            }
            supervariables[g as usize].push(j as u32);
            group.push(g);
        }
        let mut neighbours = vec![Vec::new(); supervariables.len()];
        for (g, of) in supervariables.iter().enumerate() {
            for i in column(of[0] as usize).iter().map(|&i| i as usize) {
                let other = group[i] as usize;
                if other != g && supervariables[other][0] as usize == i {
                    neighbours[g].push(other as u32);
                    neighbours[other].push(g as u32);
                }
            }
        }
        Self { supervariables, neighbours }
    }

    /// Number of supervariables.
    pub fn len(&self) -> usize {
        self.supervariables.len()
    }

    /// Elimination order of the supervariables with little fill, by approximate minimum degree (AMD).
    pub fn minimum_degree(&self) -> Result<Vec<u32>, FactorError> {
        let n = self.len();
        let mut pointers = vec![0_usize];
        let mut rows = Vec::new();
        for (j, neighbours) in self.neighbours.iter().enumerate() {
            let mut above: Vec<usize> = neighbours.iter().map(|&i| i as usize).filter(|&i| i < j).collect();
            above.sort_unstable();
            rows.extend(above);
            rows.push(j);
            pointers.push(rows.len());
        }
        let entries = rows.len();
        let upper = SymbolicSparseColMat::new_checked(n, n, pointers, None, rows);
        let (mut forward, mut inverse) = (vec![0; n], vec![0; n]);
        let mut memory =
            MemBuffer::try_new(amd::order_scratch::<usize>(n, entries)).map_err(|_| FactorError::TooLarge)?;
        amd::order(
            &mut forward,
            &mut inverse,
            upper.as_ref(),
            Default::default(),
            MemStack::new(&mut memory),
        )
        .map_err(|_| FactorError::TooLarge)?;
        Ok(forward.into_iter().map(|g| g as u32).collect())
    }
}
