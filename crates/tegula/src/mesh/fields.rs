//! Fields of a mesh file: arrays of numbers on its nodes and elements, from which distributions take their values.

use std::collections::BTreeMap;

use super::Mesh;

/// Arrays of a mesh file, by name.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fields {
    /// One number for each node.
    pub nodes: BTreeMap<String, Vec<f64>>,
    /// One number for each quad.
    pub quads: BTreeMap<String, Vec<f64>>,
    /// Numbers of components of vectors and tensors, which no factor can be; messages name them.
    pub vectors: BTreeMap<String, usize>,
}

/// Values of a field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FieldValues<'a> {
    /// One for each node.
    Nodes(&'a [f64]),
    /// One for each quad.
    Quads(&'a [f64]),
}

impl Mesh {
    /// Values of the field of a name, one for each node or quad.
    ///
    /// # Errors
    /// There is no such scalar field, two have this name, or it has the wrong length: description of the mistake, and remedy.
    pub fn field(&self, name: &str) -> Result<FieldValues<'_>, (String, String)> {
        let Fields { nodes, quads, vectors } = &self.fields;
        let (values, count, what) = match (nodes.get(name), quads.get(name), vectors.get(name)) {
            (Some(values), None, _) => (FieldValues::Nodes(values), self.positions.len(), "nodes"),
            (None, Some(values), _) => (FieldValues::Quads(values), self.quads.len(), "elements"),
            (Some(_), Some(_), _) => {
                let message = format!("the mesh has two fields \"{name}\", one of points and one of cells");
                return Err((message, "give one of them another name in the mesh file".into()));
            }
            (None, None, Some(components)) => {
                let message = format!("the field \"{name}\" has {components} components");
                return Err((message, format!("a factor is one number; {}", self.fields.known())));
            }
            (None, None, None) => {
                return Err((format!("the mesh has no field \"{name}\""), self.fields.known()));
            }
        };
        let (FieldValues::Nodes(list) | FieldValues::Quads(list)) = values;
        if list.len() == count {
            return Ok(values);
        }
        let message = format!("the field \"{name}\" has {} values for {count} {what}", list.len());
        Err((message, "give one value for each".into()))
    }
}

impl Fields {
    /// Names of all scalar fields, as a sentence.
    fn known(&self) -> String {
        let list = |names: Vec<&String>| -> String {
            names.into_iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
        };
        let [points, cells] = [&self.nodes, &self.quads].map(|fields| list(fields.keys().collect()));
        match (points.is_empty(), cells.is_empty()) {
            (true, true) => "the mesh has no fields of one component; VTU files and views in Gmsh files bring fields along".into(),
            (false, true) => format!("the mesh has, of points, {points}"),
            (true, false) => format!("the mesh has, of cells, {cells}"),
            (false, false) => format!("the mesh has, of points, {points}, and of cells {cells}"),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::Vec3;

    #[test]
    fn fields_are_found_by_name_and_length() {
        let mut mesh =
            Mesh { positions: vec![Vec3::zeros(); 4], quads: vec![[0, 1, 2, 3]], ..Mesh::default() };
        let refused = |mesh: &Mesh, name: &str| {
            let (message, help) = mesh.field(name).unwrap_err();
            format!("{message}; {help}")
        };
        assert!(refused(&mesh, "t").contains("no fields of one component"));
        mesh.fields.nodes.insert("t".into(), vec![1.0; 4]);
        mesh.fields.quads.insert("p".into(), vec![2.0]);
        mesh.fields.vectors.insert("u".into(), 3);
        assert_eq!(mesh.field("t").unwrap(), FieldValues::Nodes(&[1.0; 4]));
        assert_eq!(mesh.field("p").unwrap(), FieldValues::Quads(&[2.0]));
        assert!(
            refused(&mesh, "q")
                .contains("no field \"q\"; the mesh has, of points, \"t\", and of cells \"p\"")
        );
        assert!(refused(&mesh, "u").contains("has 3 components; a factor is one number"));
        mesh.fields.quads.insert("t".into(), vec![2.0]);
        assert!(refused(&mesh, "t").contains("two fields \"t\""));
        mesh.fields.quads.insert("p".into(), vec![2.0; 2]);
        assert!(refused(&mesh, "p").contains("has 2 values for 1 elements"));
    }
}
