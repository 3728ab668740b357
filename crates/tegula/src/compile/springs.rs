//! Springs and torsion springs: their values, and from the model to force elements.

use super::bodies::{extent, not_with_itself};
use super::body_inertia::direction;
use super::inner_point::Corners;
use super::place::{Place, ends};
use crate::checker::Checker;
use crate::constraint::joints::{End, RelativeAngle};
use crate::constraint::{Across, Spring, SpringLaw, TorsionSpring};
use crate::mesh::Mesh;
use crate::model::{self, Model, SpringDamper};
use crate::system::Coordinates;
use crate::{Issue, Vec3};

/// Mistakes in the values of springs.
pub(super) fn keys(model: &Model, c: &mut Checker) {
    for (i, spring) in model.springs.iter().enumerate() {
        spring_values(spring, &format!("springs[{i}]"), c);
    }
    for (i, spring) in model.torsion_springs.iter().enumerate() {
        torsion_spring_values(spring, &format!("torsion_springs[{i}]"), c);
    }
}

/// Force law of a spring whose points have a distance, or whose second point has one from the axis, in the reference configuration.
///
/// # Errors
/// The formula is invalid: description of the mistake, and remedy.
fn law(spring: &SpringDamper, distance: f64) -> Result<SpringLaw, (String, String)> {
    let length = spring.length.unwrap_or(distance);
    match &spring.force {
        Some(text) => SpringLaw::formula(&named(&spring.name), text, [length, distance]),
        None => Ok(SpringLaw::linear([spring.stiffness, spring.damping], length)),
    }
}

/// Distance of the points of a spring, or of the second one from the axis, in the reference configuration.
fn distance(spring: &SpringDamper) -> f64 {
    let between = Vec3::from(spring.points[1]) - Vec3::from(spring.points[0]);
    match spring.across {
        None => between.norm(),
        Some(axis) => between.cross(&Vec3::from(axis).normalize()).norm(),
    }
}

/// Moment of a torsion spring by its angle.
///
/// # Errors
/// The formula is invalid: description of the mistake, and remedy.
fn torsion_law(spring: &model::TorsionSpring) -> Result<SpringLaw, (String, String)> {
    let free = spring.free_angle.to_radians();
    match &spring.moment {
        Some(text) => SpringLaw::formula(&torsion_named(&spring.name), text, [free, 0.0]),
        None => Ok(SpringLaw::linear([spring.stiffness, spring.damping], free)),
    }
}

fn named(name: &str) -> String {
    format!("the spring \"{name}\"")
}

fn torsion_named(name: &str) -> String {
    format!("the torsion spring \"{name}\"")
}

/// A spring with neither a formula nor stiffness and damping, or with both.
fn acts(
    (what, key, name): (&str, &str, &str),
    ([stiffness, damping], formula): ([f64; 2], Option<&str>),
    c: &mut Checker,
) {
    let is_linear = stiffness != 0.0 || damping != 0.0;
    match formula {
        None if !is_linear => c.add(
            key,
            format!("{what} does nothing"),
            format!("give `stiffness`, `damping` or both, or a formula as `{name}`"),
        ),
        Some(text) if is_linear => c.add(
            format!("{key}.{name}"),
            format!("{what} has the formula \"{text}\" beside `stiffness` or `damping`"),
            format!("write them into `{name}`, as {stiffness}*x + {damping}*v, or leave `{name}` out"),
        ),
        _ => {}
    }
}

fn spring_values(spring: &SpringDamper, key: &str, c: &mut Checker) {
    c.not_negative(&format!("{key}.stiffness"), "the stiffness", spring.stiffness);
    c.not_negative(&format!("{key}.damping"), "the damping", spring.damping);
    c.not_negative(&format!("{key}.length"), "the length", spring.length.unwrap_or(0.0));
    spring.points.iter().for_each(|point| c.finite(&format!("{key}.points"), "the point", point));
    let what = named(&spring.name);
    not_with_itself((&what, &spring.between), key, c);
    acts((&what, key, "force"), ([spring.stiffness, spring.damping], spring.force.as_deref()), c);
    // Within its clearance a spring needs no direction.
    let mut is_free = false;
    match law(spring, distance(spring)) {
        Ok(law) => {
            let first = law.force([0.0; 2], 0.0, 0.0);
            is_free = spring.force.is_some() && [first.value, first.by_position] == [0.0; 2];
        }
        Err((problem, help)) => c.add(format!("{key}.force"), problem, help),
    }
    if let Some(axis) = spring.across {
        direction(&format!("{key}.across"), axis, c);
    }
    if distance(spring) == 0.0 && spring.length.is_some_and(|length| length > 0.0) && !is_free {
        let why =
            if spring.across.is_some() { "its second point lies on the axis" } else { "its points coincide" };
        c.add(
            format!("{key}.points"),
            format!("the spring \"{}\" has no direction: {why}", spring.name),
            "move one of its points, give `length = 0`, or a `force` that vanishes there, as in a clearance",
        );
    }
}

fn torsion_spring_values(spring: &model::TorsionSpring, key: &str, c: &mut Checker) {
    c.not_negative(&format!("{key}.stiffness"), "the stiffness", spring.stiffness);
    c.not_negative(&format!("{key}.damping"), "the damping", spring.damping);
    c.finite(&format!("{key}.free_angle"), "the free angle", &[spring.free_angle]);
    direction(&format!("{key}.axis"), spring.axis, c);
    let what = torsion_named(&spring.name);
    not_with_itself((&what, &spring.between), key, c);
    acts((&what, key, "moment"), ([spring.stiffness, spring.damping], spring.moment.as_deref()), c);
    if let Err((problem, help)) = torsion_law(spring) {
        c.add(format!("{key}.moment"), problem, help);
    }
}

/// Springs of the model, or what is wrong with their ends.
pub(super) fn springs(
    model: &Model,
    (mesh, corners): (&Mesh, &Corners),
    coordinates: &Coordinates,
    issues: &mut Vec<Issue>,
) -> Vec<Spring> {
    let mut c = Checker::default();
    let size = extent(model, mesh, coordinates);
    let mut out = Vec::new();
    for (i, data) in model.springs.iter().enumerate() {
        let key = format!("springs[{i}]");
        let at = |side: usize| Some((format!("{key}.points[{side}]"), data.points[side]));
        let place = Place { model, mesh, coordinates, length: size, corners };
        let Some([first, second]) = ends(&place, (&key, &data.between), [at(0), at(1)], &mut c) else {
            continue;
        };
        let points = data.points.map(Vec3::from);
        // Invalid formulas are mistakes of the keys. The length is that of the nodal vectors, so that a spring that is not stressed in the reference
        // configuration has no force there, not even by round-off.
        let mut add = |spring: Spring| {
            let length = spring.length(|v| Vec3::from(coordinates.reference[v]));
            out.extend(law(data, length).ok().map(|law| spring.with_law(law)));
        };
        let unstressed = SpringLaw::linear([0.0; 2], 0.0);
        let Some(axis) = data.across else {
            add(Spring::new([&first.point(&points[0]), &second.point(&points[1])], unstressed));
            continue;
        };
        let sides = [first, second];
        match Across::new(&sides, [&points[0], &points[1]], &axis.into()) {
            Some(across) => add(Spring::across(across, sides.contains(&End::Ground), unstressed)),
            None => c.add(
                format!("{key}.across"),
                format!("the first side of the spring \"{}\" has no axes, or its second one is a point inside an element", data.name),
                "connect a rigid body, a node of a beam or the ground with another one or with a node",
            ),
        }
    }
    issues.append(&mut c.issues);
    out
}

/// Torsion springs of the model, or what is wrong with their ends.
pub(super) fn torsion_springs(
    model: &Model,
    (mesh, corners): (&Mesh, &Corners),
    coordinates: &Coordinates,
    issues: &mut Vec<Issue>,
) -> Vec<TorsionSpring> {
    let mut c = Checker::default();
    let place = Place { model, mesh, coordinates, length: extent(model, mesh, coordinates), corners };
    let mut out = Vec::new();
    for (i, data) in model.torsion_springs.iter().enumerate() {
        let key = format!("torsion_springs[{i}]");
        let Some(ends) = ends(&place, (&key, &data.between), [None, None], &mut c) else { continue };
        match RelativeAngle::new(&ends, &data.axis.into()) {
            Some(angle) => {
                let with = |law| TorsionSpring { name: data.name.clone(), angle, law };
                out.extend(torsion_law(data).ok().map(with));
            }
            None => c.add(
                format!("{key}.between"),
                format!(
                    "the torsion spring \"{}\" needs an axis on both sides, but a point mass or a node has none",
                    data.name
                ),
                "connect rigid bodies, nodes of beams and the ground",
            ),
        }
    }
    issues.append(&mut c.issues);
    out
}
