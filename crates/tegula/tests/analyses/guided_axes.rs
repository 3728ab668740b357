//! Axes of drives and torsion springs beside joints.

use crate::multibody::{between, body, machine, revolute};
use tegula::model::*;
use tegula::{compile, mesh};

/// A drive or torsion spring about another axis than that of the hinge beside it would hold another angle than that of the hinge.
#[test]
fn drives_and_torsion_springs_about_another_axis_than_their_hinge_are_refused() {
    let hinge = revolute("hinge", "ground", "a", [0.0; 3], [0.0, 0.0, 1.0]);
    let drive = |axis: [f64; 3]| {
        Joint::DrivenAngle(DrivenAngleJoint {
            name: "motor".into(),
            between: between("a", "ground"),
            axis,
            angle: 60.0,
            amplitude: "ramp".into(),
        })
    };
    let spring = |axis: [f64; 3]| TorsionSpring {
        name: "clock".into(),
        between: between("ground", "a"),
        axis,
        stiffness: 1.0,
        damping: 0.0,
        moment: None,
        free_angle: 0.0,
    };
    let issues = |axis: [f64; 3], with_drive: bool| {
        let bodies = vec![body("a", [0.0; 3], 1.0, Some([0.1; 3]))];
        let mut model = machine(1.0, 0.1, bodies, vec![hinge.clone()]);
        model.amplitudes.insert("ramp".into(), Amplitude::Ramp(RampAmplitude { start: 0.0, end: 1.0 }));
        if with_drive {
            model.joints.push(drive(axis));
        } else {
            model.torsion_springs = vec![spring(axis)];
        }
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        compile::build(&model, &mesh).err().map(|error| error.to_string()).unwrap_or_default()
    };
    for with_drive in [true, false] {
        let message = issues([0.0, 0.6, 0.8], with_drive);
        assert!(message.contains("is not that of the joint \"hinge\""), "{message}");
        assert!(
            message.contains(if with_drive { "joints[1].axis" } else { "torsion_springs[0].axis" }),
            "{message}"
        );
        assert_eq!(issues([0.0, 0.0, -2.0], with_drive), "");
    }
}
