//! Optimality criteria: functions of the information matrix of the parameters of interest, with their gradients. Smaller is
//! better; one file per criterion, one table, [`CRITERIA`].
//!
//! Extreme eigenvalues have no gradient where they coincide, and at an optimum they do. So criteria of
//! extremes are optimised with means of eigenvalues of growing exponent ρ in their place: the mean lies
//! within `log(p)/ρ` of the logarithm of the extreme.

pub mod a_optimal;
pub mod condition;
pub mod d_optimal;
mod definition;
pub mod e_optimal;
mod eigenvalues;
pub mod model_discrimination;
pub mod parameters_of_interest;

pub use crate::design::criterion::definition::{Criterion, Graded};

/// Every criterion.
pub const CRITERIA: &[&dyn Criterion] = &[
    &condition::Condition,
    &d_optimal::DOptimal,
    &a_optimal::AOptimal,
    &e_optimal::EOptimal,
];

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Cholesky, DMatrix};

    fn matrix(size: usize, seed: u64) -> DMatrix<f64> {
        let mut rng = crate::robot::random::generator(seed);
        let factor = DMatrix::from_fn(size + 3, size, |_, _| {
            crate::robot::random::symmetric(&mut rng, 1.0)
        });
        factor.transpose() * factor
    }

    #[test]
    fn invariant_gradients_agree_with_central_differences() {
        for criterion in CRITERIA {
            for exponent in [1.0, 8.0] {
                let m = matrix(5, 3);
                let graded = criterion.graded(&m, exponent).unwrap();
                let value = criterion.minimised(&m, exponent).unwrap();
                assert!((graded.value - value).abs() < 1e-12 * (1.0 + value.abs()));
                let direction = matrix(5, 4);
                let h = 1e-5;
                let at = |h: f64| {
                    criterion
                        .minimised(&(&m + &direction * h), exponent)
                        .unwrap()
                };
                let difference = (at(h) - at(-h)) / (2.0 * h);
                let exact = graded.gradient.dot(&direction);
                assert!(
                    (difference - exact).abs() < 1e-6 * exact.abs(),
                    "{}: {difference} and {exact}",
                    criterion.id()
                );
            }
        }
    }

    #[test]
    fn invariant_means_of_growing_exponent_approach_the_reported_extreme() {
        let m = matrix(6, 9);
        for criterion in [
            &condition::Condition as &dyn Criterion,
            &e_optimal::EOptimal,
        ] {
            let exact = criterion.value(&m).ln();
            for exponent in [10.0, 100.0, 1000.0] {
                let mean = criterion.minimised(&m, exponent).unwrap();
                assert!(mean >= exact - 1e-12);
                assert!(mean - exact <= 6f64.ln() / exponent + 1e-12);
            }
        }
    }

    #[test]
    fn singular_information_has_no_value() {
        let mut m = matrix(4, 1);
        m.row_mut(2).fill(0.0);
        m.column_mut(2).fill(0.0);
        assert!(Cholesky::new(m.clone()).is_none());
        for criterion in CRITERIA {
            assert!(criterion.graded(&m, 4.0).is_none(), "{}", criterion.id());
            assert_eq!(criterion.value(&m), f64::INFINITY, "{}", criterion.id());
        }
    }
}
