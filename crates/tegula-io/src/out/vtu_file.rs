//! Reads back the files of [`vtu`](super::vtu).

use std::io::Read as _;
use std::ops::Range;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;
use roxmltree::{Document, Node};

use super::file::OutputError;
use super::vtu::{VTK_LINE, VTK_QUAD, VTK_TRIANGLE};

/// Points or cells, to which an array belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Points of the grid.
    Points,
    /// Cells of the grid.
    Cells,
}

/// An array of numbers in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ArrayHead {
    /// Points or cells.
    pub place: Place,
    /// Name.
    pub name: String,
    /// Numbers per point or cell.
    pub components: usize,
    /// Names of the components; empty where the file has none.
    pub component_names: Vec<String>,
    offset: usize,
}

/// Cells of a grid, as indices of points.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Cells {
    /// Corners of quadrilaterals; the last corner of a triangle stands twice.
    pub quads: Vec<[u32; 4]>,
    /// Ends of lines, which stand behind the quadrilaterals.
    pub lines: Vec<[u32; 2]>,
}

/// A file of [`vtu::write`](super::vtu::write) whose arrays are decoded on demand.
#[derive(Debug)]
pub struct VtuFile {
    path: PathBuf,
    text: String,
    appended: Range<usize>,
    /// Number of points.
    pub points: usize,
    /// Number of cells.
    pub cells: usize,
    /// Fields on points and cells, in the order of the file.
    pub arrays: Vec<ArrayHead>,
    coordinates: usize,
    connectivity: usize,
    offsets: usize,
    types: usize,
}

impl VtuFile {
    /// Opens a file.
    ///
    /// # Errors
    /// It cannot be read, or was not written by this program.
    pub fn open(path: &Path) -> Result<Self, OutputError> {
        let text = std::fs::read_to_string(path).map_err(|cause| OutputError::read(path, cause))?;
        Self::parse(path, text).map_err(|problem| damaged(path, problem))
    }

    fn parse(path: &Path, text: String) -> Result<Self, String> {
        let document = Document::parse(&text).map_err(|e| format!("it is not XML: {e}"))?;
        let root = document.root_element();
        if root.attribute("compressor") != Some("vtkZLibDataCompressor")
            || root.attribute("header_type") != Some("UInt64")
        {
            return Err("its arrays are not encoded as this program writes them".into());
        }
        let find = |name: &str| {
            root.descendants().find(|n| n.has_tag_name(name)).ok_or_else(|| format!("it has no `{name}`"))
        };
        let data = find("AppendedData")?;
        let content = data.first_child().ok_or("its section `AppendedData` is empty")?.range();
        let marker =
            text.get(content.clone()).and_then(|t| t.find('_')).ok_or("its data have no beginning")?;
        let piece = find("Piece")?;
        let count = |name: &str| -> Result<usize, String> {
            piece.attribute(name).and_then(|n| n.parse().ok()).ok_or_else(|| format!("it has no `{name}`"))
        };
        let (points, cells) = (count("NumberOfPoints")?, count("NumberOfCells")?);
        let mut arrays = Vec::new();
        for (place, name) in [(Place::Points, "PointData"), (Place::Cells, "CellData")] {
            for node in find(name)?.children().filter(|n| n.has_tag_name("DataArray")) {
                arrays.push(head(place, &node)?);
            }
        }
        let of_grid = |section: &str, name: &str| -> Result<usize, String> {
            let arrays = find(section)?;
            let array = arrays.children().find(|n| n.attribute("Name") == Some(name));
            offset(&array.ok_or_else(|| format!("it has no array `{name}`"))?)
        };
        let coordinates = of_grid("Points", "Points")?;
        let [connectivity, offsets, types] =
            ["connectivity", "offsets", "types"].map(|n| of_grid("Cells", n));
        let (connectivity, offsets, types) = (connectivity?, offsets?, types?);
        let appended = content.start + marker + 1..content.end;
        drop(document);
        let path = path.to_owned();
        Ok(Self { path, text, appended, points, cells, arrays, coordinates, connectivity, offsets, types })
    }

    /// Coordinates of the points.
    ///
    /// # Errors
    /// The data are damaged.
    pub fn coordinates(&self) -> Result<Vec<[f64; 3]>, OutputError> {
        let values = self.checked(self.doubles(self.coordinates, 3 * self.points))?;
        Ok(values.chunks_exact(3).map(|x| [x[0], x[1], x[2]]).collect())
    }

    /// Values of an array, components of one point or cell side by side.
    ///
    /// # Errors
    /// The data are damaged.
    pub fn values(&self, array: &ArrayHead) -> Result<Vec<f64>, OutputError> {
        let count = match array.place {
            Place::Points => self.points,
            Place::Cells => self.cells,
        };
        self.checked(self.doubles(array.offset, count.saturating_mul(array.components)))
    }

    /// Cells.
    ///
    /// # Errors
    /// The data are damaged, or lines stand before quadrilaterals.
    pub fn cells(&self) -> Result<Cells, OutputError> {
        self.checked(self.decoded_cells())
    }

    fn decoded_cells(&self) -> Result<Cells, String> {
        let kinds = self.bytes(self.types)?;
        let ends = self.integers(self.offsets)?;
        let corners = self.integers(self.connectivity)?;
        if kinds.len() != self.cells || ends.len() != self.cells {
            return Err("its cells are incomplete".into());
        }
        let mut cells = Cells::default();
        let mut begin = 0;
        for (&kind, &end) in kinds.iter().zip(&ends) {
            let own = corners.get(begin..end).ok_or("its cells are inconsistent")?;
            begin = end;
            if own.iter().any(|&p| p >= self.points) {
                return Err(format!("a cell names a point beyond the {} points", self.points));
            }
            match (kind, own, cells.lines.is_empty()) {
                (VTK_QUAD, &[a, b, c, d], true) => cells.quads.push([a, b, c, d].map(|p| p as u32)),
                (VTK_TRIANGLE, &[a, b, c], true) => cells.quads.push([a, b, c, c].map(|p| p as u32)),
                (VTK_LINE, &[a, b], _) => cells.lines.push([a, b].map(|p| p as u32)),
                _ => return Err(format!("it has a cell of the type {kind} where none is expected")),
            }
        }
        Ok(cells)
    }

    fn checked<T>(&self, found: Result<T, String>) -> Result<T, OutputError> {
        found.map_err(|problem| damaged(&self.path, problem))
    }

    fn doubles(&self, offset: usize, count: usize) -> Result<Vec<f64>, String> {
        let bytes = self.bytes(offset)?;
        if Some(bytes.len()) != count.checked_mul(8) {
            return Err(format!("an array has {} bytes where {count} numbers were expected", bytes.len()));
        }
        Ok(bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect())
    }

    fn integers(&self, offset: usize) -> Result<Vec<usize>, String> {
        let bytes = self.bytes(offset)?;
        let whole = |b: &[u8; 8]| {
            usize::try_from(i64::from_le_bytes(*b)).map_err(|_| "an index is negative".to_owned())
        };
        bytes.as_chunks::<8>().0.iter().map(whole).collect()
    }

    /// Decoded array at an offset of the appended section.
    fn bytes(&self, offset: usize) -> Result<Vec<u8>, String> {
        const BROKEN: &str = "an array is damaged";
        let appended = self.text.get(self.appended.clone()).and_then(|t| t.get(offset..)).ok_or(BROKEN)?;
        let decoded = |chars: Range<usize>| -> Result<Vec<u8>, String> {
            let text = appended.get(chars).ok_or(BROKEN)?;
            STANDARD.decode(text).map_err(|e| format!("{BROKEN}: {e}"))
        };
        let number = |bytes: &[u8], i: usize| -> Result<usize, String> {
            let bytes = bytes.get(8 * i..8 * i + 8).and_then(|b| b.try_into().ok()).ok_or(BROKEN)?;
            usize::try_from(u64::from_le_bytes(bytes)).map_err(|e| e.to_string())
        };
        let encoded = |bytes: usize| bytes.div_ceil(3).checked_mul(4).ok_or(BROKEN);
        let blocks = number(&decoded(0..12)?, 0)?;
        let words = blocks.checked_add(3).filter(|&n| n < appended.len()).ok_or(BROKEN)?;
        let begin = encoded(8 * words)?;
        let header = decoded(0..begin)?;
        let sizes: Vec<usize> = (0..blocks).map(|k| number(&header, 3 + k)).collect::<Result<_, _>>()?;
        let all = sizes.iter().try_fold(0_usize, |sum, &size| sum.checked_add(size)).ok_or(BROKEN)?;
        let data = decoded(begin..begin.checked_add(encoded(all)?).ok_or(BROKEN)?)?;
        let (mut bytes, mut rest) = (Vec::new(), &data[..]);
        for size in sizes {
            let block;
            (block, rest) = rest.split_at_checked(size).ok_or(BROKEN)?;
            ZlibDecoder::new(block).read_to_end(&mut bytes).map_err(|e| format!("{BROKEN}: {e}"))?;
        }
        Ok(bytes)
    }
}

fn damaged(path: &Path, problem: String) -> OutputError {
    OutputError::damaged(
        path,
        problem,
        "Run the model again, or remove the file and its line in the list of files",
    )
}

fn offset(node: &Node<'_, '_>) -> Result<usize, String> {
    let found = node.attribute("offset").and_then(|o| o.parse().ok());
    found.ok_or_else(|| "an array has no offset".into())
}

fn head(place: Place, node: &Node<'_, '_>) -> Result<ArrayHead, String> {
    let name = node.attribute("Name").ok_or("an array has no name")?.to_owned();
    if node.attribute("type") != Some("Float64") {
        return Err(format!("the array `{name}` has other numbers than this program writes"));
    }
    let components = node.attribute("NumberOfComponents").and_then(|n| n.parse().ok()).unwrap_or(1);
    let names = (0..components).map_while(|i| node.attribute(format!("ComponentName{i}").as_str()));
    let component_names = names.map(str::to_owned).collect();
    Ok(ArrayHead { place, name, components, component_names, offset: offset(node)? })
}

#[cfg(test)]
mod tests {
    use super::super::vtu::{self, DataArray, VtuGrid};
    use super::*;

    /// A grid with all kinds of cells, written and opened.
    fn written(folder: &Path, points: &[[f64; 3]], n: u32) -> PathBuf {
        let quads: Vec<[u32; 4]> =
            (0..n).map(|i| [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]).chain([[0, 1, 2, 2]]).collect();
        let lines = [[0, 3], [2, 1]];
        let velocity: Vec<f64> = (0..3 * points.len()).map(|i| (i as f64).sin() / 3.0).collect();
        let stress: Vec<f64> =
            (0..quads.len() + 2).map(|i| if i == 1 { f64::NAN } else { i as f64 }).collect();
        let grid = VtuGrid {
            points,
            quads: &quads,
            lines: &lines,
            point_data: vec![DataArray::new("velocity", 3, &velocity[..])],
            cell_data: vec![DataArray::new("a<b", 1, &stress[..]).with_component_names(&["x & y"])],
            time: 0.25,
        };
        let path = folder.join("a.vtu");
        vtu::write(&path, &grid).unwrap();
        path
    }

    #[test]
    fn files_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        // Enough for several blocks.
        let n = 9_000;
        let points: Vec<[f64; 3]> =
            (0..2 * n + 2).map(|i| [i as f64, 1.0 / f64::from(i + 1), -0.5]).collect();
        let file = VtuFile::open(&written(folder.path(), &points, n)).unwrap();
        assert_eq!((file.points, file.cells), (points.len(), n as usize + 3));
        assert_eq!(file.coordinates().unwrap(), points);
        let cells = file.cells().unwrap();
        assert_eq!(cells.quads.len(), n as usize + 1);
        assert_eq!((cells.quads[1], cells.quads[n as usize]), ([2, 4, 5, 3], [0, 1, 2, 2]));
        assert_eq!(cells.lines, [[0, 3], [2, 1]]);
        let heads: Vec<_> = file.arrays.iter().map(|a| (a.place, a.name.as_str(), a.components)).collect();
        assert_eq!(heads, [(Place::Points, "velocity", 3), (Place::Cells, "a<b", 1)]);
        assert_eq!(file.arrays[1].component_names, ["x & y"]);
        let velocity = file.values(&file.arrays[0]).unwrap();
        assert_eq!((velocity.len(), velocity[7]), (3 * points.len(), 7_f64.sin() / 3.0));
        let stress = file.values(&file.arrays[1]).unwrap();
        assert!(stress[1].is_nan());
        assert_eq!((stress[0], stress[n as usize + 2]), (0.0, f64::from(n + 2)));
    }

    #[test]
    fn damaged_files_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let points: Vec<[f64; 3]> = (0..6).map(|i| [f64::from(i), 0.0, 0.0]).collect();
        let path = written(folder.path(), &points, 2);
        let text = std::fs::read_to_string(&path).unwrap();
        let all = |file: VtuFile| -> Result<(), OutputError> {
            file.coordinates()?;
            file.cells()?;
            file.arrays.iter().try_for_each(|a| file.values(a).map(drop))
        };
        all(VtuFile::open(&path).unwrap()).unwrap();
        let mut failed = 0;
        let mut tried = 0;
        for i in (0..text.len()).step_by(5) {
            for with in ["", "9", "A", "<"] {
                let mut bad = text.clone();
                bad.replace_range(i..i + 1, with);
                // Whatever comes out: nothing may panic.
                let outcome = VtuFile::parse(&path, bad).map_err(|e| damaged(&path, e)).and_then(all);
                (tried, failed) = (tried + 1, failed + usize::from(outcome.is_err()));
            }
        }
        assert!(2 * failed > tried, "{failed} of {tried}");
        std::fs::write(&path, "no XML").unwrap();
        let message = VtuFile::open(&path).unwrap_err().to_string();
        assert!(message.contains("a.vtu") && message.contains("not XML"), "{message}");
    }
}
