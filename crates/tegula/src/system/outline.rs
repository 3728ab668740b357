//! Outline of bodies, beams and springs, for pictures: points that move with the nodal vectors, joined to quadrilaterals and lines.

use crate::Vec3;
use crate::constraint::Attachment;
use crate::element::Nodal;

/// Corners of the polygon that stands for a circle; even.
const CORNERS: usize = 24;
/// Rings of a ball, apart from its poles.
const RINGS: usize = 11;

/// Outline of the bodies, beams and springs of a model.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Outline {
    /// Points, as linear combinations of nodal vectors.
    pub points: Vec<Attachment>,
    /// Faces: corners as indices of points. A triangle has its last corner twice.
    pub quads: Vec<[u32; 4]>,
    /// Lines: ends as indices of points.
    pub lines: Vec<[u32; 2]>,
    /// Part and element within it that each face belongs to; bodies and springs have the element 0.
    pub owner_of_quad: Vec<[u32; 2]>,
    /// Part and element within it that each line belongs to.
    pub owner_of_line: Vec<[u32; 2]>,
    /// Names of the parts.
    pub parts: Vec<String>,
}

impl Outline {
    /// Whether there is nothing to draw.
    pub fn is_empty(&self) -> bool {
        self.quads.is_empty() && self.lines.is_empty()
    }

    /// Positions of the points at displacements `u` times `scale` from the reference values of the nodal vectors.
    pub fn positions(&self, reference: &[Nodal], u: &[Nodal], scale: f64) -> Vec<Nodal> {
        let value = |v: u32| {
            let displacement = u.get(v as usize).map_or_else(Vec3::zeros, |u| Vec3::from(*u));
            Vec3::from(reference[v as usize]) + displacement * scale
        };
        self.points.iter().map(|point| (point.constant + moved(point, value)).into()).collect()
    }

    /// Displacements (velocities) of the points for those of the nodal vectors; zero where there are none.
    pub fn displacements(&self, of_vectors: &[Nodal]) -> Vec<Nodal> {
        let value = |v: u32| of_vectors.get(v as usize).map_or_else(Vec3::zeros, |u| Vec3::from(*u));
        self.points.iter().map(|point| moved(point, value).into()).collect()
    }

    /// Adds a part; returns its number.
    pub fn add_part(&mut self, name: &str) -> u32 {
        self.parts.push(name.to_owned());
        (self.parts.len() - 1) as u32
    }

    /// Adds a line.
    pub fn line(&mut self, ends: [Attachment; 2], owner: [u32; 2]) {
        let [a, b] = ends.map(|end| self.point(end));
        self.lines.push([a, b]);
        self.owner_of_line.push(owner);
    }

    /// Adds a surface of triangles.
    pub fn surface(
        &mut self,
        points: impl Iterator<Item = Attachment>,
        triangles: &[[u32; 3]],
        owner: [u32; 2],
    ) {
        let first = self.points.len() as u32;
        self.points.extend(points);
        triangles
            .iter()
            .for_each(|t| self.face([t[0], t[1], t[2], t[2]].map(|corner| first + corner), owner));
    }

    /// Adds a ring of points.
    fn ring(&mut self, points: impl IntoIterator<Item = Attachment>) -> Vec<u32> {
        points.into_iter().map(|point| self.point(point)).collect()
    }

    /// Joins two rings of as many points by faces.
    fn join(&mut self, first: &[u32], second: &[u32], owner: [u32; 2]) {
        let n = first.len();
        for i in 0..n {
            let next = (i + 1) % n;
            self.face([first[i], first[next], second[next], second[i]], owner);
        }
    }

    /// Closes a convex ring with an even number of points.
    fn close(&mut self, ring: &[u32], owner: [u32; 2]) {
        for i in (1..ring.len().saturating_sub(2)).step_by(2) {
            self.face([ring[0], ring[i], ring[i + 1], ring[i + 2]], owner);
        }
    }

    /// Adds rings joined one after another, with the first and the last one closed.
    pub fn solid(&mut self, rings: &[Vec<Attachment>], owner: [u32; 2]) {
        let rings: Vec<Vec<u32>> = rings.iter().map(|ring| self.ring(ring.iter().cloned())).collect();
        rings.windows(2).for_each(|pair| self.join(&pair[0], &pair[1], owner));
        rings.first().into_iter().chain(rings.last()).for_each(|ring| self.close(ring, owner));
    }

    /// Adds a tube between rings of its outer and its inner surface; a solid where it has no inner surface.
    pub fn tube(&mut self, outer: &[Vec<Attachment>], inner: &[Vec<Attachment>], owner: [u32; 2]) {
        if inner.is_empty() {
            return self.solid(outer, owner);
        }
        let [outer, inner] = [outer, inner].map(|rings| {
            let rings = rings.iter().map(|ring| self.ring(ring.iter().cloned()));
            rings.collect::<Vec<Vec<u32>>>()
        });
        for rings in [&outer, &inner] {
            rings.windows(2).for_each(|pair| self.join(&pair[0], &pair[1], owner));
        }
        for (outer, inner) in
            outer.first().zip(inner.first()).into_iter().chain(outer.last().zip(inner.last()))
        {
            self.join(outer, inner, owner);
        }
    }

    fn point(&mut self, point: Attachment) -> u32 {
        self.points.push(point);
        (self.points.len() - 1) as u32
    }

    fn face(&mut self, corners: [u32; 4], owner: [u32; 2]) {
        self.quads.push(corners);
        self.owner_of_quad.push(owner);
    }
}

fn moved(point: &Attachment, value: impl Fn(u32) -> Vec3) -> Vec3 {
    point.terms.iter().map(|&(v, weight)| value(v) * weight).sum()
}

/// Corners of the polygon that stands for a circle about the origin of a plane.
pub fn circle(radius: f64) -> impl Iterator<Item = [f64; 2]> {
    let corner = move |i: usize| {
        let angle = std::f64::consts::TAU * i as f64 / CORNERS as f64;
        [radius * angle.cos(), radius * angle.sin()]
    };
    (0..CORNERS).map(corner)
}

/// Places along the axis and radii of the rings of a ball.
pub fn ball(radius: f64) -> impl Iterator<Item = [f64; 2]> {
    let ring = move |i: usize| {
        let angle = std::f64::consts::PI * i as f64 / (RINGS + 1) as f64;
        [-radius * angle.cos(), radius * angle.sin()]
    };
    (1..=RINGS).map(ring)
}
