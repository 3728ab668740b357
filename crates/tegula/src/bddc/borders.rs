//! The unknowns that pieces share, and sums over the pieces.

use rayon::prelude::*;

use super::Work;
use super::averages::Group;
use super::piece::Piece;
use crate::lists::Lists;

/// Unknowns of the borders: dual ones first, then those of corners.
pub(super) struct Borders {
    /// Free coordinate of each.
    pub unknowns: Vec<u32>,
    /// How many are dual.
    dual: usize,
    /// Pieces that hold each, and its places in their borders.
    sources: Lists<(u32, u32)>,
    /// For each piece, the unknowns of its border.
    pub of_piece: Vec<Vec<u32>>,
}

impl Borders {
    /// The dual unknowns of `groups` come first, group by group.
    pub fn new(pieces: &[Piece], unknowns: usize, groups: &[Group]) -> Self {
        // 1: dual, 2: corner.
        let mut kind = vec![0_u8; unknowns];
        for piece in pieces {
            for (k, &u) in piece.unknowns[piece.inner..].iter().enumerate() {
                kind[u as usize] = if k < piece.dual { 1 } else { 2 };
            }
        }
        let of_kind =
            |wanted: u8| kind.iter().enumerate().filter(move |(_, k)| **k == wanted).map(|(u, _)| u as u32);
        let mut list: Vec<u32> = groups.iter().flat_map(|g| &g.unknowns).copied().collect();
        let mut grouped = vec![false; unknowns];
        list.iter().for_each(|&u| grouped[u as usize] = true);
        list.extend(of_kind(1).filter(|&u| !grouped[u as usize]));
        let dual = list.len();
        list.extend(of_kind(2));
        let mut number = vec![u32::MAX; unknowns];
        for (n, &u) in list.iter().enumerate() {
            number[u as usize] = n as u32;
        }
        let of_piece: Vec<Vec<u32>> = pieces
            .iter()
            .map(|p| p.unknowns[p.inner..].iter().map(|&u| number[u as usize]).collect())
            .collect();
        let places = of_piece
            .iter()
            .enumerate()
            .flat_map(|(p, of)| of.iter().enumerate().map(move |(k, &n)| (n, (p as u32, k as u32))));
        let sources = Lists::by_key(list.len(), places);
        Self { unknowns: list, dual, sources, of_piece }
    }

    /// Unknowns of the borders.
    pub fn len(&self) -> usize {
        self.unknowns.len()
    }

    /// Those that are not at corners.
    pub fn dual(&self) -> usize {
        self.dual
    }

    /// Those at corners.
    pub fn corners(&self) -> usize {
        self.len() - self.dual
    }

    /// How many pieces share an unknown.
    pub fn pieces(&self, unknown: u32) -> usize {
        self.sources(unknown as usize).len()
    }

    /// Pieces that hold an unknown, and its places in their borders.
    pub fn sources(&self, unknown: usize) -> &[(u32, u32)] {
        self.sources.of(unknown)
    }

    /// Adds what the pieces hold in `y` for the unknowns from `first` on.
    pub fn add(&self, works: &[Work], first: usize, out: &mut [f64]) {
        out.par_iter_mut().with_min_len(4096).enumerate().for_each(|(n, out)| {
            for &(piece, at) in self.sources(first + n) {
                *out += works[piece as usize].y[at as usize];
            }
        });
    }

    /// Finds the shares of the pieces in the dual unknowns, by the diagonals of their matrices. They add up to one.
    pub fn weigh(&self, pieces: &[Piece], works: &mut [Work]) {
        for work in works.iter_mut() {
            let Some(factored) = &work.factored else { continue };
            work.y.iter_mut().zip(factored.interface.diagonal()).for_each(|(y, d)| *y = d);
        }
        let mut sums = vec![0.0; self.dual];
        self.add(works, 0, &mut sums);
        for ((work, piece), of) in works.iter_mut().zip(pieces).zip(&self.of_piece) {
            let shares = work.y.iter().zip(of).take(piece.dual);
            work.weights = shares.map(|(y, &n)| y / sums[n as usize]).collect();
        }
    }
}
