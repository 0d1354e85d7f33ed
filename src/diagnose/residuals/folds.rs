//! Products over folds of the fitted rows: of a model's derivatives and residual, and of hat functions in one channel, without what
//! the model can take of these.
//!
//! ```text
//! C⊥ = C − J B,   B = (JᵀJ)⁻¹ Jᵀ C
//! ```
//!
//! over all channels: what a hat function takes of one is wrong in another by what the model's unknowns change there.

use crate::diagnose::fit::linear_model::{LinearModel, OwnProducts};
use crate::diagnose::residuals::hats::HatRows;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;
use std::ops::Range;

/// Folds of the fitted rows.
pub const FOLDS: usize = 5;

/// Share of the squares of a derivative that is rounding.
const ROUNDING: f64 = 1e-12;

/// A model with its products over each fold.
pub struct FoldedModel<'a> {
    linear: &'a LinearModel,
    /// Rows of `[channel][fold]`: as many in each fold of a channel.
    folds: Vec<Vec<Range<usize>>>,
    /// `[channel][fold]`.
    channels: Vec<Vec<OwnProducts>>,
    /// Over all channels, by fold.
    all: Vec<OwnProducts>,
    whole: Cholesky<f64, Dyn>,
}

/// Products of the hats of some functions over one fold.
#[derive(Clone)]
pub struct HatProducts {
    /// CᵀC.
    pub square: DMatrix<f64>,
    /// CᵀJ.
    by_model: DMatrix<f64>,
    /// Cᵀr.
    right: DVector<f64>,
}

impl<'a> FoldedModel<'a> {
    /// Of a model along rows; `None` where its derivatives are not finite.
    pub fn of(linear: &'a LinearModel) -> Option<Self> {
        let of_rows = |rows: usize| -> Vec<Range<usize>> {
            let fold = |k: usize| k * rows / FOLDS..(k + 1) * rows / FOLDS;
            (0..FOLDS).map(fold).collect()
        };
        let folds: Vec<Vec<Range<usize>>> = linear
            .residual
            .iter()
            .map(|rows| of_rows(rows.len()))
            .collect();
        let of_channel = |c: usize| -> Vec<OwnProducts> {
            let of = |fold: &Range<usize>| OwnProducts::of(linear, c, fold.clone());
            folds[c].iter().map(of).collect()
        };
        let numbers = (0..linear.residual.len()).into_par_iter();
        let channels: Vec<Vec<OwnProducts>> = numbers.map(of_channel).collect();
        let over = |k: usize| {
            let mut each = channels.iter().map(|folds| folds[k].clone());
            let first = each.next()?;
            Some(each.fold(first, OwnProducts::plus))
        };
        let all: Vec<OwnProducts> = (0..FOLDS).map(over).collect::<Option<_>>()?;
        let mut square = linear.known_square();
        all.iter().for_each(|fold| square += &fold.square);
        let largest = square.diagonal().amax();
        for k in 0..square.nrows() {
            // An unknown that nothing depends on stays as it is.
            square[(k, k)] += match square[(k, k)] > 0.0 {
                true => ROUNDING * square[(k, k)],
                false => largest.max(1.0),
            };
        }
        Some(Self {
            linear,
            folds,
            channels,
            all,
            whole: square.cholesky()?,
        })
    }

    /// The products of a channel, by fold.
    pub fn of_channel(&self, channel: usize) -> &[OwnProducts] {
        &self.channels[channel]
    }

    /// Mean square of what is left of each fold of a channel, by values of the unknowns that are fitted to the other folds of all
    /// channels (cross-validation: Stone 1974); `None` where these do not determine them.
    pub fn forecast_error(&self, channel: usize) -> Option<f64> {
        let whole = self.whole.l() * self.whole.l().transpose();
        let right: DVector<f64> = self.all.iter().map(|fold| &fold.right).sum();
        let mut left = 0.0;
        for (all, own) in self.all.iter().zip(&self.channels[channel]) {
            let others = (&whole - &all.square).cholesky()?;
            let step = others.solve(&(&right - &all.right));
            left += own.residual - 2.0 * step.dot(&own.right) + step.dot(&(&own.square * &step));
        }
        let rows = self.folds[channel].last().map_or(0, |fold| fold.end);
        Some(left / rows.max(1) as f64)
    }

    /// Of no hats.
    pub fn nothing(&self) -> Vec<HatProducts> {
        let unknowns = self.whole.l_dirty().nrows();
        let none = HatProducts {
            square: DMatrix::zeros(0, 0),
            by_model: DMatrix::zeros(0, unknowns),
            right: DVector::zeros(0),
        };
        vec![none; FOLDS]
    }

    /// Of the hats of known functions and of one more in a channel.
    pub fn with(
        &self,
        channel: usize,
        known: &[HatProducts],
        functions: &[&HatRows],
        rows: &HatRows,
    ) -> Vec<HatProducts> {
        let scale = self.linear.scale[channel];
        let columns = &self.linear.columns[channel];
        let residual = &self.linear.residual[channel];
        let of = |(fold, before): (&Range<usize>, &HatProducts)| {
            let square = |f: &HatRows| f.cross(rows, fold.clone()) / (scale * scale);
            let own = HatProducts {
                square: square(rows),
                by_model: rows.against_columns(columns, fold.clone()) / scale,
                right: rows.against(residual, fold.clone()) / scale,
            };
            let cross: Vec<DMatrix<f64>> = functions.iter().map(|f| square(f)).collect();
            before.with(own, &cross)
        };
        self.folds[channel].iter().zip(known).map(of).collect()
    }

    /// B.
    pub fn steps(&self, products: &[HatProducts]) -> DMatrix<f64> {
        let mut sum = products[0].by_model.transpose();
        for fold in &products[1..] {
            sum += fold.by_model.transpose();
        }
        self.whole.solve(&sum)
    }

    /// Products of C⊥ over all channels, by fold, where the unknowns change by `steps`.
    pub fn apart(&self, products: &[HatProducts], steps: &DMatrix<f64>) -> Vec<Apart> {
        let folds = products.iter().zip(&self.all);
        folds.map(|(p, all)| p.apart(steps, all)).collect()
    }
}

/// Products of C⊥ over one fold.
pub struct Apart {
    /// C⊥ᵀC⊥.
    pub square: DMatrix<f64>,
    /// C⊥ᵀr.
    pub right: DVector<f64>,
}

impl Apart {
    /// Over all folds.
    pub fn sum(all: &[Self]) -> Self {
        let mut square = all[0].square.clone();
        let mut right = all[0].right.clone();
        for one in &all[1..] {
            square += &one.square;
            right += &one.right;
        }
        Self { square, right }
    }
}

impl HatProducts {
    /// With a function more, of which the products with each known one are `cross`.
    fn with(&self, own: Self, cross: &[DMatrix<f64>]) -> Self {
        let (before, width) = (self.square.nrows(), own.square.nrows());
        let total = before + width;
        let mut square = self.square.clone().resize(total, total, 0.0);
        square
            .view_mut((before, before), (width, width))
            .copy_from(&own.square);
        let mut start = 0;
        for product in cross {
            let rows = product.nrows();
            square
                .view_mut((start, before), (rows, width))
                .copy_from(product);
            let mut lower = square.view_mut((before, start), (width, rows));
            lower.copy_from(&product.transpose());
            start += rows;
        }
        let unknowns = own.by_model.ncols();
        let mut by_model = self.by_model.clone().resize(total, unknowns, 0.0);
        by_model.rows_mut(before, width).copy_from(&own.by_model);
        let mut right = self.right.clone().resize_vertically(total, 0.0);
        right.rows_mut(before, width).copy_from(&own.right);
        Self {
            square,
            by_model,
            right,
        }
    }

    /// Of C⊥ = C − J B, with the products of J:
    ///
    /// ```text
    /// C⊥ᵀC⊥ = CᵀC − H B − (H B)ᵀ,   H = CᵀJ − ½ Bᵀ JᵀJ
    /// ```
    pub fn apart(&self, steps: &DMatrix<f64>, own: &OwnProducts) -> Apart {
        let of_model = (&own.square * steps).transpose() * 0.5;
        let across = (&self.by_model - of_model) * steps;
        Apart {
            square: &self.square - &across - across.transpose(),
            right: &self.right - steps.tr_mul(&own.right),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::random::{generator, symmetric};

    const ROWS: [usize; 2] = [43, 30];

    fn drawn(seed: u64, rows: usize) -> Vec<f64> {
        let mut rng = generator(seed);
        (0..rows).map(|_| symmetric(&mut rng, 1.0)).collect()
    }

    /// Each fold by unknowns that are fitted anew to the other folds of both channels.
    #[test]
    fn matches_independent_implementation_of_cross_validation() {
        let series = |seed: u64| ROWS.map(|rows| drawn(seed + rows as u64, rows));
        let columns: Vec<[Vec<f64>; 2]> = (1..4).map(|k| series(100 * k)).collect();
        let residual = series(1000);
        let of_channel = |c: usize| columns.iter().map(move |column| Some(column[c].clone()));
        let linear = LinearModel::of_columns(
            [0, 1].map(|c| of_channel(c).collect()).to_vec(),
            residual.to_vec(),
            DMatrix::zeros(0, 3),
        );
        let folded = FoldedModel::of(&linear).unwrap();
        for (channel, rows) in ROWS.into_iter().enumerate() {
            let mut squares = 0.0;
            for k in 0..FOLDS {
                let is_own = |c: usize, row: usize| {
                    (k * ROWS[c] / FOLDS..(k + 1) * ROWS[c] / FOLDS).contains(&row)
                };
                let all = (0..2).flat_map(|c| (0..ROWS[c]).map(move |row| (c, row)));
                let others: Vec<(usize, usize)> = all.filter(|&(c, row)| !is_own(c, row)).collect();
                let jacobian =
                    DMatrix::from_fn(others.len(), 3, |i, j| columns[j][others[i].0][others[i].1]);
                let left =
                    DVector::from_fn(others.len(), |i, _| residual[others[i].0][others[i].1]);
                let step = jacobian.svd(true, true).solve(&left, 1e-12).unwrap();
                for row in (0..rows).filter(|&row| is_own(channel, row)) {
                    let taken: f64 = (0..3).map(|j| columns[j][channel][row] * step[j]).sum();
                    squares += (residual[channel][row] - taken).powi(2);
                }
            }
            let expected = squares / rows as f64;
            let found = folded.forecast_error(channel).unwrap();
            assert!(
                (found - expected).abs() < 1e-9 * expected,
                "{found} {expected}"
            );
        }
    }
}
