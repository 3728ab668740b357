//! The locking study: elements with a remedy switched off, on problems whose deflections are known.
//!
//! An element *locks* if it cannot represent a deformation without spurious strains: strains that should vanish do
//! not, and the element is far too stiff, the more so the thinner it is. Every remedy of an element cures one such
//! defect. Here each remedy is switched off separately, on examples that require it, and the linear deflection is
//! compared with the exact one.

mod examples;
mod report;

use tegula::Result;
use tegula::element::registry;
use tegula::model::{ElementKind, Section};

pub use examples::Example;
pub use report::{csv, markdown, picture};

/// Locking remedy that an element can do without.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Remedy {
    /// Nothing is switched off.
    All,
    /// Assumed natural strain for the transverse shear.
    AnsShear,
    /// Assumed natural strain for the thickness stretch.
    AnsThickness,
    /// Enhanced assumed strain in the plane.
    Eas,
    /// Enhanced assumed strain over the thickness.
    ThicknessEas,
}

impl Remedy {
    /// All of them.
    pub const EVERY: [Self; 5] =
        [Self::All, Self::AnsShear, Self::AnsThickness, Self::Eas, Self::ThicknessEas];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::All => "nothing",
            Self::AnsShear => "ans-shear",
            Self::AnsThickness => "ans-thickness",
            Self::Eas => "eas",
            Self::ThicknessEas => "thickness-eas",
        }
    }

    /// Title for tables and pictures.
    pub fn title(self) -> &'static str {
        match self {
            Self::All => "all remedies",
            Self::AnsShear => "no ANS shear",
            Self::AnsThickness => "no ANS thickness",
            Self::Eas => "no EAS in plane",
            Self::ThicknessEas => "no EAS over thickness",
        }
    }

    /// True if the element has this remedy: it is another one without it.
    pub fn belongs_to(self, element: ElementKind) -> bool {
        let with = Section { element, ..Section::new("", 1.0) };
        let mut without = with.clone();
        self.leave_out(&mut without);
        let made = |section: &Section| format!("{:?}", registry::shell(section, 1.0));
        self == Self::All || made(&with) != made(&without)
    }

    /// Switches it off.
    fn leave_out(self, section: &mut Section) {
        match self {
            Self::All => {}
            Self::AnsShear => section.ans_shear = false,
            Self::AnsThickness => section.ans_thickness = false,
            Self::Eas => section.eas = false,
            Self::ThicknessEas => section.thickness_eas = 0,
        }
    }
}

/// Parameters of a study.
#[derive(Debug, Clone)]
pub struct Study {
    /// Problems.
    pub examples: Vec<Example>,
    /// Elements.
    pub elements: Vec<ElementKind>,
    /// Remedies that are left out, one at a time.
    pub without: Vec<Remedy>,
    /// Length or radius over thickness (over depth for the beam).
    pub slenderness: Vec<u32>,
    /// Elements along a side.
    pub meshes: Vec<u32>,
}

/// One computed deflection.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Problem.
    pub example: Example,
    /// Element.
    pub element: ElementKind,
    /// Remedy that was switched off.
    pub without: Remedy,
    /// Length over thickness.
    pub slenderness: u32,
    /// Elements along a side.
    pub mesh: u32,
    /// Deflection over the exact one.
    pub ratio: f64,
}

impl Study {
    /// Computes all combinations; `progress` gets every row.
    ///
    /// # Errors
    /// A model that cannot be computed.
    pub fn run(&self, progress: &mut dyn FnMut(&Row)) -> Result<Vec<Row>> {
        let mut rows = Vec::new();
        for &element in &self.elements {
            for &without in self.without.iter().filter(|r| r.belongs_to(element)) {
                for &example in &self.examples {
                    for &slenderness in &self.slenderness {
                        for &mesh in &self.meshes {
                            let ratio = example.ratio(slenderness, mesh, &|section| {
                                section.element = element;
                                without.leave_out(section);
                            })?;
                            let row = Row { example, element, without, slenderness, mesh, ratio };
                            progress(&row);
                            rows.push(row);
                        }
                    }
                }
            }
        }
        Ok(rows)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn ratio(example: Example, element: ElementKind, without: Remedy, slenderness: u32, mesh: u32) -> f64 {
        let study = Study {
            examples: vec![example],
            elements: vec![element],
            without: vec![without],
            slenderness: vec![slenderness],
            meshes: vec![mesh],
        };
        study.run(&mut |_| {}).unwrap()[0].ratio
    }

    #[test]
    fn with_all_remedies_nothing_locks() {
        for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm, ElementKind::SolidShell] {
            for example in Example::EVERY {
                for slenderness in [10, 100, 1000] {
                    let found = ratio(example, element, Remedy::All, slenderness, 16);
                    assert!((found - 1.0).abs() < 0.02, "{example:?} {element:?} {slenderness}: {found}");
                }
            }
        }
    }

    #[test]
    fn every_missing_remedy_locks_somewhere() {
        use ElementKind::{Cm, Ems};
        // Shear: next to nothing moves.
        assert!(ratio(Example::Plate, Ems, Remedy::AnsShear, 1000, 16) < 0.01);
        // Poisson's ratio: bending without change of thickness is stiffer by (1 − ν)²/(1 − 2ν) = 1.225 in a cylinder,
        // 0.816 of the deflection; the plate also bends across, which gives 0.84.
        let poisson = ratio(Example::Plate, Cm, Remedy::ThicknessEas, 1000, 32);
        assert!((0.816..0.86).contains(&poisson), "{poisson}");
        // Curvature: the thickness stretches where it should not.
        assert!(ratio(Example::Arch, Ems, Remedy::AnsThickness, 1000, 8) < 0.25);
        // Bending in the plane of a thin strip of one element.
        assert!(ratio(Example::Beam, Ems, Remedy::Eas, 100, 16) < 0.2);
    }
}
