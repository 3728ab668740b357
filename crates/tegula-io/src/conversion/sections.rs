//! Sections of a model file.

use super::document::{Document, number, quoted, vector};

/// Section of a set of elements.
#[derive(Debug)]
pub(crate) struct Section {
    /// Quad set.
    pub on: String,
    /// Card that it comes from, as it is spelt in the file.
    pub card: &'static str,
    /// Line of the card.
    pub line: usize,
    /// Element type; the usual one unless given.
    pub element: Option<&'static str>,
    /// Layers from the bottom to the top.
    pub layers: Layers,
    /// The 0° direction of a layup; unless given the x axis.
    pub direction: Option<[f64; 3]>,
    /// Height of the middle of a layup above the mesh, with its line.
    pub offset: Option<(f64, usize)>,
}

/// Layers of a section.
#[derive(Debug)]
pub(crate) enum Layers {
    /// One layer whose material has no axes.
    One {
        /// Name of the material.
        material: String,
        /// Thickness.
        thickness: f64,
        /// Line of the thickness.
        line: usize,
    },
    /// A layup.
    Plies(Vec<Ply>),
}

/// A ply of a layup.
#[derive(Debug, Clone)]
pub(crate) struct Ply {
    /// Name of the material.
    pub material: String,
    /// Thickness.
    pub thickness: f64,
    /// Angle about the normal (degrees).
    pub angle: f64,
    /// Its line.
    pub line: usize,
}

impl Section {
    /// Writes the table of the section.
    pub fn write(&self, out: &mut Document) {
        out.table(self.line, "[[sections]]", self.card);
        out.key(self.line, "on", &quoted(&self.on));
        if let Some(element) = self.element {
            out.key(self.line, "element", &quoted(element));
        }
        match &self.layers {
            Layers::One { material, thickness, line } => {
                out.key(self.line, "material", &quoted(material));
                out.key(*line, "thickness", &number(*thickness));
            }
            Layers::Plies(plies) => {
                out.line(self.line, "layup.plies = [");
                for Ply { material, thickness, angle, line } in plies {
                    let (material, thickness) = (quoted(material), number(*thickness));
                    let angle = number(*angle);
                    out.line(
                        *line,
                        &format!(
                            "    {{ material = {material}, angle = {angle}, thickness = {thickness} }},"
                        ),
                    );
                }
                out.line(self.line, "]");
                if let Some(direction) = self.direction {
                    out.key(self.line, "layup.direction", &vector(&direction));
                }
                if let Some((offset, line)) = self.offset {
                    out.key(line, "layup.offset", &number(offset));
                }
            }
        }
    }
}
