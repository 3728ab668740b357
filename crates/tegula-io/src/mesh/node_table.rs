//! Tables of displacements of nodes: lines of text with the number of a node and three components, separated by commas.
//!
//! The first line may be `node,x,y,z`. Empty lines and those that begin with `#` or `*` are comments, so that the table of an input file of
//! another program can be used as it is.

use std::collections::BTreeMap;
use std::path::Path;

use tegula::model::NodeDisplacement;

use super::{At, MeshError, load};

/// Names of the columns, which the first line may give.
const COLUMNS: [&str; 4] = ["node", "x", "y", "z"];

/// Displacements of the table at `path`, and the bytes of the file.
///
/// # Errors
/// The file cannot be read, or a line is none of a table.
pub fn read(path: &Path) -> Result<(Vec<NodeDisplacement>, Vec<u8>), MeshError> {
    let bytes = load(path, ("table of displacements", ".csv"))?;
    Ok((parse(path, &bytes)?, bytes))
}

/// Displacements of the bytes of a table; `path` only appears in errors.
///
/// # Errors
/// A line is none of a table.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Vec<NodeDisplacement>, MeshError> {
    let failed = |at: At, message: String, help: &str| MeshError {
        file: path.to_owned(),
        at,
        message,
        help: help.to_owned(),
    };
    let text = std::str::from_utf8(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)).map_err(|_| {
        failed(
            At::File,
            "this is no text".into(),
            "give lines of the number of a node and its displacement, such as `12,0,0,0.5`",
        )
    })?;
    let mut first = true;
    let (mut out, mut lines) = (Vec::new(), BTreeMap::new());
    for (number, line) in text.lines().enumerate().map(|(i, line)| (i + 1, line.trim())) {
        if line.is_empty() || line.starts_with(['#', '*']) {
            continue;
        }
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        if std::mem::take(&mut first) && cells == COLUMNS {
            continue;
        }
        let row = row(&cells).map_err(|message| {
            failed(
                At::Line(number),
                message,
                "a line is the number of a node and its displacement, such as `12,0,0,0.5`",
            )
        })?;
        if let Some(earlier) = lines.insert(row.node, number) {
            let message = format!("node {} is displaced again; line {earlier} does so, too", row.node);
            return Err(failed(At::Line(number), message, "give each node once"));
        }
        out.push(row);
    }
    if out.is_empty() {
        return Err(failed(At::File, "the table has no lines".into(), "give at least one node"));
    }
    Ok(out)
}

fn row(cells: &[&str]) -> Result<NodeDisplacement, String> {
    let [node, components @ ..] = cells else { return Err("the line is empty".into()) };
    let node = node.parse().map_err(|_| format!("\"{node}\" is not the number of a node"))?;
    if components.len() != 3 {
        return Err(format!("a displacement has 3 components, and there are {}", components.len()));
    }
    let mut displacement = [0.0; 3];
    for (x, text) in displacement.iter_mut().zip(components) {
        *x =
            text.parse().ok().filter(|x: &f64| x.is_finite()).ok_or(format!("\"{text}\" is not a number"))?;
    }
    Ok(NodeDisplacement { node, displacement })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(text: &str) -> String {
        parse(Path::new("dents.csv"), text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn tables_are_read_with_and_without_names() {
        let expected = [
            NodeDisplacement { node: 7, displacement: [0.0, 1e-3, -2.0] },
            NodeDisplacement { node: 0, displacement: [1.0, 2.0, 3.0] },
        ];
        for names in ["", "node,x,y,z\r\n", "\u{feff}node, x, y, z\n", "** of another program\n\n"] {
            let text = format!("{names}7, 0.0, 1e-3, -2\n# a comment\n0,1,2,3");
            assert_eq!(parse(Path::new("dents.csv"), text.as_bytes()).unwrap(), expected, "{names:?}");
        }
    }

    #[test]
    fn mistakes_name_their_line() {
        assert!(
            told("node,x,y,z\n1,0,0\n")
                .starts_with("dents.csv:2: a displacement has 3 components, and there are 2")
        );
        assert!(told("1,0,0,0\n\n-1,0,0,0").starts_with("dents.csv:3: \"-1\" is not the number of a node"));
        assert!(told("1,0,0,nan").starts_with("dents.csv:1: \"nan\" is not a number"));
        assert!(told("1,0,0,0\nnode,x,y,z").starts_with("dents.csv:2: \"node\""));
        assert!(told("1,0,0,0\n2,0,0,0\n1,0,0,1").contains("line 1 does so, too"));
        assert!(told("node,x,y,z\n").starts_with("dents.csv: the table has no lines"));
        assert!(parse(Path::new("dents.csv"), &[0xff, 0xfe]).is_err());
    }
}
