//! From the model and its mesh to the compiled [`System`].

use std::collections::BTreeMap;

use super::check;
use super::{AddedMass, Analysis, Condition, Load, Model, NodalVector};
use crate::element::ems::{self, EmsShell, ShellGeometry};
use crate::element::{ElementGroup, Nodal, QuadraticGroup, fold_tie};
use crate::load::{FollowerLoad, TimeFunction};
use crate::mesh::directors::{Directors, FOLD_ANGLE_DEGREES};
use crate::mesh::{Mesh, quality};
use crate::section::{SectionInertia, SectionStiffness};
use crate::system::numbering::{Numbering, Support, VectorKind};
use crate::system::pattern::PatternBuilder;
use crate::system::{DeadLoad, IndexMap, Shell, ShellSection, System};
use crate::{Error, Issue, Result, Vec3};

/// Nodal vectors of a mesh: position of each node, then its directors, node by node.
struct Vectors {
    reference: Vec<Nodal>,
    kinds: Vec<VectorKind>,
    nodes: Vec<u32>,
    position_of: Vec<u32>,
    director_of: Vec<u32>,
    /// Nodal vector of each director.
    of_director: Vec<u32>,
}

impl Vectors {
    fn new(mesh: &Mesh, directors: &Directors) -> Self {
        let nodes = mesh.positions.len();
        let mut of_node: Vec<Vec<u32>> = vec![Vec::new(); nodes];
        for (d, &node) in directors.node.iter().enumerate() {
            of_node[node as usize].push(d as u32);
        }
        let mut out = Self {
            reference: Vec::new(),
            kinds: Vec::new(),
            nodes: Vec::new(),
            position_of: vec![u32::MAX; nodes],
            director_of: vec![u32::MAX; nodes],
            of_director: vec![u32::MAX; directors.values.len()],
        };
        for (node, list) in of_node.iter().enumerate().filter(|(_, l)| !l.is_empty()) {
            out.position_of[node] = out.push(mesh.positions[node], VectorKind::Position, node);
            for (i, &d) in list.iter().enumerate() {
                let v = out.push(directors.values[d as usize], VectorKind::Director, node);
                out.of_director[d as usize] = v;
                if i == 0 {
                    out.director_of[node] = v;
                }
            }
        }
        out
    }

    fn push(&mut self, value: Vec3, kind: VectorKind, node: usize) -> u32 {
        self.reference.push(value.into());
        self.kinds.push(kind);
        self.nodes.push(node as u32);
        (self.reference.len() - 1) as u32
    }

    /// Directors of each node.
    fn directors_by_node(&self) -> BTreeMap<u32, Vec<u32>> {
        let mut out: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (v, (kind, node)) in self.kinds.iter().zip(&self.nodes).enumerate() {
            if *kind == VectorKind::Director {
                out.entry(*node).or_default().push(v as u32);
            }
        }
        out
    }
}

/// Compiles a model on its mesh.
///
/// # Errors
/// Everything that is wrong with the model, at once, each with the key or element and a remedy.
pub fn build(model: &Model, mesh: &Mesh) -> Result<System> {
    let mut issues = check::keys(model);
    issues.extend(quality::check(mesh));
    issues.extend(check::sets(model, mesh));
    if !issues.is_empty() {
        return Err(Error::Model(issues));
    }
    let directors = Directors::of(mesh, FOLD_ANGLE_DEGREES)?;
    let vectors = Vectors::new(mesh, &directors);
    let mut elements = Elements::default();
    elements.shells(model, mesh, &directors, &vectors, &mut issues);
    elements.ties(&directors, &vectors);
    let (amplitudes, names) = time_functions(model, &mut issues);
    let supports = supports(model, mesh, &vectors, &names);
    let numbering = match Numbering::new(vectors.reference.len(), &supports) {
        Ok(n) => Some(n),
        Err(pairs) => {
            let mut pairs = pairs;
            pairs.dedup();
            issues.extend(pairs.into_iter().map(|(first, second)| {
                Issue::new(
                    second,
                    format!("prescribes a component that {first} supports differently"),
                    "take the shared nodes out of one of the two sets, or drop one condition",
                )
            }));
            None
        }
    };
    let Some(numbering) = numbering.filter(|_| issues.is_empty()) else { return Err(Error::Model(issues)) };
    if numbering.unknowns == 0 {
        issues.push(Issue::new(
            "conditions",
            "every coordinate of the model is supported: nothing is left to compute",
            "take nodes out of the supported sets",
        ));
    }
    if !matches!(model.analysis, Analysis::Transient(_) | Analysis::Modal(_)) {
        issues.extend(check::mechanisms(mesh, &vectors.reference, &vectors.kinds, &vectors.nodes, &supports));
    }

    let mut builder = PatternBuilder::default();
    for group in &elements.groups {
        for e in 0..group.len() {
            builder.element(group.vectors(e), group.mass(e));
        }
    }
    let followers = follower_loads(model, mesh, &vectors, &names);
    for load in &followers {
        builder.element(load.vectors(), &[]);
    }
    issues.extend(lost_moments(&followers, &vectors));
    let added = added_masses(model, mesh, &vectors);
    for &(a, b, m) in &added {
        builder.mass(a, b, m);
    }
    let pattern = builder.build(vectors.reference.len(), &numbering);

    let linear = match &model.analysis {
        Analysis::Static(s) => s.linear,
        Analysis::Transient(t) => t.linear,
        Analysis::Modal(_) => false,
    };
    let proportional = matches!(model.analysis, Analysis::Static(_) | Analysis::Modal(_));
    let initial_velocity = initial_velocity(model, mesh, &vectors);
    let mut system = System {
        index_map: IndexMap::serial(vectors.reference.len()),
        numbering,
        groups: elements.groups,
        shells: elements.list,
        sections: elements.sections,
        dead_loads: Vec::new(),
        followers,
        amplitudes,
        pattern,
        mass_damping: model.damping.mass,
        length: mesh.extent(),
        linear,
        proportional,
        initial_velocity,
        reference: vectors.reference,
        kinds: vectors.kinds,
        nodes: vectors.nodes,
        position_of: vectors.position_of,
        director_of: vectors.director_of,
    };
    issues.extend(check::masses(model, &system));
    system.dead_loads = dead_loads(model, mesh, &system, &names);
    if issues.is_empty() { Ok(system) } else { Err(Error::Model(issues)) }
}

#[derive(Default)]
struct Elements {
    groups: Vec<Box<dyn ElementGroup>>,
    list: Vec<Shell>,
    sections: Vec<ShellSection>,
    /// h E A at the directors, for ties.
    director_stiffness: BTreeMap<u32, f64>,
}

impl Elements {
    fn shells(
        &mut self,
        model: &Model,
        mesh: &Mesh,
        directors: &Directors,
        vectors: &Vectors,
        issues: &mut Vec<Issue>,
    ) {
        for (index, section) in model.sections.iter().enumerate() {
            let (Some(material), Some(quads)) =
                (model.materials.get(&section.material), mesh.quads_on(&section.on))
            else {
                continue;
            };
            let stiffness = SectionStiffness::of(section, material);
            let super::Material::Isotropic(m) = material;
            let element = EmsShell {
                ans_shear: section.ans_shear,
                ans_thickness: section.ans_thickness,
                eas: section.eas,
            };
            let shells: Vec<(u32, [u32; 8], ShellGeometry)> = quads
                .iter()
                .map(|&q| {
                    let nodes = mesh.quads[q as usize];
                    let corners = directors.corners[q as usize];
                    let connectivity = std::array::from_fn(|a| {
                        if a < 4 {
                            vectors.position_of[nodes[a] as usize]
                        } else {
                            vectors.of_director[corners[a - 4] as usize]
                        }
                    });
                    let geometry = ShellGeometry {
                        positions: nodes.map(|n| mesh.positions[n as usize]),
                        directors: corners.map(|d| directors.values[d as usize]),
                    };
                    (q, connectivity, geometry)
                })
                .collect();
            let unit = SectionInertia::homogeneous(1.0, section.thickness);
            let density = match section.total_mass {
                None => m.density,
                Some(total) => {
                    let volume: f64 = shells
                        .iter()
                        .map(|(_, _, g)| {
                            let mass = element.mass(g, &unit);
                            (0..4).map(|a| (0..4).map(|b| mass[pair(a, b)]).sum::<f64>()).sum::<f64>()
                        })
                        .sum();
                    total / volume
                }
            };
            let inertia = SectionInertia::homogeneous(density, section.thickness);
            let tau = section.retardation_time + model.damping.stiffness;
            let mut fill = Fill {
                section: index,
                element,
                stiffness: &stiffness,
                inertia: &inertia,
                group: self.groups.len(),
                list: &mut self.list,
                director_stiffness: &mut self.director_stiffness,
                issues,
            };
            let group: Box<dyn ElementGroup> = if element.ans_shear {
                Box::new(fill.group::<{ ems::SAMPLES }>(&shells, tau))
            } else {
                Box::new(fill.group::<{ ems::SAMPLES_WITHOUT_ANS_SHEAR }>(&shells, tau))
            };
            self.groups.push(group);
            self.sections.push(ShellSection { stiffness, thickness: section.thickness });
        }
    }

    fn ties(&mut self, directors: &Directors, vectors: &Vectors) {
        if directors.ties.is_empty() {
            return;
        }
        let mut group = QuadraticGroup::<2, 6, 1>::new("fold-tie", fold_tie::strains(), 0.0);
        for pair in &directors.ties {
            let v = pair.map(|d| vectors.of_director[d as usize]);
            let stiffness =
                v.iter().filter_map(|v| self.director_stiffness.get(v)).fold(f64::INFINITY, |a, &b| a.min(b));
            if stiffness.is_finite() {
                group.push(v, &[stiffness], &[0.0; 3]);
            }
        }
        self.groups.push(Box::new(group));
    }
}

struct Fill<'a> {
    section: usize,
    element: EmsShell,
    stiffness: &'a SectionStiffness,
    inertia: &'a SectionInertia,
    group: usize,
    list: &'a mut Vec<Shell>,
    director_stiffness: &'a mut BTreeMap<u32, f64>,
    issues: &'a mut Vec<Issue>,
}

impl Fill<'_> {
    fn group<const S: usize>(
        &mut self,
        shells: &[(u32, [u32; 8], ShellGeometry)],
        tau: f64,
    ) -> QuadraticGroup<{ ems::VECTORS }, { ems::COORDINATES }, S> {
        let mut group = QuadraticGroup::new("ems", self.element.strains::<S>(), tau);
        for (quad, connectivity, geometry) in shells {
            let (h, _) = match self.element.stiffness(geometry, self.stiffness) {
                Ok(h) => h,
                Err(reason) => {
                    let c = geometry.positions.iter().sum::<Vec3>() / 4.0;
                    self.issues.push(Issue::new(
                        "mesh",
                        format!(
                            "element {quad} at ({:.4}, {:.4}, {:.4}) is invalid: {reason}",
                            c.x, c.y, c.z
                        ),
                        "repair the mesh there",
                    ));
                    continue;
                }
            };
            let mass = self.element.mass(geometry, self.inertia);
            let unit = self.element.mass(geometry, &SectionInertia { mass: 1.0, rotary: 0.0 });
            for a in 0..4 {
                let area: f64 = (0..4).map(|b| unit[pair(a, b)]).sum();
                *self.director_stiffness.entry(connectivity[a + 4]).or_default() +=
                    self.stiffness.thickness * area;
            }
            self.list.push(Shell {
                quad: *quad,
                member: (self.group, group.len()),
                element: self.element,
                geometry: *geometry,
                section: self.section,
            });
            group.push(*connectivity, &h, &mass);
        }
        group
    }
}

/// Place of a pair in a lower triangle.
fn pair(a: usize, b: usize) -> usize {
    let (i, j) = (a.max(b), a.min(b));
    i * (i + 1) / 2 + j
}

fn time_functions(model: &Model, issues: &mut Vec<Issue>) -> (Vec<TimeFunction>, BTreeMap<String, usize>) {
    let mut functions = Vec::new();
    let mut names = BTreeMap::new();
    for (name, amplitude) in &model.amplitudes {
        match TimeFunction::new(amplitude) {
            Ok(f) => {
                names.insert(name.clone(), functions.len());
                functions.push(f);
            }
            Err((message, help)) => issues.push(Issue::new(format!("amplitudes.{name}"), message, help)),
        }
    }
    (functions, names)
}

fn supports(
    model: &Model,
    mesh: &Mesh,
    vectors: &Vectors,
    amplitudes: &BTreeMap<String, usize>,
) -> Vec<Support> {
    let directors = vectors.directors_by_node();
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    let mut out = Vec::new();
    for (i, condition) in model.conditions.iter().enumerate() {
        let key = format!("conditions[{i}]");
        let mut add = |node: u32, of: NodalVector, direction: Vec3, motion| {
            let position = [vectors.position_of[node as usize]];
            let list: &[u32] = match of {
                NodalVector::Position => &position,
                NodalVector::Director => directors.get(&node).map_or(&[], Vec::as_slice),
            };
            for &vector in list.iter().filter(|&&v| v != u32::MAX) {
                out.push(Support { vector, direction, motion, key: key.clone() });
            }
        };
        for node in mesh.nodes_on(condition.on()).unwrap_or_default() {
            match condition {
                Condition::Clamp(_) => {
                    for a in axes {
                        add(node, NodalVector::Position, a, None);
                        add(node, NodalVector::Director, a, None);
                    }
                }
                Condition::Hinge(_) | Condition::Spherical(_) => {
                    axes.into_iter().for_each(|a| add(node, NodalVector::Position, a, None));
                }
                Condition::Symmetry(plane) => {
                    let normal = Vec3::from(plane.normal).normalize();
                    add(node, NodalVector::Position, normal, None);
                    add(node, NodalVector::Director, normal, None);
                }
                Condition::Fix(fix) => {
                    for a in &fix.position {
                        add(node, NodalVector::Position, axes[a.index()], None);
                    }
                    for a in &fix.director {
                        add(node, NodalVector::Director, axes[a.index()], None);
                    }
                }
                Condition::Prescribe(p) => {
                    let amplitude = p.amplitude.as_ref().and_then(|a| amplitudes.get(a).copied());
                    add(node, p.of, axes[p.component.index()], Some((p.value, amplitude)));
                }
            }
        }
    }
    out
}

fn follower_loads(
    model: &Model,
    mesh: &Mesh,
    vectors: &Vectors,
    amplitudes: &BTreeMap<String, usize>,
) -> Vec<FollowerLoad> {
    let mut out = Vec::new();
    let find = |a: &Option<String>| a.as_ref().and_then(|a| amplitudes.get(a).copied());
    for load in &model.loads {
        match load {
            Load::Moment(l) => {
                for node in mesh.nodes_on(&l.on).unwrap_or_default() {
                    let vector = vectors.director_of[node as usize];
                    out.push(FollowerLoad::Moment {
                        vector,
                        moment: Vec3::from(l.value),
                        amplitude: find(&l.amplitude),
                    });
                }
            }
            Load::EdgeMoment(l) => {
                for (node, length) in tributary_lengths(mesh, &l.on) {
                    out.push(FollowerLoad::Moment {
                        vector: vectors.director_of[node as usize],
                        moment: Vec3::from(l.value) * length,
                        amplitude: find(&l.amplitude),
                    });
                }
            }
            Load::Pressure(l) => {
                for q in mesh.quads_on(&l.on).unwrap_or_default() {
                    out.push(FollowerLoad::Pressure {
                        vectors: mesh.quads[q as usize].map(|n| vectors.position_of[n as usize]),
                        pressure: l.value,
                        amplitude: find(&l.amplitude),
                    });
                }
            }
            Load::Force(_) | Load::Edge(_) | Load::Traction(_) | Load::Gravity(_) => {}
        }
    }
    out
}

/// Moments along a director: nothing of the shell resists there, so that part would be lost.
fn lost_moments(loads: &[FollowerLoad], vectors: &Vectors) -> Vec<Issue> {
    let lost = |load: &FollowerLoad| match load {
        FollowerLoad::Moment { vector, moment, .. } => {
            let d = Vec3::from(vectors.reference[*vector as usize]);
            let along = moment.dot(&d).abs();
            (along > 1e-3 * moment.norm()).then(|| (vectors.nodes[*vector as usize], along, moment.norm()))
        }
        FollowerLoad::Pressure { .. } => None,
    };
    let all: Vec<_> = loads.iter().filter_map(lost).collect();
    let Some((node, along, whole)) = all.first() else { return Vec::new() };
    vec![Issue::new(
        "loads",
        format!(
            "{} moment(s) have a part along the director, the first at node {node}: {along:.3e} of {whole:.3e} would be lost",
            all.len()
        ),
        "a shell node does not resist turning about its director; use a pair of forces for that part",
    )]
}

fn dead_loads(
    model: &Model,
    mesh: &Mesh,
    system: &System,
    amplitudes: &BTreeMap<String, usize>,
) -> Vec<DeadLoad> {
    let n = system.vectors();
    let mut out = Vec::new();
    for load in &model.loads {
        let mut force = vec![[0.0; 3]; n];
        let mut add = |node: u32, f: Vec3| {
            let v = system.position_of[node as usize] as usize;
            for i in 0..3 {
                force[v][i] += f[i];
            }
        };
        let (amplitude, gravity) = match load {
            Load::Force(l) => {
                for node in mesh.nodes_on(&l.on).unwrap_or_default() {
                    add(node, Vec3::from(l.value));
                }
                (&l.amplitude, false)
            }
            Load::Edge(l) => {
                for (node, length) in tributary_lengths(mesh, &l.on) {
                    add(node, Vec3::from(l.value) * length);
                }
                (&l.amplitude, false)
            }
            Load::Traction(l) => {
                for (node, area) in tributary_areas(mesh, &l.on) {
                    add(node, Vec3::from(l.value) * area);
                }
                (&l.amplitude, false)
            }
            Load::Gravity(l) => {
                let mut field = vec![[0.0; 3]; n];
                for (v, kind) in system.kinds.iter().enumerate() {
                    if *kind == VectorKind::Position {
                        field[v] = l.value;
                    }
                }
                system.pattern.add_mass_product(1.0, &field, &mut force);
                // Gravity acts on masses; a director carries weight only where the section is not symmetric.
                (&l.amplitude, true)
            }
            Load::Moment(_) | Load::EdgeMoment(_) | Load::Pressure(_) => continue,
        };
        let amplitude = amplitude.as_ref().and_then(|a| amplitudes.get(a).copied());
        out.push(DeadLoad { force, amplitude, gravity });
    }
    out
}

fn added_masses(model: &Model, mesh: &Mesh, vectors: &Vectors) -> Vec<(u32, u32, f64)> {
    let mut out = Vec::new();
    for mass in &model.masses {
        match mass {
            AddedMass::Point(m) => {
                for node in mesh.nodes_on(&m.on).unwrap_or_default() {
                    let v = vectors.position_of[node as usize];
                    out.push((v, v, m.value));
                }
            }
            AddedMass::Edge(m) => {
                for [a, b] in mesh.edges_on(&m.on).unwrap_or_default() {
                    let length = (mesh.positions[a as usize] - mesh.positions[b as usize]).norm();
                    let (a, b) = (vectors.position_of[a as usize], vectors.position_of[b as usize]);
                    let third = m.value * length / 3.0;
                    out.extend([(a, a, third), (b, b, third), (a, b, 0.5 * third)]);
                }
            }
            AddedMass::Area(m) => {
                for q in mesh.quads_on(&m.on).unwrap_or_default() {
                    let nodes = mesh.quads[q as usize];
                    let geometry = ShellGeometry {
                        positions: nodes.map(|n| mesh.positions[n as usize]),
                        directors: [Vec3::z(); 4],
                    };
                    let inertia = SectionInertia { mass: m.value, rotary: 0.0 };
                    let matrix = EmsShell::default().mass(&geometry, &inertia);
                    for a in 0..4 {
                        for b in 0..=a {
                            let (va, vb) = (
                                vectors.position_of[nodes[a] as usize],
                                vectors.position_of[nodes[b] as usize],
                            );
                            out.push((va, vb, matrix[pair(a, b)]));
                        }
                    }
                }
            }
        }
    }
    out
}

fn initial_velocity(model: &Model, mesh: &Mesh, vectors: &Vectors) -> Vec<Nodal> {
    let mut out = vec![[0.0; 3]; vectors.reference.len()];
    let directors = vectors.directors_by_node();
    for initial in &model.initial_velocities {
        let (v, omega) = (Vec3::from(initial.velocity), Vec3::from(initial.angular_velocity));
        let center = Vec3::from(initial.center);
        for node in mesh.nodes_on(&initial.on).unwrap_or_default() {
            let p = vectors.position_of[node as usize];
            if p != u32::MAX {
                let x = mesh.positions[node as usize];
                out[p as usize] = (v + omega.cross(&(x - center))).into();
            }
            for &d in directors.get(&node).map_or(&[][..], Vec::as_slice) {
                out[d as usize] = omega.cross(&Vec3::from(vectors.reference[d as usize])).into();
            }
        }
    }
    out
}

/// Length of an edge set that each of its nodes stands for (consistent with linear edges).
fn tributary_lengths(mesh: &Mesh, on: &str) -> BTreeMap<u32, f64> {
    let mut out = BTreeMap::new();
    for [a, b] in mesh.edges_on(on).unwrap_or_default() {
        let half = 0.5 * (mesh.positions[a as usize] - mesh.positions[b as usize]).norm();
        *out.entry(a).or_default() += half;
        *out.entry(b).or_default() += half;
    }
    out
}

/// Area ∫N_a dA that each node of a quad set stands for.
fn tributary_areas(mesh: &Mesh, on: &str) -> BTreeMap<u32, f64> {
    let mut out = BTreeMap::new();
    for q in mesh.quads_on(on).unwrap_or_default() {
        let nodes = mesh.quads[q as usize];
        let geometry =
            ShellGeometry { positions: nodes.map(|n| mesh.positions[n as usize]), directors: [Vec3::z(); 4] };
        let matrix = EmsShell::default().mass(&geometry, &SectionInertia { mass: 1.0, rotary: 0.0 });
        for a in 0..4 {
            *out.entry(nodes[a]).or_default() += (0..4).map(|b| matrix[pair(a, b)]).sum::<f64>();
        }
    }
    out
}
