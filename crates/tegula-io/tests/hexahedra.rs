//! A shell read as hexahedra is the shell that a generator makes.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use tegula::analysis::{Silent, statics};
use tegula::compile::build;
use tegula::model::{
    Analysis, Condition, CylinderMesh, ElementKind, Grid, Isotropic, Load, MeshSource, Model, OnSet,
    StaticAnalysis, VectorLoad,
};
use tegula::{Error, Mesh, Vec3};

fn generated() -> MeshSource {
    MeshSource::Cylinder(CylinderMesh {
        center: [0.0; 3],
        axis: [0.0, 0.0, 1.0],
        start: [1.0, 0.0, 0.0],
        radius: 2.0,
        length: 3.0,
        angles: [0.0, 90.0],
        grid: Grid::uniform(4, 3),
    })
}

fn read() -> Mesh {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/layer-4-ascii.msh");
    tegula_io::mesh::gmsh::read(&file, 1.0).unwrap()
}

fn model(element: ElementKind, thickness: f64, fixed: &str, tip: &str) -> (Model, StaticAnalysis) {
    let options = StaticAnalysis::default();
    let mut model =
        Model::new(generated(), Analysis::Static(options.clone()), Isotropic::new(1e7, 0.3, 1e3), thickness);
    model.sections[0].element = element;
    model.conditions = vec![Condition::Clamp(OnSet { on: fixed.into() })];
    model.loads = vec![Load::Force(VectorLoad {
        on: tip.into(),
        value: [0.0, -1.0, 0.5].map(|x| x * 200.0),
        amplitude: None,
        distribution: None,
    })];
    (model, options)
}

/// Displacement of the loaded corner.
fn tip(model: &Model, options: &StaticAnalysis, mesh: &Mesh, at: &str) -> Vec3 {
    let system = build(model, mesh).unwrap();
    let outcome = statics::run(&system, options, None, &mut Silent).unwrap();
    let node = mesh.nodes_on(at).unwrap()[0];
    Vec3::from(outcome.state.u[system.coordinates.position_of[node as usize] as usize])
}

#[test]
fn hexahedra_and_quads_with_exact_normals_are_one_shell() {
    let from_generator = tegula::mesh::generators::generate(&generated()).unwrap();
    let from_file = read();
    for &element in ElementKind::ALL {
        let (a, options) = model(element, 0.1, "u_min", "u_max_v_min");
        let (b, _) = model(element, 0.1, "fixed", "tip");
        let a = tip(&a, &options, &from_generator, "u_max_v_min");
        let b = tip(&b, &options, &from_file, "tip");
        assert!(a.norm() > 0.1, "moves by far: {a}");
        assert!((a - b).norm() < 1e-8 * a.norm(), "{element:?}: {a} {b}");
    }
}

#[test]
fn a_section_has_the_thickness_of_its_hexahedra() {
    let (model, _) = model(ElementKind::SolidShell, 0.05, "fixed", "tip");
    let Err(Error::Model(issues)) = build(&model, &read()) else { panic!("accepted") };
    let text = issues[0].to_string();
    assert!(issues.len() == 1 && text.contains("sections[0].thickness"), "{text}");
    assert!(text.contains("the section is 0.05 thick, but the mesh is 0.100000 thick at node"), "{text}");
}

/// Two hexahedra one of which has its lower edge where the other one has its upper edge: a node would be at the bottom and at the top.
#[test]
fn parts_whose_top_and_bottom_share_an_edge_are_refused_in_any_order() {
    let nodes = "1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 .1\n6 1 0 .1\n7 1 1 .1\n8 0 1 .1\n\
                 9 2 0 .1\n10 2 1 .1\n11 1 0 .2\n12 2 0 .2\n13 2 1 .2\n14 1 1 .2";
    let corners = ["1 2 3 4 5 6 7 8", "6 9 10 7 11 12 13 14"];
    let folder = tempfile::tempdir().unwrap();
    for [first, second] in [[0, 1], [1, 0]] {
        let text = format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n14\n{nodes}\n$EndNodes\n$Elements\n2\n1 5 2 1 1 {}\n2 5 2 1 1 {}\n$EndElements\n",
            corners[first], corners[second]
        );
        let file = folder.path().join("parts.msh");
        std::fs::write(&file, text).unwrap();
        let refused = tegula_io::mesh::gmsh::read(&file, 1.0).err().unwrap().to_string();
        assert!(refused.contains("do not lie side by side in one layer"), "{refused}");
    }
}
