//! VTKHDF files: all instants of a series of VTU files in one HDF5 file, for ParaView and VTK.
//!
//! An `UnstructuredGrid` of version 2.0 with the group `Steps`, which says for each instant at which row its part of every
//! array begins. The mesh stands in the file once. So does an array as long as it does not change from instant to
//! instant, such as the coordinates: both instants begin at the same row. Each instant of an array is one
//! compressed chunk.
//!
//! See "VTKHDF File Format", <https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/vtkhdf_specifications.html>.

use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::file::{OutputError, write_whole_seekable};
use super::hdf5::{Address, Attribute, Chunk, Hdf5Writer, Number, Shape, compressed};
use super::vtu::{VTK_LINE, VTK_QUAD, VTK_TRIANGLE};
use super::vtu_file::{ArrayHead, Cells, Place, VtuFile};

/// Version of the format: the first one with instants, which all readers of instants know.
const VERSION: [i64; 2] = [2, 0];
/// Bytes that a chunk of HDF5 may have.
const LARGEST_CHUNK: usize = u32::MAX as usize;
/// Bytes of a name, and of the names of all components, at most; a message of a header has 64 KiB.
const LONGEST_NAME: usize = 32_000;
const REMEDY: &str = "All files of a series have one mesh and the same arrays; convert the series of one run";

/// Writes the instants of a series, time value and VTU file each, to one file, whole or not at all. One instant is in memory at a time.
///
/// # Errors
/// The series is empty, or its files cannot be read, were not written by this program or differ in mesh or arrays; the file cannot
/// be written.
pub fn write(path: &Path, instants: &[(f64, PathBuf)]) -> Result<(), OutputError> {
    let Some((_, first)) = instants.first() else {
        return Err(OutputError::refused(path, "there are no instants to be written"));
    };
    let first = (VtuFile::open(first)?, first);
    let cells = first.0.cells()?;
    write_whole_seekable(path, |file| {
        let failed = |cause| OutputError::write(path, cause);
        let mut file = Hdf5Writer::new(file).map_err(failed)?;
        let mut series = Series::of(&first.0).map_err(|problem| OutputError::refused(path, problem))?;
        let arrays = &first.0.arrays;
        for (_, place) in instants {
            let instant = VtuFile::open(place)?;
            if let Some(problem) = difference(&instant, &cells, arrays)? {
                return Err(OutputError::damaged(
                    place,
                    format!("{problem} `{}`", first.1.display()),
                    REMEDY,
                ));
            }
            series.add(&mut file, &instant, path)?;
        }
        let times: Vec<f64> = instants.iter().map(|(time, _)| *time).collect();
        series.finish(&mut file, &cells, &times).map_err(failed)
    })
}

/// Difference of a file from the first one in cells or arrays, to be followed by the first one's name.
fn difference(file: &VtuFile, cells: &Cells, arrays: &[ArrayHead]) -> Result<Option<String>, OutputError> {
    if file.cells()? != *cells {
        return Ok(Some("its mesh is another one than that of".into()));
    }
    let key = |array: &ArrayHead| (array.place == Place::Points, array.name.clone(), array.components);
    let [own, expected] = [&file.arrays[..], arrays].map(|list| list.iter().map(key).collect::<Vec<_>>());
    let odd = own.iter().find(|a| !expected.contains(a)).or(expected.iter().find(|a| !own.contains(a)));
    Ok(odd.map(|(_, name, _)| format!("the array `{name}` is not the same, or not there, in it and in")))
}

/// One array over all instants.
struct Track {
    shape: Shape,
    name: String,
    attributes: Vec<(&'static str, Attribute)>,
    chunks: Vec<Chunk>,
    /// Row at which each instant begins.
    offsets: Vec<i64>,
    latest: Vec<u8>,
}

impl Track {
    fn new(name: &str, rows: usize, components: usize) -> Self {
        let shape = Shape {
            number: Number::F64,
            rows: 0,
            rows_per_chunk: rows,
            columns: (components > 1).then_some(components),
        };
        let (attributes, chunks, offsets, latest) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { shape, name: name.to_owned(), attributes, chunks, offsets, latest }
    }

    /// Compressed values of an instant; none where they are those of the instant before.
    fn encode(&mut self, values: impl Iterator<Item = f64>) -> io::Result<Option<Vec<u8>>> {
        let bytes: Vec<u8> = values.flat_map(f64::to_le_bytes).collect();
        if !self.offsets.is_empty() && bytes == self.latest {
            return Ok(None);
        }
        self.latest = bytes;
        compressed(&self.latest, self.shape.number.size()).map(Some)
    }

    fn put<W: Write + Seek>(&mut self, file: &mut Hdf5Writer<W>, new: Option<&[u8]>) -> io::Result<()> {
        if let Some(bytes) = new {
            self.chunks.push(file.chunk(bytes)?);
            self.shape.rows += self.shape.rows_per_chunk;
        }
        self.offsets.push((self.shape.rows - self.shape.rows_per_chunk) as i64);
        Ok(())
    }

    fn write<W: Write + Seek>(&self, file: &mut Hdf5Writer<W>) -> io::Result<Address> {
        file.chunked_array(&self.shape, &self.chunks, &self.attributes)
    }
}

/// Arrays over all instants.
struct Series {
    points: Track,
    point_data: Vec<Track>,
    cell_data: Vec<Track>,
}

impl Series {
    /// Empty arrays for those of the first file.
    fn of(file: &VtuFile) -> Result<Self, String> {
        let tracks = |place: Place, rows: usize| -> Result<Vec<Track>, String> {
            let own = file.arrays.iter().filter(|array| array.place == place);
            own.map(|array| {
                check_head(array)?;
                let mut track = Track::new(&array.name, rows, array.components);
                if !array.component_names.is_empty() {
                    track.attributes =
                        vec![("component_names", Attribute::Texts(array.component_names.clone()))];
                }
                Ok(track)
            })
            .collect()
        };
        let series = Self {
            points: Track::new("Points", file.points, 3),
            point_data: tracks(Place::Points, file.points)?,
            cell_data: tracks(Place::Cells, file.cells)?,
        };
        let too_large = |track: &&Track| {
            let row = track.shape.columns.unwrap_or(1).checked_mul(8);
            let bytes = row.and_then(|row| track.shape.rows_per_chunk.checked_mul(row));
            bytes.is_none_or(|bytes| bytes > LARGEST_CHUNK)
        };
        let all = series.point_data.iter().chain(&series.cell_data).chain([&series.points]);
        if let Some(track) = all.into_iter().find(too_large) {
            return Err(format!("one instant of the array `{}` has more than 4 GiB", track.name));
        }
        Ok(series)
    }

    /// Writes the arrays of an instant.
    fn add<W: Write + Seek>(
        &mut self,
        file: &mut Hdf5Writer<W>,
        instant: &VtuFile,
        path: &Path,
    ) -> Result<(), OutputError> {
        let failed = |cause| OutputError::write(path, cause);
        let points = instant.coordinates()?;
        let new = self.points.encode(points.into_iter().flatten()).map_err(failed)?;
        self.points.put(file, new.as_deref()).map_err(failed)?;
        for (place, tracks) in [(Place::Points, &mut self.point_data), (Place::Cells, &mut self.cell_data)] {
            let head = |name: &str| instant.arrays.iter().find(|a| a.place == place && a.name == name);
            let encoded: Vec<Option<Vec<u8>>> = tracks
                .par_iter_mut()
                .map(|track| match head(&track.name) {
                    Some(array) => track.encode(instant.values(array)?.into_iter()).map_err(failed),
                    None => Ok(None),
                })
                .collect::<Result<_, _>>()?;
            for (track, new) in tracks.iter_mut().zip(encoded) {
                track.put(file, new.as_deref()).map_err(failed)?;
            }
        }
        Ok(())
    }

    /// Writes the mesh, and the objects that name what was written.
    fn finish<W: Write + Seek>(
        self,
        file: &mut Hdf5Writer<W>,
        cells: &Cells,
        times: &[f64],
    ) -> io::Result<()> {
        let mesh = Mesh::of(cells);
        let (points, count) = (self.points.shape.rows_per_chunk, mesh.types.len());
        let mut members = vec![
            ("NumberOfPoints", integers(file, &[points as i64])?),
            ("NumberOfCells", integers(file, &[count as i64])?),
            ("NumberOfConnectivityIds", integers(file, &[mesh.connectivity.len() as i64])?),
            ("Points", self.points.write(file)?),
            ("Connectivity", packed(file, Number::I64, &bytes_of(&mesh.connectivity))?),
            ("Offsets", packed(file, Number::I64, &bytes_of(&mesh.offsets))?),
            ("Types", packed(file, Number::U8, &mesh.types)?),
        ];
        let mut places = Vec::new();
        for (name, tracks) in [("PointData", &self.point_data), ("CellData", &self.cell_data)] {
            let (data, offsets) = group_of(file, tracks)?;
            members.push((name, data));
            places.push(offsets);
        }
        let steps = times.len();
        let time_values = list_of_times(file, times)?;
        members.push(("FieldData", file.group(&[("TimeValue", time_values)], &[])?));
        let offsets_of_field: Vec<i64> = (0..steps as i64).collect();
        // One component, one tuple.
        let sizes = bytes_of(&vec![1; 2 * steps]);
        let field_sizes =
            file.array(&Shape { columns: Some(2), ..Shape::list(Number::I64, steps) }, &sizes)?;
        let field_offsets = integers(file, &offsets_of_field)?;
        let zeros = vec![0; steps];
        let column = Shape { columns: Some(1), ..Shape::list(Number::I64, steps) };
        let members_of_steps = [
            ("Values", list_of_times(file, times)?),
            ("PartOffsets", integers(file, &zeros)?),
            ("NumberOfParts", integers(file, &vec![1; steps])?),
            ("PointOffsets", integers(file, &self.points.offsets)?),
            ("CellOffsets", file.array(&column, &bytes_of(&zeros))?),
            ("ConnectivityIdOffsets", file.array(&column, &bytes_of(&zeros))?),
            ("PointDataOffsets", places[0]),
            ("CellDataOffsets", places[1]),
            ("FieldDataOffsets", file.group(&[("TimeValue", field_offsets)], &[])?),
            ("FieldDataSizes", file.group(&[("TimeValue", field_sizes)], &[])?),
        ];
        members
            .push(("Steps", file.group(&members_of_steps, &[("NSteps", Attribute::Integer(steps as i64))])?));
        let attributes = [
            ("Version", Attribute::Integers(VERSION.to_vec())),
            ("Type", Attribute::Ascii("UnstructuredGrid".into())),
        ];
        let grid = file.group(&members, &attributes)?;
        let root = file.group(&[("VTKHDF", grid)], &[])?;
        file.finish(root)
    }
}

/// Refuses what HDF5 cannot name, or cannot write into one header.
fn check_head(array: &ArrayHead) -> Result<(), String> {
    let (name, components) = (&array.name, &array.component_names);
    if name.contains('/') || name == "." || name.is_empty() || name.len() > LONGEST_NAME {
        return Err(format!("HDF5 cannot name an array `{name}`"));
    }
    let longest = components.iter().map(String::len).max().unwrap_or(0);
    if array.components == 0 || longest.saturating_mul(components.len()) > LONGEST_NAME {
        return Err(format!("the array `{name}` has no components, or their names are too long"));
    }
    Ok(())
}

/// Cells as VTK stores them.
struct Mesh {
    connectivity: Vec<i64>,
    offsets: Vec<i64>,
    types: Vec<u8>,
}

impl Mesh {
    fn of(cells: &Cells) -> Self {
        let mut mesh = Self { connectivity: Vec::new(), offsets: vec![0], types: Vec::new() };
        for quad in &cells.quads {
            match quad {
                [a, b, c, d] if c == d => mesh.push(&[*a, *b, *c], VTK_TRIANGLE),
                _ => mesh.push(quad, VTK_QUAD),
            }
        }
        cells.lines.iter().for_each(|line| mesh.push(line, VTK_LINE));
        mesh
    }

    fn push(&mut self, corners: &[u32], kind: u8) {
        self.connectivity.extend(corners.iter().map(|&corner| i64::from(corner)));
        self.offsets.push(self.connectivity.len() as i64);
        self.types.push(kind);
    }
}

fn bytes_of(list: &[i64]) -> Vec<u8> {
    list.iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn integers<W: Write + Seek>(file: &mut Hdf5Writer<W>, list: &[i64]) -> io::Result<Address> {
    file.array(&Shape::list(Number::I64, list.len()), &bytes_of(list))
}

fn list_of_times<W: Write + Seek>(file: &mut Hdf5Writer<W>, times: &[f64]) -> io::Result<Address> {
    let bytes: Vec<u8> = times.iter().flat_map(|t| t.to_le_bytes()).collect();
    file.array(&Shape::list(Number::F64, times.len()), &bytes)
}

/// Writes an array in one compressed chunk.
fn packed<W: Write + Seek>(file: &mut Hdf5Writer<W>, number: Number, bytes: &[u8]) -> io::Result<Address> {
    if bytes.is_empty() || bytes.len() > LARGEST_CHUNK {
        return file.array(&Shape::list(number, bytes.len() / number.size()), bytes);
    }
    let chunk = file.chunk(&compressed(bytes, number.size())?)?;
    file.chunked_array(&Shape::list(number, bytes.len() / number.size()), &[chunk], &[])
}

/// Groups of arrays, and of the rows at which their instants begin.
fn group_of<W: Write + Seek>(file: &mut Hdf5Writer<W>, tracks: &[Track]) -> io::Result<(Address, Address)> {
    let (mut arrays, mut offsets) = (Vec::new(), Vec::new());
    for track in tracks {
        arrays.push((track.name.as_str(), track.write(file)?));
        offsets.push((track.name.as_str(), integers(file, &track.offsets)?));
    }
    Ok((file.group(&arrays, &[])?, file.group(&offsets, &[])?))
}

#[cfg(test)]
mod tests {
    use super::super::hdf5::reader::Hdf5File;
    use super::super::vtu::{self, DataArray, VtuGrid};
    use super::*;

    const POINTS: [[f64; 3]; 5] =
        [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.5, 0.25]];
    const NAMES: [&str; 2] = ["1", "α"];

    /// One instant of a square, a triangle and a line; `change` changes it.
    fn instant<'a>(folder: &Path, number: usize, change: impl FnOnce(&mut VtuGrid<'a>)) -> (f64, PathBuf) {
        let t = number as f64 / 8.0;
        let displacement: Vec<f64> = (0..15).map(|i| t * f64::from(i)).collect();
        let stress = vec![f64::NAN, -0.0, t, 1.0 / 3.0, t * t, f64::INFINITY];
        let mut grid = VtuGrid {
            points: &POINTS,
            quads: &[[0, 1, 2, 3], [1, 4, 2, 2]],
            lines: &[[0, 4]],
            point_data: vec![DataArray::new("displacement", 3, displacement)],
            cell_data: vec![
                DataArray::new("stress", 2, stress).with_component_names(&NAMES),
                DataArray::new("thickness", 1, vec![0.5; 3]),
            ],
            time: t,
        };
        change(&mut grid);
        let path = folder.join(format!("{number}.vtu"));
        vtu::write(&path, &grid).unwrap();
        (t, path)
    }

    #[test]
    fn all_instants_are_in_the_file_and_what_stays_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vtkhdf");
        let moved = POINTS.map(|[x, y, z]| [x, y, z + 1.0]);
        let instants = [0, 1, 2].map(|i| {
            instant(folder.path(), i, |grid| {
                if i == 2 {
                    grid.points = &moved
                }
            })
        });
        write(&path, &instants).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let file = Hdf5File(&bytes);
        let of = |name: &str| file.array(&format!("VTKHDF/{name}"));
        let grid = file.find("VTKHDF");
        assert_eq!(file.attribute(grid, "Type"), b"UnstructuredGrid");
        assert_eq!(file.attribute(grid, "Version"), [2, 0].map(i64::to_le_bytes).concat());
        assert_eq!(file.attribute(file.find("VTKHDF/Steps"), "NSteps"), 3_i64.to_le_bytes());

        assert_eq!(of("Connectivity").integers(), [0, 1, 2, 3, 1, 4, 2, 0, 4]);
        assert_eq!(of("Offsets").integers(), [0, 4, 7, 9]);
        assert_eq!(of("Types").axes, [3]);
        for (name, count) in [("NumberOfPoints", 5), ("NumberOfCells", 3), ("NumberOfConnectivityIds", 9)] {
            assert_eq!(of(name).integers(), [count]);
        }
        assert_eq!(of("Points").floats(), [POINTS, moved].concat().concat());
        let displacement = of("PointData/displacement");
        assert_eq!((&displacement.axes[..], displacement.chunks), (&[15, 3][..], Some(3)));
        let expected: Vec<f64> = (0..45).map(|i| f64::from(i / 15) / 8.0 * f64::from(i % 15)).collect();
        assert_eq!(displacement.floats(), expected);
        let stress = of("CellData/stress").floats();
        assert!(stress[0].is_nan() && stress[7].to_bits() == (-0.0_f64).to_bits());
        assert_eq!(stress[12..].get(2..), Some(&[0.25, 1.0 / 3.0, 0.0625, f64::INFINITY][..]));
        let names = file.attribute(file.find("VTKHDF/CellData/stress"), "component_names");
        assert_eq!(names, "1\0α".as_bytes());
        let thickness = of("CellData/thickness");
        assert_eq!((&thickness.axes[..], thickness.floats()), (&[3][..], vec![0.5; 3]));

        assert_eq!(of("Steps/Values").floats(), [0.0, 0.125, 0.25]);
        assert_eq!(of("FieldData/TimeValue").floats(), [0.0, 0.125, 0.25]);
        let offsets = [
            ("PointOffsets", [0, 0, 5]),
            ("PartOffsets", [0, 0, 0]),
            ("NumberOfParts", [1, 1, 1]),
            ("CellOffsets", [0, 0, 0]),
            ("ConnectivityIdOffsets", [0, 0, 0]),
            ("PointDataOffsets/displacement", [0, 5, 10]),
            ("CellDataOffsets/stress", [0, 3, 6]),
            ("CellDataOffsets/thickness", [0, 0, 0]),
            ("FieldDataOffsets/TimeValue", [0, 1, 2]),
        ];
        for (name, rows) in offsets {
            assert_eq!(of(&format!("Steps/{name}")).integers(), rows, "{name}");
        }
        assert_eq!(of("Steps/FieldDataSizes/TimeValue").axes, [3, 2]);
    }

    #[test]
    fn thousands_of_instants_are_indexed_in_one_page() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vtkhdf");
        let two = [0, 1].map(|i| instant(folder.path(), i, |_| ()));
        let many: Vec<_> = (0..1500).map(|i| (f64::from(i), two[i as usize % 2].1.clone())).collect();
        write(&path, &many).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let displacement = Hdf5File(&bytes).array("VTKHDF/PointData/displacement");
        assert_eq!(displacement.chunks, Some(1500));
        assert_eq!(displacement.floats()[15 * 1499 + 14], 14.0 / 8.0);
    }

    #[test]
    fn a_grid_without_cells_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vtkhdf");
        let instants = [0, 1].map(|i| {
            instant(folder.path(), i, |grid| {
                (grid.quads, grid.lines) = (&[], &[]);
                grid.cell_data = vec![DataArray::new("stress", 2, Vec::new())];
            })
        });
        write(&path, &instants).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let file = Hdf5File(&bytes);
        assert_eq!(file.array("VTKHDF/CellData/stress").axes, [0, 2]);
        assert_eq!(file.array("VTKHDF/NumberOfCells").integers(), [0]);
        assert_eq!(file.array("VTKHDF/Offsets").integers(), [0]);
    }

    #[test]
    fn what_does_not_fit_is_refused_and_nothing_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vtkhdf");
        let first = instant(folder.path(), 0, |_| ());
        let refusal = |instants: &[(f64, PathBuf)]| {
            let message = write(&path, instants).unwrap_err().to_string();
            assert!(!path.exists());
            message
        };
        assert!(refusal(&[]).contains("no instants"));
        let other = instant(folder.path(), 1, |grid| grid.quads = &[[0, 1, 2, 3], [4, 1, 2, 2]]);
        let message = refusal(&[first.clone(), other]);
        assert!(
            message.contains("1.vtu` cannot be used: its mesh is another one than that of `"),
            "{message}"
        );
        let other = instant(folder.path(), 2, |grid| grid.cell_data.truncate(1));
        assert!(refusal(&[first.clone(), other]).contains("array `thickness` is not the same, or not there"));
        let other = instant(folder.path(), 3, |grid| grid.points = &POINTS);
        let gone = (1.0, folder.path().join("gone.vtu"));
        assert!(refusal(&[first.clone(), other, gone]).contains("gone.vtu"));
        let named = instant(folder.path(), 4, |grid| grid.cell_data[1].name = "a/b".into());
        assert!(refusal(&[named]).contains("HDF5 cannot name an array `a/b`"));
        let long = "x".repeat(16_001);
        let names = [long.as_str(), "y"];
        let named = instant(folder.path(), 5, |grid| {
            grid.cell_data[0] = DataArray::new("stress", 2, vec![0.0; 6]).with_component_names(&names);
        });
        assert!(refusal(&[named]).contains("`stress` has no components, or their names are too long"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 6);
        let nowhere = folder.path().join("nowhere/a.vtkhdf");
        assert!(write(&nowhere, &[first]).unwrap_err().to_string().contains("nowhere"));
    }
}
