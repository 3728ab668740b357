//! Edges through the thickness of a layer of solids that are not normal to its middle surface. A shell has its thickness along the normal: the length of an
//! oblique edge is more than that, and bending would be too stiff by the third power of their ratio.

use crate::Vec3;
use crate::checker::Checker;
use crate::mesh::Mesh;
use crate::norm::larger;

/// Angle of an edge to the normal (degrees) that is refused, beside the angle between neighbouring facets of a curved surface: 0.4 % of the bending stiffness.
const OBLIQUE: f64 = 3.0;

/// Refuses oblique edges of the quads of a section.
pub(super) fn refuse(mesh: &Mesh, key: &str, quads: &[u32], c: &mut Checker) {
    let (Some(edges), Some(_)) = (&mesh.normals, &mesh.thickness) else { return };
    let normals: Vec<Vec3> =
        (0..mesh.quads.len() as u32).map(|q| mesh.normal(q).unwrap_or_else(Vec3::zeros)).collect();
    let mut around: Vec<Vec<Vec3>> = vec![Vec::new(); mesh.positions.len()];
    for (quad, normal) in mesh.quads.iter().zip(&normals) {
        for node in quad {
            around.get_mut(*node as usize).into_iter().for_each(|here| here.push(*normal));
        }
    }
    let lean = |(&q, corner): (&u32, usize)| {
        let (normal, quad) = (normals.get(q as usize)?, mesh.quads.get(q as usize)?);
        let of_edge = angle(&edges.get(q as usize)?[corner], normal);
        let neighbours = quad.iter().filter_map(|n| around.get(*n as usize)).flatten();
        let turn = neighbours.map(|other| angle(other, normal)).fold(0.0, larger);
        (of_edge > OBLIQUE + turn).then_some((of_edge, q, quad[corner]))
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

/// Angle between unit vectors (degrees).
fn angle(a: &Vec3, b: &Vec3) -> f64 {
    a.cross(b).norm().atan2(a.dot(b)).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generators::generate;
    use crate::model::MeshSource;

    fn refused(mesh: &Mesh) -> Option<String> {
        let mut c = Checker::default();
        let quads: Vec<u32> = (0..mesh.quads.len() as u32).collect();
        refuse(mesh, "sections[0].thickness", &quads, &mut c);
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
}
