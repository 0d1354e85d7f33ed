//! Eight numbers side by side, one type per instruction set.
//!
//! The methods compile to single instructions only inside functions that enable the set, which is why
//! all of them are always inlined; [`crate::robot::instructions`] holds those functions.

#![allow(
    unsafe_code,
    reason = "vector instructions, which run where the processor has them"
)]

use crate::robot::scalar::Scalar;
use std::array;
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// Numbers in one value.
pub const LANES: usize = 8;

/// Eight numbers that are computed with at once.
pub trait Lanes: Scalar {
    fn from_array(values: [f64; LANES]) -> Self;
    fn to_array(self) -> [f64; LANES];

    /// Eight consecutive values of a series from `start`; a short end repeats its last value.
    #[inline(always)]
    fn load(series: &[f64], start: usize) -> Self {
        if let Some(Ok(whole)) = series
            .get(start..start + LANES)
            .map(<[f64; LANES]>::try_from)
        {
            return Self::from_array(whole);
        }
        let mut values = [0.0; LANES];
        for (lane, value) in values.iter_mut().enumerate() {
            *value = series[(start + lane).min(series.len() - 1)];
        }
        Self::from_array(values)
    }

    /// Writes the eight values to a series from `start`.
    #[inline(always)]
    fn store(self, series: &mut [f64], start: usize) {
        series[start..start + LANES].copy_from_slice(&self.to_array());
    }
}

/// Eight numbers for any processor.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Portable([f64; LANES]);

impl Lanes for Portable {
    #[inline(always)]
    fn from_array(values: [f64; LANES]) -> Self {
        Self(values)
    }
    #[inline(always)]
    fn to_array(self) -> [f64; LANES] {
        self.0
    }
}

impl Scalar for Portable {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self([value; LANES])
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        self * factor + addend
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        sin_cos(self)
    }
}

/// Addition, subtraction and multiplication of a type, each an expression in `a` and `b`; what else
/// the recursions need follows. Expressions and not functions: a call in between would keep the
/// compiler from inlining the instruction.
macro_rules! arithmetic {
    ($type:ty, |$a:ident, $b:ident| $add:expr, $subtract:expr, $multiply:expr) => {
        impl Add for $type {
            type Output = Self;
            #[inline(always)]
            fn add(self, $b: Self) -> Self {
                let $a = self;
                $add
            }
        }
        impl Sub for $type {
            type Output = Self;
            #[inline(always)]
            fn sub(self, $b: Self) -> Self {
                let $a = self;
                $subtract
            }
        }
        impl Mul for $type {
            type Output = Self;
            #[inline(always)]
            fn mul(self, $b: Self) -> Self {
                let $a = self;
                $multiply
            }
        }
        impl Neg for $type {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self::constant(0.0) - self
            }
        }
        impl AddAssign for $type {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }
    };
}

arithmetic!(
    Portable,
    |a, b| Self(array::from_fn(|lane| a.0[lane] + b.0[lane])),
    Self(array::from_fn(|lane| a.0[lane] - b.0[lane])),
    Self(array::from_fn(|lane| a.0[lane] * b.0[lane]))
);

#[cfg(target_arch = "x86_64")]
pub use x86::{Avx2, Avx512};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Add, AddAssign, LANES, Lanes, Mul, Neg, Scalar, Sub, sin_cos};
    use std::arch::x86_64::{
        __m256d, __m512d, _mm256_add_pd, _mm256_fmadd_pd, _mm256_loadu_pd, _mm256_mul_pd,
        _mm256_set1_pd, _mm256_storeu_pd, _mm256_sub_pd, _mm512_add_pd, _mm512_fmadd_pd,
        _mm512_loadu_pd, _mm512_mul_pd, _mm512_set1_pd, _mm512_storeu_pd, _mm512_sub_pd,
    };

    /// Eight numbers in one register; only where the processor has AVX-512F.
    #[derive(Clone, Copy, Debug)]
    pub struct Avx512(__m512d);

    // SAFETY of every block below: these types are made and used only inside functions of
    // `crate::robot::instructions` that run after their instruction set was detected; loads and
    // stores are unaligned and stay within an array of eight.
    arithmetic!(
        Avx512,
        |a, b| unsafe { Self(_mm512_add_pd(a.0, b.0)) },
        unsafe { Self(_mm512_sub_pd(a.0, b.0)) },
        unsafe { Self(_mm512_mul_pd(a.0, b.0)) }
    );

    impl Scalar for Avx512 {
        #[inline(always)]
        fn constant(value: f64) -> Self {
            unsafe { Self(_mm512_set1_pd(value)) }
        }
        #[inline(always)]
        fn mul_add(self, factor: Self, addend: Self) -> Self {
            unsafe { Self(_mm512_fmadd_pd(self.0, factor.0, addend.0)) }
        }
        #[inline(always)]
        fn sin_cos(self) -> (Self, Self) {
            sin_cos(self)
        }
    }

    impl Lanes for Avx512 {
        #[inline(always)]
        fn from_array(values: [f64; LANES]) -> Self {
            unsafe { Self(_mm512_loadu_pd(values.as_ptr())) }
        }
        #[inline(always)]
        fn to_array(self) -> [f64; LANES] {
            let mut values = [0.0; LANES];
            unsafe { _mm512_storeu_pd(values.as_mut_ptr(), self.0) };
            values
        }
    }

    /// Eight numbers in two registers; only where the processor has AVX2 and FMA.
    #[derive(Clone, Copy, Debug)]
    pub struct Avx2([__m256d; 2]);

    arithmetic!(
        Avx2,
        |a, b| unsafe { Self([_mm256_add_pd(a.0[0], b.0[0]), _mm256_add_pd(a.0[1], b.0[1])]) },
        unsafe { Self([_mm256_sub_pd(a.0[0], b.0[0]), _mm256_sub_pd(a.0[1], b.0[1])]) },
        unsafe { Self([_mm256_mul_pd(a.0[0], b.0[0]), _mm256_mul_pd(a.0[1], b.0[1])]) }
    );

    impl Scalar for Avx2 {
        #[inline(always)]
        fn constant(value: f64) -> Self {
            unsafe { Self([_mm256_set1_pd(value); 2]) }
        }
        #[inline(always)]
        fn mul_add(self, factor: Self, addend: Self) -> Self {
            unsafe {
                Self([
                    _mm256_fmadd_pd(self.0[0], factor.0[0], addend.0[0]),
                    _mm256_fmadd_pd(self.0[1], factor.0[1], addend.0[1]),
                ])
            }
        }
        #[inline(always)]
        fn sin_cos(self) -> (Self, Self) {
            sin_cos(self)
        }
    }

    impl Lanes for Avx2 {
        #[inline(always)]
        fn from_array(values: [f64; LANES]) -> Self {
            unsafe {
                Self([
                    _mm256_loadu_pd(values.as_ptr()),
                    _mm256_loadu_pd(values[LANES / 2..].as_ptr()),
                ])
            }
        }
        #[inline(always)]
        fn to_array(self) -> [f64; LANES] {
            let mut values = [0.0; LANES];
            unsafe {
                _mm256_storeu_pd(values.as_mut_ptr(), self.0[0]);
                _mm256_storeu_pd(values[LANES / 2..].as_mut_ptr(), self.0[1]);
            }
            values
        }
    }
}

/// Largest angle, rad, for which three-part reduction by π/2 keeps full precision without fused
/// arithmetic: the quadrant number has at most 17 bits, and the leading parts of π/2 have 33.
const REDUCTION_LIMIT: f64 = 1.0e5;

/// π/2 in three parts of 33, 33 and 53 bits (the split of fdlibm's `__ieee754_rem_pio2`).
const HALF_PI: [f64; 3] = [
    1.570_796_326_734_125_6e+00,
    6.077_100_506_303_966e-11,
    2.022_266_248_795_950_6e-21,
];

/// Coefficients of sin x = x + x³·P(x²) on |x| <= π/4 (Cephes, Moshier 1989), highest power first.
const SINE: [f64; 6] = [
    1.589_623_015_765_465_7e-10,
    -2.505_074_776_285_780_7e-8,
    2.755_731_362_138_572_5e-6,
    -1.984_126_982_958_954e-4,
    8.333_333_333_322_118e-3,
    -1.666_666_666_666_663e-1,
];

/// Coefficients of cos x = 1 − x²/2 + x⁴·Q(x²) on |x| <= π/4 (Cephes, Moshier 1989).
const COSINE: [f64; 6] = [
    -1.135_853_652_138_768_2e-11,
    2.087_570_084_197_473e-9,
    -2.755_731_417_929_674e-7,
    2.480_158_728_885_170_5e-5,
    -1.388_888_888_887_305_6e-3,
    4.166_666_666_666_66e-2,
];

/// Nearest integer: adding 1.5·2^52 leaves no room for a fraction.
#[inline(always)]
fn round<T: Scalar>(x: T) -> T {
    let shift = T::constant(6_755_399_441_055_744.0);
    (x + shift) - shift
}

/// For whole x: ⌊x/2⌋, and x modulo 2 as 0 or 1.
#[inline(always)]
fn halve<T: Scalar>(x: T) -> (T, T) {
    let half = round(x.mul_add(T::constant(0.5), T::constant(-0.25)));
    (half, half.mul_add(T::constant(-2.0), x))
}

#[inline(always)]
fn horner<T: Scalar>(table: [f64; 6], z: T) -> T {
    let mut sum = T::constant(table[0]);
    for c in &table[1..] {
        sum = sum.mul_add(z, T::constant(*c));
    }
    sum
}

/// True where reduction by π/2 is exact enough; false for numbers that are not finite.
fn all_reducible(angles: &[f64; LANES]) -> bool {
    angles.iter().all(|a| a.abs() < REDUCTION_LIMIT)
}

#[inline(always)]
fn sin_cos<L: Lanes>(x: L) -> (L, L) {
    let angles = x.to_array();
    if !all_reducible(&angles) {
        let pairs = angles.map(f64::sin_cos);
        let (sines, cosines) = (pairs.map(|p| p.0), pairs.map(|p| p.1));
        return (L::from_array(sines), L::from_array(cosines));
    }
    let one = L::constant(1.0);
    let quadrant = round(x * L::constant(std::f64::consts::FRAC_2_PI));
    let mut r = x;
    for part in HALF_PI {
        r = quadrant.mul_add(L::constant(-part), r);
    }
    let z = r * r;
    let sine = (r * z).mul_add(horner(SINE, z), r);
    let cosine = (z * z).mul_add(horner(COSINE, z), L::constant(-0.5).mul_add(z, one));
    // sin changes sign with ⌊k/2⌋, cos with ⌊(k+1)/2⌋, and odd quadrants exchange them; factors of
    // 0 and 1 select without rounding.
    let (half, odd) = halve(quadrant);
    let (even, minus_two) = (one - odd, L::constant(-2.0));
    let sine_sign = halve(half).1.mul_add(minus_two, one);
    let cosine_sign = halve(half + odd).1.mul_add(minus_two, one);
    (
        sine_sign * sine.mul_add(even, cosine * odd),
        cosine_sign * cosine.mul_add(even, sine * odd),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_of_lanes_match_the_standard_library() {
        for step in 0..40_000 {
            let start = -90.0 + step as f64 * 0.004_5;
            let angles: [f64; LANES] = array::from_fn(|lane| start * (1.0 + 117.3 * lane as f64));
            let (sine, cosine) = Portable(angles).sin_cos();
            for (lane, angle) in angles.iter().enumerate() {
                let (s, c) = angle.sin_cos();
                // One unit in the last place of 1, and the reduction error of a large angle.
                let bound = 3.0e-16 + 1.0e-21 * angle.abs();
                assert!((sine.0[lane] - s).abs() <= bound, "sin {angle}");
                assert!((cosine.0[lane] - c).abs() <= bound, "cos {angle}");
            }
        }
    }

    #[test]
    fn angles_beyond_the_reduction_fall_back_to_the_standard_library() {
        let (sine, cosine) = Portable([3.0e9; LANES]).sin_cos();
        assert_eq!((sine.0[3], cosine.0[3]), 3.0e9_f64.sin_cos());
    }

    #[test]
    fn a_short_end_repeats_its_last_value() {
        let lanes = Portable::load(&[1.0, 2.0, 3.0], 1);
        assert_eq!(lanes.0, [2.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0]);
    }
}
