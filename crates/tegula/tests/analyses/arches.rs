//! Limit points and bifurcations of shallow arches, pinned and clamped, against the closed form.

use crate::common::{cylinder, model, on, vector_load};
use crate::paths::{critical, follow};
use tegula::analysis::path::CriticalKind;
use tegula::model::*;

/// Pinned or clamped shallow arch under a uniform load: Y.-L. Pi, M. A. Bradford, B. Uy, *In-plane stability of arches*, Int. J. Solids Struct. 39
/// (2002) 105–125. With inward displacement w, compression N and μ² = N/EI
///
/// ```text
/// EI w'''' + N (w'' + 1/R) = q,    N/EA = (1/S) ∫ (w/R − ½ w'²) ds,    w = 0, and w'' = 0 or w' = 0, at s = ±S/2
/// ```
///
/// the path is a curve q(β), β = μ S/2, with p = (q − N/R)/EI and w = p/μ⁴ (cos μs/cos β − 1) − p/(2 μ²) (S²/4 − s²), of the clamped arch
/// w = p S/(2 μ³ sin β) (cos μs − cos β) − p/(2 μ²) (S²/4 − s²). The pinned arch bifurcates without symmetry at β = π, the clamped one at tan β = β.
pub struct Arch {
    radius: f64,
    length: f64,
    /// EA and EI of the unit width.
    stiffness: [f64; 2],
    clamped: bool,
}

impl Arch {
    /// Loads q at a β: the two roots of the quadratic equation for p, ascending; none where there is no equilibrium.
    fn loads(&self, beta: f64) -> Option<[f64; 2]> {
        let [ea, ei] = self.stiffness;
        let mu = 2.0 * beta / self.length;
        let n = mu * mu * ei;
        // Mean over the length by Simpson's rule.
        let mean = |f: &dyn Fn(f64) -> f64| {
            let parts = 400;
            let weight = |i: i32| match i {
                _ if i == 0 || i == parts => 1.0,
                _ if i % 2 == 1 => 4.0,
                _ => 2.0,
            };
            let place = |i: i32| self.length * (f64::from(i) / f64::from(parts) - 0.5);
            (0..=parts).map(|i| weight(i) * f(place(i))).sum::<f64>() / f64::from(3 * parts)
        };
        // Coefficient of cos μs − cos β.
        let wave = if self.clamped {
            0.5 * self.length / beta.sin() / mu.powi(3)
        } else {
            1.0 / beta.cos() / mu.powi(4)
        };
        let w = |s: f64| {
            wave * ((mu * s).cos() - beta.cos())
                - (0.25 * self.length * self.length - s * s) / (2.0 * mu * mu)
        };
        let slope = |s: f64| -wave * mu * (mu * s).sin() + s / (mu * mu);
        let (a, b, c) = (0.5 * mean(&|s| slope(s).powi(2)), mean(&w) / self.radius, n / ea);
        let root = (b * b - 4.0 * a * c).sqrt();
        let mut both = [-1.0, 1.0].map(|sign| n / self.radius + ei * (b + sign * root) / (2.0 * a));
        both.sort_by(f64::total_cmp);
        root.is_finite().then_some(both)
    }
}

/// Strip bent to an arch of half angle 0.1 rad, pinned at both ends.
pub fn arch(n: u32, thickness: f64) -> (Model, Arch) {
    let (radius, half) = (10.0, 0.1_f64);
    let mesh = cylinder(radius, [-half.to_degrees(), half.to_degrees()], 0.2, [n, 1]);
    let young = 2e6;
    let mut m = model(mesh, young, thickness);
    if let Some(Material::Isotropic(material)) = m.materials.values_mut().next() {
        material.poisson = 0.0;
    }
    m.conditions = vec![Condition::Hinge(on("u_min")), Condition::Hinge(on("u_max"))];
    let stiffness = [young * thickness, young * thickness.powi(3) / 12.0];
    (m, Arch { radius, length: 2.0 * half * radius, stiffness, clamped: false })
}

/// The arch with clamped ends.
fn clamped_arch(n: u32, thickness: f64) -> (Model, Arch) {
    let (mut m, arch) = arch(n, thickness);
    m.conditions = ["u_min", "u_max"].map(|edge| Condition::Clamp(on(edge))).to_vec();
    (m, Arch { clamped: true, ..arch })
}

/// Largest upper and smallest lower load of an arch between two poles of its path, where both roots belong to one path, and the loads at
/// which it bifurcates on the way to the one and on the way from the other.
pub fn critical_loads(arch: &Arch) -> [f64; 4] {
    points(arch).map(|(load, _)| load)
}

/// These loads, each with its β: along the path β rises on the upper root, and falls on the lower one.
fn points(arch: &Arch) -> [(f64, f64); 4] {
    let pi = std::f64::consts::PI;
    let (first, last, bifurcation) = if arch.clamped {
        // The first positive root of tan β = β.
        (pi, 2.0 * pi, 4.493_409_457_909_064)
    } else {
        (0.5 * pi, 1.5 * pi, pi)
    };
    let root = |number: usize| {
        let betas = (1..20_000).map(|i| first + (last - first) * f64::from(i) / 20_000.0);
        betas.filter_map(move |beta| Some((arch.loads(beta)?[number], beta)))
    };
    let largest = root(1).max_by(|p, q| p.0.total_cmp(&q.0)).unwrap();
    let smallest = root(0).min_by(|p, q| p.0.total_cmp(&q.0)).unwrap();
    let [lower, upper] = arch.loads(bifurcation).unwrap();
    [(upper, bifurcation), largest, smallest, (lower, bifurcation)]
}

/// The path of the perfect arch passes both bifurcations without an imperfection. With the second thickness bifurcation and limit
/// point lie within 1 % of the load: in one step of the path.
#[test]
fn a_shallow_arch_has_the_limit_points_and_bifurcations_of_the_closed_form() {
    use CriticalKind::{Bifurcation, Limit};
    for (clamped, thickness) in [(false, 0.01), (false, 0.036), (true, 0.01), (true, 0.018)] {
        let (mut m, exact) = if clamped { clamped_arch(48, thickness) } else { arch(48, thickness) };
        let points = points(&exact);
        let full = points[1].0;
        m.loads = vec![Load::Traction(vector_load("all", [0.0, 0.0, -full]))];
        m.analysis = Analysis::Path(PathAnalysis { end_load: 1.5, ..Default::default() });
        let (outcome, _) = follow(&m, "u_min_v_min");
        let found = critical(&outcome);
        let kinds: Vec<_> = found.iter().map(|point| (point.kind, point.change)).collect();
        let all = [(Bifurcation, 1), (Limit, 1), (Limit, -1), (Bifurcation, -1)];
        let mut expected: Vec<_> = all.into_iter().zip(points).collect();
        expected[..2].sort_by(|p, q| p.1.1.total_cmp(&q.1.1));
        expected[2..].sort_by(|p, q| q.1.1.total_cmp(&p.1.1));
        let order: Vec<_> = expected.iter().map(|point| point.0).collect();
        assert_eq!(kinds, order, "{clamped} {thickness}");
        for (point, (_, (load, _))) in found.iter().zip(expected) {
            // Lower loads are small differences.
            let scale = if load > 0.0 { load } else { full };
            let error = (point.load * full - load) / scale;
            println!("{clamped} {thickness} {load} {error}");
            assert!(
                error.abs() < if clamped { 0.01 } else { 0.005 },
                "{clamped} {thickness} {:?}: {error}",
                point.kind
            );
        }
    }
}
