//! Constants of materials in the model file: ranges, contradictions, words.

use tegula::material::NeoHookeanForm;
use tegula::model::*;

/// The keys of a material that its check refuses.
fn refused(material: Material) -> Vec<String> {
    tegula::compile::check::material(&material, "m").into_iter().map(|i| i.place.to_string()).collect()
}

/// Every constant at the end of its range and just within it: both Young's moduli and shear moduli are above 0, Poisson's
/// ratio is between −1 and ½, where the shear and the bulk modulus would be infinite.
#[test]
fn constants_at_the_end_of_their_range_are_refused() {
    let isotropic = |young, poisson| Material::Isotropic(Isotropic::new(young, poisson, 1.0));
    let plastic = |poisson| Plastic {
        young: 1e5,
        poisson,
        yield_stress: 100.0,
        hardening: 0.0,
        saturation: None,
        saturation_rate: 0.0,
        kinematic: 0.0,
        density: 0.0,
        expansion: 0.0,
    };
    for nu in [0.5, -1.0, 0.7, f64::NAN, f64::INFINITY] {
        assert_eq!(refused(isotropic(1e5, nu)), ["m.poisson"], "{nu}");
        assert_eq!(refused(Material::Plastic(plastic(nu))), ["m.poisson"], "{nu}");
    }
    for nu in [0.4999, 0.0, -0.9999] {
        assert_eq!(refused(isotropic(1e5, nu)), [""; 0], "{nu}");
        assert_eq!(refused(Material::Plastic(plastic(nu))), [""; 0], "{nu}");
    }
    for young in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(refused(isotropic(young, 0.3)), ["m.young"], "{young}");
        assert_eq!(refused(Material::Plastic(Plastic { young, ..plastic(0.3) })), ["m.young"], "{young}");
    }
    let message = &tegula::compile::check::material(&isotropic(1e5, 0.5), "m")[0];
    assert!(message.message.contains("0.5") && message.help.contains("incompressible"), "{message:?}");
    for density in [-1e-9, f64::NAN] {
        let m = Material::Isotropic(Isotropic::new(1.0, 0.3, density));
        assert_eq!(refused(m), ["m.density"], "{density}");
    }
}

#[test]
fn constants_of_plastic_materials_at_the_end_of_their_range_are_refused() {
    let good = Plastic {
        young: 1e5,
        poisson: 0.3,
        yield_stress: 100.0,
        hardening: 0.0,
        saturation: Some(100.0),
        saturation_rate: 0.0,
        kinematic: 0.0,
        density: 0.0,
        expansion: 0.0,
    };
    assert_eq!(refused(Material::Plastic(good.clone())), [""; 0]);
    let negative = -1e-9;
    for (key, wrong) in [
        ("m.yield_stress", Plastic { yield_stress: 0.0, saturation: None, ..good.clone() }),
        ("m.hardening", Plastic { hardening: negative, ..good.clone() }),
        ("m.saturation", Plastic { saturation: Some(99.999), ..good.clone() }),
        ("m.saturation", Plastic { saturation: Some(f64::NAN), ..good.clone() }),
        ("m.saturation_rate", Plastic { saturation_rate: negative, ..good.clone() }),
        ("m.kinematic", Plastic { kinematic: negative, ..good.clone() }),
        ("m.expansion", Plastic { expansion: f64::NAN, ..good }),
    ] {
        assert_eq!(refused(Material::Plastic(wrong)), [key]);
    }
}

#[test]
fn constants_of_rubber_at_the_end_of_their_range_are_refused() {
    let neo = NeoHookean { shear: 1.0, bulk: 1e-9, density: 0.0, form: NeoHookeanForm::Split };
    assert_eq!(refused(Material::NeoHookean(neo.clone())), [""; 0]);
    assert_eq!(refused(Material::NeoHookean(NeoHookean { shear: 0.0, ..neo.clone() })), ["m.shear"]);
    assert_eq!(refused(Material::NeoHookean(NeoHookean { bulk: 0.0, ..neo })), ["m.bulk"]);
    let rivlin = MooneyRivlin { c10: 1.0, c01: -0.999, bulk: 1.0, density: 0.0 };
    assert_eq!(refused(Material::MooneyRivlin(rivlin.clone())), [""; 0]);
    assert_eq!(refused(Material::MooneyRivlin(MooneyRivlin { c01: -1.0, ..rivlin.clone() })), ["m.c10"]);
    assert_eq!(refused(Material::MooneyRivlin(MooneyRivlin { bulk: 0.0, ..rivlin })), ["m.bulk"]);
}

/// R. M. Jones, *Mechanics of Composite Materials*, 2nd ed., Sect. 2.4: every |ν_ij| is below √(E_i/E_j), and
/// 1 − ν12 ν21 − ν23 ν32 − ν13 ν31 − 2 ν21 ν32 ν13 is above 0.
#[test]
fn orthotropic_constants_at_the_end_of_their_range_are_refused() {
    let with = |young: [f64; 3], poisson: [f64; 3], shear: [f64; 3]| {
        let (density, expansion, strength) = (0.0, [0.0; 3], None);
        refused(Material::Orthotropic(Orthotropic { young, poisson, shear, density, expansion, strength }))
    };
    let (young, shear) = ([140.0, 10.0, 9.0], [5.0, 4.5, 3.5]);
    for i in 0..3 {
        let mut wrong = shear;
        wrong[i] = 0.0;
        assert_eq!(with(young, [0.3; 3], wrong), [format!("m.shear[{i}]")]);
        let mut wrong = young;
        wrong[i] = 0.0;
        assert_eq!(with(wrong, [0.3; 3], shear), [format!("m.young[{i}]")]);
        // One ratio alone: the limit is √(E_i/E_j).
        let (a, b) = [(0, 1), (0, 2), (1, 2)][i];
        let mut poisson = [0.0; 3];
        for (part, refuses) in [(1.0, true), (-1.0, true), (0.9999, false), (-0.9999, false)] {
            poisson[i] = part * (young[a] / young[b]).sqrt();
            assert_eq!(!with(young, poisson, shear).is_empty(), refuses, "{poisson:?}");
        }
    }
    // All equal, the material is isotropic: the limit is ½.
    for (nu, refuses) in [(0.5, true), (0.4999, false), (-1.0, true), (-0.9999, false)] {
        assert_eq!(!with([1.0; 3], [nu; 3], [1.0; 3]).is_empty(), refuses, "{nu}");
    }
}

/// A strength is a positive number, and the Tsai–Wu surface is closed for |F12*| < 1 only (Tsai and Wu 1971, eq. 11).
#[test]
fn strengths_at_the_end_of_their_range_are_refused() {
    let good = Strengths::new(1500.0, 1200.0, 50.0, 250.0, 70.0);
    assert_eq!(good.mistakes(), []);
    let keys = |s: Strengths| s.mistakes().iter().map(|m| m.0).collect::<Vec<_>>();
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(keys(Strengths { xt: bad, ..good }), ["xt"], "{bad}");
        assert_eq!(keys(Strengths { xc: bad, ..good }), ["xc"], "{bad}");
        assert_eq!(keys(Strengths { yt: bad, ..good }), ["yt"], "{bad}");
        assert_eq!(keys(Strengths { yc: bad, ..good }), ["yc"], "{bad}");
        assert_eq!(keys(Strengths { s12: bad, ..good }), ["s12"], "{bad}");
    }
    for (interaction, refused) in
        [(-1.0, true), (1.0, true), (f64::NAN, true), (-0.999, false), (0.999, false)]
    {
        let found = keys(Strengths { tsai_wu_interaction: interaction, ..good });
        assert_eq!(!found.is_empty(), refused, "{interaction}");
    }
    // The usual interaction, F12* = −1/2, also where the model file does not give one.
    assert_eq!(good.tsai_wu_interaction, -0.5);
    let read = serde_json::json!({ "xt": 1500.0, "xc": 1200.0, "yt": 50.0, "yc": 250.0, "s12": 70.0 });
    assert_eq!(serde_json::from_value::<Strengths>(read).unwrap(), good);
}
