//! Linear buckling with nonlinear materials, about the reference configuration and beyond.

use std::f64::consts::PI;

use crate::common::{compile, on, plate, vector_load};
use tegula::analysis::{Silent, buckling};
use tegula::model::*;

const YOUNG: f64 = 3e6;

/// Slender column of a material with Young's modulus 3e6, clamped and free: π² EI/4L² within its shear flexibility and mesh.
fn factor(material: Material) -> f64 {
    let analysis = Analysis::Buckling(BucklingAnalysis::new(1));
    let mut m = Model::new(plate([1.0, 0.02], [64, 1], 0.0), analysis, Isotropic::new(1.0, 0.0, 1.0), 0.01);
    m.materials.insert("m".into(), material);
    m.sections[0].element = ElementKind::Cm;
    m.conditions = vec![Condition::Clamp(on("u_min"))];
    m.loads = vec![Load::Edge(vector_load("u_max", [-50.0, 0.0, 0.0]))];
    let (_, system) = compile(&m);
    buckling::run(&system, &BucklingAnalysis::new(1), &mut Silent).unwrap().modes[0].factor
}

/// The moduli at rest are those of linear elasticity, whatever happens at larger strains.
#[test]
fn rubber_and_yielding_columns_buckle_with_their_moduli_at_rest() {
    let expected = PI * PI * YOUNG * 0.02 * 1e-6 / 12.0 / 4.0;
    let rubber =
        NeoHookean { shear: YOUNG / 2.0, bulk: YOUNG / 3.0, density: 1.0, form: NeoHookeanForm::Split };
    let plastic = Plastic {
        young: YOUNG,
        poisson: 0.0,
        yield_stress: 1.0,
        hardening: 1e3,
        saturation: None,
        saturation_rate: 0.0,
        kinematic: 0.0,
        density: 1.0,
        expansion: 0.0,
    };
    for material in [Material::NeoHookean(rubber), Material::Plastic(plastic)] {
        let found = factor(material.clone());
        assert!((found / expected - 1.0).abs() < 1e-3, "{material:?} {found} {expected}");
    }
}
