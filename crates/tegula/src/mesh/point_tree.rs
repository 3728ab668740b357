//! k-d tree of points: finds those within a box in logarithmic time, however finely parts of a mesh are graded.
//!
//! J. L. Bentley, *Multidimensional binary search trees used for associative searching*, Comm. ACM 18 (1975) 509–517.

use crate::Vec3;

/// Points of a leaf.
const LEAF: usize = 8;

/// Points with numbers.
pub(super) struct PointTree {
    /// The points; each range of the tree has its median in the middle.
    points: Vec<(u32, Vec3)>,
    /// Coordinate by which the range with its median here is divided.
    axes: Vec<u8>,
}

impl PointTree {
    /// Sorts points into a tree.
    pub fn of(points: Vec<(u32, Vec3)>) -> Self {
        let mut tree = Self { axes: vec![0; points.len()], points };
        let mut ranges = vec![(0, tree.points.len())];
        while let Some((first, end)) = ranges.pop() {
            if end - first <= LEAF {
                continue;
            }
            let range = &mut tree.points[first..end];
            let (low, high) =
                range.iter().fold((range[0].1, range[0].1), |(low, high), (_, x)| (low.inf(x), high.sup(x)));
            let axis = (high - low).imax();
            let middle = range.len() / 2;
            // The number decides between equal coordinates, so that the tree is the same in every run.
            range.select_nth_unstable_by(middle, |a, b| a.1[axis].total_cmp(&b.1[axis]).then(a.0.cmp(&b.0)));
            tree.axes[first + middle] = axis as u8;
            ranges.extend([(first, first + middle), (first + middle + 1, end)]);
        }
        tree
    }

    /// Hands the points of the box from `low` to `high`, its faces included, to `take`.
    pub fn within(&self, low: &Vec3, high: &Vec3, mut take: impl FnMut(u32, &Vec3)) {
        let mut take_inside = |(number, x): &(u32, Vec3)| {
            if (0..3).all(|i| low[i] <= x[i] && x[i] <= high[i]) {
                take(*number, x);
            }
        };
        // A tree of 2³² points is 32 levels deep, and each level leaves one range behind.
        let mut ranges = [(0, 0); 64];
        ranges[0] = (0, self.points.len());
        let mut left = 1;
        while left > 0 {
            left -= 1;
            let (first, end) = ranges[left];
            if end - first <= LEAF {
                self.points[first..end].iter().for_each(&mut take_inside);
                continue;
            }
            let middle = first + (end - first) / 2;
            let axis = usize::from(self.axes[middle]);
            let at = self.points[middle].1[axis];
            take_inside(&self.points[middle]);
            for (range, wanted) in [((first, middle), low[axis] <= at), ((middle + 1, end), at <= high[axis])]
            {
                if wanted {
                    ranges[left] = range;
                    left += 1;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn points_of_a_box_are_those_found_one_by_one(
            coordinates in prop::collection::vec(prop::array::uniform3(0..6_i32), 0..200),
            (low, size) in (prop::array::uniform3(0..6_i32), prop::array::uniform3(0..4_i32)),
        ) {
            let point = |x: &[i32; 3]| Vec3::from(x.map(f64::from));
            let points: Vec<_> = (0u32..).zip(coordinates.iter().map(point)).collect();
            let (low, high) = (point(&low), point(&low) + point(&size));
            let inside = |x: &Vec3| (0..3).all(|i| low[i] <= x[i] && x[i] <= high[i]);
            let expected: Vec<u32> = points.iter().filter(|(_, x)| inside(x)).map(|(n, _)| *n).collect();
            let mut found = Vec::new();
            PointTree::of(points).within(&low, &high, |n, _| found.push(n));
            found.sort_unstable();
            prop_assert_eq!(found, expected);
        }
    }
}
