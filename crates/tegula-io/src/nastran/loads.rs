//! Loads that a subcase selects: `LOAD`, `GRAV`, and the sets of the other cards.

use std::collections::BTreeMap;

use crate::conversion::loads::Load;
use crate::mesh::MeshError;
use crate::mesh::nastran::bulk::Bulk;
use crate::mesh::nastran::file::File;
use crate::mesh::nastran::loads::{self, Nodal, Pressure};
use crate::mesh::numbered::Reader;

/// Loads of all load sets.
pub(super) struct LoadSets {
    nodal: Vec<Nodal>,
    pressures: Vec<Pressure>,
    /// Accelerations by load set, with their lines.
    gravity: Vec<(u64, [f64; 3], usize)>,
    /// Lengths of the vectors N of accelerations that differ from 1, with their lines.
    pub lengths: Vec<(f64, usize)>,
    /// Combinations by their numbers: the load sets with their factors, and the line.
    combined: BTreeMap<u64, (Vec<(u64, f64)>, usize)>,
}

impl LoadSets {
    /// Reads the loads of a file.
    ///
    /// # Errors
    /// The first mistake of a card.
    pub fn read(reader: &Reader<'_>, file: &File<'_>, bulk: &Bulk) -> Result<Self, MeshError> {
        let (mut gravity, mut lengths) = (Vec::new(), Vec::new());
        for card in file.named("GRAV") {
            let set = card.id(reader, 0, "the load set")?;
            card.none(
                reader,
                1,
                "the coordinate system",
                "give the direction in the basic coordinate system",
            )?;
            let size = card.required(reader, 2, "the acceleration")?;
            let along = loads::components(reader, card, 3)?;
            let length = along.iter().map(|x| x * x).sum::<f64>().sqrt();
            // Components of few digits have a length near 1.
            if (length - 1.0).abs() > 1e-3 {
                lengths.push((length, card.line));
            }
            card.none(reader, 6, "MB", "leave it out")?;
            card.only(reader, 7)?;
            gravity.push((set, along.map(|x| size * x), card.line));
        }
        let mut combined = BTreeMap::new();
        for card in file.named("LOAD") {
            let set = card.id(reader, 0, "the number")?;
            let whole = card.required(reader, 1, "the scale factor")?;
            let mut parts: Vec<(u64, f64)> = Vec::new();
            for at in (2..card.count())
                .step_by(2)
                .filter(|&at| !(card.field(at).text.is_empty() && card.field(at + 1).text.is_empty()))
            {
                let factor = card.required(reader, at, "a scale factor")?;
                parts.push((card.id(reader, at + 1, "a load set")?, whole * factor));
            }
            if parts.is_empty() {
                return Err(card.missing(reader, 2, "a scale factor with its load set"));
            }
            if combined.insert(set, (parts, card.line)).is_some() {
                return Err(reader.error(
                    card.line,
                    format!("LOAD {set} is defined again"),
                    "keep one of them",
                ));
            }
        }
        let (nodal, pressures) =
            (loads::nodal(reader, file, &bulk.parts)?, loads::pressures(reader, file, &bulk.parts)?);
        let sets = Self { nodal, pressures, gravity, lengths, combined };
        match sets.combined.iter().find(|(set, _)| sets.has(**set)) {
            None => Ok(sets),
            Some((set, (_, line))) => Err(reader.error(
                *line,
                format!("LOAD {set} has the number of a load set"),
                "give combinations and load sets different numbers",
            )),
        }
    }

    fn has(&self, set: u64) -> bool {
        self.nodal.iter().any(|load| load.set == set)
            || self.pressures.iter().any(|load| load.set == set)
            || self.gravity.iter().any(|load| load.0 == set)
    }

    /// Load sets of a combination; none where the number is no combination.
    pub fn combined(&self, set: u64) -> impl Iterator<Item = u64> {
        self.combined.get(&set).into_iter().flat_map(|(parts, _)| parts.iter().map(|(set, _)| *set))
    }

    /// Loads of the number that a subcase selects on a line.
    ///
    /// # Errors
    /// There is no such load set.
    pub fn selected(&self, reader: &Reader<'_>, (set, line): (u64, usize)) -> Result<Vec<Load>, MeshError> {
        let single = (vec![(set, 1.0)], line);
        let (parts, line) = self.combined.get(&set).unwrap_or(&single);
        let mut out = Vec::new();
        let mut fall: Option<([f64; 3], usize)> = None;
        for (set, factor) in parts {
            if !self.has(*set) {
                let message = format!("there are no loads of the set {set}");
                return Err(reader.error(
                    *line,
                    message,
                    "check its number; FORCE, MOMENT, PLOAD2, PLOAD4 and GRAV are read",
                ));
            }
            for load in self.nodal.iter().filter(|load| load.set == *set) {
                let kind = if load.card == "FORCE" { "force" } else { "moment" };
                let value = load.value.map(|x| factor * x).to_vec();
                out.push(Load { card: load.card, kind, on: Some(load.name.clone()), value, line: load.line });
            }
            for load in self.pressures.iter().filter(|load| load.set == *set) {
                // It acts along the normal of the shell, `pressure` against the director.
                let value = vec![-factor * load.value];
                out.push(Load {
                    card: load.card,
                    kind: "pressure",
                    on: Some(load.name.clone()),
                    value,
                    line: load.line,
                });
            }
            for (_, acceleration, line) in self.gravity.iter().filter(|load| load.0 == *set) {
                let (sum, _) = fall.get_or_insert(([0.0; 3], *line));
                for (total, along) in sum.iter_mut().zip(acceleration) {
                    *total += factor * along;
                }
            }
        }
        if let Some((value, line)) = fall {
            out.push(Load { card: "GRAV", kind: "gravity", on: None, value: value.to_vec(), line });
        }
        Ok(out)
    }
}
