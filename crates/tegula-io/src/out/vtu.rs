//! VTK's XML file for unstructured grids (`.vtu`), for meshes of quadrilaterals, triangles and lines.
//!
//! File version 1.0, little endian, `header_type="UInt64"`. All arrays are in the appended section, cut into
//! blocks that are compressed by zlib and encoded in base64. That is one of the encodings that ParaView,
//! PyVista (VTK) and meshio all read, and the file stays well-formed XML. One array is
//!
//! ```text
//! base64( n_blocks | block size | size of the last block or 0 | compressed size of each block )  base64( blocks )
//! ```
//!
//! See "VTK XML formats", <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::file::{OutputError, write_whole};

/// Bytes in one block before compression; a multiple of 8 so that no number is cut (meshio needs that).
const BLOCK: usize = 1 << 16;
/// By this comment near its beginning a file is known as one of this program.
const MARK: &str = "<!-- written by tegula -->\n";
/// VTK's number for a four-node quadrilateral, `VTK_QUAD`.
pub(super) const VTK_QUAD: u8 = 9;
/// VTK's number for a triangle, `VTK_TRIANGLE`.
pub(super) const VTK_TRIANGLE: u8 = 5;
/// VTK's number for a line of two points, `VTK_LINE`.
pub(super) const VTK_LINE: u8 = 3;

/// One named array on the points or on the cells.
#[derive(Debug, Clone)]
pub struct DataArray<'a> {
    /// Name shown in the viewer.
    pub name: Cow<'a, str>,
    /// Numbers per point or cell: 1 a scalar, 3 a vector, 6 a symmetric tensor in VTK's order XX YY ZZ XY YZ XZ.
    pub components: usize,
    /// Names of the components, one each; `None` lets the viewer choose.
    pub component_names: Option<&'a [&'a str]>,
    /// Values, components of one point or cell side by side.
    pub values: Cow<'a, [f64]>,
}

impl<'a> DataArray<'a> {
    /// An array without component names.
    pub fn new(name: impl Into<Cow<'a, str>>, components: usize, values: impl Into<Cow<'a, [f64]>>) -> Self {
        Self { name: name.into(), components, component_names: None, values: values.into() }
    }

    /// Array with named components.
    pub fn with_component_names(mut self, names: &'a [&'a str]) -> Self {
        self.component_names = Some(names);
        self
    }
}

/// A mesh of quadrilaterals and lines with its fields at one instant.
#[derive(Debug, Clone, Default)]
pub struct VtuGrid<'a> {
    /// Coordinates of the points.
    pub points: &'a [[f64; 3]],
    /// Corners of the quadrilaterals, as indices into `points`; one whose last two corners are the same is a triangle.
    pub quads: &'a [[u32; 4]],
    /// Ends of the lines, as indices into `points`.
    pub lines: &'a [[u32; 2]],
    /// Fields on the points.
    pub point_data: Vec<DataArray<'a>>,
    /// Fields on the quadrilaterals, and behind them on the lines.
    pub cell_data: Vec<DataArray<'a>>,
    /// Time of this picture; written as the field `TimeValue`, which VTK knows.
    pub time: f64,
}

/// Writes the grid to `path`, whole or not at all.
///
/// Numbers that are not finite are written as they are: the last state of a run that failed is worth a look.
pub fn write(path: &Path, grid: &VtuGrid<'_>) -> Result<(), OutputError> {
    check(grid).map_err(|problem| OutputError::refused(path, problem))?;
    write_whole(path, |w| write_to(w, grid))
}

/// True for a file that this program has written.
pub fn is_own(path: &Path) -> bool {
    use std::io::Read as _;
    let mut beginning = Vec::new();
    let read = std::fs::File::open(path).and_then(|f| f.take(256).read_to_end(&mut beginning));
    read.is_ok() && beginning.windows(MARK.len()).any(|bytes| bytes == MARK.as_bytes())
}

impl VtuGrid<'_> {
    /// Points of each cell: quadrilaterals, then lines.
    fn cells(&self) -> impl Iterator<Item = &[u32]> {
        self.quads.iter().map(corners).chain(self.lines.iter().map(|line| &line[..]))
    }
}

/// Corners of a quadrilateral, or of a triangle whose last corner stands twice.
fn corners(quad: &[u32; 4]) -> &[u32] {
    if quad[2] == quad[3] { &quad[..3] } else { quad }
}

/// Reports data that do not fit the grid, in words.
fn check(grid: &VtuGrid<'_>) -> Result<(), String> {
    let points = grid.points.len();
    if !grid.time.is_finite() {
        return Err(format!("its time is {}", grid.time));
    }
    for (cell, corners) in grid.cells().enumerate() {
        if let Some(corner) = corners.iter().find(|&&p| p as usize >= points) {
            return Err(format!("cell {cell} names point {corner}, but there are only {points} points"));
        }
    }
    check_arrays("point", points, &grid.point_data)?;
    check_arrays("cell", grid.cells().count(), &grid.cell_data)
}

/// Lengths and names of the arrays of one kind.
fn check_arrays(kind: &str, count: usize, arrays: &[DataArray<'_>]) -> Result<(), String> {
    let mut seen = BTreeSet::new();
    for array in arrays {
        let name = &array.name;
        if name.is_empty() || !seen.insert(name.as_ref()) {
            return Err(format!("two {kind} arrays are named `{name}`, or one has no name"));
        }
        if array.components == 0 || array.components.checked_mul(count) != Some(array.values.len()) {
            return Err(format!(
                "{kind} array `{name}` has {} values; {count} {kind}s of {} components were expected",
                array.values.len(),
                array.components
            ));
        }
        if let Some(names) = array.component_names
            && names.len() != array.components
        {
            return Err(format!(
                "{kind} array `{name}` has {} components but {} component names",
                array.components,
                names.len()
            ));
        }
    }
    Ok(())
}

/// Complete file. Offsets into the appended section precede it, so it is encoded first.
fn write_to(w: &mut dyn Write, grid: &VtuGrid<'_>) -> io::Result<()> {
    let mut appended = String::new();
    let mut xml = String::new();
    let (points, cells) = (grid.points.len(), grid.cells().count());
    xml.push_str("<?xml version=\"1.0\"?>\n");
    xml.push_str(MARK);
    xml.push_str("<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" ");
    xml.push_str("header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n");
    let _ = write!(
        xml,
        "<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{:?}\
         </DataArray>\n</FieldData>\n<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">\n",
        grid.time
    );

    section(&mut xml, &mut appended, "PointData", &grid.point_data)?;
    section(&mut xml, &mut appended, "CellData", &grid.cell_data)?;

    xml.push_str("<Points>\n");
    tag(&mut xml, "Float64", "Points", 3, None, appended.len());
    append(&mut appended, grid.points.iter().flatten().flat_map(|x| x.to_le_bytes()))?;
    xml.push_str("</Points>\n<Cells>\n");
    tag(&mut xml, "Int64", "connectivity", 1, None, appended.len());
    append(&mut appended, grid.cells().flatten().flat_map(|&p| i64::from(p).to_le_bytes()))?;
    tag(&mut xml, "Int64", "offsets", 1, None, appended.len());
    let ends = grid.cells().scan(0_u64, |end, corners| {
        *end += corners.len() as u64;
        Some(*end)
    });
    append(&mut appended, ends.flat_map(u64::to_le_bytes))?;
    tag(&mut xml, "UInt8", "types", 1, None, appended.len());
    let kind = |points: &[u32]| match points.len() {
        2 => VTK_LINE,
        3 => VTK_TRIANGLE,
        _ => VTK_QUAD,
    };
    append(&mut appended, grid.cells().map(kind))?;
    xml.push_str("</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"base64\">\n_");

    w.write_all(xml.as_bytes())?;
    w.write_all(appended.as_bytes())?;
    w.write_all(b"\n</AppendedData>\n</VTKFile>\n")
}

/// `PointData` or `CellData` with all its arrays.
fn section(xml: &mut String, appended: &mut String, kind: &str, arrays: &[DataArray<'_>]) -> io::Result<()> {
    let _ = writeln!(xml, "<{kind}>");
    for array in arrays {
        tag(xml, "Float64", &array.name, array.components, array.component_names, appended.len());
        append(appended, array.values.iter().flat_map(|x| x.to_le_bytes()))?;
    }
    let _ = writeln!(xml, "</{kind}>");
    Ok(())
}

/// The element that announces one appended array.
fn tag(xml: &mut String, number: &str, name: &str, components: usize, names: Option<&[&str]>, offset: usize) {
    let name = escape(name);
    let _ = write!(xml, "<DataArray type=\"{number}\" Name=\"{name}\" NumberOfComponents=\"{components}\"");
    for (i, component) in names.unwrap_or_default().iter().enumerate() {
        let _ = write!(xml, " ComponentName{i}=\"{}\"", escape(component));
    }
    let _ = writeln!(xml, " format=\"appended\" offset=\"{offset}\"/>");
}

/// Compresses and encodes one array onto the appended section.
fn append(appended: &mut String, bytes: impl Iterator<Item = u8>) -> io::Result<()> {
    let bytes: Vec<u8> = bytes.collect();
    let blocks = bytes.len().div_ceil(BLOCK) as u64;
    let mut header = vec![blocks, BLOCK as u64, (bytes.len() % BLOCK) as u64];
    let mut compressed = Vec::with_capacity(bytes.len() / 2);
    for block in bytes.chunks(BLOCK) {
        let before = compressed.len();
        let mut encoder = ZlibEncoder::new(compressed, Compression::fast());
        encoder.write_all(block)?;
        compressed = encoder.finish()?;
        header.push((compressed.len() - before) as u64);
    }
    let header: Vec<u8> = header.iter().flat_map(|n| n.to_le_bytes()).collect();
    STANDARD.encode_string(header, appended);
    STANDARD.encode_string(compressed, appended);
    Ok(())
}

/// Text for an XML attribute. Control characters, which XML has no way to write, become spaces.
pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;

    /// Points, cells, a vector on the points and a scalar on the cells.
    type Strip = (Vec<[f64; 3]>, Vec<[u32; 4]>, Vec<f64>, Vec<f64>);

    /// A strip of `n` squares and a field on each kind.
    fn strip(n: usize) -> Strip {
        let points: Vec<[f64; 3]> =
            (0..=n).flat_map(|i| [[i as f64, 0.0, 0.1], [i as f64, 1.0, 0.1]]).collect();
        let quads = (0..n as u32).map(|i| [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]).collect();
        let displacement = (0..3 * points.len()).map(|i| (i as f64).sin() / 3.0).collect();
        let cell = (0..n).map(|i| 1e-7 * i as f64).collect();
        (points, quads, displacement, cell)
    }

    /// The array at `offset` of the appended section, decoded independently of the writer's loop.
    fn decode(text: &str, offset: usize) -> Vec<u8> {
        let start = text.find("\n_").unwrap() + 2 + offset;
        let u64_at = |bytes: &[u8], i: usize| u64::from_le_bytes(bytes[8 * i..8 * i + 8].try_into().unwrap());
        let blocks = u64_at(&STANDARD.decode(&text[start..start + 12]).unwrap(), 0) as usize;
        let header_chars = (8 * (3 + blocks)).div_ceil(3) * 4;
        let header = STANDARD.decode(&text[start..start + header_chars]).unwrap();
        let sizes: Vec<usize> = (0..blocks).map(|k| u64_at(&header, 3 + k) as usize).collect();
        let data_chars = sizes.iter().sum::<usize>().div_ceil(3) * 4;
        let data_start = start + header_chars;
        let data = STANDARD.decode(&text[data_start..data_start + data_chars]).unwrap();
        let (mut at, mut bytes) = (0, Vec::new());
        for size in sizes {
            flate2::read::ZlibDecoder::new(&data[at..at + size]).read_to_end(&mut bytes).unwrap();
            at += size;
        }
        bytes
    }

    #[test]
    fn arrays_of_several_blocks_survive() {
        let (points, quads, displacement, cell) = strip(20_000);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vtu");
        let grid = VtuGrid {
            points: &points,
            quads: &quads,
            point_data: vec![DataArray::new("displacement", 3, &displacement[..])],
            cell_data: vec![DataArray::new("a<b \"&\"", 1, &cell[..]).with_component_names(&["x"])],
            time: 0.1 + 0.2,
            ..VtuGrid::default()
        };
        write(&path, &grid).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains("0.30000000000000004") && text.contains("a&lt;b &quot;&amp;&quot;"));
        let offsets: Vec<usize> = text
            .split("offset=\"")
            .skip(1)
            .map(|rest| rest.split('"').next().unwrap().parse().unwrap())
            .collect();
        let bytes = decode(&text, offsets[0]);
        let read: Vec<f64> = bytes.chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
        assert_eq!(read, displacement);
        let bytes = decode(&text, offsets[3]);
        let read: Vec<i64> = bytes.chunks(8).map(|b| i64::from_le_bytes(b.try_into().unwrap())).collect();
        let nodes: Vec<i64> = quads.iter().flatten().map(|&node| i64::from(node)).collect();
        assert_eq!(read, nodes);
        let bytes = decode(&text, offsets[4]);
        let ends: Vec<i64> = bytes.chunks(8).map(|b| i64::from_le_bytes(b.try_into().unwrap())).collect();
        assert_eq!(ends, (1..=quads.len() as i64).map(|q| 4 * q).collect::<Vec<_>>());
        assert_eq!(decode(&text, offsets[5]), vec![VTK_QUAD; quads.len()]);
    }

    #[test]
    fn what_does_not_fit_is_refused_by_name() {
        let (points, quads, displacement, cell) = strip(2);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vtu");
        let good = VtuGrid { points: &points, quads: &quads, ..VtuGrid::default() };
        let refusal = |grid: &VtuGrid<'_>| write(&path, grid).unwrap_err().to_string();

        let mut grid = good.clone();
        grid.point_data.push(DataArray::new("displacement", 3, &displacement[1..]));
        assert!(refusal(&grid).contains("`displacement` has 17 values"), "{}", refusal(&grid));
        let mut grid = good.clone();
        grid.cell_data = vec![DataArray::new("s", 1, &cell[..]), DataArray::new("s", 1, &cell[..])];
        assert!(refusal(&grid).contains("two cell arrays"));
        let mut grid = good.clone();
        grid.cell_data = vec![DataArray::new("s", 1, &cell[..]).with_component_names(&["a", "b"])];
        assert!(refusal(&grid).contains("2 component names"));
        let far = [[0, 1, 2, 99]];
        assert!(refusal(&VtuGrid { quads: &far, ..good.clone() }).contains("point 99"));
        assert!(refusal(&VtuGrid { time: f64::NAN, ..good }).contains("time"));
        assert!(!path.exists());
    }

    #[test]
    fn files_of_other_programs_are_not_own() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vtu");
        let (points, quads, ..) = strip(2);
        assert!(!is_own(&path), "there is no file");
        let grid = VtuGrid { points: &points, quads: &quads, ..VtuGrid::default() };
        write(&path, &grid).unwrap();
        assert!(is_own(&path));
        let text = std::fs::read_to_string(&path).unwrap().replace(MARK, "");
        std::fs::write(&path, text).unwrap();
        assert!(!is_own(&path), "the mark is missing");
    }

    /// Offset of the last array, the types of the cells.
    fn last_offset(text: &str) -> usize {
        text.rsplit("offset=\"").next().unwrap().split('"').next().unwrap().parse().unwrap()
    }

    #[test]
    fn lines_stand_behind_quadrilaterals() {
        let (points, quads, ..) = strip(2);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vtu");
        let lines = [[0, 5], [4, 1], [2, 3]];
        let part = [0.0, 0.0, 1.0, 2.0, 3.0];
        let cell_data = vec![DataArray::new("part", 1, &part[..])];
        let grid = VtuGrid { points: &points, quads: &quads, lines: &lines, cell_data, ..VtuGrid::default() };
        write(&path, &grid).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains("NumberOfCells=\"5\""));
        let offsets: Vec<usize> = text
            .split("offset=\"")
            .skip(1)
            .map(|rest| rest.split('"').next().unwrap().parse().unwrap())
            .collect();
        let integers = |offset: usize| -> Vec<i64> {
            let bytes = decode(&text, offset);
            bytes.chunks(8).map(|b| i64::from_le_bytes(b.try_into().unwrap())).collect()
        };
        assert_eq!(integers(offsets[2]), [0, 2, 3, 1, 2, 4, 5, 3, 0, 5, 4, 1, 2, 3]);
        assert_eq!(integers(offsets[3]), [4, 8, 10, 12, 14]);
        assert_eq!(decode(&text, offsets[4]), [9, 9, 3, 3, 3]);

        // A quadrilateral whose last corner stands twice is a triangle.
        let quads = [quads[0], [0, 2, 3, 3]];
        write(&path, &VtuGrid { quads: &quads, ..grid }).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(decode(&text, last_offset(&text)), [9, 5, 3, 3, 3]);
        let far = [[0, 6]];
        let refused = write(&path, &VtuGrid { points: &points, lines: &far, ..VtuGrid::default() });
        assert!(refused.unwrap_err().to_string().contains("point 6"));
    }

    #[test]
    fn an_empty_grid_is_a_file_too() {
        let folder = tempfile::tempdir().unwrap();
        let grid = VtuGrid::default();
        write(&folder.path().join("a.vtu"), &grid).unwrap();
    }
}
