//! Parametrised surfaces behind the generators.
//!
//! Each maps parameters (u, v) to a position r and knows its exact unit normal
//! r,u × r,v / |r,u × r,v|. Angles come in degrees, and quarter turns give exact
//! sines and cosines, so that symmetry planes hold their nodes exactly.

use crate::Vec3;

/// A surface with its exact normal.
pub(super) trait Surface {
    /// Position at the parameters (u, v) (length).
    fn position(&self, u: f64, v: f64) -> Vec3;

    /// Unit normal r,u × r,v at the parameters (u, v); `side` is a u within the
    /// element that asks, and tells the two sides of a fold apart.
    fn normal(&self, u: f64, v: f64, side: f64) -> Vec3;
}

/// A parallelogram; u, v in 0…1.
pub(super) struct Plate {
    /// Corner u = v = 0 (length).
    pub origin: Vec3,
    /// Side along u (length).
    pub u_side: Vec3,
    /// Side along v (length).
    pub v_side: Vec3,
    /// Unit normal.
    pub normal: Vec3,
}

impl Surface for Plate {
    fn position(&self, u: f64, v: f64) -> Vec3 {
        self.origin + self.u_side * u + self.v_side * v
    }

    fn normal(&self, _: f64, _: f64, _: f64) -> Vec3 {
        self.normal
    }
}

/// A cylinder; u in 0…1 runs over the angles, v in 0…1 along the axis.
pub(super) struct Cylinder {
    /// Point on the axis at v = 0 (length).
    pub center: Vec3,
    /// Radial unit vector of the angle 0.
    pub radial: Vec3,
    /// Unit vector of the axis.
    pub axis: Vec3,
    /// Radius (length).
    pub radius: f64,
    /// First and last angle (degrees).
    pub angles: [f64; 2],
    /// Length (length).
    pub length: f64,
}

impl Cylinder {
    fn outward(&self, u: f64) -> Vec3 {
        let (sin, cos) = sin_cos_degrees(between(self.angles, u));
        self.radial * cos + self.axis.cross(&self.radial) * sin
    }
}

impl Surface for Cylinder {
    fn position(&self, u: f64, v: f64) -> Vec3 {
        self.center + self.outward(u) * self.radius + self.axis * (self.length * v)
    }

    // r,u = (θ₁ − θ₀) R e_θ and r,v = L a, and e_θ × a = e_r
    fn normal(&self, u: f64, _: f64, _: f64) -> Vec3 {
        self.outward(u) * direction(self.angles)
    }
}

/// A flat ring normal to z; u in 0…1 runs over the radii, v in 0…1 over the angles.
pub(super) struct Annulus {
    /// Centre (length).
    pub center: Vec3,
    /// Inner and outer radius (length).
    pub radii: [f64; 2],
    /// First and last angle (degrees).
    pub angles: [f64; 2],
}

impl Surface for Annulus {
    fn position(&self, u: f64, v: f64) -> Vec3 {
        let (sin, cos) = sin_cos_degrees(between(self.angles, v));
        self.center + Vec3::new(cos, sin, 0.0) * between(self.radii, u)
    }

    fn normal(&self, _: f64, _: f64, _: f64) -> Vec3 {
        Vec3::new(0.0, 0.0, direction(self.angles))
    }
}

/// A sphere about the z axis; u in 0…1 runs over the longitudes, v in 0…1 over the latitudes.
pub(super) struct Sphere {
    /// Centre (length).
    pub center: Vec3,
    /// Radius (length).
    pub radius: f64,
    /// First and last longitude (degrees).
    pub longitudes: [f64; 2],
    /// First and last latitude (degrees).
    pub latitudes: [f64; 2],
}

impl Sphere {
    fn outward(&self, u: f64, v: f64) -> Vec3 {
        let (sin_long, cos_long) = sin_cos_degrees(between(self.longitudes, u));
        let (sin_lat, cos_lat) = sin_cos_degrees(between(self.latitudes, v));
        Vec3::new(cos_lat * cos_long, cos_lat * sin_long, sin_lat)
    }
}

impl Surface for Sphere {
    fn position(&self, u: f64, v: f64) -> Vec3 {
        self.center + self.outward(u, v) * self.radius
    }

    // east × north points outwards
    fn normal(&self, u: f64, v: f64, _: f64) -> Vec3 {
        self.outward(u, v) * (direction(self.longitudes) * direction(self.latitudes))
    }
}

/// A swept polyline; u in 0…number of segments (whole numbers are vertices), v in 0…1 along the sweep.
pub(super) struct Extrusion {
    /// Vertices (length), at least two.
    pub vertices: Vec<Vec3>,
    /// Sweep (length).
    pub sweep: Vec3,
    /// Unit normal of each segment's sheet.
    pub normals: Vec<Vec3>,
}

impl Extrusion {
    fn segment(&self, u: f64) -> usize {
        // a negative or undefined u becomes 0
        (u.floor() as usize).min(self.normals.len().saturating_sub(1))
    }
}

impl Surface for Extrusion {
    fn position(&self, u: f64, v: f64) -> Vec3 {
        let segment = self.segment(u);
        let part = u - segment as f64;
        let along = match self.vertices.get(segment..segment + 2) {
            Some([a, b]) => a * (1.0 - part) + b * part,
            _ => Vec3::zeros(),
        };
        along + self.sweep * v
    }

    fn normal(&self, _: f64, _: f64, side: f64) -> Vec3 {
        self.normals.get(self.segment(side)).copied().unwrap_or_else(Vec3::zeros)
    }
}

/// Value a part `t` of the way from the first to the last, exact at both ends.
fn between(ends: [f64; 2], t: f64) -> f64 {
    ends[0] * (1.0 - t) + ends[1] * t
}

/// +1 if the last value lies above the first, −1 otherwise.
fn direction(ends: [f64; 2]) -> f64 {
    if ends[1] > ends[0] { 1.0 } else { -1.0 }
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90°.
fn sin_cos_degrees(angle: f64) -> (f64, f64) {
    let turned = angle.rem_euclid(360.0);
    let quarters = (turned / 90.0).round();
    let (sin, cos) = (turned - 90.0 * quarters).to_radians().sin_cos();
    match quarters as u8 {
        1 => (cos, -sin),
        2 => (-sin, -cos),
        3 => (-cos, sin),
        _ => (sin, cos),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// r,u × r,v by central differences, normalised.
    fn numeric_normal(surface: &impl Surface, u: f64, v: f64) -> Vec3 {
        let h = 1e-5;
        let ru = surface.position(u + h, v) - surface.position(u - h, v);
        let rv = surface.position(u, v + h) - surface.position(u, v - h);
        ru.cross(&rv).normalize()
    }

    fn agrees(surface: &impl Surface) {
        for (u, v) in [(0.2, 0.3), (0.55, 0.9), (0.8, 0.1)] {
            let exact = surface.normal(u, v, u);
            assert!((exact - numeric_normal(surface, u, v)).norm() < 1e-7);
            assert!((exact.norm() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn normals_are_the_cross_product_of_the_tangents() {
        let center = Vec3::new(1.0, 2.0, 3.0);
        for angles in [[0.0, 90.0], [30.0, -200.0]] {
            let (radial, axis) = (Vec3::z(), Vec3::y());
            agrees(&Cylinder { center, radial, axis, radius: 2.0, angles, length: 3.0 });
            agrees(&Annulus { center, radii: [1.0, 2.5], angles });
            for latitudes in [[-10.0, 72.0], [50.0, 5.0]] {
                agrees(&Sphere { center, radius: 4.0, longitudes: angles, latitudes });
            }
        }
    }

    #[test]
    fn quarter_turns_are_exact() {
        for (angle, expected) in [
            (0.0, (0.0, 1.0)),
            (90.0, (1.0, 0.0)),
            (180.0, (0.0, -1.0)),
            (270.0, (-1.0, 0.0)),
            (360.0, (0.0, 1.0)),
            (-90.0, (-1.0, 0.0)),
        ] {
            assert_eq!(sin_cos_degrees(angle), expected, "{angle}");
        }
        for angle in [-400.0, -100.0, 12.5, 44.0, 46.0, 140.0, 300.0, 359.0] {
            let (sin, cos) = sin_cos_degrees(angle);
            let (s, c) = f64::sin_cos(angle.to_radians());
            assert!((sin - s).abs() < 1e-14 && (cos - c).abs() < 1e-14, "{angle}");
        }
    }
}
