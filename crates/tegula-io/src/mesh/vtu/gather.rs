//! Mesh from the grid of a file.

use std::collections::{BTreeMap, HashMap, HashSet};

use tegula::mesh::sets::RENAME_ALL;
use tegula::mesh::{Fields, Labels};
use tegula::{Mesh, Vec3};

use super::Fault;
use super::arrays::Numbers;
use super::cells::Cell;
use super::grid::{Array, Data, Grid};

/// Largest number of different values of an array that are groups; arrays with more, as numbers of points, are none.
const MOST_GROUPS: usize = 1000;

/// Quads on the points they use, with sets and fields; all coordinates are multiplied by `scale`.
pub(super) fn mesh(grid: &Grid, file: String, scale: f64) -> Result<Mesh, Fault> {
    without_ghosts(&grid.cell_data)?;
    [&grid.point_data, &grid.cell_data].into_iter().try_for_each(with_own_names)?;
    let quads = quads(grid)?;
    let mut place = vec![None; grid.points.len()];
    quads.iter().flat_map(|(_, quad)| quad).for_each(|&point| place[point as usize] = Some(0));
    let used: Vec<u32> =
        (0..).zip(&place).filter(|(_, node)| node.is_some()).map(|(point, _)| point).collect();
    for (&point, node) in used.iter().zip(0_u32..) {
        place[point as usize] = Some(node);
    }
    let local = |point: u32| place.get(point as usize).copied().flatten();
    let mut mesh = Mesh::default();
    for &point in &used {
        let position = Vec3::from(grid.points[point as usize]) * scale;
        if !position.iter().all(|x| x.is_finite()) {
            let message = format!("point {point} has a coordinate that is not a finite number");
            return Err(Fault::new(
                message,
                "repair the geometry, or the scale of the mesh, and write it again",
            ));
        }
        mesh.positions.push(position);
    }
    for (_, quad) in &quads {
        if let [Some(a), Some(b), Some(c), Some(d)] = quad.map(local) {
            mesh.quads.push([a, b, c, d]);
        }
    }
    let numbers: Vec<usize> = quads.iter().map(|(number, _)| *number).collect();
    sets_of_points(&grid.point_data, &used, &mut mesh);
    sets_of_cells(grid, &numbers, local, &mut mesh)?;
    mesh.fields = fields(grid, &used, &numbers);
    mesh.labels = Some(Labels {
        file,
        nodes: used.iter().copied().map(u64::from).collect(),
        quads: numbers.iter().map(|&number| number as u64).collect(),
    });
    match mesh.partial_all() {
        Some((_, message)) => Err(Fault::new(message, RENAME_ALL)),
        None => Ok(mesh),
    }
}

/// Quads with their numbers among the cells, each once and with four corners.
fn quads(grid: &Grid) -> Result<Vec<(usize, [u32; 4])>, Fault> {
    let (mut out, mut known) = (Vec::new(), HashMap::new());
    for (number, cell) in grid.cells.iter().enumerate() {
        let Cell::Quad(corners) = cell else { continue };
        let mut key = *corners;
        key.sort_unstable();
        if let Some(twice) = key.windows(2).find(|pair| pair[0] == pair[1]) {
            let message = format!("cell {number} has point {} at two corners", twice[0]);
            return Err(Fault::new(message, "mesh this part without collapsed quadrilaterals"));
        }
        if let Some(first) = known.insert(key, number) {
            let message = format!("cells {first} and {number} have the same four points");
            return Err(Fault::new(message, "remove one of them; one thickness has to count for both"));
        }
        out.push((number, *corners));
    }
    if out.is_empty() {
        return Err(Fault::new(
            "the file holds no quadrilaterals",
            "give the middle surface as quadrilaterals of 4 points",
        ));
    }
    if u32::try_from(grid.points.len().max(out.len())).is_err() {
        return Err(Fault::new("the mesh has more than 4294967295 points or quads", "make a coarser mesh"));
    }
    Ok(out)
}

/// Array in which VTK marks cells that are hidden, or that other pieces have, too.
const GHOSTS: &str = "vtkGhostType";

/// Refuses cells that VTK hides or counts twice.
fn without_ghosts(cells: &Data) -> Result<(), Fault> {
    for array in cells.arrays.iter().filter(|array| array.name == GHOSTS) {
        let Numbers::Whole(values) = &array.numbers else { continue };
        if let Some(number) = values.iter().position(|value| *value != 0) {
            let message =
                format!("cell {number} is hidden or a duplicate: its `{GHOSTS}` is {}", values[number]);
            return Err(Fault::new(message, "write the file without hidden and ghost cells"));
        }
    }
    Ok(())
}

/// Refuses an array of truth values whose set has the name of a group of another array.
fn with_own_names(data: &Data) -> Result<(), Fault> {
    let truths: HashSet<&str> =
        groups(data).filter(|groups| groups.truth).map(|groups| groups.array.name.as_str()).collect();
    for groups in groups(data).filter(|groups| !groups.truth && !truths.is_empty()) {
        for name in (0..groups.values.len()).filter_map(|place| groups.set(place)) {
            if truths.contains(name.as_str()) {
                let message = format!(
                    "the arrays \"{name}\" and \"{}\" both have a set with the name \"{name}\"",
                    groups.array.name
                );
                return Err(Fault::new(message, "rename one of the arrays"));
            }
        }
    }
    Ok(())
}

/// Array of integers that are groups.
struct Groups<'a> {
    array: &'a Array,
    values: &'a [i64],
    /// Whether the values are truth values.
    truth: bool,
}

impl Groups<'_> {
    /// Name of the set of a point or cell; `None` where it is in none.
    fn set(&self, place: usize) -> Option<String> {
        let value = self.values.get(place)?;
        let name = &self.array.name;
        if self.truth { (*value == 1).then(|| name.clone()) } else { Some(format!("{name}:{value}")) }
    }
}

/// Arrays of integers that are groups.
fn groups(data: &Data) -> impl Iterator<Item = Groups<'_>> {
    data.arrays.iter().filter_map(|array| match &array.numbers {
        Numbers::Whole(values) if array.components == 1 && !array.is_id => {
            let mut different = HashSet::new();
            let few = values.iter().all(|&value| {
                different.insert(value);
                different.len() <= MOST_GROUPS
            });
            let truth = array.is_byte && different.iter().all(|value| [0, 1].contains(value));
            few.then_some(Groups { array, values, truth })
        }
        _ => None,
    })
}

fn sets_of_points(data: &Data, used: &[u32], mesh: &mut Mesh) {
    for groups in groups(data) {
        for (&point, node) in used.iter().zip(0..) {
            if let Some(name) = groups.set(point as usize) {
                mesh.node_sets.entry(name).or_default().push(node);
            }
        }
    }
}

/// Sets of quads, of the edges of lines and of the nodes of vertices.
fn sets_of_cells(
    grid: &Grid,
    numbers: &[usize],
    local: impl Fn(u32) -> Option<u32>,
    mesh: &mut Mesh,
) -> Result<(), Fault> {
    let sorted = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    // Only lines need the sides of the quads.
    let has_lines = grid.cells.iter().any(|cell| matches!(cell, Cell::Line(_)));
    let with_sides = if has_lines { &mesh.quads[..] } else { &[] };
    let sides_of = |&[a, b, c, d]: &[u32; 4]| [[a, b], [b, c], [c, d], [d, a]].map(sorted);
    let sides: HashSet<[u32; 2]> = with_sides.iter().flat_map(sides_of).collect();
    let (mut edge_sets, mut node_sets) = (BTreeMap::<_, Vec<_>>::new(), BTreeMap::<_, Vec<_>>::new());
    for groups in groups(&grid.cell_data) {
        for (quad, &number) in (0..).zip(numbers) {
            if let Some(name) = groups.set(number) {
                mesh.quad_sets.entry(name).or_default().push(quad);
            }
        }
        let others = grid.cells.iter().enumerate().filter(|(_, cell)| !matches!(cell, Cell::Quad(_)));
        for (number, cell) in others {
            let Some(name) = groups.set(number) else { continue };
            let lost = |what: String, help: &str| {
                Fault::new(
                    format!("{what} of cell {number}, of the group \"{}\",", name) + " is not in the mesh",
                    help,
                )
            };
            match cell {
                Cell::Quad(_) => {}
                Cell::Line(points) => {
                    for ends in points.windows(2) {
                        let help = "take lines that are no sides of quadrilaterals out of the file, or the integer arrays of its cells";
                        let side = || lost(format!("the line from point {} to {}", ends[0], ends[1]), help);
                        let (Some(a), Some(b)) = (local(ends[0]), local(ends[1])) else { return Err(side()) };
                        let edge = sorted([a, b]);
                        if !sides.contains(&edge) {
                            return Err(side());
                        }
                        edge_sets.entry(name.clone()).or_default().push(edge);
                    }
                }
                Cell::Vertices(points) => {
                    for &point in points {
                        let help = "take vertices that belong to no quadrilateral out of the file, or the integer arrays of its cells";
                        let node =
                            local(point).ok_or_else(|| lost(format!("the vertex at point {point}"), help))?;
                        node_sets.entry(name.clone()).or_default().push(node);
                    }
                }
            }
        }
    }
    mesh.edge_sets = edge_sets.into_iter().map(|(name, edges)| (name, distinct(edges))).collect();
    for (name, nodes) in node_sets {
        let set = mesh.node_sets.remove(&name).unwrap_or_default();
        mesh.node_sets.insert(name, distinct([set, nodes].concat()));
    }
    Ok(())
}

/// The items without repetition, each where it first stands.
fn distinct<T: Copy + Eq + std::hash::Hash>(items: Vec<T>) -> Vec<T> {
    let mut seen = HashSet::new();
    items.into_iter().filter(|item| seen.insert(*item)).collect()
}

/// Arrays on the points and quads of the mesh.
fn fields(grid: &Grid, used: &[u32], numbers: &[usize]) -> Fields {
    let mut out = Fields::default();
    let nodes: Vec<usize> = used.iter().map(|&point| point as usize).collect();
    let lists = [(&grid.point_data, &nodes[..], &mut out.nodes), (&grid.cell_data, numbers, &mut out.quads)];
    for (data, places, fields) in lists {
        for array in &data.arrays {
            if array.components == 1 {
                let all = array.numbers.reals();
                let values = places.iter().filter_map(|&place| all.get(place).copied()).collect();
                fields.insert(array.name.clone(), values);
            } else {
                out.vectors.insert(array.name.clone(), array.components);
            }
        }
    }
    out
}
