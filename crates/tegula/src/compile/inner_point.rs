//! Points inside shell elements, to which joints and force elements connect.
//!
//! A point of an element moves as `x = Σ N_a (r_a + z d_a)` with the shape functions N at its place and its height z over the mid-surface:
//! linear in the nodal vectors, as all points of bodies are.

use super::sections::Elements;
use crate::constraint::joints::End;
use crate::constraint::{Attachment, FollowedPoint, MaterialLine, StrainGauge};
use crate::mesh::{Mesh, show};
use crate::{Mat3, Vec3};

/// Distance from the surface over the size of the model that is round-off.
const ROUND_OFF: f64 = 1e-9;
/// Part of an element by which a point may lie outside of it.
const BESIDE: f64 = 1e-9;
/// Iterations for the place in an element; four are enough in one that is nearly flat.
const ITERATIONS: usize = 12;

/// Part of a direction in the surface below which it counts as that of the director.
const ALONG_DIRECTOR: f64 = 1e-6;

/// Place in an element.
struct Found {
    /// Positions and directors of the corners.
    vectors: [u32; 8],
    /// Their values at the reference.
    corners: [Vec3; 8],
    /// ξ and η from 0 to 1, and the height in units of the directors.
    place: [f64; 3],
}

impl Found {
    /// Vectors along ξ and η at a place, at the height of the point, and the director there.
    fn base(&self, [xi, eta]: [f64; 2]) -> [Vec3; 3] {
        let height = self.place[2];
        let sum = |weights: [f64; 4]| -> Vec3 {
            (0..4).map(|a| (self.corners[a] + self.corners[4 + a] * height) * weights[a]).sum()
        };
        let director = (0..4).map(|a| self.corners[4 + a] * shapes(xi, eta)[a]).sum();
        [sum(along_xi(eta)), sum(along_eta(xi)), director]
    }

    /// Material line of length 1 at a place along a direction that is projected along the director; `None` where that leaves nothing.
    fn line(&self, [xi, eta]: [f64; 2], direction: &Vec3) -> Option<MaterialLine> {
        let [first, second, director] = self.base([xi, eta]);
        let c = Mat3::from_columns(&[first, second, director]).try_inverse()? * direction;
        let length = (first * c.x + second * c.y).norm();
        let c = if length > ALONG_DIRECTOR { c / length } else { return None };
        let along: [f64; 4] = std::array::from_fn(|a| c.x * along_xi(eta)[a] + c.y * along_eta(xi)[a]);
        let weights = along.into_iter().chain(along.map(|weight| self.place[2] * weight));
        let terms = self.vectors.into_iter().zip(weights).filter(|(_, weight)| *weight != 0.0).collect();
        let vector = Attachment { terms, constant: Vec3::zeros() };
        Some(MaterialLine { vector, reference: first * c.x + second * c.y })
    }

    /// Strain gauge along a direction, on axes that are those of the element in its middle: normal to each other, as near to ξ and η as that is possible.
    fn gauge(&self, direction: &Vec3) -> Option<StrainGauge> {
        let [xi, eta, _] = self.place;
        let [first, second, _] = self.base([0.5; 2]);
        let axes = orthonormal([first, second]);
        let [a, b] = [self.line([xi, eta], &axes[0])?, self.line([xi, eta], &axes[1])?];
        let at_place = orthonormal([a.reference, b.reference]);
        let wanted = self.line([xi, eta], direction)?.reference;
        Some(StrainGauge {
            lines: [self.line([xi, eta], &at_place[0])?, self.line([xi, eta], &at_place[1])?],
            middle: [self.line([0.5; 2], &axes[0])?, self.line([0.5; 2], &axes[1])?],
            direction: at_place.map(|axis| axis.dot(&wanted)),
        })
    }
}

/// Unit vectors at a right angle in the plane of two vectors, with the same bisector.
fn orthonormal(vectors: [Vec3; 2]) -> [Vec3; 2] {
    let [a, b] = vectors.map(|vector| vector.normalize());
    let (sum, difference) = ((a + b).normalize(), (a - b).normalize());
    [sum + difference, sum - difference].map(|axis| axis.normalize())
}

/// Nodal vectors and thickness of the shells of a model, quad by quad.
#[derive(Default)]
pub(super) struct Corners {
    /// Positions and directors of the corners; `None` where the element has other nodal vectors, or none.
    vectors: Vec<Option<[u32; 8]>>,
    /// Heights of the lower and the upper face over the mesh (length).
    faces: Vec<[f64; 2]>,
}

impl Corners {
    /// Corners of all elements.
    pub(super) fn new(mesh: &Mesh, elements: &Elements) -> Self {
        let mut out = Self { vectors: vec![None; mesh.quads.len()], faces: vec![[0.0; 2]; mesh.quads.len()] };
        for shell in &elements.list {
            let vectors = elements.groups[shell.groups.start].vectors(shell.member);
            out.vectors[shell.quad as usize] = vectors.try_into().ok();
            let section = &elements.sections[shell.section].section;
            out.faces[shell.quad as usize] =
                [-0.5, 0.5].map(|side| section.offset + side * section.thickness);
        }
        out
    }

    /// Point of one of the quads, at a place of the reference configuration, as the end of a joint.
    ///
    /// # Errors
    /// No quad contains the point: a message and what to do.
    pub(super) fn end(
        &self,
        quads: &[u32],
        at: &Vec3,
        model: (impl Fn(u32) -> Vec3, f64),
    ) -> Result<End, (String, String)> {
        self.point(quads, at, model).map(|followed| End::Interior { terms: followed.point.terms })
    }

    /// Point of one of the quads, at a place of the reference configuration, with the material vectors there.
    ///
    /// # Errors
    /// No quad contains the point: a message and what to do.
    pub(super) fn point(
        &self,
        quads: &[u32],
        at: &Vec3,
        model: (impl Fn(u32) -> Vec3, f64),
    ) -> Result<FollowedPoint, (String, String)> {
        self.find(quads, at, model).map(|found| followed(&found.vectors, &found.corners, found.place))
    }

    /// Strain gauges at a point, one in each of the quads that contain it, along a direction that is projected along the director onto the surface.
    /// Quads that the direction crosses are left out where there are others.
    ///
    /// # Errors
    /// No quad contains the point, or the direction is across the surface: a message and what to do.
    pub(super) fn gauges(
        &self,
        quads: &[u32],
        at: &Vec3,
        direction: &Vec3,
        (reference, length): (impl Fn(u32) -> Vec3, f64),
    ) -> Result<Vec<StrainGauge>, (String, String)> {
        // The message of the search tells what is wrong where no quad contains the point.
        self.find(quads, at, (&reference, length))?;
        let found = quads.iter().filter_map(|quad| self.find(&[*quad], at, (&reference, length)).ok());
        let gauges: Vec<StrainGauge> =
            found.filter_map(|found| found.gauge(&direction.normalize())).collect();
        if gauges.is_empty() {
            return Err((
                format!("the direction is along the director at the point {}", show(*at)),
                "give a direction in the surface".into(),
            ));
        }
        Ok(gauges)
    }

    /// Element that contains a place of the reference configuration.
    ///
    /// # Errors
    /// No quad contains the point: a message and what to do.
    fn find(
        &self,
        quads: &[u32],
        at: &Vec3,
        (reference, length): (impl Fn(u32) -> Vec3, f64),
    ) -> Result<Found, (String, String)> {
        let mut nearest: Option<(f64, Found, Vec3)> = None;
        let mut known = false;
        for &quad in quads {
            let Some(vectors) = self.vectors[quad as usize] else { continue };
            known = true;
            let corners = vectors.map(&reference);
            let Some([xi, eta, height]) = place(&corners, at) else { continue };
            let foot = (0..4).map(|a| corners[a] * shapes(xi, eta)[a]).sum::<Vec3>();
            let [lower, upper] = self.faces[quad as usize];
            let over_mesh = height * corners[4].norm();
            let outside = (over_mesh - upper).max(lower - over_mesh);
            let beside = (outside - 0.5 * BESIDE * (upper - lower) - ROUND_OFF * length).max(0.0);
            if nearest.as_ref().is_none_or(|(least, ..)| beside < *least) {
                let height = if height.abs() > ROUND_OFF * length { height } else { 0.0 };
                nearest = Some((beside, Found { vectors, corners, place: [xi, eta, height] }, foot));
            }
        }
        match nearest {
            Some((beside, found, _)) if beside <= 0.0 => Ok(found),
            Some((beside, _, foot)) => Err((
                format!(
                    "the point lies {beside:.3e} above or below the shell, whose nearest point is {}",
                    show(foot)
                ),
                "give a point in the shell, or connect a body whose `attached` set is on the shell".into(),
            )),
            None if known => Err((
                format!("the point {} lies beside all elements of the set", show(*at)),
                "give a point in the shell".into(),
            )),
            None => Err((
                "the elements of the set have gradients, or none exist there".into(),
                "connect a node, or take another type of element".into(),
            )),
        }
    }
}

/// Point of an element at a place and height, with its material vectors.
fn followed(vectors: &[u32; 8], corners: &[Vec3; 8], [xi, eta, height]: [f64; 3]) -> FollowedPoint {
    let combined = |weights: [f64; 8]| -> (Attachment, Vec3) {
        let terms = vectors.iter().copied().zip(weights).filter(|(_, weight)| *weight != 0.0).collect();
        let value = corners.iter().zip(weights).map(|(x, weight)| x * weight).sum();
        (Attachment { terms, constant: Vec3::zeros() }, value)
    };
    let of = |positions: [f64; 4], directors: [f64; 4]| {
        combined(std::array::from_fn(|k| if k < 4 { positions[k] } else { directors[k - 4] }))
    };
    let n = shapes(xi, eta);
    let (point, _) = of(n, n.map(|n| height * n));
    let base = [of(along_xi(eta), [0.0; 4]), of(along_eta(xi), [0.0; 4]), of([0.0; 4], n)];
    FollowedPoint { point, base }
}

/// Bilinear shape functions, of ξ and η from 0 to 1.
fn shapes(xi: f64, eta: f64) -> [f64; 4] {
    [(1.0 - xi) * (1.0 - eta), xi * (1.0 - eta), xi * eta, (1.0 - xi) * eta]
}

/// Derivatives of the shape functions by ξ.
fn along_xi(eta: f64) -> [f64; 4] {
    [eta - 1.0, 1.0 - eta, eta, -eta]
}

/// Derivatives of the shape functions by η.
fn along_eta(xi: f64) -> [f64; 4] {
    [xi - 1.0, -xi, xi, 1.0 - xi]
}

/// Place ξ, η in an element and height z in units of its directors with `Σ N_a (r_a + z d_a) = x`, by Newton's method; `None` where the
/// place is beside the element.
fn place(corners: &[Vec3; 8], x: &Vec3) -> Option<[f64; 3]> {
    let mut at = Vec3::new(0.5, 0.5, 0.0);
    for _ in 0..ITERATIONS {
        let [xi, eta, z] = [at.x, at.y, at.z];
        let sum =
            |weights: [f64; 4]| (0..4).map(|a| (corners[a] + corners[4 + a] * z) * weights[a]).sum::<Vec3>();
        let director = (0..4).map(|a| corners[4 + a] * shapes(xi, eta)[a]).sum::<Vec3>();
        let columns = [sum([eta - 1.0, 1.0 - eta, eta, -eta]), sum([xi - 1.0, -xi, xi, 1.0 - xi]), director];
        at += Mat3::from_columns(&columns).try_inverse()? * (x - sum(shapes(xi, eta)));
        // A start far beside the element must not run away.
        at.x = at.x.clamp(-2.0, 3.0);
        at.y = at.y.clamp(-2.0, 3.0);
    }
    let inside = [at.x, at.y].iter().all(|t| (-BESIDE..=1.0 + BESIDE).contains(t));
    inside.then_some([at.x, at.y, at.z])
}
