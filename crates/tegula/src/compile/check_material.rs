//! Check of the values of materials.

use crate::Issue;
use crate::checker::Checker;
use crate::model::Material;

/// Mistakes in the values of a material.
pub fn issues(material: &Material, key: &str) -> Vec<Issue> {
    let mut c = Checker::default();
    material.check(key, &mut c);
    c.not_negative(&format!("{key}.density"), "the density", material.density());
    c.finite(&format!("{key}.expansion"), "the thermal expansion", &material.expansion());
    if let Some(s) = material.strength() {
        for (name, mistake) in s.mistakes() {
            c.add(format!("{key}.strength.{name}"), mistake, "give the strength in the units of a stress");
        }
    }
    c.issues
}
