//! Gmsh files (`.msh`), formats 2.2 and 4.1, ASCII and binary of either byte order.
//!
//! | in Gmsh | becomes |
//! |---|---|
//! | quadrilateral of 4 nodes | a quad; written once however many groups it belongs to |
//! | hexahedron of 8 nodes, in one layer | a quad on its middle surface with directors and thickness |
//! | physical volume | a quad set |
//! | physical surface | a quad set; a group of negative sign turns its quads around |
//! | physical curve | an edge set |
//! | physical point | a node set |
//! | view `$NodeData`, `$ElementData` of one component | a field |
//!
//! A group without a name is called by its number. Nodes are ordered by their Gmsh number, quads as
//! in the file; nodes of no quad are dropped. The mesh keeps the numbers of the file as labels. Everything that cannot be computed (triangles, elements
//! of higher order, solids) is refused with the command that repairs it. Format:
//! <https://gmsh.info/doc/texinfo/gmsh.html#Gmsh-file-formats>.

mod data;
mod gather;
mod hexahedra;
mod raw;
mod scanner;
mod v2;
mod v4;

use std::path::Path;

use tegula::Mesh;

use self::raw::Raw;
use self::scanner::{Encoding, Scanner};
use super::{MeshError, MeshReader, load};

/// Reads the Gmsh file at `path`; all coordinates are multiplied by `scale`.
pub fn read(path: &Path, scale: f64) -> Result<Mesh, MeshError> {
    parse(path, &load(path, ("mesh file", Gmsh::SUFFIX))?, scale)
}

/// Format of Gmsh.
pub struct Gmsh;

impl MeshReader for Gmsh {
    const SUFFIX: &'static str = ".msh";

    fn parse(path: &Path, bytes: &[u8], scale: f64) -> Result<Mesh, MeshError> {
        parse(path, bytes, scale)
    }

    fn example() -> &'static [u8] {
        include_bytes!("../../../templates/plate.msh")
    }
}

/// Reads Gmsh data already in memory; `path` only appears in errors.
pub fn parse(path: &Path, bytes: &[u8], scale: f64) -> Result<Mesh, MeshError> {
    let mut scanner = Scanner::new(path, bytes);
    if !(scale.is_finite() && scale > 0.0) {
        return Err(scanner.whole(
            format!("the factor on the coordinates is {scale}"),
            "give a scale above 0, such as 0.001 for a mesh drawn in millimetres",
        ));
    }
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(scanner.whole("the mesh file is empty", "save the mesh again in Gmsh (File > Save Mesh)"));
    }
    let format = header(&mut scanner)?;
    let (mut raw, mut views) = (Raw::default(), Vec::new());
    loop {
        let place = scanner.position();
        let Some(section) = scanner.next_section()? else { break };
        match (section, format) {
            ("PhysicalNames", _) => physical_names(&mut scanner, &mut raw)?,
            ("Nodes", Format::Two) => v2::nodes(&mut scanner, &mut raw)?,
            ("Elements", Format::Two) => v2::elements(&mut scanner, &mut raw)?,
            ("Entities", Format::Four) if !raw.elements.is_empty() => {
                return Err(scanner.error(
                    place,
                    "$Entities stands behind $Elements",
                    "put the sections in the order $Entities, $Nodes, $Elements, as Gmsh does",
                ));
            }
            ("Entities", Format::Four) => v4::entities(&mut scanner, &mut raw)?,
            ("Nodes", Format::Four) => v4::nodes(&mut scanner, &mut raw)?,
            ("Elements", Format::Four) => v4::elements(&mut scanner, &mut raw)?,
            ("NodeData" | "ElementData", _) => {
                views.push(data::view(&mut scanner, section == "ElementData")?)
            }
            ("PartitionedEntities", _) => {
                return Err(scanner.error(
                    place,
                    "the mesh is partitioned",
                    "save it whole: Mesh > Unpartition in Gmsh, or gmsh -2 without -part",
                ));
            }
            (other, _) => {
                scanner.skip_section(other)?;
                continue;
            }
        }
        scanner.end_section(section)?;
    }
    let mut mesh = gather::mesh(&scanner, raw, scale)?;
    data::add_fields(&mut mesh, views);
    Ok(mesh)
}

/// The families of formats that differ in their sections.
#[derive(Debug, Clone, Copy)]
enum Format {
    Two,
    Four,
}

/// `$MeshFormat`: the version, and how the numbers of all other sections are written.
fn header(scanner: &mut Scanner<'_>) -> Result<Format, MeshError> {
    const SAVE: &str = "save it as \"Version 4.1\" or \"Version 2 ASCII\" in Gmsh (File > Export, .msh)";
    if scanner.next_section().ok().flatten() != Some("MeshFormat") {
        return Err(scanner.error(0, "this is not a Gmsh mesh: it does not begin with $MeshFormat", SAVE));
    }
    let start = scanner.position();
    let line = scanner.line("the version of the format")?;
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let [version, kind, size] = words[..] else {
        return Err(scanner.error(
            start,
            format!("expected version, file type and data size, found \"{line}\""),
            SAVE,
        ));
    };
    let format = match version {
        "2" | "2.0" | "2.1" | "2.2" => Format::Two,
        "4.1" => Format::Four,
        _ => {
            return Err(scanner.error(
                start,
                format!("format {version} is not read, only 2.2 and 4.1"),
                "save it with \"Mesh.MshFileVersion = 4.1;\" in the .geo file, or gmsh -format msh41",
            ));
        }
    };
    match (kind, size) {
        ("0", _) => {}
        ("1", "4" | "8") => {
            let one = scanner.bytes(4, "the number 1 that shows the byte order")?;
            let big = match one {
                [1, 0, 0, 0] => false,
                [0, 0, 0, 1] => true,
                _ => {
                    return Err(scanner.error(
                        start,
                        "the number 1 that shows the byte order is missing",
                        "the file is damaged: save the mesh again in Gmsh",
                    ));
                }
            };
            scanner.encoding = Encoding::Binary { big, wide: size == "8" };
        }
        ("1", _) => {
            return Err(scanner.error(
                start,
                format!("numbers of {size} bytes are not read, only 4 or 8"),
                SAVE,
            ));
        }
        _ => {
            let message = format!("the file type is \"{kind}\", neither 0 (ASCII) nor 1 (binary)");
            return Err(scanner.error(start, message, SAVE));
        }
    }
    scanner.end_section("MeshFormat")?;
    Ok(format)
}

/// `$PhysicalNames`, text in every variant: `dimension number "name"`.
fn physical_names(scanner: &mut Scanner<'_>, raw: &mut Raw) -> Result<(), MeshError> {
    let count = scanner.text_count("the number of physical names")?;
    for _ in 0..count {
        let start = scanner.position();
        let line = scanner.line("a physical name")?;
        let Some((dimension, tag, name)) = physical_name(line) else {
            return Err(scanner.error(
                start,
                format!("expected a physical name such as 2 1 \"shell\", found \"{line}\""),
                "the section $PhysicalNames is damaged: save the mesh again in Gmsh",
            ));
        };
        if !name.is_empty() {
            raw.names.insert((dimension, tag), name.to_owned());
        }
    }
    Ok(())
}

fn physical_name(line: &str) -> Option<(u8, u64, &str)> {
    let (numbers, quoted) = line.split_once('"')?;
    let (name, _) = quoted.rsplit_once('"')?;
    let mut numbers = numbers.split_ascii_whitespace();
    let dimension = numbers.next()?.parse().ok()?;
    let tag = numbers.next()?.parse::<i64>().ok()?.unsigned_abs();
    Some((dimension, tag, name))
}

#[cfg(test)]
mod tests;
