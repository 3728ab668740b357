//! Sets of the mesh that the model defines by places, directions, formulas or other sets.

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

use crate::checker::Checker;
use crate::load::PlaceCondition;
use crate::mesh::Mesh;
use crate::mesh::sets::{ALL, RENAME_ALL, undirected};
use crate::model::{
    BoundarySet, BoxSet, CombinedSet, CylinderSet, FormulaSet, MeshSet, NormalSet, PlaneSet, SphereSet,
};
use crate::{Issue, Vec3};

/// Distance over the size of the mesh up to which places lie on a surface.
const TOLERANCE: f64 = 1e-6;
/// Distance of the middle of an edge from a set that holds both of its ends, over its length, up to which the edge belongs to the set: the edges of a
/// polygon lie inside its circle.
const SLACK: f64 = 0.2;

/// Members of a set.
#[derive(Debug, Default)]
struct Members {
    nodes: Vec<u32>,
    edges: Vec<[u32; 2]>,
    quads: Vec<u32>,
}

/// Adds the sets of a model to its mesh, one after another: each may refer to those before it.
///
/// Returns an issue for each set that cannot be made or holds nothing, and leaves it out.
pub fn define_sets(sets: &[MeshSet], mesh: &mut Mesh) -> Vec<Issue> {
    let mut c = Checker::default();
    for (number, set) in sets.iter().enumerate() {
        let (key, name) = (format!("sets[{number}]"), set.name());
        let before = c.issues.len();
        if mesh.quads.is_empty() {
            c.add(
                key,
                "the model has no mesh of which this could be a part",
                "leave the set out, or give a mesh",
            );
            continue;
        }
        if name == "ground" {
            c.add(format!("{key}.name"), "\"ground\" is not the name of a set", "give the set another name");
        } else if name == ALL {
            c.add(format!("{key}.name"), "a set is called \"all\"", RENAME_ALL);
        } else if name.is_empty() || mesh.set_names().contains(name) {
            let problem = if name.is_empty() {
                "the set has no name".into()
            } else {
                format!("the mesh already has a set \"{name}\"")
            };
            c.add(format!("{key}.name"), problem, "give the set a name of its own");
        }
        let members = members(mesh, (&key, set), &mut c);
        if c.issues.len() > before {
            continue;
        }
        let Members { nodes, edges, quads } = members;
        if nodes.is_empty() && edges.is_empty() && quads.is_empty() {
            let (low, high) = mesh.bounding_box();
            c.add(
                key.as_str(),
                format!("the set \"{name}\" holds no node, no element and no edge"),
                format!(
                    "look at its keys; the mesh lies between {} and {}",
                    crate::mesh::show(low),
                    crate::mesh::show(high)
                ),
            );
        }
        // Empty lists, too: otherwise edges would follow from nodes, and nodes from elements.
        mesh.node_sets.insert(name.clone(), nodes);
        mesh.edge_sets.insert(name.clone(), edges);
        mesh.quad_sets.insert(name.clone(), quads);
    }
    c.issues
}

fn members(mesh: &Mesh, (key, set): (&str, &MeshSet), c: &mut Checker) -> Members {
    match set {
        MeshSet::Box(keys) => in_box(mesh, (key, keys), c),
        MeshSet::Plane(keys) => on_plane(mesh, (key, keys), c),
        MeshSet::Sphere(keys) => in_sphere(mesh, (key, keys), c),
        MeshSet::Cylinder(keys) => in_cylinder(mesh, (key, keys), c),
        MeshSet::Formula(keys) => by_formula(mesh, (key, keys), c),
        MeshSet::Normal(keys) => by_normal(mesh, (key, keys), c),
        MeshSet::Boundary(keys) => of_boundary(mesh, (key, keys), c),
        MeshSet::Union(keys) => combined(mesh, (key, keys), c, |holding, _| holding > 0),
        MeshSet::Intersection(keys) => combined(mesh, (key, keys), c, |holding, _| holding == keys.of.len()),
        MeshSet::Difference(keys) => combined(mesh, (key, keys), c, |holding, first| first && holding == 1),
    }
}

/// Part of the mesh that a set is chosen from.
struct Base {
    members: Members,
    /// Distance up to which places lie on a surface (length).
    tolerance: f64,
}

impl Base {
    fn new(mesh: &Mesh, key: &str, within: &str, tolerance: Option<f64>, c: &mut Checker) -> Self {
        if let Some(tolerance) = tolerance {
            c.not_negative(&format!("{key}.tolerance"), "the tolerance", tolerance);
        }
        let members = named(mesh, (&format!("{key}.within"), within), c);
        Self { members, tolerance: tolerance.unwrap_or(TOLERANCE * mesh.extent()) }
    }

    /// Members in a part of space, given by whether it holds a place up to a slack: nodes, elements by their centre, and edges by their ends and
    /// their middle.
    fn chosen(&self, mesh: &Mesh, holds: impl Fn(&Vec3, f64) -> bool) -> Members {
        let place = |node: u32| mesh.positions.get(node as usize).copied();
        let is_in = |node: u32| place(node).is_some_and(|x| holds(&x, 0.0));
        let middle_is_in = |[a, b]: [u32; 2]| {
            let ends = place(a).zip(place(b));
            ends.is_some_and(|(a, b)| holds(&((a + b) * 0.5), SLACK * (a - b).norm()))
        };
        let edge_is_in = |edge: &[u32; 2]| edge.iter().all(|&n| is_in(n)) && middle_is_in(*edge);
        let centre_is_in = |quad: u32| mesh.centre(quad).is_some_and(|x| holds(&x, 0.0));
        Members {
            nodes: self.members.nodes.iter().copied().filter(|&node| is_in(node)).collect(),
            edges: self.members.edges.iter().copied().filter(edge_is_in).collect(),
            quads: self.members.quads.iter().copied().filter(|&q| centre_is_in(q)).collect(),
        }
    }
}

/// Members of a set that exists; an issue where it does not.
fn named(mesh: &Mesh, (key, name): (&str, &str), c: &mut Checker) -> Members {
    match mesh.nodes_on(name) {
        Some(nodes) => Members {
            // Of a set of elements alone: the edges of the boundary between its nodes.
            edges: mesh.edges_on(name).unwrap_or_else(|| mesh.boundary_between(&nodes)),
            quads: mesh.quads_on(name).unwrap_or_default(),
            nodes,
        },
        None => {
            let help = match mesh.closest_name(name) {
                Some(close) => {
                    format!("did you mean \"{close}\"? There are: {}", mesh.set_names().join(", "))
                }
                None => {
                    format!("sets may name those before them; there are: {}", mesh.set_names().join(", "))
                }
            };
            c.add(key, format!("there is no set \"{name}\" yet"), help);
            Members::default()
        }
    }
}

fn in_box(mesh: &Mesh, (key, keys): (&str, &BoxSet), c: &mut Checker) -> Members {
    let base = Base::new(mesh, key, &keys.within, keys.tolerance, c);
    let ranges = [("x", keys.x), ("y", keys.y), ("z", keys.z)];
    if ranges.iter().all(|(_, range)| range.is_none()) {
        c.add(
            key,
            "the box has no range",
            "give the range of one coordinate or more, such as `x = [0.0, 1.0]`",
        );
    }
    for (axis, range) in &ranges {
        let Some([low, high]) = range else { continue };
        c.finite(&format!("{key}.{axis}"), "an end of the range", &[*low, *high]);
        if low > high {
            c.add(format!("{key}.{axis}"), "the range ends below its beginning", "exchange both ends");
        }
    }
    let within = |x: f64, range: Option<[f64; 2]>, margin: f64| {
        range.is_none_or(|[low, high]| low - margin <= x && x <= high + margin)
    };
    base.chosen(mesh, |x, slack| {
        ranges.iter().zip(x.iter()).all(|((_, range), x)| within(*x, *range, base.tolerance + slack))
    })
}

fn on_plane(mesh: &Mesh, (key, keys): (&str, &PlaneSet), c: &mut Checker) -> Members {
    let mut base = Base::new(mesh, key, &keys.within, keys.tolerance, c);
    c.finite(&format!("{key}.at"), "the point", &keys.at);
    let Some(normal) = direction((&format!("{key}.normal"), &keys.normal), c) else {
        return Members::default();
    };
    let (at, tolerance) = (Vec3::from(keys.at), base.tolerance);
    let holds = |x: &Vec3, slack: f64| (x - at).dot(&normal).abs() <= tolerance + slack;
    let lies = |node: u32| mesh.positions.get(node as usize).is_some_and(|x| holds(x, 0.0));
    let nodes: BTreeSet<u32> = base.members.nodes.iter().copied().collect();
    // The line in which the plane cuts elements that have edges on it; elements that lie in the plane have no such line.
    let mut edges: BTreeMap<[u32; 2], [u32; 2]> =
        base.members.edges.iter().map(|edge| (undirected(edge), *edge)).collect();
    for &quad in &base.members.quads {
        if !mesh.sides(quad).all(|[node, _]| lies(node)) {
            let sides = mesh.sides(quad).filter(|side| side.iter().all(|node| nodes.contains(node)));
            sides.for_each(|edge| _ = edges.entry(undirected(&edge)).or_insert(edge));
        }
    }
    base.members.edges = edges.into_values().collect();
    base.chosen(mesh, holds)
}

fn in_sphere(mesh: &Mesh, (key, keys): (&str, &SphereSet), c: &mut Checker) -> Members {
    let base = Base::new(mesh, key, &keys.within, keys.tolerance, c);
    c.finite(&format!("{key}.at"), "the centre", &keys.at);
    let [inner, outer] = radii((key, [keys.inner_radius, keys.radius]), base.tolerance, c);
    let at = Vec3::from(keys.at);
    base.chosen(mesh, |x, slack| (inner - slack..=outer + slack).contains(&(x - at).norm()))
}

fn in_cylinder(mesh: &Mesh, (key, keys): (&str, &CylinderSet), c: &mut Checker) -> Members {
    let base = Base::new(mesh, key, &keys.within, keys.tolerance, c);
    c.finite(&format!("{key}.at"), "the point", &keys.at);
    let [inner, outer] = radii((key, [keys.inner_radius, keys.radius]), base.tolerance, c);
    let Some(axis) = direction((&format!("{key}.axis"), &keys.axis), c) else { return Members::default() };
    let at = Vec3::from(keys.at);
    base.chosen(mesh, |x, slack| (inner - slack..=outer + slack).contains(&(x - at).cross(&axis).norm()))
}

/// Least and largest distance between two radii.
fn radii((key, [inner, outer]): (&str, [f64; 2]), tolerance: f64, c: &mut Checker) -> [f64; 2] {
    c.not_negative(&format!("{key}.radius"), "the radius", outer);
    c.not_negative(&format!("{key}.inner_radius"), "the radius", inner);
    if inner > outer {
        c.add(format!("{key}.inner_radius"), "the inner radius is larger than the radius", "exchange both");
    }
    [inner - tolerance, outer + tolerance]
}

fn by_formula(mesh: &Mesh, (key, keys): (&str, &FormulaSet), c: &mut Checker) -> Members {
    let base = Base::new(mesh, key, &keys.within, keys.tolerance, c);
    let condition = match PlaceCondition::read(&keys.condition) {
        Ok(condition) => condition,
        Err((problem, help)) => {
            c.add(format!("{key}.where"), problem, help);
            return Members::default();
        }
    };
    let undefined = Cell::new(None);
    let members = base.chosen(mesh, |x, slack| {
        let holds = condition.holds(x, [base.tolerance, slack]);
        if holds.is_none() {
            undefined.set(Some(*x));
        }
        holds.unwrap_or(false)
    });
    if let Some(place) = undefined.get() {
        c.add(
            format!("{key}.where"),
            format!("a formula has no value at {}, where the set is looked for", crate::mesh::show(place)),
            "put an inequality before it that does not hold there, with `and`, or choose from a smaller set with `within`",
        );
    }
    members
}

/// Elements with a normal near to a direction, their nodes, and their sides on the boundary of the mesh.
fn by_normal(mesh: &Mesh, (key, keys): (&str, &NormalSet), c: &mut Checker) -> Members {
    let base = Base::new(mesh, key, &keys.within, None, c);
    if !(0.0..=180.0).contains(&keys.angle) {
        let problem = format!("the angle is {:?} degrees", keys.angle);
        c.add(format!("{key}.angle"), problem, "give an angle between 0 and 180 degrees");
    }
    let Some(direction) = direction((&format!("{key}.direction"), &keys.direction), c) else {
        return Members::default();
    };
    let limit = keys.angle.to_radians() + TOLERANCE;
    let near = |q: &u32| mesh.normal(*q).is_some_and(|normal| normal.angle(&direction) <= limit);
    let quads: Vec<u32> = base.members.quads.into_iter().filter(near).collect();
    let sides: BTreeSet<[u32; 2]> =
        quads.iter().flat_map(|&quad| mesh.sides(quad)).map(|side| undirected(&side)).collect();
    let of_quads: BTreeSet<u32> = sides.iter().flatten().copied().collect();
    let nodes = base.members.nodes.into_iter().filter(|node| of_quads.contains(node)).collect();
    let edges = base.members.edges.into_iter().filter(|edge| sides.contains(&undirected(edge))).collect();
    Members { nodes, edges, quads }
}

fn of_boundary(mesh: &Mesh, (key, keys): (&str, &BoundarySet), c: &mut Checker) -> Members {
    let base = Base::new(mesh, key, &keys.within, None, c);
    let mut edges = mesh.boundary_of(&base.members.quads);
    if let Some(near) = keys.near {
        c.finite(&format!("{key}.near"), "the point", &near);
        edges = nearest_line(mesh, edges, near.into());
    }
    let nodes: BTreeSet<u32> = edges.iter().flatten().copied().collect();
    Members { nodes: nodes.into_iter().collect(), edges, quads: Vec::new() }
}

/// Of the connected lines of some edges the one with the node nearest to a point.
fn nearest_line(mesh: &Mesh, edges: Vec<[u32; 2]>, near: Vec3) -> Vec<[u32; 2]> {
    let distance = |node: u32| mesh.positions.get(node as usize).map_or(f64::INFINITY, |x| (x - near).norm());
    let ends = edges.iter().flatten().copied();
    let Some(start) = ends.min_by(|a, b| distance(*a).total_cmp(&distance(*b))) else { return edges };
    let mut neighbours: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for [a, b] in &edges {
        neighbours.entry(*a).or_default().push(*b);
        neighbours.entry(*b).or_default().push(*a);
    }
    let (mut line, mut next) = (BTreeSet::from([start]), vec![start]);
    while let Some(node) = next.pop() {
        let others = neighbours.get(&node).into_iter().flatten();
        next.extend(others.filter(|other| line.insert(**other)));
    }
    edges.into_iter().filter(|[a, _]| line.contains(a)).collect()
}

/// Members by the number of the sets that hold them, and whether the first one does.
fn combined(
    mesh: &Mesh,
    (key, CombinedSet { of, .. }): (&str, &CombinedSet),
    c: &mut Checker,
    keeps: impl Fn(usize, bool) -> bool,
) -> Members {
    if of.is_empty() {
        c.add(format!("{key}.of"), "the list of sets is empty", "name the sets that are combined");
    }
    let sets: Vec<Members> =
        of.iter().enumerate().map(|(i, name)| named(mesh, (&format!("{key}.of[{i}]"), name), c)).collect();
    let kept = |member: fn(&Members) -> Vec<[u32; 2]>| -> Vec<[u32; 2]> {
        let mut found: BTreeMap<[u32; 2], (usize, bool, [u32; 2])> = BTreeMap::new();
        for (i, set) in sets.iter().enumerate() {
            for edge in member(set) {
                found.entry(undirected(&edge)).or_insert((0, i == 0, edge)).0 += 1;
            }
        }
        found
            .into_values()
            .filter(|(holding, first, _)| keeps(*holding, *first))
            .map(|(.., edge)| edge)
            .collect()
    };
    let first = |list: Vec<[u32; 2]>| list.into_iter().map(|[n, _]| n).collect();
    Members {
        nodes: first(kept(|set| loops(&set.nodes))),
        edges: kept(|set| set.edges.clone()),
        quads: first(kept(|set| loops(&set.quads))),
    }
}

/// Nodes or elements as edges from each to itself.
fn loops(list: &[u32]) -> Vec<[u32; 2]> {
    list.iter().map(|&n| [n, n]).collect()
}

/// A unit vector; an issue where a direction has no length.
fn direction((key, value): (&str, &[f64; 3]), c: &mut Checker) -> Option<Vec3> {
    let unit = Vec3::from(*value).try_normalize(0.0).filter(|d| d.iter().all(|x| x.is_finite()));
    if unit.is_none() {
        c.add(key, "the direction has no length", "give three numbers that are not all 0");
    }
    unit
}

#[cfg(test)]
mod tests;
