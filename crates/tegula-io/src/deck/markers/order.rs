//! Order of things that depend on each other.

/// Numbers of all things that depend on no circle, each behind those it needs, and the circles, each in the order of need.
/// `needs[i]` are the numbers of the things that thing `i` needs. (A. B. Kahn, *Topological sorting of large networks*, 1962.)
pub(super) fn sorted(needs: &[Vec<usize>]) -> (Vec<usize>, Vec<Vec<usize>>) {
    let mut needed_by: Vec<Vec<usize>> = vec![Vec::new(); needs.len()];
    let mut missing: Vec<usize> = needs.iter().map(Vec::len).collect();
    for (i, list) in needs.iter().enumerate() {
        list.iter().for_each(|&need| needed_by[need].push(i));
    }
    let mut order: Vec<usize> = (0..needs.len()).filter(|&i| missing[i] == 0).collect();
    let mut done = 0;
    while let Some(&ready) = order.get(done) {
        done += 1;
        for &i in &needed_by[ready] {
            missing[i] -= 1;
            if missing[i] == 0 {
                order.push(i);
            }
        }
    }
    // Each thing left over needs another one: following these leads into a circle.
    let mut seen = vec![false; needs.len()];
    let mut circles = Vec::new();
    for start in (0..needs.len()).filter(|&i| missing[i] > 0) {
        let (mut path, mut next) = (Vec::new(), Some(start));
        while let Some(i) = next.filter(|&i| !seen[i]) {
            seen[i] = true;
            path.push(i);
            next = needs[i].iter().copied().find(|&need| missing[need] > 0);
        }
        let closed = next.and_then(|end| path.iter().position(|&i| i == end));
        circles.extend(closed.map(|first| path.split_off(first)));
    }
    (order, circles)
}

#[cfg(test)]
mod tests {
    #[test]
    fn things_stand_behind_what_they_need() {
        assert_eq!(super::sorted(&[vec![2], vec![0, 2], vec![]]), (vec![2, 0, 1], vec![]));
        assert_eq!(super::sorted(&[]), (vec![], vec![]));
    }

    #[test]
    fn each_circle_is_found_once() {
        // 0 leads into 1 → 2 → 1; 3 needs itself; 4 needs nothing.
        let (order, circles) = super::sorted(&[vec![1], vec![2], vec![1, 4], vec![3], vec![]]);
        assert_eq!((order, circles), (vec![4], vec![vec![1, 2], vec![3]]));
    }
}
