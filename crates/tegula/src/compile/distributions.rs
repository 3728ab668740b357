//! Checks of the distributions of loads, prescribed strains and thicknesses: formulas in the coordinates, and fields of the mesh.

use super::adaptive_integrals::{WithoutIntegral, over_edges, over_elements};
use super::factors::{Factors, means};
use crate::Vec3;
use crate::checker::Checker;
use crate::load::PlaceFormula;
use crate::mesh::{FieldValues, Mesh, show};
use crate::model::loads::LoadedPart;
use crate::model::{Distribution, ElementKind, Section};

/// Largest absolute value of a field.
const LARGEST: f64 = 1e100;

impl Checker {
    /// Reports a distribution of the thickness of a section that has no mean above 0 in an element.
    pub(super) fn thickness_distribution(
        &mut self,
        mesh: &Mesh,
        (number, section, distribution): (usize, &Section, &Distribution),
        quads: &[u32],
    ) {
        let key = format!("sections[{number}].thickness_distribution");
        if section.element == ElementKind::AncfFull {
            let help = "use `ems`, `mitc4`, `cm` or `solid-shell`, or sections of one thickness each";
            return self.add(key, "`ancf-full` has one thickness in each section", help);
        }
        let usual = section.whole_thickness();
        if !usual.is_normal() || usual < 0.0 {
            // It is refused on its own.
            return;
        }
        let before = self.issues.len();
        self.distribution(mesh, &key, (distribution, &section.on, LoadedPart::Quads));
        if self.issues.len() > before {
            return;
        }
        let help = "give a distribution that is above 0 on the whole set";
        let factors = Factors::of(distribution, mesh);
        let value = |node: u32| factors.as_ref().and_then(|factors| factors.at_node(mesh, node));
        let negative = |node: &u32| value(*node).is_some_and(|value| value < 0.0);
        if let Some(node) = mesh.nodes_on(&section.on).into_iter().flatten().find(negative) {
            let message = format!(
                "the distribution is {:.3e} at node {} at {}: no thickness is below 0",
                value(node).unwrap_or_default(),
                mesh.node_label(node),
                show(mesh.positions[node as usize])
            );
            return self.add(key, message, help);
        }
        let means = means(Some(distribution), mesh, quads);
        let thin = quads
            .iter()
            .zip(means)
            .find(|(_, mean)| !(mean * section.whole_thickness()).is_normal() || *mean < 0.0);
        if let Some((&quad, mean)) = thin {
            let centre =
                mesh.quads[quad as usize].iter().map(|n| mesh.positions[*n as usize]).sum::<Vec3>() * 0.25;
            let message = format!(
                "the mean of the distribution over element {} at {} is {mean:.3e}: the thickness must be above 0",
                mesh.quad_label(quad as usize),
                show(centre)
            );
            self.add(key, message, help);
        }
    }

    /// Reports a distribution, given with its set and the parts of it over which it is integrated, that has no value somewhere.
    pub(super) fn distribution(
        &mut self,
        mesh: &Mesh,
        key: &str,
        (distribution, on, part): (&Distribution, &str, LoadedPart),
    ) {
        let text = match distribution {
            Distribution::Formula(text) => text,
            Distribution::Field(name) => {
                if let Some((message, help)) = unusable_field(mesh, &name.field, (on, part)) {
                    self.add(format!("{key}.field"), message, help);
                }
                return;
            }
        };
        let Ok(formula) = PlaceFormula::read(text) else { return };
        match without_integral(mesh, (on, part), &formula) {
            None => {}
            Some(WithoutIntegral::Undefined(place)) => self.add(
                key,
                format!(
                    "the distribution has no value, or grows beyond all bounds, at {}",
                    show(place)
                ),
                "look for a division by 0, a root or logarithm of a negative number, and numbers above 1e100",
            ),
            Some(WithoutIntegral::Divergent(place)) => self.add(
                key,
                format!("the integral of the distribution does not converge at {}", show(place)),
                "look for a division by a number that becomes 0 there, and for features that are far smaller than the elements",
            ),
        }
    }
}

/// Mistake in the formula of a distribution, and remedy.
pub(super) fn wrong_formula(distribution: &Distribution) -> Option<(String, String)> {
    match distribution {
        Distribution::Formula(text) => PlaceFormula::read(text).err(),
        Distribution::Field(_) => None,
    }
}

/// Reason why a field cannot be the distribution on a set, and remedy.
fn unusable_field(mesh: &Mesh, name: &str, (on, part): (&str, LoadedPart)) -> Option<(String, String)> {
    let is_number = |value: Option<&f64>| value.is_some_and(|value| value.abs() <= LARGEST);
    let without = |what: &str, label: u64| {
        let message = format!("the field \"{name}\" has no number below 1e100 at {what} {label}");
        (message, "give a number there, or a set without it".to_owned())
    };
    match mesh.field(name) {
        Err(mistake) => Some(mistake),
        Ok(FieldValues::Nodes(values)) => {
            let nodes = mesh.nodes_on(on).into_iter().flatten();
            let wrong = nodes.into_iter().find(|&node| !is_number(values.get(node as usize)));
            wrong.map(|node| without("node", mesh.node_label(node)))
        }
        Ok(FieldValues::Quads(_)) if part != LoadedPart::Quads => Some((
            format!(
                "the field \"{name}\" has a value for each cell, and nodes and edges need one for each point"
            ),
            "average it to the points, in ParaView by the filter \"Cell Data to Point Data\"".into(),
        )),
        Ok(FieldValues::Quads(values)) => {
            let quads = mesh.quads_on(on).into_iter().flatten();
            let wrong = quads.into_iter().find(|&quad| !is_number(values.get(quad as usize)));
            wrong.map(|quad| without("element", mesh.quad_label(quad as usize)))
        }
    }
}

/// Why a distribution has no integral: a node of its set, or a place between two ends of an edge or on a diagonal of an element, at
/// which it has no value, or a place at which its integral does not converge.
fn without_integral(
    mesh: &Mesh,
    (on, part): (&str, LoadedPart),
    formula: &PlaceFormula,
) -> Option<WithoutIntegral> {
    let place = |node: u32| mesh.positions[node as usize];
    let value = |x: &Vec3| formula.value(x);
    let without_value = |x: &Vec3| !value(x).is_finite();
    let nodes = mesh.nodes_on(on).unwrap_or_default();
    if let Some(at) = nodes.into_iter().map(place).find(without_value) {
        return Some(WithoutIntegral::Undefined(at));
    }
    let corners_of = |quad: u32| mesh.quads[quad as usize].map(place);
    let edges: Vec<[Vec3; 2]> = match part {
        LoadedPart::Edges => mesh.edges_on(on).into_iter().flatten().map(|edge| edge.map(place)).collect(),
        _ => Vec::new(),
    };
    let elements: Vec<[Vec3; 4]> = match part {
        LoadedPart::Quads => mesh.quads_on(on).into_iter().flatten().map(corners_of).collect(),
        _ => Vec::new(),
    };
    // Steep flanks of finite height look like poles: the integral decides.
    let diagonals = elements.iter().flat_map(|x| [[x[0], x[2]], [x[1], x[3]]]);
    let mut lines = edges.iter().copied().chain(diagonals);
    if let Some(at) = lines.find_map(|ends| formula.pole(ends).filter(without_value)) {
        return Some(WithoutIntegral::Undefined(at));
    }
    over_edges(&edges, |at| value(&at.place))
        .err()
        .or_else(|| over_elements(&elements, |at| value(&at.place)).err())
}
