//! Materials of a model file.

use super::document::{Document, bare, number, vector};

/// An elastic material; each property with its line.
#[derive(Debug)]
pub(crate) struct Material {
    /// Name in the model file.
    pub name: String,
    /// Card that it comes from, as it is spelt in the file.
    pub card: &'static str,
    /// Line of the card.
    pub line: usize,
    /// Elastic constants.
    pub elastic: Option<(usize, Elastic)>,
    /// Density.
    pub density: Option<(usize, f64)>,
    /// Thermal expansion, or those along three axes.
    pub expansion: Option<(usize, Vec<f64>)>,
}

/// Elastic constants.
#[derive(Debug)]
pub(crate) enum Elastic {
    /// Young's modulus and Poisson's ratio.
    Isotropic([f64; 2]),
    /// E1, E2, E3, ν12, ν13, ν23, G12, G13 and G23.
    Orthotropic([f64; 9]),
}

impl Material {
    /// Writes the table of the material.
    pub fn write(&self, out: &mut Document) {
        out.table(self.line, &format!("[materials.{}]", bare(&self.name)), self.card);
        let mut directions = 1;
        match &self.elastic {
            Some((line, Elastic::Isotropic([young, poisson]))) => {
                out.key(*line, "type", "\"isotropic\"");
                out.key(*line, "young", &number(*young));
                out.key(*line, "poisson", &number(*poisson));
            }
            Some((line, Elastic::Orthotropic(constants))) => {
                directions = 3;
                out.key(*line, "type", "\"orthotropic\"");
                for (name, three) in ["young", "poisson", "shear"].into_iter().zip(constants.chunks(3)) {
                    out.key(*line, name, &vector(three));
                }
            }
            None => {}
        }
        if let Some((line, density)) = self.density {
            out.key(line, "density", &number(density));
        }
        match &self.expansion {
            Some((line, values)) if directions == 1 => {
                out.key(*line, "expansion", &number(values.first().copied().unwrap_or(0.0)));
            }
            Some((line, values)) => {
                let along = |i: usize| values.get(i).or(values.first()).copied().unwrap_or(0.0);
                out.key(*line, "expansion", &vector(&[along(0), along(1), along(2)]));
            }
            None => {}
        }
    }
}
