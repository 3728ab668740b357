//! Sect. 5.3 of the paper.
mod common;
use tegula::analysis::{Silent, modal};
use tegula::model::*;
#[test]
fn free_plate() {
    for (n, h) in [(4, 1e-3), (8, 1e-3), (16, 1e-3), (32, 1e-3), (64, 1e-3), (16, 1e-2), (16, 1e-1), (4, 0.1)]
    {
        let mesh = MeshSource::Plate(PlateMesh {
            origin: [0.0; 3],
            u_axis: [1.0, 0.0, 0.0],
            v_axis: [0.0, 1.0, 0.0],
            size: [1.0, 1.0],
            grid: Grid::uniform(n, n),
        });
        let mut m = common::model(mesh, 2.1e11, h);
        m.conditions.clear();
        m.materials.insert(
            "m".into(),
            Material::Isotropic(Isotropic { young: 2.1e11, poisson: 0.3, density: 7850.0 }),
        );
        m.analysis = Analysis::Modal(ModalAnalysis { modes: 16, prestressed: false });
        let mesh = tegula::mesh::generators::generate(&m.mesh).unwrap();
        let s = build::build(&m, &mesh).unwrap();
        let t = std::time::Instant::now();
        match modal::run(&s, 16, None, &mut Silent) {
            Ok(o) => {
                let d = 2.1e11 * h * h * h / 12.0 / (1.0 - 0.09);
                let w0 = std::f64::consts::PI.powi(2) * (d / (7850.0 * h)).sqrt();
                println!(
                    "{n} {h} {:?} {} {:?} rigid {} {:?}",
                    o.statistics,
                    o.sturm_checked,
                    o.modes
                        .iter()
                        .filter(|m| !m.rigid)
                        .map(|m| format!("{:.7}", m.omega / w0))
                        .collect::<Vec<_>>(),
                    o.modes.iter().filter(|m| m.rigid).count(),
                    t.elapsed()
                );
            }
            Err(e) => println!("{e}"),
        }
    }
}
