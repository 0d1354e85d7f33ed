//! A fitted model linearised over its recordings, and what its own parameters can take of further columns.
//!
//! ```text
//! r + J δ + C γ,   δ = −(JᵀJ)⁻¹ Jᵀ C γ,   C⊥ = C − J (JᵀJ)⁻¹ Jᵀ C
//! ```
//!
//! with the weighted derivatives J, the weighted residual r without what a step of the model's parameters takes of it, which is
//! orthogonal to J over these rows, and columns C of something that the model has not (Frisch and Waugh 1933, Lovell 1963).

use crate::chain::dataset::Prepared;
use crate::diagnose::fit::channel_series::ChannelSeries;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::estimate::noise::counting_rows;
use crate::linalg::lanes::inner_product::dot;
use crate::linalg::triangular::Triangular;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Residual and derivatives of a model, in units of the deviation of each channel.
pub struct LinearModel {
    /// Deviation of the residual of each channel.
    pub scale: Vec<f64>,
    /// The signal as the model has it, `[channel][row]`, in the unit of the signal.
    pub predicted: Vec<Vec<f64>>,
    /// The same over all rows that count, also where the channel's own joint stands still.
    pub loads: Vec<Vec<f64>>,
    /// `ŝ − s`, `[channel][row]`, without what a step of its parameters takes of it.
    pub residual: Vec<Vec<f64>>,
    /// That step of its unknowns.
    pub step: DVector<f64>,
    /// `[channel][unknown][row]`; `None` where a channel does not depend on an unknown.
    pub columns: Vec<Vec<Option<Vec<f64>>>>,
    /// Rows of what is known beforehand.
    known: DMatrix<f64>,
    /// R⁻¹ of the factor R of J and of these rows.
    inverse: DMatrix<f64>,
}

/// Products of derivatives J and residual r over some rows of a channel.
#[derive(Debug, Clone)]
pub struct OwnProducts {
    /// JᵀJ.
    pub square: DMatrix<f64>,
    /// Jᵀr.
    pub right: DVector<f64>,
    /// rᵀr.
    pub residual: f64,
}

/// A column beside the derivatives: the channels that it enters.
pub type ChannelColumn = Vec<(usize, Vec<f64>)>;

impl LinearModel {
    /// Of a fitted model over every n-th row of the fitted recordings.
    pub fn of(fit: &ModelFit, every: usize, recordings: &[&Prepared]) -> Self {
        let scale = fit.deviations();
        let positions = fit.unknowns.positions();
        let series = ChannelSeries::of(&fit.model, &fit.values, &positions, recordings);
        let mut columns = series.columns;
        for (c, of_channel) in columns.iter_mut().enumerate() {
            for column in of_channel.iter_mut().flatten() {
                column.iter_mut().for_each(|x| *x /= scale[c]);
            }
        }
        // What is known beforehand weighs beside some rows as it does beside all.
        let weight = 1.0 / (every as f64).sqrt();
        let known = fit.prior.rows().select_columns(&positions) * weight;
        let residual = weighted_difference(&series.predicted, &series.recorded, &scale);
        let mut linear = Self {
            predicted: series.predicted,
            loads: series.loads,
            scale,
            ..Self::of_columns(columns, residual, known)
        };
        linear.take_step(&(fit.prior.residual(&fit.values) * weight));
        linear
    }

    /// Along few of the rows that count, with the recordings that have these.
    pub fn along_few(
        fit: &ModelFit,
        recordings: &[&Prepared],
        enough: usize,
    ) -> (Self, Vec<Prepared>) {
        let every = (counting_rows(recordings) / enough).max(1);
        let few: Vec<Prepared> = recordings.iter().map(|r| r.thinned(every)).collect();
        let linear = Self::of(fit, every, &few.iter().collect::<Vec<_>>());
        (linear, few)
    }

    /// Takes from the residual what a Gauss-Newton step of the parameters takes beside what is known of them: a fit is where all rows
    /// want none, and some of them, or others, do.
    fn take_step(&mut self, of_known: &DVector<f64>) {
        let own = (0..self.residual.len()).map(|c| self.against_columns(c, &self.residual[c]));
        let gradient = own.fold(self.known.tr_mul(of_known), |sum, own| sum + own);
        self.step = -self.step_of(&self.project_one(&gradient));
        let step = self.step.clone();
        self.add_step(&step);
    }

    /// Adds what a step of its unknowns does to its residual.
    fn add_step(&mut self, step: &DVector<f64>) {
        for (residual, columns) in self.residual.iter_mut().zip(&self.columns) {
            for (column, step) in columns.iter().zip(step.iter()) {
                let rows = column.iter().flatten().zip(residual.iter_mut());
                rows.for_each(|(j, r)| *r += step * j);
            }
        }
    }

    /// Takes a series of one channel, in the unit of the signal, and what a step of its unknowns adds in all channels, from its residual.
    pub fn take(&mut self, channel: usize, series: &[f64], step: &DVector<f64>) {
        self.add_step(step);
        let rows = self.residual[channel].iter_mut().zip(series);
        rows.for_each(|(r, x)| *r -= x / self.scale[channel]);
    }

    /// Of derivatives and a residual in units of deviations, with rows of what is known beforehand; predicts nothing.
    pub fn of_columns(
        columns: Vec<Vec<Option<Vec<f64>>>>,
        residual: Vec<Vec<f64>>,
        known: DMatrix<f64>,
    ) -> Self {
        Self {
            scale: vec![1.0; residual.len()],
            predicted: Vec::new(),
            loads: Vec::new(),
            inverse: inverse_factor(&columns, &known),
            step: DVector::zeros(known.ncols()),
            residual,
            columns,
            known,
        }
    }

    /// Products of the rows of what is known beforehand.
    pub fn known_square(&self) -> DMatrix<f64> {
        self.known.tr_mul(&self.known)
    }

    /// What its own parameters can take of a further column: R⁻ᵀ Jᵀ c.
    pub fn project(&self, column: &ChannelColumn) -> DVector<f64> {
        let zero = DVector::zeros(self.inverse.nrows());
        let product = column.iter().fold(zero, |sum, (channel, series)| {
            sum + self.against_columns(*channel, series)
        });
        self.inverse.tr_mul(&product)
    }

    /// The same of what a column of one channel has with the derivatives there, Jᵀ c.
    pub fn project_one(&self, against_columns: &DVector<f64>) -> DVector<f64> {
        self.inverse.tr_mul(against_columns)
    }

    /// The step of the parameters that takes it, but for its sign: R⁻¹ p of a projection p.
    pub fn step_of(&self, projected: &DVector<f64>) -> DVector<f64> {
        &self.inverse * projected
    }

    /// Jᵀ c of a column of one channel.
    pub fn against_columns(&self, channel: usize, column: &[f64]) -> DVector<f64> {
        let own = self.columns[channel].iter();
        let of = |own: &Option<Vec<f64>>| own.as_ref().map_or(0.0, |own| dot(own, column));
        DVector::from_iterator(self.columns[channel].len(), own.map(of))
    }

    /// Product of a column with the residual.
    pub fn against_residual(&self, column: &ChannelColumn) -> f64 {
        let of = |(c, series): &(usize, Vec<f64>)| dot(&self.residual[*c], series);
        column.iter().map(of).sum()
    }
}

impl OwnProducts {
    /// Of some rows of a channel.
    pub fn of(linear: &LinearModel, channel: usize, rows: Range<usize>) -> Self {
        let own = &linear.columns[channel];
        let residual = linear.residual[channel]
            .get(rows.clone())
            .unwrap_or_default();
        let mut columns = DMatrix::zeros(residual.len(), own.len());
        for (k, column) in own.iter().enumerate() {
            if let Some(column) = column {
                columns.column_mut(k).copy_from_slice(&column[rows.clone()]);
            }
        }
        let residual = DVector::from_column_slice(residual);
        Self {
            square: columns.tr_mul(&columns),
            right: columns.tr_mul(&residual),
            residual: residual.norm_squared(),
        }
    }

    /// Of the rows of both.
    pub fn plus(self, other: Self) -> Self {
        Self {
            square: self.square + other.square,
            right: self.right + other.right,
            residual: self.residual + other.residual,
        }
    }
}

/// R⁻¹ of the weighted derivatives and the rows of what is known beforehand.
fn inverse_factor(columns: &[Vec<Option<Vec<f64>>>], known: &DMatrix<f64>) -> DMatrix<f64> {
    let count = known.ncols();
    let mut factor = Triangular::new(count);
    factor.absorb(known.as_slice());
    for of_channel in columns {
        let rows = of_channel.iter().flatten().map(Vec::len).max().unwrap_or(0);
        let zero = vec![0.0; rows];
        let slices: Vec<&[f64]> = of_channel
            .iter()
            .map(|column| column.as_deref().unwrap_or(&zero))
            .collect();
        factor.absorb_columns(&slices);
    }
    factor
        .inverse()
        .unwrap_or_else(|| DMatrix::zeros(count, count))
}

fn weighted_difference(a: &[Vec<f64>], b: &[Vec<f64>], scale: &[f64]) -> Vec<Vec<f64>> {
    let of = |((a, b), scale): ((&Vec<f64>, &Vec<f64>), &f64)| {
        a.iter().zip(b).map(|(a, b)| (a - b) / scale).collect()
    };
    a.iter().zip(b).zip(scale).map(of).collect()
}

/// Product of two columns.
pub fn inner(a: &ChannelColumn, b: &ChannelColumn) -> f64 {
    let of = |(c, x): &(usize, Vec<f64>)| {
        let other = b.iter().find(|(d, _)| d == c);
        other.map_or(0.0, |(_, y)| dot(x, y))
    };
    a.iter().map(of).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::random::{generator, symmetric};

    /// What a step leaves is what least squares leaves over the rows of the data and of what is known, whatever was fitted.
    #[test]
    fn matches_independent_implementation_by_dense_least_squares() {
        const ROWS: usize = 30;
        let mut rng = generator(7);
        let mut drawn =
            |rows: usize| -> Vec<f64> { (0..rows).map(|_| symmetric(&mut rng, 1.0)).collect() };
        let columns = [drawn(2 * ROWS), drawn(2 * ROWS)];
        let (residual, of_known) = (drawn(2 * ROWS), DVector::from_vec(drawn(1)));
        let known = DMatrix::from_row_slice(1, 2, &[3.0, -1.0]);
        let of_channel = |series: &[f64], c: usize| series[c * ROWS..(c + 1) * ROWS].to_vec();
        let mut linear = LinearModel::of_columns(
            [0, 1]
                .map(|c| {
                    columns
                        .each_ref()
                        .map(|column| Some(of_channel(column, c)))
                        .to_vec()
                })
                .to_vec(),
            [0, 1].map(|c| of_channel(&residual, c)).to_vec(),
            known.clone(),
        );
        linear.take_step(&of_known);
        let mut system = DMatrix::zeros(2 * ROWS + 1, 2);
        for (k, column) in columns.iter().enumerate() {
            system
                .view_mut((0, k), (2 * ROWS, 1))
                .copy_from_slice(column);
        }
        system.row_mut(2 * ROWS).copy_from(&known.row(0));
        let right = DVector::from_iterator(
            2 * ROWS + 1,
            residual.iter().chain(of_known.iter()).copied(),
        );
        let step = system.clone().svd(true, true).solve(&right, 1e-12).unwrap();
        let left = right - system * step;
        for (k, value) in linear.residual.concat().iter().enumerate() {
            assert!((value - left[k]).abs() < 1e-12);
        }
    }
}
