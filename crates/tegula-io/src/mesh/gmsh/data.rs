//! Sections `$NodeData` and `$ElementData`: values of post-processing views, which become fields.
//!
//! ```text
//! number of strings | name of the view, …
//! number of reals   | time, …
//! number of integers | number of the time step, components, rows, …
//! number of the node or element, value of each component
//! ```
//!
//! The lines of the head are text in binary files, too.

use std::collections::HashMap;

use tegula::Mesh;
use tegula::mesh::Labels;

use super::scanner::Scanner;
use crate::mesh::MeshError;

/// Values of a view at nodes or on elements.
#[derive(Debug)]
pub(super) struct View {
    name: String,
    /// On elements, else at nodes.
    on_elements: bool,
    components: u64,
    /// Value by the number of the node or element; none of views with several components.
    values: HashMap<u64, f64>,
}

/// Reads a section behind its name.
pub(super) fn view(scanner: &mut Scanner<'_>, on_elements: bool) -> Result<View, MeshError> {
    let start = scanner.position();
    let mut name = String::new();
    for i in 0..scanner.text_count("the number of names of a view")? {
        let line = scanner.line("the name of a view")?;
        if i == 0 {
            name = line.trim_matches('"').to_owned();
        }
    }
    for _ in 0..scanner.text_count("the number of real tags of a view")? {
        scanner.line("a real tag of a view")?;
    }
    let mut integers = [None; 3];
    for i in 0..scanner.text_count("the number of integer tags of a view")? {
        let value = scanner.text_count("an integer tag of a view")?;
        if let Some(integer) = usize::try_from(i).ok().and_then(|i| integers.get_mut(i)) {
            *integer = Some(value);
        }
    }
    let [_, Some(components), Some(rows)] = integers else {
        return Err(scanner.error(
            start,
            "a view has no number of components and of rows",
            "export the view again in Gmsh (File > Export, .msh)",
        ));
    };
    let mut values = HashMap::new();
    for _ in 0..rows {
        let number = scanner.natural("the number of a node or element of a view")?;
        let mut last = 0.0;
        for _ in 0..components {
            last = scanner.double("a value of a view")?;
        }
        if components == 1 {
            values.insert(number, last);
        }
    }
    Ok(View { name, on_elements, components, values })
}

/// Makes the views fields of a mesh: of those with one name the last, as the last time step. Nodes and elements without a value have NaN.
pub(super) fn add_fields(mesh: &mut Mesh, views: Vec<View>) {
    let Some(Labels { nodes, quads, .. }) = &mesh.labels else { return };
    for View { name, on_elements, components, values } in views {
        if components != 1 {
            mesh.fields.vectors.insert(name, usize::try_from(components).unwrap_or(usize::MAX));
            continue;
        }
        let (numbers, fields) =
            if on_elements { (quads, &mut mesh.fields.quads) } else { (nodes, &mut mesh.fields.nodes) };
        let of = |number: &u64| values.get(number).copied().unwrap_or(f64::NAN);
        fields.insert(name, numbers.iter().map(of).collect());
    }
}
