//! Places and directions of single elements.

use super::Mesh;
use super::facet::Facet;
use crate::Vec3;

impl Mesh {
    /// Mean of the nodes of a quad (length); `None` if an index is out of range.
    pub fn centre(&self, quad: u32) -> Option<Vec3> {
        Some(self.facet(quad)?.center())
    }

    /// Unit normal in the centre of a quad, on the side of the director; `None` if an index is out of range or the quad has no area.
    pub fn normal(&self, quad: u32) -> Option<Vec3> {
        self.facet(quad)?.area_vector().try_normalize(0.0)
    }

    /// Sides of a quad, each from one corner to the next; none if the index is out of range.
    pub(crate) fn sides(&self, quad: u32) -> impl Iterator<Item = [u32; 2]> {
        let corners = self.quads.get(quad as usize).copied();
        corners.into_iter().flat_map(|quad| (0..4).map(move |i| [quad[i], quad[(i + 1) % 4]]))
    }

    fn facet(&self, quad: u32) -> Option<Facet> {
        Facet::of(self, self.quads.get(quad as usize)?)
    }
}
