//! Contract of every registered element type, tested on random warped and distorted elements and every
//! combination of its remedies, through the interface that the program itself uses.
//!
//! Energies are polynomials of degree four and forces of degree three in the displacements, so a
//! five-point difference is an exact derivative whatever its step.

use std::collections::BTreeMap;

use crate::common::{Random, geometry, rotation};
use nalgebra::DMatrix;
use tegula::Vec3;
use tegula::element::shell::{GroupSetup, Member, ShellElement};
use tegula::element::{
    ElementGroup, GroupPoint, InternalVariables, Motion, Nodal, ShellGeometry, TangentRequest,
    TangentWeights, registry,
};
use tegula::model::{ElementKind, Isotropic, Material, Membrane, Section};
use tegula::norm::{larger, max_norm};
use tegula::system::VectorKind;

const THICKNESS: f64 = 0.08;

/// Every element type with every combination of its remedies.
fn sections() -> Vec<Section> {
    let mut out = Vec::new();
    for &element in ElementKind::ALL {
        println!("contract: element {}", element.name());
        for switches in 0..8_u8 {
            for thickness_eas in [0, 1, 3, 4] {
                let mut s = Section::new("m", THICKNESS);
                s.element = element;
                s.ans_shear = switches & 1 == 0;
                s.ans_thickness = switches & 2 == 0;
                s.eas = switches & 4 == 0;
                s.thickness_eas = thickness_eas;
                let ours = matches!(element, ElementKind::Cm | ElementKind::SolidShell);
                let plain = switches == 0 && thickness_eas == 4;
                if plain && element != ElementKind::AncfFull {
                    for membrane in [Membrane::StableEas, Membrane::Mitc4Plus, Membrane::AssumedShear] {
                        out.push(Section { membrane: Some(membrane), ..s.clone() });
                    }
                }
                if plain || (ours || thickness_eas == 4) && element != ElementKind::AncfFull {
                    out.push(s);
                }
            }
        }
    }
    out
}

struct Element {
    groups: Vec<Box<dyn ElementGroup>>,
    kinds: Vec<VectorKind>,
    reference: Vec<Nodal>,
    shell: Box<dyn ShellElement>,
}

fn element(section: &Section, geometry: ShellGeometry) -> Element {
    let material = Material::Isotropic(Isotropic::new(1e3, 0.3, 2.0));
    let compiled = section.compile(&BTreeMap::from([("m".to_string(), material)])).unwrap();
    let shell = registry::shell(section, THICKNESS);
    let mut kinds = Vec::new();
    let mut reference: Vec<Nodal> = Vec::new();
    for (i, kind) in shell.nodal_vectors().iter().enumerate() {
        for a in 0..4 {
            kinds.push(*kind);
            reference.push(match kind {
                VectorKind::Position => geometry.positions[a].into(),
                VectorKind::Director => geometry.directors[a].into(),
                VectorKind::Gradient => geometry.tangents[a][i - 2].into(),
            });
        }
    }
    let vectors: Vec<u32> = (0..reference.len() as u32).collect();
    let mut builder = shell.builder(GroupSetup::default());
    builder
        .push(Member {
            vectors: &vectors,
            geometry: &geometry,
            integration_points: compiled.integration_points(shell.as_ref(), &geometry, &[]).unwrap(),
            mass: shell.mass(&geometry, &compiled.inertia),
        })
        .unwrap();
    Element { groups: builder.finish(), kinds, reference, shell }
}

impl Element {
    fn motion<'a>(&'a self, u: &'a [Nodal]) -> GroupPoint<'a> {
        GroupPoint {
            reference: &self.reference,
            motion: Motion::State { u, velocity: None },
            linear: false,
            interior: InternalVariables { history: &[], factors: &[] },
            inextensible: &[],
        }
    }

    fn energy(&self, u: &[Nodal]) -> f64 {
        let mut sum = 0.0;
        for g in &self.groups {
            let mut e = [0.0];
            g.energies(&self.motion(u), &mut e);
            sum += e[0];
        }
        sum
    }

    fn force(&self, u: &[Nodal]) -> Vec<f64> {
        let mut sum = vec![0.0; 3 * u.len()];
        for g in &self.groups {
            let mut f = vec![0.0; 3 * u.len()];
            g.evaluate(&self.motion(u), 0, &mut f, None);
            sum.iter_mut().zip(&f).for_each(|(s, f)| *s += f);
        }
        sum
    }

    fn tangent(&self, u: &[Nodal]) -> DMatrix<f64> {
        let m = u.len();
        let mut k = DMatrix::zeros(3 * m, 3 * m);
        for g in &self.groups {
            let mut f = vec![0.0; 3 * m];
            let mut blocks = vec![0.0; 9 * m * (m + 1) / 2];
            let weights = TangentWeights::STATIC;
            let request = TangentRequest { weights, stress: None, prescribed: None, blocks: &mut blocks };
            g.evaluate(&self.motion(u), 0, &mut f, Some(request));
            let mut block = blocks.chunks_exact(9);
            for a in 0..m {
                for b in 0..=a {
                    let values = block.next().unwrap();
                    for i in 0..9 {
                        k[(3 * a + i / 3, 3 * b + i % 3)] += values[i];
                        if a != b {
                            k[(3 * b + i % 3, 3 * a + i / 3)] += values[i];
                        }
                    }
                }
            }
        }
        k
    }

    /// A random displacement, small against the element but not infinitesimal.
    fn displacement(&self, random: &mut Random) -> Vec<Nodal> {
        self.kinds.iter().map(|_| (random.vector() * 0.1).into()).collect()
    }
}

/// `Σ c_i f(t_i)` of the five-point difference at the step h.
fn difference<T>(h: f64, f: impl Fn(f64) -> T, combine: impl Fn(&mut T, T, f64), zero: T) -> T {
    let mut sum = zero;
    for (t, c) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
        combine(&mut sum, f(t * h), c / (12.0 * h));
    }
    sum
}

/// A warped and distorted element; narrow where the membrane part is chosen, whose weights begin at an aspect ratio of 2.
fn shape(section: &Section, random: &mut Random) -> ShellGeometry {
    match section.membrane {
        Some(_) => geometry(random, [0.25, 1.0], 0.03),
        None => geometry(random, [1.0, 1.0], 0.12),
    }
}

#[test]
fn every_membrane_part_has_the_same_energy_in_affine_motion() {
    let mut random = Random::new(50);
    let mut flat = geometry(&mut random, [0.2, 1.0], 0.03);
    for (x, d) in flat.positions.iter_mut().zip(&mut flat.directors) {
        (x.z, *d) = (0.0, Vec3::z());
    }
    let parts = [
        Membrane::Eas,
        Membrane::StableEas,
        Membrane::Mitc4Plus,
        Membrane::AssumedShear,
        Membrane::Displacement,
    ];
    for kind in [ElementKind::Ems, ElementKind::Cm, ElementKind::Mitc4, ElementKind::SolidShell] {
        let energies = parts.map(|membrane| {
            let section = Section { element: kind, membrane: Some(membrane), ..Section::new("m", THICKNESS) };
            let e = element(&section, ShellGeometry::new(flat.positions, flat.directors));
            let stretch = nalgebra::Matrix3::new(0.4, 0.3, 0.0, -0.2, -0.3, 0.0, 0.1, 0.5, 0.0);
            let u: Vec<Nodal> = (0..e.kinds.len())
                .map(|v| {
                    let position = e.kinds[v] == VectorKind::Position;
                    (if position { stretch * Vec3::from(e.reference[v]) } else { Vec3::zeros() }).into()
                })
                .collect();
            e.energy(&u)
        });
        for energy in energies {
            assert!((energy - energies[0]).abs() <= 1e-12 * energies[0], "{kind:?}: {energies:?}");
        }
    }
}

#[test]
fn force_is_the_derivative_of_the_energy_and_tangent_that_of_the_force() {
    for (i, section) in sections().iter().enumerate() {
        let mut random = Random::new(100 + i as u64);
        let e = element(section, shape(section, &mut random));
        let u = e.displacement(&mut random);
        let (force, tangent) = (e.force(&u), e.tangent(&u));
        let size = max_norm(&force);
        for _ in 0..4 {
            let direction = e.displacement(&mut random);
            let along = |t: f64| -> Vec<Nodal> {
                let add = |(u, d): (&Nodal, &Nodal)| std::array::from_fn(|i| u[i] + t * d[i]);
                u.iter().zip(&direction).map(add).collect()
            };
            let flat: Vec<f64> = direction.as_flattened().to_vec();
            let work: f64 = force.iter().zip(&flat).map(|(f, d)| f * d).sum();
            let slope = difference(0.5, |t| e.energy(&along(t)), |s, v, c| *s += c * v, 0.0);
            let scale: f64 = force.iter().zip(&flat).map(|(f, d)| (f * d).abs()).sum();
            assert!((slope - work).abs() <= 1e-10 * scale, "{section:?}: {slope:e} for {work:e}");
            let product = &tangent * nalgebra::DVector::from_column_slice(&flat);
            let change = difference(
                0.5,
                |t| e.force(&along(t)),
                |s, v, c| s.iter_mut().zip(&v).for_each(|(s, v)| *s += c * v),
                vec![0.0; flat.len()],
            );
            for (a, b) in change.iter().zip(product.iter()) {
                assert!((a - b).abs() <= 1e-9 * size, "{section:?}: {a:e} for {b:e}");
            }
        }
    }
}

#[test]
fn rigid_motions_cost_nothing_and_turn_forces() {
    let q = rotation([0.3, -0.8, 0.5], 2.1);
    for (i, section) in sections().iter().enumerate() {
        let mut random = Random::new(200 + i as u64);
        let e = element(section, shape(section, &mut random));
        for u in [vec![[0.0; 3]; e.kinds.len()], e.displacement(&mut random)] {
            let (energy, force) = (e.energy(&u), e.force(&u));
            let moved: Vec<Nodal> = (0..u.len())
                .map(|v| {
                    let x0 = Vec3::from(e.reference[v]);
                    let shift = if e.kinds[v] == VectorKind::Position {
                        Vec3::new(3.0, -1.0, 2.0)
                    } else {
                        Vec3::zeros()
                    };
                    (q * (x0 + Vec3::from(u[v])) + shift - x0).into()
                })
                .collect();
            // An energy of strains of 1 in the stiffest sense is E h A.
            let stiff = 1e3 * THICKNESS;
            assert!((e.energy(&moved) - energy).abs() <= 1e-12 * (energy + 1e-12 * stiff), "{section:?}");
            let turned = e.force(&moved);
            let size = larger(1e-3 * stiff, max_norm(&force));
            for v in 0..u.len() {
                let f = |list: &[f64]| Vec3::new(list[3 * v], list[3 * v + 1], list[3 * v + 2]);
                assert!((f(&turned) - q * f(&force)).norm() <= 1e-11 * size, "{section:?}");
            }
        }
    }
}

/// Directors of elements that keep their length cannot stretch: their length has no stiffness and is no motion.
#[test]
fn exactly_six_motions_are_free_of_energy() {
    for (i, section) in sections().iter().enumerate() {
        let mut random = Random::new(300 + i as u64);
        let e = element(section, shape(section, &mut random));
        let n = 3 * e.kinds.len();
        let mut k = e.tangent(&vec![[0.0; 3]; e.kinds.len()]);
        if e.shell.unit_directors() {
            let mean = k.trace() / n as f64;
            for (v, kind) in e.kinds.iter().enumerate() {
                if *kind == VectorKind::Director {
                    let d = Vec3::from(e.reference[v]);
                    let mut block = k.view_mut((3 * v, 3 * v), (3, 3));
                    block += d * d.transpose() * mean;
                }
            }
            // The penalty must not count turning about an axis with displaced length as strain: it does not, to first order.
        }
        let scale: Vec<f64> = (0..n).map(|i| 1.0 / k[(i, i)].abs().sqrt()).collect();
        let scaled = DMatrix::from_fn(n, n, |i, j| k[(i, j)] * scale[i] * scale[j]);
        let mut values: Vec<f64> = scaled.symmetric_eigenvalues().iter().copied().collect();
        values.sort_by(f64::total_cmp);
        assert!(values[5].abs() <= 1e-12, "{section:?}: {:e}", values[5]);
        assert!(values[6] >= 1e-7, "{section:?}: {:e}", values[6]);
    }
}

#[test]
fn mass_is_that_of_the_volume_and_moves_rigidly() {
    for (i, section) in sections().iter().enumerate() {
        let mut random = Random::new(400 + i as u64);
        let e = element(section, geometry(&mut random, [1.0, 1.0], 0.0));
        let m = e.kinds.len();
        let mass = e.groups.iter().fold(vec![0.0; m * (m + 1) / 2], |mut sum, g| {
            sum.iter_mut().zip(g.mass(0)).for_each(|(s, m)| *s += m);
            sum
        });
        let full = |a: usize, b: usize| mass[a.max(b) * (a.max(b) + 1) / 2 + a.min(b)];
        let (velocity, omega) = (Vec3::new(1.0, 2.0, -0.5), Vec3::new(0.3, -0.7, 1.1));
        let rate = |v: usize| {
            let x = Vec3::from(e.reference[v]);
            omega.cross(&x) + if e.kinds[v] == VectorKind::Position { velocity } else { Vec3::zeros() }
        };
        let mut kinetic = 0.0;
        for a in 0..m {
            for b in 0..m {
                kinetic += 0.5 * full(a, b) * rate(a).dot(&rate(b));
            }
        }
        // ½∫ρ|v + ω × x|² over the unit plate, by Gauss's rule, exact for squares of linear fields.
        let mut exact = 0.0;
        let g = 0.5 / 3.0_f64.sqrt();
        for x in [0.5 - g, 0.5 + g] {
            for y in [0.5 - g, 0.5 + g] {
                for z in [-g, g] {
                    let at = Vec3::new(x, y, z * THICKNESS);
                    exact += 0.5 * 2.0 * THICKNESS / 8.0 * (velocity + omega.cross(&at)).norm_squared();
                }
            }
        }
        assert!((kinetic - exact).abs() <= 1e-12 * exact, "{section:?}: {kinetic} for {exact}");
    }
}
