//! Shapes of a report: meshes with their fields at several instants, read from the lists of field files.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::blocks::{Block, Blocks, Rounded};
use super::marks::Mark;
use crate::out::vtu_file::{ArrayHead, Place, VtuFile};
use crate::out::{OutputError, PvdSeries};

/// Largest number of instants in a scene.
const MOST_INSTANTS: usize = 400;
/// Fields that are frames, numbers or directions, which nobody looks at as colours.
const NOT_SHOWN: [&str; 10] = [
    "displacement",
    "director",
    "director_change",
    "axis_x",
    "axis_y",
    "axis_z",
    "node",
    "element",
    "section",
    "part",
];
/// Fields that come first where not all have room.
const FIRST: [&str; 8] = [
    "von_mises",
    "reserve_factor",
    "tsai_wu",
    "plastic_strain",
    "max_stress",
    "critical_ply",
    "energy_density",
    "velocity",
];

/// Kind of the instants of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Kind {
    /// States in the course of an analysis.
    States,
    /// Shapes of modes, which are animated.
    Modes,
    /// Reference configuration of a model, with marks.
    Model,
}

/// List of field files, and what they show.
#[derive(Debug, Clone, Copy)]
pub(super) struct List<'a> {
    /// Heading.
    pub name: &'a str,
    /// List of the shells.
    pub shells: &'a str,
    /// List of the outlines of bodies, beams and springs.
    pub bodies: &'a str,
    /// Kind of its files.
    pub kind: Kind,
    /// Meaning of the time value of a file.
    pub parameter: &'a str,
    /// Whether the files contain the deformed mesh.
    pub deformed: bool,
    /// Bytes of the displacements before compression, at most: the number of instants is reduced for it.
    pub most_bytes: usize,
}

/// Shapes that are shown one after another.
#[derive(Debug, Serialize)]
pub(super) struct Scene {
    /// Heading.
    pub name: String,
    /// Kind of the instants.
    pub kind: Kind,
    /// Meaning of their time values.
    pub parameter: String,
    /// Time value of each instant.
    pub values: Vec<f64>,
    /// Label of each instant, where it has one.
    pub labels: Vec<String>,
    /// Number of instants in the files.
    pub available: usize,
    /// Shells, then bodies.
    pub meshes: Vec<SceneMesh>,
    /// Fields that had no room.
    pub left_out: Vec<String>,
    /// Supports, loads, joints and sets that can be shown.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub marks: Vec<Mark>,
}

/// Mesh with its fields at the instants of its scene.
#[derive(Debug, Serialize)]
pub(super) struct SceneMesh {
    /// Whether it shows the outline of bodies, which have one colour.
    pub outline: bool,
    /// Number of points.
    pub points: usize,
    /// Coordinates without displacement, in single precision: of all instants, or of each one where the modes are about different states.
    pub references: Vec<Block>,
    /// Corners of the cells.
    pub quads: Block,
    /// Ends of the lines.
    pub lines: Block,
    /// Displacement along x, y and z.
    pub displacement: Option<[Rounded; 3]>,
    /// Fields by which the mesh can be coloured.
    pub fields: Vec<SceneField>,
}

/// Field by which a mesh is coloured.
#[derive(Debug, Serialize)]
pub(super) struct SceneField {
    /// Name as in the files.
    pub name: String,
    /// Whether it has values at points, else on cells.
    pub at_points: bool,
    /// Its components with their names.
    pub components: Vec<(String, Rounded)>,
    /// Names of its values 0, 1, 2, …, where they are no quantities but numbers of something.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub categories: Vec<String>,
}

/// Files of a list, those of each instant that is shown.
struct Files {
    times: Vec<f64>,
    paths: Vec<PathBuf>,
}

impl Files {
    fn read(folder: &Path, list: &str) -> Result<Option<Self>, OutputError> {
        let path = folder.join(list);
        if !path.is_file() {
            return Ok(None);
        }
        let series = PvdSeries::open(&path)?;
        let there = series.entries().iter().map(|(time, file)| (*time, folder.join(file)));
        let (times, paths): (Vec<f64>, Vec<PathBuf>) = there.filter(|(_, path)| path.is_file()).unzip();
        Ok((!paths.is_empty()).then_some(Self { times, paths }))
    }

    /// Values of an array of `count` numbers at all instants; gaps where a file has none.
    fn values(&self, array: &ArrayHead, count: usize) -> Result<Vec<Vec<f64>>, OutputError> {
        let same =
            |a: &&ArrayHead| (a.place, &a.name, a.components) == (array.place, &array.name, array.components);
        let mut values =
            self.each(|file| file.arrays.iter().find(same).map_or(Ok(Vec::new()), |own| file.values(own)))?;
        values.iter_mut().for_each(|values| values.resize(count, f64::NAN));
        Ok(values)
    }

    fn each(
        &self,
        values: impl Fn(&VtuFile) -> Result<Vec<f64>, OutputError>,
    ) -> Result<Vec<Vec<f64>>, OutputError> {
        self.paths.iter().map(|path| values(&VtuFile::open(path)?)).collect()
    }
}

/// Numbers that are shown of `count`: at most `most`, evenly spaced, the first and the last among them.
pub(super) fn shown(count: usize, most: usize) -> Vec<usize> {
    let most = most.max(2);
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|i| (i * (count - 1) + (most - 1) / 2) / (most - 1)).collect()
}

/// Reads a scene; `None` where the folder has no such files. Fields beyond the displacement are added while all blocks have at most
/// `most` characters.
pub(super) fn read(
    folder: &Path,
    list: List<'_>,
    blocks: &mut Blocks,
    most: usize,
) -> Result<Option<Scene>, OutputError> {
    let mut files: Vec<(bool, Files)> = Vec::new();
    for (outline, name) in [(false, list.shells), (true, list.bodies)] {
        files.extend(Files::read(folder, name)?.map(|found| (outline, found)));
    }
    // A run that was killed, or that goes on, may have written one of the lists further than the other one.
    let times: Vec<Vec<f64>> = files.iter().map(|(_, files)| files.times.clone()).collect();
    let Some((first, others)) = times.split_first() else { return Ok(None) };
    let times: Vec<f64> =
        first.iter().copied().filter(|t| others.iter().all(|other| other.contains(t))).collect();
    if times.is_empty() {
        return Ok(None);
    }
    let mut points = 0;
    for (_, files) in &files {
        points += VtuFile::open(&files.paths[0])?.points;
    }
    let available = times.len();
    let most_instants = MOST_INSTANTS.min(list.most_bytes / (6 * points.max(1)));
    let instants = match list.kind {
        Kind::States => shown(available, most_instants),
        Kind::Modes | Kind::Model => (0..available.min(most_instants.max(2))).collect(),
    };
    let values: Vec<f64> = instants.iter().filter_map(|&i| times.get(i).copied()).collect();
    let mut scene = Scene {
        name: list.name.into(),
        kind: list.kind,
        parameter: list.parameter.into(),
        labels: Vec::new(),
        available,
        meshes: Vec::new(),
        left_out: Vec::new(),
        marks: Vec::new(),
        values,
    };
    files.iter_mut().for_each(|(_, files)| files.keep(&scene.values));
    for (outline, files) in &files {
        scene.meshes.push(mesh(files, *outline, list, blocks)?);
    }
    for ((_, files), mesh) in files.iter().zip(&mut scene.meshes).filter(|((outline, _), _)| !outline) {
        fields(files, mesh, blocks, most, &mut scene.left_out)?;
    }
    Ok(Some(scene))
}

impl Files {
    /// Keeps the files at these times.
    fn keep(&mut self, times: &[f64]) {
        let found: Vec<(f64, PathBuf)> = times
            .iter()
            .filter_map(|time| {
                let at = self.times.iter().position(|t| t == time)?;
                Some((*time, self.paths[at].clone()))
            })
            .collect();
        (self.times, self.paths) = found.into_iter().unzip();
    }
}

/// Mesh with its displacements, without other fields.
fn mesh(files: &Files, outline: bool, list: List<'_>, blocks: &mut Blocks) -> Result<SceneMesh, OutputError> {
    let first = VtuFile::open(&files.paths[0])?;
    let flat = |file: &VtuFile| Ok(file.coordinates()?.into_iter().flatten().collect::<Vec<f64>>());
    let count = 3 * first.points;
    let array = first.arrays.iter().find(|a| a.name == "displacement" && a.components == 3);
    let mut references = vec![flat(&first)?];
    let displacements = match (list.kind, list.deformed, array) {
        (Kind::Modes | Kind::Model, ..) => {
            // Modes of critical points are each about a state of their own.
            let all =
                files.paths.iter().map(|path| flat(&VtuFile::open(path)?)).collect::<Result<Vec<_>, _>>()?;
            if all.iter().any(|points| *points != references[0]) {
                references = all;
            }
            array.map(|array| files.values(array, count)).transpose()?
        }
        (Kind::States, false, array) => array.map(|array| files.values(array, count)).transpose()?,
        (Kind::States, true, array) => {
            if let Some(array) = array {
                references[0].iter_mut().zip(first.values(array)?).for_each(|(x, u)| *x -= u);
            }
            let moved =
                |file: &VtuFile| Ok(flat(file)?.iter().zip(&references[0]).map(|(x, x0)| x - x0).collect());
            Some(files.each(moved)?)
        }
    };
    let cells = first.cells()?;
    let displacement = displacements.map(|all| [0, 1, 2].map(|c| blocks.rounded(&component(&all, c, 3))));
    Ok(SceneMesh {
        outline,
        points: first.points,
        references: references.iter().map(|points| blocks.singles(points)).collect(),
        quads: blocks.indices(cells.quads.iter().flatten()),
        lines: blocks.indices(cells.lines.iter().flatten()),
        displacement,
        fields: Vec::new(),
    })
}

/// One component of values at all instants.
fn component(instants: &[Vec<f64>], index: usize, components: usize) -> Vec<Vec<f64>> {
    instants.iter().map(|values| values.iter().skip(index).step_by(components).copied().collect()).collect()
}

/// Adds the fields of a mesh while they have room.
fn fields(
    files: &Files,
    mesh: &mut SceneMesh,
    blocks: &mut Blocks,
    most: usize,
    left_out: &mut Vec<String>,
) -> Result<(), OutputError> {
    let first = VtuFile::open(&files.paths[0])?;
    let mut arrays: Vec<&ArrayHead> =
        first.arrays.iter().filter(|a| !NOT_SHOWN.contains(&a.name.as_str())).collect();
    arrays.sort_by_key(|a| FIRST.iter().position(|name| *name == a.name).unwrap_or(FIRST.len()));
    for array in arrays {
        let count = if array.place == Place::Points { first.points } else { first.cells };
        if blocks.size + 2 * Blocks::CHARACTERS * count * array.components * files.paths.len() / 100 > most {
            left_out.push(array.name.clone());
            continue;
        }
        let all = files.values(array, count * array.components)?;
        let name = |i: usize| match (array.components, array.component_names.get(i)) {
            (_, Some(name)) => name.clone(),
            (3, None) => ["x", "y", "z"][i].to_owned(),
            (1, None) => String::new(),
            (_, None) => (i + 1).to_string(),
        };
        let components = (0..array.components)
            .map(|i| (name(i), blocks.rounded(&component(&all, i, array.components))))
            .collect();
        mesh.fields.push(SceneField {
            name: array.name.clone(),
            at_points: array.place == Place::Points,
            components,
            categories: Vec::new(),
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_and_the_last_instant_are_always_shown() {
        assert_eq!(shown(3, 5), [0, 1, 2]);
        assert_eq!(shown(11, 3), [0, 5, 10]);
        assert_eq!(shown(10, 0), [0, 9]);
        assert_eq!(shown(0, 4), [] as [usize; 0]);
        for (count, most) in [(1000, 400), (401, 400), (7, 6)] {
            let found = shown(count, most);
            assert_eq!((found.len(), found[0], found[most - 1]), (most, 0, count - 1));
            assert!(found.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}
