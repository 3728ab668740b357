//! `*BOUNDARY`: fixed and prescribed degrees of freedom.

use std::collections::BTreeMap;

use super::targets;
use crate::conversion::supports::Restraint;
use crate::mesh::MeshError;
use crate::mesh::abaqus::cards::{Card, DataLine, Reader, shown};
use crate::mesh::numbered::Parts;

/// Supports of the cards `*BOUNDARY` of one part of the file, in the order in which their nodes or sets first stand there.
///
/// # Errors
/// The first mistake.
pub(super) fn restraints(
    reader: &Reader<'_>,
    parts: &Parts,
    cards: &[&Card<'_>],
) -> Result<Vec<Restraint>, MeshError> {
    let mut found: Vec<Restraint> = Vec::new();
    let mut index: BTreeMap<String, usize> = BTreeMap::new();
    for card in cards {
        reader.only(card, &["OP", "TYPE"])?;
        if card.parameter("TYPE").is_some_and(|kind| !kind.eq_ignore_ascii_case("DISPLACEMENT")) {
            return Err(reader.error(
                card.line,
                "prescribed velocities and accelerations are not read",
                "give a `prescribe` with an amplitude in a model file",
            ));
        }
        for data in &card.data {
            let (field, dofs) = degrees(reader, *data)?;
            let target = targets::nodes(reader, parts, (data.line, field), false)?;
            let at = *index.entry(target.name.clone()).or_insert(found.len());
            if at == found.len() {
                found.push(Restraint { target, line: data.line, dofs: [None; 6], card: "*BOUNDARY" });
            }
            let Some(restraint) = found.get_mut(at) else { continue };
            for (i, (of, value)) in restraint.dofs.iter_mut().zip(dofs).enumerate() {
                let Some(value) = value else { continue };
                if let Some((earlier, line)) = of.filter(|(earlier, _)| *earlier != value) {
                    return Err(reader.error(
                        data.line,
                        format!("degree of freedom {} gets {value}, and {earlier} on line {line}", i + 1),
                        "give it one value",
                    ));
                }
                *of = Some((value, data.line));
            }
        }
    }
    Ok(found)
}

/// Node or set of a data line, and the values of its degrees of freedom.
fn degrees<'t>(reader: &Reader<'_>, data: DataLine<'t>) -> Result<(&'t str, [Option<f64>; 6]), MeshError> {
    let fields = data.list();
    let field = |i: usize| fields.get(i).copied().unwrap_or_default();
    let wrong = |message: String| {
        reader.error(
            data.line,
            message,
            "write a node or a set, the first and the last degree of freedom from 1 to 6, and a value other than 0",
        )
    };
    if fields.len() > 4 {
        return Err(wrong(format!("a line of *BOUNDARY has 2 to 4 values, and there are {}", fields.len())));
    }
    let named: Option<&[usize]> = match field(1).to_uppercase().as_str() {
        "ENCASTRE" => Some(&[1, 2, 3, 4, 5, 6]),
        "PINNED" => Some(&[1, 2, 3]),
        "XSYMM" => Some(&[1, 5, 6]),
        "YSYMM" => Some(&[2, 4, 6]),
        "ZSYMM" => Some(&[3, 4, 5]),
        "XASYMM" => Some(&[2, 3, 4]),
        "YASYMM" => Some(&[1, 3, 5]),
        "ZASYMM" => Some(&[1, 2, 6]),
        _ => None,
    };
    let mut out = [None; 6];
    if let Some(named) = named {
        for (i, value) in out.iter_mut().enumerate() {
            *value = named.contains(&(i + 1)).then_some(0.0);
        }
        return Ok((field(0), out));
    }
    let dof = |text: &str| {
        let found = text.parse().ok().filter(|n: &usize| (1..=6).contains(n));
        found.ok_or_else(|| wrong(format!("\"{}\" is not a degree of freedom from 1 to 6", shown(text))))
    };
    let first = dof(field(1))?;
    let last = if field(2).is_empty() { first } else { dof(field(2))? };
    if last < first {
        return Err(wrong(format!("the last degree of freedom, {last}, is before the first one, {first}")));
    }
    let value = reader.number(data.line, field(3))?;
    for (_, of) in out.iter_mut().enumerate().filter(|(i, _)| (first..=last).contains(&(i + 1))) {
        *of = Some(value);
    }
    Ok((field(0), out))
}
