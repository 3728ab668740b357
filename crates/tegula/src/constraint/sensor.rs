//! Sensors: quantities of the motion of points, bodies and joints.

use super::Attachment;
use super::joints::RelativeAngle;
use crate::Vec3;
use crate::element::geometry::{GAUSS_POINTS, shape, shape_eta, shape_xi};

/// Sensor of the compiled model.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Name of the sensor in the model.
    pub name: String,
    /// Quantity that it measures.
    pub measure: Measure,
}

/// Quantity that a sensor measures.
#[derive(Debug, Clone, PartialEq)]
pub enum Measure {
    /// Distance of two points.
    Distance([Attachment; 2]),
    /// Angle of the second end relative to the first one. Angles of sensors continue over full turns; the state holds them.
    Angle(Box<RelativeAngle>),
    /// Motion of a point.
    Point(Attachment),
    /// Reaction of the joint with this number.
    Reaction(usize),
    /// Volume of the cone over a surface.
    Volume(ConeVolume),
    /// Mean elongation of gauges in all elements that contain a point.
    Strain(Vec<StrainGauge>),
}

/// Material line element of a shell: a vector that is linear in the nodal vectors, of length 1 in the reference configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialLine {
    /// Vector along the line.
    pub vector: Attachment,
    /// Its value in the reference configuration.
    pub reference: Vec3,
}

/// Strain gauge in a shell element: Green–Lagrange strains along two axes of its surface at its place, and their shear strain in the middle of the element.
/// Away from the middle the bilinear displacements have a shear strain under in-plane bending that the structure has not.
#[derive(Debug, Clone, PartialEq)]
pub struct StrainGauge {
    /// Lines along both axes at the place of the gauge.
    pub lines: [MaterialLine; 2],
    /// Lines along both axes in the middle of the element.
    pub middle: [MaterialLine; 2],
    /// Components of the direction of the gauge along the axes.
    pub direction: [f64; 2],
}

impl StrainGauge {
    /// Elongation `λ − 1` with `λ² = 1 + 2 E`, and its rate; with `linear` those of small displacements.
    pub fn value_and_rate(
        &self,
        linear: bool,
        at: impl Fn(u32) -> Vec3 + Copy,
        velocity: impl Fn(u32) -> Vec3 + Copy,
    ) -> [f64; 2] {
        // Twice the strain of two lines `a·b − A·B`, and its rate.
        let twice = |[a, b]: [&MaterialLine; 2]| {
            let [x, y] = [a, b].map(|line| line.vector.value(at));
            let [v, w] = [a, b].map(|line| line.vector.rate(velocity));
            let (u, z) = (x - a.reference, y - b.reference);
            let small = u.dot(&b.reference) + a.reference.dot(&z);
            match linear {
                true => [small, v.dot(&b.reference) + a.reference.dot(&w)],
                false => [small + u.dot(&z), v.dot(&y) + x.dot(&w)],
            }
        };
        let ([a, b], [p, q], [c, s]) = (&self.lines, &self.middle, self.direction);
        let parts = [(c * c, twice([a, a])), (s * s, twice([b, b])), (2.0 * c * s, twice([p, q]))];
        let [strain, rate] = [0, 1].map(|i| parts.iter().map(|(weight, part)| weight * part[i]).sum::<f64>());
        if linear {
            return [0.5 * strain, 0.5 * rate];
        }
        // √(1 + 2E) − 1 = 2E/(√(1 + 2E) + 1) keeps the digits of small strains.
        let length = (1.0 + strain).sqrt();
        [strain / (length + 1.0), 0.5 * rate / length]
    }
}

/// Volume of the cone over a surface of quads, `V = ⅓ ∫ (r − t)·(r,ξ × r,η) dξ dη` with the tip t: that which a closed surface encloses.
#[derive(Debug, Clone, PartialEq)]
pub struct ConeVolume {
    /// Positions of the nodes of each quad, around its director.
    pub quads: Vec<[u32; 4]>,
    /// Tip.
    pub tip: Vec3,
}

impl ConeVolume {
    /// Volume, and its rate for given positions and velocities. The rule of 2 × 2 points is exact for bilinear quads.
    pub fn value_and_rate(&self, at: impl Fn(u32) -> Vec3, velocity: impl Fn(u32) -> Vec3) -> [f64; 2] {
        let mut out = [0.0; 2];
        for quad in &self.quads {
            let x = quad.map(|v| at(v) - self.tip);
            let v = quad.map(&velocity);
            for [xi, eta] in GAUSS_POINTS {
                let sum =
                    |values: &[Vec3; 4], n: [f64; 4]| values.iter().zip(n).map(|(x, n)| x * n).sum::<Vec3>();
                let [n, n_xi, n_eta] = [shape(xi, eta), shape_xi(eta), shape_eta(xi)];
                let [r, a, b] = [n, n_xi, n_eta].map(|n| sum(&x, n));
                let [w, p, q] = [n, n_xi, n_eta].map(|n| sum(&v, n));
                out[0] += r.dot(&a.cross(&b)) / 3.0;
                out[1] += (w.dot(&a.cross(&b)) + r.dot(&p.cross(&b)) + r.dot(&a.cross(&q))) / 3.0;
            }
        }
        out
    }
}

impl Sensor {
    /// Angle that the sensor measures, if it measures one.
    pub fn angle(&self) -> Option<&RelativeAngle> {
        match &self.measure {
            Measure::Angle(angle) => Some(angle),
            Measure::Distance(_)
            | Measure::Point(_)
            | Measure::Reaction(_)
            | Measure::Volume(_)
            | Measure::Strain(_) => None,
        }
    }
}
