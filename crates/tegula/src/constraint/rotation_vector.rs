//! Rotation vector of a rotation from its quadratic forms.
//!
//! The axial vector `w = θ̂ sin θ` of the skew part of a rotation matrix and the cosine `c = ½ (tr R − 1)` of its angle are linear in the
//! matrix, so that they are quadratic forms of nodal vectors. The rotation vector is `φ = κ(c) w` with
//!
//! ```text
//! κ(c) = θ/sin θ = arccos c/√(1 − c²),   κ' = (c κ − 1)/(1 − c²)
//! ```
//!
//! which is analytic at `c = 1`: with `z = ½ (1 − c)` it is the series `Σ a_n zⁿ`, `a₀ = 1`, `a_{n+1} = a_n (2n + 2)/(2n + 3)`
//! (M. Abramowitz, I. A. Stegun, *Handbook of Mathematical Functions* (1964), 15.1.6).

/// Size of z below which κ is summed from its series; otherwise its derivatives would lose digits.
const SERIES: f64 = 0.05;
/// Terms of the series: the last one is below the round-off of the second derivative.
const TERMS: i32 = 20;
/// Change of `1 + c`, relative to its smaller value, below which the divided difference is integrated: the error of the quadrature
/// is of the size of round-off there.
const NEAR: f64 = 0.01;

/// Factor κ by which the axial vector becomes the rotation vector, with its first and second derivative by the cosine c of the
/// angle; NaN for cosines out of the range of rotations.
pub fn factor(cosine: f64) -> [f64; 3] {
    let z = 0.5 * (1.0 - cosine);
    let [value, slope, curvature] = if z.abs() < SERIES { series(z) } else { closed(cosine, z) };
    // dz/dc = −½.
    [value, -0.5 * slope, 0.25 * curvature]
}

/// Divided difference `(κ(c₁) − κ(c₀))/(c₁ − c₀)`, without cancellation where the cosines are close to each other.
pub fn divided_difference([first, last]: [f64; 2]) -> f64 {
    let change = last - first;
    if change.abs() > NEAR * (1.0 + first.min(last)) {
        return (factor(last)[0] - factor(first)[0]) / change;
    }
    // Gauss quadrature of κ' with three points.
    let slope = |at: f64| factor(first + at * change)[1];
    let off = 0.15_f64.sqrt();
    (5.0 * (slope(0.5 - off) + slope(0.5 + off)) + 8.0 * slope(0.5)) / 18.0
}

/// Values of κ, dκ/dz and d²κ/dz² from the series.
fn series(z: f64) -> [f64; 3] {
    let (mut out, mut coefficient, mut powers) = ([0.0; 3], 1.0, [1.0, 0.0, 0.0]);
    for n in 0..TERMS {
        let n = f64::from(n);
        out.iter_mut().zip(&powers).for_each(|(out, power)| *out += coefficient * power);
        coefficient *= (2.0 * n + 2.0) / (2.0 * n + 3.0);
        let [p, p1, p2] = powers;
        powers = [p * z, p1 * z + p, p2 * z + 2.0 * p1];
    }
    out
}

/// Values of κ, dκ/dz and d²κ/dz² from the closed form and its differential equation `2z(1 − z) dκ/dz = 1 − (1 − 2z) κ`.
fn closed(cosine: f64, z: f64) -> [f64; 3] {
    let square = z * (1.0 - z);
    let value = cosine.acos() / (2.0 * square.sqrt());
    let slope = (1.0 - cosine * value) / (2.0 * square);
    [value, slope, (2.0 * value - 3.0 * cosine * slope) / (2.0 * square)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The factor is θ/sin θ, its derivatives by c = cos θ follow from those by θ: d/dc = −1/sin θ d/dθ.
    #[test]
    fn the_factor_and_its_derivatives_are_those_of_the_angle() {
        for angle in [0.3_f64, 0.44, 0.46, 1.0, 1.6, 2.3, 2.6] {
            let (s, c) = angle.sin_cos();
            let first = (s - angle * c) / s.powi(2);
            let second = (angle * s * s - 2.0 * c * (s - angle * c)) / s.powi(3);
            let by_cosine = (second * s - first * c) / s.powi(3);
            let expected = [angle / s, -first / s, by_cosine];
            for (found, expected) in factor(c).into_iter().zip(expected) {
                assert!((found / expected - 1.0).abs() < 3e-12, "{angle}: {found} {expected}");
            }
        }
        // κ = 1 + (1 − c)/3 + 2 (1 − c)²/15 + … (θ/sin θ = 1 + θ²/6 + 7 θ⁴/360 + …, 1 − c = θ²/2 − θ⁴/24 + …).
        let [value, slope, curvature] = factor(1.0);
        assert!(value == 1.0 && (slope + 1.0 / 3.0).abs() < 1e-15 && (curvature - 4.0 / 15.0).abs() < 1e-15);
    }

    #[test]
    fn divided_differences_join_where_the_quadrature_begins() {
        for cosine in [-0.86_f64, -0.5, 0.0, 0.7, 0.95] {
            for part in [0.2, 0.9, 0.999_999, 1.000_001, 1.1, 5.0] {
                let change = part * NEAR * (1.0 + cosine);
                let found = divided_difference([cosine, cosine + change]) * change;
                let expected = factor(cosine + change)[0] - factor(cosine)[0];
                let size = factor(cosine)[0];
                assert!((found - expected).abs() < 2e-15 * size, "{cosine} {part}: {found} {expected}");
            }
            let slope = factor(cosine)[1];
            assert!((divided_difference([cosine; 2]) / slope - 1.0).abs() < 1e-14);
        }
        assert!(factor(1.2)[0].is_nan() && factor(-1.1)[0].is_nan() && factor(f64::NAN)[0].is_nan());
    }
}
