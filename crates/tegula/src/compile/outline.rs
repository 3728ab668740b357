//! Outline of the bodies, beams and springs of a model.
//!
//! A body with a shape has its faces, one with a surface of triangles that surface; one without is drawn by lines from its mass centre to
//! its joints, springs, and attached or distributed nodes. A beam is drawn with its cross-section, or as a line where only section constants are known.
//! Springs and rods without mass are lines.

use std::collections::BTreeSet;

use super::place::{Place, ends};
use crate::Vec3;
use crate::checker::Checker;
use crate::constraint::Attachment;
use crate::model::{BeamSection, BodyShape, Joint, RigidBody};
use crate::system::coordinates::Body;
use crate::system::outline::{ball, circle};
use crate::system::{BeamLine, Outline, VectorKind};

/// Distance from the mass centre, as a part of the model, below which a point is the centre itself.
const SAME: f64 = 1e-9;

/// Outline of a model whose beams have their nodes among the bodies.
pub(super) fn outline(place: &Place<'_>, beams: &[BeamLine]) -> Outline {
    let Place { model, coordinates, .. } = *place;
    let own = beams.first().map_or(coordinates.bodies.len(), |beam| beam.bodies.start);
    let mut drawing = Drawing { place, beams, own, out: Outline::default() };
    for (data, body) in model.bodies.iter().zip(&coordinates.bodies).take(own) {
        drawing.body(data, body);
    }
    for line in beams {
        let section = model.beams.iter().find(|data| data.name == line.name).map(|data| data.section);
        drawing.beam(line, section);
    }
    for joint in &model.joints {
        let (keys, points) = (joint.common(), joint.common().points());
        let second = |side: usize| keys.second_side().at.filter(|_| side == 1);
        let at = |side: usize| second(side).or_else(|| points.get(side).or(points.first()).map(|(_, x)| *x));
        let (Some(first), Some(second)) = (at(0), at(1)) else { continue };
        drawing.arms(keys.between(), [first, second]);
        if matches!(joint, Joint::Distance(_)) {
            drawing.rod(keys.name(), keys.between(), [first, second]);
        }
    }
    for spring in &model.springs {
        drawing.arms(&spring.between, spring.points);
        drawing.rod(&spring.name, &spring.between, spring.points);
    }
    for bushing in &model.bushings {
        drawing.arms(&bushing.between, [bushing.at; 2]);
    }
    drawing.out
}

/// Outline in the making.
struct Drawing<'a> {
    place: &'a Place<'a>,
    beams: &'a [BeamLine],
    /// Number of bodies that are no nodes of beams.
    own: usize,
    out: Outline,
}

impl Drawing<'_> {
    fn body(&mut self, data: &RigidBody, body: &Body) {
        let owner = [self.out.add_part(&data.name), 0];
        let Some((shape, directors)) = data.shape.as_ref().zip(body.directors) else {
            let kinds = &self.place.coordinates.kinds;
            let is_position = |vector: u32| kinds[vector as usize] == VectorKind::Position;
            for node in body.attached.iter().filter(|attached| is_position(attached.vector)) {
                self.out.line([Attachment::vector(body.centre), Attachment::vector(node.vector)], owner);
            }
            let followed =
                data.distributed.iter().flat_map(|set| self.place.mesh.nodes_on(set).unwrap_or_default());
            let followed: BTreeSet<u32> = followed
                .map(|node| self.place.coordinates.position_of[node as usize])
                .filter(|v| *v != u32::MAX)
                .collect();
            for position in followed {
                self.out.line([Attachment::vector(body.centre), Attachment::vector(position)], owner);
            }
            return;
        };
        let at = |x: [f64; 3]| Attachment::point(body.centre, directors, &Vec3::from(x));
        let ring = |x: f64, corners: &mut dyn Iterator<Item = [f64; 2]>| -> Vec<Attachment> {
            corners.map(|[y, z]| at([x, y, z])).collect()
        };
        match shape {
            BodyShape::Box(shape) => {
                let [a, b, c] = shape.size.map(|side| 0.5 * side);
                let rings = [-a, a].map(|x| ring(x, &mut rectangle(b, c).into_iter()));
                self.out.solid(&rings, owner);
            }
            BodyShape::Cylinder(shape) => {
                let rings = |radius: f64| -> Vec<_> {
                    [-0.5, 0.5].into_iter().map(|x| ring(x * shape.length, &mut circle(radius))).collect()
                };
                self.out.tube(&rings(shape.radius), &hole(shape.inner_radius, rings), owner);
            }
            BodyShape::Sphere(shape) => {
                let rings: Vec<_> =
                    ball(shape.radius).map(|[x, radius]| ring(x, &mut circle(radius))).collect();
                self.out.solid(&rings, owner);
            }
            BodyShape::Rod(shape) => {
                self.out.line([-0.5, 0.5].map(|x| at([x * shape.length, 0.0, 0.0])), owner);
            }
            BodyShape::Stl(shape) => {
                let Some(surface) = &shape.surface else { return };
                let points = surface.points.iter().map(|x| at((x * shape.scale).into()));
                self.out.surface(points, &surface.triangles, owner);
            }
        }
    }

    fn beam(&mut self, line: &BeamLine, section: Option<BeamSection>) {
        let part = self.out.add_part(&line.name);
        let nodes = &self.place.coordinates.bodies[line.bodies.clone()];
        let ring = |node: &Body, corners: &mut dyn Iterator<Item = [f64; 2]>| -> Vec<Attachment> {
            let directors = node.directors.unwrap_or_default();
            let at = |[y, z]: [f64; 2]| Attachment::point(node.centre, directors, &Vec3::new(y, z, 0.0));
            corners.map(at).collect()
        };
        let first = self.out.quads.len();
        match section {
            Some(BeamSection::Rectangle(section)) => {
                let [a, b] = section.size.map(|side| 0.5 * side);
                let rings: Vec<_> =
                    nodes.iter().map(|node| ring(node, &mut rectangle(a, b).into_iter())).collect();
                self.out.solid(&rings, [part, 0]);
            }
            Some(BeamSection::Circle(section)) => {
                let rings = |radius: f64| -> Vec<_> {
                    nodes.iter().map(|node| ring(node, &mut circle(radius))).collect()
                };
                self.out.tube(&rings(section.radius), &hole(section.inner_radius, rings), [part, 0]);
            }
            Some(BeamSection::Box(section)) => {
                let rings = |[a, b]: [f64; 2]| -> Vec<_> {
                    nodes.iter().map(|node| ring(node, &mut rectangle(a, b).into_iter())).collect()
                };
                let outer = section.size.map(|side| 0.5 * side);
                let inner = outer.map(|half| half - section.thickness);
                self.out.tube(&rings(outer), &rings(inner), [part, 0]);
            }
            Some(BeamSection::Constants(_)) | None => {
                for (element, pair) in nodes.windows(2).enumerate() {
                    let ends = [Attachment::vector(pair[0].centre), Attachment::vector(pair[1].centre)];
                    self.out.line(ends, [part, element as u32]);
                }
            }
        }
        // Faces of an element hold a point of each of its nodes; those that close the beam belong to its first and last one.
        let element_of = |corners: &[u32; 4], out: &Outline| {
            let node = |corner: &u32| {
                let (centre, _) = out.points[*corner as usize].terms.first()?;
                nodes.binary_search_by_key(centre, |node| node.centre).ok()
            };
            corners.iter().filter_map(node).min().unwrap_or(0).min(nodes.len().saturating_sub(2)) as u32
        };
        for face in first..self.out.quads.len() {
            self.out.owner_of_quad[face][1] = element_of(&self.out.quads[face], &self.out);
        }
    }

    /// Lines from the mass centres of bodies without a shape to points of theirs.
    fn arms(&mut self, between: &[String; 2], points: [[f64; 3]; 2]) {
        let Place { model, coordinates, length, .. } = *self.place;
        for (name, at) in between.iter().zip(points) {
            let Some(number) = coordinates.bodies.iter().position(|body| body.name == *name) else {
                continue;
            };
            let body = &coordinates.bodies[number];
            let reference = |v: u32| Vec3::from(coordinates.reference[v as usize]);
            let arm = Vec3::from(at) - reference(body.centre);
            let Some(directors) = body.directors.filter(|_| arm.norm() > SAME * length) else { continue };
            if model.bodies.get(number).is_some_and(|body| body.shape.is_some()) {
                continue;
            }
            let part = match self.beams.iter().position(|beam| beam.bodies.contains(&number)) {
                Some(beam) => self.own + beam,
                None => number,
            };
            let along = Vec3::from(directors.map(|d| reference(d).dot(&arm)));
            let end = Attachment::point(body.centre, directors, &along);
            self.out.line([Attachment::vector(body.centre), end], [part as u32, 0]);
        }
    }

    /// A line between points of two bodies, nodes or the ground.
    fn rod(&mut self, name: &str, between: &[String; 2], points: [[f64; 3]; 2]) {
        let sides = points.map(|at| Some((String::new(), at)));
        let Some([a, b]) = ends(self.place, ("", between), sides, &mut Checker::default()) else { return };
        let part = self.out.add_part(name);
        self.out.line([a.point(&points[0].into()), b.point(&points[1].into())], [part, 0]);
    }
}

/// Corners of a rectangle with half sides.
fn rectangle(a: f64, b: f64) -> [[f64; 2]; 4] {
    [[-a, -b], [a, -b], [a, b], [-a, b]]
}

/// Rings of the inner surface of a tube; none of a solid.
fn hole<R: Default>(radius: f64, rings: impl Fn(f64) -> R) -> R {
    if radius > 0.0 { rings(radius) } else { R::default() }
}
