//! Sine and cosine of eight angles at once.

use crate::linalg::lanes::lane::{LANES, Lanes};
use crate::linalg::lanes::scalar::Scalar;

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

/// Sine and cosine of angles in rad.
#[inline(always)]
pub(super) fn sin_cos<L: Lanes>(x: L) -> (L, L) {
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
