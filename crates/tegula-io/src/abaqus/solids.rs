//! Supports and forces of continuum shells, whose nodes lie at the bottom and the top of the shell.
//!
//! A node of the middle surface stands for both nodes of an edge through the thickness h: its displacement is the mean of theirs, and the change of
//! its director their difference over h. So what holds or moves both nodes along an axis has an exact counterpart, and so have equal forces on
//! both. What acts on one of them alone has none.

use std::collections::{BTreeMap, BTreeSet};

use crate::conversion::document::{Document, axes, number, quoted};
use crate::conversion::loads::Load;
use crate::conversion::supports::Restraint;
use crate::mesh::MeshError;
use crate::mesh::abaqus::cards::{Reader, shown};
use crate::mesh::numbered::Parts;
use crate::mesh::numbered::normals::Target;

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];
/// Relative difference of thicknesses below which they are the same.
const SAME: f64 = 1e-9;

/// Force along an axis on every node of a target.
#[derive(Debug)]
pub(super) struct Force {
    /// The nodes.
    pub target: Target,
    /// Axis, from 0 to 2.
    pub axis: usize,
    /// The force on each node.
    pub value: f64,
    /// Line of the card.
    pub line: usize,
}

/// Nodes of the middle surface that nodes of continuum shells stand for.
fn middles(parts: &Parts, target: &Target) -> BTreeSet<u64> {
    target.nodes.iter().filter_map(|node| parts.middle(*node)).collect()
}

/// Values of both nodes of the edges through the thickness at `middles`, the bottom first; they must be the same ones at all of these edges.
fn of_both(
    reader: &Reader<'_>,
    parts: &Parts,
    middles: &BTreeSet<u64>,
    (line, what): (usize, &str),
    value: impl Fn(u64) -> Option<f64>,
) -> Result<[f64; 2], MeshError> {
    let mut found: Option<[f64; 2]> = None;
    for bottom in middles {
        let top = parts.layer.above.get(bottom).copied().unwrap_or_default();
        let (of_bottom, of_top) = (value(*bottom), value(top));
        let (Some(of_bottom), Some(of_top)) = (of_bottom, of_top) else {
            let (with, without) = if of_top.is_some() { (top, *bottom) } else { (*bottom, top) };
            return Err(reader.error(
                line,
                format!("node {with} {what}, and node {without} on the other side of the continuum shell does not"),
                "give both nodes of an edge through the thickness the same degrees of freedom, or mesh the middle surface with S4, which can be supported and loaded in its nodes",
            ));
        };
        let both = [of_bottom, of_top];
        if found.is_some_and(|earlier| earlier != both) {
            return Err(reader.error(
                line,
                format!("node {bottom} or node {top} {what} with another value than those before in the set"),
                "give nodes with different values sets of their own",
            ));
        }
        found = Some(both);
    }
    Ok(found.unwrap_or_default())
}

/// Values of degrees of freedom, each with its line, by the numbers of nodes and from 0 on.
type Held = BTreeMap<(u64, usize), (f64, usize)>;

/// Degrees of freedom of each node, of all supports together.
fn held(reader: &Reader<'_>, restraints: &[Restraint]) -> Result<Held, MeshError> {
    let mut out = Held::new();
    for restraint in restraints {
        for (i, dof) in restraint.dofs.iter().enumerate() {
            let Some((value, line)) = *dof else { continue };
            if i >= 3 && value != 0.0 {
                return Err(reader.error(
                    line,
                    format!(
                        "the rotation {value} is prescribed, and nodes of continuum shells have no rotations"
                    ),
                    "prescribe displacements of the nodes at the bottom and at the top",
                ));
            }
            for node in &restraint.target.nodes {
                if let Some((earlier, at)) = out.insert((*node, i), (value, line)).filter(|of| of.0 != value)
                {
                    let message = format!(
                        "degree of freedom {} of node {node} gets {value}, and {earlier} on line {at}",
                        i + 1
                    );
                    return Err(reader.error(line, message, "give it one value"));
                }
            }
        }
    }
    Ok(out)
}

/// Writes supports as entries of `[[conditions]]`. Fixed rotations have no effect, as nodes of continuum shells have none.
///
/// # Errors
/// A degree of freedom is held at one side of the shell alone.
pub(super) fn write_supports(
    out: &mut Document,
    reader: &Reader<'_>,
    parts: &Parts,
    restraints: &[Restraint],
) -> Result<(), MeshError> {
    let held = held(reader, restraints)?;
    let mut written = Vec::new();
    for Restraint { target, line, dofs, card } in restraints {
        let middles = middles(parts, target);
        let mut both: [Option<[f64; 2]>; 3] = [None; 3];
        for (axis, (of, dof)) in both.iter_mut().zip(dofs).enumerate() {
            let Some((_, line)) = *dof else { continue };
            let what = format!("is held along {}", AXES.get(axis).copied().unwrap_or_default());
            let value = |node: u64| held.get(&(node, axis)).map(|(value, _)| *value);
            *of = Some(of_both(reader, parts, &middles, (line, &what), value)?);
        }
        let key = (middles, both);
        if both == [None; 3] || written.contains(&key) {
            continue;
        }
        support(out, (*line, *card, target), both, thickness(reader, parts, &key, *line)?);
        written.push(key);
    }
    Ok(())
}

/// Thickness at nodes of the middle surface, which must be the same at all of them where the directors turn.
fn thickness(
    reader: &Reader<'_>,
    parts: &Parts,
    (middles, both): &(BTreeSet<u64>, [Option<[f64; 2]>; 3]),
    line: usize,
) -> Result<f64, MeshError> {
    let all: Vec<f64> =
        middles.iter().filter_map(|node| parts.through.get(node)).map(|through| through.norm()).collect();
    let first = all.first().copied().unwrap_or_default();
    let turns = both.iter().flatten().any(|[bottom, top]| bottom != top);
    if turns && all.iter().any(|other| !((other - first).abs() <= SAME * first)) {
        return Err(reader.error(
            line,
            "nodes whose bottom and top are displaced differently have different thicknesses",
            "give each thickness a set of its own",
        ));
    }
    Ok(first)
}

/// Writes the conditions of one set: values of the bottom and the top along the axes.
fn support(
    out: &mut Document,
    (line, card, target): (usize, &str, &Target),
    both: [Option<[f64; 2]>; 3],
    thickness: f64,
) {
    let mean = both.map(|of| of.map(|[bottom, top]| 0.5 * (bottom + top)));
    let turned = both.map(|of| of.map(|[bottom, top]| (top - bottom) / thickness));
    let fixed = |of: [Option<f64>; 3]| of.map(|value| value == Some(0.0));
    let entry = |out: &mut Document, kind: &str| {
        out.table(line, "[[conditions]]", card);
        out.key(line, "type", &quoted(kind));
        out.key(line, "on", &quoted(&target.name));
    };
    match (fixed(mean), fixed(turned)) {
        ([false, false, false], [false, false, false]) => {}
        ([true, true, true], [true, true, true]) => entry(out, "clamp"),
        (position, director) => {
            entry(out, "fix");
            for (key, of) in [("position", position), ("director", director)] {
                if of != [false; 3] {
                    out.key(line, key, &axes(of));
                }
            }
        }
    }
    for (of, values) in [("position", mean), ("director", turned)] {
        for (axis, value) in AXES.into_iter().zip(values) {
            let Some(value) = value.filter(|value| *value != 0.0) else { continue };
            entry(out, "prescribe");
            out.key(line, "of", &quoted(of));
            out.key(line, "component", &quoted(axis));
            out.key(line, "value", &number(value));
        }
    }
}

/// Loads of forces on nodes of continuum shells: twice the force of one node acts on the middle surface.
///
/// # Errors
/// A force acts at one side of the shell alone, or the forces of both sides differ.
pub(super) fn forces(
    reader: &Reader<'_>,
    parts: &Parts,
    forces: &[Force],
    out: &mut Vec<Load>,
) -> Result<(), MeshError> {
    let of_nodes: BTreeMap<(u64, usize), f64> = forces
        .iter()
        .flat_map(|force| force.target.nodes.iter().map(|node| ((*node, force.axis), force.value)))
        .collect();
    let mut done: BTreeSet<(u64, usize)> = BTreeSet::new();
    for Force { target, axis, value, line } in forces {
        let middles = middles(parts, target);
        let what = format!("is loaded along {}", AXES.get(*axis).copied().unwrap_or_default());
        let force = |node: u64| of_nodes.get(&(node, *axis)).copied();
        let [bottom, top] = of_both(reader, parts, &middles, (*line, &what), force)?;
        if bottom != top {
            return Err(reader.error(
                *line,
                format!("the nodes of {} at the bottom have the force {bottom}, and those at the top {top}", shown(&target.name)),
                "give both nodes of an edge through the thickness the same force; the difference is a moment, which a model with S4 can have",
            ));
        }
        let new = middles.iter().filter(|node| done.insert((**node, *axis))).count();
        if new == 0 {
            continue;
        }
        if new < middles.len() {
            return Err(reader.error(
                *line,
                format!("some nodes of {} are loaded in this direction with a set above, and others are not", shown(&target.name)),
                "load nodes at the bottom and at the top by one set of both, or by two sets with the same edges through the thickness",
            ));
        }
        let on = Some(target.name.clone());
        let there = out.iter().position(|load| load.kind == "force" && load.on == on);
        let at = there.unwrap_or_else(|| {
            out.push(Load { card: "*CLOAD", kind: "force", on, value: vec![0.0; 3], line: *line });
            out.len() - 1
        });
        if let Some(component) = out.get_mut(at).and_then(|load| load.value.get_mut(*axis)) {
            *component = 2.0 * value;
        }
    }
    Ok(())
}
