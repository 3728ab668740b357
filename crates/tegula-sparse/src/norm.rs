//! Maximum norms that propagate NaN.
//!
//! `f64::max` drops NaN, so the largest of many NaN, folded from 0, is 0: a deviation that would pass every bound.

use std::borrow::Borrow;

/// Larger of two numbers; NaN if either is NaN.
pub fn larger(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

/// Maximum norm max |xᵢ|; NaN if a value is NaN, or if there are no values.
pub fn max_norm<T: Borrow<f64>>(values: impl IntoIterator<Item = T>) -> f64 {
    values.into_iter().map(|x| x.borrow().abs()).reduce(larger).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nan_anywhere_makes_the_norm_nan() {
        assert_eq!(max_norm([1.0, -3.0, 2.0]), 3.0);
        assert_eq!(max_norm([0.0, f64::NEG_INFINITY]), f64::INFINITY);
        for place in 0..3 {
            let mut values = [1.0, -3.0, 2.0];
            values[place] = f64::NAN;
            assert!(max_norm(values).is_nan(), "{place}");
        }
        assert!(max_norm::<f64>([]).is_nan());
        assert!(larger(f64::NAN, 1.0).is_nan() && larger(1.0, f64::NAN).is_nan());
        assert_eq!((larger(1.0, 2.0), larger(2.0, 1.0)), (2.0, 2.0));
    }
}
