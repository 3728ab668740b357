//! Local to global numbers of nodal vectors.
//!
//! Elements see local numbers only. A process owns the first `owned` of its nodal vectors;
//! the rest are ghosts, copies of vectors that another process owns. One process alone owns all.

/// Maps local numbers of nodal vectors to global ones.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IndexMap {
    first: u64,
    owned: usize,
    ghosts: Vec<u64>,
}

impl IndexMap {
    /// All `n` vectors owned by this process.
    pub fn serial(n: usize) -> Self {
        Self { first: 0, owned: n, ghosts: Vec::new() }
    }

    /// `owned` vectors from the global number `first` on, followed by ghosts.
    pub fn new(first: u64, owned: usize, ghosts: Vec<u64>) -> Self {
        Self { first, owned, ghosts }
    }

    /// Number of owned vectors.
    pub fn owned(&self) -> usize {
        self.owned
    }

    /// Number of local vectors, ghosts included.
    pub fn len(&self) -> usize {
        self.owned + self.ghosts.len()
    }

    /// True if there are no vectors.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Global number of a local vector.
    pub fn global(&self, local: usize) -> Option<u64> {
        if local < self.owned {
            Some(self.first + local as u64)
        } else {
            self.ghosts.get(local - self.owned).copied()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ghosts_follow_the_owned_vectors() {
        let map = IndexMap::new(10, 2, vec![3, 40]);
        assert_eq!(
            (0..5).map(|i| map.global(i)).collect::<Vec<_>>(),
            [Some(10), Some(11), Some(3), Some(40), None]
        );
        assert_eq!(IndexMap::serial(3).global(2), Some(2));
    }
}
