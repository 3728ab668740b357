//! Director-angle constraints at a node: pairs of directors with constant angle, so that they rotate as a rigid cross.
//!
//! Small rotations of n unit directors have 2n components; a rigid cross leaves three of them, two if the directors
//! lie in one plane, where angles determine only the rotation about the common edge (the others follow the edge). A
//! constraint between two directors gives one condition. Pairs are taken in turn, those of sheets with a common edge
//! first and among them the ones nearest to a right angle, as long as their conditions are independent: of n directors
//! about a straight edge n − 1 pairs, of n directors in general position 2n − 3. A T of three sheets, whose flange may
//! have its directors on opposite sides, is therefore constrained by its two right angles and not by the antiparallel
//! pair.

use crate::Vec3;

/// Directors nearer to parallel than this (degrees) cannot be tied by their angle.
pub(super) const UNTIED_DEGREES: f64 = 1.0;

/// Norm of a condition after Gram–Schmidt orthogonalisation against the ones before it, above which it counts as
/// independent.
const INDEPENDENT: f64 = 0.1;

/// Pairs of the unit vectors `directors` to be tied, ascending, each with the length of the edges that its sheets have in
/// common, which `length` gives.
pub(super) fn ties(directors: &[Vec3], length: impl Fn(usize, usize) -> f64) -> Vec<([usize; 2], f64)> {
    let n = directors.len();
    let mut pairs: Vec<([usize; 2], f64, f64)> = (0..n)
        .flat_map(|j| (0..j).map(move |i| [i, j]))
        .map(|[i, j]| ([i, j], length(i, j), directors[i].cross(&directors[j]).norm()))
        .filter(|&(_, _, sine)| sine >= UNTIED_DEGREES.to_radians().sin())
        .collect();
    pairs.sort_by(|a, b| (b.1 > 0.0).cmp(&(a.1 > 0.0)).then(b.2.total_cmp(&a.2)));
    let mut basis: Vec<Vec<Vec3>> = Vec::new();
    let mut out = Vec::new();
    for ([i, j], length, sine) in pairs {
        // Change of the angle with the directors: unit vectors across them, each towards the other.
        let (a, b) = (directors[i], directors[j]);
        let cosine = a.dot(&b);
        let mut row = vec![Vec3::zeros(); n];
        (row[i], row[j]) = ((b - a * cosine) / sine, (a - b * cosine) / sine);
        for known in &basis {
            let part: f64 = row.iter().zip(known).map(|(r, k)| r.dot(k)).sum();
            row.iter_mut().zip(known).for_each(|(r, k)| *r -= k * part);
        }
        let rest = row.iter().map(Vec3::norm_squared).sum::<f64>().sqrt();
        if rest > INDEPENDENT {
            row.iter_mut().for_each(|r| *r /= rest);
            basis.push(row);
            out.push(([i, j], length));
        }
    }
    out.sort_by_key(|(pair, _)| *pair);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(directors: &[Vec3], joined: &[[usize; 2]]) -> Vec<[usize; 2]> {
        let length = |i, j| if joined.contains(&[i, j]) { 1.0 } else { 0.0 };
        ties(directors, length).into_iter().map(|(pair, _)| pair).collect()
    }

    fn about_y(degrees: f64) -> Vec3 {
        Vec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos())
    }

    #[test]
    fn directors_about_one_edge_have_one_tie_less_than_their_number() {
        let all = [[0, 1], [0, 2], [1, 2]];
        let y = [0.0, 120.0, 240.0].map(about_y);
        assert_eq!(pairs(&y, &all).len(), 2);
        // A flange with directors on opposite sides and its web.
        assert_eq!(pairs(&[0.0, 180.0, 90.0].map(about_y), &all), [[0, 2], [1, 2]]);
        assert_eq!(pairs(&[0.0, 179.5, 60.0].map(about_y), &all), [[0, 2], [1, 2]]);
        assert_eq!(pairs(&[0.0, 45.0, 90.0, 135.0].map(about_y), &[]).len(), 3);
    }

    #[test]
    fn directors_in_general_position_are_rigid() {
        let corner = [Vec3::x(), Vec3::y(), Vec3::z()];
        assert_eq!(pairs(&corner, &[[0, 1], [0, 2], [1, 2]]), [[0, 1], [0, 2], [1, 2]]);
        let apex: Vec<Vec3> = (0..5)
            .map(|k| {
                let turn = f64::from(k) * 72_f64.to_radians();
                Vec3::new(0.3 * turn.cos(), 0.3 * turn.sin(), 1.0).normalize()
            })
            .collect();
        assert_eq!(pairs(&apex, &[]).len(), 2 * 5 - 3);
        // Sheets with a common edge come first.
        let ring = [[0, 1], [1, 2], [2, 3], [3, 4], [0, 4]];
        let found = pairs(&apex, &ring);
        assert!(found.len() == 7 && ring.iter().all(|pair| found.contains(pair)), "{found:?}");
    }

    #[test]
    fn parallel_directors_are_not_tied() {
        assert!(pairs(&[Vec3::z(), -Vec3::z()], &[[0, 1]]).is_empty());
        assert!(pairs(&[Vec3::z()], &[]).is_empty());
    }
}
