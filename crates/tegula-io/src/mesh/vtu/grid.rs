//! Grid of a file: points, cells and arrays of all pieces.

use roxmltree::{Document, Node};

use super::Fault;
use super::arrays::{Numbers, Source, components, is_byte, is_numeric};
use super::cells::{self, Cell};
use super::document::{Parts, line, root, split};

/// Grid of a file.
#[derive(Debug, Default)]
pub(super) struct Grid {
    /// Coordinates of the points.
    pub points: Vec<[f64; 3]>,
    /// Cells, in the order of the file.
    pub cells: Vec<Cell>,
    /// Arrays of the points.
    pub point_data: Data,
    /// Arrays of the cells.
    pub cell_data: Data,
}

/// Arrays of the points or cells, in the order of the file.
#[derive(Debug, Default)]
pub(super) struct Data {
    pub arrays: Vec<Array>,
}

/// Array of the points or cells.
#[derive(Debug)]
pub(super) struct Array {
    pub name: String,
    pub components: usize,
    /// Numbers of an array of one component; those of others are not read.
    pub numbers: Numbers,
    /// True for integers of one byte, which may be truth values.
    pub is_byte: bool,
    /// True for numbers that tell points or cells from one another and are no groups.
    pub is_id: bool,
}

/// Grid of the bytes of a file.
pub(super) fn read(bytes: &[u8]) -> Result<Grid, Fault> {
    if bytes.starts_with(b"# vtk DataFile") {
        let help = "save it as a `.vtu` file, in ParaView or by `meshio convert`";
        return Err(Fault::new("this is a legacy file of VTK", help));
    }
    let Parts { text, appended } = split(bytes)?;
    let document = Document::parse(&text).map_err(|error| {
        Fault::new(format!("this is no VTU file, or a damaged one: {error}"), super::DAMAGED)
    })?;
    let (root, encoding) = root(&document)?;
    let source = Source { encoding, appended };
    let mut grid = Grid::default();
    let pieces = root.descendants().filter(|node| node.has_tag_name("Piece"));
    for piece in pieces {
        grid.add(piece, &source)?;
    }
    Ok(grid)
}

impl Grid {
    /// Adds a piece.
    fn add(&mut self, piece: Node<'_, '_>, source: &Source<'_>) -> Result<(), Fault> {
        let count = |name: &str| -> Result<usize, Fault> {
            let found = piece.attribute(name).and_then(|n| n.trim().parse().ok());
            found.ok_or_else(|| {
                Fault::damaged(format!("a piece has no `{name}` that is a number")).at_line(line(piece))
            })
        };
        let [points, cells] = [count("NumberOfPoints")?, count("NumberOfCells")?];
        if [points, cells] == [0, 0] {
            return Ok(());
        }
        let [points_before, cells_before] = [self.points.len(), self.cells.len()];
        self.add_points(piece, source, points)?;
        self.add_cells(piece, source, [points, cells])?;
        for (section, tuples, before) in
            [("PointData", points, points_before), ("CellData", cells, cells_before)]
        {
            let data = if section == "PointData" { &mut self.point_data } else { &mut self.cell_data };
            data.add(child(piece, section), source, [tuples, before])?;
        }
        Ok(())
    }

    fn add_points(&mut self, piece: Node<'_, '_>, source: &Source<'_>, points: usize) -> Result<(), Fault> {
        let array = child(piece, "Points").and_then(|section| child(section, "DataArray"));
        let array =
            array.ok_or_else(|| Fault::damaged("a piece has no array of its points").at_line(line(piece)))?;
        if components(array) != 3 {
            let message = format!("the points have {} coordinates, not 3", components(array));
            let help = "give three coordinates, the third one 0 for a plane mesh";
            return Err(Fault::new(message, help).at_line(line(array)));
        }
        let numbers = source.numbers(array, points)?;
        self.points.extend(numbers.reals().as_chunks::<3>().0);
        Ok(())
    }

    fn add_cells(
        &mut self,
        piece: Node<'_, '_>,
        source: &Source<'_>,
        [points, cells]: [usize; 2],
    ) -> Result<(), Fault> {
        let named = |name: &str| -> Result<Node<'_, '_>, Fault> {
            let mut arrays = child(piece, "Cells").into_iter().flat_map(|section| section.children());
            let found = arrays.find(|node| node.attribute("Name") == Some(name));
            found.ok_or_else(|| {
                Fault::damaged(format!("the cells have no array \"{name}\"")).at_line(line(piece))
            })
        };
        let whole = |name: &str, count: usize| -> Result<Vec<i64>, Fault> {
            let array = named(name)?;
            source.numbers(array, count)?.into_whole().ok_or_else(|| {
                Fault::damaged(format!("the array \"{name}\" has numbers that are no integers"))
                    .at_line(line(array))
            })
        };
        let kinds = whole("types", cells)?;
        let ends = whole("offsets", cells)?;
        let ends: Option<Vec<usize>> = ends.into_iter().map(|end| usize::try_from(end).ok()).collect();
        let ends = ends.filter(|ends| ends.is_sorted());
        let ends = ends.ok_or_else(|| Fault::damaged("the offsets of the cells do not ascend from 0"))?;
        let connectivity = whole("connectivity", ends.last().copied().unwrap_or(0))?;
        let before = self.points.len() - points;
        let mut begin = 0;
        let mut refused = Refused::default();
        for (kind, end) in kinds.into_iter().zip(ends) {
            let number = self.cells.len() + refused.count;
            let own = connectivity.get(begin..end).unwrap_or_default();
            begin = end;
            let place = |&point: &i64| {
                let inside = usize::try_from(point).ok().filter(|&point| point < points);
                inside.and_then(|point| u32::try_from(before + point).ok()).ok_or(point)
            };
            let nodes: Result<Vec<u32>, i64> = own.iter().map(place).collect();
            let nodes = nodes.map_err(|point| {
                Fault::damaged(format!("cell {number} has the point {point}, and there are {points} points"))
            })?;
            match cells::cell(kind, &nodes) {
                Some(cell) => self.cells.push(cell),
                None => refused.add(kind, nodes.len(), number),
            }
        }
        refused.fault().map_or(Ok(()), Err)
    }
}

/// Cells that cannot be computed.
#[derive(Default)]
struct Refused {
    count: usize,
    /// Type, points, and number of the first ones of their type.
    first: Vec<(i64, usize, usize)>,
}

impl Refused {
    fn add(&mut self, kind: i64, points: usize, number: usize) {
        self.count += 1;
        if !self.first.iter().any(|(known, ..)| *known == kind) && self.first.len() < 10 {
            self.first.push((kind, points, number));
        }
    }

    fn fault(&self) -> Option<Fault> {
        let &(kind, ..) = self.first.first()?;
        let shown = |&(kind, points, number): &(i64, usize, usize)| {
            let name = cells::name(kind).map_or(format!("cell of the type {kind}"), str::to_owned);
            format!("a {name} of {points} points (cell {number})")
        };
        let list: Vec<String> = self.first.iter().map(shown).collect();
        let message = format!(
            "{} of the cells are none that can be computed: {}; only quadrilaterals of 4 points are, and lines and vertices form sets",
            self.count,
            list.join(", ")
        );
        Some(Fault::new(message, cells::remedy(kind)))
    }
}

impl Data {
    /// Adds the arrays of a section of a piece with so many points or cells, behind those of earlier pieces.
    fn add(
        &mut self,
        section: Option<Node<'_, '_>>,
        source: &Source<'_>,
        [tuples, before]: [usize; 2],
    ) -> Result<(), Fault> {
        let ids = |section: Node<'_, '_>, name: &str| {
            ["GlobalIds", "PedigreeIds"].iter().any(|key| section.attribute(*key) == Some(name))
                || name.starts_with("vtk")
        };
        let arrays =
            section.into_iter().flat_map(|section| section.children().map(move |node| (section, node)));
        for (section, node) in arrays.filter(|(_, node)| node.has_tag_name("DataArray")) {
            let Some(name) = node.attribute("Name").filter(|_| is_numeric(node)) else { continue };
            let components = components(node);
            let numbers =
                if components == 1 { source.numbers(node, tuples)? } else { Numbers::Real(Vec::new()) };
            let known = self.arrays.iter_mut().find(|array| array.name == name);
            match known {
                None if before == 0 => {
                    let (name, is_byte, is_id) = (name.to_owned(), is_byte(node), ids(section, name));
                    self.arrays.push(Array { name, components, numbers, is_byte, is_id });
                }
                Some(array)
                    if array.components == components
                        && (components > 1 || array.numbers.len() == before) =>
                {
                    array.is_byte &= is_byte(node);
                    array.numbers.append(numbers);
                }
                _ => return Err(Self::uneven(name).at_line(line(node))),
            }
        }
        let missing = self.arrays.iter().find(|a| a.components == 1 && a.numbers.len() != before + tuples);
        missing.map_or(Ok(()), |array| Err(Self::uneven(&array.name)))
    }

    fn uneven(name: &str) -> Fault {
        let message = format!("the array \"{name}\" stands twice in a piece, or not in every piece");
        Fault::new(message, "give it once in each piece, or in none")
    }
}

fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    node.children().find(|child| child.has_tag_name(name))
}
