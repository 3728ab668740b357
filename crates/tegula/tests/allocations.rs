//! A time step takes no memory: everything is made when the analysis begins. Explicit steps find their critical step
//! anew meanwhile.
//!
//! One test only, so that no other one allocates meanwhile.

#![allow(clippy::unwrap_used)]

mod common;

use std::alloc::System as Allocator;

use common::{compile, on, quarter_cylinder};
use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};
use tegula::analysis::{Observer, Step, dynamics};
use tegula::model::*;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<Allocator> = &INSTRUMENTED_SYSTEM;

/// Allocations so far, at the end of each step.
struct Counts(Vec<usize>);

impl Observer for Counts {
    fn on_step(&mut self, _: &Step) -> tegula::Result<()> {
        let stats = ALLOCATOR.stats();
        assert!(self.0.len() < self.0.capacity());
        self.0.push(stats.allocations + stats.reallocations);
        Ok(())
    }
}

#[test]
fn a_step_allocates_nothing() {
    // From within the pool: queues of work given to it from outside grow now and then.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    for element in [ElementKind::Ems, ElementKind::Mitc4, ElementKind::Cm] {
        for scheme in [
            Scheme::default(),
            Scheme::Hht(HhtScheme { alpha: -0.1 }),
            Scheme::EnergyMomentum(EnergyMomentumScheme { order: 2 }),
            Scheme::Bdf2(Bdf2Scheme {}),
            Scheme::Explicit(ExplicitScheme { scale_director_inertia: true }),
        ] {
            let explicit = matches!(scheme, Scheme::Explicit(_));
            if explicit && element == ElementKind::Mitc4 {
                continue;
            }
            let mut m = quarter_cylinder(12, 2.1e7);
            m.sections[0].element = element;
            m.sections[0].total_mass = Some(5.0);
            m.sections[0].retardation_time = 1e-5;
            m.conditions = vec![Condition::Spherical(on("u_min_v_min"))];
            m.loads = vec![Load::Gravity(GravityLoad { value: [0.0, 0.0, -9.81], amplitude: None })];
            if matches!(scheme, Scheme::EnergyMomentum(_)) {
                let rim = RigidBody::new("rim", [1.0, 0.5, 1.2], 1.0, Some([0.1; 3]));
                m.bodies = vec![RigidBody { distributed: vec!["u_max".into()], ..rim }];
                // One that slides and one that sticks.
                for (name, speed, coefficient) in [("slides", 1.0, 0.1), ("sticks", 0.0, 0.8)] {
                    let block = RigidBody::new(name, [2.0, 0.0, 0.0], 1.0, Some([0.1; 3]));
                    m.bodies.push(RigidBody { velocity: [speed, 0.0, speed], ..block });
                    m.joints.push(Joint::Prismatic(CoordinateJoint {
                        name: format!("{name} on the slope"),
                        between: ["ground".into(), name.into()],
                        at: [2.0, 0.0, 0.0],
                        axis: [1.0, 0.0, 1.0],
                        friction: Some(JointFriction {
                            coefficient,
                            static_coefficient: Some(1.2),
                            ..JointFriction::default()
                        }),
                        stops: Some(JointStops { lower: Some(-1.0), upper: Some(1.0), restitution: 0.5 }),
                        second_at: None,
                        second_axis: None,
                    }));
                }
            }
            if explicit {
                let rim = RigidBody::new("rim", [1.0, 0.5, 1.2], 1.0, Some([0.1; 3]));
                m.bodies = vec![
                    RigidBody { attached: vec!["u_max".into()], ..rim },
                    RigidBody::new("slides", [1.4, 0.5, 1.2], 1.0, Some([0.1; 3])),
                ];
                m.joints = vec![Joint::Revolute(
                    AxisJoint {
                        name: "hinge".into(),
                        between: ["rim".into(), "slides".into()],
                        at: [1.2, 0.5, 1.2],
                        axis: [0.0, 1.0, 0.0],
                        second_at: None,
                        second_axis: None,
                    }
                    .into(),
                )];
            }
            if !m.bodies.is_empty() {
                m.springs = vec![SpringDamper {
                    across: None,
                    name: "bump stop".into(),
                    between: ["ground".into(), "slides".into()],
                    points: [[0.0; 3], [2.0, 0.0, 0.0]],
                    stiffness: 0.0,
                    damping: 0.0,
                    length: None,
                    force: Some("0.5*x*exp(x) + 5*max(x - 0.01, 0)^1.5 + v*abs(v)".into()),
                }];
            }
            let time_step = if explicit { None } else { Some(0.01) };
            let options = TransientAnalysis { scheme, time_step, ..TransientAnalysis::new(0.1) };
            m.analysis = Analysis::Transient(options.clone());
            let (_, system) = compile(&m);
            let mut counts = Counts(Vec::with_capacity(100_000));
            pool.install(|| dynamics::run(&system, &options, None, &mut counts)).unwrap();
            let per_step: Vec<usize> = counts.0.windows(2).map(|w| w[1] - w[0]).collect();
            assert!(per_step.len() >= 10);
            // Queues between threads and their pools of memory reach their size in the first steps.
            assert!(per_step[3..].iter().all(|n| *n == 0), "{element:?} {scheme:?}: {per_step:?}");
        }
    }
}
