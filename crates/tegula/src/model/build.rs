//! From the model and its mesh to the compiled [`System`].

use std::collections::BTreeMap;

use super::actions::{added_masses, dead_loads, follower_loads, initial_velocity, lost_moments, supports};
use super::{Analysis, Model};
use super::{check, mechanism};
use crate::element::ems::{self, EmsShell, ShellGeometry};
use crate::element::{ElementGroup, Nodal, QuadraticGroup, fold_tie};
use crate::load::TimeFunction;
use crate::mesh::directors::{Directors, FOLD_ANGLE_DEGREES};
use crate::mesh::{Mesh, quality};
use crate::section::{SectionInertia, SectionStiffness};
use crate::system::numbering::{Numbering, VectorKind};
use crate::system::pattern::PatternBuilder;
use crate::system::{IndexMap, Shell, ShellSection, System};
use crate::{Error, Issue, Result, Vec3};

/// Nodal vectors of a mesh: position of each node, then its directors, node by node.
pub(super) struct Vectors {
    pub(super) reference: Vec<Nodal>,
    pub(super) kinds: Vec<VectorKind>,
    pub(super) nodes: Vec<u32>,
    pub(super) position_of: Vec<u32>,
    pub(super) director_of: Vec<u32>,
    /// Nodal vector of each director.
    pub(super) of_director: Vec<u32>,
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
    pub(super) fn directors_by_node(&self) -> BTreeMap<u32, Vec<u32>> {
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
        issues.extend(mechanism::mechanisms(
            mesh,
            &vectors.reference,
            &vectors.kinds,
            &vectors.nodes,
            &supports,
        ));
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
            let unit = self.element.mass(geometry, &SectionInertia { mass: 1.0, coupling: 0.0, rotary: 0.0 });
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
pub(super) fn pair(a: usize, b: usize) -> usize {
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
