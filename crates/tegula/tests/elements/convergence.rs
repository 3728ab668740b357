//! Rates of convergence of the elements to exact solutions: plates in bending, manufactured solutions of the membrane.
//!
//! A square plate on hard simple supports under a uniform load, Reissner–Mindlin theory (Navier's series): with
//! `k² = (mπ/a)² + (nπ/a)²` and `q_mn = 16 q/(π² m n)` for odd m, n,
//!
//! ```text
//! w = Σ q_mn/(D k⁴) (1 + D k²/S) sin(mπx/a) sin(nπy/a)      D = E h³/12, S = κ G h, ν = 0
//! U = ½ ∫ q w dA = Σ ½ (16 q/π²)² a²/(4 m² n²) (1 + D k²/S)/(D k⁴)
//! ```
//!
//! Without Poisson's effect the elements with three-dimensional stresses have the same limit, with κ = 1. S. P. Timoshenko,
//! S. Woinowsky-Krieger, *Theory of Plates and Shells*, 2nd ed. 1959, Sect. 30; for shear C. M. Wang, J. N. Reddy, K. H.
//! Lee, *Shear Deformable Beams and Plates*, 2000, Sect. 6.2.

use std::f64::consts::PI;

use tegula::Vec3;
use tegula::model::{
    Analysis, Axis, Condition, ElementKind, FixComponents, Isotropic, Load, Model, StaticAnalysis,
};

use crate::common::{plate, solve, vector_load};

const SIDE: f64 = 1.0;
const THICKNESS: f64 = 0.05;
const YOUNG: f64 = 1e7;
const LOAD: f64 = 1.0;

/// Deflection of the centre and strain energy of the whole plate.
fn exact(shear_factor: f64) -> (f64, f64) {
    let bending = YOUNG * THICKNESS.powi(3) / 12.0;
    let shear = shear_factor * 0.5 * YOUNG * THICKNESS;
    let (mut centre, mut energy) = (0.0, 0.0);
    // Smallest terms first.
    for m in (1..400).rev().step_by(2) {
        for n in (1..400).rev().step_by(2) {
            let (p, q) = (f64::from(m), f64::from(n));
            let k2 = (PI / SIDE).powi(2) * (p * p + q * q);
            let response = (1.0 + bending * k2 / shear) / (bending * k2 * k2);
            let load = 16.0 * LOAD / (PI * PI * p * q);
            let sign = if ((m - 1) / 2 + (n - 1) / 2) % 2 == 0 { 1.0 } else { -1.0 };
            centre += sign * load * response;
            energy += 0.125 * load * load * response * SIDE * SIDE;
        }
    }
    (centre, energy)
}

fn supported_plate(element: ElementKind, n: u32, distortion: f64) -> Model {
    let analysis = Analysis::Static(StaticAnalysis { linear: true, ..StaticAnalysis::default() });
    let mesh = plate([SIDE, SIDE], [n, n], distortion);
    let mut model = Model::new(mesh, analysis, Isotropic::new(YOUNG, 0.0, 0.0), THICKNESS);
    model.sections[0].element = element;
    let hard = |on: &str, along: Axis| {
        Condition::Fix(FixComponents { on: on.into(), position: vec![Axis::Z], director: vec![along] })
    };
    model.conditions = vec![
        hard("u_min", Axis::Y),
        hard("u_max", Axis::Y),
        hard("v_min", Axis::X),
        hard("v_max", Axis::X),
        Condition::Fix(FixComponents {
            on: "u_min_v_min".into(),
            position: vec![Axis::X, Axis::Y],
            director: vec![],
        }),
        Condition::Fix(FixComponents { on: "u_max_v_min".into(), position: vec![Axis::Y], director: vec![] }),
    ];
    model.loads = vec![Load::Traction(vector_load("all", [0.0, 0.0, LOAD]))];
    model
}

/// Relative errors of deflection and energy on a mesh.
fn errors(element: ElementKind, n: u32, distortion: f64, (centre, energy): (f64, f64)) -> [f64; 2] {
    let (mesh, system, outcome) = solve(&supported_plate(element, n, distortion));
    let middle = mesh.nearest_node(Vec3::new(0.5 * SIDE, 0.5 * SIDE, 0.0)).unwrap();
    let w = outcome.state.u[system.coordinates.position_of[middle as usize] as usize][2];
    [(w / centre - 1.0).abs(), (outcome.balance.strain / energy - 1.0).abs()]
}

#[test]
fn deflection_and_energy_of_plates_converge_with_the_square_of_the_element_size() {
    for (element, shear_factor) in [
        (ElementKind::Ems, 5.0 / 6.0),
        (ElementKind::Mitc4, 5.0 / 6.0),
        (ElementKind::Cm, 1.0),
        (ElementKind::SolidShell, 1.0),
    ] {
        let exact = exact(shear_factor);
        let meshes = [8, 16, 32];
        let found = meshes.map(|n| errors(element, n, 0.0, exact));
        for quantity in 0..2 {
            for pair in found.windows(2) {
                let rate = (pair[0][quantity] / pair[1][quantity]).log2();
                assert!((1.9..2.15).contains(&rate), "{element:?}, quantity {quantity}: {rate}, {found:?}");
            }
        }
        // On distorted meshes the node nearest to the centre is not there; energy has no place.
        let [coarse, fine] = [8, 32].map(|n| errors(element, n, 0.2, exact)[1]);
        let rate = 0.5 * (coarse / fine).log2();
        assert!(rate > 1.7 && fine < 5e-3, "{element:?}, distorted: {rate}, {coarse} {fine}");
    }
}

/// Membrane problem with a manufactured solution: the displacements
///
/// ```text
/// u = s(x) s(y)    v = s(x) t(y)    s(x) = sin²(πx)    t(y) = sin(πy) sin(2πy)
/// ```
///
/// of a square of side 1 vanish with their first derivatives on its boundary, which is clamped. They belong to the body force
///
/// ```text
/// b = −C [u,xx + (1−ν)/2 u,yy + (1+ν)/2 v,xy    v,yy + (1−ν)/2 v,xx + (1+ν)/2 u,xy]    C = E h/(1−ν²)
/// ```
///
/// per area, plane stress. The plate is so thin that the elements with three-dimensional stresses have the same limit.
mod membrane {
    use super::*;

    use tegula::analysis::statics;
    use tegula::element::Nodal;
    use tegula::model::{Membrane, OnSet};
    use tegula::system::VectorKind;
    use tegula::{Mesh, System};

    use crate::common::{Notes, compile, static_options};

    const POISSON: f64 = 0.3;
    const THIN: f64 = 1e-3;
    const STIFFNESS: f64 = YOUNG * THIN / (1.0 - POISSON * POISSON);

    /// Derivative of order `order` of cos(ωx).
    fn cosine(omega: f64, order: i32, x: f64) -> f64 {
        omega.powi(order) * (omega * x + 0.5 * PI * f64::from(order)).cos()
    }

    /// Derivative of the displacements, of order `p` in x and `q` in y.
    fn displacement(p: i32, q: i32, x: Vec3) -> [f64; 2] {
        let s = |order, x| 0.5 * (cosine(0.0, order, x) - cosine(2.0 * PI, order, x));
        let t = 0.5 * (cosine(PI, q, x.y) - cosine(3.0 * PI, q, x.y));
        [s(p, x.x) * s(q, x.y), s(p, x.x) * t]
    }

    /// Derivative of the body force per area, of order `p` in x and `q` in y.
    fn body_force(p: i32, q: i32, x: Vec3) -> Vec3 {
        let (xx, xy, yy) =
            (displacement(p + 2, q, x), displacement(p + 1, q + 1, x), displacement(p, q + 2, x));
        let (shear, mixed) = (0.5 * (1.0 - POISSON), 0.5 * (1.0 + POISSON));
        let [b, c] = [xx[0] + shear * yy[0] + mixed * xy[1], yy[1] + shear * xx[1] + mixed * xy[0]];
        -STIFFNESS * Vec3::new(b, c, 0.0)
    }

    /// Strain energy per area of the derivatives [u,x v,x] and [u,y v,y].
    fn energy_density([u_x, v_x]: [f64; 2], [u_y, v_y]: [f64; 2]) -> f64 {
        let normal = u_x * u_x + v_y * v_y + 2.0 * POISSON * u_x * v_y;
        0.5 * STIFFNESS * (normal + 0.5 * (1.0 - POISSON) * (u_y + v_x).powi(2))
    }

    /// `Σ w f(x, N, N,x, N,y)` over the 3 × 3 Gauss points of a plane quad, N its bilinear shape functions.
    fn integrate(corners: [Vec3; 4], mut f: impl FnMut(f64, Vec3, [f64; 4], [[f64; 4]; 2])) {
        let g = 0.6_f64.sqrt();
        let rule = [(-g, 5.0 / 9.0), (0.0, 8.0 / 9.0), (g, 5.0 / 9.0)];
        const SIGNS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        for ((xi, w), (eta, v)) in rule.into_iter().flat_map(|a| rule.map(|b| (a, b))) {
            let shape = SIGNS.map(|[a, b]| 0.25 * (1.0 + a * xi) * (1.0 + b * eta));
            let natural = [
                SIGNS.map(|[a, b]| 0.25 * a * (1.0 + b * eta)),
                SIGNS.map(|[a, b]| 0.25 * b * (1.0 + a * xi)),
            ];
            let sum = |n: &[f64; 4]| (0..4).map(|a| corners[a] * n[a]).sum::<Vec3>();
            let [d, e] = [sum(&natural[0]), sum(&natural[1])];
            let area = d.x * e.y - d.y * e.x;
            let along =
                |p: f64, q: f64| std::array::from_fn(|a| (p * natural[0][a] + q * natural[1][a]) / area);
            f(w * v * area, sum(&shape), shape, [along(e.y, -d.y), along(-e.x, d.x)]);
        }
    }

    /// Nodal forces of the body force: ∫ N b dA, for elements with gradients ∫ NᵀN dA of their nodal values of b, which
    /// their interpolation follows to the fourth order. Their mass at a density of 1 is that times the thickness.
    fn body_force_on_nodes(system: &System, mesh: &Mesh) -> Vec<Nodal> {
        let c = &system.coordinates;
        let mut force = vec![[0.0; 3]; system.vectors()];
        if c.kinds.contains(&VectorKind::Gradient) {
            let value = |v: usize| -> Nodal {
                let (x, t) = (mesh.positions[c.nodes[v] as usize], c.reference[v]);
                match c.kinds[v] {
                    VectorKind::Position => body_force(0, 0, x),
                    VectorKind::Director => Vec3::zeros(),
                    VectorKind::Gradient => body_force(1, 0, x) * t[0] + body_force(0, 1, x) * t[1],
                }
                .into()
            };
            let nodal: Vec<Nodal> = (0..system.vectors()).map(value).collect();
            system.pattern.add_mass_product(1.0 / THIN, &nodal, &mut force);
        } else {
            for quad in &mesh.quads {
                integrate(quad.map(|a| mesh.positions[a as usize]), |w, x, shape, _| {
                    let b = body_force(0, 0, x);
                    for (a, n) in quad.iter().zip(shape) {
                        let f = &mut force[c.position_of[*a as usize] as usize];
                        (0..3).for_each(|i| f[i] += w * n * b[i]);
                    }
                });
            }
        }
        force
    }

    /// Relative errors on a mesh: displacement in L2, strain energy, and strains of the interpolated displacements in
    /// the energy norm.
    fn errors(element: ElementKind, membrane: Option<Membrane>, n: u32, distortion: f64) -> [f64; 3] {
        let analysis = Analysis::Static(StaticAnalysis { linear: true, ..StaticAnalysis::default() });
        let mesh = plate([SIDE, SIDE], [n, n], distortion);
        let mut model = Model::new(mesh, analysis, Isotropic::new(YOUNG, POISSON, 1.0), THIN);
        (model.sections[0].element, model.sections[0].membrane) = (element, membrane);
        let edges = ["u_min", "u_max", "v_min", "v_max"];
        model.conditions = edges.map(|on| Condition::Clamp(OnSet { on: on.into() })).into();
        model.loads = vec![Load::Traction(vector_load("all", [1.0, 0.0, 0.0]))];
        let (mesh, mut system) = compile(&model);

        let force = body_force_on_nodes(&system, &mesh);
        system.dead_loads[0].force = force;
        let outcome = statics::run(&system, &static_options(&model), None, &mut Notes::default()).unwrap();

        let [mut error, mut size, mut strain, mut energy] = [0.0; 4];
        for quad in &mesh.quads {
            let u = quad.map(|a| outcome.state.u[system.coordinates.position_of[a as usize] as usize]);
            let corners = quad.map(|a| mesh.positions[a as usize]);
            integrate(corners, |w, x, shape, along| {
                let sum = |n: [f64; 4]| [0, 1].map(|i| (0..4).map(|a| n[a] * u[a][i]).sum::<f64>());
                let less = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
                let square = |a: [f64; 2]| a[0] * a[0] + a[1] * a[1];
                let [exact, exact_x, exact_y] =
                    [displacement(0, 0, x), displacement(1, 0, x), displacement(0, 1, x)];
                error += w * square(less(sum(shape), exact));
                size += w * square(exact);
                let [e, f] = along.map(sum);
                strain += w * energy_density(less(e, exact_x), less(f, exact_y));
                energy += w * energy_density(exact_x, exact_y);
            });
        }
        [(error / size).sqrt(), (outcome.balance.strain / energy - 1.0).abs(), (strain / energy).sqrt()]
    }

    #[test]
    #[ignore = "long"]
    fn displacements_and_energy_of_manufactured_membrane_solutions_converge_at_the_rates_of_bilinear_elements()
     {
        // Every membrane part of both kinds of bilinear elements, whose membrane the others share.
        let parts = [ElementKind::Ems, ElementKind::Cm].into_iter();
        let mut elements: Vec<_> = parts.flat_map(|e| Membrane::ALL.map(|m| (e, Some(m)))).collect();
        elements.extend(ElementKind::ALL.iter().map(|&e| (e, None)));
        let mut slow = Vec::new();
        for (element, membrane) in elements {
            for distortion in [0.0, 0.25] {
                let [coarse, fine] = [8, 24].map(|n| errors(element, membrane, n, distortion));
                let rates: [f64; 3] = std::array::from_fn(|i| (coarse[i] / fine[i]).ln() / 3.0_f64.ln());
                let case =
                    format!("{element:?} {membrane:?}, distortion {distortion}: {rates:.2?}, {fine:.4?}");
                println!("{case}");
                let enough = rates[0] >= 1.8 && rates[1] >= 1.8 && rates[2] >= 0.9;
                let small = fine[0] < 0.02 && fine[1] < 0.02 && fine[2] < 0.12;
                if !(enough && small) {
                    slow.push(case);
                }
            }
        }
        assert!(slow.is_empty(), "{slow:#?}");
    }
}
