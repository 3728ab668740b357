//! Geometry of one quad as the bilinear surface through its four nodes.

use super::Mesh;
use crate::Vec3;

/// The four corners of a quad.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facet {
    /// Positions of the corners in the order of the quad's nodes (length).
    pub x: [Vec3; 4],
}

impl Facet {
    /// Facet of a quad; `None` if a node index is out of range.
    pub fn of(mesh: &Mesh, quad: &[u32; 4]) -> Option<Self> {
        let mut x = [Vec3::zeros(); 4];
        for (corner, &node) in x.iter_mut().zip(quad) {
            *corner = *mesh.positions.get(node as usize)?;
        }
        Some(Self { x })
    }

    /// Mean of the corners (length).
    pub fn center(&self) -> Vec3 {
        (self.x[0] + self.x[1] + self.x[2] + self.x[3]) * 0.25
    }

    /// Integral of the normal over the facet, ½ d₀₂ × d₁₃ with the diagonals d (length²).
    pub fn area_vector(&self) -> Vec3 {
        (self.x[2] - self.x[0]).cross(&(self.x[3] - self.x[1])) * 0.5
    }

    /// Length of the longer diagonal (length).
    pub fn diagonal(&self) -> f64 {
        (self.x[2] - self.x[0]).norm().max((self.x[3] - self.x[1]).norm())
    }

    /// Length of the side from `corner` to the next (length).
    pub fn side(&self, corner: usize) -> f64 {
        (self.x[(corner + 1) % 4] - self.x[corner]).norm()
    }

    /// r,ξ × r,η at a corner, times 4 (length²); its length is 4 times the Jacobian.
    pub fn corner_normal(&self, corner: usize) -> Vec3 {
        let (next, previous) = self.arms(corner);
        next.cross(&previous)
    }

    /// Angle between the two sides at a corner [rad], 0…π.
    pub fn corner_angle(&self, corner: usize) -> f64 {
        let (next, previous) = self.arms(corner);
        angle_between(&next, &previous)
    }

    /// Distance of a point from the bilinear surface through the corners, where its nearest point lies between them.
    pub fn distance_inside(&self, point: &Vec3) -> Option<f64> {
        let [a, b, c, d] = self.x;
        let (mut xi, mut eta) = (0.5, 0.5);
        let surface = |xi: f64, eta: f64| {
            a * ((1.0 - xi) * (1.0 - eta)) + b * (xi * (1.0 - eta)) + c * (xi * eta) + d * ((1.0 - xi) * eta)
        };
        // Gauss–Newton: two or three steps for the nearly flat, convex facets of a mesh.
        for _ in 0..8 {
            let along_xi = (b - a) * (1.0 - eta) + (c - d) * eta;
            let along_eta = (d - a) * (1.0 - xi) + (c - b) * xi;
            let rest = point - surface(xi, eta);
            let (p, q) = (rest.dot(&along_xi), rest.dot(&along_eta));
            let (xx, xy, yy) = (along_xi.norm_squared(), along_xi.dot(&along_eta), along_eta.norm_squared());
            let determinant = xx * yy - xy * xy;
            (xi, eta) = (xi + (p * yy - q * xy) / determinant, eta + (q * xx - p * xy) / determinant);
        }
        // a little beyond the sides, so that rounding does not lose a point on them
        let inside = [xi, eta].iter().all(|t| (-1e-9..=1.0 + 1e-9).contains(t));
        inside.then(|| (point - surface(xi, eta)).norm())
    }

    /// Vectors from a corner to the next and to the previous corner.
    fn arms(&self, corner: usize) -> (Vec3, Vec3) {
        let here = self.x[corner];
        (self.x[(corner + 1) % 4] - here, self.x[(corner + 3) % 4] - here)
    }
}

/// Angle between two vectors [rad], 0…π; exact for small angles too, where an arc cosine is not.
pub(super) fn angle_between(a: &Vec3, b: &Vec3) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// A position as text with six digits, for messages.
pub(crate) fn show(position: Vec3) -> String {
    let six = |x: f64| format!("{x:.5e}").parse::<f64>().map_or_else(|_| x.to_string(), |x| format!("{x:?}"));
    format!("({}, {}, {})", six(position.x), six(position.y), six(position.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn square_has_its_area_normal_and_angles() {
        let x = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]]
            .map(|p| Vec3::new(p[0], p[1], p[2]));
        let facet = Facet { x };
        assert_eq!(facet.area_vector(), Vec3::new(0.0, 0.0, 4.0));
        assert_eq!(facet.center(), Vec3::new(1.0, 1.0, 0.0));
        for corner in 0..4 {
            assert_eq!(facet.corner_normal(corner), Vec3::new(0.0, 0.0, 4.0));
            assert!((facet.corner_angle(corner) - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        }
    }

    #[test]
    fn distance_is_measured_across_the_facet() {
        let x = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 1.0, 0.0]].map(Vec3::from);
        let facet = Facet { x };
        for (point, distance) in
            [([1.0, 0.5, 0.25], Some(0.25)), ([2.2, 1.4, -1e-3], Some(1e-3)), ([2.7, 1.5, 0.0], None)]
        {
            let found = facet.distance_inside(&Vec3::from(point));
            assert_eq!(found.is_some(), distance.is_some(), "{point:?}");
            assert!(found.zip(distance).is_none_or(|(a, b)| (a - b).abs() < 1e-12), "{point:?}: {found:?}");
        }
        assert_eq!(Facet { x: [Vec3::zeros(); 4] }.distance_inside(&Vec3::x()), None);
    }

    #[test]
    fn positions_are_shown_short() {
        assert_eq!(show(Vec3::new(1.0 / 3.0, -2.0, 1e-20)), "(0.333333, -2.0, 1e-20)");
        assert_eq!(show(Vec3::new(f64::NAN, 0.0, f64::INFINITY)), "(NaN, 0.0, inf)");
    }
}
