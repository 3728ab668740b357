//! Loads and material laws of the caller, which no model file holds.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Compiler, named};
use crate::element::registry;
use crate::load::{FieldLoad, LoadOnNodes, NodalLoad, OwnLoad};
use crate::material::MaterialLaw;
use crate::mesh::Mesh;
use crate::model::Model;
use crate::{Issue, Result};

/// Mistake of a model without anything that acts, unless the caller adds loads.
pub(super) const NOTHING_ACTS: &str =
    "a static analysis without loads and prescribed motions has nothing to do";

impl<'a> Compiler<'a> {
    /// Checks and compiles a model some of whose materials have laws of the caller: the three-dimensional law of a
    /// nonlinear material in elements with three-dimensional stresses (`cm`, `solid-shell`) is the one with its name.
    ///
    /// # Errors
    /// As [`new`](Self::new); a law is given for a material that the model has not, or that no law can replace.
    pub fn with_laws(
        model: &Model,
        mesh: &'a Mesh,
        laws: &BTreeMap<String, Arc<dyn MaterialLaw>>,
    ) -> Result<Self> {
        Self::with_own_parts(model, mesh, laws, false)
    }

    /// As [`with_laws`](Self::with_laws), of a model to which the caller will add loads where `loaded` is true: it needs none of its own.
    ///
    /// # Errors
    /// As [`with_laws`](Self::with_laws).
    pub fn with_own_parts(
        model: &Model,
        mesh: &'a Mesh,
        laws: &BTreeMap<String, Arc<dyn MaterialLaw>>,
        loaded: bool,
    ) -> Result<Self> {
        Self::compiled(model, mesh, laws, loaded).map_err(|error| named(error, mesh))
    }

    /// Nodal vectors of the position and of the (first) director of a node; `None` for nodes without elements.
    pub fn vectors_of(&self, node: u32) -> Option<[u32; 2]> {
        let of = |list: &[u32]| list.get(node as usize).copied().filter(|&v| v != u32::MAX);
        Some([of(&self.vectors.coordinates.position_of)?, of(&self.vectors.coordinates.director_of)?])
    }

    /// Nodal vector of the mass centre of a body; `None`: there is no such body.
    pub fn centre_of_body(&self, name: &str) -> Option<u32> {
        self.vectors.coordinates.bodies.iter().find(|body| body.name == name).map(|body| body.centre)
    }

    /// Adds a load of the caller to all steps compiled from now on. In a static step it grows with the load factor, unless
    /// an earlier step had it, in a transient one it acts from the start.
    pub fn add_load(&mut self, name: &str, load: Arc<dyn NodalLoad>) {
        self.own_loads.push((name.to_owned(), OwnLoad(load)));
    }

    /// Adds a load of the caller on the positions of nodes or bodies, by their nodal vectors, to all steps compiled from now on; factors as for
    /// [`add_load`](Self::add_load). A step that cannot have it is an error of [`system`](Self::system).
    pub fn add_field_load(&mut self, name: &str, vectors: Vec<u32>, load: Arc<dyn FieldLoad>) {
        self.field_loads.push((name.to_owned(), Arc::new(LoadOnNodes::new(vectors, load))));
    }
}

/// A law for a material that is not there, or is linear: linear materials are integrated when the model is compiled.
pub(super) fn irreplaceable(model: &Model, name: &str) -> Option<Issue> {
    if let Some(issue) = out_of_place(model, name) {
        return Some(issue);
    }
    let (message, help) = match model.materials.get(name) {
        None => ("a law is given for it, but the model has no such material", "add the material"),
        Some(material) if material.is_linear() => (
            "a law is given for it, but the material is linear and integrated when the model is compiled",
            "give it a nonlinear type, such as \"neo-hookean\", with the stiffness of the law at zero strain",
        ),
        Some(_) => return None,
    };
    Some(Issue::new(format!("materials.{name}"), message, help))
}

/// Section in which a law of the caller is not evaluated, or not in the axes that it has: its element assumes plane stress, or its plies are turned.
fn out_of_place(model: &Model, name: &str) -> Option<Issue> {
    model.sections.iter().enumerate().find_map(|(i, section)| {
        if !section.materials().iter().any(|material| material == name) {
            return None;
        }
        if !registry::shell(section, section.whole_thickness()).is_solid() {
            return Some(Issue::new(
                format!("sections[{i}].element"),
                format!("a law is given for \"{name}\", and this element assumes plane stress, for which there is none"),
                "take the element `cm` or `solid-shell`",
            ));
        }
        let (key, layers) = section.layers()?;
        let angles = layers.plies("").unwrap_or_default();
        let turned = angles.iter().any(|ply| ply.material == name && ply.angle != 0.0);
        (turned || layers.direction() != [1.0, 0.0, 0.0]).then(|| {
            Issue::new(
                format!("sections[{i}].{key}"),
                format!(
                    "a law is given for \"{name}\", which gets strains in the cross-section frame of each element: angles and the direction of plies \
                     do not turn them"
                ),
                "leave `direction` and angles out, and turn strains and stresses in the law",
            )
        })
    })
}
