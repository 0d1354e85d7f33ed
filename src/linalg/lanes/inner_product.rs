//! The inner product of two series.

use crate::linalg::lanes::instructions::{self, InstructionSet, Kernel};
use crate::linalg::lanes::lane::{LANES, Lanes};

/// Sums that are formed side by side, so that none waits for the one before.
const SUMS: usize = 4;

/// Σ a b over the length of the shorter series.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    instructions::run(InnerProduct(a, b), InstructionSet::detect())
}

struct InnerProduct<'a>(&'a [f64], &'a [f64]);

impl Kernel for InnerProduct<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        let samples = self.0.len().min(self.1.len());
        let (a, b) = (&self.0[..samples], &self.1[..samples]);
        let (many_a, many_b) = (a.chunks_exact(SUMS * LANES), b.chunks_exact(SUMS * LANES));
        let rest = many_a.remainder().iter().zip(many_b.remainder());
        let rest: f64 = rest.map(|(x, y)| x * y).sum();
        let mut sums = [L::constant(0.0); SUMS];
        for (a, b) in many_a.zip(many_b) {
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum = L::load(a, k * LANES).mul_add(L::load(b, k * LANES), *sum);
            }
        }
        let [first, second, third, fourth] = sums;
        ((first + second) + (third + fourth)).sum() + rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_product_is_summed_once() {
        // Of integers: exact, however they are added.
        let a: Vec<f64> = (0..150).map(f64::from).collect();
        let b: Vec<f64> = (0..150).map(|k| f64::from(k % 7 - 3)).collect();
        for samples in [0, 1, 7, 8, 31, 32, 33, 64, 150] {
            let expected: f64 = (0..samples).map(|k| a[k] * b[k]).sum();
            assert_eq!(dot(&a[..samples], &b), expected);
        }
    }
}
