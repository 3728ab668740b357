//! Sets of nodes and elements of an input file: `*NSET`, `*ELSET`, and the parameters `NSET` and `ELSET` of other cards.

use std::collections::BTreeSet;

use super::cards::{Card, Reader, label, shown};
use crate::mesh::MeshError;
use crate::mesh::numbered::Sets;

/// Kind of set that a card defines.
#[derive(Debug, Clone, Copy)]
pub struct SetKind {
    /// Parameter with the name of the set.
    pub parameter: &'static str,
    /// Member in messages, with its article: "a node".
    pub member: &'static str,
    /// Member in messages: "node".
    pub noun: &'static str,
}

/// Sets of nodes.
pub const NODES: SetKind = SetKind { parameter: "NSET", member: "a node", noun: "node" };
/// Sets of elements.
pub const ELEMENTS: SetKind = SetKind { parameter: "ELSET", member: "an element", noun: "element" };

impl Sets {
    /// Adds the members that a card `*NSET` or `*ELSET` lists; all of them must be among the `known` ones, but for those of
    /// ranges, which may have gaps.
    ///
    /// # Errors
    /// A field is neither a known number nor the name of a set above this card, or a range is incomplete.
    pub fn add(
        &mut self,
        reader: &Reader<'_>,
        card: &Card<'_>,
        kind: SetKind,
        known: &BTreeSet<u64>,
    ) -> Result<(), MeshError> {
        reader.only(card, &[kind.parameter, "GENERATE", "UNSORTED", "INTERNAL"])?;
        reader.set_name(card, kind.parameter)?;
        let name = reader.required(card, kind.parameter)?;
        let members = match card.has("GENERATE") {
            true => ranges(reader, card, kind, known)?,
            false => self.listed(reader, card, kind, known)?,
        };
        self.extend(name, members);
        Ok(())
    }

    /// Members that the data lines list, by number or by the names of other sets.
    fn listed(
        &self,
        reader: &Reader<'_>,
        card: &Card<'_>,
        kind: SetKind,
        known: &BTreeSet<u64>,
    ) -> Result<Vec<u64>, MeshError> {
        let mut members = Vec::new();
        for (line, field) in card.fields().filter(|(_, field)| !field.is_empty()) {
            if let Some(number) = label(field) {
                if !known.contains(&number) {
                    return Err(reader.error(
                        line,
                        format!("the file has no {} {number}, which the set names", kind.noun),
                        "remove the number from the set, or define it",
                    ));
                }
                members.push(number);
            } else if let Some((_, others)) = self.get(field.trim_matches('"')) {
                members.extend(others);
                members.extend(self.repeated(field.trim_matches('"')));
            } else {
                return Err(reader.error(
                    line,
                    format!(
                        "\"{}\" is neither the number of {} nor the name of a set above",
                        shown(field),
                        kind.member
                    ),
                    "list whole numbers and names of sets that are defined before, with commas between them",
                ));
            }
        }
        Ok(members)
    }
}

/// Members of the ranges `first, last, increment` of a card with GENERATE. Only numbers of the file are taken, so that the memory does not
/// depend on the numbers of a range.
fn ranges(
    reader: &Reader<'_>,
    card: &Card<'_>,
    kind: SetKind,
    known: &BTreeSet<u64>,
) -> Result<Vec<u64>, MeshError> {
    let mut members = Vec::new();
    for data in &card.data {
        let fields = data.list();
        let (first, last, step) = match fields[..] {
            [first] => (first, first, "1"),
            [first, last] | [first, last, ""] => (first, last, "1"),
            [first, last, step] => (first, last, step),
            _ => {
                return Err(reader.error(
                    data.line,
                    format!("a range has 2 or 3 numbers, and there are {}", fields.len()),
                    "write first, last, increment",
                ));
            }
        };
        let first = reader.label(data.line, first, kind.member)?;
        let last = reader.label(data.line, last, kind.member)?;
        let step = reader.label(data.line, step, "an increment")?;
        if last < first {
            return Err(reader.error(
                data.line,
                format!("the range ends at {last}, before its first number {first}"),
                "write first, last, increment",
            ));
        }
        if (last - first) % step != 0 {
            return Err(reader.error(
                data.line,
                format!("the range from {first} by {step} does not meet its last number {last}"),
                "programs differ in whether the last number belongs to it: give one that does",
            ));
        }
        let mut inside = known.range(first..=last).filter(|&&n| (n - first) % step == 0).peekable();
        if inside.peek().is_none() {
            return Err(reader.error(
                data.line,
                format!("the range from {first} to {last} holds no {} of the file", kind.noun),
                "check the numbers of the range",
            ));
        }
        members.extend(inside);
    }
    Ok(members)
}
