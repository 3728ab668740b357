//! Instants of a result folder, read from its lists of field files.

use std::path::{Path, PathBuf};

use super::{At, DIGITS, Drawing, SIZE_OF_A_MODE};
use crate::job::Summary;
use crate::job::drawn_outline::{corners_of_lines, faces_of_lines};
use crate::out::numbers::significant;
use crate::out::vtu_file::{ArrayHead, Place, VtuFile};
use crate::out::{OutputError, PvdSeries};
use tegula::norm::larger;

/// Shape at one instant.
#[derive(Debug, Clone)]
pub(super) struct Instant {
    /// Name of the instant.
    pub label: String,
    /// Points of shells, then of bodies, without displacement.
    reference: Vec<[f64; 3]>,
    displacement: Vec<[f64; 3]>,
    /// Values of the field on elements or at points.
    pub values: Option<Vec<f64>>,
}

impl Instant {
    /// Positions with the displacements times a factor.
    pub fn positions(&self, scale: f64) -> Vec<[f64; 3]> {
        let moved = |(x, u): (&[f64; 3], &[f64; 3])| std::array::from_fn(|i| x[i] + scale * u[i]);
        self.reference.iter().zip(&self.displacement).map(moved).collect()
    }

    fn largest_displacement(&self) -> f64 {
        self.displacement.iter().map(|u| u.iter().map(|x| x * x).sum::<f64>().sqrt()).fold(0.0, larger)
    }

    fn extent(&self) -> f64 {
        let side = |i: usize| {
            let range = self
                .reference
                .iter()
                .map(|x| x[i])
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
            range[1] - range[0]
        };
        (0..3).map(side).fold(0.0, larger)
    }
}

/// Points without displacement, and their displacements.
type Moved = (Vec<[f64; 3]>, Vec<[f64; 3]>);

/// Field that gives the colours.
struct Field {
    array: ArrayHead,
    /// Component; the size of the vector without one.
    component: Option<usize>,
    name: String,
}

/// Field files of a result.
pub(super) struct Source {
    folder: PathBuf,
    summary: Summary,
    modes: bool,
    /// Whether the files have displacements.
    displaced: bool,
    /// Time value of each instant with its file, and with that of the bodies.
    instants: Vec<(f64, PathBuf, Option<PathBuf>)>,
    field: Option<Field>,
    quads: Vec<[u32; 4]>,
    bodies: Vec<[u32; 4]>,
    /// Lines of the outline of bodies, as indices of its own points, and their width counts by the size of the model (length).
    lines: Vec<[u32; 2]>,
    length: f64,
}

impl Source {
    /// Opens the states of a result folder, or its modes.
    pub fn open(folder: &Path, drawing: &Drawing) -> Result<Self, OutputError> {
        let summary = Summary::read(folder)?;
        let modes = matches!(drawing.at, At::Mode(_))
            || summary.frequencies_hz.is_some()
            || summary.load_factors.is_some();
        let lists = if modes { ["modes.pvd", "mode_bodies.pvd"] } else { ["fields.pvd", "bodies.pvd"] };
        let [shells, bodies] = lists.map(|list| list_of(folder, list));
        let (shells, bodies) = (shells?, bodies?);
        let of_body = |time: &f64| bodies.iter().find(|(t, _)| t == time).map(|(_, file)| file.clone());
        let instants: Vec<_> = if shells.is_empty() {
            bodies.iter().map(|(time, file)| (*time, file.clone(), None)).collect()
        } else {
            shells.iter().map(|(time, file)| (*time, file.clone(), of_body(time))).collect()
        };
        let Some((_, first, outline)) = instants.first() else {
            let what = if modes { "modes" } else { "states" };
            let steps: Vec<String> =
                summary.analyses.iter().map(|step| format!("`{}`", step.folder)).collect();
            let remedy = if steps.is_empty() {
                "Give the result folder of a run with field files".to_owned()
            } else {
                format!("Give the folder of one of its steps: {}", steps.join(", "))
            };
            return Err(OutputError::damaged(
                folder,
                format!("it has no field files of {what}: `{}` names none that is there", lists[0]),
                remedy,
            ));
        };
        let file = VtuFile::open(first)?;
        let cells = file.cells()?;
        let displaced = file.arrays.iter().any(|a| a.name == "displacement" && a.components == 3);
        if !displaced && drawing.scale.is_some() {
            let problem = "it has no field `displacement`, which could be enlarged";
            return Err(OutputError::damaged(
                first,
                problem,
                "Leave the factor out, or add the field to `output.fields`",
            ));
        }
        if let Some(name) = drawing.field.as_ref().filter(|name| shells.is_empty() && *name != "none") {
            let problem = format!("bodies alone have one colour, not the field `{name}`");
            return Err(OutputError::damaged(folder, problem, "Leave the field out"));
        }
        let field = if shells.is_empty() { None } else { field(&file, drawing.field.as_deref(), first)? };
        let of_bodies = match (shells.is_empty(), outline) {
            (true, _) => Some((cells.clone(), file.points, 0)),
            (false, Some(outline)) => {
                let outline = VtuFile::open(outline)?;
                Some((outline.cells()?, outline.points, file.points))
            }
            (false, None) => None,
        };
        let (mut bodies, mut lines) = (Vec::new(), Vec::new());
        if let Some((outline, points, before)) = of_bodies {
            bodies.extend(outline.quads.iter().map(|quad| quad.map(|n| n + before as u32)));
            bodies.extend(faces_of_lines(outline.lines.len(), before + points));
            lines = outline.lines;
        }
        let quads = if shells.is_empty() { Vec::new() } else { cells.quads };
        let mut out = Self {
            folder: folder.to_owned(),
            modes,
            displaced,
            instants,
            field,
            quads,
            bodies,
            lines,
            length: 0.0,
            summary,
        };
        out.length = out.instant(0)?.extent();
        Ok(out)
    }

    /// Number of instants.
    pub fn len(&self) -> usize {
        self.instants.len()
    }

    /// Whether the files have displacements.
    pub fn has_displacements(&self) -> bool {
        self.displaced
    }

    /// Whether the instants are modes.
    pub fn is_modes(&self) -> bool {
        self.modes
    }

    /// Summary of the run.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// Elements.
    pub fn quads(&self) -> &[[u32; 4]] {
        &self.quads
    }

    /// Faces of bodies.
    pub fn bodies(&self) -> &[[u32; 4]] {
        &self.bodies
    }

    /// Whether the field has values at points.
    pub fn is_at_nodes(&self) -> bool {
        self.field.as_ref().is_some_and(|field| field.array.place == Place::Points)
    }

    /// Name of the field beside the colours.
    pub fn label(&self) -> String {
        self.field.as_ref().map(|field| field.name.replace('_', " ")).unwrap_or_default()
    }

    /// Number of the instant that is wanted.
    pub fn nearest(&self, at: At) -> Result<usize, OutputError> {
        let last = self.instants.len() - 1;
        match at {
            At::Default if self.modes => {
                // Rigid motions come first, and show nothing.
                let frequency = |mode: f64| {
                    let number = (mode as usize).checked_sub(1)?;
                    self.summary.frequencies_hz.as_ref()?.get(number).copied()
                };
                let moves =
                    |(mode, ..): &(f64, PathBuf, Option<PathBuf>)| frequency(*mode).is_none_or(|f| f > 0.0);
                Ok(self.instants.iter().position(moves).unwrap_or(0))
            }
            At::Default => Ok(last),
            At::Mode(number) => {
                let is = |(value, ..): &(f64, PathBuf, Option<PathBuf>)| value.floor() == number as f64;
                // Complex modes have two shapes each.
                let count = self.instants.iter().filter(|(value, ..)| value.fract() == 0.0).count();
                self.instants.iter().position(is).ok_or_else(|| {
                    OutputError::damaged(
                        &self.folder,
                        format!("it has no files of mode {number}, but of {count} modes"),
                        "Ask for one of these",
                    )
                })
            }
            At::Value(_) if self.modes => {
                Err(OutputError::damaged(&self.folder, "modes have no time", "Choose one by its number"))
            }
            At::Value(wanted) => {
                let distance = |i: &usize| (self.instants[*i].0 - wanted).abs();
                (0..=last).min_by(|a, b| distance(a).total_cmp(&distance(b))).ok_or_else(|| {
                    OutputError::damaged(&self.folder, "it has no states", "Run the model again")
                })
            }
        }
    }

    /// Factor on the displacements.
    pub fn scale(&self, drawing: &Drawing, instant: &Instant) -> f64 {
        if let Some(scale) = drawing.scale {
            return scale;
        }
        let largest = instant.largest_displacement();
        if self.modes && largest > 0.0 { SIZE_OF_A_MODE * instant.extent() / largest } else { 1.0 }
    }

    /// The instant of a vibration at which the displacements of its shape are multiplied by `factor`. Values without a sign, as stresses of von Mises
    /// and sizes of vectors, keep it; energies are quadratic.
    pub fn vibrating(&self, shape: &Instant, factor: f64) -> Instant {
        let signed = shape.values.iter().flatten().any(|value| *value < 0.0);
        let quadratic = self.field.as_ref().is_some_and(|field| field.array.name == "energy_density");
        let factor = if quadratic {
            factor * factor
        } else if signed {
            factor
        } else {
            factor.abs()
        };
        let values = shape.values.as_ref().map(|values| values.iter().map(|x| x * factor).collect());
        Instant { values, ..shape.clone() }
    }

    /// Reads an instant.
    pub fn instant(&self, number: usize) -> Result<Instant, OutputError> {
        let (value, shells, outline) = &self.instants[number];
        let file = VtuFile::open(shells)?;
        let (mut reference, mut displacement) = self.points(&file)?;
        let mut values = match &self.field {
            None => None,
            Some(field) => Some(field.values(&file, shells)?),
        };
        let of_bodies =
            if self.quads.is_empty() { Some((reference.clone(), displacement.clone())) } else { None };
        let of_bodies = match outline {
            Some(outline) => Some(self.points(&VtuFile::open(outline)?)?),
            None => of_bodies,
        };
        if let Some((points, moved)) = of_bodies {
            let ends = |of: &[[f64; 3]]| {
                self.lines
                    .iter()
                    .flat_map(|line| line.map(|end| [of[end as usize]; 4]))
                    .flatten()
                    .collect::<Vec<_>>()
            };
            let corners = (corners_of_lines(&points, &self.lines, self.length), ends(&moved));
            if outline.is_some() {
                reference.extend(points);
                displacement.extend(moved);
            }
            reference.extend(corners.0);
            displacement.extend(corners.1);
        }
        if let Some(values) = values.as_mut().filter(|_| self.is_at_nodes()) {
            values.resize(reference.len(), f64::NAN);
        }
        Ok(Instant { label: self.name(*value), reference, displacement, values })
    }

    /// Points without displacement, and their displacements.
    fn points(&self, file: &VtuFile) -> Result<Moved, OutputError> {
        let mut points = file.coordinates()?;
        let array = file.arrays.iter().find(|a| a.name == "displacement" && a.components == 3);
        let moved: Vec<[f64; 3]> = match array {
            Some(array) => file.values(array)?.chunks_exact(3).map(|u| [u[0], u[1], u[2]]).collect(),
            None => vec![[0.0; 3]; points.len()],
        };
        if self.summary.deformed && !self.modes {
            for (x, u) in points.iter_mut().zip(&moved) {
                (0..3).for_each(|i| x[i] -= u[i]);
            }
        }
        Ok((points, moved))
    }

    fn name(&self, value: f64) -> String {
        let found = self.summary.frequencies_hz.as_ref().map(|f| (f, "f"));
        let found = found.or(self.summary.load_factors.as_ref().map(|f| (f, "λ")));
        match (self.modes, found) {
            (true, found) => {
                let number = value.floor();
                let of = found
                    .and_then(|(list, letter)| Some((list.get((number as usize).checked_sub(1)?)?, letter)));
                of.map_or(format!("mode {number}"), |(x, letter)| {
                    format!("mode {number}: {letter} = {}", significant(*x, DIGITS))
                })
            }
            (false, _) => match self.summary.analysis.as_str() {
                "transient" => format!("t = {}", significant(value, DIGITS)),
                "path" => format!("position {}", significant(value, DIGITS)),
                _ => format!("load factor {}", significant(value, DIGITS)),
            },
        }
    }
}

impl Field {
    /// Values of the component, or sizes of vectors.
    fn values(&self, file: &VtuFile, path: &Path) -> Result<Vec<f64>, OutputError> {
        let same = |a: &&ArrayHead| {
            (a.place, &a.name, a.components) == (self.array.place, &self.array.name, self.array.components)
        };
        let Some(own) = file.arrays.iter().find(same) else {
            return Err(OutputError::damaged(
                path,
                format!("it has no field `{}`, as the first file of the list does", self.array.name),
                "Choose another field",
            ));
        };
        let all = file.values(own)?;
        let of = |values: &[f64]| match self.component {
            Some(component) => values[component],
            None => values.iter().map(|x| x * x).sum::<f64>().sqrt(),
        };
        Ok(if own.components == 1 { all } else { all.chunks_exact(own.components).map(of).collect() })
    }
}

/// Times and files of a list that are there.
fn list_of(folder: &Path, list: &str) -> Result<Vec<(f64, PathBuf)>, OutputError> {
    let path = folder.join(list);
    if !path.is_file() {
        return Ok(Vec::new());
    }
    let series = PvdSeries::open(&path)?;
    let files = series.entries().iter().map(|(time, file)| (*time, folder.join(file)));
    Ok(files.filter(|(_, file)| file.is_file()).collect())
}

/// The field that a name means.
fn field(file: &VtuFile, wanted: Option<&str>, path: &Path) -> Result<Option<Field>, OutputError> {
    let find = |name: &str| file.arrays.iter().find(|a| a.name == name).cloned();
    let Some(wanted) = wanted else {
        let first = ["von_mises", "displacement"].into_iter().find_map(find);
        return Ok(first.map(|array| Field { name: array.name.clone(), component: None, array }));
    };
    if wanted == "none" {
        return Ok(None);
    }
    let refuse = |problem: String| {
        let names: Vec<String> = file.arrays.iter().map(|a| a.name.clone()).collect();
        OutputError::damaged(path, problem, format!("It has the fields {}", names.join(", ")))
    };
    if let Some(array) = find(wanted) {
        return Ok(Some(Field { name: wanted.into(), component: None, array }));
    }
    let Some((array, component)) = wanted.rsplit_once('.').and_then(|(name, part)| Some((find(name)?, part)))
    else {
        return Err(refuse(format!("it has no field `{wanted}`")));
    };
    let named = array.component_names.iter().position(|name| name == component);
    let by_axis =
        || ["x", "y", "z"].iter().position(|axis| *axis == component).filter(|_| array.components == 3);
    let by_number =
        || component.parse::<usize>().ok().and_then(|n| n.checked_sub(1)).filter(|n| *n < array.components);
    match named.or_else(by_axis).or_else(by_number) {
        Some(component) => Ok(Some(Field { name: wanted.into(), component: Some(component), array })),
        None => {
            let names = if array.component_names.is_empty() {
                format!("1 to {}", array.components)
            } else {
                array.component_names.join(", ")
            };
            Err(refuse(format!(
                "the field `{}` has no component `{component}` (components: {names})",
                array.name
            )))
        }
    }
}
