//! Axes of the material: elements of a property whose first axes are the projection of one direction.
//!
//! `THETA` of a `CQUAD4` is the angle of the first axis of the material from the side of its first two nodes, about its normal; `MCID` 0 stands for the x axis. A section has
//! one direction, which is projected on the surface. So the elements of a property whose material has axes are parted by their directions.

use std::collections::{BTreeMap, BTreeSet};

use tegula::Vec3;

use super::bulk::{Bulk, Shell, property_set};
use super::cards::Card;
use super::file::File;
use crate::mesh::MeshError;
use crate::mesh::numbered::{Element, Reader};

/// Directions within this angle (radians) are one.
const SAME: f64 = 1e-5;
/// Most sections that one property becomes.
const MOST: usize = 200;

/// Elements of a property with one direction of the material.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// Name of the set.
    pub name: String,
    /// Numbers of the elements.
    pub elements: Vec<u64>,
    /// Direction whose projection is the first axis of the material; `None` where the material has no axes.
    pub direction: Option<[f64; 3]>,
}

/// Elements of all properties, and which properties have axes.
pub struct Properties<'b> {
    elements: BTreeMap<u64, Vec<(&'b Element, &'b Shell)>>,
    oriented: BTreeSet<u64>,
}

impl<'b> Properties<'b> {
    /// Elements by their properties, in the order of the file.
    pub fn new(file: &File<'_>, bulk: &'b Bulk) -> Self {
        let mut elements: BTreeMap<u64, Vec<(&Element, &Shell)>> = BTreeMap::new();
        for (element, shell) in bulk.parts.elements.iter().zip(&bulk.shells) {
            elements.entry(shell.property).or_default().push((element, shell));
        }
        Self { elements, oriented: oriented(file) }
    }

    /// Numbers of the properties of elements, in ascending order.
    pub fn numbers(&self) -> impl Iterator<Item = u64> {
        self.elements.keys().copied()
    }

    /// Whether an element has a property.
    pub fn has(&self, property: u64) -> bool {
        self.elements.contains_key(&property)
    }

    /// Parts the elements of a property by the directions of their material.
    ///
    /// # Errors
    /// A coordinate system gives the axes of a material, or there are too many directions.
    pub fn groups(&self, reader: &Reader<'_>, bulk: &Bulk, property: u64) -> Result<Vec<Group>, MeshError> {
        let own = self.elements.get(&property).map_or(&[][..], Vec::as_slice);
        if !self.oriented.contains(&property) {
            let elements = own.iter().map(|(element, _)| element.label).collect();
            return Ok(vec![Group { name: property_set(property), elements, direction: None }]);
        }
        parted(reader, bulk, property, own)
    }
}

/// Properties that need a direction: each `PCOMP`, whose default direction may be normal to it, and those with a `MAT8`.
fn oriented(file: &File<'_>) -> BTreeSet<u64> {
    let number = |card: &Card<'_>, index: usize| card.field(index).text.parse::<u64>().ok();
    let materials: BTreeSet<u64> = file.named("MAT8").filter_map(|card| number(card, 0)).collect();
    let with_axes = |card: &&Card<'_>| number(card, 1).is_some_and(|material| materials.contains(&material));
    file.named("PCOMP")
        .chain(file.named("PSHELL").filter(with_axes))
        .filter_map(|card| number(card, 0))
        .collect()
}

/// Groups of elements whose material has axes.
fn parted(
    reader: &Reader<'_>,
    bulk: &Bulk,
    property: u64,
    own: &[(&Element, &Shell)],
) -> Result<Vec<Group>, MeshError> {
    let mut found: Vec<(Vec3, Vec<u64>)> = Vec::new();
    for &(element, shell) in own {
        if shell.system.is_some_and(|system| system != 0) {
            return Err(reader.error(
                element.line,
                format!("a coordinate system MCID gives the axes of the material of element {}", element.label),
                "give the angle THETA from the side of the first two nodes, or `direction` of a `layup` in a model file",
            ));
        }
        let [Some(a), Some(b), Some(c), Some(d)] =
            element.nodes.map(|node| bulk.parts.nodes.get(&node).map(|(position, _)| *position))
        else {
            continue;
        };
        let Some(normal) = (c - a).cross(&(d - b)).try_normalize(0.0) else { continue };
        let projected = |v: Vec3| (v - normal * normal.dot(&v)).try_normalize(1e-3 * v.norm());
        let basic = shell.system.is_some();
        let first = if basic { Vec3::x() } else { b - a };
        let Some(side) = projected(first) else {
            return Err(reader.error(
                element.line,
                format!("the first axis of the material of element {} is normal to it", element.label),
                "give the angle THETA from the side of the first two nodes",
            ));
        };
        let (sine, cosine) = shell.angle.to_radians().sin_cos();
        // Whole multiples of a right angle leave no round-off in the text.
        let clean = |x: f64| if x.abs() < 1e-15 { 0.0 } else { x };
        let axis = (side * clean(cosine) + normal.cross(&side) * clean(sine)).map(clean);
        let near = |direction: &Vec3| projected(*direction).is_some_and(|along| (along - axis).norm() < SAME);
        match found.iter_mut().find(|(direction, _)| near(direction)) {
            Some((_, elements)) => elements.push(element.label),
            None => found.push((if basic { first } else { axis }, vec![element.label])),
        }
        if found.len() > MOST {
            return Err(reader.error(
                element.line,
                format!("the axes of the material of property {property} have more than {MOST} directions"),
                "number the nodes so that the sides of the first two nodes run along one direction, or give `direction` of a `layup` in a model file",
            ));
        }
    }
    let set = property_set(property);
    let single = found.len() == 1;
    Ok(found
        .into_iter()
        .enumerate()
        .map(|(i, (axis, elements))| Group {
            name: if single { set.clone() } else { format!("{set} direction {}", i + 1) },
            elements,
            direction: Some(axis.into()),
        })
        .collect())
}
