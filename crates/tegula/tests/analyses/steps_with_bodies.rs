//! Motions of bodies that follow one another, or a static step.

use crate::common::Notes;
use crate::multibody::{between, body, gravity, machine, revolute};
use tegula::analysis::{Observer, dynamics};
use tegula::model::*;
use tegula::result::bodies::BodyMotion;
use tegula::result::joint_reaction;
use tegula::{System, Vec3, compile, mesh};

/// Bodies have the velocities of the model at the start of the first motion, behind a static step, too, and not again at that of the
/// second one.
#[test]
fn a_second_motion_begins_with_the_velocities_at_the_end_of_the_first_one() {
    let wheel = RigidBody {
        angular_velocity: [0.0, 0.0, 3.0],
        ..body("wheel", [0.0; 3], 1.0, Some([0.1, 0.1, 0.2]))
    };
    let hinge = revolute("hinge", "ground", "wheel", [0.0; 3], [0.0, 0.0, 1.0]);
    let mut model = machine(0.1, 0.01, vec![wheel], vec![hinge]);
    model.torsion_springs = vec![TorsionSpring {
        name: "coil".into(),
        between: between("ground", "wheel"),
        axis: [0.0, 0.0, 1.0],
        stiffness: 5.0,
        damping: 0.0,
        moment: None,
        free_angle: 20.0,
    }];
    let moves = model.analysis.clone();
    let rest = StaticAnalysis::default();
    model.steps = vec![
        AnalysisStep::new("rest", Analysis::Static(rest.clone())),
        AnalysisStep::new("first", moves.clone()),
        AnalysisStep::new("second", moves.clone()),
    ];
    let mesh = mesh::generators::generate(&model.mesh).unwrap();
    let compiler = compile::Compiler::new(&model, &mesh).unwrap();
    let system = compiler.system(0, None).unwrap();
    let mut start =
        tegula::analysis::statics::run(&system, &rest, None, &mut Notes::default()).unwrap().state;
    let mut expected = 3.0;
    for step in 1..3 {
        let system = compiler.system(step, Some(start.end_of_step())).unwrap();
        let Analysis::Transient(options) = &moves else { panic!() };
        let mut spins = Spins { system: &system, found: Vec::new() };
        start = dynamics::run(&system, options, None, &mut spins).unwrap().state;
        assert!((spins.found[0] - expected).abs() < 1e-9, "{step}: {} {expected}", spins.found[0]);
        expected = *spins.found.last().unwrap();
    }
    // About the free angle with ω² = 25, for 0.2 s.
    assert!((expected - 3.0 * 1_f64.cos()).abs() < 0.02, "{expected}");
}

/// Angular velocity of the first body about z in each state.
struct Spins<'a> {
    system: &'a System,
    found: Vec<f64>,
}

impl Observer for Spins<'_> {
    fn on_step(&mut self, step: &tegula::analysis::Step) -> tegula::Result<()> {
        let body = &self.system.coordinates.bodies[0];
        self.found.push(BodyMotion::new(self.system, step.state, body).angular_velocity.z);
        Ok(())
    }
}

/// A bar that a motor holds still in the field of gravity: a motion behind a static step begins with the reactions at its end.
#[test]
fn a_motion_behind_a_static_step_begins_with_its_reactions() {
    let bar = body("bar", [0.5, 0.0, 0.0], 2.0, Some([0.2, 0.2, 0.3]));
    let motor = Joint::DrivenAngle(DrivenAngleJoint {
        name: "motor".into(),
        between: between("ground", "bar"),
        axis: [0.0, 0.0, 1.0],
        angle: 90.0,
        amplitude: "still".into(),
    });
    let joints = vec![revolute("hinge", "ground", "bar", [0.0; 3], [0.0, 0.0, 1.0]), motor];
    let mut model = machine(0.02, 0.01, vec![bar], joints);
    model.amplitudes.insert("still".into(), Amplitude::Constant(ConstantAmplitude { value: 1.0 }));
    model.loads = gravity([0.0, -10.0, 0.0]);
    for order in [2, 4] {
        let Analysis::Transient(options) = &mut model.analysis else { panic!() };
        options.scheme = Scheme::EnergyMomentum(EnergyMomentumScheme { order });
        let options = options.clone();
        model.steps = vec![
            AnalysisStep::new("rest", Analysis::Static(StaticAnalysis::default())),
            AnalysisStep::new("motion", Analysis::Transient(options.clone())),
        ];
        let mesh = mesh::generators::generate(&model.mesh).unwrap();
        let compiler = compile::Compiler::new(&model, &mesh).unwrap();
        let system = compiler.system(0, None).unwrap();
        let rest =
            tegula::analysis::statics::run(&system, &StaticAnalysis::default(), None, &mut Notes::default());
        let system = compiler.system(1, Some(rest.unwrap().state.end_of_step())).unwrap();
        let mut reactions = Reactions { system: &system, found: Vec::new() };
        dynamics::run(&system, &options, None, &mut reactions).unwrap();
        assert_eq!(reactions.found.len(), 3);
        for (force, moment) in reactions.found {
            assert!((force - Vec3::new(0.0, 20.0, 0.0)).norm() < 1e-9, "{order}: {force}");
            assert!((moment - Vec3::new(0.0, 0.0, 10.0)).norm() < 1e-9, "{order}: {moment}");
        }
    }
}

/// Force of the first joint and moment of the second one in each state.
struct Reactions<'a> {
    system: &'a System,
    found: Vec<(Vec3, Vec3)>,
}

impl Observer for Reactions<'_> {
    fn on_step(&mut self, step: &tegula::analysis::Step) -> tegula::Result<()> {
        let of = |joint: usize| joint_reaction(self.system, step.state, &self.system.joints[joint]);
        self.found.push((of(0).0, of(1).1));
        Ok(())
    }
}
