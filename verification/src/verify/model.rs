//! Models of the cases: model files of `verification/models/` with a few values changed.

use std::path::Path;

use tegula::analysis::{Observer, Silent, statics};
use tegula::compile::build;
use tegula::mesh::generators::generate;
use tegula::model::{
    Analysis, ElementKind, Grid, Isotropic, Material, Membrane, MeshSource, Model, Section, StaticAnalysis,
};
use tegula::{Error, Mesh, Result, System};

use tegula_io::deck::Deck;

use super::statistics::run_static;

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

/// The grid of a generated mesh.
pub fn grid(mesh: &mut MeshSource) -> Option<&mut Grid> {
    mesh.grid_mut()
}

/// Sets element type and remedies of all sections as a reference variant is named: `EMS no ANS shear`,
/// `CM eas4+3 ks=5/6`, `indep solid-shell EAS5 ks=1`, `inextensible EMS no EAS (MITC4)`. The value of the key `membrane`
/// may follow: `EMS membrane stable-eas`.
pub fn switch(model: &mut Model, variant: &str) {
    let (variant, membrane) = match variant.split_once(" membrane ") {
        Some((variant, name)) => (variant, Membrane::ALL.into_iter().find(|m| m.name() == name)),
        None => (variant, None),
    };
    let has = |text: &str| variant.contains(text);
    let none = has("no remedies");
    for s in &mut model.sections {
        s.element = if has("MITC4") || has("mitc4") || has("indep plate") {
            ElementKind::Mitc4
        } else if has("solid-shell") {
            ElementKind::SolidShell
        } else if has("ancf-full") {
            ElementKind::AncfFull
        } else if variant.to_lowercase().starts_with("cm") {
            ElementKind::Cm
        } else {
            ElementKind::Ems
        };
        s.ans_shear = !(none || has("no ANS shear") || has("plate no ANS"));
        s.ans_thickness = !(none || has("no ANS thick"));
        s.eas = true;
        s.membrane = membrane.or(Some(if none || has("no EAS") || has("no in-plane EAS") {
            Membrane::Displacement
        } else if has("assumed in-plane shear") {
            Membrane::AssumedShear
        } else {
            // The paper's element, whatever the default is.
            Membrane::Eas
        }));
        s.thickness_eas = if none || has("no thickness EAS") {
            0
        } else if has("4+3") || has("EAS7") {
            3
        } else if has("4+4") || has("EAS8") {
            4
        } else if has("4+1") || has("EAS5") || s.element == ElementKind::Cm && has("no ") {
            1
        } else {
            4
        };
        s.shear_correction = if has("ks=5/6") {
            Some([5.0 / 6.0; 2])
        } else if has("ks=1") {
            Some([1.0; 2])
        } else {
            None
        };
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
            Some([node]) => Ok(self.system.coordinates.position_of[*node as usize] as usize),
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
        run_static(&self.system, options, None, observer)
    }
}
