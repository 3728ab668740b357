//! Meshes of plates, cylinders, rings, spheres and folded sheets.
//!
//! All map a grid of parameters (u, v) to a surface, know its exact normals
//! r,u × r,v, and name the same parts:
//!
//! ```text
//!          v_max
//!        +---+---+        node sets and edge sets u_min, u_max, v_min, v_max,
//!        | 2 | 3 |        node sets u_min_v_min, …, middle, and the user's points
//!  u_min +---+---+ u_max
//!   v ↑  | 0 | 1 |        nodes and elements are numbered u fastest
//!     |  +---+---+
//!     +--→ u  v_min
//! ```
//!
//! Full turns of cylinders and spheres and closed polylines join their ends: there
//! `u_min`, `u_max` and the corners do not exist.

use super::Mesh;
use super::arrays;
use super::grid::{Lines, build};
use super::input::{Input, TINY};
use super::polyline::extrusion;
use super::surfaces::{Annulus, Cylinder, Plate, Sphere, Surface};
use crate::model::{AnnulusMesh, CylinderMesh, Grid, MeshSource, PlateMesh, SphereMesh};
use crate::{Error, Result};

/// Generates the mesh that `source` describes.
///
/// A plate whose axes are not at right angles becomes a parallelogram. A polyline
/// with more segments than elements gets one element a segment.
///
/// # Errors
/// Everything wrong with the numbers of `source`, all at once, under the keys of the model (`mesh.radius`, …); and Gmsh
/// files, which this library does not read.
pub fn generate(source: &MeshSource) -> Result<Mesh> {
    let mut input = Input::default();
    match source {
        MeshSource::Plate(source) => meshed(plate(source, &mut input), &source.grid, input),
        MeshSource::Cylinder(source) => meshed(cylinder(source, &mut input), &source.grid, input),
        MeshSource::Annulus(source) => meshed(annulus(source, &mut input), &source.grid, input),
        MeshSource::Sphere(source) => meshed(sphere(source, &mut input), &source.grid, input),
        MeshSource::Extrusion(source) => meshed(extrusion(source, &mut input), &source.grid, input),
        MeshSource::Arrays(source) => arrays::mesh(source),
        MeshSource::None => Ok(Mesh::default()),
        _ => Err(Error::model(
            "mesh.file",
            format!(
                "the mesh lies in the file `{}`, which is not generated but read",
                source.file().map_or("", |keys| &keys.file)
            ),
            "read it with the crate tegula-io, or run the model with the program",
        )),
    }
}

/// Meshes a checked surface and names the user's points.
fn meshed<S: Surface>(surface: Option<(S, Lines)>, grid: &Grid, input: Input) -> Result<Mesh> {
    let mut issues = input.issues;
    if let Some((surface, lines)) = surface.filter(|_| issues.is_empty()) {
        let mut mesh = build(&surface, &lines, grid.distortion, grid.seed);
        if grid.merge_coincident == Some(true)
            && let Err(collapsed) = mesh.merge_coincident_nodes()
        {
            issues.extend(collapsed);
        }
        issues.extend(mesh.name_points_of("mesh.grid.points", &grid.points));
        if issues.is_empty() {
            return Ok(mesh);
        }
    }
    Err(Error::Model(issues))
}

fn plate(source: &PlateMesh, input: &mut Input) -> Option<(Plate, Lines)> {
    input.grid(&source.grid);
    let origin = input.point("mesh.origin", "the origin", source.origin);
    let u = input.direction("mesh.u_axis", "the direction of u", source.u_axis);
    let v = input.direction("mesh.v_axis", "the direction of v", source.v_axis);
    input.size("mesh.size", "the length along u", source.size[0]);
    input.size("mesh.size", "the length along v", source.size[1]);
    let (origin, u, v) = (origin?, u?, v?);
    let normal = u.cross(&v);
    if normal.norm() <= TINY {
        input.wrong(
            "mesh.v_axis",
            format!("v_axis {:?} is parallel to u_axis {:?}", source.v_axis, source.u_axis),
            "turn one of them",
        );
    }
    let surface =
        Plate { origin, u_side: u * source.size[0], v_side: v * source.size[1], normal: normal.normalize() };
    Some((surface, graded(&source.grid, false, input)?))
}

fn cylinder(source: &CylinderMesh, input: &mut Input) -> Option<(Cylinder, Lines)> {
    input.grid(&source.grid);
    let center = input.point("mesh.center", "the centre", source.center);
    let axis = input.direction("mesh.axis", "the axis", source.axis);
    let start = input.direction("mesh.start", "the direction of the angle 0", source.start);
    input.size("mesh.radius", "the radius", source.radius);
    input.size("mesh.length", "the length", source.length);
    let full = input.angles("mesh.angles", "the angles", source.angles);
    let (center, axis, start) = (center?, axis?, start?);
    let radial = start - axis * axis.dot(&start);
    if radial.norm() <= TINY {
        input.wrong(
            "mesh.start",
            format!("start {:?} is parallel to the axis {:?}", source.start, source.axis),
            "give the radial direction of the angle 0",
        );
    }
    let lines = graded(&source.grid, full, input)?;
    input.element_span("angle (u)", source.angles, &lines.u);
    let CylinderMesh { radius, angles, length, .. } = *source;
    Some((Cylinder { center, radial: radial.normalize(), axis, radius, angles, length }, lines))
}

fn annulus(source: &AnnulusMesh, input: &mut Input) -> Option<(Annulus, Lines)> {
    input.grid(&source.grid);
    let center = input.point("mesh.center", "the centre", source.center);
    let [inner, outer] = source.radii;
    input.size("mesh.radii", "the inner radius", inner);
    input.size("mesh.radii", "the outer radius", outer);
    if inner > 0.0 && outer - inner <= TINY * outer {
        input.wrong(
            "mesh.radii",
            format!("the inner radius {inner:?} is not below the outer radius {outer:?}"),
            "give the inner radius first",
        );
    }
    input.angles("mesh.angles", "the angles", source.angles);
    let lines = graded(&source.grid, false, input)?;
    input.element_span("angle (v)", source.angles, &lines.v);
    Some((Annulus { center: center?, radii: source.radii, angles: source.angles }, lines))
}

fn sphere(source: &SphereMesh, input: &mut Input) -> Option<(Sphere, Lines)> {
    input.grid(&source.grid);
    let center = input.point("mesh.center", "the centre", source.center);
    input.size("mesh.radius", "the radius", source.radius);
    let full = input.angles("mesh.longitudes", "the longitudes", source.longitudes);
    input.angles("mesh.latitudes", "the latitudes", source.latitudes);
    for latitude in source.latitudes {
        if latitude.is_finite() && latitude.abs() >= 90.0 * (1.0 - TINY) {
            input.wrong(
                "mesh.latitudes",
                format!(
                    "the latitude {latitude:?} is at or beyond a pole, where the elements would be triangles"
                ),
                "keep latitudes between -90 and 90 degrees: leave a small hole, or read a mesh file",
            );
        }
    }
    let lines = graded(&source.grid, full, input)?;
    input.element_span("longitude (u)", source.longitudes, &lines.u);
    let SphereMesh { radius, longitudes, latitudes, .. } = *source;
    Some((Sphere { center: center?, radius, longitudes, latitudes }, lines))
}

/// Lines of a grid; `None` if an issue was found before.
fn graded(grid: &Grid, joined: bool, input: &Input) -> Option<Lines> {
    input.issues.is_empty().then(|| Lines::graded(grid.elements, grid.grading, joined))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
