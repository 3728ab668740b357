//! Result folders as a user reads them: the summary, histories and VTU files, decoded apart from their writers.

use std::collections::BTreeMap;
use std::fs;
use std::io::Read as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use tegula::{Error, Result, Vec3};

use super::reference::{Record, records};
use super::statistics::{Counters, note};
use tegula_io::deck::Deck;
use tegula_io::job::{self, JobOptions, Unwatched};

/// Results of a run in a folder of its own, which vanishes with them.
pub struct Results(tempfile::TempDir);

impl Results {
    /// Runs the text of a model file as `tegula run` does.
    pub fn of(text: &str) -> Result<Self> {
        let outside = |e: &dyn std::fmt::Display| Error::Outside(e.to_string());
        let folder = tempfile::tempdir().map_err(|e| outside(&e))?;
        let path = folder.path().join("model.toml");
        fs::write(&path, text).map_err(|e| outside(&e))?;
        let deck = Deck::read(&path).map_err(|problems| {
            let problems: Vec<String> = problems.iter().map(ToString::to_string).collect();
            Error::Outside(problems.join("\n"))
        })?;
        let options = JobOptions { folder: folder.path().join("results"), resume: false, force: false };
        let summary = job::run(&deck, &options, &mut Unwatched).map_err(|e| outside(&e))?;
        note(Counters {
            analysis: "run",
            unknowns: summary.unknowns,
            steps: summary.steps,
            iterations: summary.iterations,
            factorizations: summary.factorizations,
            cutbacks: summary.cutbacks,
        });
        Ok(Self(folder))
    }

    fn text(&self, name: &str) -> Result<String> {
        let path = self.0.path().join("results").join(name);
        fs::read_to_string(&path).map_err(|e| Error::Outside(format!("{}: {e}", path.display())))
    }

    /// Number of `summary.json` at a path of keys and places; NaN if there is none.
    pub fn summary(&self, path: &str) -> Result<f64> {
        let all: Value = serde_json::from_str(&self.text("summary.json")?)
            .map_err(|e| Error::Outside(format!("summary.json: {e}")))?;
        Ok(all.pointer(path).and_then(Value::as_f64).unwrap_or(f64::NAN))
    }

    /// Rows of a table such as `history.csv`.
    pub fn table(&self, name: &str) -> Result<Vec<Record>> {
        Ok(records(&self.text(name)?))
    }

    /// Last frame of a series such as `fields.pvd`: the file that it names last.
    pub fn last_frame(&self, series: &str) -> Result<Frame> {
        let list = self.text(series)?;
        let name = list.rsplit_once("file=\"").and_then(|(_, rest)| rest.split_once('"'));
        let (name, _) = name.ok_or_else(|| Error::Outside(format!("{series} names no file")))?;
        self.frame(name)
    }

    /// Frame of a VTU file.
    pub fn frame(&self, name: &str) -> Result<Frame> {
        Frame::parse(&self.text(name)?).ok_or_else(|| Error::Outside(format!("{name} cannot be read")))
    }
}

/// A mesh with its fields, as a VTU file holds them.
pub struct Frame {
    points: Vec<Vec3>,
    cells: Vec<[usize; 4]>,
    /// Arrays of the points by name: components and values.
    at_points: BTreeMap<String, (usize, Vec<f64>)>,
    at_cells: BTreeMap<String, (usize, Vec<f64>)>,
}

impl Frame {
    /// Decodes a file of one piece of quadrilaterals.
    fn parse(text: &str) -> Option<Self> {
        let (head, data) = text.split_once("<AppendedData encoding=\"base64\">")?;
        let data = data.trim_start().strip_prefix('_')?;
        let floats = |section: &str| -> Option<BTreeMap<String, (usize, Vec<f64>)>> {
            let arrays = arrays(head, section)?.into_iter();
            arrays
                .map(|a| Some((a.name.clone(), (a.components, a.numbers(data, f64::from_le_bytes)?))))
                .collect()
        };
        let cells = arrays(head, "Cells")?;
        let nodes = cells.iter().find(|a| a.name == "connectivity")?.numbers(data, i64::from_le_bytes)?;
        let points = floats("Points")?.into_values().next()?.1;
        Some(Self {
            points: points.chunks_exact(3).map(Vec3::from_column_slice).collect(),
            cells: nodes.chunks_exact(4).map(|c| [0, 1, 2, 3].map(|k| c[k] as usize)).collect(),
            at_points: floats("PointData")?,
            at_cells: floats("CellData")?,
        })
    }

    /// Values of a cell array in the cell whose centre is nearest to a place; NaN if there is no such array.
    pub fn in_cell<const N: usize>(&self, array: &str, place: [f64; 3]) -> [f64; N] {
        let centre = |c: &[usize; 4]| c.iter().filter_map(|&p| self.points.get(p)).sum::<Vec3>() / 4.0;
        values(&self.at_cells, array, nearest(self.cells.iter().map(centre), place))
    }

    /// Values of a point array at the point nearest to a place; NaN if there is no such array. A coordinate of the place that
    /// is NaN does not count: points may be drawn where they have moved to.
    pub fn at_point<const N: usize>(&self, array: &str, place: [f64; 3]) -> [f64; N] {
        values(&self.at_points, array, nearest(self.points.iter().copied(), place))
    }
}

fn nearest(points: impl Iterator<Item = Vec3>, place: [f64; 3]) -> usize {
    let known =
        |x: Vec3| (0..3).filter(|&i| !place[i].is_nan()).map(move |i| (x[i] - place[i]).powi(2)).sum::<f64>();
    let distances = points.map(known).enumerate();
    distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(i, _)| i)
}

fn values<const N: usize>(
    arrays: &BTreeMap<String, (usize, Vec<f64>)>,
    name: &str,
    place: usize,
) -> [f64; N] {
    match arrays.get(name) {
        Some((components, all)) if *components == N => {
            std::array::from_fn(|i| all.get(N * place + i).copied().unwrap_or(f64::NAN))
        }
        _ => [f64::NAN; N],
    }
}

/// An array of the appended data, as its tag announces it.
struct Announced {
    name: String,
    components: usize,
    offset: usize,
}

/// Arrays of a section of the file.
fn arrays(head: &str, section: &str) -> Option<Vec<Announced>> {
    let (_, rest) = head.split_once(&format!("<{section}>"))?;
    let (inside, _) = rest.split_once(&format!("</{section}>"))?;
    let attribute = |tag: &str, name: &str| {
        let (_, rest) = tag.split_once(&format!(" {name}=\""))?;
        Some(rest.split_once('"')?.0.to_owned())
    };
    inside
        .split("<DataArray")
        .skip(1)
        .map(|tag| {
            Some(Announced {
                name: attribute(tag, "Name")?,
                components: attribute(tag, "NumberOfComponents").map_or(Some(1), |n| n.parse().ok())?,
                offset: attribute(tag, "offset")?.parse().ok()?,
            })
        })
        .collect()
}

impl Announced {
    /// Numbers of eight bytes: a header of block sizes in base64, then the blocks, compressed by zlib, in base64.
    fn numbers<T>(&self, data: &str, from: fn([u8; 8]) -> T) -> Option<Vec<T>> {
        let own = data.get(self.offset..)?;
        let decoded = |from: usize, bytes: usize| {
            let characters = bytes.div_ceil(3) * 4;
            Some((STANDARD.decode(own.get(from..from + characters)?).ok()?, from + characters))
        };
        let word = |bytes: &[u8], i: usize| {
            let word = bytes.get(8 * i..8 * i + 8)?.try_into().ok()?;
            usize::try_from(u64::from_le_bytes(word)).ok()
        };
        // The number of blocks, alone: a header of 24 bytes and 8 more a block.
        let blocks = word(&STANDARD.decode(own.get(..12)?).ok()?, 0)?;
        let (header, start) = decoded(0, 8 * (3 + blocks))?;
        let sizes: Option<Vec<usize>> = (0..blocks).map(|k| word(&header, 3 + k)).collect();
        let sizes = sizes?;
        let (compressed, _) = decoded(start, sizes.iter().sum())?;
        let (mut at, mut bytes) = (0, Vec::new());
        for size in sizes {
            let block = compressed.get(at..at + size)?;
            flate2::read::ZlibDecoder::new(block).read_to_end(&mut bytes).ok()?;
            at += size;
        }
        Some(bytes.as_chunks::<8>().0.iter().map(|b| from(*b)).collect())
    }
}
