//! `*CLOAD` and `*DLOAD`.

use std::collections::HashMap;

use super::solids::{self, Force};
use super::targets;
use crate::conversion::loads::Load;
use crate::mesh::MeshError;
use crate::mesh::abaqus::cards::{Card, DataLine, Reader, shown};
use crate::mesh::numbered::Parts;
use crate::mesh::numbered::bars::frame::Frame;
use crate::mesh::numbered::normals::Target;

/// Loads of the cards of one step, beside those of the step before, which continue.
///
/// # Errors
/// The first mistake.
pub(super) fn loads(
    reader: &Reader<'_>,
    (parts, frame): (&Parts, &Frame),
    cards: &[&Card<'_>],
    before: &[Load],
) -> Result<Vec<Load>, MeshError> {
    let mut new: Vec<Load> = Vec::new();
    let mut forces = HashMap::new();
    let mut pressures = HashMap::new();
    let mut of_solids = Vec::new();
    let mut kept = before.to_vec();
    for card in cards {
        let of = if card.keyword == "CLOAD" { "*CLOAD" } else { "*DLOAD" };
        let known: &[&str] = if of == "*CLOAD" { &["OP", "FOLLOWER"] } else { &["OP"] };
        reader.only(card, known)?;
        match card.parameter("OP").map(str::to_uppercase).as_deref() {
            None | Some("MOD") => {}
            Some("NEW") => kept.retain(|load| load.card != of),
            Some(other) => {
                return Err(reader.error(
                    card.line,
                    format!("OP={} is not read", shown(other)),
                    "write OP=NEW, or OP=MOD",
                ));
            }
        }
        for data in &card.data {
            match of {
                "*CLOAD" => {
                    let found = force(reader, parts, *data, &mut forces)?;
                    let is_follower = card.has("FOLLOWER");
                    if parts.through.is_empty() {
                        on_nodes((parts, frame), &found, is_follower, &mut new);
                    } else {
                        of_solids.push(on_solid(reader, found, is_follower)?);
                    }
                }
                _ => distributed(reader, parts, *data, &mut pressures, &mut new)?,
            }
        }
    }
    solids::forces(reader, parts, &of_solids, &mut new)?;
    if let Some(load) = new.iter().find(|load| kept.iter().any(|earlier| earlier.card == load.card)) {
        return Err(reader.error(
            load.line,
            format!("the step adds to the loads by {} of the step before", load.card),
            "write OP=NEW on the card and list all its loads",
        ));
    }
    kept.extend(new);
    Ok(kept)
}

/// Force or moment of a line: nodes, direction from 1 to 6, value.
struct Nodal {
    target: Target,
    direction: usize,
    value: f64,
    line: usize,
}

/// Force or moment along an axis on every node of a set.
fn force(
    reader: &Reader<'_>,
    parts: &Parts,
    data: DataLine<'_>,
    taken: &mut HashMap<(u64, usize), usize>,
) -> Result<Nodal, MeshError> {
    let fields = data.list();
    let [on, direction, value] = fields[..] else {
        return Err(reader.error(
            data.line,
            format!("a line of *CLOAD has 3 values, and there are {}", fields.len()),
            "write a node or a set, the direction from 1 to 6, and the force or moment on each node",
        ));
    };
    let direction: usize = direction.parse().ok().filter(|n| (1..=6).contains(n)).ok_or_else(|| {
        reader.error(
            data.line,
            format!("\"{}\" is not a direction from 1 to 6", shown(direction)),
            "write 1 to 3 for forces along x, y, z and 4 to 6 for moments about them",
        )
    })?;
    let target = targets::nodes(reader, parts, (data.line, on), true)?;
    let value = reader.number(data.line, value)?;
    for &node in &target.nodes {
        if let Some(earlier) = taken.insert((node, direction), data.line) {
            return Err(reader.error(
                data.line,
                format!("node {node} is loaded in the direction {direction} on line {earlier}, too"),
                "give the load of each node and direction once in a step",
            ));
        }
    }
    Ok(Nodal { target, direction, value, line: data.line })
}

/// A force on nodes of continuum shells.
fn on_solid(reader: &Reader<'_>, nodal: Nodal, is_follower: bool) -> Result<Force, MeshError> {
    let Nodal { target, direction, value, line } = nodal;
    if direction > 3 || is_follower {
        return Err(reader.error(
            line,
            "nodes of continuum shells have no rotations, so they have no moments and no forces that turn with them",
            "give forces along x, y and z on the nodes at the bottom and at the top, or mesh the middle surface with S4",
        ));
    }
    Ok(Force { target, axis: direction - 1, value, line })
}

/// Adds a force or a moment on nodes of shells and beams; followers turn with the node.
fn on_nodes((parts, frame): (&Parts, &Frame), nodal: &Nodal, is_follower: bool, out: &mut Vec<Load>) {
    let Nodal { target, direction, value, line } = nodal;
    let (kind, axis) = match (*direction <= 3, is_follower) {
        (true, false) => ("force", direction - 1),
        (false, false) => ("moment", direction - 4),
        (true, true) => ("follower-force", direction - 1),
        (false, true) => ("follower-moment", direction - 4),
    };
    let of_shells = target.nodes.iter().any(|node| parts.used.contains(node)).then(|| target.name.clone());
    let of_beams = target.nodes.iter().filter(|node| !parts.used.contains(node));
    let sections = of_beams.filter_map(|node| frame.carriers.get(node).cloned());
    for name in of_shells.into_iter().chain(sections) {
        let there = out.iter().position(|load| load.kind == kind && load.on.as_deref() == Some(&name));
        let at = there.unwrap_or_else(|| {
            out.push(Load { card: "*CLOAD", kind, on: Some(name), value: vec![0.0; 3], line: *line });
            out.len() - 1
        });
        if let Some(component) = out.get_mut(at).and_then(|load| load.value.get_mut(axis)) {
            *component = *value;
        }
    }
}

/// Pressure or gravity.
fn distributed(
    reader: &Reader<'_>,
    parts: &Parts,
    data: DataLine<'_>,
    taken: &mut HashMap<(u64, String), usize>,
    out: &mut Vec<Load>,
) -> Result<(), MeshError> {
    let fields = data.list();
    let field = |i: usize| fields.get(i).copied().unwrap_or_default();
    let kind = field(1).to_uppercase();
    match kind.as_str() {
        "P" | "P1" | "P2" if fields.len() == 3 => pressure(reader, parts, (data, &kind), taken, out)?,
        "GRAV" if fields.len() == 6 => {
            if !field(0).is_empty() {
                let (on, members) = targets::elements(reader, parts, (data.line, field(0)))?;
                if members.len() < parts.elements.len() + parts.bars.len() {
                    return Err(reader.error(
                        data.line,
                        format!("gravity acts on the set \"{}\" alone", shown(&on)),
                        "gravity acts on all masses of a model: give a set of all elements",
                    ));
                }
            }
            let mut numbers = [0.0; 4];
            for (x, field) in numbers.iter_mut().zip(fields.iter().skip(2)) {
                *x = reader.number(data.line, field)?;
            }
            let [size, x, y, z] = numbers;
            let length = x.hypot(y).hypot(z);
            if !length.is_normal() {
                return Err(reader.error(
                    data.line,
                    "the direction of gravity has no length",
                    "write the acceleration and the components of its direction, such as 9.81, 0, 0, -1",
                ));
            }
            let value = [x, y, z].map(|component| size * (component / length)).to_vec();
            out.push(Load { card: "*DLOAD", kind: "gravity", on: None, value, line: data.line });
        }
        "P" | "P1" | "P2" | "GRAV" => {
            return Err(reader.error(
                data.line,
                format!("{kind} has {} values", fields.len()),
                "write `SET, P, pressure`, with P1 or P2 for continuum shells, or `SET, GRAV, acceleration, x, y, z`",
            ));
        }
        other => {
            let help = match other {
                "PX" | "PY" | "PZ" => {
                    "loads along the lines of beams are not read: give their resultants on the nodes with *CLOAD"
                }
                "CENTRIF" | "CENTRIFUGAL" => "give a load of the type `centrifugal` in a model file",
                _ => {
                    "P and GRAV are read; give others in a model file, as `traction`, `edge` or `edge-moment`"
                }
            };
            return Err(reader.error(
                data.line,
                format!("the distributed load \"{}\" is not read", shown(other)),
                help,
            ));
        }
    }
    Ok(())
}

/// Pressure on shells, P, or on the bottom, P1, or the top, P2, of continuum shells.
fn pressure(
    reader: &Reader<'_>,
    parts: &Parts,
    (data, kind): (DataLine<'_>, &str),
    taken: &mut HashMap<(u64, String), usize>,
    out: &mut Vec<Load>,
) -> Result<(), MeshError> {
    let fields = data.list();
    let field = |i: usize| fields.get(i).copied().unwrap_or_default();
    let (on, members) = targets::elements(reader, parts, (data.line, field(0)))?;
    let wrong = |message: String, help: &str| Err(reader.error(data.line, message, help));
    if let Some(bar) = parts.bars.iter().find(|bar| members.contains(&bar.label)) {
        return wrong(
            format!("{kind} acts on the beam {}", bar.label),
            "loads along the lines of beams are not read: give their resultants on the nodes with *CLOAD",
        );
    }
    let is_solid = !parts.through.is_empty();
    if is_solid != (kind != "P") {
        return wrong(
            format!("{kind} does not act on the elements of {}", shown(&on)),
            "write P for shells S4; write P1 for the bottom of continuum shells SC8R, the nodes 1 to 4, and P2 for their top",
        );
    }
    for element in members {
        if let Some(earlier) = taken.insert((element, kind.to_owned()), data.line) {
            return wrong(
                format!("element {element} has a pressure on line {earlier}, too"),
                "give the pressure of each element once in a step",
            );
        }
    }
    // P acts along the normal of the shell, P1 and P2 into the element, `pressure` against the director.
    let sign = if kind == "P2" { 1.0 } else { -1.0 };
    let value = vec![sign * reader.number(data.line, field(2))?];
    out.push(Load { card: "*DLOAD", kind: "pressure", on: Some(on), value, line: data.line });
    Ok(())
}
