//! Elements of a section, by the registry of element types in `crates/tegula/src/model/element_kind.rs`.

use super::shell::ShellElement;
use crate::model::{ElementKind, Section, element_types};

/// Element type that is made from the keys of a section.
pub(super) trait FromSection: ShellElement + Sized {
    /// Element with the locking remedies of a section of the given thickness (length); `rubber` is true if one of its
    /// materials is hyperelastic.
    fn from_section(section: &Section, thickness: f64, rubber: bool) -> Self;
}

macro_rules! dispatch {
    ($($file:ident::$type:ident as $kind:ident: $help:literal,)*) => {
        /// Element type of a section whose materials are known; `rubber` is true if one of them is hyperelastic.
        pub fn shell_of(section: &Section, thickness: f64, rubber: bool) -> Box<dyn ShellElement> {
            match section.element {
                $(ElementKind::$kind => {
                    Box::new(super::$file::$type::from_section(section, thickness, rubber))
                })*
            }
        }
    };
}
element_types!(dispatch);

/// Element type of a section, with its locking remedies.
pub fn shell(section: &Section, thickness: f64) -> Box<dyn ShellElement> {
    shell_of(section, thickness, false)
}

impl ElementKind {
    /// Word of the model file.
    pub fn name(self) -> &'static str {
        shell(&Section { element: self, ..Section::new("", 1.0) }, 1.0).name()
    }
}
