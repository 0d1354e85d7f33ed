//! Numbers that the recursions run on: one sample (`f64`) or eight samples at once
//! (`lanes`).

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// Real arithmetic as the recursions need it.
pub trait Scalar:
    Copy
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + AddAssign
{
    /// The same number in every lane.
    fn constant(value: f64) -> Self;
    /// `self · factor + addend`, fused where the instruction set has it.
    fn mul_add(self, factor: Self, addend: Self) -> Self;
    /// Sine and cosine of an angle in rad.
    fn sin_cos(self) -> (Self, Self);
}

impl Scalar for f64 {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        // The method of the standard library is a function call on targets without the instruction.
        self * factor + addend
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        f64::sin_cos(self)
    }
}
