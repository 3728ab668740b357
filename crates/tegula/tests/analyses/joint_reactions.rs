//! Reactions of joints against the change of momentum.

use crate::common::Notes;
use crate::multibody::{between, body, gravity, machine, run};
use tegula::Vec3;
use tegula::model::*;
use tegula::norm::max_norm;
use tegula::result::joint_reaction;

/// The reaction of the energy–momentum scheme is the mean of a step: with the weight it changes the momentum, exactly, also where the
/// direction of the constraint turns.
#[test]
fn the_reaction_of_a_rod_is_the_change_of_momentum_of_each_step() {
    let rod = Joint::Distance(DistanceJoint {
        name: "rod".into(),
        between: between("ground", "m"),
        points: [[0.0; 3], [1.0, 0.0, 0.0]],
    });
    let mut model = machine(0.6, 0.02, vec![body("m", [1.0, 0.0, 0.0], 1.5, None)], vec![rod]);
    model.loads = gravity([0.0, -10.0, 0.0]);
    let mut notes = Notes::keeping();
    let (system, _) = run(&model, &mut notes);
    let mut worst = Vec::new();
    for pair in notes.states.windows(2) {
        let centre = system.coordinates.bodies[0].centre as usize;
        let [before, after] = [0, 1].map(|i: usize| Vec3::from(pair[i].v[centre]));
        let dt = pair[1].time - pair[0].time;
        let (force, _) = joint_reaction(&system, &pair[1], &system.joints[0]);
        worst.push(((after - before) * (1.5 / dt) + Vec3::new(0.0, 15.0, 0.0) - force).norm());
    }
    assert!(worst.len() > 20 && max_norm(&worst) < 1e-9, "{worst:?}");
}
