//! Inertia of rigid bodies from their shapes or given moments, with the mistakes in their values.

use crate::checker::Checker;
use crate::model::body::axes_of_space;
use crate::model::{BodyShape, Model, RigidBody};
use crate::norm::max_norm;
use crate::{Issue, Mat3, Vec3};

/// Cosine of the angle between directions, and ratio of moments of inertia, that are the same but for round-off.
const SAME: f64 = 1e-9;

/// Mistakes in the values of a body, which may be without mass in kinematic analyses.
pub(super) fn values(body: &RigidBody, key: &str, kinematic: bool, c: &mut Checker) {
    c.finite(&format!("{key}.at"), "the position", &body.at);
    c.finite(&format!("{key}.velocity"), "the velocity", &body.velocity);
    c.finite(&format!("{key}.angular_velocity"), "the angular velocity", &body.angular_velocity);
    two_directions(body.axes, key, c);
    if let Some(mass) = body.mass {
        c.positive(&format!("{key}.mass"), "the mass", mass);
    }
    if let Some(density) = body.density {
        c.positive(&format!("{key}.density"), "the density", density);
    }
    if let Some(shape) = &body.shape {
        shape_values(body, shape, &format!("{key}.shape"), c);
    }
    let name = &body.name;
    if body.is_point_mass() && body.axes != axes_of_space() {
        c.add(
            format!("{key}.axes"),
            format!("body \"{name}\" is a point mass, which has no axes"),
            "give `inertia`, a shape, `attached` or `distributed`, or leave the axes out",
        );
    }
    let wrong = match (&body.shape, body.inertia, body.mass, body.density) {
        (Some(_), Some(_), ..) => Some(("inertia", "has a shape and an inertia", "give one of them")),
        (None, _, _, Some(_)) => Some(("density", "has a density but no shape", "give `mass`, or a shape")),
        (Some(_), _, Some(_), Some(_)) => Some(("density", "has a mass and a density", "give one of them")),
        (Some(BodyShape::Rod(_)), _, None, Some(_)) => {
            Some(("density", "is a rod, which has no volume", "give `mass`"))
        }
        (None, None, None, None) if body.is_on_nodes() || kinematic => None,
        (_, _, None, None) => Some(("mass", "has no mass", "give `mass`")),
        _ => None,
    };
    if let Some((which, message, help)) = wrong {
        c.add(format!("{key}.{which}"), format!("body \"{name}\" {message}"), help);
        return;
    }
    c.finite(&format!("{key}.products_of_inertia"), "a product of inertia", &body.products_of_inertia);
    if body.inertia.is_none() && (body.products_of_inertia != [0.0; 3]) {
        c.add(
            format!("{key}.products_of_inertia"),
            format!("body \"{name}\" has products of inertia, but no `inertia`"),
            "give the moments of inertia, too",
        );
    }
    if body.is_point_mass() && body.angular_velocity != [0.0; 3] {
        c.add(
            format!("{key}.angular_velocity"),
            format!("body \"{name}\" is a point mass, which does not rotate"),
            "give `inertia` or a shape, or leave the angular velocity out",
        );
    }
    if let Some(inertia) = body.inertia {
        c.finite(&format!("{key}.inertia"), "a moment of inertia", &inertia);
        let euler = euler_tensor(body);
        let smallest = euler.symmetric_eigenvalues().min();
        if !(smallest >= -SAME * euler.norm()) || !(euler.trace() > 0.0) {
            c.add(
                format!("{key}.inertia"),
                format!("no body has the moments of inertia of \"{name}\": the largest one exceeds the sum of the others, or all vanish"),
                "check the moments and products of inertia, and that they are about the mass centre",
            );
        }
    }
}

/// Mistakes in the values of a shape.
fn shape_values(body: &RigidBody, shape: &BodyShape, key: &str, c: &mut Checker) {
    for size in shape.sizes() {
        c.positive(key, "a size of the shape", size);
    }
    match shape {
        BodyShape::Cylinder(shape) => {
            c.not_negative(&format!("{key}.inner_radius"), "the inner radius", shape.inner_radius);
            if !(shape.inner_radius < shape.radius) {
                let message = "the inner radius is not below the radius";
                c.add(format!("{key}.inner_radius"), message, "give a smaller `inner_radius`");
            }
        }
        BodyShape::Stl(stl) => {
            c.positive(&format!("{key}.scale"), "the scale", stl.scale);
            if let Some(surface) = &stl.surface {
                let size = max_norm(surface.points.iter().map(Vec3::norm)) * stl.scale;
                c.positive(key, "the size of the surface", size);
                c.finite(key, "the mass centre of the surface", shape.centre().as_slice());
                c.positive(key, "the volume of the surface", shape.volume());
                if body.density.is_some() {
                    c.positive(key, "the mass of the solid within the surface", mass(body));
                }
            }
        }
        BodyShape::Box(_) | BodyShape::Sphere(_) | BodyShape::Rod(_) => {}
    }
}

/// Bodies whose surfaces nobody has read.
pub(super) fn unread_surfaces(model: &Model) -> Vec<Issue> {
    let issue = |(i, body): (usize, &RigidBody)| match &body.shape {
        Some(BodyShape::Stl(stl)) if stl.surface.is_none() => Some(Issue::new(
            format!("bodies[{i}].shape.file"),
            format!("the surface \"{}\" of body \"{}\" has not been read", stl.file, body.name),
            "read it by the crate tegula-io, or set `surface` of the shape",
        )),
        _ => None,
    };
    model.bodies.iter().enumerate().filter_map(issue).collect()
}

/// Mass of a body.
pub(super) fn mass(body: &RigidBody) -> f64 {
    let volume = body.shape.as_ref().map_or(0.0, BodyShape::volume);
    body.mass.unwrap_or_else(|| body.density.unwrap_or(0.0) * volume)
}

/// Euler tensor ∫ρ X Xᵀ dV about the mass centre along the axes of the body.
pub(super) fn euler_tensor(body: &RigidBody) -> Mat3 {
    match (&body.shape, body.inertia) {
        (Some(shape), _) => shape.second_moments() * mass(body),
        (None, Some([a, b, d])) => {
            let [ab, ad, bd] = body.products_of_inertia;
            let j = Mat3::new(a, ab, ad, ab, b, bd, ad, bd, d);
            Mat3::identity() * (0.5 * j.trace()) - j
        }
        (None, None) => Mat3::zeros(),
    }
}

/// Axes of a body at the reference, as columns.
pub(super) fn axes(body: &RigidBody) -> Mat3 {
    frame(body.axes)
}

/// Axes, as columns, of a first axis and a second direction in the plane of the first two ones.
pub(super) fn frame([first, second]: [[f64; 3]; 2]) -> Mat3 {
    let first = Vec3::from(first).normalize();
    let third = first.cross(&Vec3::from(second)).normalize();
    Mat3::from_columns(&[first, third.cross(&first), third])
}

/// Refuses two directions that span no plane.
pub(super) fn two_directions(axes: [[f64; 3]; 2], key: &str, c: &mut Checker) {
    for (i, axis) in axes.iter().enumerate() {
        direction(&format!("{key}.axes[{i}]"), *axis, c);
    }
    if cosine(axes).abs() > 1.0 - SAME {
        c.add(
            format!("{key}.axes"),
            "the two directions are parallel",
            "give two directions that span a plane",
        );
    }
}

/// Mass centre of a body at the reference.
pub(super) fn centre(body: &RigidBody) -> Vec3 {
    let within = body.shape.as_ref().map_or_else(Vec3::zeros, BodyShape::centre);
    Vec3::from(body.at) + axes(body) * within
}

fn cosine([a, b]: [[f64; 3]; 2]) -> f64 {
    Vec3::from(a).normalize().dot(&Vec3::from(b).normalize())
}

/// Refuses a direction that is zero or not finite.
pub(super) fn direction(key: &str, value: [f64; 3], c: &mut Checker) {
    c.finite(key, "the direction", &value);
    if value.iter().all(|x| x.is_finite()) && !(Vec3::from(value).norm() > 0.0) {
        c.add(key, "the direction is zero", "give a vector that is not zero");
    }
}
