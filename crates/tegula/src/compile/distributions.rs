//! Checks of the distributions of loads: formulas in the coordinates that multiply their values.

use crate::Vec3;
use crate::checker::Checker;
use crate::element::geometry::{weighted_nodal_areas, weighted_nodal_lengths};
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
        let Some(place) = undefined_on(mesh, load, &formula) else { return };
        self.add(
            key,
            format!(
                "the distribution has no value, or grows beyond all bounds, at {}",
                crate::mesh::show(place)
            ),
            "look for a division by 0, a root or logarithm of a negative number, and numbers above 1e308",
        );
    }
}

/// A place at which the distribution of a load has no value: a node of its set, a place between two ends of an edge or on a diagonal of an element,
/// which each line through the element crosses, or one at which it is integrated.
fn undefined_on(mesh: &Mesh, load: &Load, formula: &PlaceFormula) -> Option<Vec3> {
    let place = |node: u32| mesh.positions[node as usize];
    let without_value = |x: &Vec3| !formula.value(x).is_finite();
    let nodes = mesh.nodes_on(load.on()).unwrap_or_default();
    if let Some(at) = nodes.into_iter().map(place).find(without_value) {
        return Some(at);
    }
    let on_edge = |edge: [u32; 2]| {
        let ends = edge.map(place);
        let whole = weighted_nodal_lengths(ends, |x| formula.value(x)).iter().all(|x| x.is_finite());
        formula.pole(ends).or_else(|| (!whole).then(|| (ends[0] + ends[1]) * 0.5))
    };
    let on_quad = |quad: u32| {
        let x = mesh.quads[quad as usize].map(place);
        let whole = weighted_nodal_areas(&x, |x| formula.value(x)).iter().all(|x| x.is_finite());
        let poles = [[x[0], x[2]], [x[1], x[3]]].into_iter().find_map(|ends| formula.pole(ends));
        poles.or_else(|| if whole { None } else { mesh.centre(quad) })
    };
    match load.part() {
        LoadedPart::Edges => mesh.edges_on(load.on()).into_iter().flatten().find_map(on_edge),
        LoadedPart::Quads => mesh.quads_on(load.on()).into_iter().flatten().find_map(on_quad),
        LoadedPart::Nodes | LoadedPart::Model => None,
    }
}
