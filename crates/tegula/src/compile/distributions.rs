//! Checks of the distributions of loads: formulas in the coordinates that multiply their values.

use super::adaptive_integrals::{over_edge, over_element};
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
                "look for a division by a number that becomes 0 there; a formula that varies very fast needs smaller elements",
            ),
        }
    }
}

/// Why a distribution has no resultant.
enum WithoutIntegral {
    /// It has no finite value at a place.
    Undefined(Vec3),
    /// Its integral does not converge at a place.
    Divergent(Vec3),
}

/// Integral of the absolute value over an edge or element below which it plays no part in that over the set: the far flank of a narrow peak needs not
/// be resolved.
const NEGLIGIBLE: f64 = 1e-9;

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
    let edges = if load.part() == LoadedPart::Edges { mesh.edges_on(load.on()) } else { None };
    let quads = if load.part() == LoadedPart::Quads { mesh.quads_on(load.on()) } else { None };
    let of_edge = |edge: [u32; 2]| {
        let ends = edge.map(place);
        (vec![ends], over_edge(ends, value).map(|whole| (whole.size, whole.divergent_at)))
    };
    let of_quad = |quad: u32| {
        let x = mesh.quads[quad as usize].map(place);
        let whole = over_element(&x, value).map(|whole| (whole.size, whole.divergent_at));
        (vec![[x[0], x[2]], [x[1], x[3]]], whole)
    };
    let parts = edges.into_iter().flatten().map(of_edge).chain(quads.into_iter().flatten().map(of_quad));
    let (mut total, mut divergent) = (0.0, Vec::new());
    for (lines, whole) in parts {
        let pole = || lines.iter().find_map(|ends| formula.pole(*ends));
        // Steep flanks of finite height look like poles: the integral decides.
        if let Some(at) = pole().filter(without_value) {
            return Some(WithoutIntegral::Undefined(at));
        }
        match whole {
            Err(at) => return Some(WithoutIntegral::Undefined(at)),
            Ok((size, at)) => {
                total += size;
                // The search along a line finds the place of a pole more exactly.
                divergent.extend(at.map(|at| (size, pole().unwrap_or(at))));
            }
        }
    }
    let counts = |(size, at): (f64, Vec3)| (size > NEGLIGIBLE * total).then_some(at);
    divergent.into_iter().find_map(counts).map(WithoutIntegral::Divergent)
}
