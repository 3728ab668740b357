//! Contract of every element: every registered type with every combination of its remedies, and with every kind of
//! material, layup and prescribed strain, on random warped and distorted shapes, through the interface that the program
//! uses.
//!
//! Forces and tangents are exact derivatives, by dual numbers where the materials are linear; rigid motions store no
//! energy, exactly six motions are free of energy, the numbering of the nodes does not matter, and the enhanced strains
//! satisfy their condition (eq. 36 of the paper).

use nalgebra::{DMatrix, DVector};
use num_dual::Dual64;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use tegula::Vec3;
use tegula::element::scalar::Scalar;
use tegula::element::shell::{PointResponse, condense};
use tegula::element::{Nodal, ShellGeometry, director_angle};
use tegula::model::*;
use tegula::norm::{larger, max_norm};
use tegula::system::VectorKind;

use crate::common::{Random, geometry, rotation};
use crate::harness::{Element, H, Materials, layup, materials};

/// Sections of every element with what it can carry.
fn laden() -> Vec<Section> {
    let mut out = Vec::new();
    for &element in ElementKind::ALL {
        let solid = matches!(element, ElementKind::Cm | ElementKind::SolidShell);
        let mut add = |material: &str, plies: &[(&str, f64, f64)]| {
            let mut s = Section { element, ..Section::new(material, H) };
            if !plies.is_empty() {
                (s.material, s.thickness, s.layup) = (String::new(), 0.0, Some(layup(plies)));
            }
            out.push(s);
        };
        add("m", &[]);
        add("ply", &[]);
        if element != ElementKind::AncfFull {
            add("metal", &[]);
            add("", &[("m", 0.0, 0.5), ("ply", 30.0, 0.3), ("ply", -50.0, 0.2)]);
            add("", &[("metal", 0.0, 0.4), ("ply", 20.0, 0.6)]);
        }
        if solid {
            add("rubber", &[]);
            add("", &[("rubber", 0.0, 0.5), ("ply", 20.0, 0.5)]);
        }
    }
    for element in [ElementKind::Ems, ElementKind::Mitc4] {
        for material in ["m", "metal"] {
            let beside = Layup { offset: -2.5 * H, ..layup(&[(material, 0.0, 0.4), ("ply", 20.0, 0.6)]) };
            out.push(Section { element, layup: Some(beside), ..Section::new("", 0.0) });
        }
    }
    out
}

/// Every element type with every combination of its remedies.
fn remedies() -> Vec<Section> {
    let mut out = Vec::new();
    for &element in ElementKind::ALL {
        println!("contract: element {}", element.name());
        for switches in 0..8_u8 {
            for thickness_eas in [0, 1, 3, 4] {
                let mut s = Section::new("m", H);
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

/// A warped and distorted element; narrow where the membrane part is chosen, whose weights begin at an aspect ratio of 2.
fn shape(section: &Section, random: &mut Random) -> ShellGeometry {
    match section.membrane {
        Some(_) => geometry(random, [0.25, 1.0], 0.03),
        None => geometry(random, [1.0, 1.0], 0.12),
    }
}

/// An element, the label of its section, and its sequence of random numbers.
struct Case {
    element: Element,
    label: String,
    random: Random,
    section: Section,
    geometry: ShellGeometry,
    materials: Materials,
    fields: bool,
}

impl Case {
    fn new(
        section: Section,
        materials: Materials,
        geometry: ShellGeometry,
        fields: bool,
        random: Random,
    ) -> Self {
        let layup = section.layup.as_ref().map(|l| &l.plies);
        let label = format!("{section:?} {layup:?} fields {fields}");
        let element = Element::with_fields(&section, &materials, &geometry, fields);
        Self { element, label, random, section, geometry, materials, fields }
    }

    /// Element of the case with its nodes in another order; `side` −1 turns its directors around.
    fn renumbered(&self, order: [usize; 4], side: f64) -> Element {
        let g = &self.geometry;
        let turned = ShellGeometry::new(order.map(|a| g.positions[a]), order.map(|a| g.directors[a] * side));
        Element::with_fields(&self.section, &self.materials, &turned, self.fields)
    }
}

/// Elements with all combinations of their remedies: of ordinary shape and material, and of random size, thickness,
/// stiffness and Poisson's ratio.
fn with_remedies() -> impl Iterator<Item = Case> {
    remedies().into_iter().enumerate().flat_map(|(i, section)| {
        [false, true].map(|any| {
            let mut random = Random::new(2 * i as u64 + u64::from(any));
            let g = shape(&section, &mut random);
            if !any {
                return Case::new(section.clone(), materials(), g, false, random);
            }
            let mut between = |a: f64, b: f64| a + 0.5 * (b - a) * (1.0 + random.next());
            let size = 10_f64.powf(between(-2.0, 2.0));
            let thickness = size * 10_f64.powf(between(-2.5, -0.5));
            let material = Isotropic::new(10_f64.powf(between(3.0, 11.0)), between(-0.9, 0.49), 1.0);
            let materials = Materials::from([("m".to_string(), Material::Isotropic(material))]);
            let g = ShellGeometry::new(g.positions.map(|x| x * size), g.directors);
            Case::new(Section { thickness, ..section.clone() }, materials, g, false, random)
        })
    })
}

/// Elements with every material, layup and prescribed strain that they can carry.
fn with_materials() -> impl Iterator<Item = Case> {
    let all = laden().into_iter().flat_map(|s| [(s.clone(), false), (s, true)]);
    all.enumerate().map(|(i, (section, fields))| {
        let mut random = Random::new(700 + i as u64);
        let g = geometry(&mut random, [1.0, 1.0], 0.12);
        Case::new(section, materials(), g, fields, random)
    })
}

/// Element of a cylinder of radius 1: `angle` wide, straight edges skewed by `skew`.
fn cylinder_patch(angle: f64, skew: f64) -> ShellGeometry {
    let at = |theta: f64, y: f64| Vec3::new(theta.sin(), y, 1.0 - theta.cos());
    let corners = [[0.0, 0.0], [angle, skew], [angle + skew, 0.5], [skew, 0.5 - skew]];
    ShellGeometry::new(
        corners.map(|[t, y]| at(t, y)),
        corners.map(|[t, _]| Vec3::new(-t.sin(), 0.0, t.cos())),
    )
}

/// Elements with all combinations of their remedies as parts of a cylinder, flat to strongly curved.
fn on_cylinders() -> impl Iterator<Item = Case> {
    let all = remedies().into_iter().flat_map(|s| [0.05, 0.4, 0.8].map(|angle| (s.clone(), angle)));
    all.enumerate().map(|(i, (section, angle))| {
        let section = Section { thickness: 0.01, ..section };
        Case::new(section, materials(), cylinder_patch(angle, 0.1), false, Random::new(i as u64))
    })
}

fn all_cases() -> impl Iterator<Item = Case> {
    with_remedies().chain(with_materials())
}

/// 1/√K_ii of the reference tangent in the units of the coordinates: entries that belong together.
fn scales(e: &Element) -> Vec<f64> {
    let (k, units) = (e.tangent(&vec![[0.0; 3]; e.kinds.len()]), e.units());
    let diagonal: Vec<f64> = (0..units.len()).map(|i| k[(i, i)] * units[i] * units[i]).collect();
    let least = 1e-8 * max_norm(&diagonal);
    diagonal.iter().map(|d| 1.0 / larger(*d, least).sqrt()).collect()
}

/// Strains are quadratic in the nodal vectors q: the forces Bᵀ n of the stresses n are `Σ 2 n_k A_k q`.
#[test]
fn forces_of_stresses_are_the_geometric_stiffness_times_the_nodal_vectors() {
    let mut kinds = std::collections::BTreeSet::new();
    for Case { element: e, label, mut random, section, .. } in all_cases().filter(|c| c.element.linear) {
        let u = e.displacement(0.1, &mut random);
        for [forces, product] in e.forces_of_stresses(&u) {
            let (size, error) = (max_norm(forces.iter()), max_norm((&forces - product).iter()));
            assert!(size > 0.0 && error < 1e-10 * size, "{label}: {error:e} of {size:e}");
            kinds.insert(section.element.name());
        }
    }
    assert!(!kinds.is_empty());
    println!("{kinds:?}");
}

#[test]
#[ignore = "long"]
fn force_is_the_derivative_of_the_energy_and_tangent_that_of_the_force_where_materials_are_linear() {
    for Case { element: e, label, mut random, .. } in all_cases().filter(|c| c.element.linear) {
        let (u, units, polynomial) = (e.displacement(0.1, &mut random), e.units(), e.polynomial());
        let scale = scales(&e);
        let flat: Vec<f64> = u.as_flattened().iter().zip(&units).map(|(u, unit)| u / unit).collect();
        let force: Vec<f64> = e.force(&u).iter().zip(&units).map(|(f, unit)| f * unit).collect();
        let tangent = e.tangent(&u);
        let n = units.len();
        let relative = |r: usize, c: usize, value: f64| value * scale[r] * scale[c];
        let entry = |r: usize, c: usize| tangent[(r, c)] * units[r] * units[c];
        let all = (0..n * n).map(|i| (i / n, i % n));
        let tangent_size = max_norm(all.map(|(r, c)| relative(r, c, entry(r, c))));
        let force_size = max_norm((0..n).map(|i| force[i] * scale[i]));
        let at_rest = polynomial.energy_and_force(&vec![0.0; n]).0 + e.energy(&vec![[0.0; 3]; e.kinds.len()]);
        let energy = polynomial.energy_and_force(&flat).0;
        let difference = energy - e.energy(&u) + at_rest;
        assert!(
            difference.abs() <= 1e-9 * (energy.abs() + at_rest.abs()),
            "{label}: {energy:e} {difference:e}"
        );
        for c in 0..n {
            let mut dual: Vec<Dual64> = flat.iter().map(|y| Dual64::from(*y)).collect();
            dual[c].eps = 1.0;
            let (energy, dual_force) = polynomial.energy_and_force(&dual);
            let error = (energy.eps - force[c]) * scale[c];
            assert!(error.abs() <= 1e-9 * force_size, "{label}: force {c}: {error:e} of {force_size:e}");
            for r in 0..n {
                let error = relative(r, c, dual_force[r].eps - entry(r, c));
                assert!(error.abs() <= 1e-9 * tangent_size, "{label}: tangent ({r}, {c}): {error:e}");
            }
        }
    }
}

#[test]
fn force_is_the_derivative_of_the_energy_and_tangent_that_of_the_force_where_materials_are_nonlinear() {
    for Case { element: e, label, mut random, .. } in with_materials().filter(|c| !c.element.linear) {
        let u = e.displacement(0.02, &mut random);
        let (force, tangent) = (e.force(&u), e.tangent(&u));
        assert!(force.iter().all(|f| f.is_finite()) && max_norm(&force) > 0.1, "{label}");
        for _ in 0..3 {
            let direction = e.displacement(0.02, &mut random);
            let flat = DVector::from_column_slice(direction.as_flattened());
            let along = |t: f64| -> Vec<Nodal> {
                let add = |(u, d): (&Nodal, &Nodal)| std::array::from_fn(|i| u[i] + t * d[i]);
                u.iter().zip(&direction).map(add).collect()
            };
            let h = 2e-4;
            let points = [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)];
            let work: f64 = points.iter().map(|(t, c)| c * e.energy(&along(t * h)) / (12.0 * h)).sum();
            let exact = force.dot(&flat);
            let scale = force.component_mul(&flat).abs().sum();
            assert!((work - exact).abs() < 1e-7 * scale, "{label}: {work:e} for {exact:e}");
            let product = &tangent * &flat;
            let change: DVector<f64> =
                points.iter().map(|(t, c)| e.force(&along(t * h)) * (c / (12.0 * h))).sum();
            assert!(max_norm(&(&change - &product)) < 1e-6 * max_norm(&product), "{label}: tangent");
        }
    }
}

#[test]
fn rigid_motions_change_no_energy_and_turn_forces_and_tangents() {
    let q = rotation([0.3, -0.8, 0.5], 2.1);
    for Case { element: e, label, mut random, .. } in all_cases() {
        let shift = Vec3::new(0.7, -1.3, 0.4) * e.size;
        for part in [0.0, 0.02] {
            let u = e.displacement(part, &mut random);
            let moved = e.moved(&u, &q, shift);
            // A displacement of the size of the element stretches it by one.
            let k = e.tangent(&vec![[0.0; 3]; u.len()]);
            let stiff = max_norm(k.diagonal().iter().zip(e.units()).map(|(k, unit)| k * unit * unit));
            let (a, b) = (e.energy(&u), e.energy(&moved));
            assert!((a - b).abs() <= 1e-11 * (a.abs() + 1e-3 * stiff), "{label}: {a:e} {b:e} {stiff:e}");
            let (f, turned) = (e.force(&u), e.force(&moved));
            for v in 0..u.len() {
                let unit = e.units()[3 * v];
                let at = |list: &DVector<f64>| Vec3::new(list[3 * v], list[3 * v + 1], list[3 * v + 2]);
                let error = (at(&turned) - q * at(&f)).norm() * unit;
                assert!(error <= 1e-11 * stiff, "{label}: force on {v}: {error:e} of {stiff:e}");
            }
            let mut rotate = DMatrix::zeros(k.nrows(), k.nrows());
            for v in 0..u.len() {
                rotate.view_mut((3 * v, 3 * v), (3, 3)).copy_from(q.matrix());
            }
            let (k, units) = (e.tangent(&u), e.units());
            let difference = e.tangent(&moved) - &rotate * k * rotate.transpose();
            for (i, d) in difference.iter().enumerate() {
                let error = (d * units[i / units.len()] * units[i % units.len()]).abs();
                assert!(error <= 1e-10 * stiff, "{label}: tangent: {error:e} of {stiff:e}");
            }
        }
    }
}

#[test]
fn energy_and_forces_do_not_depend_on_the_numbering_of_the_nodes() {
    let mirrors = [([0, 3, 2, 1], 1.0), ([0, 3, 2, 1], -1.0), ([1, 0, 3, 2], -1.0)];
    let turns = [([1, 2, 3, 0], 1.0), ([2, 3, 0, 1], 1.0), ([3, 0, 1, 2], 1.0)];
    for mut case in all_cases().chain(on_cylinders()) {
        let e = &case.element;
        let u = e.displacement(0.02, &mut case.random);
        let (energy, force) = (e.energy(&u), e.force(&u));
        let size = |kind: VectorKind| {
            let of = |v: &usize| e.kinds[*v] == kind;
            max_norm((0..u.len()).filter(of).flat_map(|v| (0..3).map(move |i| 3 * v + i)).map(|i| force[i]))
        };
        // The top is another side where layers or prescribed strains differ, and gradients follow the directors.
        let sided = case.fields || case.section.layup.is_some() || e.shell.nodal_vectors().len() > 2;
        for (order, side) in turns.into_iter().chain(mirrors).filter(|(_, side)| *side > 0.0 || !sided) {
            let other = case.renumbered(order, side);
            let place = |v: usize| 4 * (v / 4) + order[v % 4];
            let sign = |v: usize| if e.kinds[v] == VectorKind::Position { 1.0 } else { side };
            let u2: Vec<Nodal> = (0..u.len()).map(|v| u[place(v)].map(|x| x * sign(v))).collect();
            let (energy2, force2) = (other.energy(&u2), other.force(&u2));
            let label = format!("{} {order:?} {side}", case.label);
            assert!((energy - energy2).abs() <= 1e-9 * energy.abs(), "{label}: {energy:e} {energy2:e}");
            for v in 0..u.len() {
                for i in 0..3 {
                    let (a, b) = (force[3 * place(v) + i], sign(v) * force2[3 * v + i]);
                    assert!((a - b).abs() <= 1e-9 * size(e.kinds[v]), "{label}: force on {v}: {a:e} {b:e}");
                }
            }
        }
    }
}

/// The shear factors c_xz and c_yz count from the direction of the section, which is the global x axis without a layup: two *different* factors are the
/// same section from whichever corner the nodes are numbered, and another one where they are exchanged.
#[test]
fn different_shear_factors_do_not_depend_on_the_numbering() {
    let energies = |factors: [f64; 2]| {
        let section = Section { shear_correction: Some(factors), ..Section::new("m", 0.1) };
        let case = Case::new(section, materials(), cylinder_patch(0.4, 0.1), false, Random::new(3));
        let u = case.element.displacement(0.1, &mut Random::new(3));
        let energy = |order: [usize; 4]| {
            let u: Vec<Nodal> = (0..8).map(|v| u[4 * (v / 4) + order[v % 4]]).collect();
            case.renumbered(order, 1.0).energy(&u)
        };
        [[0, 1, 2, 3], [1, 2, 3, 0], [2, 3, 0, 1]].map(energy)
    };
    let [first, turned, opposite] = energies([0.3, 1.0]);
    assert!((turned - first).abs() < 1e-9 * first, "{turned} {first}");
    assert!((opposite - first).abs() < 1e-9 * first, "{opposite} {first}");
    let [exchanged, ..] = energies([1.0, 0.3]);
    assert!((exchanged - first).abs() > 1e-3 * first, "{exchanged} {first}");
}

/// Minimum of the energy over the enhanced parameters: their forces vanish, and the energy is at most that without them.
#[test]
fn enhanced_stress_does_no_work_on_enhanced_strain() {
    for Case { element: e, label, mut random, .. } in with_remedies() {
        let (samples, parameters) = (e.shell.samples(), e.shell.parameters());
        if parameters == 0 {
            continue;
        }
        let with = condense(&e.points, samples, parameters, 0).unwrap();
        let mut k_aa = DMatrix::<f64>::zeros(parameters, parameters);
        let mut plain = DMatrix::<f64>::zeros(samples, samples);
        for p in &e.points {
            let PointResponse::Linear(c) = &p.response else { unreachable!() };
            k_aa += p.enhanced.transpose() * c * &p.enhanced * p.weight;
            plain += p.samples.transpose() * c * &p.samples * p.weight;
        }
        let diagonal: Vec<f64> = (0..parameters).map(|i| k_aa[(i, i)].sqrt()).collect();
        let scaled =
            DMatrix::from_fn(parameters, parameters, |i, j| k_aa[(i, j)] / diagonal[i] / diagonal[j]);
        assert!(scaled.symmetric_eigenvalues().iter().all(|v| *v > 1e-4), "{label}: K_αα {scaled}");
        for _ in 0..4 {
            let s = DVector::from_fn(samples, |_, _| random.next());
            let alpha = &with.recovery * &s;
            let [energy, most] = [&with.stiffness, &plain].map(|h| 0.5 * s.dot(&(h * &s)));
            assert!(energy > 0.0 && energy <= most * (1.0 + 1e-13), "{label}: {energy:e} of {most:e}");
            let (mut force, mut size, mut sum) =
                (DVector::zeros(parameters), DVector::zeros(parameters), 0.0);
            for p in &e.points {
                let PointResponse::Linear(c) = &p.response else { unreachable!() };
                let strain = &p.samples * &s + &p.enhanced * &alpha;
                let stress = c * &strain;
                force += p.enhanced.transpose() * &stress * p.weight;
                size += p.enhanced.transpose().abs() * stress.abs() * p.weight;
                sum += 0.5 * strain.dot(&stress) * p.weight;
            }
            for i in 0..parameters {
                assert!(force[i].abs() <= 1e-11 * size[i], "{label}: {i}: {:e}", force[i] / size[i]);
            }
            assert!((sum - energy).abs() <= 1e-11 * most, "{label}: {sum:e} recovered, {energy:e} of H");
        }
    }
}

#[test]
fn membrane_parts_have_the_same_energy_in_affine_motion() {
    let mut random = Random::new(50);
    let mut flat = geometry(&mut random, [0.2, 1.0], 0.03);
    for (x, d) in flat.positions.iter_mut().zip(&mut flat.directors) {
        (x.z, *d) = (0.0, Vec3::z());
    }
    for kind in [ElementKind::Ems, ElementKind::Cm, ElementKind::Mitc4, ElementKind::SolidShell] {
        let energies = Membrane::ALL.map(|membrane| {
            let section = Section { element: kind, membrane: Some(membrane), ..Section::new("m", H) };
            let e = Element::new(&section, &materials(), &ShellGeometry::new(flat.positions, flat.directors));
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

/// Directors of elements that keep their length cannot stretch: their length has no stiffness and is no motion.
#[test]
fn exactly_six_motions_are_free_of_energy() {
    for Case { element: e, label, section, .. } in with_remedies().chain(on_cylinders()) {
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
        // Bending is softer than stretching by (h/L)², with a margin for bad shapes.
        let soft = 1e-4 * (section.thickness / e.size).powi(2);
        assert!(values[5].abs() <= 1e-12, "{label}: sixth eigenvalue {:e}", values[5]);
        assert!(values[6] >= larger(soft, 1e-11), "{label}: seventh {:e}, at least {soft:e}", values[6]);
    }
}

#[test]
fn mass_is_that_of_the_volume_in_rigid_motion() {
    for (i, section) in remedies().iter().enumerate() {
        let mut random = Random::new(400 + i as u64);
        let e = Element::new(section, &materials(), &geometry(&mut random, [1.0, 1.0], 0.0));
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
                    let at = Vec3::new(x, y, z * H);
                    exact += 0.5 * 2.0 * H / 8.0 * (velocity + omega.cross(&at)).norm_squared();
                }
            }
        }
        assert!((kinetic - exact).abs() <= 1e-12 * exact, "{section:?}: {kinetic} for {exact}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 24,
        rng_seed: RngSeed::Fixed(1),
        max_shrink_iters: 0,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// The constraint has one strain and so a singular diagonal; its entries need no scaling.
    #[test]
    fn director_angle_constraints_have_exact_derivatives_and_turn_with_rigid_motions(
        d in prop::array::uniform12(-1.0..1.0_f64),
        stiffness in 0.1..1e9_f64,
    ) {
        let v = |i: usize| Vec3::new(d[3 * i], d[3 * i + 1], d[3 * i + 2]);
        let reference = [Vec3::z() + v(0) * 0.3, Vec3::x() + v(1) * 0.3].map(|d| d.normalize());
        let u: [Nodal; 2] = [v(2), v(3)].map(|v| (v * 0.3).into());
        let h = director_angle::stiffness([&reference[0], &reference[1]], stiffness);
        let reference: [Nodal; 2] = reference.map(Into::into);
        let (energy, force) = constraint(&h, &reference, &u);
        prop_assume!(energy > 1e-4 * stiffness);
        let kernel = director_angle::strains();
        let (p0, p) = (kernel.directions(&reference), kernel.directions(&u));
        let s = kernel.strains(&p0, &p, true);
        let stress: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| h[3 * i + j] * s[j]).sum());
        let x = kernel.directions(&[0, 1].map(|v| std::array::from_fn(|i| reference[v][i] + u[v][i])));
        let mut blocks = [0.0; 27];
        kernel.tangent(&h, &kernel.gradient(&x), &stress, 1.0, 1.0, &mut blocks);
        for c in 0..6 {
            let mut dual = u.map(|v| v.map(Dual64::from));
            dual[c / 3][c % 3].eps = 1.0;
            let (e, f) = constraint(&h, &reference, &dual);
            assert!((e.eps - force[c / 3][c % 3]).abs() <= 1e-12 * stiffness);
            for r in 0..6 {
                let (a, b) = if r / 3 >= c / 3 { (r, c) } else { (c, r) };
                let found = blocks[9 * (a / 3 + b / 3) + 3 * (a % 3) + b % 3];
                assert!((f[r / 3][r % 3].eps - found).abs() <= 1e-12 * stiffness, "({r}, {c})");
            }
        }
        let q = rotation([1.0, 2.0, -0.5], 1.7);
        let moved = std::array::from_fn(|v| {
            let x0 = Vec3::from(reference[v]);
            (q * (x0 + Vec3::from(u[v])) - x0).into()
        });
        let (moved_energy, moved_force) = constraint(&h, &reference, &moved);
        assert!((moved_energy - energy).abs() <= 1e-12 * energy);
        for v in 0..2 {
            assert!((Vec3::from(moved_force[v]) - q * Vec3::from(force[v])).norm() <= 1e-12 * stiffness);
        }
    }
}

/// Energy and forces of a director-angle constraint over any scalar.
fn constraint<T: Scalar>(h: &[f64; 9], reference: &[Nodal; 2], u: &[[T; 3]; 2]) -> (T, [[T; 3]; 2]) {
    let kernel = director_angle::strains();
    let p0 = kernel.directions(&reference.map(|v| v.map(T::from)));
    let p = kernel.directions(u);
    let s = kernel.strains(&p0, &p, true);
    let (mut energy, mut stress) = (T::from(0.0), [T::from(0.0); 3]);
    for i in 0..3 {
        for j in 0..3 {
            stress[i] += T::from(h[3 * i + j]) * s[j];
        }
        energy += T::from(0.5) * s[i] * stress[i];
    }
    let mut x = p0;
    for (x, p) in x.iter_mut().zip(&p) {
        (0..3).for_each(|i| x[i] += p[i]);
    }
    (energy, kernel.force(&x, &stress))
}
