//! Check of a material law by differences: the stress is the derivative of the energy, and the tangent that of the stress.

use tegula::material::{Response, Strain};
use tegula::norm::max_norm;

/// Components of strains.
const STRAINS: [&str; 6] = ["xx", "yy", "2xy", "zz", "2xz", "2yz"];
/// Components of stresses.
const STRESSES: [&str; 6] = ["xx", "yy", "xy", "zz", "xz", "yz"];

/// Small strain of no symmetry at which a law is checked; laws have their kinks at rounder numbers.
const AT: [f64; 6] = [1.037e-3, -0.519e-3, 0.313e-3, 0.207e-3, 0.729e-3, -0.411e-3];
/// Half of a difference of strains. Differences of stresses C ε have round-off of 1e-11 C and errors of (step/strain at which the law bends)².
const STEP: f64 = 1e-5;
/// Largest error over the largest component.
const TOLERANCE: f64 = 1e-4;
/// Round-off of an energy, over the energy.
const ROUND_OFF: f64 = 32.0 * f64::EPSILON;

/// Strains whose responses show whether a law is consistent: zero, a small strain, and its neighbours.
pub fn strains() -> Vec<Strain> {
    let at = Strain::from(AT);
    let beside = |i: usize| [1.0, -1.0].map(|sign| at + Strain::ith(i, sign * STEP));
    [Strain::zeros(), at].into_iter().chain((0..6).flat_map(beside)).collect()
}

/// Mistake in the responses at [`strains`], as words behind the name of the law; nothing is known of strains without a response.
pub fn mistake(responses: &[Option<Response>]) -> Option<String> {
    let [_, Some(at), beside @ ..] = responses else { return None };
    let pairs: Vec<(usize, &Response, &Response)> = beside
        .chunks_exact(2)
        .enumerate()
        .filter_map(|(i, pair)| Some((i, pair[0].as_ref()?, pair[1].as_ref()?)))
        .collect();
    let place = || {
        let strain: Vec<_> = AT.iter().map(f64::to_string).collect();
        format!("at the strain [{}]", strain.join(", "))
    };
    wrong_stress(at, &pairs)
        .map(|(i, stress, difference)| {
            format!(
                "has a stress {} = {stress:.6e} {}, and its energy has the derivative {difference:.6e} by {}: the stress is the derivative of the \
                 energy by the strains xx, yy, 2xy, zz, 2xz, 2yz",
                STRESSES[i],
                place(),
                STRAINS[i]
            )
        })
        .or_else(|| {
            let (i, j, tangent, difference) = wrong_tangent(at, &pairs)?;
            Some(format!(
                "has the tangent {tangent:.6e} of stress {} by strain {} {}, and the stress has the derivative {difference:.6e}: the tangent \
                 is the derivative of the stress by the strains xx, yy, 2xy, zz, 2xz, 2yz",
                STRESSES[i],
                STRAINS[j],
                place()
            ))
        })
}

/// Component of the stress that differs most from the derivative of the energy, where it is too much, with both.
fn wrong_stress(at: &Response, pairs: &[(usize, &Response, &Response)]) -> Option<(usize, f64, f64)> {
    let differences: Vec<(usize, f64, f64)> = pairs
        .iter()
        .map(|&(i, more, less)| (i, at.stress[i], (more.energy - less.energy) / (2.0 * STEP)))
        .collect();
    // Stresses may cancel; they are not known better than the tangent times the strain.
    let size = max_norm(differences.iter().map(|(.., difference)| *difference))
        .max(at.stress.amax())
        .max(at.tangent.amax() * Strain::from(AT).amax());
    // An energy may have an offset, whose round-off the differences have.
    let energy = max_norm(pairs.iter().flat_map(|(_, more, less)| [more.energy, less.energy]));
    let tolerance = TOLERANCE * size + ROUND_OFF * energy / STEP;
    worst(
        differences.into_iter().map(|(i, stress, difference)| ((i, stress, difference), stress - difference)),
    )
    .and_then(|(found, error)| (error > tolerance).then_some(found))
}

/// Entry of the tangent that differs most from the derivative of the stress, where it is too much, with both.
fn wrong_tangent(at: &Response, pairs: &[(usize, &Response, &Response)]) -> Option<(usize, usize, f64, f64)> {
    let differences: Vec<(usize, usize, f64, f64)> = pairs
        .iter()
        .flat_map(|&(j, more, less)| {
            let derivative = (more.stress - less.stress) / (2.0 * STEP);
            (0..6).map(move |i| (i, j, at.tangent[(i, j)], derivative[i]))
        })
        .collect();
    let size = max_norm(differences.iter().map(|(.., difference)| *difference)).max(at.tangent.amax());
    let tolerance = TOLERANCE * size + ROUND_OFF * at.stress.amax() / STEP;
    worst(differences.into_iter().map(|found| (found, found.2 - found.3)))
        .and_then(|(found, error)| (error > tolerance).then_some(found))
}

/// Item with the largest absolute error.
fn worst<T>(items: impl Iterator<Item = (T, f64)>) -> Option<(T, f64)> {
    items.map(|(item, error)| (item, error.abs())).max_by(|(_, a), (_, b)| a.total_cmp(b))
}
