//! The number type of the element kernels.

use std::ops::{Add, AddAssign, Mul, Sub};

/// Number type of the element kernels: `f64` in production, dual numbers in the tests that check forces and tangents as
/// derivatives.
pub trait Scalar:
    Copy + From<f64> + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + AddAssign
{
}

impl<T> Scalar for T where
    T: Copy + From<f64> + Add<Output = T> + Sub<Output = T> + Mul<Output = T> + AddAssign
{
}

/// A vector of three-dimensional space over any scalar.
pub type Triple<T> = [T; 3];

/// Scalar product.
#[inline(always)]
pub fn dot<T: Scalar>(a: Triple<T>, b: Triple<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
