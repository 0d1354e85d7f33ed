//! The information matrix of the parameters of interest, nuisance parameters eliminated, columns scaled; and the gradient by M.
//!
//! ```text
//! I = (Sᵀ (M + M₀)⁻¹ S)⁻¹        information of the parameters S asked for, the others estimated as well
//! A = D I D                       D = 1: none and whitened;  D_kk = 1/√I_kk: own columns;  fixed D
//! ```
//!
//! With `K = I Sᵀ (M + M₀)⁻¹` the gradient of f(I) with respect to M is `Kᵀ (∂f/∂I) K`.

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::design::criterion::{Criterion, Graded};

/// How the columns are scaled before a criterion looks at them.
#[derive(Debug, Clone, PartialEq)]
pub enum Scale {
    /// As they are.
    None,
    /// Each column divided by its norm along the motion.
    Own,
    /// Each column multiplied by a constant.
    Fixed(DVector<f64>),
}

/// What a design is judged by.
#[derive(Debug, Clone)]
pub struct Target<'a> {
    /// What is minimised.
    pub criterion: &'a dyn Criterion,
    /// Positions of the columns asked for; all of them where absent.
    pub wanted: Option<Vec<usize>>,
    /// M₀, what is known beforehand.
    pub prior: DMatrix<f64>,
    /// How the matrix is scaled before it.
    pub scale: Scale,
}

/// The information of the parameters asked for, and the way back.
struct Marginal {
    information: DMatrix<f64>,
    /// K; absent where every parameter is asked for.
    back: Option<DMatrix<f64>>,
}

impl Target<'_> {
    /// I; `None` where the motion does not determine the parameters.
    pub fn marginal(&self, information: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        Some(self.eliminate(information)?.information)
    }

    fn eliminate(&self, information: &DMatrix<f64>) -> Option<Marginal> {
        let total = information + &self.prior;
        let Some(wanted) = &self.wanted else {
            return Some(Marginal {
                information: total,
                back: None,
            });
        };
        // Columns of one size, so that units do not decide what is singular.
        let size = total.diagonal().map(|d| 1.0 / d.sqrt());
        let unit = scaled(&total, &size);
        let inverse = Cholesky::new(unit)?.inverse();
        let covariance = inverse.select_rows(wanted).select_columns(wanted);
        let own = Cholesky::new(covariance)?.inverse();
        let back = &own * inverse.select_rows(wanted);
        let units = size.select_rows(wanted).map(|s| 1.0 / s);
        let mut carried = back;
        for (i, mut row) in carried.row_iter_mut().enumerate() {
            for (value, s) in row.iter_mut().zip(size.iter()) {
                *value *= units[i] * s;
            }
        }
        Some(Marginal {
            information: scaled(&own, &units),
            back: Some(carried),
        })
    }

    /// A, the matrix that the scaling names.
    pub fn matrix(&self, information: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        Some(self.rescale(&self.marginal(information)?))
    }

    fn rescale(&self, information: &DMatrix<f64>) -> DMatrix<f64> {
        match &self.scale {
            Scale::None => information.clone(),
            Scale::Own => scaled(information, &own_scale(information)),
            Scale::Fixed(d) => scaled(information, d),
        }
    }

    /// What is minimised.
    pub fn minimised(&self, information: &DMatrix<f64>, exponent: f64) -> Option<f64> {
        self.criterion
            .minimised(&self.matrix(information)?, exponent)
    }

    /// What is minimised, with its gradient with respect to M.
    pub fn graded(&self, information: &DMatrix<f64>, exponent: f64) -> Option<Graded> {
        let marginal = self.eliminate(information)?;
        let own = &marginal.information;
        let Graded { value, gradient } = self.criterion.graded(&self.rescale(own), exponent)?;
        let by_own = match &self.scale {
            Scale::None => gradient,
            Scale::Fixed(d) => scaled(&gradient, d),
            Scale::Own => {
                let d = own_scale(own);
                let mut by_own = scaled(&gradient, &d);
                // The norms change with the diagonal: −(F A)_kk / I_kk.
                let product = &gradient * scaled(own, &d);
                for k in 0..d.len() {
                    by_own[(k, k)] -= product[(k, k)] * d[k] * d[k];
                }
                by_own
            }
        };
        let gradient = match &marginal.back {
            None => by_own,
            Some(back) => back.transpose() * by_own * back,
        };
        Some(Graded { value, gradient })
    }
}

/// D M D.
fn scaled(m: &DMatrix<f64>, d: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| d[i] * m[(i, j)] * d[j])
}

/// One over the norms of the columns.
fn own_scale(information: &DMatrix<f64>) -> DVector<f64> {
    information.diagonal().map(|d| 1.0 / d.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::criterion::CRITERIA;
    use crate::robot::random::{generator, symmetric};

    fn matrix(size: usize, seed: u64) -> DMatrix<f64> {
        let mut rng = generator(seed);
        let factor = DMatrix::from_fn(size + 3, size, |_, j| {
            10f64.powi(j as i32 % 3) * symmetric(&mut rng, 1.0)
        });
        factor.transpose() * factor
    }

    fn targets(criterion: &'static dyn Criterion) -> Vec<Target<'static>> {
        let mut targets = Vec::new();
        for wanted in [None, Some(vec![1, 4])] {
            let count = wanted.as_ref().map_or(6, Vec::len);
            let fixed = DVector::from_fn(count, |k, _| 0.5 + k as f64);
            for scale in [Scale::None, Scale::Own, Scale::Fixed(fixed)] {
                targets.push(Target {
                    criterion,
                    wanted: wanted.clone(),
                    prior: DMatrix::identity(6, 6) * 0.1,
                    scale,
                });
            }
        }
        targets
    }

    #[test]
    fn invariant_gradients_agree_with_central_differences_for_every_scaling_and_subset() {
        let (m, direction) = (matrix(6, 1), matrix(6, 2));
        for target in CRITERIA.iter().flat_map(|c| targets(*c)) {
            let graded = target.graded(&m, 8.0).unwrap();
            // Large, because eigenvalues of an information matrix of condition 10⁸ have eight digits.
            let h = 1e-3;
            let at = |h: f64| target.minimised(&(&m + &direction * h), 8.0).unwrap();
            // Five points: the curvature of a large condition number shows in three.
            let near = at(h) - at(-h);
            let far = at(2.0 * h) - at(-2.0 * h);
            let difference = (8.0 * near - far) / (12.0 * h);
            let exact = graded.gradient.dot(&direction);
            assert!(
                (difference - exact).abs() < 1e-6 * exact.abs().max(1e-3 * graded.value.abs()),
                "{target:?}: {difference} and {exact}"
            );
        }
    }

    #[test]
    fn invariant_information_of_a_subset_is_the_schur_complement() {
        let m = matrix(6, 5);
        let target = targets(CRITERIA[0]).remove(3);
        let total = &m + &target.prior;
        let rest: Vec<usize> = vec![0, 2, 3, 5];
        let wanted = [1, 4];
        let pick = |a: &[usize], b: &[usize]| total.select_rows(a).select_columns(b);
        let schur = pick(&wanted, &wanted)
            - pick(&wanted, &rest)
                * pick(&rest, &rest).try_inverse().unwrap()
                * pick(&rest, &wanted);
        let own = target.marginal(&m).unwrap();
        // Elimination subtracts numbers of the size of the total.
        assert!((own - schur).amax() < 1e-12 * total.amax());
    }
}
