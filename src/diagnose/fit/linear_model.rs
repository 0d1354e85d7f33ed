//! A fitted model linearised over its recordings, and what its own parameters can take of further columns.
//!
//! ```text
//! r + J δ + C γ,   δ = −(JᵀJ)⁻¹ Jᵀ C γ,   C⊥ = C − J (JᵀJ)⁻¹ Jᵀ C
//! ```
//!
//! with the weighted residual r, which is orthogonal to the weighted derivatives J, and columns C of something that the model has
//! not (Frisch and Waugh 1933, Lovell 1963).

use crate::chain::dataset::Prepared;
use crate::diagnose::fit::channel_series::ChannelSeries;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::linalg::triangular::Triangular;
use nalgebra::{DMatrix, DVector, DVectorView};

/// Residual and derivatives of a model, in units of the deviation of each channel.
pub struct LinearModel {
    /// Deviation of the residual of each channel.
    pub scale: Vec<f64>,
    /// The signal as the model has it, `[channel][row]`, in the unit of the signal.
    pub predicted: Vec<Vec<f64>>,
    /// The same over all rows that count, also where the channel's own joint stands still.
    pub loads: Vec<Vec<f64>>,
    /// `ŝ − s`, `[channel][row]`.
    pub residual: Vec<Vec<f64>>,
    /// `[channel][unknown][row]`; `None` where a channel does not depend on an unknown.
    pub columns: Vec<Vec<Option<Vec<f64>>>>,
    /// Rows of what is known beforehand.
    known: DMatrix<f64>,
    /// R⁻¹ of the factor R of J and of these rows.
    inverse: DMatrix<f64>,
}

/// A column beside the derivatives: the channels that it enters.
pub type ChannelColumn = Vec<(usize, Vec<f64>)>;

impl LinearModel {
    /// Of a fitted model over recordings.
    pub fn of(fit: &ModelFit, recordings: &[&Prepared]) -> Self {
        let scale = fit.deviations();
        let positions = fit.unknowns.positions();
        let series = ChannelSeries::of(&fit.model, &fit.values, &positions, recordings);
        let mut columns = series.columns;
        for (c, of_channel) in columns.iter_mut().enumerate() {
            for column in of_channel.iter_mut().flatten() {
                column.iter_mut().for_each(|x| *x /= scale[c]);
            }
        }
        let known = fit.prior.rows().select_columns(&positions);
        let residual = weighted_difference(&series.predicted, &series.recorded, &scale);
        Self {
            predicted: series.predicted,
            loads: series.loads,
            scale,
            ..Self::of_columns(columns, residual, known)
        }
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

    /// The same of a column of one channel.
    pub fn project_one(&self, channel: usize, column: &[f64]) -> DVector<f64> {
        self.inverse.tr_mul(&self.against_columns(channel, column))
    }

    /// Jᵀ c.
    fn against_columns(&self, channel: usize, column: &[f64]) -> DVector<f64> {
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

/// Σ a b.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let of = |x| DVectorView::from_slice(x, x.len());
    of(a).dot(&of(b))
}

/// Product of two columns.
pub fn inner(a: &ChannelColumn, b: &ChannelColumn) -> f64 {
    let of = |(c, x): &(usize, Vec<f64>)| {
        let other = b.iter().find(|(d, _)| d == c);
        other.map_or(0.0, |(_, y)| dot(x, y))
    };
    a.iter().map(of).sum()
}
