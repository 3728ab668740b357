//! Registry of the shell element types, by their names in model files.

use super::ancf_full::AncfFull;
use super::cm::CmShell;
use super::ems::EmsShell;
use super::mitc4::Mitc4;
use super::shell::ShellElement;
use super::solid_shell::SolidShell;
use crate::model::{ElementKind, Section};

impl ElementKind {
    /// Every element type; a new one is a file beside the others, a variant and a line here and in [`shell`].
    pub const ALL: [Self; 5] = [Self::Ems, Self::Cm, Self::Mitc4, Self::SolidShell, Self::AncfFull];
}

/// Element type of a section, with its locking remedies.
pub fn shell(section: &Section, thickness: f64) -> Box<dyn ShellElement> {
    shell_of(section, thickness, false)
}

/// Element type of a section whose materials are known; `rubber` is true if one of them is hyperelastic.
pub fn shell_of(section: &Section, thickness: f64, rubber: bool) -> Box<dyn ShellElement> {
    let Section { ans_shear, ans_thickness, .. } = *section;
    let membrane = section.membrane_part();
    let continuum = CmShell {
        ans_shear,
        ans_thickness,
        membrane,
        thickness_parameters: usize::from(section.thickness_eas),
        thickness,
        rubber,
    };
    match section.element {
        ElementKind::Ems => Box::new(EmsShell { ans_shear, ans_thickness, membrane }),
        ElementKind::Cm => Box::new(continuum),
        ElementKind::Mitc4 => Box::new(Mitc4 { ans_shear, membrane }),
        ElementKind::SolidShell => Box::new(SolidShell(continuum)),
        ElementKind::AncfFull => Box::new(AncfFull { thickness }),
    }
}
