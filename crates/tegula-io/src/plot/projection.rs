//! Parallel projection of space onto the picture.

use super::canvas::Point;

/// From where a picture looks: the direction from the model to the viewer. The z axis points up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Angle from the x axis towards the y axis, degrees.
    pub azimuth_deg: f64,
    /// Height above the xy plane, degrees; 90 looks down from above.
    pub elevation_deg: f64,
}

impl Default for View {
    fn default() -> Self {
        Self { azimuth_deg: -60.0, elevation_deg: 25.0 }
    }
}

/// A space vector.
pub(super) type Vec3 = nalgebra::Vector3<f64>;

/// The directions of the picture in space, orthonormal.
#[derive(Debug, Clone, Copy)]
pub(super) struct Camera {
    right: Vec3,
    up: Vec3,
    /// Towards the viewer.
    near: Vec3,
}

impl Camera {
    pub(super) fn new(view: View) -> Self {
        let finite = |degrees: f64| if degrees.is_finite() { degrees.to_radians() } else { 0.0 };
        let (sa, ca) = finite(view.azimuth_deg).sin_cos();
        let (se, ce) = finite(view.elevation_deg).sin_cos();
        Self {
            right: Vec3::new(-sa, ca, 0.0),
            up: Vec3::new(-se * ca, -se * sa, ce),
            near: Vec3::new(ce * ca, ce * sa, se),
        }
    }

    /// Components to the right, upwards and towards the viewer.
    pub(super) fn see(&self, x: &Vec3) -> Vec3 {
        Vec3::new(self.right.dot(x), self.up.dot(x), self.near.dot(x))
    }
}

/// Placement of the projected model on the sheet, with the same scale in both directions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placement {
    /// Pixels per unit of length.
    pub(super) scale: f64,
    centre: Point,
    middle: Point,
}

impl Placement {
    /// The placement that fits all points into the rectangle; `None` without finite points.
    pub(super) fn fit<'a>(
        seen: impl Iterator<Item = &'a Vec3>,
        [left, top]: Point,
        [right, bottom]: Point,
    ) -> Option<Self> {
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for x in seen {
            for axis in 0..2 {
                low[axis] = low[axis].min(x[axis]);
                high[axis] = high[axis].max(x[axis]);
            }
        }
        let (wide, tall) = (high[0] - low[0], high[1] - low[1]);
        if !(wide.is_finite() && tall.is_finite()) || wide.max(tall) <= 0.0 {
            return None;
        }
        let scale = ((right - left) / wide).min((bottom - top) / tall);
        let middle = [(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0];
        let centre = [(left + right) / 2.0, (top + bottom) / 2.0];
        scale.is_finite().then_some(Self { scale, centre, middle })
    }

    /// Position on the sheet of a seen point, on a fixed grid, so that neighbours that compute a common point differently
    /// still agree on it.
    pub(super) fn at(&self, seen: &Vec3) -> Point {
        self.exactly_at(seen).map(snapped)
    }

    /// Position on the sheet of a seen point.
    pub(super) fn exactly_at(&self, seen: &Vec3) -> Point {
        [
            self.centre[0] + (seen.x - self.middle[0]) * self.scale,
            self.centre[1] - (seen.y - self.middle[1]) * self.scale,
        ]
    }
}

fn snapped(x: f64) -> f64 {
    (x * 256.0).round() / 256.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_has_the_right_hand_up() {
        let camera = Camera::new(View { azimuth_deg: -90.0, elevation_deg: 0.0 });
        // Seen from the front: x to the right, z up, y away from the viewer.
        assert!((camera.see(&Vec3::x()) - Vec3::x()).norm() < 1e-12);
        assert!((camera.see(&Vec3::z()) - Vec3::y()).norm() < 1e-12);
        assert!((camera.see(&Vec3::y()) + Vec3::z()).norm() < 1e-12);
        let camera = Camera::new(View { azimuth_deg: 33.0, elevation_deg: 20.0 });
        assert!((camera.right.cross(&camera.up) - camera.near).norm() < 1e-12);
    }

    #[test]
    fn fitting_keeps_the_aspect() {
        let seen = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(4.0, 1.0, 9.0)];
        let placement = Placement::fit(seen.iter(), [100.0, 50.0], [500.0, 350.0]).unwrap();
        assert_eq!(placement.scale, 100.0);
        assert_eq!(placement.at(&seen[0]), [100.0, 250.0]);
        assert_eq!(placement.at(&seen[1]), [500.0, 150.0]);
        assert!(Placement::fit([Vec3::zeros()].iter(), [0.0, 0.0], [9.0, 9.0]).is_none());
        assert!(Placement::fit([].iter(), [0.0, 0.0], [9.0, 9.0]).is_none());
    }
}
