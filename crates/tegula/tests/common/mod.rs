#![allow(dead_code, missing_docs)]
use std::collections::BTreeMap;
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
pub fn quarter_cylinder(n: u32, young: f64) -> Model {
    let mesh = MeshSource::Cylinder(CylinderMesh {
        center: [0.0, 0.0, 1.0],
        axis: [0.0, 1.0, 0.0],
        start: [0.0, 0.0, -1.0],
        radius: 1.0,
        angles: [0.0, -90.0],
        length: 1.0,
        grid: Grid::uniform(n, n),
    });
    model(mesh, young, 0.01)
}
