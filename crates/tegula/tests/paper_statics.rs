//! Sect. 5.1 and 5.2 of the paper.
use std::collections::BTreeMap;
use tegula::analysis::{Silent, statics};
use tegula::mesh::generators::generate;
use tegula::model::*;

pub fn model(mesh: MeshSource, young: f64, thickness: f64) -> Model {
    Model {
        title: String::new(),
        analysis: Analysis::Static(StaticAnalysis::default()),
        mesh,
        materials: BTreeMap::from([(
            "m".to_string(),
            Material::Isotropic(Isotropic { young, poisson: 0.3, density: 1.0 }),
        )]),
        sections: vec![Section {
            on: "all".into(),
            element: ElementKind::Ems,
            material: "m".into(),
            thickness,
            shear_correction: [5.0 / 6.0; 2],
            ans_shear: true,
            ans_thickness: true,
            eas: true,
            total_mass: None,
            retardation_time: 0.0,
        }],
        conditions: vec![Condition::Clamp(OnSet { on: "u_min".into() })],
        loads: vec![],
        masses: vec![],
        initial_velocities: vec![],
        damping: Damping::default(),
        amplitudes: BTreeMap::new(),
        output: Output::default(),
    }
}

#[test]
fn plate() {
    for (h, q, w) in [(1e-3, 5e-2, -8.626936740e-04)] {
        let mesh = MeshSource::Plate(PlateMesh {
            origin: [0.0; 3],
            u_axis: [1.0, 0.0, 0.0],
            v_axis: [0.0, 1.0, 0.0],
            size: [1.0, 1.0],
            grid: Grid::uniform(4, 4),
        });
        let mut m = model(mesh, 2.1e11, h);
        m.analysis = Analysis::Static(StaticAnalysis { linear: true, ..Default::default() });
        m.loads = vec![Load::Edge(VectorLoad { on: "u_max".into(), value: [0.0, 0.0, -q], amplitude: None })];
        let mesh = generate(&m.mesh).unwrap();
        let s = build::build(&m, &mesh).unwrap();
        let o = statics::run(&s, &StaticAnalysis { linear: true, ..Default::default() }, None, &mut Silent)
            .unwrap();
        let c = mesh.nodes_on("u_max_v_min").unwrap()[0];
        println!("{} {:?}", o.state.u[s.position_of[c as usize] as usize][2] / w - 1.0, o.statistics);
    }
}

#[test]
fn quarter_cylinder() {
    for n in [4, 8, 16, 32, 64] {
        let mesh = MeshSource::Cylinder(CylinderMesh {
            center: [0.0, 0.0, 1.0],
            axis: [0.0, 1.0, 0.0],
            start: [0.0, 0.0, -1.0],
            radius: 1.0,
            angles: [0.0, -90.0],
            length: 1.0,
            grid: Grid::uniform(n, n),
        });
        let mut m = model(mesh, 2.1e8, 0.01);
        m.loads = vec![Load::Force(VectorLoad {
            on: "u_max_v_max".into(),
            value: [0.0, 0.0, -20.0],
            amplitude: None,
        })];
        let mesh = generate(&m.mesh).unwrap();
        let s = build::build(&m, &mesh).unwrap();
        struct P;
        impl tegula::analysis::Observer for P {
            fn on_step(&mut self, _: &tegula::analysis::Step) -> tegula::Result<()> {
                Ok(())
            }
            fn on_iteration(&mut self, i: u32, e: f64, d: f64) {
                println!("  {i} {e:.2e} {d:.2e}");
            }
            fn on_event(&mut self, m: &str) {
                println!("  {m}");
            }
        }
        let t = std::time::Instant::now();
        let o = statics::run(&s, &StaticAnalysis::default(), None, &mut P);
        match o {
            Ok(o) => {
                let c = mesh.nodes_on("u_max_v_max").unwrap()[0];
                println!(
                    "{n} {:?} {:.9} {:?} {:?}",
                    o.state.u[s.position_of[c as usize] as usize],
                    o.balance.strain,
                    o.statistics,
                    t.elapsed()
                );
            }
            Err(e) => println!("{n} {e}"),
        }
    }
}
