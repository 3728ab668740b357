//! Integrals against closed forms, and refusals of surfaces that bound no solid.

use std::f64::consts::PI;

use super::TriangulatedSurface;
use crate::norm::max_norm;
use crate::{Mat3, Vec3};

type Corners = Vec<[[f64; 3]; 3]>;

/// Box with its corner of lowest coordinates at `low`.
fn cuboid(low: [f64; 3], size: [f64; 3]) -> Corners {
    let corner = |i: usize| std::array::from_fn(|k| low[k] + if i >> k & 1 == 1 { size[k] } else { 0.0 });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
    faces.into_iter().flat_map(halves).map(|t| t.map(corner)).collect()
}

fn reversed(corners: Corners) -> Corners {
    corners.into_iter().map(|[a, b, c]| [a, c, b]).collect()
}

fn mapped(corners: &Corners, map: impl Fn(Vec3) -> Vec3) -> Corners {
    corners.iter().map(|t| t.map(|x| map(x.into()).into())).collect()
}

/// Octahedron whose triangles are halved `levels` times, with its vertices on the unit sphere.
fn ball(levels: usize) -> Corners {
    let axis = |k: usize, sign: f64| Vec3::ith(k, sign);
    let mut out: Vec<[Vec3; 3]> = Vec::new();
    for octant in 0..8 {
        let sign = |k: usize| if octant >> k & 1 == 1 { -1.0 } else { 1.0 };
        let t = [axis(0, sign(0)), axis(1, sign(1)), axis(2, sign(2))];
        out.push(if sign(0) * sign(1) * sign(2) > 0.0 { t } else { [t[0], t[2], t[1]] });
    }
    for _ in 0..levels {
        let quarters = |[a, b, c]: [Vec3; 3]| {
            let [ab, bc, ca] = [(a + b).normalize(), (b + c).normalize(), (c + a).normalize()];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        out = out.into_iter().flat_map(quarters).collect();
    }
    out.into_iter().map(|t| t.map(Into::into)).collect()
}

fn rotation() -> Mat3 {
    nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0).into_inner()
}

/// Largest entry of a difference of matrices.
fn distance(a: &Mat3, b: &Mat3) -> f64 {
    max_norm((a - b).iter())
}

#[test]
fn box_has_the_moments_of_a_box() {
    let [a, b, c] = [0.3, 1.7, 0.04];
    let s = TriangulatedSurface::new(&cuboid([0.1, -0.2, 5.0], [a, b, c])).unwrap();
    assert!((s.volume / (a * b * c) - 1.0).abs() < 1e-12, "{}", s.volume);
    assert!((s.centre - Vec3::new(0.25, 0.65, 5.02)).norm() < 1e-12, "{}", s.centre);
    let expected = Mat3::from_diagonal(&(Vec3::new(a * a, b * b, c * c) / 12.0));
    assert!(distance(&s.second_moments, &expected) < 1e-12, "{}", s.second_moments);
    assert_eq!((s.points.len(), s.triangles.len()), (8, 12));
}

/// About the corner of right angles ∫x² dV = 1/60 and ∫xy dV = 1/120, by integration in closed form.
#[test]
fn tetrahedron_has_its_products_of_inertia() {
    let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let s = TriangulatedSurface::new(&[[o, y, x], [o, z, y], [o, x, z], [x, y, z]]).unwrap();
    assert!((s.volume - 1.0 / 6.0).abs() < 1e-15 && (s.centre - Vec3::repeat(0.25)).norm() < 1e-15);
    let expected = Mat3::from_fn(|i, j| if i == j { 0.1 } else { 0.05 } - 0.0625);
    assert!(distance(&s.second_moments, &expected) < 1e-15, "{}", s.second_moments);
}

#[test]
fn ball_of_triangles_converges_at_second_order() {
    let error = |levels| {
        let s = TriangulatedSurface::new(&ball(levels)).unwrap();
        let moments = distance(&s.second_moments, &(Mat3::identity() / 5.0)) / 0.2;
        [(s.volume / (4.0 / 3.0 * PI) - 1.0).abs(), moments]
    };
    let (coarse, fine) = (error(4), error(5));
    for (coarse, fine) in coarse.into_iter().zip(fine) {
        let order = (coarse / fine).log2();
        assert!((order - 2.0).abs() < 0.05 && fine < 2e-3, "{coarse} {fine} {order}");
    }
}

/// Moments of two boxes by the parallel-axis theorem, as parts of one solid and as a solid with a cavity, in a rotated frame.
#[test]
fn parts_and_cavities_follow_the_parallel_axis_theorem() {
    let (r, shift) = (rotation(), Vec3::new(0.7, -3.0, 0.2));
    let sizes = [Vec3::new(2.0, 1.0, 1.5), Vec3::new(0.5, 0.25, 1.0)];
    for (place, sign) in [(Vec3::new(4.0, 0.3, 0.1), 1.0), (Vec3::new(0.9, 0.5, 0.2), -1.0)] {
        let second = cuboid(place.into(), sizes[1].into());
        let second = if sign > 0.0 { second } else { reversed(second) };
        let both = [cuboid([0.0; 3], sizes[0].into()), second].concat();
        let s = TriangulatedSurface::new(&mapped(&both, |x| r * x + shift)).unwrap();
        let v = [sizes[0].product(), sign * sizes[1].product()];
        let middles = [sizes[0] * 0.5, place + sizes[1] * 0.5];
        let volume = v[0] + v[1];
        let centre = (middles[0] * v[0] + middles[1] * v[1]) / volume;
        let of = |i: usize| {
            let own = Mat3::from_diagonal(&(sizes[i].component_mul(&sizes[i]) / 12.0));
            let arm = middles[i] - centre;
            (own + arm * arm.transpose()) * v[i]
        };
        let moments = r * (of(0) + of(1)) * r.transpose() / volume;
        assert!((s.volume - volume).abs() < 1e-12, "{} {volume}", s.volume);
        assert!((s.centre - (r * centre + shift)).norm() < 1e-12, "{}", s.centre);
        assert!(distance(&s.second_moments, &moments) < 1e-12, "{}", s.second_moments);
    }
}

/// At a hundred thousand times its size from the origin a body keeps its moments as far as its coordinates have digits.
#[test]
fn moments_do_not_lose_digits_far_from_the_origin() {
    let at = Vec3::new(1e5, -2e5, 1.5e5);
    let r = rotation();
    let near = mapped(&cuboid([-0.5; 3], [1.0, 0.6, 0.3]), |x| r * x);
    let [near, far] =
        [near.clone(), mapped(&near, |x| x + at)].map(|t| TriangulatedSurface::new(&t).unwrap());
    assert!((far.volume / near.volume - 1.0).abs() < 1e-9, "{}", far.volume);
    assert!((far.centre - at - near.centre).norm() < 1e-9, "{}", far.centre);
    let size = max_norm(near.second_moments.iter());
    assert!(distance(&far.second_moments, &near.second_moments) < 1e-9 * size);
}

/// A triangle with two equal corners closes itself; −0 and 0 are one coordinate.
#[test]
fn triangles_reduced_to_lines_are_left_out() {
    let mut t = cuboid([0.0; 3], [1.0; 3]);
    t.push([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]);
    t[0][0][1] = -0.0;
    let s = TriangulatedSurface::new(&t).unwrap();
    assert_eq!((s.points.len(), s.triangles.len()), (8, 12));
    assert!((s.volume - 1.0).abs() < 1e-15);
}

/// Part of the message for a surface that is refused.
fn refused(corners: &Corners, parts: &[&str]) {
    let message = TriangulatedSurface::new(corners).unwrap_err().to_string();
    assert!(parts.iter().all(|part| message.contains(part)), "{message}");
}

#[test]
fn surfaces_that_bound_no_solid_are_refused() {
    let whole = || cuboid([0.0; 3], [1.0, 2.0, 3.0]);
    refused(&whole()[1..].to_vec(), &["not closed: 3 edges belong", "(0, 0, 0) to"]);
    let mut one = whole();
    one[5] = [one[5][0], one[5][2], one[5][1]];
    refused(&one, &["not oriented alike: 3 edges lie"]);
    refused(&reversed(whole()), &["oriented inwards", "-6e0", "flip the normals"]);
    refused(&[whole(), whole()].concat(), &["18 edges belong to more than two triangles"]);
    let mut gap = whole();
    gap[0][0][0] += 1e-9;
    refused(&gap, &["not closed"]);
    refused(&Vec::new(), &["no triangles"]);
    refused(&vec![[[1.0; 3]; 3]; 4], &["all 4 triangles"]);
    let flat = mapped(&cuboid([0.0; 3], [1.0; 3]), |x| rotation() * Vec3::new(x.x, x.y, 0.3 * x.x));
    let sheet: Corners = mapped(&ball(1), |x| rotation() * Vec3::new(x.x, x.y, 0.5 * x.x - x.y));
    for surface in [flat, sheet] {
        let message = TriangulatedSurface::new(&surface).unwrap_err().to_string();
        assert!(message.contains("no volume") || message.contains("more than two"), "{message}");
    }
    refused(&cuboid([0.0; 3], [1.0, 1.0, 1e-14]), &["no volume"]);
    for bad in [f64::NAN, f64::INFINITY, 1e80] {
        let mut t = whole();
        t[3][1][2] = bad;
        refused(&t, &["triangle 4", "not a number below"]);
    }
}

#[test]
fn shells_that_count_material_twice_are_refused() {
    let outer = || cuboid([0.0; 3], [4.0; 3]);
    let inner = || cuboid([1.0; 3], [1.0; 3]);
    refused(&[outer(), inner()].concat(), &["12 triangles", "within the solid"]);
    let beside = reversed(cuboid([8.0; 3], [1.0; 3]));
    refused(&[outer(), beside].concat(), &["12 triangles", "is oriented inwards"]);
    refused(&[reversed(outer()), inner()].concat(), &["is oriented inwards"]);
    refused(
        &[outer(), reversed(cuboid([0.5; 3], [3.0; 3])), reversed(inner())].concat(),
        &["is oriented inwards"],
    );
    // A core in a cavity is material again; boxes that touch with a face are two parts.
    let core = [outer(), reversed(cuboid([0.5; 3], [3.0; 3])), inner()].concat();
    let volume = TriangulatedSurface::new(&core).unwrap().volume;
    assert!((volume - (64.0 - 27.0 + 1.0)).abs() < 1e-12, "{volume}");
    let touching = [outer(), cuboid([4.0, 1.0, 1.0], [1.0; 3])].concat();
    assert!((TriangulatedSurface::new(&touching).unwrap().volume - 65.0).abs() < 1e-12);
}
