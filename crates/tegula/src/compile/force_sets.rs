//! Sets of the mesh whose forces are recovered: those of supports and prescribed motions, and the loads.

use super::{body_inertia, relief};
use crate::Vec3;
use crate::mesh::Mesh;
use crate::model::Model;
use crate::system::ForceSet;

/// Sets that conditions support or move, each once, in the order of the model.
pub(super) fn of_conditions(model: &Model, mesh: &Mesh) -> Vec<ForceSet> {
    let mut out: Vec<ForceSet> = Vec::new();
    for (number, condition) in model.conditions.iter().enumerate() {
        let (name, key) = (condition.on(), format!("conditions[{number}]"));
        match out.iter_mut().find(|set| set.name == name) {
            Some(set) => set.keys.push(key),
            None => out.push(ForceSet { name: name.into(), keys: vec![key], about: centre(mesh, name) }),
        }
    }
    out
}

/// Loads by their kind and set; those with the same name are numbered.
pub(super) fn of_loads(model: &Model, mesh: &Mesh) -> Vec<ForceSet> {
    let mut out: Vec<ForceSet> = Vec::new();
    for (number, load) in model.loads.iter().enumerate() {
        let (kind, on) = (load.kind(), load.on());
        let name = if on.is_empty() { kind.to_owned() } else { format!("{kind}.{on}") };
        let same = |set: &ForceSet| set.name == name || set.name.starts_with(&format!("{name}#"));
        let before = out.iter().filter(|set| same(set)).count();
        let name = if before == 0 { name } else { format!("{name}#{}", before + 1) };
        let body = model.bodies.iter().find(|body| body.name == on);
        let about =
            body.map_or_else(|| centre(mesh, if on.is_empty() { "all" } else { on }), body_inertia::centre);
        out.push(ForceSet { name, keys: vec![format!("loads[{number}]")], about });
    }
    out
}

/// Supports that inertia relief adds, whose reactions vanish.
pub(super) fn of_relief(mesh: &Mesh) -> ForceSet {
    ForceSet { name: relief::NAME.into(), keys: vec![relief::KEY.into()], about: centre(mesh, "all") }
}

/// Load of the caller.
pub(super) fn of_caller(name: &str, mesh: &Mesh) -> ForceSet {
    ForceSet { name: name.into(), keys: Vec::new(), about: centre(mesh, "all") }
}

/// Reactions of supports that a static step has not any more, as a load.
pub(super) fn of_released_supports(mesh: &Mesh, others: &[ForceSet]) -> ForceSet {
    let free = |name: &String| others.iter().all(|set| set.name != *name);
    let numbered = (2..).map(|n| format!("released#{n}"));
    let name = std::iter::once("released".to_owned()).chain(numbered).find(free).unwrap_or_default();
    ForceSet { name, keys: Vec::new(), about: centre(mesh, "all") }
}

/// Mean of the nodes of a set.
fn centre(mesh: &Mesh, set: &str) -> Vec3 {
    let nodes = mesh.nodes_on(set).unwrap_or_default();
    let sum: Vec3 = nodes.iter().map(|&n| mesh.positions[n as usize]).sum();
    sum / nodes.len().max(1) as f64
}
