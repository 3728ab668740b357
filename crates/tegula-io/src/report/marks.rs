//! Marks in the picture of a model: supports, loads, joints, bodies, masses, recorded points and named sets.

use serde::Serialize;
use tegula::model::loads::LoadedPart;
use tegula::model::{AddedMass, Condition, Joint, Load};
use tegula::{Mesh, System, Vec3};

use super::blocks::{Block, Blocks};
use super::scene::shown;
use crate::job::Prepared;
use crate::out::numbers::{counted, significant};

/// Length of the longest arrow of a load as a part of the model.
const ARROW: f64 = 0.12;
/// Most arrows of a load; of more places those that are evenly spaced have one.
const MOST_ARROWS: usize = 150;
/// Most named sets that are listed.
const MOST_SETS: usize = 300;

/// Kind of a mark, by which it is coloured and listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Subject {
    /// Support or prescribed motion.
    Support,
    /// Load.
    Load,
    /// Joint or bushing.
    Joint,
    /// Rigid body.
    Body,
    /// Added mass.
    Mass,
    /// Recorded point.
    Point,
    /// Named set of the mesh.
    Set,
}

/// Shape of the markers of a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Symbol {
    Square,
    Circle,
    Diamond,
    Triangle,
    Cross,
}

/// Something that can be shown on the reference configuration.
#[derive(Debug, Serialize)]
pub(super) struct Mark {
    /// Kind.
    pub subject: Subject,
    /// Name in the list.
    pub name: String,
    /// Value or size in words.
    pub note: String,
    /// Shape of its markers.
    pub symbol: Symbol,
    /// Marked nodes of the mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nodes: Option<Block>,
    /// Marked edges, by their nodes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edges: Option<Block>,
    /// Marked quads.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quads: Option<Block>,
    /// Marked places in space, in single precision.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub places: Option<Block>,
    /// Arrows: start and vector, six numbers in single precision each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arrows: Option<Block>,
    /// Whether the arrows have two heads: moments and axes of rotation.
    pub turning: bool,
}

impl Mark {
    fn new(subject: Subject, name: String, note: String, symbol: Symbol) -> Self {
        Self {
            subject,
            name,
            note,
            symbol,
            nodes: None,
            edges: None,
            quads: None,
            places: None,
            arrows: None,
            turning: false,
        }
    }
}

/// Word of the model file for a kind: the value of its key `type`, or the value itself.
pub(super) fn word(value: &impl Serialize) -> String {
    let value = serde_json::to_value(value).unwrap_or_default();
    value.get("type").unwrap_or(&value).as_str().unwrap_or_default().to_owned()
}

/// Marks of a model. Named sets are added while all blocks have at most `most` characters; returns the number of those that are left out, too.
pub(super) fn of(prepared: &Prepared, blocks: &mut Blocks, most: usize) -> (Vec<Mark>, usize) {
    let Prepared { model, mesh, system, .. } = prepared;
    let mut drawing = Drawing { mesh, system, blocks, out: Vec::new() };
    let whole = [(String::new(), &model.conditions, &model.loads)];
    let steps = model.steps.iter().enumerate().map(|(i, step)| {
        let name = if step.name.is_empty() { (i + 1).to_string() } else { step.name.clone() };
        (format!(" (step {name})"), &step.conditions, &step.loads)
    });
    for (step, conditions, loads) in whole.into_iter().chain(steps) {
        conditions.iter().for_each(|condition| drawing.support(condition, &step));
        loads.iter().for_each(|load| drawing.load(load, &step));
    }
    model.joints.iter().for_each(|joint| drawing.joint(joint));
    for bushing in &model.bushings {
        let note = format!("bushing between {}", bushing.between.join(" and "));
        drawing.places(Subject::Joint, &bushing.name, note, Symbol::Square, &[bushing.at.into()]);
    }
    drawing.bodies();
    model.masses.iter().for_each(|mass| drawing.mass(mass));
    for probe in &prepared.probes {
        let place = mesh.positions.get(probe.node as usize).copied().into_iter().collect::<Vec<_>>();
        drawing.places(Subject::Point, &probe.name, "recorded".into(), Symbol::Cross, &place);
    }
    let left_out = drawing.sets(most);
    (drawing.out, left_out)
}

/// Marks in the making.
struct Drawing<'a> {
    mesh: &'a Mesh,
    system: &'a System,
    blocks: &'a mut Blocks,
    out: Vec<Mark>,
}

impl Drawing<'_> {
    fn support(&mut self, condition: &Condition, step: &str) {
        let word = word(condition);
        let symbol = match word.as_str() {
            "clamp" => Symbol::Square,
            "spherical" | "hinge" => Symbol::Circle,
            "prescribe" => Symbol::Triangle,
            _ => Symbol::Diamond,
        };
        let nodes = self.mesh.nodes_on(condition.on()).unwrap_or_default();
        let (name, note) = (format!("{word} on {}{step}", condition.on()), of_nodes(nodes.len()));
        let nodes = Some(self.blocks.indices(&nodes));
        self.out.push(Mark { nodes, ..Mark::new(Subject::Support, name, note, symbol) });
    }

    fn load(&mut self, load: &Load, step: &str) {
        let on = if load.on().is_empty() { String::new() } else { format!(" on {}", load.on()) };
        let values: Vec<String> = load.values().iter().map(|x| significant(*x, 5)).collect();
        let value = if let [one] = &values[..] { one.clone() } else { format!("({})", values.join(", ")) };
        let amplitude = load.amplitude().as_ref().map(|name| format!(" × {name}")).unwrap_or_default();
        let note = format!("{value}{amplitude}");
        let mut mark = Mark::new(
            Subject::Load,
            format!("{} load{on}{step}", load.kind().replace('-', " ")).replace("load load", "load"),
            note,
            Symbol::Circle,
        );
        mark.turning = load.kind().contains("moment") || matches!(load, Load::Centrifugal(_));
        if load.part() == LoadedPart::Edges {
            let edges = self.mesh.edges_on(load.on()).unwrap_or_default();
            mark.edges = Some(self.blocks.indices(edges.iter().flatten()));
        }
        let arrows = self.arrows(load);
        if !arrows.is_empty() {
            mark.arrows = Some(self.blocks.singles(arrows.iter().flatten().flat_map(|v| v.iter())));
        }
        self.out.push(mark);
    }

    /// Start and vector of the arrows of a load, all of one length.
    fn arrows(&self, load: &Load) -> Vec<[Vec3; 2]> {
        let length = ARROW * self.system.length;
        if let Load::Centrifugal(keys) = load {
            let along = Vec3::from(keys.axis).try_normalize(0.0).unwrap_or_default() * self.system.length;
            return vec![[Vec3::from(keys.at) - 0.6 * along, 1.2 * along]];
        }
        let places = self.loaded_places(load);
        let chosen = shown(places.len(), MOST_ARROWS).into_iter().filter_map(|i| places.get(i));
        match *load.values() {
            [x, y, z] => {
                let unit = Vec3::new(x, y, z).try_normalize(0.0).unwrap_or_default();
                chosen.map(|(place, _)| [*place, unit * length]).collect()
            }
            [value] => chosen
                .map(|(place, normal)| match value > 0.0 {
                    // A pressure pushes against the director, and ends at the surface.
                    true => [place + normal * length, normal * -length],
                    false => [*place, normal * length],
                })
                .collect(),
            _ => Vec::new(),
        }
    }

    /// Places of the arrows of a load, with the normal of the surface where it acts on quads.
    fn loaded_places(&self, load: &Load) -> Vec<(Vec3, Vec3)> {
        let position = |node: u32| self.mesh.positions.get(node as usize).copied().unwrap_or_default();
        let flat = |place: Vec3| (place, Vec3::zeros());
        match load.part() {
            LoadedPart::Nodes => match self.centre(load.on()) {
                Some(centre) => vec![flat(centre)],
                None => {
                    let nodes = self.mesh.nodes_on(load.on()).unwrap_or_default();
                    nodes.into_iter().map(|node| flat(position(node))).collect()
                }
            },
            LoadedPart::Edges => {
                let edges = self.mesh.edges_on(load.on()).unwrap_or_default();
                edges.iter().map(|&[a, b]| flat(0.5 * (position(a) + position(b)))).collect()
            }
            LoadedPart::Quads => {
                let quads = self.mesh.quads_on(load.on()).unwrap_or_default();
                let place = |quad: u32| {
                    let x = self.mesh.quads.get(quad as usize)?.map(position);
                    let normal = (x[2] - x[0]).cross(&(x[3] - x[1]));
                    Some((x.iter().sum::<Vec3>() / 4.0, normal.try_normalize(0.0).unwrap_or_default()))
                };
                quads.into_iter().filter_map(place).collect()
            }
            LoadedPart::Model => vec![flat(self.middle())],
        }
    }

    /// Middle of the box of the model.
    fn middle(&self) -> Vec3 {
        if self.mesh.quads.is_empty() {
            let bodies = &self.system.coordinates.bodies;
            let sum: Vec3 = bodies.iter().map(|body| self.reference(body.centre)).sum();
            return sum / bodies.len().max(1) as f64;
        }
        let (low, high) = self.mesh.bounding_box();
        0.5 * (low + high)
    }

    fn reference(&self, vector: u32) -> Vec3 {
        self.system.coordinates.reference.get(vector as usize).map_or_else(Vec3::zeros, |x| Vec3::from(*x))
    }

    /// Mass centre of a body.
    fn centre(&self, name: &str) -> Option<Vec3> {
        let body = self.system.coordinates.bodies.iter().find(|body| body.name == name)?;
        Some(self.reference(body.centre))
    }

    fn places(&mut self, subject: Subject, name: &str, note: String, symbol: Symbol, places: &[Vec3]) {
        let places = Some(self.blocks.singles(places.iter().flat_map(|x| x.iter())));
        self.out.push(Mark { places, ..Mark::new(subject, name.to_owned(), note, symbol) });
    }

    fn joint(&mut self, joint: &Joint) {
        let keys = joint.common();
        let note =
            format!("{} joint between {}", joint.word().replace('-', " "), keys.between().join(" and "));
        let points: Vec<Vec3> = keys.points().iter().map(|(_, x)| Vec3::from(*x)).collect();
        self.places(Subject::Joint, keys.name(), note, Symbol::Circle, &points);
        let axes: Vec<[Vec3; 2]> = keys
            .directions()
            .iter()
            .zip(points.iter().cycle())
            .filter_map(|((_, axis), point)| {
                let along = Vec3::from(*axis).try_normalize(0.0)? * (ARROW * self.system.length);
                Some([point - 0.5 * along, along])
            })
            .collect();
        if let Some(mark) = self.out.last_mut().filter(|_| !axes.is_empty()) {
            mark.arrows = Some(self.blocks.singles(axes.iter().flatten().flat_map(|v| v.iter())));
        }
    }

    /// Mass centres of the bodies that are no nodes of beams.
    fn bodies(&mut self) {
        let own = self.system.beams.first().map_or(usize::MAX, |beam| beam.bodies.start);
        let found: Vec<(String, f64, Vec3)> = self
            .system
            .coordinates
            .bodies
            .iter()
            .take(own)
            .map(|body| (body.name.clone(), body.mass, self.reference(body.centre)))
            .collect();
        for (name, mass, centre) in found {
            let note = format!("body of mass {}", significant(mass, 5));
            self.places(Subject::Body, &name, note, Symbol::Diamond, &[centre]);
        }
    }

    fn mass(&mut self, mass: &AddedMass) {
        let (AddedMass::Point(keys) | AddedMass::Edge(keys) | AddedMass::Area(keys)) = mass;
        let name = format!("{} mass on {}", word(mass), keys.on);
        let note = significant(keys.value, 5);
        let nodes = self.mesh.nodes_on(&keys.on).unwrap_or_default();
        let nodes = Some(self.blocks.indices(&nodes));
        self.out.push(Mark { nodes, ..Mark::new(Subject::Mass, name, note, Symbol::Circle) });
    }

    /// Named sets of the mesh while they have room; returns the number of those that have none.
    fn sets(&mut self, most: usize) -> usize {
        let Mesh { node_sets, edge_sets, quad_sets, .. } = self.mesh;
        let all = node_sets.len() + edge_sets.len() + quad_sets.len();
        let mut added = 0;
        let mut add =
            |drawing: &mut Self, name: &String, note: String, fill: &dyn Fn(&mut Blocks, &mut Mark)| {
                if added == MOST_SETS || drawing.blocks.size > most {
                    return;
                }
                let mut mark = Mark::new(Subject::Set, name.clone(), note, Symbol::Circle);
                fill(drawing.blocks, &mut mark);
                drawing.out.push(mark);
                added += 1;
            };
        for (name, nodes) in node_sets {
            let fill = |blocks: &mut Blocks, mark: &mut Mark| mark.nodes = Some(blocks.indices(nodes));
            add(self, name, of_nodes(nodes.len()), &fill);
        }
        for (name, edges) in edge_sets {
            let fill = |blocks: &mut Blocks, mark: &mut Mark| {
                mark.edges = Some(blocks.indices(edges.iter().flatten()))
            };
            add(self, name, counted(edges.len() as u64, "edge"), &fill);
        }
        for (name, quads) in quad_sets {
            let fill = |blocks: &mut Blocks, mark: &mut Mark| mark.quads = Some(blocks.indices(quads));
            add(self, name, counted(quads.len() as u64, "element"), &fill);
        }
        all - added
    }
}

fn of_nodes(count: usize) -> String {
    counted(count as u64, "node")
}
