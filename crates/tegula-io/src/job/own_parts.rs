//! Parts of a model that no model file holds: loads and material laws of the caller.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use tegula::compile::Compiler;
use tegula::load::FieldLoad;
use tegula::material::MaterialLaw;
use tegula::model::Imperfection;
use tegula::{Error, Issue, Mesh, Model};

use crate::out::fingerprint;

/// Load of the caller on the nodes of a set, or on a body.
#[derive(Debug, Clone)]
pub struct OwnLoad {
    /// Name in the columns of the history and in messages.
    pub name: String,
    /// Name of the set or of the body. The load acts on the nodes of a set in ascending order, or on the mass centre of a body.
    pub on: String,
    /// Forces as functions of time and motion.
    pub load: Arc<dyn FieldLoad>,
}

/// Loads and material laws of the caller, which act in all analysis steps.
#[derive(Debug, Clone, Default)]
pub struct OwnParts {
    /// Loads.
    pub loads: Vec<OwnLoad>,
    /// Laws by the name of the material that they replace.
    pub laws: BTreeMap<String, Arc<dyn MaterialLaw>>,
}

impl OwnParts {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.loads.is_empty() && self.laws.is_empty()
    }

    /// Compiler of a model with these parts.
    ///
    /// # Errors
    /// Everything that is wrong with the model; a load whose set the model has not, or whose name is not its own.
    pub fn compiler<'a>(&self, model: &Model, mesh: &'a Mesh) -> tegula::Result<Compiler<'a>> {
        let mut compiler = Compiler::with_own_parts(model, mesh, &self.laws, !self.loads.is_empty())?;
        let mut issues: Vec<Issue> = self.refused_imperfections(model).into_iter().collect();
        let mut names = BTreeSet::new();
        for OwnLoad { name, on, load } in &self.loads {
            if !names.insert(name) {
                let message = format!("two loads of the caller have the name \"{name}\"");
                issues.push(Issue::new("loads", message, "give each a name of its own"));
            }
            match vectors(&compiler, mesh, on) {
                Ok(vectors) => compiler.add_field_load(name, vectors, load.clone()),
                Err(reason) => issues.push(Issue::new(
                    "loads",
                    format!("the load \"{name}\" of the caller acts on \"{on}\", {reason}"),
                    "name a set of the mesh or a body of the model",
                )),
            }
        }
        if issues.is_empty() { Ok(compiler) } else { Err(Error::Model(issues)) }
    }

    /// Imperfections by buckling modes, which belong to the model without these parts.
    fn refused_imperfections(&self, model: &Model) -> Option<Issue> {
        let by_modes = model.imperfections.iter().any(|i| matches!(i, Imperfection::Mode(_)));
        (by_modes && !self.is_empty()).then(|| {
            Issue::new(
                "imperfections",
                "buckling modes are those of the model file alone, without loads and material laws of the caller",
                "give the imperfection as a wave or as a file",
            )
        })
    }

    /// Fingerprint of a model with these parts by the names of the parts; what they compute is unknown.
    pub(super) fn fingerprint(&self, of_model: u64) -> u64 {
        if self.is_empty() {
            return of_model;
        }
        let loads = self.loads.iter().map(|load| format!("load {:?} {:?}\n", load.name, load.on));
        let laws = self.laws.keys().map(|name| format!("law {name:?}\n"));
        let text: String = loads.chain(laws).collect();
        fingerprint([of_model.to_le_bytes().as_slice(), text.as_bytes()].concat())
    }
}

/// Nodal vectors of the positions on which a load acts.
fn vectors(compiler: &Compiler<'_>, mesh: &Mesh, on: &str) -> Result<Vec<u32>, String> {
    if let Some(centre) = compiler.centre_of_body(on) {
        return Ok(vec![centre]);
    }
    let nodes = mesh.nodes_on(on).ok_or("which is neither a set of the mesh nor a body")?;
    if nodes.is_empty() {
        return Err("which has no nodes".into());
    }
    let position = |&node: &u32| {
        let [position, _] = compiler
            .vectors_of(node)
            .ok_or_else(|| format!("whose node {} belongs to no element", mesh.node_label(node)))?;
        Ok(position)
    };
    nodes.iter().map(position).collect()
}
