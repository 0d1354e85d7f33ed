//! The contribution of uncertain parameters to errors of prediction.
//!
//! ```text
//! ŝ(θ̂) − ŝ(θ) ≈ J (θ̂ − θ),   mean over rows of Var = tr(JᵀJ C) / rows
//! ```
//!
//! with the derivatives J of a channel over the held-out rows and the covariance C of the parameters, in which noise has its
//! colour. Recordings that show little of a parameter leave it to those that show more.

use crate::diagnose::fit::channel_series::ChannelSeries;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::recording::split::Split;
use crate::stats::deviation::deviation;
use nalgebra::DMatrix;

/// Of the predictions of held-out rows.
#[derive(Debug, Clone)]
pub struct PredictionError {
    /// RMS deviation per channel over the RMS residual of what was fitted, from which it follows.
    relative: Vec<f64>,
}

impl PredictionError {
    /// Of a fitted model with the covariance of its unknowns; those that its derivatives do not determine add nothing.
    pub fn of(context: &Context<'_>, fit: &ModelFit, covariance: Option<&DMatrix<f64>>) -> Self {
        let channels = fit.model.channels().len();
        let Some(covariance) = covariance else {
            return Self {
                relative: vec![0.0; channels],
            };
        };
        let held_out = context.recordings(Split::Validation);
        let positions = fit.unknowns.positions();
        let series = ChannelSeries::of(&fit.model, &fit.values, &positions, &held_out);
        let of = |c: usize| {
            let own = series.columns[c].iter().enumerate();
            let own: Vec<(usize, &Vec<f64>)> = own
                .filter_map(|(k, column)| Some((k, column.as_ref()?)))
                .collect();
            let mut sum = 0.0;
            for (i, a) in &own {
                for (j, b) in &own {
                    let entry = covariance[(*i, *j)];
                    if entry.is_finite() {
                        sum += entry * a.iter().zip(*b).map(|(a, b)| a * b).sum::<f64>();
                    }
                }
            }
            let rows = series.predicted[c].len().max(1) as f64;
            (sum.max(0.0) / rows).sqrt() / deviation(&fit.train[c])
        };
        Self {
            relative: (0..channels).map(of).collect(),
        }
    }

    /// The RMS error of predictions where rows that were fitted have `noise` and nothing else.
    pub fn beside(&self, channel: usize, noise: f64) -> f64 {
        noise * self.relative[channel].hypot(1.0)
    }
}
