//! Fields on the mesh, as VTU files.

use std::path::Path;

use tegula::analysis::State;
use tegula::element::Nodal;
use tegula::model::{Field, Output};
use tegula::result::inside::Snapshot;
use tegula::result::{Equilibrium, ShellResult, plastic_strains, plies, recover};
use tegula::{Mesh, System};

use super::frames;
use crate::out::{DataArray, OutputError, VtuGrid, vtu};

pub(super) mod bodies;
mod more;

const PLANE: [&str; 3] = ["xx", "yy", "xy"];
const PLY: [&str; 3] = ["11", "22", "12"];
const SHEAR: [&str; 2] = ["xz", "yz"];

/// A nodal field of positions, node by node; zero where a node has no element.
pub fn nodal(system: &System, field: &[Nodal]) -> Vec<Nodal> {
    let value = |&v: &u32| field.get(v as usize).copied().unwrap_or_default();
    system.coordinates.position_of.iter().map(value).collect()
}

/// Positions of all nodes of the mesh at displacements `u` times `scale`.
pub fn positions(mesh: &Mesh, system: &System, u: &[Nodal], scale: f64) -> Vec<[f64; 3]> {
    let moved = nodal(system, u);
    mesh.positions.iter().zip(moved).map(|(x, u)| std::array::from_fn(|i| x[i] + scale * u[i])).collect()
}

/// A quantity of the shells, quad by quad; NaN where a quad has no shell.
pub(super) fn by_quad<const N: usize>(
    mesh: &Mesh,
    system: &System,
    results: &[ShellResult],
    value: impl Fn(&ShellResult) -> [f64; N],
) -> Vec<f64> {
    let mut out = vec![f64::NAN; N * mesh.quads.len()];
    for (shell, result) in system.shells.iter().zip(results) {
        let first = N * shell.quad as usize;
        out[first..first + N].copy_from_slice(&value(result));
    }
    out
}

/// Von Mises stress of a state, quadrilateral by quadrilateral (force/length²): the greatest of top, middle and bottom; NaN where there is no shell.
pub fn von_mises(mesh: &Mesh, system: &System, state: &State) -> Vec<f64> {
    by_quad(mesh, system, &recover(system, state), |r| [r.von_mises])
}

/// Fields of a state, or of a small motion about it.
pub(super) struct Frame<'a> {
    /// State, by which the mesh is deformed.
    pub state: &'a State,
    /// Small motion about the state, whose displacements and stresses are written in place of the state's.
    pub small: Option<&'a [Nodal]>,
    /// Reactions; none for a small motion.
    pub forces: Option<&'a Equilibrium>,
    /// Time of the file.
    pub time: f64,
}

impl<'a> Frame<'a> {
    /// Fields of a state.
    pub fn of_state(state: &'a State) -> Self {
        Self { state, small: None, forces: None, time: frames::place(state) }
    }

    /// Where stresses come from.
    pub fn snapshot(&self, system: &'a System) -> Snapshot<'a> {
        match self.small {
            None => Snapshot::new(system, self.state),
            Some(shape) => Snapshot::of_small_motion(system, self.state, shape),
        }
    }
}

/// Writes the wanted fields of a state, on the reference mesh or the deformed one, or of a small motion on the mesh of
/// its state.
pub(super) fn write(
    path: &Path,
    mesh: &Mesh,
    system: &System,
    output: &Output,
    frame: &Frame<'_>,
    results: &[ShellResult],
) -> Result<(), OutputError> {
    let state = frame.state;
    let deformed = output.deformed || frame.small.is_some();
    let points = positions(mesh, system, &state.u, f64::from(u8::from(deformed)));
    let wanted = &output.fields;
    let mut point_data: Vec<DataArray<'_>> = Vec::new();
    let mut cell_data: Vec<DataArray<'_>> = Vec::new();
    let plane = |name: &'static str, value: fn(&ShellResult) -> [f64; 3]| {
        DataArray::new(name, 3, by_quad(mesh, system, results, value)).with_component_names(&PLANE)
    };
    let scalar = |name: &'static str, value: fn(&ShellResult) -> [f64; 1]| {
        DataArray::new(name, 1, by_quad(mesh, system, results, value))
    };
    let has = |field: Field| wanted.contains(&field);
    if has(Field::Displacement) {
        point_data.push(DataArray::new(
            "displacement",
            3,
            nodal(system, frame.small.unwrap_or(&state.u)).concat(),
        ));
    }
    if has(Field::Director) {
        let values = directors(system, state, frame.small).concat();
        let name = if frame.small.is_some() { "director_change" } else { "director" };
        point_data.push(DataArray::new(name, 3, values));
    }
    if has(Field::Velocity) {
        point_data.push(DataArray::new("velocity", 3, nodal(system, &state.v).concat()));
    }
    if has(Field::Reaction)
        && let Some(forces) = frame.forces
    {
        let (at_nodes, moments) = forces.at_nodes(system, &state.u);
        point_data.push(DataArray::new("reaction", 3, at_nodes.concat()));
        point_data.push(DataArray::new("reaction_moment", 3, moments.concat()));
    }
    if has(Field::Membrane) {
        cell_data.push(plane("membrane", |r| r.membrane));
    }
    if has(Field::Bending) {
        cell_data.push(plane("bending", |r| r.bending));
    }
    if has(Field::Shear) {
        let values = by_quad(mesh, system, results, |r| r.shear);
        cell_data.push(DataArray::new("shear", 2, values).with_component_names(&SHEAR));
    }
    if has(Field::SurfaceStress) {
        cell_data.push(plane("stress_top", |r| r.stress_top));
        cell_data.push(plane("stress_bottom", |r| r.stress_bottom));
    }
    if has(Field::VonMises) {
        cell_data.push(scalar("von_mises", |r| [r.von_mises]));
    }
    if has(Field::EnergyDensity) {
        cell_data.push(scalar("energy_density", |r| [r.energy_density]));
    }
    add_plies(mesh, system, wanted, frame, &mut cell_data);
    let plastic = system.sections.iter().any(|s| s.section.layers.iter().any(|l| l.material.yields()));
    if has(Field::PlasticStrain) && plastic {
        let strains = plastic_strains(system, state);
        cell_data.push(DataArray::new("plastic_strain", 1, by_shell(mesh, system, |i| strains[i])));
    }
    more::add(mesh, system, wanted, results, &mut point_data, &mut cell_data);
    vtu::write(
        path,
        &VtuGrid { points: &points, quads: &mesh.quads, lines: &[], point_data, cell_data, time: frame.time },
    )
}

/// Values of the shells on the elements of the mesh; NaN on those that are no shells.
fn by_shell(mesh: &Mesh, system: &System, value: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut out = vec![f64::NAN; mesh.quads.len()];
    for (i, shell) in system.shells.iter().enumerate() {
        out[shell.quad as usize] = value(i);
    }
    out
}

/// Adds the wanted stresses and failure indices of plies.
fn add_plies(
    mesh: &Mesh,
    system: &System,
    wanted: &[Field],
    frame: &Frame<'_>,
    cell_data: &mut Vec<DataArray<'_>>,
) {
    let has = |field: Field| wanted.contains(&field);
    let strong =
        system.sections.iter().any(|s| s.section.layers.iter().any(|l| l.material.strength().is_some()));
    let plies = if has(Field::PlyStress) || has(Field::Failure) && strong {
        plies::of_shells(&frame.snapshot(system))
    } else {
        Vec::new()
    };
    if has(Field::PlyStress) {
        let most = plies.iter().map(Vec::len).max().unwrap_or(0);
        for number in 0..most {
            for (place, name) in ["bottom", "middle", "top"].into_iter().enumerate() {
                let mut values = vec![f64::NAN; 3 * mesh.quads.len()];
                for (shell, of_shell) in system.shells.iter().zip(&plies) {
                    if let Some(ply) = of_shell.get(number) {
                        let first = 3 * shell.quad as usize;
                        values[first..first + 3].copy_from_slice(&ply.stress[place].plane);
                    }
                }
                let name = format!("ply_{}_{name}", number + 1);
                cell_data.push(DataArray::new(name, 3, values).with_component_names(&PLY));
            }
        }
    }
    if has(Field::Failure) && strong {
        let worst = |i: usize| {
            let failures = plies[i].iter().enumerate().filter_map(|(k, p)| Some((k, p.failure?)));
            failures.min_by(|a, b| a.1.reserve.total_cmp(&b.1.reserve))
        };
        cell_data.push(DataArray::new(
            "tsai_wu",
            1,
            by_shell(mesh, system, |i| worst(i).map_or(0.0, |w| w.1.tsai_wu)),
        ));
        // Where there is no stress the factor has no bound, and none is shown.
        let reserve = |i| worst(i).map_or(f64::NAN, |w| w.1.reserve);
        let bounded = |x: f64| if x < f64::MAX { x } else { f64::NAN };
        cell_data.push(DataArray::new("reserve_factor", 1, by_shell(mesh, system, |i| bounded(reserve(i)))));
        cell_data.push(DataArray::new(
            "max_stress",
            1,
            by_shell(mesh, system, |i| {
                plies[i].iter().filter_map(|p| Some(p.failure?.max_stress)).fold(0.0, tegula::norm::larger)
            }),
        ));
        cell_data.push(DataArray::new(
            "critical_ply",
            1,
            by_shell(mesh, system, |i| worst(i).map_or(0.0, |w| (w.0 + 1) as f64)),
        ));
    }
}

/// The (first) director of each node; of a small motion, its change.
pub fn directors(system: &System, state: &State, small: Option<&[Nodal]>) -> Vec<Nodal> {
    let value =
        |&v: &u32| match (system.coordinates.reference.get(v as usize), state.u.get(v as usize), small) {
            (Some(_), Some(_), Some(shape)) => shape[v as usize],
            (Some(d), Some(u), None) => std::array::from_fn(|i| d[i] + u[i]),
            _ => [0.0; 3],
        };
    system.coordinates.director_of.iter().map(value).collect()
}
