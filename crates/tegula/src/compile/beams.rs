//! Beams: their nodes are rigid cross-sections, which take part in a model as rigid bodies.

use crate::Vec3;
use crate::checker::Checker;
use crate::element::ElementGroup;
use crate::element::beam;
use crate::element::generalized_law::LinearLaw;
use crate::element::quadratic::{Members, QuadraticGroup};
use crate::mesh::Mesh;
use crate::model::{Analysis, Beam, BeamSection, Isotropic, Material, Model, RigidBody, SectionConstants};
use crate::section::beam::constants;
use crate::system::{BeamLine, Coordinates, System};

/// Longest name of a beam (characters).
const LONGEST_NAME: usize = 50;
/// Largest number of elements of a beam.
const MOST_ELEMENTS: u32 = 100_000;
/// Largest angle (degrees) between pieces of a beam, and of its twist in one element: beyond it the chords of the axis do not
/// follow the beam.
const LARGEST_ANGLE: f64 = 30.0;
/// Sine of the angle between the direction of axis 1 and the beam, below which they are parallel.
const PARALLEL: f64 = 1e-6;

/// Distance along the axis between a node of a shell and the node of the beam that it is attached to, over the length of an element.
const BESIDE: f64 = 1e-3;

/// Mistakes in the values of beams.
pub(super) fn keys(model: &Model, c: &mut Checker) {
    for (i, data) in model.beams.iter().enumerate() {
        let key = format!("beams[{i}]");
        let mistakes = c.issues.len();
        c.file_name(&format!("{key}.name"), &data.name, LONGEST_NAME);
        if model.beams[..i].iter().any(|other| other.name == data.name) {
            let message = format!("the name \"{}\" is given twice", data.name);
            c.add(format!("{key}.name"), message, "give each beam its own name");
        }
        data.points.iter().for_each(|x| c.finite(&format!("{key}.points"), "the point", x));
        c.finite(&format!("{key}.direction"), "the direction", &data.direction);
        c.finite(&format!("{key}.twist"), "the twist", &[data.twist]);
        c.finite(&format!("{key}.velocity"), "the velocity", &data.velocity);
        c.finite(&format!("{key}.angular_velocity"), "the angular velocity", &data.angular_velocity);
        c.not_negative(&format!("{key}.retardation_time"), "the retardation time", data.retardation_time);
        section_values(data, model, &key, c);
        if c.issues.len() == mistakes {
            axis_values(data, &key, c);
        }
    }
}

/// Sets of attached nodes that the mesh does not have.
pub(super) fn sets(model: &Model, mesh: &Mesh, c: &mut Checker) {
    for (i, beam) in model.beams.iter().enumerate() {
        for (k, set) in beam.attached.iter().enumerate() {
            c.set(mesh, format!("beams[{i}].attached[{k}]"), set, "nodes", Mesh::nodes_on);
        }
    }
}

/// Mistake of beams without mass in a model that has none at all, where a load acts on masses.
pub(super) fn masses(model: &Model, system: &System, load: &str, c: &mut Checker) {
    let Some(beam) = model.beams.first().filter(|_| system.total_mass() == 0.0) else { return };
    let message =
        format!("{load} acts on masses, but neither beam \"{}\" nor any other part has one", beam.name);
    c.add("beams[0]", message, "give the density of its material, or the mass of its section constants");
}

/// Whether the analysis needs the masses of beams.
fn needs_mass(model: &Model) -> bool {
    !matches!(model.analysis, Analysis::Static(_) | Analysis::Path(_) | Analysis::Buckling(_))
}

fn section_values(data: &Beam, model: &Model, key: &str, c: &mut Checker) {
    let place = format!("{key}.section");
    match &data.section {
        BeamSection::Rectangle(section) => {
            section.size.iter().for_each(|x| c.positive(&place, "a side of the section", *x));
        }
        BeamSection::Circle(section) => {
            c.positive(&place, "the radius of the section", section.radius);
            c.not_negative(&place, "the inner radius of the section", section.inner_radius);
            if !(section.inner_radius < section.radius) {
                c.add(
                    place.as_str(),
                    "the inner radius is not below the radius",
                    "give a smaller `inner_radius`",
                );
            }
        }
        BeamSection::Box(section) => {
            section.size.iter().for_each(|x| c.positive(&place, "a side of the section", *x));
            c.positive(&place, "the thickness of the walls", section.thickness);
            if !(2.0 * section.thickness < section.size[0].min(section.size[1])) {
                let message =
                    "the walls fill the section: twice their thickness is not below the smaller side";
                c.add(place.as_str(), message, "give a smaller `thickness`, or a `rectangle`");
            }
        }
        BeamSection::Constants(s) => {
            if data.material.is_some() {
                let message = format!("beam \"{}\" has section constants and a material", data.name);
                c.add(
                    format!("{key}.material"),
                    message,
                    "leave the material out, or give a shape of the section",
                );
            }
            let stiffness =
                [("axial", vec![s.axial]), ("shear", s.shear.into()), ("bending", s.bending.into())];
            for (name, values) in stiffness.into_iter().chain([("torsion", vec![s.torsion])]) {
                values.iter().for_each(|x| c.positive(&place, &format!("the constant `{name}`"), *x));
            }
            let check = if needs_mass(model) { Checker::positive } else { Checker::not_negative };
            for (name, values) in [("mass", vec![s.mass]), ("inertia", s.inertia.into())] {
                values.iter().for_each(|x| check(c, &place, &format!("the constant `{name}`"), *x));
            }
            return;
        }
    }
    let Some(name) = &data.material else {
        let message = format!("beam \"{}\" has a section of a shape, but no material", data.name);
        c.add(format!("{key}.material"), message, "name an isotropic material");
        return;
    };
    match model.materials.get(name) {
        None => c.missing(format!("{key}.material"), "material", name, model.materials.keys()),
        Some(Material::Isotropic(material)) if material.density > 0.0 || !needs_mass(model) => {}
        Some(Material::Isotropic(_)) => {
            let message = format!("the density is 0, but beam \"{}\" needs its mass", data.name);
            c.add(format!("materials.{name}.density"), message, "give the density");
        }
        Some(_) => c.add(
            format!("{key}.material"),
            format!("the material \"{name}\" is not isotropic and linear"),
            "name one with `type = \"isotropic\"`, or give section constants",
        ),
    }
}

fn axis_values(data: &Beam, key: &str, c: &mut Checker) {
    let name = &data.name;
    let (count, points) = (data.points.len(), format!("{key}.points"));
    match (count, data.elements) {
        (0 | 1, _) => {
            return c.add(
                points,
                format!("beam \"{name}\" has {count} point(s)"),
                "give both ends, or all nodes",
            );
        }
        (2, None | Some(0)) => {
            let message = format!("beam \"{name}\" has no elements");
            return c.add(format!("{key}.elements"), message, "give the number of its elements");
        }
        (2, Some(n)) if n > MOST_ELEMENTS => {
            let message = format!("beam \"{name}\" has {n} elements; at most {MOST_ELEMENTS} are taken");
            return c.add(format!("{key}.elements"), message, "give fewer elements");
        }
        (3.., Some(_)) => {
            let message = format!("the {count} points of beam \"{name}\" are its nodes");
            return c.add(format!("{key}.elements"), message, "leave `elements` out, or give both ends only");
        }
        _ => {}
    }
    let axis = Axis::of(data);
    let chords: Vec<Vec3> = axis.points.windows(2).map(|x| x[1] - x[0]).collect();
    if chords.iter().any(|chord| !(chord.norm() > 0.0)) {
        return c.add(points, format!("two points of beam \"{name}\" coincide"), "leave one of them out");
    }
    let sharp = |pair: &[Vec3]| pair[0].angle(&pair[1]).to_degrees() > LARGEST_ANGLE;
    if chords.windows(2).any(sharp) {
        c.add(
            points,
            format!("the axis of beam \"{name}\" turns by more than {LARGEST_ANGLE} degrees from one element to the next"),
            "give more points, or two beams with a fixed joint where they meet at an angle",
        );
    }
    let elements = chords.len();
    if data.twist.abs() > LARGEST_ANGLE * elements as f64 {
        c.add(
            format!("{key}.twist"),
            format!("beam \"{name}\" is twisted by more than {LARGEST_ANGLE} degrees in each element"),
            "give more elements",
        );
    }
    let direction = Vec3::from(data.direction);
    if axis.tangents().iter().any(|t| !(t.cross(&direction).norm() > PARALLEL * direction.norm())) {
        c.add(
            format!("{key}.direction"),
            format!("the direction of axis 1 of beam \"{name}\" is zero or along the beam"),
            "give a direction across the beam",
        );
    }
    for node in data.history.iter().flatten().filter(|node| **node as usize > elements) {
        c.add(
            format!("{key}.history"),
            format!("beam \"{name}\" has no node {node}: its nodes are 0 to {elements}"),
            "give numbers of nodes",
        );
    }
}

/// Nodes of a beam along its axis.
struct Axis {
    points: Vec<Vec3>,
}

impl Axis {
    fn of(data: &Beam) -> Self {
        let given: Vec<Vec3> = data.points.iter().map(|x| Vec3::from(*x)).collect();
        match (&given[..], data.elements) {
            ([a, b], Some(n)) => {
                let at = |i: u32| a + (b - a) * (f64::from(i) / f64::from(n));
                Self { points: (0..=n).map(at).collect() }
            }
            _ => Self { points: given },
        }
    }

    /// Unit tangents at the nodes: the mean of both chords, at the ends that of a circle through the first (last) nodes.
    fn tangents(&self) -> Vec<Vec3> {
        let chords: Vec<Vec3> = self.points.windows(2).map(|x| (x[1] - x[0]).normalize()).collect();
        let n = chords.len();
        let inner = |i: usize| (chords[i - 1] + chords[i]).normalize();
        let mirrored = |chord: Vec3, next: Vec3| chord * (2.0 * chord.dot(&next)) - next;
        (0..=n)
            .map(|i| match i {
                _ if n == 1 => chords[0],
                0 => mirrored(chords[0], inner(1)),
                i if i == n => mirrored(chords[n - 1], inner(n - 1)),
                i => inner(i),
            })
            .collect()
    }

    /// Axes 1, 2 and 3 of the cross-section at each node.
    fn bases(&self, data: &Beam) -> Vec<[Vec3; 3]> {
        let lengths = self.points.windows(2).map(|x| (x[1] - x[0]).norm());
        let ends: Vec<f64> = std::iter::once(0.0)
            .chain(lengths.scan(0.0, |sum, length| {
                *sum += length;
                Some(*sum)
            }))
            .collect();
        let total = ends[ends.len() - 1];
        let base = |(t, s): (Vec3, f64)| {
            let direction = Vec3::from(data.direction);
            let first = (direction - t * t.dot(&direction)).normalize();
            let (sine, cosine) = (data.twist.to_radians() * s / total).sin_cos();
            let first = first * cosine + t.cross(&first) * sine;
            [first, t.cross(&first), t]
        };
        self.tangents().into_iter().zip(ends).map(base).collect()
    }
}

/// Name of a node of a beam of `elements`.
fn node_name(beam: &str, node: usize, elements: usize) -> String {
    match node {
        0 => format!("{beam}.start"),
        n if n == elements => format!("{beam}.end"),
        n => format!("{beam}.{n}"),
    }
}

/// The model with the nodes of all beams as rigid bodies, behind its own bodies.
pub(super) fn with_nodes(model: &Model) -> Model {
    let mut out = model.clone();
    for data in &model.beams {
        let Some(section) = section(data, model) else { continue };
        let axis = Axis::of(data);
        let elements = axis.points.len().saturating_sub(1);
        if elements == 0 {
            continue;
        }
        let half = |i: usize| 0.5 * (axis.points[i + 1] - axis.points[i]).norm();
        for (i, (x, [first, second, _])) in axis.points.iter().zip(axis.bases(data)).enumerate() {
            let before = if i > 0 { half(i - 1) } else { 0.0 };
            let share = before + if i < elements { half(i) } else { 0.0 };
            let [j1, j2] = section.inertia;
            let omega = Vec3::from(data.angular_velocity);
            let velocity = Vec3::from(data.velocity) + omega.cross(&(x - axis.points[0]));
            let inertia = [j1, j2, j1 + j2].map(|j| j * share);
            let name = node_name(&data.name, i, elements);
            out.bodies.push(RigidBody {
                axes: [first.into(), second.into()],
                velocity: velocity.into(),
                angular_velocity: data.angular_velocity,
                ..RigidBody::new(&name, (*x).into(), section.mass * share, Some(inertia))
            });
        }
    }
    out
}

/// Nodes of a beam with the bodies that they are.
pub(super) struct Nodes {
    points: Vec<Vec3>,
    tangents: Vec<Vec3>,
    /// Shortest element (length).
    shortest: f64,
    /// Number of the first node among the bodies.
    first: usize,
}

impl Nodes {
    /// Nodes of a beam in the reference configuration.
    pub fn of(data: &Beam, coordinates: &Coordinates) -> Self {
        let axis = Axis::of(data);
        let start = node_name(&data.name, 0, usize::MAX);
        let first = coordinates.bodies.iter().position(|body| body.name == start).unwrap_or_default();
        let lengths = axis.points.windows(2).map(|x| (x[1] - x[0]).norm());
        Self {
            shortest: lengths.fold(f64::INFINITY, f64::min),
            tangents: axis.tangents(),
            points: axis.points,
            first,
        }
    }

    /// Number of the body that is the node beside a place.
    ///
    /// # Errors
    /// The place lies before or behind the nearest node, by this distance along the axis.
    pub fn beside(&self, place: &Vec3) -> Result<usize, f64> {
        let distance = |i: &usize| (self.points[*i] - place).norm();
        let nearest = (0..self.points.len()).min_by(|i, j| distance(i).total_cmp(&distance(j)));
        let nearest = nearest.unwrap_or_default();
        let along = (self.points[nearest] - place).dot(&self.tangents[nearest]).abs();
        if along <= BESIDE * self.shortest { Ok(self.first + nearest) } else { Err(along) }
    }
}

fn section(data: &Beam, model: &Model) -> Option<SectionConstants> {
    let material: Option<&Isotropic> =
        data.material.as_ref().and_then(|name| model.materials.get(name)).and_then(
            |material| match material {
                Material::Isotropic(isotropic) => Some(isotropic),
                _ => None,
            },
        );
    constants(&data.section, material)
}

/// Elements of the beams of a model whose nodes are bodies: groups of one retardation time each, and the beams with their nodes
/// and elements.
pub(super) fn elements(
    model: &Model,
    coordinates: &Coordinates,
) -> (Vec<Box<dyn ElementGroup>>, Vec<BeamLine>) {
    let (mut groups, mut lines): (Vec<Box<dyn ElementGroup>>, _) = (Vec::new(), Vec::new());
    for data in &model.beams {
        let start = node_name(&data.name, 0, usize::MAX);
        let first = coordinates.bodies.iter().position(|body| body.name == start);
        let (Some(section), Some(first)) = (section(data, model), first) else { continue };
        let axis = Axis::of(data);
        let elements = axis.points.len() - 1;
        let bodies = first..first + elements + 1;
        let mut members = Members::<{ beam::VECTORS }>::default();
        let mut law = LinearLaw::<{ beam::STRAINS }>::default();
        for (pair, x) in coordinates.bodies[bodies.clone()].windows(2).zip(axis.points.windows(2)) {
            let node = |i: usize| {
                let [d1, d2, d3] = pair[i].directors.unwrap_or_default();
                [pair[i].centre, d1, d2, d3]
            };
            let ([r0, a1, a2, a3], [r1, b1, b2, b3]) = (node(0), node(1));
            members.vectors.push([r0, a1, a2, a3, r1, b1, b2, b3]);
            members.mass.extend([0.0; beam::VECTORS * (beam::VECTORS + 1) / 2]);
            law.h.extend(beam::stiffness(&section, (x[1] - x[0]).norm()));
        }
        let history = data.history.clone().unwrap_or_else(|| vec![0, elements as u32]);
        lines.push(BeamLine { name: data.name.clone(), bodies, group: groups.len(), history });
        let group = QuadraticGroup::<
            { beam::VECTORS },
            { 3 * beam::VECTORS },
            { beam::STRAINS },
            { beam::BASE },
            _,
        >::new(
            "beam", beam::strains(), members, law, data.retardation_time + model.damping.stiffness
        );
        groups.push(Box::new(group));
    }
    (groups, lines)
}
