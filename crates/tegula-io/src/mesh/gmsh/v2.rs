//! Sections of format 2.2: `$Nodes` and `$Elements`.

use std::collections::BTreeMap;

use tegula::Vec3;

use super::raw::{Head, Raw, RawNode};
use super::scanner::{Encoding, Scanner};
use crate::mesh::MeshError;

/// `count`, then `number x y z` for each node.
pub(super) fn nodes(scanner: &mut Scanner<'_>, raw: &mut Raw) -> Result<(), MeshError> {
    let count = scanner.text_count("the number of nodes")?;
    for _ in 0..count {
        let at = scanner.position();
        let tag = scanner.natural("the number of a node")?;
        let coordinates = scanner.position();
        let mut position = Vec3::zeros();
        for i in 0..3 {
            position[i] = scanner.double("a coordinate of a node")?;
        }
        raw.nodes.push(RawNode { tag, position, at, coordinates });
    }
    Ok(())
}

/// `count`, then `number type tag-count tags… nodes…` for each element. In binary
/// files type and tag count stand in front of a batch of elements that share them.
pub(super) fn elements(scanner: &mut Scanner<'_>, raw: &mut Raw) -> Result<(), MeshError> {
    let start = scanner.position();
    let count = scanner.text_count("the number of elements")?;
    raw.copies = true;
    let mut lists = BTreeMap::new();
    let mut done = 0;
    while done < count {
        if scanner.encoding == Encoding::Ascii {
            let at = scanner.position();
            let tag = scanner.natural("the number of an element")?;
            let kind = scanner.int("the type of an element")?;
            let tags = scanner.natural("the number of tags of an element")?;
            element(scanner, raw, &mut lists, (kind, tag, tags, at))?;
            done += 1;
            continue;
        }
        let kind = scanner.int("the type of an element")?;
        let batch = scanner.natural("the number of elements of a type")?;
        let tags = scanner.natural("the number of tags of an element")?;
        for _ in 0..batch {
            let at = scanner.position();
            let tag = scanner.natural("the number of an element")?;
            element(scanner, raw, &mut lists, (kind, tag, tags, at))?;
        }
        done = done.saturating_add(batch);
    }
    scanner.total(start, "elements", (count, done))
}

/// Tags and nodes of one element; the first tag is the physical group, 0 for none, the second the entity.
fn element(
    scanner: &mut Scanner<'_>,
    raw: &mut Raw,
    lists: &mut BTreeMap<i64, usize>,
    (kind, tag, tags, at): (i64, u64, u64, usize),
) -> Result<(), MeshError> {
    let (mut group, mut entity) = (0, 0);
    for i in 0..tags {
        let value = scanner.int("a tag of an element")?;
        match i {
            0 => group = value,
            1 => entity = value,
            _ => {}
        }
    }
    let list = match lists.get(&group) {
        Some(&list) => Some(list),
        None if group == 0 => None,
        None => {
            let list = raw.add_groups(vec![group]);
            lists.extend(list.map(|list| (group, list)));
            list
        }
    };
    raw.read_element(scanner, Head { kind, tag, groups: list, entity, at }, |s| {
        s.natural("a node of an element")
    })
}
