//! Elements of one shape share their stiffness.
//!
//! Regular meshes are made of few shapes. `H`, the masses and the stress of prescribed strains of an element depend on
//! its shape and on the directions that its section and its prescribed strains refer to, not on how it lies in space:
//! once per shape is enough, for the time of set-up, for memory, and for the traffic between memory and processor.

use std::collections::HashMap;

use crate::element::ShellGeometry;
use crate::element::geometry::cross_section_frame;
use crate::{Mat3, Vec3};

/// Rounding of coordinates within which shapes count as one.
const ROUNDING: f64 = 32.0 * f64::EPSILON;
/// Shapes are looked up by their numbers in these units of the element's size.
const CELL: f64 = 1e-9;

/// Shape of an element, in its own frame.
struct Shape {
    numbers: Vec<f64>,
    /// Largest difference that counts as rounding.
    tolerance: f64,
}

impl Shape {
    /// `directions` refer to space; none where an element has no frame, or its coordinates are too coarse to tell.
    fn new(g: &ShellGeometry, directions: &[Vec3]) -> Option<Self> {
        let frame: Mat3 = cross_section_frame(&g.base(0.0, 0.0, 0.0))?;
        let centre = g.centre();
        let size = g.positions.iter().map(|x| (x - centre).norm()).fold(0.0, crate::norm::larger);
        let far = g.positions.iter().map(|x| x.amax()).fold(0.0, crate::norm::larger);
        let tolerance = ROUNDING * (1.0 + far / size);
        if tolerance.is_nan() || tolerance > 0.1 * CELL {
            return None;
        }
        let positions = g.positions.iter().map(|x| (x - centre) / size);
        let vectors = positions.chain(g.directors.iter().copied()).chain(directions.iter().copied());
        let mut numbers = vec![size];
        numbers.extend(vectors.flat_map(|v| <[f64; 3]>::from(frame.tr_mul(&v))));
        Some(Self { numbers, tolerance })
    }

    fn key(&self, acting: &[f64]) -> Key {
        // The size by its logarithm: the same relative accuracy.
        let numbers = self.numbers.iter().enumerate();
        let cells = numbers.map(|(i, x)| (if i == 0 { x.ln() } else { *x } / CELL).round() as i64);
        (cells.collect(), acting.iter().map(|factor| factor.to_bits()).collect())
    }

    fn is(&self, other: &Self) -> bool {
        let tolerance = self.tolerance.max(other.tolerance);
        let mut pairs = self.numbers.iter().zip(&other.numbers);
        let size = pairs.next().is_some_and(|(a, b)| (a - b).abs() <= tolerance * a.abs());
        size && pairs.all(|(a, b)| (a - b).abs() <= tolerance * a.abs().max(1.0))
    }
}

/// Shapes so far among the elements of a section.
#[derive(Default)]
pub(super) struct Congruence {
    known: HashMap<Key, (usize, Shape)>,
}

/// Shape in cells, and bits of the factors of the fields.
type Key = (Vec<i64>, Vec<u64>);

/// A shape without a congruent earlier element.
pub(super) struct NewShape(Key, Shape);

/// Congruence of an element with earlier ones.
pub(super) enum Match {
    /// Congruent with the earlier element of this number.
    Like(usize),
    /// No earlier element is congruent.
    New(NewShape),
    /// Congruence cannot be decided, or the shape is nearly that of another element but not quite.
    Alone,
}

impl Congruence {
    /// Looks for an earlier element with the shape of this one and the same `directions` relative to it, under the same
    /// fields of prescribed strain, whose factors are `acting`.
    pub fn look_up(&self, g: &ShellGeometry, directions: &[Vec3], acting: &[f64]) -> Match {
        let Some(shape) = Shape::new(g, directions) else { return Match::Alone };
        let key = shape.key(acting);
        match self.known.get(&key) {
            Some((first, known)) if known.is(&shape) => Match::Like(*first),
            Some(_) => Match::Alone,
            None => Match::New(NewShape(key, shape)),
        }
    }

    /// Records that element number `member` has a new shape. Only elements that were accepted have numbers.
    pub fn register(&mut self, NewShape(key, shape): NewShape, member: usize) {
        self.known.insert(key, (member, shape));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element(origin: Vec3, turn: f64, stretch: f64) -> ShellGeometry {
        let q = *nalgebra::Rotation3::new(Vec3::new(0.3, -0.2, 1.0).normalize() * turn).matrix();
        let square = [[0.0, 0.0], [1.0, 0.1], [1.1, stretch], [0.0, 1.0]];
        let positions = square.map(|[x, y]| origin + q * Vec3::new(x, y, 0.1 * x * y));
        ShellGeometry::new(positions, [0.0, 0.1, 0.2, 0.3].map(|x| q * Vec3::new(x, 0.1, 1.0).normalize()))
    }

    /// The first like this one, which is registered under its number where it is new.
    fn first_like(
        shapes: &mut Congruence,
        g: &ShellGeometry,
        (directions, acting): (&[Vec3], &[f64]),
        member: usize,
    ) -> Option<usize> {
        match shapes.look_up(g, directions, acting) {
            Match::Like(first) => return Some(first),
            Match::New(shape) => shapes.register(shape, member),
            Match::Alone => {}
        }
        None
    }

    #[test]
    fn moved_elements_are_congruent_and_others_are_not() {
        let mut shapes = Congruence::default();
        let origin = Vec3::new(3.0, -1.0, 2.0);
        assert_eq!(first_like(&mut shapes, &element(Vec3::zeros(), 0.0, 1.0), (&[], &[]), 0), None);
        for k in 1..20 {
            let g = element(origin * f64::from(k), 0.3 * f64::from(k), 1.0);
            assert_eq!(first_like(&mut shapes, &g, (&[], &[]), k as usize), Some(0), "{k}");
        }
        assert_eq!(first_like(&mut shapes, &element(origin, 0.4, 1.0 + 1e-7), (&[], &[]), 20), None);
        assert_eq!(first_like(&mut shapes, &element(origin, 0.4, 1.0), (&[], &[1.0]), 21), None);
    }

    #[test]
    fn directions_in_space_count() {
        let mut shapes = Congruence::default();
        let first = |shapes: &mut Congruence, turn: f64, n| {
            first_like(shapes, &element(Vec3::zeros(), turn, 1.0), (&[Vec3::x()], &[]), n)
        };
        assert_eq!(first(&mut shapes, 0.0, 0), None);
        assert_eq!(first(&mut shapes, 0.5, 1), None);
        assert_eq!(first(&mut shapes, 0.5, 2), Some(1));
    }

    #[test]
    fn what_was_not_accepted_is_not_found() {
        let shapes = Congruence::default();
        for _ in 0..3 {
            let found = shapes.look_up(&element(Vec3::zeros(), 0.0, 1.0), &[], &[]);
            assert!(matches!(found, Match::New(_)));
        }
    }
}
