//! Numbers that the recursions run on: one sample (`f64`) or eight samples at once (`Lanes`).
//!
//! The recursions are written once, generic over [`Scalar`]; a batch puts samples in vector lanes,
//! so that one pass over the tree serves eight of them.

use std::array;
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

/// Samples side by side in one [`Lanes`].
pub const LANES: usize = 8;

/// Eight samples; `FUSED` where the code around it is compiled with fused multiply-add.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes<const FUSED: bool>(pub [f64; LANES]);

impl<const FUSED: bool> Lanes<FUSED> {
    /// Eight consecutive values of a series; short ends repeat the last value.
    #[inline(always)]
    pub fn load(series: &[f64], start: usize) -> Self {
        match series.get(start..start + LANES) {
            Some(full) => Self(array::from_fn(|lane| full[lane])),
            None => Self(array::from_fn(|lane| {
                series[(start + lane).min(series.len() - 1)]
            })),
        }
    }
}

macro_rules! lanewise {
    ($($trait:ident $method:ident $op:tt),*) => {$(
        impl<const FUSED: bool> $trait for Lanes<FUSED> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(array::from_fn(|lane| self.0[lane] $op other.0[lane]))
            }
        }
    )*};
}
lanewise!(Add add +, Sub sub -, Mul mul *);

impl<const FUSED: bool> Neg for Lanes<FUSED> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl<const FUSED: bool> AddAssign for Lanes<FUSED> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const FUSED: bool> Scalar for Lanes<FUSED> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self([value; LANES])
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        if FUSED {
            Self(array::from_fn(|lane| {
                self.0[lane].mul_add(factor.0[lane], addend.0[lane])
            }))
        } else {
            self * factor + addend
        }
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        if self.0.iter().all(|x| x.abs() < REDUCTION_LIMIT) {
            sin_cos_reduced(self)
        } else {
            let pairs = self.0.map(f64::sin_cos);
            (Self(pairs.map(|p| p.0)), Self(pairs.map(|p| p.1)))
        }
    }
}

/// Largest angle, rad, for which three-part reduction by π/2 keeps full precision without fused
/// arithmetic: the quadrant number has at most 17 bits, and the leading parts of π/2 have 33.
const REDUCTION_LIMIT: f64 = 1.0e5;

/// π/2 in three parts of 33, 33 and 53 bits (the split of fdlibm's `__ieee754_rem_pio2`).
const HALF_PI: [f64; 3] = [
    1.570_796_326_734_125_614_17e+00,
    6.077_100_506_303_965_976_60e-11,
    2.022_266_248_795_950_631_54e-21,
];

/// Coefficients of sin x = x + x³·P(x²) on |x| <= π/4 (Cephes, Moshier 1989), highest power first.
const SINE: [f64; 6] = [
    1.589_623_015_765_465_680_60e-10,
    -2.505_074_776_285_780_728_66e-8,
    2.755_731_362_138_572_452_13e-6,
    -1.984_126_982_958_953_859_96e-4,
    8.333_333_333_322_118_588_78e-3,
    -1.666_666_666_666_663_073_94e-1,
];

/// Coefficients of cos x = 1 − x²/2 + x⁴·Q(x²) on |x| <= π/4 (Cephes, Moshier 1989).
const COSINE: [f64; 6] = [
    -1.135_853_652_138_768_172_28e-11,
    2.087_570_084_197_473_166_85e-9,
    -2.755_731_417_929_673_881_12e-7,
    2.480_158_728_885_170_459_21e-5,
    -1.388_888_888_887_305_641_30e-3,
    4.166_666_666_666_659_295_18e-2,
];

#[inline(always)]
fn sin_cos_reduced<const FUSED: bool>(x: Lanes<FUSED>) -> (Lanes<FUSED>, Lanes<FUSED>) {
    // Adding and taking away 1.5·2^52 rounds to the nearest integer in the current mode.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    let quadrant: Lanes<FUSED> =
        Lanes(x.0.map(|v| v * std::f64::consts::FRAC_2_PI + ROUND)) - Lanes::constant(ROUND);
    let mut r = x;
    for part in HALF_PI {
        r = (-quadrant).mul_add(Lanes::constant(part), r);
    }
    let z = r * r;
    let horner = |table: [f64; 6]| {
        let mut sum = Lanes::constant(table[0]);
        for c in &table[1..] {
            sum = sum.mul_add(z, Lanes::constant(*c));
        }
        sum
    };
    let sine = (r * z).mul_add(horner(SINE), r);
    let cosine = (z * z).mul_add(
        horner(COSINE),
        Lanes::constant(-0.5).mul_add(z, Lanes::constant(1.0)),
    );
    let turn: [i64; LANES] = quadrant.0.map(|v| v as i64);
    let pick = |odd: [f64; LANES], even: [f64; LANES], shift: i64| {
        Lanes(array::from_fn(|lane| {
            let value = if turn[lane] & 1 == 1 { odd[lane] } else { even[lane] };
            if (turn[lane] + shift) & 2 == 2 { -value } else { value }
        }))
    };
    (pick(cosine.0, sine.0, 0), pick(sine.0, cosine.0, 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_of_lanes_match_the_standard_library() {
        for step in 0..40_000 {
            let start = -90.0 + step as f64 * 0.004_5;
            let angles: [f64; LANES] = array::from_fn(|lane| start * (1.0 + 117.3 * lane as f64));
            let (sine, cosine) = Lanes::<false>(angles).sin_cos();
            for lane in 0..LANES {
                let (s, c) = angles[lane].sin_cos();
                // One unit in the last place of 1, and the reduction error of a large angle.
                let bound = 3.0e-16 + 1.0e-21 * angles[lane].abs();
                assert!((sine.0[lane] - s).abs() <= bound, "sin {}", angles[lane]);
                assert!((cosine.0[lane] - c).abs() <= bound, "cos {}", angles[lane]);
            }
        }
    }

    #[test]
    fn angles_beyond_the_reduction_fall_back_to_the_standard_library() {
        let (sine, cosine) = Lanes::<true>([3.0e9; LANES]).sin_cos();
        assert_eq!((sine.0[3], cosine.0[3]), 3.0e9_f64.sin_cos());
    }

    #[test]
    fn a_short_end_repeats_its_last_value() {
        let lanes = Lanes::<false>::load(&[1.0, 2.0, 3.0], 1);
        assert_eq!(lanes.0, [2.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0]);
    }
}
