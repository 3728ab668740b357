//! Bushings: from the model to points, axes and matrices of the system.

use nalgebra::{Matrix6, Vector6};

use super::bodies::{extent, names, not_with_itself};
use super::body_inertia::{frame, two_directions};
use super::inner_point::Corners;
use super::place::{Place, ends};
use crate::checker::Checker;
use crate::constraint::joints::End;
use crate::constraint::{Bushing, LARGEST_ROTATION};
use crate::mesh::Mesh;
use crate::model::{self, Model};
use crate::norm::larger;
use crate::system::Coordinates;
use crate::{Issue, Vec3};

/// Relative size of round-off in the entries of a matrix.
const SAME: f64 = 1e-9;

/// Mistakes in the values of bushings.
pub(super) fn keys(model: &Model, c: &mut Checker) {
    names(model.bushings.iter().map(|bushing| &bushing.name), "bushings", &[], c);
    for (i, bushing) in model.bushings.iter().enumerate() {
        let (key, what) = (format!("bushings[{i}]"), format!("the bushing \"{}\"", bushing.name));
        c.finite(&format!("{key}.at"), "the point", &bushing.at);
        two_directions(bushing.axes, &key, c);
        not_with_itself((&what, &bushing.between), &key, c);
        let before = c.issues.len();
        for (name, diagonal, rows) in [
            ("stiffness", bushing.stiffness, bushing.stiffness_matrix),
            ("damping", bushing.damping, bushing.damping_matrix),
        ] {
            matrix_values((&key, &what, name), diagonal, rows, c);
        }
        c.finite(&format!("{key}.free"), "the free displacement or rotation", &bushing.free);
        // The rest needs matrices and a free deformation that are numbers.
        if c.issues.len() == before {
            effect(bushing, (&key, &what), c);
        }
    }
}

/// Mistakes in a matrix that is given by its diagonal or by its rows.
fn matrix_values(
    (key, what, name): (&str, &str, &str),
    diagonal: Option<[f64; 6]>,
    rows: Option<[[f64; 6]; 6]>,
    c: &mut Checker,
) {
    if let Some(diagonal) = diagonal {
        for (i, value) in diagonal.into_iter().enumerate() {
            c.not_negative(&format!("{key}.{name}[{i}]"), &format!("the {name}"), value);
        }
    }
    let Some(rows) = rows else { return };
    let key = format!("{key}.{name}_matrix");
    if diagonal.is_some() {
        c.add(&key, format!("{what} has `{name}` and `{name}_matrix`"), "give one of them");
    }
    let before = c.issues.len();
    c.finite(&key, &format!("the {name}"), rows.as_flattened());
    if c.issues.len() > before {
        return;
    }
    let pairs = || (0..6).flat_map(|i| (0..i).map(move |j| (i, j)));
    let differs = |&(i, j): &(usize, usize)| {
        let [a, b] = [rows[i][j], rows[j][i]];
        (a - b).abs() > SAME * larger(a.abs(), b.abs())
    };
    if let Some((i, j)) = pairs().find(differs) {
        c.add(
            format!("{key}[{i}][{j}]"),
            format!(
                "the {name} matrix of {what} is not symmetric: {} in row {}, column {}, but {} in row {}, column {}",
                rows[i][j],
                i + 1,
                j + 1,
                rows[j][i],
                j + 1,
                i + 1
            ),
            "give a symmetric matrix: only then the forces have a potential, or the damper takes energy in every motion",
        );
    } else if !is_semidefinite(&rows) {
        c.add(
            &key,
            format!("the {name} matrix of {what} has a negative eigenvalue: in some motion it would supply energy"),
            "make the entries off the diagonal smaller, `|k_ij| ≤ √(k_ii k_jj)` at least, or correct the order of the six motions",
        );
    }
}

/// Whether a symmetric matrix has no negative eigenvalue but for round-off, whatever the units of displacements and rotations.
fn is_semidefinite(rows: &[[f64; 6]; 6]) -> bool {
    let size: [f64; 6] = std::array::from_fn(|i| rows[i][i].sqrt());
    let coupled_to_nothing =
        |i: usize| size[i] == 0.0 && rows.iter().zip(&rows[i]).any(|(row, x)| row[i] != 0.0 || *x != 0.0);
    if size.iter().any(|x| x.is_nan()) || (0..6).any(coupled_to_nothing) {
        return false;
    }
    let scaled = Matrix6::from_fn(|i, j| {
        let scale = size[i] * size[j];
        if scale > 0.0 { 0.5 * (rows[i][j] + rows[j][i]) / scale } else { 0.0 }
    });
    scaled.symmetric_eigenvalues().iter().all(|x| *x >= -SAME)
}

/// Bushings that do nothing, and free deformations that they cannot have.
fn effect(bushing: &model::Bushing, (key, what): (&str, &str), c: &mut Checker) {
    let (stiffness, free) = (bushing.stiffness(), Vector6::from(bushing.free));
    let zero = Matrix6::zeros();
    if stiffness == zero && bushing.damping() == zero {
        c.add(
            key,
            format!("{what} does nothing"),
            "give `stiffness` or `stiffness_matrix`, `damping` or `damping_matrix`, or both",
        );
    } else if free != Vector6::zeros() && stiffness * free == Vector6::zeros() {
        c.add(
            format!("{key}.free"),
            format!("{what} has no stiffness against its free displacement or rotation, which has no effect"),
            "give a stiffness in its direction, or leave `free` out",
        );
    }
    let angle = free.fixed_rows::<3>(3).norm();
    if angle > LARGEST_ROTATION {
        c.add(
            format!("{key}.free"),
            format!("the free rotation of {what} is {angle}°, and a bushing rotates by {LARGEST_ROTATION}° at most"),
            "give a smaller rotation, or use a joint with a torsion spring",
        );
    }
}

/// Bushings of the model, or what is wrong with their ends.
pub(super) fn bushings(
    model: &Model,
    (mesh, corners): (&Mesh, &Corners),
    coordinates: &Coordinates,
    issues: &mut Vec<Issue>,
) -> Vec<Bushing> {
    let mut c = Checker::default();
    let place = Place { model, mesh, coordinates, length: extent(model, mesh, coordinates), corners };
    let mut out = Vec::new();
    for (i, data) in model.bushings.iter().enumerate() {
        let key = format!("bushings[{i}]");
        let at = || Some((format!("{key}.at"), data.at));
        let Some(ends) = ends(&place, (&key, &data.between), [at(), at()], &mut c) else { continue };
        let mut free = Vector6::from(data.free);
        free.fixed_rows_mut::<3>(3).apply(|angle| *angle = angle.to_radians());
        let (point, axes) = (Vec3::from(data.at), frame(data.axes));
        let matrices = [data.stiffness(), data.damping()];
        match Bushing::new(&data.name, &ends, (&point, &axes), matrices, free) {
            Some(bushing) => out.push(bushing),
            None => lacks_axes(data, &ends, &key, &mut c),
        }
    }
    issues.append(&mut c.issues);
    out
}

/// A bushing between ends without the axes that it needs.
fn lacks_axes(data: &model::Bushing, ends: &[End; 2], key: &str, c: &mut Checker) {
    let [first, second] = &data.between;
    if matches!(ends[0], End::Point { .. } | End::Interior { .. }) {
        c.add(
            format!("{key}.between[0]"),
            format!(
                "the axes of the bushing \"{}\" move with its first side, but \"{first}\" is a point mass or a node, which has none",
                data.name
            ),
            "name a body, a node of a beam or the ground first, and the point mass or node second",
        );
    } else {
        c.add(
            format!("{key}.between[1]"),
            format!(
                "the bushing \"{}\" resists rotations, but \"{second}\" is a point mass or a node, which has no axes",
                data.name
            ),
            "leave the stiffness and damping of rotations zero, or attach the nodes to a body",
        );
    }
}
