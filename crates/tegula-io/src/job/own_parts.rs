//! Parts of a model that no model file holds: loads and material laws of the caller.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use tegula::compile::Compiler;
use tegula::load::FieldLoad;
use tegula::material::MaterialLaw;
use tegula::model::{Imperfection, Load};
use tegula::{Error, Issue, Mesh, Model};

use crate::out::fingerprint;

/// Characters that separate columns of files.
const NOT_IN_NAMES: &str = ",;\"'`";
/// Names of loads that the program adds: those of released supports and joints, and of inertia relief.
const OF_PROGRAM: [&str; 2] = ["released", "inertia_relief"];

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
    /// Everything that is wrong with the model; a load whose set the model has not, or whose name is not its own or no part of a column.
    pub fn compiler<'a>(&self, model: &Model, mesh: &'a Mesh) -> tegula::Result<Compiler<'a>> {
        let mut compiler = Compiler::with_own_parts(model, mesh, &self.laws, !self.loads.is_empty())?;
        let mut issues: Vec<Issue> = self.refused_imperfections(model).into_iter().collect();
        let mut names = BTreeSet::new();
        for OwnLoad { name, on, load } in &self.loads {
            if !names.insert(name) {
                let message = format!("two loads of the caller have the name \"{name}\"");
                issues.push(Issue::new("loads", message, "give each a name of its own"));
            }
            issues.extend(refused_name(name, &compiler));
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

/// A name that cannot be part of the columns of the history, or that a load of the model has in one of its steps.
fn refused_name(name: &str, compiler: &Compiler<'_>) -> Option<Issue> {
    if name.trim().is_empty() || name.chars().any(|c| c.is_control() || NOT_IN_NAMES.contains(c)) {
        return Some(Issue::new(
            "loads",
            format!("{name:?} cannot name a load of the caller"),
            "it is part of the names of columns: give some letters, without commas, quotes and control characters",
        ));
    }
    let of_model = |load: &Load| {
        let (kind, on) = (load.kind(), load.on());
        let own = if on.is_empty() { kind.to_owned() } else { format!("{kind}.{on}") };
        // Those of one kind and set are numbered.
        name == own || name.strip_prefix(&own).is_some_and(|rest| rest.starts_with('#'))
    };
    let of_program = OF_PROGRAM.iter().any(|own| {
        name.strip_prefix(own).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '#']))
    });
    let is_taken = of_program || compiler.steps().iter().any(|step| step.model.loads.iter().any(of_model));
    is_taken.then(|| {
        Issue::new(
            "loads",
            format!("the load \"{name}\" of the caller has the name of a load of the model"),
            format!("give it another name: both would have the column `load.{name}.fx`"),
        )
    })
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
