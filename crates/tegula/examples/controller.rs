//! A controller damps a swinging strip: between time steps it sets a force from the velocity of the tip.
//!
//! `cargo run --release -p tegula --example controller`
//!
//! The force −c v at the tip does the work of a damper of constant c. The strip is a cantilever of mass m. Each of
//! its modes moves the tip as an oscillator of the mass m/4, since `∫ρA φ² dx = m φ(L)²/4` for the modes φ of a clamped-free
//! beam (W. Weaver, S. P. Timoshenko, D. H. Young, *Vibration Problems in Engineering*, 5th ed. 1990, Sect. 5.11). So the
//! energy falls with `exp(−c t/(m/4))`.

use tegula::analysis::{Silent, dynamics};
use tegula::compile;
use tegula::mesh::generators::generate;
use tegula::model::{
    Amplitude, Analysis, Condition, ConstantAmplitude, InitialVelocity, Isotropic, Load, MeshSource, Model,
    OnSet, PlateMesh, TransientAnalysis, VectorLoad,
};

const WIDTH: f64 = 0.1;
const THICKNESS: f64 = 0.01;
/// Damping constant of the controller (N s/m).
const DAMPING: f64 = 5.0;

fn main() -> tegula::Result<()> {
    let options = TransientAnalysis { time_step: Some(1e-3), ..TransientAnalysis::new(1.0) };
    let mesh = MeshSource::Plate(PlateMesh::new([1.0, WIDTH], [16, 2]));
    let mut model = Model::new(
        mesh,
        Analysis::Transient(options.clone()),
        Isotropic::new(2.1e11, 0.0, 7850.0),
        THICKNESS,
    );
    model.conditions = vec![Condition::Clamp(OnSet::new("u_min"))];
    model.initial_velocities = vec![InitialVelocity {
        on: "all".into(),
        velocity: [0.0; 3],
        angular_velocity: [0.0, -0.3, 0.0],
        center: [0.0; 3],
    }];
    model.amplitudes.insert("control".into(), Amplitude::Constant(ConstantAmplitude { value: 0.0 }));
    let force =
        VectorLoad { amplitude: Some("control".into()), ..VectorLoad::new("u_max", [0.0, 0.0, 1.0 / WIDTH]) };
    model.loads = vec![Load::Edge(force)];

    let mesh = generate(&model.mesh)?;
    let mut system = compile::build(&model, &mesh)?;
    let Some(control) = system.signal("control") else { unreachable!("the model has this amplitude") };
    let tip = system.coordinates.position_of[mesh.nodes_on("u_max").unwrap_or_default()[1] as usize] as usize;

    let mut steps = dynamics::steps(&system, &options, None)?;
    steps.begin(&mut Silent)?;
    let energy = |steps: &dyn tegula::analysis::Stepper| steps.balance().kinetic + steps.balance().strain;
    let first = energy(steps.as_ref());
    let mut printed = 0.0;
    while steps.state().time < steps.end() {
        control.set(-DAMPING * steps.state().v[tip][2]);
        steps.advance(&mut Silent)?;
        if steps.state().time > printed + 0.0999 {
            printed = steps.state().time;
            println!("time {printed:.1} s: energy {:.3e} J", energy(steps.as_ref()));
        }
    }
    let rate = (first / energy(steps.as_ref())).ln() / steps.end();
    let expected = DAMPING / (0.25 * 7850.0 * THICKNESS * WIDTH);
    println!("energy decays with {rate:.3} 1/s, that of oscillators with {expected:.3} 1/s");
    assert!((rate / expected - 1.0).abs() < 0.03);
    Ok(())
}
