//! Values of eight lanes against the standard library, on every instruction set of this processor.

use crate::linalg::lanes::instructions::{self, InstructionSet, Kernel};
use crate::linalg::lanes::lane::{LANES, Lanes};
use crate::linalg::lanes::registers::Portable;
use crate::linalg::lanes::scalar::Scalar;
use std::array;

#[test]
fn sine_and_cosine_of_lanes_match_the_standard_library() {
    for step in 0..40_000 {
        let start = -90.0 + step as f64 * 0.004_5;
        let angles: [f64; LANES] = array::from_fn(|lane| start * (1.0 + 117.3 * lane as f64));
        let (sine, cosine) = Portable::from_array(angles).sin_cos();
        for (lane, angle) in angles.iter().enumerate() {
            let (s, c) = angle.sin_cos();
            // One unit in the last place of 1, and the reduction error of a large angle.
            let bound = 3.0e-16 + 1.0e-21 * angle.abs();
            assert!((sine.to_array()[lane] - s).abs() <= bound, "sin {angle}");
            assert!((cosine.to_array()[lane] - c).abs() <= bound, "cos {angle}");
        }
    }
}

#[test]
fn angles_beyond_the_reduction_fall_back_to_the_standard_library() {
    let (sine, cosine) = Portable::from_array([3.0e9; LANES]).sin_cos();
    assert_eq!(
        (sine.to_array()[3], cosine.to_array()[3]),
        3.0e9_f64.sin_cos()
    );
}

#[test]
fn a_short_end_repeats_its_last_value() {
    let lanes = Portable::load(&[1.0, 2.0, 3.0], 1);
    assert_eq!(lanes.to_array(), [2.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0]);
}

/// The sum of eight numbers.
struct Sum([f64; LANES]);

impl Kernel for Sum {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        L::from_array(self.0).sum()
    }
}

#[test]
fn the_sum_of_the_lanes_has_every_lane_once_on_every_instruction_set() {
    // Powers of two: each lane is one bit of the sum, which is exact.
    let powers = array::from_fn(|lane| f64::from(1 << lane));
    for set in [
        InstructionSet::Baseline,
        InstructionSet::Avx2,
        InstructionSet::Avx512,
    ] {
        assert_eq!(instructions::run(Sum(powers), set), 255.0, "{set:?}");
    }
}
