//! Elastic foundations of sets, with the weights that consistent masses of 1 per node, length or area have.

use super::actions::{consistent_edge, consistent_quad};
use crate::analysis::modal;
use crate::checker::Checker;
use crate::constraint::FoundationElement;
use crate::element::ShellGeometry;
use crate::mesh::Mesh;
use crate::model::{Foundation, Model};
use crate::system::{Coordinates, System};
use crate::{Issue, Mat3, Vec3};

/// Mistakes in the values of foundations.
pub(super) fn keys(model: &Model, c: &mut Checker) {
    for (i, foundation) in model.foundations.iter().enumerate() {
        let key = format!("foundations[{i}]");
        let (stiffness, normal) = foundation.stiffness();
        stiffness.iter().for_each(|k| c.not_negative(&format!("{key}.stiffness"), "the stiffness", *k));
        c.not_negative(&format!("{key}.normal"), "the stiffness", normal);
        c.not_negative(
            &format!("{key}.retardation_time"),
            "the retardation time",
            foundation.retardation_time(),
        );
        if stiffness == [0.0; 3] && normal == 0.0 {
            let message = format!("the foundation of \"{}\" does nothing", foundation.on());
            c.add(format!("{key}.stiffness"), message, "give a stiffness that is not zero");
        }
    }
}

/// Mistakes in the sets of foundations.
pub(super) fn sets(model: &Model, mesh: &Mesh, c: &mut Checker) {
    for (i, foundation) in model.foundations.iter().enumerate() {
        let key = format!("foundations[{i}].on");
        match foundation {
            Foundation::Point(f) => drop(c.set(mesh, key, &f.on, "nodes", Mesh::nodes_on)),
            Foundation::Edge(f) => drop(c.set(mesh, key, &f.on, "edges", Mesh::edges_on)),
            Foundation::Area(f) => drop(c.set(mesh, key, &f.on, "quads", Mesh::quads_on)),
        }
    }
}

/// Rigid motions that foundations and supports leave free in a static model with foundations or beams, but without joints and springs.
pub(super) fn free_motions(model: &Model, system: &System) -> Option<Issue> {
    let neither = model.foundations.is_empty() && system.beams.is_empty();
    if neither || model.has_springs() || system.constraints() > 0 {
        return None;
    }
    let free = modal::rigid_motions(system);
    (free > 0).then(|| {
        let (key, what, help) = if model.foundations.is_empty() {
            ("joints", "nothing prevents", "hold the beams by joints")
        } else {
            (
                "foundations",
                "foundations and supports do not prevent",
                "give the foundation a stiffness along further axes, or support the model so that it cannot move as a whole",
            )
        };
        Issue::new(key, format!("{what} {free} rigid motion(s) of the model"), help)
    })
}

/// Elements of all foundations.
pub(super) fn elements(model: &Model, mesh: &Mesh, coordinates: &Coordinates) -> Vec<FoundationElement> {
    let mut out = Vec::new();
    for foundation in &model.foundations {
        let (axes, normal) = foundation.stiffness();
        let along_axes = Mat3::from_diagonal(&Vec3::from(axes));
        let retardation_time = foundation.retardation_time() + model.damping.stiffness;
        let mut add = |nodes: &[u32], weights: Vec<f64>, stiffness: Mat3| {
            let vectors = nodes.iter().map(|&node| coordinates.position_of[node as usize]).collect();
            out.push(FoundationElement { vectors, weights, stiffness, retardation_time });
        };
        match foundation {
            Foundation::Point(f) => {
                for node in mesh.nodes_on(&f.on).unwrap_or_default() {
                    add(&[node], vec![1.0], along_axes);
                }
            }
            Foundation::Edge(f) => {
                for edge in mesh.edges_on(&f.on).unwrap_or_default() {
                    add(&edge, consistent_edge(mesh, edge).into(), along_axes);
                }
            }
            Foundation::Area(f) => {
                for quad in mesh.quads_on(&f.on).unwrap_or_default() {
                    let nodes = mesh.quads[quad as usize];
                    let places = nodes.map(|node| mesh.positions[node as usize]);
                    let across = (places[2] - places[0]).cross(&(places[3] - places[1])).normalize();
                    let geometry = ShellGeometry::new(places, [Vec3::z(); 4]);
                    let stiffness = along_axes + across * across.transpose() * normal;
                    add(&nodes, consistent_quad(&geometry).into(), stiffness);
                }
            }
        }
    }
    out
}
