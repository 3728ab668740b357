//! The eight-node solid shell: positions at the bottom and at the top only.
//!
//! Its nodes lie at `x = r ± (h/2) d` over the nodes of the mid-surface. The program stores `r` and `d` instead of the
//! two positions: the same unknowns in another basis, in which a solid shell shares its edges with every other shell,
//! and all loads, supports and results apply to it. The trilinear interpolation of the eight nodes is `x = r + z d`,
//! the kinematics of [`super::cm`]. With transverse shear assumed from the middle of the edges (S. Klinkel, F.
//! Gruttmann, W. Wagner, *A robust non-linear solid shell element based on a mixed variational formulation*, Int. J.
//! Numer. Meth. Engng 65 (2006) 1363–1378), thickness strain from the corners (P. Betsch, E. Stein, Commun. Numer.
//! Meth. Engng 11 (1995) 899–909), four enhanced parameters in the plane and up to four over the thickness, it is the
//! eight-node solid shell of other programs, and equivalent to the continuum-mechanics shell: independent programs of
//! the two print the same digits for thick plates.

use super::cm::{CmShell, SAMPLES, SAMPLES_WITHOUT_ANS_SHEAR};
use super::geometry::ShellGeometry;
use super::registry::FromSection;
use super::shell::{GroupBuilder, GroupSetup, QuadraticBuilder, ShellElement, StrainOperator};
use crate::model::Section;
use crate::section::SectionInertia;

/// Eight-node solid shell, implemented by the equivalent continuum-mechanics shell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolidShell(pub CmShell);

impl FromSection for SolidShell {
    fn from_section(section: &Section, thickness: f64, rubber: bool) -> Self {
        Self(CmShell::from_section(section, thickness, rubber))
    }
}

impl ShellElement for SolidShell {
    fn name(&self) -> &'static str {
        "solid-shell"
    }

    fn samples(&self) -> usize {
        self.0.samples()
    }

    fn parameters(&self) -> usize {
        self.0.parameters()
    }

    fn without_enhanced_strains(&self) -> Option<Box<dyn ShellElement>> {
        self.0.without_enhanced_strains()
    }

    fn is_solid(&self) -> bool {
        true
    }

    fn operator(&self, g: &ShellGeometry, point: usize, z: f64) -> Result<StrainOperator, String> {
        self.0.operator(g, point, z)
    }

    fn parameter_stiffness(&self, g: &ShellGeometry) -> Vec<f64> {
        self.0.parameter_stiffness(g)
    }

    fn mass(&self, g: &ShellGeometry, inertia: &SectionInertia) -> Vec<f64> {
        self.0.mass(g, inertia)
    }

    fn builder(&self, setup: GroupSetup) -> Box<dyn GroupBuilder> {
        let a = self.parameters();
        if self.0.ans_shear {
            Box::new(QuadraticBuilder::new("solid-shell", self.0.strains::<SAMPLES>(), a, setup))
        } else {
            let strains = self.0.strains::<SAMPLES_WITHOUT_ANS_SHEAR>();
            Box::new(QuadraticBuilder::new("solid-shell", strains, a, setup))
        }
    }
}
