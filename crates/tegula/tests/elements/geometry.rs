//! Geometry of single elements.

use tegula::Vec3;
use tegula::element::ShellGeometry;
use tegula::element::geometry::tangents;

/// Tangents are the ones of the plane perpendicular to the director, whatever its length: unit vectors, the first of them the
/// projection of the coordinate axis, the second at its left.
#[test]
fn tangents_do_not_depend_on_the_length_of_the_director() {
    for (d, axis) in [
        (Vec3::new(0.3, 0.4, 2.0), Vec3::x()),
        (Vec3::new(-1.5, 0.2, 0.7), Vec3::y()),
        (Vec3::new(0.9, -1.1, 0.1), Vec3::z()),
    ] {
        for length in [0.01, 1.0, 3.0, 250.0] {
            let d = d.normalize() * length;
            let [first, second] = tangents(&d);
            for t in [first, second] {
                assert!((t.norm() - 1.0).abs() < 1e-14, "{t}");
                assert!(t.dot(&d).abs() < 1e-14 * length, "{t} is not perpendicular to {d}");
            }
            // In the plane of director and axis, on the side of the axis.
            assert!(first.dot(&d.cross(&axis)).abs() < 1e-14 * length && first.dot(&axis) > 0.0, "{first}");
            assert!(first.cross(&second).dot(&d) > 0.999_999 * length, "{d}");
        }
    }
}

/// A rectangle has the lengths of its sides, wherever it lies and at whichever corner its numbering begins.
#[test]
fn lengths_of_elements_do_not_depend_on_place_and_numbering() {
    for origin in [Vec3::zeros(), Vec3::new(100.0, -30.0, 7.0)] {
        let corners =
            [[0.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.0, 0.5]].map(|[x, y]| origin + Vec3::new(x, y, 0.0));
        for first in 0..4 {
            let geometry =
                ShellGeometry::new(std::array::from_fn(|a| corners[(a + first) % 4]), [Vec3::z(); 4]);
            assert!(geometry.is_shorter_than(0.501), "{origin} {first}");
            assert!(!geometry.is_shorter_than(0.499), "{origin} {first}");
            assert!((geometry.centre() - origin - Vec3::new(1.0, 0.25, 0.0)).norm() < 1e-13 * 100.0);
        }
    }
}
