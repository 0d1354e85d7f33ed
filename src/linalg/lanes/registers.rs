//! Eight numbers in the registers of an instruction set, one type for each.
//!
//! The methods compile to single instructions only inside functions that enable the set, which is why
//! all of them are always inlined; [`crate::linalg::lanes::instructions`] holds those functions.

#![allow(
    unsafe_code,
    reason = "vector instructions, which run where the processor has them"
)]

use crate::linalg::lanes::lane::{LANES, Lanes};
use crate::linalg::lanes::scalar::Scalar;
use crate::linalg::lanes::sine::sin_cos;
use std::array;
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

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
    #[inline(always)]
    fn sum(self) -> f64 {
        let s = self.0;
        ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]))
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
        __m256d, __m512d, _mm_add_pd, _mm_add_sd, _mm_cvtsd_f64, _mm_unpackhi_pd, _mm256_add_pd,
        _mm256_castpd256_pd128, _mm256_extractf128_pd, _mm256_fmadd_pd, _mm256_loadu_pd,
        _mm256_mul_pd, _mm256_set1_pd, _mm256_storeu_pd, _mm256_sub_pd, _mm512_add_pd,
        _mm512_fmadd_pd, _mm512_loadu_pd, _mm512_mul_pd, _mm512_reduce_add_pd, _mm512_set1_pd,
        _mm512_storeu_pd, _mm512_sub_pd,
    };

    /// Eight numbers in one register; only where the processor has AVX-512F.
    #[derive(Clone, Copy, Debug)]
    pub struct Avx512(__m512d);

    // SAFETY of every block below: these types are made and used only inside functions of
    // `crate::linalg::lanes::instructions` that run after their instruction set was detected; loads and
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
        #[inline(always)]
        fn sum(self) -> f64 {
            unsafe { _mm512_reduce_add_pd(self.0) }
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
        #[inline(always)]
        fn sum(self) -> f64 {
            unsafe {
                let pairs = _mm256_add_pd(self.0[0], self.0[1]);
                let low = _mm256_castpd256_pd128(pairs);
                let two = _mm_add_pd(low, _mm256_extractf128_pd::<1>(pairs));
                _mm_cvtsd_f64(_mm_add_sd(two, _mm_unpackhi_pd(two, two)))
            }
        }
    }
}
