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
    /// Elongation of a material line.
    Strain(MaterialLine),
}

/// Material line element of a shell: a vector that is linear in the nodal vectors, of length 1 in the reference configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialLine {
    /// Vector along the line.
    pub vector: Attachment,
    /// Its value in the reference configuration.
    pub reference: Vec3,
}

impl MaterialLine {
    /// Elongation `|t| − 1` of the line and its rate; with `linear` those of small displacements, `t₀·(t − t₀)`.
    pub fn value_and_rate(
        &self,
        linear: bool,
        at: impl Fn(u32) -> Vec3,
        velocity: impl Fn(u32) -> Vec3,
    ) -> [f64; 2] {
        let (line, change) = (self.vector.value(at), self.vector.rate(velocity));
        if linear {
            return [self.reference.dot(&(line - self.reference)), self.reference.dot(&change)];
        }
        // |t| − 1 = (|t|² − 1)/(|t| + 1) keeps the digits of small strains.
        let (u, length) = (line - self.reference, line.norm());
        [u.dot(&(line + self.reference)) / (length + 1.0), line.dot(&change) / length]
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
            Measure::Distance(_) | Measure::Point(_) | Measure::Reaction(_) | Measure::Volume(_) | Measure::Strain(_) => None,
        }
    }
}
