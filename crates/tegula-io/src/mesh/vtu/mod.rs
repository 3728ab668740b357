//! VTU files (`.vtu`): VTK's XML files of unstructured grids, as VTK, ParaView, PyVista, meshio and this program write them.
//!
//! | in the file | becomes |
//! |---|---|
//! | quadrilateral (types 9, 8, and 7 of 4 points) | a quad |
//! | line, polyline | edges of the sets of its integer arrays; without such arrays nothing |
//! | vertex | a node of the sets of its integer arrays; without such arrays nothing |
//! | integer array `NAME` of one component on cells | sets `NAME:VALUE` of quads, edges and nodes |
//! | integer array `NAME` of one component on points | node sets `NAME:VALUE` |
//! | truth values `NAME`: 0 and 1 in integers of one byte | the set `NAME` of those with 1 |
//! | array of one component | a field, from which distributions take their values |
//!
//! Arrays stand as text, in base64 or raw, in the element or behind all others (appended), compressed by zlib or not, in either byte order and with 32- or
//! 64-bit headers. Points of no quad are dropped; the mesh keeps the numbers of points and cells, counted from 0, as labels. All other cells are refused by
//! name. Pieces follow one another in one mesh.
//!
//! The reader stands on `roxmltree` and `flate2`, which the writer and reader of results need, too. The crate `vtkio` 0.6.3 refuses files without `header_type`,
//! as those of meshio are, and compressed arrays in elements, panics at damaged files, and brings 8 packages along, two of which the compiler announces to
//! refuse in future.
//!
//! Format: "VTK XML formats", <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

mod arrays;
mod cells;
mod document;
mod encoding;
mod gather;
mod grid;

use std::path::Path;

use tegula::Mesh;

use super::{At, MeshError, MeshReader};

/// Format of VTK.
pub struct Vtu;

impl MeshReader for Vtu {
    const SUFFIX: &'static str = ".vtu";

    fn parse(path: &Path, bytes: &[u8], scale: f64) -> Result<Mesh, MeshError> {
        let mesh = || {
            if !(scale.is_finite() && scale > 0.0) {
                return Err(Fault::new(
                    format!("the factor on the coordinates is {scale}"),
                    "give a scale above 0, such as 0.001 for a mesh drawn in millimetres",
                ));
            }
            let grid = grid::read(bytes)?;
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
            gather::mesh(&grid, name, scale)
        };
        mesh().map_err(|Fault { at, message, help }| MeshError { file: path.to_owned(), at, message, help })
    }

    fn example() -> &'static [u8] {
        include_bytes!("../../../tests/data/vtu/meshio-zlib.vtu")
    }
}

/// Mistake in a file.
#[derive(Debug)]
struct Fault {
    at: At,
    message: String,
    help: String,
}

/// Remedy for files whose content contradicts itself.
const DAMAGED: &str = "the file is damaged or was not written to its end: write it again";

impl Fault {
    fn new(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { at: At::File, message: message.into(), help: help.into() }
    }

    fn damaged(message: impl Into<String>) -> Self {
        Self::new(message, DAMAGED)
    }

    fn at_line(self, line: usize) -> Self {
        Self { at: At::Line(line), ..self }
    }
}

#[cfg(test)]
mod tests;
