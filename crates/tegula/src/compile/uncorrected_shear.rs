//! Layers whose transverse shear is far too stiff in elements without a shear correction.

use crate::Issue;
use crate::model::Model;
use crate::section::compiled::Resultant;
use crate::system::{ShellSection, System};

/// Shear stiffness of the layers side by side over that of equilibrium, above which a warning tells of it. It is 1.2 in a homogeneous sheet and
/// about 1.5 in cross plies of carbon fibres.
const TOO_STIFF: f64 = 2.0;

/// Warnings of laminates in elements with three-dimensional stresses: their shear strain is one for all layers, so that a soft core counts as little as
/// the stiff faces beside it unless the section has a shear correction.
pub(super) fn warnings(model: &Model, system: &System) -> Vec<Issue> {
    let mut found: Vec<Issue> = Vec::new();
    for of in system.sections.iter() {
        let key = format!("sections[{}].shear_correction", of.of_model);
        let given = model.sections.get(of.of_model).is_none_or(|section| section.shear_correction.is_some());
        if given || found.iter().any(|issue| issue.place.key == key) {
            continue;
        }
        let Some(factors) = factors(of) else { continue };
        let least = factors[0].min(factors[1]);
        if least < 1.0 / TOO_STIFF {
            found.push(Issue::new(
                &key,
                format!(
                    "the layers differ so much in their shear moduli that the section is up to {:.0} times as stiff in transverse shear as \
                     equilibrium over the thickness makes it: elements `{}` have no shear correction unless it is given",
                    1.0 / least,
                    model.sections[of.of_model].element.name()
                ),
                format!(
                    "give `shear_correction = [{:.3e}, {:.3e}]`, or take the element `ems` or `mitc4`, which finds it from equilibrium",
                    factors[0], factors[1]
                ),
            ));
        }
    }
    found
}

/// Shear stiffness by equilibrium over that of the layers side by side, along and across the section's direction; `None` for elements that take the
/// former.
fn factors(of: &ShellSection) -> Option<[f64; 2]> {
    let Resultant::Laminate(laminate) = &of.section.resultant else { return None };
    if !of.element.is_solid() || of.section.layers.len() < 2 {
        return None;
    }
    let exact = laminate.stiffness(0.0).shear;
    let mut sum = [0.0; 2];
    for layer in &of.section.layers {
        let c = of.section.stiffness_3d(layer, layer.angle);
        sum[0] += c[(4, 4)] * (layer.top - layer.bottom);
        sum[1] += c[(5, 5)] * (layer.top - layer.bottom);
    }
    Some([exact[(0, 0)] / sum[0], exact[(1, 1)] / sum[1]])
}
