//! Layers of solids of which a shell is made: their thickness is that of the section, and their edges through the thickness are normal to the middle surface.
//!
//! A shell has its thickness along the normal: the length of an oblique edge is more than that, and bending would be too stiff by the third power of their ratio.

use super::factors::Factors;
use crate::Vec3;
use crate::checker::Checker;
use crate::mesh::Mesh;
use crate::mesh::middle_surface::{FOLD, MiddleSurface};
use crate::model::Section;
use std::collections::BTreeSet;

/// Part by which the thickness of a mesh of solids may differ from that of its section.
const OTHER_THICKNESS: f64 = 1e-3;

/// Refuses a mesh of solids whose thickness is other than that of a section on its quads, or whose edges through the thickness cannot be those of a shell.
pub(super) fn check(
    surface: &MiddleSurface<'_>,
    (number, section): (usize, &Section),
    quads: &[u32],
    c: &mut Checker,
) {
    let MiddleSurface { mesh, through, thicknesses, .. } = surface;
    let key = format!("sections[{number}].thickness");
    if let Some((angle, nodes)) = surface.sharpest_fold(quads) {
        return refuse_fold(mesh, &key, (angle, nodes), c);
    }
    refuse_oblique(mesh, &key, (surface, through), quads, c);
    refuse_other_thickness(mesh, (&key, section), thicknesses, quads, c);
}

fn refuse_fold(mesh: &Mesh, key: &str, (angle, nodes): (f64, [u32; 2]), c: &mut Checker) {
    let [first, second] = nodes.map(|node| mesh.node_label(node));
    c.add(
        key,
        format!("elements of the layer of solids meet at {angle:.1}° at the edge from node {first} to {second}"),
        format!(
            "give sheets that meet at {FOLD}° or more as quadrilaterals, which have a director for each sheet there; take more elements where the surface is curved"
        ),
    );
}

fn refuse_oblique(
    mesh: &Mesh,
    key: &str,
    (surface, edges): (&MiddleSurface<'_>, &[[Vec3; 4]]),
    quads: &[u32],
    c: &mut Checker,
) {
    let lean = |(&q, corner): (&u32, usize)| {
        let node = mesh.quads.get(q as usize)?[corner];
        let edge = edges.get(q as usize)?[corner];
        let lean = surface.lean(node, &edge)?;
        Some((lean, q, node))
    };
    let found = quads.iter().flat_map(|q| (0..4).map(move |corner| (q, corner))).filter_map(lean);
    let Some((lean, quad, node)) = found.max_by(|a, b| a.0.total_cmp(&b.0)) else { return };
    c.add(
        key,
        format!(
            "the edges of the mesh through the thickness lean by up to {lean:.1}° from the normal of the shell, in element {} at node {}",
            mesh.quad_label(quad as usize),
            mesh.node_label(node)
        ),
        "make them normal to the middle surface: a shell has its thickness along the normal, which is less than the length of oblique edges",
    );
}

/// The thickness of a section at a node, times its distribution where it has one, is that of the mesh. A value for each element is compared with the mean of the
/// nodes.
fn refuse_other_thickness(
    mesh: &Mesh,
    (key, section): (&str, &Section),
    thicknesses: &[f64],
    quads: &[u32],
    c: &mut Checker,
) {
    let factors = section.thickness_distribution.as_ref().map(|of| Factors::of(of, mesh));
    let whole = section.whole_thickness();
    let by_quad = factors.as_ref().and_then(|factors| factors.as_ref()?.by_quad());
    let difference = |quad: u32, node: u32| -> Option<(f64, u32, [f64; 2])> {
        let of_node = |node: u32| thicknesses.get(node as usize).copied();
        let [given, of_mesh] = match (&factors, by_quad) {
            (None, _) => [whole, of_node(node)?],
            (Some(_), Some(values)) => {
                let around = mesh.quads[quad as usize].map(|n| of_node(n).unwrap_or(f64::NAN));
                [whole * values.get(quad as usize)?, around.iter().sum::<f64>() / 4.0]
            }
            (Some(factors), None) => [whole * factors.as_ref()?.at_node(mesh, node)?, of_node(node)?],
        };
        Some(((of_mesh / given - 1.0).abs(), node, [given, of_mesh]))
    };
    let nodes = quads.iter().flat_map(|&q| mesh.quads[q as usize].map(|node| (q, node)));
    let off: Vec<_> = nodes
        .filter_map(|(quad, node)| difference(quad, node))
        .filter(|(difference, ..)| *difference > OTHER_THICKNESS)
        .collect();
    let Some((_, node, [given, of_mesh])) = off.iter().max_by(|a, b| a.0.total_cmp(&b.0)) else { return };
    let number = off.iter().map(|(_, node, _)| node).collect::<BTreeSet<_>>().len();
    let at = if by_quad.is_some() { "around" } else { "at" };
    c.add(
        key,
        format!(
            "the section is {given} thick, but the mesh is {of_mesh:.6} thick {at} node {}, at {number} node(s) off by more than {} %",
            mesh.node_label(*node),
            100.0 * OTHER_THICKNESS
        ),
        "give the thickness of the mesh; where it varies, by `thickness_distribution` or by sections of their own",
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generators::generate;
    use crate::model::MeshSource;

    fn refused(mesh: &Mesh) -> Option<String> {
        let mut c = Checker::default();
        let quads: Vec<u32> = (0..mesh.quads.len() as u32).collect();
        let section: Section =
            serde_json::from_str(r#"{ "material": "steel", "thickness": 0.1, "element": "ems" }"#).unwrap();
        check(&MiddleSurface::of(mesh).unwrap(), (0, &section), &quads, &mut c);
        c.issues.first().map(ToString::to_string)
    }

    fn layer(source: &str, edge: impl Fn(&Vec3) -> Vec3) -> Mesh {
        let source: MeshSource = serde_json::from_str(source).unwrap();
        let mesh = generate(&source).unwrap();
        let edges = mesh.quads.iter().map(|quad| quad.map(|n| edge(&mesh.positions[n as usize]).normalize()));
        Mesh {
            normals: Some(edges.collect()),
            thickness: Some(vec![0.1; mesh.positions.len()]),
            ..mesh.clone()
        }
    }

    /// Axis of cylinders.
    const AXIS: Vec3 = Vec3::new(0.0, 1.0, 0.0);
    const PLATE: &str = r#"{ "type": "plate", "size": [4.0, 1.0], "grid": { "elements": [4, 2] } }"#;
    const QUARTER: &str = r#"{ "type": "cylinder", "radius": 1.0, "length": 1.0, "angles": [0.0, 90.0], "grid": { "elements": [9, 2] } }"#;

    #[test]
    fn edges_that_lean_more_than_the_surface_turns_are_refused() {
        assert_eq!(refused(&layer(PLATE, |_| Vec3::z())), None);
        assert_eq!(refused(&layer(PLATE, |_| Vec3::new(0.04, 0.0, 1.0))), None);
        let told = refused(&layer(PLATE, |_| Vec3::new(0.5, 0.0, 1.0))).unwrap();
        assert!(told.contains("lean by up to 26.6°"), "{told}");
    }

    /// Radial edges are 5° from the normals of facets of 10°, also at the rims.
    #[test]
    fn edges_normal_to_a_coarse_curved_surface_are_taken() {
        let of_mesh = generate(&serde_json::from_str(QUARTER).unwrap()).unwrap();
        let exact = of_mesh.normals.clone().unwrap();
        let thick =
            Mesh { thickness: Some(vec![0.1; of_mesh.positions.len()]), normals: Some(exact), ..of_mesh };
        assert_eq!(refused(&thick), None);
    }

    /// Thicknesses that fall by a third along a plate, in the section by a formula.
    #[test]
    fn thicknesses_times_their_distribution_are_those_of_the_mesh() {
        let mut mesh = layer(PLATE, |_| Vec3::z());
        let refused = |mesh: &Mesh, distribution: &str| {
            let mut c = Checker::default();
            let mut section: Section =
                serde_json::from_str(r#"{ "material": "steel", "thickness": 0.1, "element": "ems" }"#)
                    .unwrap();
            section.thickness_distribution = Some(serde_json::from_str(distribution).unwrap());
            let quads: Vec<u32> = (0..mesh.quads.len() as u32).collect();
            check(&MiddleSurface::of(mesh).unwrap(), (0, &section), &quads, &mut c);
            c.issues.first().map(ToString::to_string)
        };
        let told = refused(&mesh, r#""1 - x/12""#).unwrap();
        assert!(told.contains("0.100000 thick at node"), "{told}");
        mesh.thickness = Some(mesh.positions.iter().map(|x| 0.1 - x.x / 120.0).collect());
        assert_eq!(refused(&mesh, r#""1 - x/12""#), None);
        assert!(refused(&mesh, r#""1 - x/11""#).is_some());
    }

    /// Radial edges that lean along the axis, where nothing is curved.
    #[test]
    fn edges_that_lean_along_the_axis_of_a_coarse_cylinder_are_refused() {
        let radial = |x: &Vec3, axial: f64| {
            let radius = x.cross(&AXIS).cross(&AXIS) * -1.0;
            radius.normalize() + AXIS * axial
        };
        let coarse = QUARTER.replace("[9, 2]", "[4, 3]");
        assert_eq!(refused(&layer(&coarse, |x| radial(x, 0.0))), None);
        assert_eq!(refused(&layer(&coarse, |x| radial(x, 0.03))), None);
        let told = refused(&layer(&coarse, |x| radial(x, 0.12))).unwrap();
        assert!(told.contains("lean by up to"), "{told}");
    }

    /// Two facets of 28° with all edges in one direction: at the rims the edges lean to the side of the other facet.
    #[test]
    fn edges_of_one_direction_on_two_facets_are_refused() {
        let arc = QUARTER.replace("90.0", "56.0").replace("[9, 2]", "[2, 2]");
        assert_eq!(refused(&layer(&arc, |x| x.cross(&AXIS).cross(&AXIS) * -1.0)), None);
        let (sine, cosine) = 28.0_f64.to_radians().sin_cos();
        let told = refused(&layer(&arc, |_| Vec3::new(sine, 0.0, cosine))).unwrap();
        assert!(told.contains("lean by up to 14.0°"), "{told}");
    }

    /// Domes of which each is a square drawn out to a disc: at its corners the edges of the elements lie along the rim.
    #[test]
    fn radial_edges_of_domes_are_taken() {
        for (elements, opening) in [(4, 30.0), (4, 60.0), (8, 40.0), (16, 60.0)] {
            let square = PLATE
                .replace("[4.0, 1.0]", "[2.0, 2.0]")
                .replace("[4, 2]", &format!("[{elements}, {elements}]"));
            let mut mesh = layer(&square, |_| Vec3::z());
            let on_sphere = |x: &Vec3| {
                let (u, v) = (x.x - 1.0, x.y - 1.0);
                let disc = [u * (1.0 - 0.5 * v * v).sqrt(), v * (1.0 - 0.5 * u * u).sqrt()];
                let radius = disc[0].hypot(disc[1]);
                let angle = opening * radius / 180.0 * std::f64::consts::PI;
                let around = if radius > 0.0 { angle.sin() / radius } else { 0.0 };
                Vec3::new(disc[0] * around, disc[1] * around, angle.cos())
            };
            mesh.positions = mesh.positions.iter().map(on_sphere).collect();
            let radial = mesh.quads.iter().map(|quad| quad.map(|n| mesh.positions[n as usize]));
            mesh.normals = Some(radial.collect());
            assert_eq!(refused(&mesh), None, "{elements} elements, {opening}°");
            mesh.normals = Some(vec![[Vec3::z(); 4]; mesh.quads.len()]);
            assert!(refused(&mesh).is_some(), "{elements} elements, {opening}°");
        }
    }

    /// A cone whose edges are radial instead of normal.
    #[test]
    fn radial_edges_of_a_cone_are_refused() {
        let half_angle = 12.0_f64.to_radians();
        let mut mesh = layer(QUARTER, |x| x.cross(&AXIS).cross(&AXIS) * -1.0);
        let normals = mesh.normals.take().unwrap();
        let narrowed = |x: &Vec3| {
            let along = AXIS * x.dot(&AXIS);
            along + (x - along) * (1.0 - half_angle.tan() * x.dot(&AXIS))
        };
        mesh.positions = mesh.positions.iter().map(narrowed).collect();
        let tilted = normals.iter().map(|quad| quad.map(|n| (n + AXIS * half_angle.tan()).normalize()));
        let right = Mesh { normals: Some(tilted.collect()), ..mesh.clone() };
        assert_eq!(refused(&right), None);
        assert!(refused(&Mesh { normals: Some(normals), ..mesh }).is_some());
    }

    /// Two halves of a strip that meet at an angle, with edges on its bisector.
    #[test]
    fn sheets_that_meet_at_an_edge_are_refused() {
        let folded = |degrees: f64| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let mesh = generate(&serde_json::from_str(PLATE).unwrap()).unwrap();
            let bend = |x: &Vec3| {
                let beyond = if x.x > 2.0 { x.x - 2.0 } else { 0.0 };
                Vec3::new(x.x - beyond + beyond * cosine, x.y, beyond * sine)
            };
            let edge = |x: &Vec3| match x.x.total_cmp(&2.0) {
                std::cmp::Ordering::Less => Vec3::z(),
                std::cmp::Ordering::Equal => Vec3::new(-sine, 0.0, 1.0 + cosine).normalize(),
                std::cmp::Ordering::Greater => Vec3::new(-sine, 0.0, cosine),
            };
            let normals = mesh.quads.iter().map(|q| q.map(|n| edge(&mesh.positions[n as usize])));
            Mesh {
                normals: Some(normals.collect()),
                thickness: Some(vec![0.1; mesh.positions.len()]),
                positions: mesh.positions.iter().map(bend).collect(),
                ..mesh
            }
        };
        assert_eq!(refused(&folded(25.0)), None);
        let told = refused(&folded(90.0)).unwrap();
        assert!(told.contains("meet at 90.0°") && told.contains("as quadrilaterals"), "{told}");
    }
}
