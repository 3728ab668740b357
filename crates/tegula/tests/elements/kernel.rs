//! The kernel of bilinear shells of linear materials against the kernel that serves every element type: forces,
//! tangents, stresses, energies, damping, prescribed strains, of elements of all types and of any number.

use std::collections::BTreeMap;

use crate::common::{Random, geometry, ply, rotation, strains};
use tegula::element::shell::{GroupSetup, Member};
use tegula::element::{
    ElementGroup, GroupPoint, InternalVariables, Motion, Nodal, TangentRequest, TangentWeights, registry,
};
use tegula::model::*;
use tegula::norm::max_norm;

const THICKNESS: f64 = 0.07;
const VECTORS: usize = 8;
/// Unlike, so that no side stands for the other.
const SIDES: [f64; 2] = [1.3, 0.8];
const FACTORS: [f64; 2] = [0.8, -0.4];
const WEIGHTS: TangentWeights = TangentWeights {
    stress: 0.7,
    direction: 0.9,
    force: 1.3,
    rate: 2.5,
    augmentation: 0.0,
    penalty: 0.0,
    multiplier: 0.0,
};

/// Elements that do not share nodes.
struct Elements {
    reference: Vec<Nodal>,
    fast: Box<dyn ElementGroup>,
    general: Box<dyn ElementGroup>,
}

/// How copies of an earlier element lie.
#[derive(Clone, Copy, PartialEq)]
enum Copies {
    Shifted,
    /// Nothing may refer to a direction of space then.
    Turned,
}

fn elements(
    section: &Section,
    copies: Copies,
    count: usize,
    distortion: f64,
    random: &mut Random,
) -> Elements {
    let steel = Material::Isotropic(Isotropic { expansion: 1e-3, ..Isotropic::new(1e3, 0.3, 2.0) });
    let materials = BTreeMap::from([("steel".to_string(), steel), ("ply".to_string(), ply())]);
    let compiled = section.compile(&materials).unwrap();
    let shell = registry::shell(section, THICKNESS);
    let strains = strains();
    let prescribed: Vec<_> = strains[..FACTORS.len()]
        .iter()
        .map(|p| (copies == Copies::Shifted || p.direction().is_none()).then_some(p))
        .collect();
    assert!(prescribed.iter().any(Option::is_some));
    let mut shapes: Vec<_> = (0..count).map(|_| geometry(random, SIDES, distortion)).collect();
    // Some are earlier ones moved elsewhere: they share what their shape has.
    let like = |e: usize| (e % 3 == 2 && e >= 5).then(|| e - 3);
    for e in 0..count {
        if let Some(first) = like(e) {
            let shift = random.vector();
            let turn = match copies {
                Copies::Shifted => rotation([1.0, 0.0, 0.0], 0.0),
                Copies::Turned => rotation(random.vector().into(), 3.0 * random.next()),
            };
            shapes[e] = shapes[first];
            shapes[e].positions.iter_mut().for_each(|x| *x = turn * *x + shift);
            shapes[e].directors.iter_mut().for_each(|d| *d = turn * *d);
        }
    }
    let group = |reference_kernel| {
        let setup =
            GroupSetup { retardation_time: 0.03, laws: Vec::new(), fields: FACTORS.len(), reference_kernel };
        let mut builder = shell.builder(setup);
        for (e, geometry) in shapes.iter().enumerate() {
            let vectors: Vec<u32> = (0..VECTORS as u32).map(|a| (e * VECTORS) as u32 + a).collect();
            if let Some(first) = like(e)
                && builder.push_like(first, &vectors, geometry)
            {
                assert!(!reference_kernel);
                continue;
            }
            let integration_points =
                compiled.integration_points(shell.as_ref(), geometry, &prescribed).unwrap();
            let mass = shell.mass(geometry, &compiled.inertia);
            builder.push(Member { vectors: &vectors, geometry, integration_points, mass }).unwrap();
        }
        builder.finish().pop().unwrap()
    };
    let reference =
        shapes.iter().flat_map(|g| g.positions.iter().chain(&g.directors).map(|v| (*v).into())).collect();
    Elements { reference, fast: group(false), general: group(true) }
}

fn field(count: usize, size: f64, random: &mut Random) -> Vec<Nodal> {
    (0..count).map(|_| (random.vector() * size).into()).collect()
}

/// Everything that a group computes of a motion, concatenated by kind.
fn everything(g: &dyn ElementGroup, k: &GroupPoint, increment: &[Nodal]) -> Vec<(&'static str, Vec<f64>)> {
    let n = g.len();
    let mut stress = vec![0.0; n * g.stresses_per_element()];
    g.extrapolate(k, increment, &WEIGHTS, &mut stress);
    let mut out = Vec::new();
    let mut forces = vec![0.0; n * 3 * VECTORS];
    g.evaluate(k, 0, &mut forces, None);
    out.push(("forces", forces.clone()));
    for (stress, prescribed) in [(None, None), (Some(&stress), None), (Some(&stress), Some(increment))] {
        let mut blocks = vec![f64::NAN; n * 9 * VECTORS * (VECTORS + 1) / 2];
        let stress = stress.map(Vec::as_slice);
        let request = TangentRequest { weights: WEIGHTS, stress, prescribed, blocks: &mut blocks };
        g.evaluate(k, 0, &mut forces, Some(request));
        out.push(("forces with tangent", forces.clone()));
        out.push(("tangent", blocks));
    }
    let mut energies = vec![0.0; n];
    g.energies(k, &mut energies);
    out.push(("energies", energies.clone()));
    g.dissipation(k, &mut energies);
    out.push(("dissipation", energies));
    out.push(("strains", (0..n).flat_map(|e| g.sampled_strains(e, k)).collect()));
    out
}

#[test]
#[ignore = "long"]
fn both_kernels_agree() {
    let mut random = Random::new(31);
    let mut uneven = Section::new("", 0.0);
    uneven.layup = Some(Layup {
        plies: [("steel", 0.0, 0.6), ("ply", 30.0, 0.4)]
            .map(|(material, angle, part)| LayupPly {
                material: Some(material.into()),
                angle,
                thickness: Some(part * THICKNESS),
            })
            .to_vec(),
        direction: [1.0, 0.3, 0.2],
        ..Layup::default()
    });
    for element in [ElementKind::Ems, ElementKind::Cm, ElementKind::Mitc4, ElementKind::SolidShell] {
        let steel = || Section::new("steel", THICKNESS);
        let weighted = || Section { membrane: Some(Membrane::Mitc4Plus), ..steel() };
        for (section, copies) in [
            (steel(), Copies::Shifted),
            (steel(), Copies::Turned),
            (weighted(), Copies::Shifted),
            (uneven.clone(), Copies::Shifted),
        ] {
            let section = Section { element, ..section };
            // Flat and regular elements couple fewer forms; no, one and several registers, and parts of one.
            for (count, distortion) in [(1, 0.0), (7, 0.1), (8, 0.0), (19, 0.1), (130, 0.1)] {
                let e = elements(&section, copies, count, distortion, &mut random);
                // They are not the same kernel: one works in forms, the other in samples.
                if element != ElementKind::Mitc4 {
                    assert_ne!(e.fast.stresses_per_element(), e.general.stresses_per_element());
                }
                let n = e.reference.len();
                let (u, v, w) =
                    (field(n, 0.05, &mut random), field(n, 0.3, &mut random), field(n, 0.01, &mut random));
                let unit: Vec<bool> = (0..n).map(|i| i % 8 >= 4).collect();
                let motions = [
                    Motion::State { u: &u, velocity: Some(&v) },
                    Motion::State { u: &u, velocity: None },
                    Motion::Step { old: &v, new: &u, dt: 0.02 },
                ];
                for (motion, linear) in motions.into_iter().flat_map(|m| [(m, false), (m, true)]) {
                    let inextensible: &[bool] = if element == ElementKind::Mitc4 { &unit } else { &[] };
                    let interior = InternalVariables { history: &[], factors: &FACTORS };
                    let k = GroupPoint {
                        reference: &e.reference,
                        motion,
                        linear,
                        interior,
                        inextensible,
                        multipliers: &[],
                        time: 0.0,
                        drives: &[],
                        preload: 1.0,
                    };
                    let pairs = everything(e.fast.as_ref(), &k, &w).into_iter().zip(everything(
                        e.general.as_ref(),
                        &k,
                        &w,
                    ));
                    for ((what, fast), (_, general)) in pairs {
                        let size = max_norm(&general);
                        let worst = max_norm(fast.iter().zip(&general).map(|(x, y)| x - y));
                        assert_eq!(fast.len(), general.len());
                        assert!(
                            worst <= 1e-12 * size,
                            "{element:?} {count} {what} {motion:?}: {worst} of {size}"
                        );
                    }
                }
            }
        }
    }
}

/// Parts of a group are what they are in the whole.
#[test]
fn parts_are_evaluated_alike() {
    let mut random = Random::new(32);
    let e = elements(&Section::new("steel", THICKNESS), Copies::Shifted, 30, 0.1, &mut random);
    let u = field(e.reference.len(), 0.05, &mut random);
    let motion = Motion::State { u: &u, velocity: None };
    let interior = InternalVariables { history: &[], factors: &FACTORS };
    let k = GroupPoint {
        reference: &e.reference,
        motion,
        linear: false,
        interior,
        inextensible: &[],
        multipliers: &[],
        time: 0.0,
        drives: &[],
        preload: 1.0,
    };
    let mut whole = vec![0.0; 30 * 24];
    e.fast.evaluate(&k, 0, &mut whole, None);
    for (first, count) in [(0, 8), (8, 16), (16, 3), (24, 6)] {
        let mut part = vec![0.0; count * 24];
        e.fast.evaluate(&k, first, &mut part, None);
        assert_eq!(part, whole[first * 24..(first + count) * 24]);
    }
}
