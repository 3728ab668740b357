//! Distributions on a mesh: values of formulas and fields at nodes, and their integrals over edges and elements.

use super::adaptive_integrals::{Integral, WithoutIntegral, over_edges, over_elements};
use crate::Vec3;
use crate::load::PlaceFormula;
use crate::mesh::{FieldValues, Mesh};
use crate::model::Distribution;

/// Factors of a distribution on a mesh.
pub(super) enum Factors<'a> {
    /// Formula of the place.
    Formula(PlaceFormula),
    /// Field; values of nodes are interpolated as positions are.
    Field(FieldValues<'a>),
}

impl<'a> Factors<'a> {
    /// Factors of a distribution; `None` where it is wrong, which the checks report.
    pub(super) fn of(distribution: &Distribution, mesh: &'a Mesh) -> Option<Self> {
        Some(match distribution {
            Distribution::Formula(text) => Self::Formula(PlaceFormula::read(text).ok()?),
            Distribution::Field(name) => Self::Field(mesh.field(&name.field).ok()?),
        })
    }

    /// Values for each quad; `None` where the factor varies within them.
    pub(super) fn by_quad(&self) -> Option<&'a [f64]> {
        if let Self::Field(FieldValues::Quads(values)) = self { Some(values) } else { None }
    }

    /// Value at a node; `None` for fields of quads.
    pub(super) fn at_node(&self, mesh: &Mesh, node: u32) -> Option<f64> {
        match self {
            Self::Formula(formula) => Some(formula.value(mesh.positions.get(node as usize)?)),
            Self::Field(FieldValues::Nodes(values)) => values.get(node as usize).copied(),
            Self::Field(FieldValues::Quads(_)) => None,
        }
    }

    /// Integrals of the shape functions of edges, given by their nodes, times the factor.
    pub(super) fn over_edges(
        &self,
        mesh: &Mesh,
        edges: &[[u32; 2]],
    ) -> Result<Vec<Integral<2>>, WithoutIntegral> {
        let places: Vec<[Vec3; 2]> = edges.iter().map(|nodes| places(mesh, nodes)).collect();
        if let Self::Formula(formula) = self {
            return over_edges(&places, |at| formula.value(&at.place));
        }
        let values: Vec<[f64; 2]> = edges.iter().map(|nodes| self.at_nodes(mesh, nodes)).collect();
        over_edges(&places, |at| interpolated(&values[at.body], &at.shapes))
    }

    /// Integrals of the shape functions of elements, given by their nodes, times the factor, which is no field of quads.
    pub(super) fn over_elements(
        &self,
        mesh: &Mesh,
        elements: &[[u32; 4]],
    ) -> Result<Vec<Integral<4>>, WithoutIntegral> {
        let places: Vec<[Vec3; 4]> = elements.iter().map(|nodes| places(mesh, nodes)).collect();
        if let Self::Formula(formula) = self {
            return over_elements(&places, |at| formula.value(&at.place));
        }
        let values: Vec<[f64; 4]> = elements.iter().map(|nodes| self.at_nodes(mesh, nodes)).collect();
        over_elements(&places, |at| interpolated(&values[at.body], &at.shapes))
    }

    fn at_nodes<const N: usize>(&self, mesh: &Mesh, nodes: &[u32; N]) -> [f64; N] {
        nodes.map(|node| self.at_node(mesh, node).unwrap_or(f64::NAN))
    }
}

fn places<const N: usize>(mesh: &Mesh, nodes: &[u32; N]) -> [Vec3; N] {
    nodes.map(|node| mesh.positions[node as usize])
}

fn interpolated<const N: usize>(values: &[f64; N], shapes: &[f64; N]) -> f64 {
    values.iter().zip(shapes).map(|(value, shape)| value * shape).sum()
}

/// Means over elements of a distribution, which has been checked; 1 without one.
pub(super) fn means(distribution: Option<&Distribution>, mesh: &Mesh, quads: &[u32]) -> Vec<f64> {
    let Some(factors) = distribution.and_then(|distribution| Factors::of(distribution, mesh)) else {
        return vec![1.0; quads.len()];
    };
    if let Some(values) = factors.by_quad() {
        return quads.iter().map(|&quad| values.get(quad as usize).copied().unwrap_or(f64::NAN)).collect();
    }
    let elements: Vec<[u32; 4]> = quads.iter().map(|&quad| mesh.quads[quad as usize]).collect();
    let integrals = factors.over_elements(mesh, &elements).unwrap_or_default();
    integrals.iter().map(Integral::mean).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::mesh::generators::generate;
    use crate::model::{Grid, MeshSource, PlateMesh};

    /// A warped mesh of distorted elements with the field `f` = 2 + x − 3y + z at its nodes, a linear function, which the interpolation of positions keeps.
    fn warped() -> Mesh {
        let grid = Grid { distortion: 0.3, ..Grid::uniform(4, 3) };
        let mut mesh =
            generate(&MeshSource::Plate(PlateMesh { grid, ..PlateMesh::new([1.0, 2.0], [4, 3]) })).unwrap();
        mesh.positions.iter_mut().for_each(|x| x.z = 0.3 * x.x * x.y);
        let values = mesh.positions.iter().map(|x| 2.0 + x.x - 3.0 * x.y + x.z).collect();
        mesh.fields.nodes.insert("f".into(), values);
        mesh.fields.quads.insert("number".into(), (0..mesh.quads.len()).map(|q| q as f64).collect());
        mesh
    }

    #[test]
    fn a_field_of_a_linear_function_has_the_integrals_of_its_formula() {
        let mesh = warped();
        let [field, formula] = [Distribution::of_field("f"), "2 + x - 3*y + z".into()];
        let [field, formula] =
            [&field, &formula].map(|distribution| Factors::of(distribution, &mesh).unwrap());
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-13, "{a} {b}");
        for node in 0..mesh.positions.len() as u32 {
            near(field.at_node(&mesh, node).unwrap(), formula.at_node(&mesh, node).unwrap());
        }
        let [a, b] = [&field, &formula].map(|factors| factors.over_elements(&mesh, &mesh.quads).unwrap());
        for (a, b) in a.iter().zip(&b) {
            (0..4).for_each(|i| near(a.nodal[i], b.nodal[i]));
        }
        let edges = mesh.edges_on("all").unwrap();
        let [a, b] = [&field, &formula].map(|factors| factors.over_edges(&mesh, &edges).unwrap());
        assert_eq!(a.len(), 14);
        for (a, b) in a.iter().zip(&b) {
            (0..2).for_each(|i| near(a.nodal[i], b.nodal[i]));
        }
    }

    #[test]
    fn a_field_of_cells_has_its_values_bit_by_bit() {
        let mesh = warped();
        let number = Distribution::of_field("number");
        assert_eq!(means(Some(&number), &mesh, &[7, 0, 11]), [7.0, 0.0, 11.0]);
        assert_eq!(means(None, &mesh, &[7, 0]), [1.0; 2]);
        let factors = Factors::of(&number, &mesh).unwrap();
        assert_eq!((factors.at_node(&mesh, 0), factors.by_quad().map(<[f64]>::len)), (None, Some(12)));
        assert!(Factors::of(&Distribution::of_field("none"), &mesh).is_none());
    }
}
