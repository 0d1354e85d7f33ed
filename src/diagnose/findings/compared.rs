//! Comparison of the declared and the final model over all held-out rows.

use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::residuals::noise_level::NoiseLevel;
use crate::diagnose::residuals::prediction_error::PredictionError;
use crate::outcome::finding::Finding;

/// Share of the excess that findings explain where they explain the misfit.
pub const MOSTLY: f64 = 0.9;

/// Two fits of the same rows, and what their residuals are held against.
pub struct Compared<'a> {
    /// The problem with its recordings.
    pub context: &'a Context<'a>,
    /// Fitted to the same rows.
    pub declared: &'a ModelFit,
    /// The model with all findings.
    pub full: &'a ModelFit,
    /// What noise leaves of each channel.
    pub noise_level: &'a NoiseLevel,
    /// Of the final model.
    pub predicted: &'a PredictionError,
}

impl Compared<'_> {
    /// Whether findings have left most of the declared model's excess over the noise in a channel.
    pub fn is_left(&self, channel: usize) -> bool {
        let pair = FitPair {
            poorer: self.declared,
            richer: self.full,
        };
        self.noise_level.share(pair.held_out(), &[channel]) < MOSTLY
    }

    /// Lack of fit of both, pooled over the joints that findings name.
    pub fn lack_of_fit(&self, findings: &[Finding]) -> LackOfFit {
        let of = |fit: &ModelFit| {
            let channels = fit.model.channels().iter().enumerate();
            let is_named = |name: &String| findings.iter().any(|f| f.joints.contains(name));
            let named = channels.filter(|(_, channel)| is_named(&channel.name));
            let named: Vec<usize> = named.map(|(c, _)| c).collect();
            self.noise_level.lack_of_fit(&fit.validation, &named)
        };
        LackOfFit {
            before: of(self.declared),
            after: of(self.full),
        }
    }
}

/// Lack of fit of the declared and of the final model.
#[derive(Debug, Clone, Copy)]
pub struct LackOfFit {
    /// Of the declared model: mean square of the residual over that of the noise.
    pub before: f64,
    /// Of the final model.
    pub after: f64,
}
