//! Checks of the distributions of loads: formulas in the coordinates that multiply their values.

use super::adaptive_integrals::{WithoutIntegral, over_edges, over_elements};
use crate::Vec3;
use crate::checker::Checker;
use crate::load::PlaceFormula;
use crate::mesh::Mesh;
use crate::model::loads::LoadedPart;
use crate::model::{Load, Model};

impl Checker {
    /// Reports a distribution of a load on a body, and one that has no value somewhere.
    pub(super) fn distribution(&mut self, model: &Model, mesh: &Mesh, (key, load): (&str, &Load)) {
        let Some(formula) = load.distribution().and_then(|text| PlaceFormula::read(text).ok()) else {
            return;
        };
        if model.bodies.iter().any(|body| body.name == load.on()) {
            return self.add(key, "a load on a body acts in one point", "leave the distribution out");
        }
        match without_integral(mesh, load, &formula) {
            None => {}
            Some(WithoutIntegral::Undefined(place)) => self.add(
                key,
                format!(
                    "the distribution has no value, or grows beyond all bounds, at {}",
                    crate::mesh::show(place)
                ),
                "look for a division by 0, a root or logarithm of a negative number, and numbers above 1e308",
            ),
            Some(WithoutIntegral::Divergent(place)) => self.add(
                key,
                format!("the integral of the distribution does not converge at {}", crate::mesh::show(place)),
                "look for a division by a number that becomes 0 there, and for features that are far smaller than the elements",
            ),
        }
    }
}

/// Why the distribution of a load has no resultant: a node of its set, or a place between two ends of an edge or on a diagonal of an element, at
/// which it has no value, or a place at which its integral does not converge.
fn without_integral(mesh: &Mesh, load: &Load, formula: &PlaceFormula) -> Option<WithoutIntegral> {
    let place = |node: u32| mesh.positions[node as usize];
    let value = |x: &Vec3| formula.value(x);
    let without_value = |x: &Vec3| !value(x).is_finite();
    let nodes = mesh.nodes_on(load.on()).unwrap_or_default();
    if let Some(at) = nodes.into_iter().map(place).find(without_value) {
        return Some(WithoutIntegral::Undefined(at));
    }
    let corners_of = |quad: u32| mesh.quads[quad as usize].map(place);
    let edges: Vec<[Vec3; 2]> = match load.part() {
        LoadedPart::Edges => {
            mesh.edges_on(load.on()).into_iter().flatten().map(|edge| edge.map(place)).collect()
        }
        _ => Vec::new(),
    };
    let elements: Vec<[Vec3; 4]> = match load.part() {
        LoadedPart::Quads => mesh.quads_on(load.on()).into_iter().flatten().map(corners_of).collect(),
        _ => Vec::new(),
    };
    // Steep flanks of finite height look like poles: the integral decides.
    let diagonals = elements.iter().flat_map(|x| [[x[0], x[2]], [x[1], x[3]]]);
    let mut lines = edges.iter().copied().chain(diagonals);
    if let Some(at) = lines.find_map(|ends| formula.pole(ends).filter(without_value)) {
        return Some(WithoutIntegral::Undefined(at));
    }
    over_edges(&edges, value).err().or_else(|| over_elements(&elements, value).err())
}
