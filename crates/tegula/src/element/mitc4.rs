//! Bilinear shell with assumed natural transverse shear and inextensible directors (MITC4), the element of most shell
//! programs.
//!
//! E. N. Dvorkin, K.-J. Bathe, *A continuum mechanics based four-node shell element for general
//! non-linear analysis*, Eng. Comput. 1 (1984) 77–88. Its strains are those of the elastic-middle-surface
//! element ([`super::ems`]) without the stretch of the director; `d·d = 1` is met exactly at the nodes,
//! where a director has two unknowns and is updated along the great circle. In-plane enhanced strains
//! (J. C. Simo, M. S. Rifai, Int. J. Numer. Meth. Engng 29 (1990) 1595–1638) are optional.

use nalgebra::DMatrix;

use super::curved_strain::ReferenceMetric;
use super::ems::EmsShell;
use super::geometry::ShellGeometry;
use super::membrane::Membrane;
use super::registry::FromSection;
use super::shell::{GroupBuilder, GroupSetup, QuadraticBuilder, ShellElement, StrainOperator};
use crate::model::Section;
use crate::section::SectionInertia;

/// Number of sampled strains with assumed natural transverse shear.
const SAMPLES: usize = 20;
/// Number of sampled strains without assumed natural transverse shear.
const SAMPLES_WITHOUT_ANS_SHEAR: usize = 24;

/// MITC4 shell element with its locking remedies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mitc4 {
    /// Assumed natural strain for transverse shear.
    pub ans_shear: bool,
    /// Membrane formulation.
    pub membrane: Membrane,
    /// Height of the middle of the layers above the nodes, along the directors (length).
    pub offset: f64,
}

impl Mitc4 {
    /// Element with extensible directors that supplies the strains; its sampled thickness strains come last and are
    /// omitted here.
    fn extensible(&self) -> EmsShell {
        let Self { ans_shear, membrane, offset } = *self;
        EmsShell { ans_shear, ans_thickness: true, membrane, offset }
    }
}

impl FromSection for Mitc4 {
    fn from_section(section: &Section, _: f64, _: bool) -> Self {
        Self { ans_shear: section.ans_shear, membrane: section.membrane_part(), offset: section.offset() }
    }
}

impl ShellElement for Mitc4 {
    fn name(&self) -> &'static str {
        "mitc4"
    }

    fn samples(&self) -> usize {
        if self.ans_shear { SAMPLES } else { SAMPLES_WITHOUT_ANS_SHEAR }
    }

    fn parameters(&self) -> usize {
        self.membrane.parameters()
    }

    fn without_enhanced_strains(&self) -> Option<Box<dyn ShellElement>> {
        (self.membrane.parameters() > 0).then(|| -> Box<dyn ShellElement> {
            Box::new(Self { membrane: Membrane::Displacement, ..*self })
        })
    }

    fn is_solid(&self) -> bool {
        false
    }

    fn unit_directors(&self) -> bool {
        true
    }

    fn operator(&self, g: &ShellGeometry, point: usize, z: f64) -> Result<StrainOperator, String> {
        let mut operator = self.extensible().operator(g, point, z)?;
        let samples: DMatrix<f64> = operator.samples.columns(0, self.samples()).into_owned();
        operator.samples = samples;
        Ok(operator)
    }

    fn reference_metric(&self, g: &ShellGeometry, point: usize) -> Result<Option<ReferenceMetric>, String> {
        self.extensible().reference_metric(g, point)
    }

    fn mass(&self, g: &ShellGeometry, inertia: &SectionInertia) -> Vec<f64> {
        self.extensible().mass(g, inertia)
    }

    fn builder(&self, setup: GroupSetup) -> Box<dyn GroupBuilder> {
        let a = self.parameters();
        let element = self.extensible();
        if self.ans_shear {
            Box::new(QuadraticBuilder::new("mitc4", element.strains::<SAMPLES>(), a, setup))
        } else {
            Box::new(QuadraticBuilder::new("mitc4", element.strains::<SAMPLES_WITHOUT_ANS_SHEAR>(), a, setup))
        }
    }
}
