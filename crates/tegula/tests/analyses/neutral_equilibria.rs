//! Mechanisms whose loads neither hold nor drive one of their free motions: each position along it is an equilibrium, and none is returned.

use crate::beams::rectangle;
use crate::common::{Notes, compile, vector_load};
use crate::multibody::{axis_joint, between, body, gravity, revolute, spherical, spring};
use crate::patches::{hub, strip};
use tegula::analysis::{Silent, path, statics};
use tegula::model::*;

/// A strip on a carriage that slides across the load, through a rigid patch or a distributing coupling.
fn strip_on_a_slide(element: ElementKind, distributed: bool) -> Model {
    let mut m = strip(element, [4, 2], 0.0);
    let width = 0.5 * if let MeshSource::Plate(plate) = &m.mesh { plate.size[1] } else { panic!("no plate") };
    let mut carriage = hub("carriage", [0.0, width, 0.0], &["u_min"]);
    if distributed {
        (carriage.distributed, carriage.mass) = (std::mem::take(&mut carriage.attached), Some(1.0));
        carriage.inertia = Some([1.0; 3]);
    }
    m.bodies = vec![carriage];
    m.joints = vec![Joint::Prismatic(
        axis_joint("slide", "ground", "carriage", [0.0, width, 0.0], [0.0, 1.0, 0.0]).into(),
    )];
    m.conditions.clear();
    m.loads = gravity([0.0, 0.0, -0.01]);
    m
}

fn refusal_of_statics(m: &Model) -> Option<String> {
    let Analysis::Static(options) = &m.analysis else { panic!("no statics") };
    let (_, system) = compile(m);
    statics::run(&system, options, None, &mut Silent).err().map(|error| error.to_string())
}

/// Whatever round-off makes of the pivot of the motion across the load, statics and paths of all elements and couplings name it.
#[test]
fn motions_that_loads_neither_hold_nor_drive_are_refused_by_name() {
    let motion = "body \"carriage\" moves along (0.0000, 1.0000, 0.0000)";
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm] {
        for distributed in [false, true] {
            let mut m = strip_on_a_slide(element, distributed);
            m.analysis = Analysis::Static(StaticAnalysis::default());
            let refusal = refusal_of_statics(&m).expect("the position along the slide is arbitrary");
            assert!(
                refusal.contains("1 motion(s) free") && refusal.contains(motion),
                "{element:?} {distributed}: {refusal}"
            );
            for method in [None, Some(PathMethod::ArcLength)] {
                let options = PathAnalysis { method, ..Default::default() };
                m.analysis = Analysis::Path(options.clone());
                let (_, system) = compile(&m);
                let refusal = path::run(&system, &options, None, &mut Silent).unwrap_err().to_string();
                assert!(
                    refusal.contains("1 motion(s) free") && refusal.contains(motion),
                    "{element:?} {distributed}: {refusal}"
                );
            }
        }
    }
}

/// Of a body that hangs on a ball the turn about the vertical axis is named, and not its swings, which its weight holds; a body on a hinge hangs in
/// equilibrium.
#[test]
fn motions_that_weights_hold_are_not_refused() {
    let hanging = body("weight", [0.0, 0.0, -1.0], 1.0, Some([0.1, 0.2, 0.3]));
    let hinge = revolute("hinge", "ground", "weight", [0.0; 3], [0.0, 1.0, 0.0]);
    let mut m = Model::of_bodies(Analysis::Static(StaticAnalysis::default()), vec![hanging], vec![hinge]);
    m.loads = gravity([0.0, 0.0, -9.81]);
    assert_eq!(refusal_of_statics(&m), None);
    m.joints = vec![spherical("ground", "weight", [0.0; 3])];
    let refusal = refusal_of_statics(&m).expect("the weight may turn about its axis");
    assert!(refusal.contains("along (0.0000, 0.0000, 1.0000)"), "{refusal}");
}

/// A plate that hangs on a spring in its middle may turn about the vertical axis, and its sag holds it against others. Without bodies it is the mesh that moves.
#[test]
fn free_motions_of_meshes_on_springs_are_refused_by_name() {
    let mut m = crate::common::model(crate::common::plate([1.0, 1.0], [2, 2], 0.0), 2e11, 0.01);
    let (x, y, tolerance) = (Some([0.5; 2]), Some([0.5; 2]), None);
    m.sets =
        vec![MeshSet::Box(BoxSet { name: "middle".into(), x, y, z: None, within: "all".into(), tolerance })];
    if let Some(Material::Isotropic(material)) = m.materials.values_mut().next() {
        material.density = 7800.0;
    }
    m.conditions.clear();
    m.springs = vec![spring("rope", ["ground", "middle"], [[0.5, 0.5, 1.0], [0.5, 0.5, 0.0]], 1e4)];
    m.loads = gravity([0.0, 0.0, -9.81]);
    m.analysis = Analysis::Static(StaticAnalysis::default());
    let refusal = refusal_of_statics(&m).expect("the plate may turn");
    assert!(refusal.contains("the mesh turns about the axis through (0.5000, 0.5000,"), "{refusal}");
    assert!(
        refusal.contains("1 motion(s) free") && refusal.contains("along (0.0000, 0.0000, 1.0000)"),
        "{refusal}"
    );
}

/// A plate that hangs on a ball joint at its corner may turn about the line from there to its centre, whatever round-off makes of the pivots.
#[test]
fn free_motions_of_plates_on_ball_joints_are_refused_by_name() {
    for elements in [[2, 1], [2, 2], [3, 2]] {
        let mut m = crate::common::model(crate::common::plate([1.0, 1.0], elements, 0.0), 2e11, 0.01);
        if let Some(Material::Isotropic(material)) = m.materials.values_mut().next() {
            material.density = 7800.0;
        }
        m.conditions.clear();
        m.joints = vec![spherical("ground", "u_min_v_min", [0.0; 3])];
        m.loads = gravity([-9.81, -9.81, 0.0]);
        m.analysis = Analysis::Static(StaticAnalysis::default());
        let refusal = refusal_of_statics(&m).expect("the plate may turn");
        assert!(
            refusal.contains("the model is a mechanism") && refusal.contains("the mesh turns about"),
            "{elements:?}: {refusal}"
        );
    }
}

/// A column of square section on a ball and a universal joint buckles in any direction. The paths that cross there are a family, along which the
/// tangent stays singular: the message says so, behind the results up to the bifurcation.
#[test]
fn paths_that_end_where_two_modes_meet_say_so() {
    // Twice Euler's load.
    let (young, side) = (1e9, 0.05_f64);
    let load = 2.0 * std::f64::consts::PI.powi(2) * young * side.powi(4) / 12.0;
    let mut column =
        Beam::straight("column", [[0.0; 3], [1.0, 0.0, 0.0]], 16, [0.0, 0.0, 1.0], rectangle([side, side]));
    column.material = Some("m".into());
    let foot = Joint::Universal(TwoAxesJoint {
        name: "foot".into(),
        between: between("ground", "column.start"),
        at: [0.0; 3],
        axes: [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        second_at: None,
    });
    let end = [1.0, 0.0, 0.0];
    let guide = Joint::Prismatic(axis_joint("guide", "ground", "slider", end, end).into());
    let head = spherical("slider", "column.end", end);
    let slider = body("slider", end, 1.0, Some([1.0; 3]));
    let options = PathAnalysis { end_load: 2.0, switch_at: vec![1], ..Default::default() };
    let mut m = Model::of_bodies(Analysis::Path(options), vec![slider], vec![foot, guide, head]);
    m.materials.insert("m".into(), Material::Isotropic(Isotropic::new(young, 0.3, 1000.0)));
    m.beams = vec![column];
    m.loads = vec![Load::Force(vector_load("slider", [-load, 0.0, 0.0]))];
    for method in [None, Some(PathMethod::ArcLength)] {
        let Analysis::Path(options) = &mut m.analysis else { panic!("no path") };
        options.method = method;
        let options = options.clone();
        let (_, system) = compile(&m);
        let mut notes = Notes::keeping();
        let error = path::run(&system, &options, None, &mut notes).unwrap_err().to_string();
        let last = notes.states.last().map_or(0.0, |state| state.time);
        assert!((last - 0.5).abs() < 0.005, "{last}");
        assert!(error.contains("2 modes meet at the bifurcation at load factor 0.499"), "{error}");
    }
}
