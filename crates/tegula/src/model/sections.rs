//! From the sections of the model to its elements.

use std::collections::{BTreeMap, BTreeSet};

use super::build::Vectors;
use super::{Material, Model, Section};
use crate::element::constitution::LinearConstitution;
use crate::element::quadratic::Members;
use crate::element::shell::{GroupSetup, Member, ShellElement};
use crate::element::{ElementGroup, QuadraticGroup, ShellGeometry, fold_tie, registry};
use crate::mesh::Mesh;
use crate::mesh::directors::Directors;
use crate::section::compiled::{Layer, Resultant};
use crate::section::{CompiledSection, SectionInertia, SectionStiffness};
use crate::system::{Shell, ShellSection, VectorKind};
use crate::{Issue, Vec3};

impl Section {
    /// The section with its materials.
    ///
    /// # Errors
    /// A material is missing.
    pub fn compile(&self, materials: &BTreeMap<String, Material>) -> Option<CompiledSection> {
        let material = materials.get(&self.material)?;
        let h = self.thickness;
        let points = usize::from(self.thickness_points.unwrap_or(if material.is_linear() { 2 } else { 5 }));
        let layers = vec![Layer::new(
            &self.material,
            material,
            [-0.5 * h, 0.5 * h],
            0.0,
            points,
            !material.is_linear(),
        )];
        let Material::Isotropic(m) = material;
        let shear = self.shear_correction.unwrap_or([5.0 / 6.0; 2]);
        Some(CompiledSection {
            thickness: h,
            layers,
            laws: Vec::new(),
            inertia: SectionInertia::homogeneous(m.density, h),
            direction: Vec3::x(),
            resultant: Resultant::Isotropic(SectionStiffness::homogeneous(m, h, shear)),
            shear_factors: self.shear_correction.unwrap_or([1.0; 2]),
            isotropic: true,
        })
    }
}

/// The elements of a model.
#[derive(Default)]
pub(super) struct Elements {
    pub(super) groups: Vec<Box<dyn ElementGroup>>,
    pub(super) list: Vec<Shell>,
    pub(super) sections: Vec<ShellSection>,
    /// Nodal vectors that keep their length.
    pub(super) unit: BTreeSet<u32>,
    /// h E A at the directors, for ties.
    director_stiffness: BTreeMap<u32, f64>,
}

impl Elements {
    /// Which directors have gradients beside them.
    pub(super) fn gradients(model: &Model, mesh: &Mesh, directors: &Directors) -> Vec<bool> {
        let mut out = vec![false; directors.values.len()];
        for section in &model.sections {
            let element = registry::shell(section, section.thickness);
            if element.nodal_vectors().contains(&VectorKind::Gradient) {
                for q in mesh.quads_on(&section.on).unwrap_or_default() {
                    for d in directors.corners[q as usize] {
                        out[d as usize] = true;
                    }
                }
            }
        }
        out
    }

    pub(super) fn shells(
        &mut self,
        model: &Model,
        mesh: &Mesh,
        directors: &Directors,
        vectors: &Vectors,
        issues: &mut Vec<Issue>,
    ) {
        for section in &model.sections {
            let (Some(compiled), Some(quads)) =
                (section.compile(&model.materials), mesh.quads_on(&section.on))
            else {
                continue;
            };
            let element = registry::shell(section, compiled.thickness);
            self.section(model, section, compiled, element, &quads, (mesh, directors, vectors), issues);
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn section(
        &mut self,
        model: &Model,
        section: &Section,
        mut compiled: CompiledSection,
        element: Box<dyn ShellElement>,
        quads: &[u32],
        (mesh, directors, vectors): (&Mesh, &Directors, &Vectors),
        issues: &mut Vec<Issue>,
    ) {
        let geometry = |q: u32| {
            ShellGeometry::new(
                mesh.quads[q as usize].map(|n| mesh.positions[n as usize]),
                directors.corners[q as usize].map(|d| directors.values[d as usize]),
            )
        };
        let area =
            |g: &ShellGeometry| crate::element::geometry::nodal_areas(&g.positions).iter().sum::<f64>();
        if let Some(total) = section.total_mass {
            let whole: f64 = quads.iter().map(|&q| area(&geometry(q))).sum();
            if compiled.inertia.mass == 0.0 {
                compiled.inertia = SectionInertia::homogeneous(1.0, compiled.thickness);
            }
            compiled.inertia = compiled.inertia.scaled(total / (whole * compiled.inertia.mass));
        }
        let fields: Vec<BTreeSet<u32>> = model
            .prescribed_strains
            .iter()
            .map(|p| mesh.quads_on(p.on()).unwrap_or_default().into_iter().collect())
            .collect();
        let acts = fields.iter().any(|f| quads.iter().any(|q| f.contains(q)));
        let mut builder = element.builder(GroupSetup {
            retardation_time: section.retardation_time + model.damping.stiffness,
            laws: compiled.laws.clone(),
            fields: if acts { fields.len() } else { 0 },
        });
        let first_group = self.groups.len();
        let stretch = compiled.resultant.at(0.0).thickness;
        let mut members = 0;
        for &q in quads {
            let g = geometry(q);
            let corners = directors.corners[q as usize];
            let mut connectivity: Vec<u32> =
                mesh.quads[q as usize].iter().map(|&n| vectors.position_of[n as usize]).collect();
            connectivity.extend(corners.map(|d| vectors.of_director[d as usize]));
            if element.nodal_vectors().contains(&VectorKind::Gradient) {
                for second in 0..2 {
                    connectivity.extend(corners.map(|d| vectors.gradient_of[d as usize] + second));
                }
            }
            let prescribed: Vec<_> = if acts {
                model
                    .prescribed_strains
                    .iter()
                    .zip(&fields)
                    .map(|(p, f)| f.contains(&q).then_some(p))
                    .collect()
            } else {
                Vec::new()
            };
            let result = compiled.stations(element.as_ref(), &g, &prescribed).and_then(|stations| {
                let mass = element.mass(&g, &compiled.inertia);
                builder.push(Member { vectors: &connectivity, geometry: &g, stations, mass })
            });
            if let Err(reason) = result {
                let c = g.centre();
                issues.push(Issue::new(
                    "mesh",
                    format!(
                        "element {} at ({:.4}, {:.4}, {:.4}) is invalid: {reason}",
                        mesh.quad_label(q as usize),
                        c.x,
                        c.y,
                        c.z
                    ),
                    "repair the mesh there",
                ));
                continue;
            }
            for (d, area) in corners.into_iter().zip(crate::element::geometry::nodal_areas(&g.positions)) {
                let v = vectors.of_director[d as usize];
                *self.director_stiffness.entry(v).or_default() += stretch * area;
                if element.unit_directors() {
                    self.unit.insert(v);
                }
            }
            self.list.push(Shell {
                quad: q,
                groups: first_group..first_group,
                member: members,
                geometry: g,
                section: self.sections.len(),
                prescribed: if acts { fields.iter().map(|f| f.contains(&q)).collect() } else { Vec::new() },
            });
            members += 1;
        }
        self.groups.extend(builder.finish());
        let last_group = self.groups.len();
        let new = self.list.len() - members;
        for shell in &mut self.list[new..] {
            shell.groups = first_group..last_group;
        }
        self.sections.push(ShellSection { section: compiled, element });
    }

    pub(super) fn ties(&mut self, directors: &Directors, vectors: &Vectors) {
        if directors.ties.is_empty() {
            return;
        }
        let mut members = Members::<2>::default();
        let mut constitution = LinearConstitution::<1>::default();
        for pair in &directors.ties {
            let v = pair.map(|d| vectors.of_director[d as usize]);
            let stiffness =
                v.iter().filter_map(|v| self.director_stiffness.get(v)).fold(f64::INFINITY, |a, &b| a.min(b));
            if stiffness.is_finite() {
                members.vectors.push(v);
                members.mass.extend([0.0; 3]);
                constitution.h.push(stiffness);
            }
        }
        self.groups.push(Box::new(QuadraticGroup::<2, 6, 1, 2, _>::new(
            "fold-tie",
            fold_tie::strains(),
            members,
            constitution,
            0.0,
        )));
    }
}
