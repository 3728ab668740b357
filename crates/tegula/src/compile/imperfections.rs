//! Imperfections: the reference geometry of the mesh moved away from the nominal one, free of stress.

use std::collections::HashMap;
use std::f64::consts::TAU;

use super::{Compiler, steps};
use crate::analysis::{Observer, buckling};
use crate::checker::Checker;
use crate::mesh::{Mesh, Random};
use crate::model::{
    Analysis, BucklingAnalysis, FileImperfection, Imperfection, ModeImperfection, Model, RandomImperfection,
    WaveImperfection,
};
use crate::norm::larger;
use crate::{Error, Result, Vec3};

/// Relative difference of the load factors of modes that are not told apart.
const MULTIPLE: f64 = 1e-6;
/// Largest displacement of the mesh over that of the model in a mode that moves other parts.
const ELSEWHERE: f64 = 1e-3;
/// Number of waves of a random field.
const WAVES: usize = 400;

/// Mesh with the imperfections of a model; `None` where it has none.
///
/// Positions are displaced, and normals that are known turn with the facets; directors follow from them. The modes are those of the nominal
/// mesh under the loads of the first analysis step, about the reference configuration.
///
/// # Errors
/// The buckling modes cannot be computed, or the model has mistakes.
pub fn imperfect_mesh(model: &Model, mesh: &Mesh, observer: &mut dyn Observer) -> Result<Option<Mesh>> {
    if model.imperfections.is_empty() {
        return Ok(None);
    }
    let mut c = Checker::default();
    keys(model, &mut c);
    if !c.issues.is_empty() {
        return Err(Error::Model(c.issues));
    }
    if mesh.quads.is_empty() {
        return Err(Error::model(
            "imperfections",
            "the model has no mesh that imperfections could displace: beams and bodies keep their places",
            "leave them out, and let side loads or initial stresses disturb the beams; or model them as shells",
        ));
    }
    let mut displaced = vec![Vec3::zeros(); mesh.positions.len()];
    let modes = match wanted(model).max() {
        Some(number) => modes(model, mesh, number, observer)?,
        None => Vec::new(),
    };
    for (i, imperfection) in model.imperfections.iter().enumerate() {
        let before = displaced.clone();
        match imperfection {
            Imperfection::Mode(ModeImperfection { mode, amplitude }) => {
                let Some(shape) = modes.get(*mode as usize - 1) else {
                    return Err(Error::model(
                        format!("imperfections[{i}].mode"),
                        format!("the structure has only {} buckling modes", modes.len()),
                        "name one of them",
                    ));
                };
                // The mode may move beams most, which are not displaced.
                let largest = shape.iter().map(|u| u.norm()).fold(0.0, larger);
                if !(largest > ELSEWHERE) {
                    return Err(Error::model(
                        format!("imperfections[{i}].mode"),
                        format!(
                            "buckling mode {mode} hardly moves the mesh: it moves beams or bodies, which imperfections do not displace"
                        ),
                        "name a mode of the mesh, or model the beams as shells",
                    ));
                }
                add(&mut displaced, shape, *amplitude / largest);
            }
            Imperfection::Random(keys) => add(&mut displaced, &random(mesh, keys), keys.amplitude),
            Imperfection::Wave(keys) => add(&mut displaced, &wave(mesh, keys), keys.amplitude),
            Imperfection::File(keys) => {
                add(&mut displaced, &of_file(mesh, keys, &format!("imperfections[{i}].file"))?, keys.factor);
            }
        }
        if let Some(reason) = without_effect(mesh, imperfection, [&before, &displaced]) {
            observer.on_warning(&format!("imperfections[{i}]: {reason}"));
        }
    }
    Ok(Some(moved(mesh, &displaced)))
}

/// Reason why an imperfection, which changes the displacements of the nodes from the first ones to the second ones, has not the effect that it is most
/// likely meant to have, as text.
fn without_effect(
    mesh: &Mesh,
    imperfection: &Imperfection,
    [before, behind]: [&[Vec3]; 2],
) -> Option<String> {
    let used = mesh.quads.iter().flatten().map(|&node| node as usize);
    let moved = |node: usize| behind[node] - before[node];
    let first = mesh.quads.first().map(|quad| moved(quad[0] as usize))?;
    let size = used.clone().map(|node| moved(node).norm()).fold(0.0, larger);
    if size == 0.0 {
        return Some("it moves no node: its amplitude is 0, or its wave is 0 everywhere".into());
    }
    if used.map(|node| (moved(node) - first).norm()).fold(0.0, larger) <= SAME * size {
        return Some("it moves all nodes alike, and leaves the shape as it is: look at its direction".into());
    }
    let Imperfection::Random(RandomImperfection { correlation_length, .. }) = imperfection else {
        return None;
    };
    let edges = mesh.quads.iter().flat_map(|quad| (0..4).map(|i| [quad[i], quad[(i + 1) % 4]]));
    let length = |[a, b]: [u32; 2]| (mesh.positions[a as usize] - mesh.positions[b as usize]).norm();
    let (sum, count) = edges.map(length).fold((0.0, 0.0), |(sum, count), l| (sum + l, count + 1.0));
    let mean: f64 = sum / count;
    (*correlation_length < mean).then(|| {
        format!(
            "its correlation length {correlation_length} is shorter than the edges of the elements, {mean:.3e} on the average: nodes move \
             independently of each other"
        )
    })
}

/// Difference of the displacements of two nodes over them that is round-off.
const SAME: f64 = 1e-9;

/// Mistakes in the values of imperfections.
pub(super) fn keys(model: &Model, c: &mut Checker) {
    for (i, imperfection) in model.imperfections.iter().enumerate() {
        let key = format!("imperfections[{i}]");
        let amplitude = match imperfection {
            Imperfection::Mode(keys) => {
                if keys.mode == 0 {
                    c.add(format!("{key}.mode"), "modes are counted from 1", "give at least 1");
                }
                keys.amplitude
            }
            Imperfection::Random(keys) => {
                c.positive(
                    &format!("{key}.correlation_length"),
                    "the correlation length",
                    keys.correlation_length,
                );
                keys.amplitude
            }
            Imperfection::Wave(keys) => {
                c.positive(&format!("{key}.wavelength"), "the wavelength", keys.wavelength);
                c.finite(&format!("{key}.phase"), "the phase", &[keys.phase]);
                c.finite(&format!("{key}.direction"), "the direction", &keys.direction);
                c.not_zero(
                    &format!("{key}.direction"),
                    "the direction",
                    Vec3::from(keys.direction).norm(),
                    "give the direction in which the wave changes",
                );
                keys.amplitude
            }
            Imperfection::File(keys) => {
                c.finite(&format!("{key}.factor"), "the factor", &[keys.factor]);
                continue;
            }
        };
        c.finite(&format!("{key}.amplitude"), "the amplitude", &[amplitude]);
    }
}

/// Numbers of the buckling modes that are imperfections.
fn wanted(model: &Model) -> impl Iterator<Item = u32> + '_ {
    model.imperfections.iter().filter_map(|imperfection| match imperfection {
        Imperfection::Mode(keys) => Some(keys.mode),
        _ => None,
    })
}

fn add(field: &mut [Vec3], shape: &[Vec3], factor: f64) {
    field.iter_mut().zip(shape).for_each(|(x, shape)| *x += shape * factor);
}

/// Displacements of the nodes in the first buckling modes.
fn modes(model: &Model, mesh: &Mesh, number: u32, observer: &mut dyn Observer) -> Result<Vec<Vec<Vec3>>> {
    let Some(first) = steps(model).into_iter().next() else { return Ok(Vec::new()) };
    let mut nominal = first.model;
    // One mode more tells whether the last one is simple.
    let options = BucklingAnalysis::new(number + 1);
    nominal.analysis = Analysis::Buckling(options.clone());
    nominal.imperfections.clear();
    nominal.initial_velocities.clear();
    nominal.steps.clear();
    nominal.output = Default::default();
    let system = Compiler::new(&nominal, mesh)?.system(0, None)?;
    let found = buckling::run(&system, &options, observer)?;
    for mode in wanted(model).map(|mode| mode as usize) {
        let own = found.modes.get(mode - 1).map_or(f64::NAN, |mode| mode.factor);
        let same = |other: usize| {
            let other = found.modes.get(other).map_or(f64::NAN, |mode| mode.factor);
            (other - own).abs() <= MULTIPLE * own.abs()
        };
        if same(mode) || (mode > 1 && same(mode - 2)) {
            observer.on_warning(&format!(
                "imperfection in the shape of buckling mode {mode}: its load factor {own:.6e} has several modes, of which any combination is \
                 one; the imperfection depends on round-off. A slightly different load or shape separates them"
            ));
        }
    }
    let of_node = |shape: &[crate::element::Nodal], &v: &u32| match v {
        u32::MAX => Vec3::zeros(),
        v => Vec3::from(shape[v as usize]),
    };
    let nodes = &system.coordinates.position_of[..mesh.positions.len()];
    Ok(found.modes.iter().map(|mode| nodes.iter().map(|v| of_node(&mode.shape, v)).collect()).collect())
}

/// Random displacements along the normals, the largest of which is 1: a sum of waves with random directions and phases, whose wave vectors
/// are normally distributed with the standard deviation 1/ℓ (spectral representation; M. Shinozuka, C.-M. Jan, *Digital simulation of random processes and its
/// applications*, J. Sound Vib. 25 (1972) 111–128).
fn random(mesh: &Mesh, keys: &RandomImperfection) -> Vec<Vec3> {
    let mut numbers = Random(keys.seed);
    let mut wave = || {
        let wave = Vec3::from_fn(|_, _| normal(&mut numbers)) / keys.correlation_length;
        (wave, TAU * uniform(&mut numbers))
    };
    let waves: Vec<(Vec3, f64)> = (0..WAVES).map(|_| wave()).collect();
    let value = |x: &Vec3| waves.iter().map(|(wave, phase)| (wave.dot(x) + phase).cos()).sum::<f64>();
    let values: Vec<f64> = mesh.positions.iter().map(value).collect();
    let largest = values.iter().map(|x| x.abs()).fold(0.0, larger);
    let scale = if largest > 0.0 { 1.0 / largest } else { 0.0 };
    normals(mesh).iter().zip(values).map(|(normal, x)| normal * (x * scale)).collect()
}

/// A plane wave of amplitude 1 along the normals.
fn wave(mesh: &Mesh, keys: &WaveImperfection) -> Vec<Vec3> {
    let along = Vec3::from(keys.direction).normalize() * (TAU / keys.wavelength);
    let value = |x: &Vec3| (along.dot(x) + keys.phase.to_radians()).cos();
    normals(mesh).iter().zip(&mesh.positions).map(|(normal, x)| normal * value(x)).collect()
}

/// Displacements of the nodes in a table.
fn of_file(mesh: &Mesh, keys: &FileImperfection, key: &str) -> Result<Vec<Vec3>> {
    let Some(table) = &keys.displacements else {
        return Err(Error::model(
            key,
            format!("the table \"{}\" has not been read", keys.file),
            "fill in `displacements`: the library opens no files",
        ));
    };
    let nodes: HashMap<u64, usize> =
        (0..mesh.positions.len()).map(|node| (mesh.node_label(node as u32), node)).collect();
    let mut out = vec![Vec3::zeros(); mesh.positions.len()];
    for row in table.iter() {
        let Some(&node) = nodes.get(&row.node) else {
            let help = if mesh.labels.is_some() {
                "give the numbers of the mesh file".to_owned()
            } else {
                format!("the {} nodes of this mesh are counted from 0", mesh.positions.len())
            };
            return Err(Error::model(
                key,
                format!(
                    "\"{}\" displaces node {}, and the mesh has no node of this number",
                    keys.file, row.node
                ),
                help,
            ));
        };
        out[node] = row.displacement.into();
    }
    Ok(out)
}

/// Uniform number in 0…1, without 0.
fn uniform(numbers: &mut Random) -> f64 {
    0.5 * (1.0 - numbers.symmetric())
}

/// Number of the standard normal distribution (Box and Muller).
fn normal(numbers: &mut Random) -> f64 {
    (-2.0 * uniform(numbers).ln()).sqrt() * (TAU * uniform(numbers)).cos()
}

/// Mean unit normal of the surface at each node, or of the facets where that of the surface is not known; zero where there is none.
fn normals(mesh: &Mesh) -> Vec<Vec3> {
    let mut out = vec![Vec3::zeros(); mesh.positions.len()];
    let facets = mesh.facet_normals();
    let known = mesh.normals.as_ref();
    for (i, (quad, corners)) in mesh.quads.iter().zip(&facets).enumerate() {
        let corners = known.and_then(|known| known.get(i)).unwrap_or(corners);
        quad.iter().zip(corners).for_each(|(&node, normal)| out[node as usize] += normal);
    }
    out.iter().map(|normal| normal.try_normalize(0.0).unwrap_or_else(Vec3::zeros)).collect()
}

/// Mesh with displaced nodes. Known normals change like those of the facets.
fn moved(mesh: &Mesh, displaced: &[Vec3]) -> Mesh {
    let mut out = mesh.clone();
    out.positions.iter_mut().zip(displaced).for_each(|(x, u)| *x += u);
    let (before, after) = (mesh.facet_normals(), out.facet_normals());
    if let Some(normals) = &mut out.normals {
        for (normals, (before, after)) in normals.iter_mut().zip(before.iter().zip(&after)) {
            for (normal, (before, after)) in normals.iter_mut().zip(before.iter().zip(after)) {
                let turned = *normal + (after - before);
                *normal = turned.try_normalize(0.0).unwrap_or(*normal);
            }
        }
    }
    out
}
