//! Check of the values of materials.

use super::checker::Checker;
use crate::Issue;
use crate::model::Material;

/// Mistakes in the values of a material.
pub fn issues(material: &Material, key: &str) -> Vec<Issue> {
    let mut c = Checker::default();
    let poisson = |c: &mut Checker, nu: f64| {
        if !(nu > -1.0 && nu < 0.5) {
            c.add(
                format!("{key}.poisson"),
                format!("Poisson's ratio is {nu}; it must be above -1 and below 0.5"),
                "at 0.5 a material is incompressible and plane stress has no limit here; use 0.49 or less",
            );
        }
    };
    match material {
        Material::Isotropic(m) => {
            c.positive(&format!("{key}.young"), "Young's modulus", m.young);
            poisson(&mut c, m.poisson);
        }
        Material::Orthotropic(m) => {
            for (name, values) in [("young", m.young), ("shear", m.shear)] {
                for (i, v) in values.into_iter().enumerate() {
                    c.positive(&format!("{key}.{name}[{i}]"), "the modulus", v);
                }
            }
            c.finite(&format!("{key}.poisson"), "Poisson's ratio", &m.poisson);
            if c.issues.is_empty() && !m.constants().is_stable() {
                c.add(
                    format!("{key}.poisson"),
                    "the compliance is not positive definite: the constants contradict each other",
                    "|ν_ij| must be below √(E_i/E_j); ν_ij belongs to stress along axis i",
                );
            }
        }
        Material::NeoHookean(m) => {
            c.positive(&format!("{key}.shear"), "the shear modulus", m.shear);
            c.positive(&format!("{key}.bulk"), "the bulk modulus", m.bulk);
        }
        Material::MooneyRivlin(m) => {
            c.finite(&format!("{key}.c01"), "the constant", &[m.c01]);
            c.positive(&format!("{key}.c10"), "c10 + c01", m.c10 + m.c01);
            c.positive(&format!("{key}.bulk"), "the bulk modulus", m.bulk);
        }
        Material::Plastic(m) => {
            c.positive(&format!("{key}.young"), "Young's modulus", m.young);
            poisson(&mut c, m.poisson);
            c.positive(&format!("{key}.yield_stress"), "the yield stress", m.yield_stress);
            for (name, v) in [
                ("hardening", m.hardening),
                ("saturation_rate", m.saturation_rate),
                ("kinematic", m.kinematic),
            ] {
                c.not_negative(&format!("{key}.{name}"), &format!("`{name}`"), v);
            }
            if m.saturation.is_some_and(|s| s.is_nan() || s < m.yield_stress) {
                c.add(
                    format!("{key}.saturation"),
                    "the saturation stress is below the yield stress: softening has no unique solution",
                    "give a stress of at least `yield_stress`",
                );
            }
        }
    }
    c.not_negative(&format!("{key}.density"), "the density", material.density());
    c.finite(&format!("{key}.expansion"), "the thermal expansion", &material.expansion());
    if let Some(s) = material.strength() {
        for (name, mistake) in s.mistakes() {
            c.add(format!("{key}.strength.{name}"), mistake, "give the strength in the units of a stress");
        }
    }
    c.issues
}
