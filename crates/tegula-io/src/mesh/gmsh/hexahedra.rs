//! Middle surface of a shell from one layer of hexahedra, with its directors and its thickness.
//!
//! A hexahedron of eight nodes becomes a quad on the midpoints of the four edges that run through the thickness.
//! These edges are its directors. Which of the three directions is the thickness follows from the mesh: bottom
//! and top belong to no second hexahedron, and neighbours share edges that run through the thickness.

use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};

use tegula::mesh::Labels;
use tegula::{Mesh, Vec3};

use super::gather::{distinct, lost_line, lost_node, sides, sorted};
use super::raw::{Corners, Raw, RawElement};
use super::scanner::Scanner;
use crate::mesh::MeshError;
use crate::mesh::layer::{Pairs, leans};

/// The pairs of opposite faces of a hexahedron in Gmsh's order of nodes; opposite nodes stand at the same place.
const PAIRS: [[[usize; 4]; 2]; 3] =
    [[[0, 1, 2, 3], [4, 5, 6, 7]], [[0, 1, 5, 4], [3, 2, 6, 7]], [[0, 3, 7, 4], [1, 2, 6, 5]]];

type Face = [u64; 4];

/// True if the file holds hexahedra.
pub(super) fn any(raw: &Raw) -> bool {
    raw.elements.iter().any(|e| matches!(e.corners, Corners::Hexahedron(_)))
}

/// Middle surface of the hexahedra and the sets of the physical groups.
pub(super) fn mesh(
    scanner: &Scanner<'_>,
    raw: &Raw,
    listed: &HashMap<u64, usize>,
    scale: f64,
) -> Result<Mesh, MeshError> {
    let layer = Layer::collect(scanner, raw, listed)?;
    let place = |tag: u64| listed.get(&tag).map_or_else(Vec3::zeros, |&i| raw.nodes[i].position * scale);
    // Nodes in the order of their bottom nodes, by whose numbers people know them.
    let mut pairs: Vec<[u64; 2]> =
        layer.bottoms.iter().flatten().zip(layer.tops.iter().flatten()).map(|(&b, &t)| [b, t]).collect();
    pairs.sort_unstable();
    pairs.dedup();
    let index: HashMap<u64, u32> = pairs.iter().zip(0..).flat_map(|(&[b, t], i)| [(b, i), (t, i)]).collect();
    let local = |tag: u64| index.get(&tag).copied();
    let through: Vec<Vec3> = pairs.iter().map(|&[b, t]| place(t) - place(b)).collect();
    let labels = Labels {
        file: scanner.file_name(),
        nodes: pairs.iter().map(|p| p[0]).collect(),
        quads: layer.solids.iter().map(|s| s.tag).collect(),
    };
    let mut mesh = Mesh {
        positions: pairs.iter().map(|&[b, t]| (place(b) + place(t)) * 0.5).collect(),
        thickness: Some(through.iter().map(|t| t.norm()).collect()),
        labels: Some(labels),
        ..Mesh::default()
    };
    let mut normals = Vec::with_capacity(layer.solids.len());
    for (solid, bottom) in layer.solids.iter().zip(&layer.bottoms) {
        let [Some(a), Some(b), Some(c), Some(d)] = bottom.map(local) else { continue };
        let mut quad = [a, b, c, d];
        let [pa, pb, pc, pd] = quad.map(|n| mesh.positions[n as usize]);
        let normal = (pc - pa).cross(&(pd - pb));
        let up = normal.dot(&quad.iter().map(|&n| through[n as usize]).sum::<Vec3>());
        if up < 0.0 {
            quad.swap(1, 3);
        }
        if quad.iter().any(|&n| leans(through[n as usize], normal)) {
            return Err(scanner.error(
                solid.at,
                format!(
                    "hexahedron {}: an edge through its thickness leans more than 60° from its normal",
                    solid.tag
                ),
                "extrude the surface along its normals, by one layer",
            ));
        }
        normals.push(quad.map(|n| through[n as usize].normalize()));
        mesh.quads.push(quad);
    }
    mesh.normals = Some(normals);
    layer.sets(scanner, raw, &local, &mut mesh)?;
    Ok(mesh)
}

/// Hexahedra once each, and which of their faces are bottom and top.
#[derive(Default)]
struct Layer<'a> {
    solids: Vec<&'a RawElement>,
    corners: Vec<[u64; 8]>,
    /// Nodes of the bottom of each, and the nodes of the top above them.
    bottoms: Vec<Face>,
    tops: Vec<Face>,
    /// The hexahedra on each face.
    owners: HashMap<Face, Vec<u32>>,
    /// Physical volumes.
    volumes: BTreeMap<String, Vec<u32>>,
}

impl<'a> Layer<'a> {
    fn collect(scanner: &Scanner<'_>, raw: &'a Raw, listed: &HashMap<u64, usize>) -> Result<Self, MeshError> {
        let mut layer = Self::default();
        let mut known: HashMap<[u64; 8], u32> = HashMap::new();
        for element in &raw.elements {
            let Corners::Hexahedron(corners) = element.corners else { continue };
            let mut key = corners;
            key.sort_unstable();
            if key.windows(2).any(|pair| pair[0] == pair[1]) {
                return Err(scanner.error(
                    element.at,
                    format!("hexahedron {} has a node at two corners", element.tag),
                    "remove collapsed hexahedra",
                ));
            }
            if let Some(missing) = key.iter().find(|tag| !listed.contains_key(tag)) {
                return Err(scanner.error(
                    element.at,
                    format!("element {} needs node {missing}, which $Nodes does not list", element.tag),
                    "the file is damaged: save the mesh again in Gmsh",
                ));
            }
            let next = layer.solids.len() as u32;
            let solid = *known.entry(key).or_insert(next);
            if solid == next {
                layer.solids.push(element);
                layer.corners.push(corners);
            } else if !raw.is_copy(layer.solids[solid as usize], element) {
                return Err(scanner.error(
                    element.at,
                    format!(
                        "hexahedra {} and {} have the same eight nodes",
                        layer.solids[solid as usize].tag, element.tag
                    ),
                    "remove one of them",
                ));
            }
            for name in raw.set_names(element, 3) {
                layer.volumes.entry(name).or_default().push(solid);
            }
        }
        for (solid, corners) in (0..).zip(&layer.corners) {
            for face in PAIRS.iter().flatten() {
                layer.owners.entry(key(face.map(|i| corners[i]))).or_default().push(solid);
            }
        }
        layer.find_thickness(scanner, raw, listed)?;
        Ok(layer)
    }

    fn shared(&self, face: Face) -> bool {
        self.owners.get(&key(face)).is_some_and(|o| o.len() > 1)
    }

    /// Bottom and top of every hexahedron, from a first one of each connected part outwards.
    fn find_thickness(
        &mut self,
        scanner: &Scanner<'_>,
        raw: &Raw,
        listed: &HashMap<u64, usize>,
    ) -> Result<(), MeshError> {
        let count = self.corners.len();
        let mut free = Vec::with_capacity(count);
        for (solid, corners) in self.corners.iter().enumerate() {
            let axes: Vec<usize> = (0..3)
                .filter(|&axis| PAIRS[axis].iter().all(|face| !self.shared(face.map(|i| corners[i]))))
                .collect();
            if axes.is_empty() {
                let element = self.solids[solid];
                return Err(scanner.error(
                    element.at,
                    format!("hexahedron {} has neighbours in all three directions: none can be its thickness", element.tag),
                    "a shell is one layer of hexahedra: extrude its surface once, and give layers of materials as \
                     plies of a `layup`",
                ));
            }
            free.push(axes);
        }
        let place = |tag: u64| listed.get(&tag).map_or_else(Vec3::zeros, |&i| raw.nodes[i].position);
        let height = |corners: &[u64; 8], axis: usize| -> f64 {
            let [low, high] = PAIRS[axis];
            low.iter().zip(high).map(|(&a, b)| (place(corners[b]) - place(corners[a])).norm()).sum()
        };
        let mut sides: Vec<Option<[Face; 2]>> = vec![None; count];
        let mut pairs = Pairs::default();
        // Where only one direction can be the thickness there is nothing to guess.
        let mut seeds: Vec<usize> = (0..count).collect();
        seeds.sort_by_key(|&s| (free[s].len() != 1, s));
        for seed in seeds {
            if sides[seed].is_some() {
                continue;
            }
            let corners = &self.corners[seed];
            let thinnest = |a: &&usize, b: &&usize| height(corners, **a).total_cmp(&height(corners, **b));
            let Some(&axis) = free[seed].iter().min_by(thinnest) else { continue };
            sides[seed] = Some(PAIRS[axis].map(|face| face.map(|i| corners[i])));
            let mut queue = VecDeque::from([seed]);
            while let Some(solid) = queue.pop_front() {
                let Some([bottom, top]) = sides[solid] else { continue };
                if !bottom.into_iter().zip(top).all(|(b, t)| pairs.add(b, t)) {
                    return Err(self.disagreement(scanner, solid));
                }
                for k in 0..4 {
                    let next = (k + 1) % 4;
                    let face = key([bottom[k], bottom[next], top[next], top[k]]);
                    for &neighbour in self.owners.get(&face).into_iter().flatten() {
                        let n = neighbour as usize;
                        if n == solid {
                            continue;
                        }
                        let found = oriented(&self.corners[n], [bottom[k], top[k]], &free[n]);
                        match (found, sides[n]) {
                            (None, _) => return Err(self.disagreement(scanner, n)),
                            (Some(new), None) => {
                                sides[n] = Some(new);
                                queue.push_back(n);
                            }
                            (Some(new), Some(old)) if key(new[0]) != key(old[0]) => {
                                return Err(self.disagreement(scanner, n));
                            }
                            _ => {}
                        }
                    }
                }
            }
        }
        for [bottom, top] in sides.into_iter().flatten() {
            self.bottoms.push(bottom);
            self.tops.push(top);
        }
        Ok(())
    }

    fn disagreement(&self, scanner: &Scanner<'_>, solid: usize) -> MeshError {
        let element = self.solids[solid];
        scanner.error(
            element.at,
            format!("hexahedron {} and its neighbours do not lie side by side in one layer", element.tag),
            "a shell is one layer of hexahedra with two sides: extrude its surface once",
        )
    }

    /// Sets of the physical groups of all dimensions.
    fn sets(
        self,
        scanner: &Scanner<'_>,
        raw: &Raw,
        local: &dyn Fn(u64) -> Option<u32>,
        mesh: &mut Mesh,
    ) -> Result<(), MeshError> {
        let Sets { nodes, edges, surfaces } = self.gather_sets(scanner, raw, local)?;
        for (name, members) in surfaces {
            if self.volumes.contains_key(&name) {
                return Err(scanner.whole(
                    format!("a physical surface and a physical volume are both called \"{name}\""),
                    "in a shell of hexahedra both name elements: give them different names",
                ));
            }
            mesh.quad_sets.insert(name, distinct(members, |&q| q));
        }
        for (name, members) in self.volumes {
            mesh.quad_sets.insert(name, distinct(members, |&q| q));
        }
        mesh.node_sets = nodes.into_iter().map(|(name, set)| (name, distinct(set, |&n| n))).collect();
        mesh.edge_sets = edges.into_iter().map(|(name, set)| (name, distinct(set, |&e| sorted(e)))).collect();
        Ok(())
    }

    /// Members of the physical points, curves and surfaces.
    fn gather_sets(
        &self,
        scanner: &Scanner<'_>,
        raw: &Raw,
        local: &dyn Fn(u64) -> Option<u32>,
    ) -> Result<Sets, MeshError> {
        let outer: HashMap<Face, u32> = (0..)
            .zip(self.bottoms.iter().zip(&self.tops))
            .flat_map(|(s, (&b, &t))| [(key(b), s), (key(t), s)])
            .collect();
        let mut below: HashSet<u64> = self.bottoms.iter().flatten().copied().collect();
        self.tops.iter().flatten().for_each(|top| {
            below.remove(top);
        });
        let quad_sides: HashSet<[u64; 2]> = self.bottoms.iter().chain(&self.tops).flat_map(sides).collect();
        let mut sets = Sets::default();
        for element in &raw.elements {
            match element.corners {
                Corners::Point(tag) => {
                    for name in raw.set_names(element, 0) {
                        let Some(node) = local(tag) else {
                            return Err(lost_node(scanner, element, &name, tag));
                        };
                        sets.nodes.entry(name).or_default().push(node);
                    }
                }
                Corners::Line(ends) => {
                    for name in raw.set_names(element, 1) {
                        let [Some(a), Some(b)] = ends.map(local) else {
                            return Err(lost_line(scanner, element, &name, ends));
                        };
                        if a == b {
                            sets.nodes.entry(name).or_default().push(a);
                        } else if quad_sides.contains(&sorted(ends)) {
                            sets.edges.entry(name).or_default().push([a, b]);
                        } else {
                            return Err(lost_line(scanner, element, &name, ends));
                        }
                    }
                }
                Corners::Quad(corners) => {
                    let names = raw.set_names(element, 2);
                    if let Some(&solid) = outer.get(&key(corners)) {
                        names.into_iter().for_each(|name| sets.surfaces.entry(name).or_default().push(solid));
                    } else if self.owners.contains_key(&key(corners)) {
                        // A face through the thickness stands on an edge of the middle surface.
                        let low = corners.iter().filter(|c| below.contains(c)).filter_map(|&c| local(c));
                        if let [a, b] = low.collect::<Vec<_>>()[..] {
                            names
                                .into_iter()
                                .for_each(|name| sets.edges.entry(name).or_default().push([a, b]));
                        }
                    } else {
                        return Err(not_a_face(scanner, element));
                    }
                }
                Corners::Hexahedron(_) => {}
            }
        }
        Ok(sets)
    }
}

/// Sets of the physical points, curves and surfaces, whose members may be there more than once.
#[derive(Default)]
struct Sets {
    nodes: BTreeMap<String, Vec<u32>>,
    edges: BTreeMap<String, Vec<[u32; 2]>>,
    surfaces: BTreeMap<String, Vec<u32>>,
}

fn not_a_face(scanner: &Scanner<'_>, element: &RawElement) -> MeshError {
    scanner.error(
        element.at,
        format!("quadrilateral {} is not the face of a hexahedron", element.tag),
        "a file holds either quadrilaterals or hexahedra: mesh the whole middle surface with quadrilaterals, and give `element = \
         \"solid-shell\"` to the sections where you want it",
    )
}

/// Bottom and top of a hexahedron of which an edge runs through the thickness, from bottom to top.
fn oriented(corners: &[u64; 8], [bottom, top]: [u64; 2], free: &[usize]) -> Option<[Face; 2]> {
    for &axis in free {
        let [low, high] = PAIRS[axis].map(|face| face.map(|i| corners[i]));
        for k in 0..4 {
            if [low[k], high[k]] == [bottom, top] {
                return Some([low, high]);
            }
            if [high[k], low[k]] == [bottom, top] {
                return Some([high, low]);
            }
        }
    }
    None
}

fn key(mut face: Face) -> Face {
    face.sort_unstable();
    face
}
