//! From the sections of the model to its elements.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::Vectors;
use super::congruence::{Congruence, Match};
use super::factors::means;
use crate::element::generalized_law::LinearLaw;
use crate::element::geometry::cross_section_frame;
use crate::element::quadratic::Members;
use crate::element::shell::{GroupSetup, Member, ShellElement};
use crate::element::{ElementGroup, QuadraticGroup, ShellGeometry, director_angle, registry};
use crate::material::{Law, OwnLaw};
use crate::mesh::Mesh;
use crate::mesh::directors::Directors;
use crate::model::{Material, Membrane, Model, PrescribedStrain, Section, StackedPly, acting_strains};
use crate::section::compiled::{Layer, Resultant};
use crate::section::laminate::Laminate;
use crate::section::ply::Ply;
use crate::section::{CompiledSection, SectionInertia, SectionStiffness};
use crate::system::{Shell, ShellSection, VectorKind};
use crate::{Issue, Vec3};

impl Section {
    /// Its plies from the bottom to the top; none if the layup is wrong, which `check` reports.
    fn plies(&self) -> Vec<StackedPly> {
        match self.layers() {
            None => {
                vec![StackedPly { material: self.material.clone(), angle: 0.0, thickness: self.thickness }]
            }
            Some((_, layers)) => layers.plies("").unwrap_or_default(),
        }
    }

    /// Thickness of all layers together (length).
    pub fn whole_thickness(&self) -> f64 {
        self.plies().iter().map(|p| p.thickness).sum()
    }

    /// Names of its materials.
    pub fn materials(&self) -> Vec<String> {
        let names: BTreeSet<String> = self.plies().into_iter().map(|p| p.material).collect();
        names.into_iter().collect()
    }

    /// The section with its materials; `None` if one is missing, which `check` reports.
    pub fn compile(&self, materials: &BTreeMap<String, Material>) -> Option<CompiledSection> {
        self.compile_with(materials, &BTreeMap::new(), 1.0)
    }

    /// The section with its materials, some of which have laws of the caller, and with a factor on the thickness of all layers.
    pub(super) fn compile_with(
        &self,
        materials: &BTreeMap<String, Material>,
        laws_of_caller: &BTreeMap<String, OwnLaw>,
        factor: f64,
    ) -> Option<CompiledSection> {
        let thickness = self.whole_thickness() * factor;
        let described = self.layers().map(|(_, layers)| layers);
        let Stack { layers, plies, laws } = self.stack(materials, laws_of_caller, (thickness, factor))?;
        let (resultant, inertia) = self.resultant(&layers, plies, thickness)?;
        Some(CompiledSection {
            thickness,
            offset: self.offset(),
            inertia,
            isotropic: self.is_equally_corrected() && layers.iter().all(|l| l.material.is_isotropic()),
            layers,
            laws,
            direction: described.map_or(Vec3::x(), |layers| Vec3::from(layers.direction())),
            resultant,
            shear_factors: self.shear_correction.unwrap_or([1.0; 2]),
            shear_stabilization: self.shear_stabilization,
        })
    }

    /// Layers of the section from the bottom to the top, each a factor times as thick, with the laws of their materials; `None` if one is missing.
    fn stack(
        &self,
        materials: &BTreeMap<String, Material>,
        laws_of_caller: &BTreeMap<String, OwnLaw>,
        (thickness, factor): (f64, f64),
    ) -> Option<Stack> {
        let is_solid = registry::shell(self, thickness).is_solid();
        let mut stack = Stack { layers: Vec::new(), plies: Vec::new(), laws: Vec::new() };
        let mut bottom = self.offset() - 0.5 * thickness;
        for mut ply in self.plies() {
            ply.thickness *= factor;
            let material = materials.get(&ply.material)?;
            let plastic = material.yields();
            let points = usize::from(self.thickness_points.unwrap_or(if plastic { 5 } else { 2 }));
            let heights = [bottom, bottom + ply.thickness];
            bottom = heights[1];
            let angle = ply.angle.to_radians();
            let mut layer = Layer::new(&ply.material, material, heights, angle, points, plastic);
            if !material.is_linear() {
                let law = match laws_of_caller.get(&ply.material) {
                    Some(own) if is_solid => Law::Own(own.clone()),
                    _ if is_solid => material.law_3d(),
                    _ => material.law_plane_stress()?,
                };
                let known = stack.laws.iter().position(|l| *l == law);
                layer.law = Some(known.unwrap_or(stack.laws.len()));
                if known.is_none() {
                    stack.laws.push(law);
                }
            }
            if let Some((plane_stress, shear, thickness_modulus)) = material.plane_stress() {
                let density = material.density();
                stack.plies.push(Ply {
                    thickness: ply.thickness,
                    angle,
                    plane_stress,
                    shear,
                    thickness_modulus,
                    density,
                });
            }
            stack.layers.push(layer);
        }
        Some(stack)
    }

    /// Stiffness of the stress resultants, and the inertia, of the layers; `None` where the layup is wrong.
    fn resultant(
        &self,
        layers: &[Layer],
        plies: Vec<Ply>,
        thickness: f64,
    ) -> Option<(Resultant, SectionInertia)> {
        let single = match layers {
            [layer] if self.layers().is_none() => Some(&layer.material),
            _ => None,
        };
        let stretch = layers.iter().map(|l| l.moments()[0] * modulus(&l.material)).sum();
        let mut inertia = match single {
            Some(m) => SectionInertia::homogeneous(m.density(), thickness),
            None => SectionInertia { mass: 0.0, rotary: 0.0, coupling: 0.0 },
        };
        let resultant = if let (Some(Material::Isotropic(m)), true) = (single, self.is_equally_corrected()) {
            let factors = self.shear_correction.unwrap_or([5.0 / 6.0; 2]);
            Resultant::Isotropic(SectionStiffness::homogeneous(m, thickness, factors))
        } else if plies.len() == layers.len() {
            let mut laminate = Laminate::new(plies).and_then(|l| l.with_offset(self.offset())).ok()?;
            if let Some(factors) = self.shear_correction {
                laminate = laminate.with_shear_correction(factors).ok()?;
            }
            if single.is_none() {
                inertia = laminate.inertia();
            }
            Resultant::Laminate(laminate)
        } else {
            Resultant::None(stretch)
        };
        if matches!(resultant, Resultant::None(_)) && single.is_none() {
            for layer in layers {
                let [z0, z1, z2] = layer.moments().map(|m| m * layer.material.density());
                inertia.mass += z0;
                inertia.coupling += z1;
                inertia.rotary += z2;
            }
        }
        Some((resultant, inertia))
    }

    /// Whether the shear correction is equal in both directions.
    fn is_equally_corrected(&self) -> bool {
        self.shear_correction.is_none_or(|[x, y]| x == y)
    }
}

/// Layers of a section, and the plies of the linear ones.
struct Stack {
    layers: Vec<Layer>,
    plies: Vec<Ply>,
    /// Nonlinear laws, each once.
    laws: Vec<Law>,
}

/// Young's modulus across the thickness, for estimates.
fn modulus(material: &Material) -> f64 {
    match material.plane_stress() {
        Some((_, _, e)) => e,
        None => material.law_3d().respond(&Default::default(), &[], &mut []).map_or(0.0, |r| {
            let shear = r.tangent[(2, 2)];
            let bulk = r.tangent[(0, 0)] - 4.0 / 3.0 * shear;
            9.0 * bulk * shear / (3.0 * bulk + shear)
        }),
    }
}

fn geometry(quad: u32, mesh: &Mesh, directors: &Directors) -> ShellGeometry {
    ShellGeometry::new(
        mesh.quads[quad as usize].map(|n| mesh.positions[n as usize]),
        directors.corners[quad as usize].map(|d| directors.values[d as usize]),
    )
}

/// Numbers of the nodal vectors of an element: positions, directors, and gradients where it has some.
fn connectivity(
    element: &dyn ShellElement,
    nodes: [u32; 4],
    corners: [u32; 4],
    vectors: &Vectors,
) -> Vec<u32> {
    let mut out = nodes.map(|n| vectors.coordinates.position_of[n as usize]).to_vec();
    out.extend(corners.map(|d| vectors.of_director[d as usize]));
    if element.nodal_vectors().contains(&VectorKind::Gradient) {
        for second in 0..2 {
            out.extend(corners.map(|d| vectors.gradient_of[d as usize] + second));
        }
    }
    out
}

/// Unit vectors along the directions from which a section and the prescribed strains count angles.
fn directions<'a>(
    section: &CompiledSection,
    prescribed: impl Iterator<Item = &'a PrescribedStrain>,
) -> Vec<Vec3> {
    let own = (!section.isotropic).then_some(section.direction);
    let of_strains = prescribed.filter_map(|p| p.direction()).map(Vec3::from);
    own.into_iter().chain(of_strains).map(|d| d.normalize()).collect()
}

fn invalid(element: u64, centre: &Vec3, reason: &str) -> Issue {
    let [x, y, z] = [centre.x, centre.y, centre.z];
    let what = format!("element {element} at ({x:.4}, {y:.4}, {z:.4}) is invalid: {reason}");
    Issue::new("mesh", what, "repair the mesh there")
}

/// Area over which an element has its mass: that of the middle surface of its layers.
fn area_of_mass(element: &dyn ShellElement, g: &ShellGeometry) -> f64 {
    let mass = element.mass(g, &SectionInertia { mass: 1.0, rotary: 0.0, coupling: 0.0 });
    let pairs = (0..4).flat_map(|a| (0..=a).map(move |b| (a, b)));
    pairs.zip(mass).map(|((a, b), m)| if a == b { m } else { 2.0 * m }).sum()
}

/// Directions that are normal to the surface somewhere in a section: that of its 0° and those of prescribed strains.
fn useless_directions(
    model: &Model,
    section: usize,
    compiled: &CompiledSection,
    quads: &[u32],
    (mesh, directors): (&Mesh, &Directors),
) -> Vec<Issue> {
    let useless = |direction: Vec3, on: &dyn Fn(&u32) -> bool| {
        let is_normal = |q: &&u32| {
            cross_section_frame(&geometry(**q, mesh, directors).base(0.0, 0.0, 0.0))
                .is_some_and(|frame| CompiledSection::angle(&frame, &direction).is_err())
        };
        let found: Vec<&u32> = quads.iter().filter(|q| on(q)).filter(is_normal).collect();
        let c = geometry(**found.first()?, mesh, directors).centre();
        Some(format!(
            "the direction ({}, {}, {}) is normal to the surface in {} element(s), such as element {} at ({:.4}, \
             {:.4}, {:.4}): it has no projection there to count angles from",
            direction.x,
            direction.y,
            direction.z,
            found.len(),
            mesh.quad_label(*found[0] as usize),
            c.x,
            c.y,
            c.z
        ))
    };
    let mut out = Vec::new();
    if compiled.is_directed()
        && let Some(message) = useless(compiled.direction, &|_| true)
    {
        let (key, help) = if let Some((key, _)) = model.sections[section].layers() {
            (format!("{key}.direction"), "give a direction that lies along the surface")
        } else {
            ("material".to_owned(), "give the direction of the material's first axis in a `layup` of one ply")
        };
        out.push(Issue::new(format!("sections[{section}].{key}"), message, help));
    }
    for (i, p) in model.prescribed_strains.iter().enumerate() {
        let Some(direction) = p.direction() else { continue };
        let on: BTreeSet<u32> = mesh.quads_on(p.on()).unwrap_or_default().into_iter().collect();
        if let Some(message) = useless(direction.into(), &|q| on.contains(q)) {
            let help = "give a direction that lies along the surface";
            out.push(Issue::new(format!("prescribed_strains[{i}].direction"), message, help));
        }
    }
    out
}

/// Factors of a prescribed strain on the elements of its set.
fn factors(strain: &PrescribedStrain, mesh: &Mesh) -> BTreeMap<u32, f64> {
    let quads = mesh.quads_on(strain.on()).unwrap_or_default();
    let factors = means(strain.distribution(), mesh, &quads);
    quads.into_iter().zip(factors).collect()
}

/// A section of the model in all thicknesses that its elements have.
#[derive(Default)]
struct Thicknesses {
    sections: Vec<ShellSection>,
    /// Index by the bits of the factor on the thickness.
    known: HashMap<u64, usize>,
    /// Index for each element.
    of_quad: Vec<usize>,
}

impl Thicknesses {
    /// Adds an element with a factor on its thickness; false if the section cannot be compiled.
    fn add(&mut self, factor: f64, compile: impl Fn(f64) -> Option<ShellSection>) -> bool {
        let new = self.sections.len();
        let index = *self.known.entry(factor.to_bits()).or_insert(new);
        if index == new {
            let Some(section) = compile(factor) else { return false };
            self.sections.push(section);
        }
        self.of_quad.push(index);
        true
    }

    /// Scales the inertia so that all elements together have the mass `total`. Without densities it is that of a homogeneous shell.
    fn set_mass(&mut self, total: f64, elements: impl Iterator<Item = ShellGeometry>) {
        for ShellSection { section, .. } in &mut self.sections {
            if section.inertia.mass == 0.0 {
                section.inertia = SectionInertia::homogeneous(1.0, section.thickness);
            }
        }
        let mass = |(g, index): (ShellGeometry, &usize)| {
            let of = &self.sections[*index];
            area_of_mass(of.element.as_ref(), &g) * of.section.inertia.mass
        };
        let present: f64 = elements.zip(&self.of_quad).map(mass).sum();
        for ShellSection { section, .. } in &mut self.sections {
            section.inertia = section.inertia.scaled(total / present);
        }
    }
}

/// The elements of a model.
#[derive(Default)]
pub(super) struct Elements {
    pub(super) groups: Vec<Box<dyn ElementGroup>>,
    pub(super) list: Vec<Shell>,
    pub(super) sections: Vec<ShellSection>,
    /// Inextensible directors.
    pub(super) unit: BTreeSet<u32>,
    /// The sheet of each director, for director-angle constraints; empty where there are none.
    sheets: Vec<Sheet>,
}

/// The elements around a director.
#[derive(Debug, Clone, Copy, Default)]
struct Sheet {
    /// Largest bending stiffness of their sections (force × length).
    bending: f64,
    /// The director's share of their area (length²).
    area: f64,
}

impl Elements {
    /// Flags, by director: whether its node also has gradients of `ancf-full`.
    pub(super) fn gradients(model: &Model, mesh: &Mesh, directors: &Directors) -> Vec<bool> {
        let mut out = vec![false; directors.values.len()];
        for section in &model.sections {
            let element = registry::shell(section, section.whole_thickness());
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
        laws: &BTreeMap<String, OwnLaw>,
        issues: &mut Vec<Issue>,
    ) {
        if !directors.ties.is_empty() {
            self.sheets = vec![Sheet::default(); directors.values.len()];
        }
        let fields: Vec<_> = model.prescribed_strains.iter().map(|p| factors(p, mesh)).collect();
        for (i, section) in model.sections.iter().enumerate() {
            let (Some(compiled), Some(quads)) =
                (section.compile_with(&model.materials, laws, 1.0), mesh.quads_on(&section.on))
            else {
                continue;
            };
            let useless = useless_directions(model, i, &compiled, &quads, (mesh, directors));
            if !useless.is_empty() {
                issues.extend(useless);
                continue;
            }
            let mut section = section.clone();
            if section.membrane.is_none() && section.eas && compiled.has_rubber() {
                section.membrane = Some(Membrane::AssumedShear);
            }
            let factors = means(section.thickness_distribution.as_ref(), mesh, &quads);
            let mut thicknesses = Thicknesses::default();
            let compile = |factor| {
                let compiled = section.compile_with(&model.materials, laws, factor)?;
                let element = registry::shell_of(&section, compiled.thickness, compiled.has_rubber());
                Some(ShellSection { section: compiled, element, of_model: i })
            };
            if !factors.iter().all(|factor| thicknesses.add(*factor, compile)) {
                continue;
            }
            let of_model = (model, &fields[..]);
            self.section(of_model, &section, thicknesses, &quads, (mesh, directors, vectors), issues);
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn section(
        &mut self,
        (model, fields): (&Model, &[BTreeMap<u32, f64>]),
        section: &Section,
        mut thicknesses: Thicknesses,
        quads: &[u32],
        (mesh, directors, vectors): (&Mesh, &Directors, &Vectors),
        issues: &mut Vec<Issue>,
    ) {
        if let Some(total) = section.total_mass {
            thicknesses.set_mass(total, quads.iter().map(|&q| geometry(q, mesh, directors)));
        }
        let Thicknesses { sections, of_quad, .. } = thicknesses;
        let Some(ShellSection { section: compiled, element, .. }) = sections.first() else { return };
        let first_section = self.sections.len();
        let acts = fields.iter().any(|f| quads.iter().any(|q| f.contains_key(q)));
        let fields = if acts { fields } else { &[] };
        let mut builder = element.builder(GroupSetup {
            retardation_time: section.retardation_time + model.damping.stiffness,
            laws: compiled.laws.clone(),
            fields: fields.len(),
            reference_kernel: false,
        });
        let first_group = self.groups.len();
        let mut members = 0;
        // The tangents of gradients depend on the global axes, so rotated elements are not congruent.
        let turns = !element.nodal_vectors().contains(&VectorKind::Gradient);
        let mut shapes = (turns && compiled.is_linear()).then(Congruence::default);
        let directions = directions(compiled, model.prescribed_strains.iter().filter(|_| acts));
        for (&q, &thickness) in quads.iter().zip(&of_quad) {
            let ShellSection { section: compiled, element, .. } = &sections[thickness];
            let g = geometry(q, mesh, directors);
            let corners = directors.corners[q as usize];
            let connectivity = connectivity(element.as_ref(), mesh.quads[q as usize], corners, vectors);
            let mut acting: Vec<f64> =
                fields.iter().map(|field| field.get(&q).copied().unwrap_or(0.0)).collect();
            let prescribed = acting_strains(model.prescribed_strains.iter(), &acting);
            let prescribed: Vec<_> = prescribed.iter().map(Option::as_deref).collect();
            acting.push(compiled.thickness);
            let found = shapes.as_ref().map_or(Match::Alone, |s| s.look_up(&g, &directions, &acting));
            acting.pop();
            let shape = if let Match::Like(first) = found { first } else { members };
            let shared = shape != members && builder.push_like(shape, &connectivity, &g);
            let result = if shared {
                Ok(())
            } else {
                let points = compiled.integration_points(element.as_ref(), &g, &prescribed);
                let mass = element.mass(&g, &compiled.inertia);
                points.and_then(|integration_points| {
                    builder.push(Member { vectors: &connectivity, geometry: &g, integration_points, mass })
                })
            };
            if let Err(reason) = result {
                issues.push(invalid(mesh.quad_label(q as usize), &g.centre(), &reason));
                continue;
            }
            // Only now has the element its number.
            if let (Some(shapes), Match::New(new)) = (&mut shapes, found) {
                shapes.register(new, members);
            }
            self.note_sheets(corners, &g, compiled);
            if element.unit_directors() {
                self.unit.extend(corners.map(|d| vectors.of_director[d as usize]));
            }
            self.list.push(Shell {
                quad: q,
                groups: first_group..first_group,
                member: members,
                section: first_section + thickness,
                shape,
                prescribed: acting,
            });
            members += 1;
        }
        self.groups.extend(builder.finish());
        let groups = first_group..self.groups.len();
        let new = self.list.len() - members;
        self.list[new..].iter_mut().for_each(|shell| shell.groups = groups.clone());
        self.sections.extend(sections);
    }

    /// Adds an element to the sheets of its directors.
    fn note_sheets(&mut self, corners: [u32; 4], g: &ShellGeometry, section: &CompiledSection) {
        for (d, area) in corners.into_iter().zip(crate::element::geometry::nodal_areas(&g.positions)) {
            if let Some(sheet) = self.sheets.get_mut(d as usize) {
                sheet.bending = sheet.bending.max(section.bending());
                sheet.area += area;
            }
        }
    }

    /// Adds the director-angle constraints of folds and junctions, `stiffness` times as stiff as one row of elements
    /// beside them.
    pub(super) fn ties(&mut self, directors: &Directors, vectors: &Vectors, stiffness: f64) {
        if directors.ties.is_empty() {
            return;
        }
        let mut members = Members::<2>::default();
        let mut constitution = LinearLaw::<3>::default();
        for at_node in directors.ties.chunk_by(|a, b| directors.node_of(a) == directors.node_of(b)) {
            let shares = at_node.iter().flat_map(|tie| {
                tie.directors.map(|d| {
                    let sheet = self.sheets[d as usize];
                    // Sheets that touch at a node only have no length in common.
                    let ratio = if tie.length > 0.0 { tie.length * tie.length / sheet.area } else { 1.0 };
                    if sheet.area > 0.0 { sheet.bending * ratio } else { 0.0 }
                })
            });
            let largest = shares.fold(0.0, crate::norm::larger);
            for tie in
                at_node.iter().filter(|tie| tie.directors.iter().all(|&d| self.sheets[d as usize].area > 0.0))
            {
                let [a, b] = tie.directors.map(|d| &directors.values[d as usize]);
                members.vectors.push(tie.directors.map(|d| vectors.of_director[d as usize]));
                members.mass.extend([0.0; 3]);
                constitution.h.extend(director_angle::stiffness([a, b], stiffness * largest));
            }
        }
        self.groups.push(Box::new(QuadraticGroup::<2, 6, 3, 2, _>::new(
            "fold-tie",
            director_angle::strains(),
            members,
            constitution,
            0.0,
        )));
    }
}
