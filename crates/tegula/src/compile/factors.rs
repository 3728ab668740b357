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
