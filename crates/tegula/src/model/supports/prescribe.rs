//! One component of position, director or gradient prescribed as a function of time.

use super::{AXES, Constraints, PrescribedMotion, SupportKeys, SupportKind, SupportedNode};
use crate::checker::Checker;
use crate::model::{Axis, NodalVector, PrescribeComponent};

/// One component of position, director or gradient prescribed as a function of time.
pub(super) struct Prescribe;

impl SupportKind for Prescribe {
    type Keys = PrescribeComponent;

    fn check(keys: &PrescribeComponent, key: &str, c: &mut Checker) {
        c.finite(&format!("{key}.value"), "the prescribed value", &[keys.value]);
    }

    fn constrain(keys: &PrescribeComponent, node: &SupportedNode, out: &mut Constraints) {
        let axis = AXES[keys.component.index()];
        match keys.of {
            NodalVector::Position => out.prescribe(node.position, axis, keys.value),
            // At a fold a rotation changes each director differently: the tie moves the others.
            NodalVector::Director => out.prescribe(node.directors.get(..1).unwrap_or(&[]), axis, keys.value),
            NodalVector::FirstGradient | NodalVector::SecondGradient => {
                if node.gradients.is_empty() {
                    out.refuse((
                        "of",
                        "there are no gradients along the surface",
                        "only the nodes of `ancf-full` have them; prescribe positions and directors",
                    ));
                }
                let second = usize::from(keys.of == NodalVector::SecondGradient);
                let half: Vec<u32> = node.gradients.iter().copied().skip(second).step_by(2).collect();
                out.prescribe(&half, axis, keys.value);
            }
        }
    }

    fn example() -> PrescribeComponent {
        PrescribeComponent {
            on: "u_min".into(),
            of: NodalVector::Position,
            component: Axis::Z,
            value: 0.01,
            amplitude: None,
        }
    }
}

impl SupportKeys for PrescribeComponent {
    fn on(&self) -> &str {
        &self.on
    }

    fn motion(&self) -> Option<PrescribedMotion<'_>> {
        Some(PrescribedMotion {
            of: self.of,
            component: self.component,
            value: self.value,
            amplitude: &self.amplitude,
        })
    }
}
