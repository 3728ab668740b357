//! Models of the cases: model files of `verification/models/` with a few values changed.

use std::path::Path;

use tegula::analysis::{Observer, Silent, statics};
use tegula::mesh::generators::generate;
use tegula::model::build::build;
use tegula::model::{Analysis, Grid, Isotropic, Material, MeshSource, Model, Section, StaticAnalysis};
use tegula::{Error, Mesh, Result, System};

use crate::deck::Deck;

/// Reads an embedded model file.
pub fn read(text: &str) -> Result<Model> {
    Deck::parse(Path::new("verification model"), text).map(|d| d.model).map_err(|problems| {
        Error::Outside(problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
    })
}

/// Sets the number of elements.
pub fn refine(model: &mut Model, elements: [u32; 2]) {
    if let Some(grid) = grid(&mut model.mesh) {
        grid.elements = elements;
    }
}

fn grid(mesh: &mut MeshSource) -> Option<&mut Grid> {
    match mesh {
        MeshSource::Plate(m) => Some(&mut m.grid),
        MeshSource::Cylinder(m) => Some(&mut m.grid),
        MeshSource::Annulus(m) => Some(&mut m.grid),
        MeshSource::Sphere(m) => Some(&mut m.grid),
        MeshSource::Extrusion(m) => Some(&mut m.grid),
        MeshSource::Gmsh(_) => None,
    }
}

/// Switches the remedies of all sections as a reference variant is named: `EMS no ANS shear` and so on.
pub fn switch(model: &mut Model, variant: &str) {
    for s in &mut model.sections {
        let none = variant.ends_with("no remedies");
        s.ans_shear = !(none || variant.ends_with("no ANS shear"));
        s.ans_thickness = !(none || variant.ends_with("no ANS thick"));
        s.eas = !(none || variant.ends_with("no EAS"));
    }
}

/// The only section.
pub fn section(model: &mut Model) -> Result<&mut Section> {
    model.sections.first_mut().ok_or_else(|| Error::Outside("the model has no section".into()))
}

/// The only material.
pub fn material(model: &Model) -> Result<&Isotropic> {
    let Some(Material::Isotropic(m)) = model.materials.values().next() else {
        return Err(Error::Outside("the model has no material".into()));
    };
    Ok(m)
}

/// A compiled model and its mesh.
pub struct Compiled {
    /// Mesh.
    pub mesh: Mesh,
    /// System.
    pub system: System,
}

impl Compiled {
    /// Compiles a model.
    pub fn new(model: &Model) -> Result<Self> {
        let mesh = generate(&model.mesh)?;
        let system = build(model, &mesh)?;
        Ok(Self { mesh, system })
    }

    /// Nodal vector of the position of the only node of a set.
    pub fn point(&self, set: &str) -> Result<usize> {
        match self.mesh.nodes_on(set).as_deref() {
            Some([node]) => Ok(self.system.position_of[*node as usize] as usize),
            _ => Err(Error::Outside(format!("set \"{set}\" is not one node"))),
        }
    }

    /// Runs the static analysis of the model.
    pub fn statics(&self, model: &Model) -> Result<statics::StaticOutcome> {
        self.statics_watched(model, &mut Silent)
    }

    /// Runs the static analysis of the model with an observer.
    pub fn statics_watched(
        &self,
        model: &Model,
        observer: &mut dyn Observer,
    ) -> Result<statics::StaticOutcome> {
        let Analysis::Static(options) = &model.analysis else {
            return Err(Error::Outside("the model is not static".into()));
        };
        let options: &StaticAnalysis = options;
        statics::run(&self.system, options, None, observer)
    }
}
