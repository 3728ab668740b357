//! Beams of a model file.

use std::collections::{BTreeMap, BTreeSet};

use tegula::Issue;
use tegula::model::{BeamSection, CircularSection};

use super::document::{Document, number, quoted, vector};
use crate::mesh::numbered::bars::Release;
use crate::mesh::numbered::bars::frame::{Frame, Joint};
use crate::mesh::numbered::bars::lines::Line;

/// Cross-section of bars.
#[derive(Debug)]
pub(crate) struct Section {
    /// Section of a beam, in TOML.
    pub text: String,
    /// Name of the material that it needs.
    pub material: Option<String>,
    /// Line of the card.
    pub line: usize,
}

/// A section in TOML.
pub(crate) fn text(section: &BeamSection) -> String {
    let (kind, keys) = match section {
        BeamSection::Rectangle(section) => ("rectangle", vec![("size", vector(&section.size))]),
        BeamSection::Box(section) => {
            ("box", vec![("size", vector(&section.size)), ("thickness", number(section.thickness))])
        }
        BeamSection::Circle(CircularSection { radius, inner_radius }) => {
            ("circle", vec![("radius", number(*radius)), ("inner_radius", number(*inner_radius))])
        }
        BeamSection::Constants(section) => (
            "constants",
            vec![
                ("axial", number(section.axial)),
                ("shear", vector(&section.shear)),
                ("bending", vector(&section.bending)),
                ("torsion", number(section.torsion)),
                ("mass", number(section.mass)),
                ("inertia", vector(&section.inertia)),
            ],
        ),
    };
    let keys: Vec<String> = keys.into_iter().map(|(key, value)| format!("{key} = {value}")).collect();
    format!("{{ type = {}, {} }}", quoted(kind), keys.join(", "))
}

/// Writes the beams of the elements of a `card`, with their sections by the numbers of properties; the motion of the `printed` nodes is recorded.
pub(crate) fn write(
    out: &mut Document,
    card: &str,
    frame: &Frame,
    sections: &BTreeMap<u64, Section>,
    printed: &BTreeSet<u64>,
) {
    for (line, attached) in frame.lines.iter().zip(&frame.attached) {
        let Some(section) = sections.get(&line.property) else { continue };
        out.table(line.line, "[[beams]]", card);
        out.key(line.line, "name", &quoted(&line.name));
        let points: Vec<String> = line.points.iter().map(|point| vector(point.as_slice())).collect();
        out.key(line.line, "points", &format!("[{}]", points.join(", ")));
        if points.len() == 2 {
            out.key(line.line, "elements", "1");
        }
        out.key(line.line, "direction", &vector(line.direction.as_slice()));
        out.key(section.line, "section", &section.text);
        if let Some(material) = &section.material {
            out.key(section.line, "material", &quoted(material));
        }
        if !attached.is_empty() {
            out.key(line.line, "attached", &format!("[{}]", quoted(&line.set())));
        }
        write_history(out, line, printed);
    }
    frame.joints.iter().for_each(|joint| write_joint(out, card, joint));
}

/// Writes which cross-sections have columns in the history, where more than both ends have.
fn write_history(out: &mut Document, line: &Line, printed: &BTreeSet<u64>) {
    let last = line.nodes.len().saturating_sub(1);
    let asked = |(i, node): (usize, &u64)| (i == 0 || i == last || printed.contains(node)).then_some(i);
    let recorded: Vec<String> =
        line.nodes.iter().enumerate().filter_map(asked).map(|i| i.to_string()).collect();
    if recorded.len() > 2 {
        out.key(line.line, "history", &format!("[{}]", recorded.join(", ")));
    }
}

/// Writes the joint of a cross-section and what it moves with.
fn write_joint(out: &mut Document, card: &str, joint: &Joint) {
    let (kind, axis) = match joint.release {
        Release::Nothing => ("fixed", None),
        Release::Rotations => ("spherical", None),
        Release::Rotation(axis) => ("revolute", Some(axis)),
    };
    out.table(joint.line, "[[joints]]", card);
    out.key(joint.line, "type", &quoted(kind));
    out.key(joint.line, "name", &quoted(&joint.name));
    let [first, second] = &joint.between;
    out.key(joint.line, "between", &format!("[{}, {}]", quoted(first), quoted(second)));
    out.key(joint.line, "at", &vector(joint.at.as_slice()));
    if let Some(axis) = axis {
        out.key(joint.line, "axis", &vector(axis.as_slice()));
    }
}

/// Warning about lines of bars that shells hold at one node alone, and no support of the cross-sections `held`: shells have no stiffness against turning
/// about their normals.
pub(crate) fn turning_freely<'a>(frame: &Frame, held: impl Iterator<Item = &'a str>) -> Option<Issue> {
    // Lines that joints connect with each other and with the ground have one number.
    let mut parts: Vec<usize> = (0..frame.lines.len()).collect();
    let ground = parts.len();
    let line_of = |section: &str| {
        let name = section.rsplit_once('.').map_or(section, |(name, _)| name);
        frame.lines.iter().position(|line| line.name == name)
    };
    parts.push(ground);
    let joints = frame.joints.iter().map(|joint| joint.between.each_ref().map(String::as_str));
    for between in joints.chain(held.map(|section| ["ground", section])) {
        let [a, b] = between.map(|side| parts[line_of(side).unwrap_or(ground)]);
        parts.iter_mut().filter(|part| **part == b).for_each(|part| *part = a);
    }
    let nodes_of = |part: usize| -> usize {
        let of_part = frame.attached.iter().zip(&parts).filter(|(_, of)| **of == part);
        of_part.map(|(nodes, _)| nodes.len()).sum()
    };
    let free =
        |i: &usize| parts[*i] != parts[ground] && nodes_of(parts[*i]) == 1 && !frame.attached[*i].is_empty();
    let found: Vec<&Line> = (0..frame.lines.len()).filter(free).map(|i| &frame.lines[i]).collect();
    let first = found.first()?;
    let others = if found.len() == 1 { "" } else { " and others" };
    Some(Issue::new(
        "beams",
        format!(
            "{} (line {}){others} is joined to shells at one node: it turns freely about the normal of the shell there, which has no stiffness against that",
            first.name, first.line
        ),
        "hold the turn by a support or a further beam where it matters; modes of 0 Hz are such turns",
    ))
}
