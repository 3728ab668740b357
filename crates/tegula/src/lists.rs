//! Compressed lists (as in compressed sparse rows): one list for each of the numbers 0, 1, …, all in two arrays.

/// Lists of values by key, in compressed storage.
#[derive(Debug)]
pub(crate) struct Lists<T> {
    /// First value of each list, and the end of the last one.
    start: Vec<u32>,
    values: Vec<T>,
}

impl<T: Copy + Default> Lists<T> {
    /// Sorts pairs of key and value into `keys` lists. Within a list they keep the order of `pairs`; keys are below
    /// `keys`.
    pub fn by_key(keys: usize, pairs: impl Iterator<Item = (u32, T)> + Clone) -> Self {
        let mut start = vec![0; keys + 1];
        pairs.clone().for_each(|(key, _)| start[key as usize + 1] += 1);
        for key in 0..keys {
            start[key + 1] += start[key];
        }
        let mut next = start.clone();
        let mut values = vec![T::default(); start[keys] as usize];
        for (key, value) in pairs {
            let next = &mut next[key as usize];
            values[*next as usize] = value;
            *next += 1;
        }
        Self { start, values }
    }

    /// List of a key.
    pub fn of(&self, key: usize) -> &[T] {
        &self.values[self.start[key] as usize..self.start[key + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_keep_their_order_within_their_list() {
        let pairs = [(2, 'a'), (0, 'b'), (2, 'c'), (3, 'd'), (0, 'e'), (2, 'a')];
        let lists = Lists::by_key(5, pairs.into_iter());
        let all: Vec<&[char]> = (0..5).map(|key| lists.of(key)).collect();
        assert_eq!(all, [&['b', 'e'][..], &[], &['a', 'c', 'a'], &['d'], &[]]);
        assert_eq!(Lists::<u32>::by_key(0, std::iter::empty()).start, [0]);
    }
}
