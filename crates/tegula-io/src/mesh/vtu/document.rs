//! XML of a file, and the data behind it.

use std::borrow::Cow;

use roxmltree::{Document, Node};

use super::Fault;
use super::encoding::{Encoding, Stream};

const APPENDED: &[u8] = b"<AppendedData";

/// XML of a file without its appended data, and these data.
pub(super) struct Parts<'a> {
    pub text: Cow<'a, str>,
    pub appended: Option<Stream<'a>>,
}

/// Divides a file in front of its appended data, which may be raw bytes, and closes the XML there.
pub(super) fn split(bytes: &[u8]) -> Result<Parts<'_>, Fault> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(Fault::new("the mesh file is empty", "write the mesh again"));
    }
    let Some(at) = bytes.windows(APPENDED.len()).position(|window| window == APPENDED) else {
        return Ok(Parts { text: Cow::Borrowed(text(bytes)?), appended: None });
    };
    let (head, rest) = bytes.split_at(at);
    let end = rest
        .iter()
        .position(|&c| c == b'>')
        .ok_or_else(|| Fault::damaged("the section `AppendedData` has no end"))?;
    let (tag, data) = rest.split_at(end + 1);
    let tag = format!("{}</AppendedData>", text(tag)?);
    let encoding = Document::parse(&tag).map_err(|_| Fault::damaged("the tag `AppendedData` is damaged"))?;
    let base64 = match encoding.root_element().attribute("encoding") {
        Some("raw") => false,
        Some("base64") => true,
        other => {
            let found = other.map_or("no encoding".to_owned(), |other| format!("the encoding \"{other}\""));
            let message = format!("the section `AppendedData` has {found}, neither \"raw\" nor \"base64\"");
            return Err(Fault::damaged(message));
        }
    };
    let data = data
        .trim_ascii_start()
        .strip_prefix(b"_")
        .ok_or_else(|| Fault::damaged("the section `AppendedData` does not begin with an underscore"))?;
    let data = if base64 { data.split(|&c| c == b'<').next().unwrap_or_default() } else { data };
    Ok(Parts {
        text: Cow::Owned(format!("{}</VTKFile>", text(head)?)),
        appended: Some(Stream { data: Cow::Borrowed(data), base64 }),
    })
}

fn text(bytes: &[u8]) -> Result<&str, Fault> {
    std::str::from_utf8(bytes).map_err(|_| {
        Fault::new(
            "this is no VTU file: it is not XML in UTF-8",
            "write the mesh as a VTU file, VTK's XML format of unstructured grids",
        )
    })
}

/// Root of a file, which has to be one of unstructured grids, and the encoding of its arrays.
pub(super) fn root<'a, 'input>(
    document: &'a Document<'input>,
) -> Result<(Node<'a, 'input>, Encoding), Fault> {
    let root = document.root_element();
    if !root.has_tag_name("VTKFile") {
        return Err(Fault::new(
            format!("this is no VTU file: its first element is `{}`, not `VTKFile`", root.tag_name().name()),
            "write the mesh as a VTU file, VTK's XML format of unstructured grids",
        ));
    }
    match root.attribute("type") {
        Some("UnstructuredGrid") => {}
        Some("PUnstructuredGrid") => {
            return Err(Fault::new(
                "this is the list of the pieces of a grid (`.pvtu`)",
                "name one of the pieces, or save the grid as one `.vtu` file in ParaView",
            ));
        }
        other => {
            return Err(Fault::new(
                format!(
                    "the file holds data of the type \"{}\", not an unstructured grid",
                    other.unwrap_or("")
                ),
                "save it as an unstructured grid (`.vtu`), in ParaView behind the filter \"Append Datasets\"",
            ));
        }
    }
    let unknown = |name: &str, found: &str, help: &str| {
        Err(Fault::new(format!("the attribute `{name}` of the file is \"{found}\""), help))
    };
    let big = match root.attribute("byte_order") {
        Some("LittleEndian") | None => false,
        Some("BigEndian") => true,
        Some(other) => return unknown("byte_order", other, "give LittleEndian or BigEndian"),
    };
    let word = match root.attribute("header_type") {
        Some("UInt32") | None => 4,
        Some("UInt64") => 8,
        Some(other) => return unknown("header_type", other, "give UInt32 or UInt64"),
    };
    let zlib = match root.attribute("compressor") {
        None | Some("") => false,
        Some("vtkZLibDataCompressor") => true,
        Some(other) => {
            let help = "save it with the compressor ZLib, or without any: in ParaView under \"Compressor Type\", in meshio by `compression=\"zlib\"`";
            return unknown("compressor", other, help);
        }
    };
    Ok((root, Encoding { big, word, zlib }))
}

/// Line of a node, counted from 1.
pub(super) fn line(node: Node<'_, '_>) -> usize {
    node.document().text_pos_at(node.range().start).row as usize
}
