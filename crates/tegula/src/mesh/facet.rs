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
    /// The facet of a quad; `None` if a node index is out of range.
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
pub(super) fn show(position: Vec3) -> String {
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
    fn positions_are_shown_short() {
        assert_eq!(show(Vec3::new(1.0 / 3.0, -2.0, 1e-20)), "(0.333333, -2.0, 1e-20)");
        assert_eq!(show(Vec3::new(f64::NAN, 0.0, f64::INFINITY)), "(NaN, 0.0, inf)");
    }
}
