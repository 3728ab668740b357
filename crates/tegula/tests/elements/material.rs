//! Contract of every material law, and each law against closed forms.

use std::sync::Arc;

use crate::common::{Random, rotation};
use nalgebra::{Matrix2, Matrix3, Matrix6, Vector6};
use tegula::material::linear::{Orthotropy, isotropic, isotropic_plane_stress};
use tegula::material::{
    Hyperelastic, Law, MaterialLaw, NeoHookeanForm, OwnLaw, PlaneStressPlasticity, Plasticity,
};
use tegula::model::{ElementKind, Material, MooneyRivlin, NeoHookean};
use tegula::norm::{larger, max_norm};

const STEEL: Plasticity = Plasticity {
    young: 2e5,
    poisson: 0.3,
    yield_stress: 250.0,
    hardening: 1000.0,
    saturation: 400.0,
    rate: 30.0,
    kinematic: 2000.0,
};

/// Laws of all registered materials, and more of their forms.
fn laws() -> Vec<(Law, f64)> {
    let orthotropy =
        Orthotropy { young: [140.0, 10.0, 9.0], poisson: [0.3, 0.28, 0.4], shear: [5.0, 4.5, 3.5] };
    let mut laws = vec![
        (Law::Linear(Box::new(isotropic(7.0, 0.3))), 0.2),
        (Law::Linear(Box::new(orthotropy.stiffness())), 0.2),
        (Law::Hyperelastic(Hyperelastic::Split { c10: 0.4, c01: 0.0, bulk: 3.0 }), 0.2),
        (Law::Hyperelastic(Hyperelastic::Split { c10: 0.4, c01: 0.15, bulk: 900.0 }), 0.2),
        (Law::Hyperelastic(Hyperelastic::Coupled { mu: 0.8, lambda: 2.0 }), 0.2),
        (Law::Plastic(STEEL), 0.01),
        (Law::PlaneStressPlastic(PlaneStressPlasticity(STEEL)), 0.01),
    ];
    for material in Material::examples() {
        let size = material.example_strain();
        laws.push((material.law_3d(), size));
        laws.extend(material.law_plane_stress().map(|law| (law, size)));
    }
    laws
}

fn respond(law: &Law, strain: &Vector6<f64>, committed: &[f64]) -> (tegula::material::Response, Vec<f64>) {
    let mut updated = committed.to_vec();
    let r = law.respond(strain, committed, &mut updated).unwrap();
    (r, updated)
}

fn random(random: &mut Random, size: f64) -> Vector6<f64> {
    Vector6::from_fn(|_, _| size * random.next())
}

/// Components of a strain in axes turned by q.
fn turned(strain: &Vector6<f64>, q: &Matrix3<f64>, shear: f64) -> Vector6<f64> {
    let f = 1.0 / shear;
    let m = Matrix3::new(
        strain[0],
        f * strain[2],
        f * strain[4],
        f * strain[2],
        strain[1],
        f * strain[5],
        f * strain[4],
        f * strain[5],
        strain[3],
    );
    let m = q * m * q.transpose();
    Vector6::new(m[(0, 0)], m[(1, 1)], shear * m[(0, 1)], m[(2, 2)], shear * m[(0, 2)], shear * m[(1, 2)])
}

/// Derivatives by differences of fourth order.
#[test]
fn stress_is_the_derivative_of_the_energy_and_tangent_that_of_the_stress() {
    for (i, (law, size)) in laws().into_iter().enumerate() {
        let mut numbers = Random::new(7 + i as u64);
        for trial in 0..20 {
            let committed = vec![0.0; law.history()];
            // Plastic laws: from a state that has yielded before.
            let (_, committed) = respond(&law, &random(&mut numbers, size), &committed);
            let strain = random(&mut numbers, size);
            let (r, _) = respond(&law, &strain, &committed);
            assert!(
                max_norm(&(r.tangent - r.tangent.transpose())) <= 1e-12 * max_norm(&r.tangent),
                "{law:?}"
            );
            let h = 1e-4 * size;
            let at = |j: usize, t: f64| {
                let mut e = strain;
                e[j] += t * h;
                respond(&law, &e, &committed).0
            };
            for j in 0..6 {
                let rs = [-2.0, -1.0, 1.0, 2.0].map(|t| at(j, t));
                let slope = |f: &dyn Fn(&tegula::material::Response) -> f64| {
                    (f(&rs[0]) - 8.0 * f(&rs[1]) + 8.0 * f(&rs[2]) - f(&rs[3])) / (12.0 * h)
                };
                for k in 0..6 {
                    let d = slope(&|r| r.stress[k]);
                    assert!(
                        (d - r.tangent[(k, j)]).abs() <= 1e-6 * max_norm(&r.tangent),
                        "{law:?} {trial}: {d} for {}",
                        r.tangent[(k, j)]
                    );
                }
                if law.history() == 0 {
                    let d = slope(&|r| r.energy);
                    assert!((d - r.stress[j]).abs() <= 1e-8 * max_norm(&r.tangent) * size, "{law:?}");
                }
            }
        }
    }
}

#[test]
fn isotropic_laws_do_not_know_directions() {
    let q = *rotation([0.4, -1.0, 0.7], 1.1).matrix();
    for (law, size) in laws().into_iter().filter(|(l, _)| !matches!(l, Law::PlaneStressPlastic(_))) {
        if let Law::Linear(c) = &law
            && c[(0, 0)] != c[(1, 1)]
        {
            continue;
        }
        let mut numbers = Random::new(3);
        for _ in 0..10 {
            let strain = random(&mut numbers, size);
            let committed = vec![0.0; law.history()];
            let (r, _) = respond(&law, &strain, &committed);
            let (other, _) = respond(&law, &turned(&strain, &q, 2.0), &committed);
            let expected = turned(&r.stress, &q, 1.0);
            assert!(max_norm(&(other.stress - expected)) <= 1e-11 * max_norm(&r.stress), "{law:?}");
            assert!((other.energy - r.energy).abs() <= 1e-11 * r.energy);
        }
    }
}

/// Small strains keep their digits.
#[test]
fn hyperelastic_laws_are_linear_for_small_strains() {
    for (law, mu, bulk) in [
        (Hyperelastic::Split { c10: 0.3, c01: 0.1, bulk: 3.0 }, 0.8, 3.0),
        (Hyperelastic::Coupled { mu: 0.8, lambda: 3.0 - 2.0 / 3.0 * 0.8 }, 0.8, 3.0),
    ] {
        let young = 9.0 * bulk * mu / (3.0 * bulk + mu);
        let c: Matrix6<f64> = isotropic(young, 0.5 * young / mu - 1.0);
        let mut numbers = Random::new(5);
        for size in [1e-6, 1e-9, 1e-12] {
            let strain = random(&mut numbers, size);
            let r = Law::Hyperelastic(law).respond(&strain, &[], &mut []).unwrap();
            assert!(
                max_norm(&(r.stress - c * strain)) <= (20.0 * size + 1e-13) * max_norm(&r.stress),
                "{size}"
            );
        }
    }
}

/// Shear modulus μ and bulk modulus κ of the model file are those of small strains, E = 9κμ/(3κ + μ) and
/// ν = (3κ − 2μ)/(2(3κ + μ)), whichever energy is chosen; those of Mooney–Rivlin are μ = 2 (c10 + c01).
#[test]
fn keys_of_rubber_are_the_moduli_of_small_strains() {
    let (shear, bulk) = (0.8, 3.0);
    let neo = |form| Material::NeoHookean(NeoHookean { shear, bulk, density: 1.0, form });
    let mooney = Material::MooneyRivlin(MooneyRivlin { c10: 0.3, c01: 0.1, bulk, density: 1.0 });
    let sum = 3.0 * bulk + shear;
    let c = isotropic(9.0 * bulk * shear / sum, (3.0 * bulk - 2.0 * shear) / (2.0 * sum));
    for material in [neo(NeoHookeanForm::Split), neo(NeoHookeanForm::Coupled), mooney] {
        let (r, _) = respond(&material.law_3d(), &Vector6::zeros(), &[]);
        assert!(max_norm(&(r.tangent - c)) <= 1e-12 * max_norm(&c), "{material:?}: {}", r.tangent);
    }
}

/// First Piola–Kirchhoff stresses of principal stretches by ψ(λ1, λ2, λ3) alone.
fn nominal(law: &Hyperelastic, l: [f64; 3]) -> [f64; 3] {
    let j: f64 = l.iter().product();
    let (i1, i2) = (
        l.iter().map(|x| x * x).sum::<f64>(),
        l[0] * l[0] * l[1] * l[1] + l[1] * l[1] * l[2] * l[2] + l[2] * l[2] * l[0] * l[0],
    );
    std::array::from_fn(|k| match *law {
        Hyperelastic::Split { c10, c01, bulk } => {
            let (p, q) = (j.powf(-2.0 / 3.0), j.powf(-4.0 / 3.0));
            let (d1, d2) = (2.0 * l[k], 2.0 * l[k] * (i1 - l[k] * l[k]));
            c10 * p * (d1 - 2.0 / 3.0 * i1 / l[k])
                + c01 * q * (d2 - 4.0 / 3.0 * i2 / l[k])
                + bulk * (j - 1.0) * j / l[k]
        }
        Hyperelastic::Coupled { mu, lambda } => mu * (l[k] - 1.0 / l[k]) + lambda * j.ln() / l[k],
    })
}

/// Stretches for which the law's stress vanishes in the directions `free`, which are alike: by bisection.
fn relax(law: &Hyperelastic, mut l: [f64; 3], free: &[usize]) -> [f64; 3] {
    let rows = [0, 1, 3];
    let (mut low, mut high) = (0.2, 5.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        free.iter().for_each(|&d| l[d] = middle);
        let e = l.map(|x| 0.5 * (x * x - 1.0));
        let strain = Vector6::new(e[0], e[1], 0.0, e[2], 0.0, 0.0);
        let stress = Law::Hyperelastic(*law).respond(&strain, &[], &mut []).unwrap().stress[rows[free[0]]];
        if stress < 0.0 { low = middle } else { high = middle }
    }
    l
}

#[test]
fn uniaxial_equibiaxial_and_shear_follow_closed_forms() {
    let laws = [
        Hyperelastic::Split { c10: 0.5, c01: 0.0, bulk: 4.0 },
        Hyperelastic::Split { c10: 0.3, c01: 0.2, bulk: 4.0 },
        Hyperelastic::Split { c10: 0.3, c01: 0.2, bulk: 1e4 },
        Hyperelastic::Coupled { mu: 1.0, lambda: 3.0 },
    ];
    let response = |law: &Hyperelastic, l: [f64; 3]| {
        let e = l.map(|x| 0.5 * (x * x - 1.0));
        let r = Law::Hyperelastic(*law)
            .respond(&Vector6::new(e[0], e[1], 0.0, e[2], 0.0, 0.0), &[], &mut [])
            .unwrap();
        [r.stress[0] * l[0], r.stress[1] * l[1], r.stress[3] * l[2]]
    };
    for law in &laws {
        for stretch in [0.6_f64, 0.9, 1.3, 2.0] {
            let narrow = stretch.powf(-0.5);
            let uniaxial = relax(law, [stretch, narrow, narrow], &[1, 2]);
            let biaxial = relax(law, [stretch, stretch, stretch.powi(-2)], &[2]);
            for l in [uniaxial, biaxial, [1.3, 0.8, 1.1]] {
                let (found, exact) = (response(law, l), nominal(law, l));
                let scale = max_norm(exact);
                for k in 0..3 {
                    assert!(
                        (found[k] - exact[k]).abs() <= 1e-8 * scale,
                        "{law:?} {l:?}: {found:?} for {exact:?}"
                    );
                }
            }
            let exact = nominal(law, uniaxial);
            assert!(exact[1].abs() <= 1e-8 * exact[0].abs() && exact[2].abs() <= 1e-8 * exact[0].abs());
            assert!(nominal(law, biaxial)[2].abs() <= 1e-8 * exact[0].abs());
        }
        // Simple shear by γ: F = 1 + γ e1⊗e2; Cauchy's σ12 = 2 (c10 + c01) γ, or μ γ.
        for gamma in [0.1, 0.7, 1.5_f64] {
            let f = Matrix3::new(1.0, gamma, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
            let e = (f.transpose() * f - Matrix3::identity()) * 0.5;
            let strain = Vector6::new(e[(0, 0)], e[(1, 1)], 2.0 * e[(0, 1)], e[(2, 2)], 0.0, 0.0);
            let s = Law::Hyperelastic(*law).respond(&strain, &[], &mut []).unwrap().stress;
            let second = Matrix3::new(s[0], s[2], s[4], s[2], s[1], s[5], s[4], s[5], s[3]);
            let cauchy = f * second * f.transpose();
            let mu = match *law {
                Hyperelastic::Split { c10, c01, .. } => 2.0 * (c10 + c01),
                Hyperelastic::Coupled { mu, .. } => mu,
            };
            assert!((cauchy[(0, 1)] - mu * gamma).abs() <= 1e-8 * mu * gamma, "{law:?}");
        }
    }
    // Nearly incompressible: σ = 2 (λ − λ⁻²)(c10 + c01/λ), nominal.
    let (c10, c01) = (0.3, 0.2);
    for bulk in [1e4, 1e6] {
        let law = Hyperelastic::Split { c10, c01, bulk };
        let l = relax(&law, [1.7, 0.77, 0.77], &[1, 2]);
        let exact = 2.0 * (1.7 - 1.7_f64.powi(-2)) * (c10 + c01 / 1.7);
        assert!((nominal(&law, l)[0] - exact).abs() < 2.0 / bulk * exact);
    }
}

/// Uniaxial strain history with free lateral strains; returns stress and internal variables.
fn pull(law: &Law, axial: f64, committed: &[f64]) -> (f64, Vec<f64>) {
    let mut strain = Vector6::new(axial, -0.3 * axial, 0.0, -0.3 * axial, 0.0, 0.0);
    for _ in 0..100 {
        let (r, _) = respond(law, &strain, committed);
        let k = nalgebra::Matrix2::new(
            r.tangent[(1, 1)],
            r.tangent[(1, 3)],
            r.tangent[(3, 1)],
            r.tangent[(3, 3)],
        );
        let step = k.lu().solve(&nalgebra::Vector2::new(r.stress[1], r.stress[3])).unwrap();
        strain[1] -= step[0];
        strain[3] -= step[1];
    }
    let (r, updated) = respond(law, &strain, committed);
    assert!(r.stress[1].abs() < 1e-9 * larger(r.stress[0].abs(), 1.0));
    (r.stress[0], updated)
}

#[test]
fn uniaxial_yielding_follows_closed_forms() {
    // Linear hardening, isotropic H and kinematic H_k: σ = y + (H + H_k) E/(E + H + H_k) (ε − y/E).
    for (h, hk) in [(1500.0, 0.0), (0.0, 3000.0), (1000.0, 700.0)] {
        let law = Law::Plastic(Plasticity { hardening: h, kinematic: hk, saturation: 250.0, ..STEEL });
        let strain = 0.02;
        let (stress, state) = pull(&law, strain, &[0.0; 13]);
        let slope = (h + hk) * 2e5 / (2e5 + h + hk);
        let exact = 250.0 + slope * (strain - 250.0 / 2e5);
        assert!((stress - exact).abs() <= 1e-10 * exact, "{stress} for {exact}");
        let plastic = strain - exact / 2e5;
        assert!((law.plastic_strain(&state).unwrap() - plastic).abs() < 1e-10);
        // Back: the elastic range is 2 σ_y(p) wide and centred at the back stress.
        let backstress = hk * plastic;
        let yield_now = 250.0 + h * plastic;
        let (reverse, _) = pull(&law, strain - 2.2 * yield_now / 2e5, &state);
        let reached = backstress - yield_now;
        assert!(reverse < reached, "yields at {reached} on the way back, found {reverse}");
        let (inside, _) = pull(&law, strain - 1.9 * yield_now / 2e5, &state);
        assert!((inside - (exact - 1.9 * yield_now)).abs() < 1e-8 * exact, "elastic before that");
    }
    // Saturation: ε = σ/E + p with σ = y0 + H p + (y∞ − y0)(1 − e^(−δp)), solved for p on its own.
    let law = Law::Plastic(Plasticity { kinematic: 0.0, ..STEEL });
    let strain = 0.03;
    let stress_of = |p: f64| 250.0 + 1000.0 * p + 150.0 * (1.0 - (-30.0 * p).exp());
    let (mut low, mut high) = (0.0, strain);
    for _ in 0..200 {
        let p = 0.5 * (low + high);
        if stress_of(p) / 2e5 + p < strain { low = p } else { high = p }
    }
    let (stress, _) = pull(&law, strain, &[0.0; 13]);
    assert!((stress - stress_of(low)).abs() <= 1e-9 * stress, "{stress} for {}", stress_of(low));
}

/// The plane-stress law is the three-dimensional one with σ_zz relaxed, along a path that unloads.
#[test]
fn plane_stress_is_the_law_with_a_relaxed_thickness() {
    let (plane, solid) = (Law::PlaneStressPlastic(PlaneStressPlasticity(STEEL)), Law::Plastic(STEEL));
    let mut states = [vec![0.0; 13], vec![0.0; 13]];
    for [x, y, xy] in
        [[0.004, 0.0, 0.001], [0.008, -0.003, 0.006], [0.002, -0.004, 0.0], [-0.006, 0.002, -0.003]]
    {
        let (r, new) = respond(&plane, &Vector6::new(x, y, xy, 0.0, 0.0, 0.0), &states[0]);
        let mut zz = 0.0;
        for _ in 0..100 {
            let (full, _) = respond(&solid, &Vector6::new(x, y, xy, zz, 0.0, 0.0), &states[1]);
            zz -= full.stress[3] / full.tangent[(3, 3)];
        }
        let (full, other) = respond(&solid, &Vector6::new(x, y, xy, zz, 0.0, 0.0), &states[1]);
        for i in 0..3 {
            assert!((r.stress[i] - full.stress[i]).abs() < 1e-9 * 250.0);
        }
        for (a, b) in new.iter().zip(&other) {
            assert!((a - b).abs() < 1e-9 * (a.abs() + 1e-3));
        }
        states = [new, other];
    }
}

/// Transverse shears follow G = E/(2(1 + ν)) and the thickness E, whatever yields in the plane; their energies ½Gγ² and
/// ½Eε² come on top.
#[test]
fn transverse_strains_stay_elastic_under_plane_stress() {
    let law = Law::PlaneStressPlastic(PlaneStressPlasticity(STEEL));
    let moduli = [2e5, 2e5 / 2.6, 2e5 / 2.6];
    for in_plane in [[0.0; 3], [5e-4, -2e-4, 3e-4], [0.01, -0.004, 0.006]] {
        let plane = Vector6::new(in_plane[0], in_plane[1], in_plane[2], 0.0, 0.0, 0.0);
        let (without, plastic) = respond(&law, &plane, &[0.0; 13]);
        let transverse = [1.5e-3, -2e-3, 7e-4];
        let strain = plane + Vector6::new(0.0, 0.0, 0.0, transverse[0], transverse[1], transverse[2]);
        let (r, history) = respond(&law, &strain, &[0.0; 13]);
        assert_eq!(history, plastic);
        assert_eq!(law.plastic_strain(&history), Some(history[12]));
        let mut energy = 0.0;
        for (i, (modulus, e)) in moduli.into_iter().zip(transverse).enumerate() {
            let row = 3 + i;
            assert!((r.stress[row] / (modulus * e) - 1.0).abs() < 1e-14, "{}", r.stress);
            for j in 0..6 {
                let expected = if j == row { modulus } else { 0.0 };
                for entry in [r.tangent[(row, j)], r.tangent[(j, row)]] {
                    assert!((entry - expected).abs() <= 1e-14 * modulus, "{}", r.tangent);
                }
            }
            energy += 0.5 * modulus * e * e;
        }
        assert!(((r.energy - without.energy) / energy - 1.0).abs() < 1e-12, "{}", r.energy);
        assert_eq!(r.dissipation, without.dissipation);
    }
}

/// Work on the material is stored or dissipated, to first order in the step.
#[test]
fn plastic_work_is_balanced() {
    let error = |steps: u32| {
        let law = Law::Plastic(STEEL);
        let (mut state, mut work, mut lost) = (vec![0.0; 13], 0.0, 0.0);
        let (mut strain, mut stress, mut energy) = (Vector6::zeros(), Vector6::zeros(), 0.0);
        for i in 1..=steps {
            let t = f64::from(i) / f64::from(steps);
            let new =
                Vector6::new(0.02 * t, -0.005 * t, 0.01 * (3.0 * t).sin(), -0.008 * t, 0.003 * t * t, 0.0);
            let (r, updated) = respond(&law, &new, &state);
            work += 0.5 * (stress + r.stress).dot(&(new - strain));
            assert!(r.dissipation >= 0.0);
            lost += r.dissipation;
            (strain, stress, energy, state) = (new, r.stress, r.energy, updated);
        }
        ((work - energy - lost) / work).abs()
    };
    let (coarse, fine) = (error(50), error(400));
    assert!(fine < 2e-3 && fine < 0.25 * coarse, "{coarse:e}, {fine:e}");
}

#[test]
fn impossible_strains_have_no_answer() {
    let crushed = Vector6::new(-0.5, 0.0, 0.0, 0.0, 0.0, 0.0);
    // C = diag(−1, −1, 1): its determinant is positive, but no deformation has it.
    let inverted = Vector6::new(-1.0, -1.0, 0.0, 0.0, 0.0, 0.0);
    for law in [
        Hyperelastic::Split { c10: 1.0, c01: 0.0, bulk: 2.0 },
        Hyperelastic::Coupled { mu: 1.0, lambda: 1.0 },
    ] {
        for strain in [crushed, inverted] {
            assert!(Law::Hyperelastic(law).respond(&strain, &[], &mut []).is_none());
        }
    }
}

/// Static condensation of ε_zz in three dimensions, σ_zz = 0.
#[test]
fn plane_stress_and_transverse_shear_are_those_of_the_three_dimensional_stiffness() {
    let ply = Orthotropy { young: [140.0, 12.0, 9.0], poisson: [0.3, 0.25, 0.4], shear: [5.0, 4.0, 3.0] };
    let rubber = isotropic(7.0, 0.4);
    let pairs = [(isotropic_plane_stress(7.0, 0.4), rubber), (ply.plane_stress(), ply.stiffness())];
    for (plane, c) in pairs {
        let condensed = Matrix3::from_fn(|i, j| c[(i, j)] - c[(i, 3)] * c[(3, j)] / c[(3, 3)]);
        assert!(max_norm(&(plane - condensed)) < 1e-12 * max_norm(&condensed), "{plane} {condensed}");
    }
    let shear = ply.stiffness().fixed_view::<2, 2>(4, 4).into_owned();
    assert_eq!(ply.transverse_shear(), shear);
    assert_eq!(shear, Matrix2::new(4.0, 0.0, 0.0, 3.0));
}

#[test]
fn orthotropic_constants_that_contradict_each_other_are_seen() {
    let good = Orthotropy { young: [140.0, 10.0, 10.0], poisson: [0.3; 3], shear: [5.0; 3] };
    assert!(good.is_stable());
    assert!(!Orthotropy { poisson: [4.0, 0.3, 0.3], ..good }.is_stable());
    assert!(!Orthotropy { shear: [5.0, -5.0, 5.0], ..good }.is_stable());
    let c = good.stiffness();
    let strain = c.try_inverse().unwrap() * Vector6::new(7.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    assert!((strain[0] - 0.05).abs() < 1e-12 && (strain[1] + 0.015).abs() < 1e-12);
}

#[test]
fn laws_for_unknown_and_for_linear_materials_are_refused() {
    #[derive(Debug)]
    struct Nothing;
    impl tegula::material::MaterialLaw for Nothing {
        fn respond(
            &self,
            _: &tegula::material::Strain,
            _: &[f64],
            _: &mut [f64],
        ) -> Option<tegula::material::Response> {
            None
        }
    }
    let mut model = crate::common::edge_loaded_shell(false, 2, 10.0, 0.0);
    let mesh = tegula::mesh::generators::generate(&model.mesh).unwrap();
    let (ems, cm) = (model.sections[0].element, ElementKind::Cm);
    for (name, element, word) in
        [("steel", cm, "no such material"), ("m", cm, "is linear"), ("m", ems, "assumes plane stress")]
    {
        model.sections[0].element = element;
        let laws = std::collections::BTreeMap::from([(
            name.to_owned(),
            std::sync::Arc::new(Nothing) as std::sync::Arc<dyn tegula::material::MaterialLaw>,
        )]);
        let Err(tegula::Error::Model(issues)) = tegula::compile::Compiler::with_laws(&model, &mesh, &laws)
        else {
            panic!("{name} is taken")
        };
        assert!(issues.len() == 1 && issues[0].message.contains(word), "{issues:?}");
    }
}

/// A law of a caller answers as it does by itself, and is equal to nothing but itself.
#[test]
fn laws_of_callers_are_asked_for_everything() {
    let mut numbers = Random::new(11);
    let rubber = Hyperelastic::Coupled { mu: 0.8, lambda: 2.0 };
    let steel: Arc<dyn MaterialLaw> = Arc::new(STEEL);
    let pairs = [
        (Law::Plastic(STEEL), Law::Own(OwnLaw(steel.clone())), 0.02),
        (Law::Hyperelastic(rubber), Law::Own(OwnLaw(Arc::new(rubber))), 0.2),
    ];
    for (law, own, size) in &pairs {
        assert_eq!(own.history(), law.history());
        assert_eq!(own.is_hyperelastic(), law.is_hyperelastic());
        assert!(!own.is_linear());
        let mut committed = vec![0.0; law.history()];
        for _ in 0..3 {
            let strain = random(&mut numbers, *size);
            let (expected, updated) = respond(law, &strain, &committed);
            assert_eq!(respond(own, &strain, &committed), (expected, updated.clone()));
            assert_eq!(own.plastic_strain(&updated), law.plastic_strain(&updated));
            committed = updated;
        }
        // Not the start: the strains yield.
        assert!(law.history() == 0 || own.plastic_strain(&committed).is_some_and(|p| p > 1e-3));
    }
    assert_eq!(pairs[0].1, Law::Own(OwnLaw(steel)));
    assert_ne!(pairs[0].1, Law::Own(OwnLaw(Arc::new(STEEL))));
}

#[test]
fn every_material_is_read_as_it_is_written_and_has_the_word_of_the_model_file() {
    for material in Material::examples() {
        println!("contract: material {}", material.kind());
        let written = serde_json::to_value(&material).unwrap();
        assert_eq!(written["type"], material.kind(), "{material:?}");
        assert_eq!(serde_json::from_value::<Material>(written).unwrap(), material);
        assert_eq!(tegula::compile::check::material(&material, "m"), [], "{material:?}");
        assert_eq!(material.law_3d().is_linear(), material.is_linear(), "{material:?}");
    }
}
