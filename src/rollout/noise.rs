//! Noise of the signal and of the start, as the recordings show it.
//!
//! The scatter of the periods gives the noise of a channel with its colour, or else the differences of successive samples,
//! which then are those of white noise. Where neither tells it, what the final model leaves counts as noise, with the
//! colour of an autoregression.

use crate::chain::dataset::Prepared;
use crate::robot::random::generator;
use crate::stats::autoregression::{Autoregression, OrderCriterion, largest_order};
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Samples after which a series has forgotten that it began at rest.
const RUN_IN: usize = 512;

/// Noise of one channel.
#[derive(Debug, Clone)]
pub struct ChannelNoise {
    colour: Autoregression,
    /// Standard deviation, unit of the signal.
    pub deviation: f64,
    /// The recording itself shows it.
    pub measured: bool,
}

impl ChannelNoise {
    /// Of a channel of a recording; `residual` is what the final model leaves of it.
    pub fn of(recording: &Prepared, channel: usize, residual: &[f64]) -> Self {
        let experiment = &recording.experiment;
        if let Some(noise) = &experiment.noise {
            let variance = noise.signal_covariance[(channel, channel)];
            let covariance = noise.autocovariance.get(channel);
            let rows = experiment.rows();
            let colour = covariance.and_then(|c| Autoregression::of_autocovariance(c, rows));
            return Self {
                colour: colour.unwrap_or_else(|| Autoregression::white(1.0)),
                deviation: variance.max(0.0).sqrt(),
                measured: true,
            };
        }
        let white = experiment.white_noise.get(channel).copied().flatten();
        // Behind a filter it is white no longer.
        if let Some(deviation) = white.filter(|_| experiment.parallel.is_none()) {
            return Self {
                colour: Autoregression::white(1.0),
                deviation,
                measured: true,
            };
        }
        let counted: Vec<f64> = residual
            .iter()
            .enumerate()
            .filter(|(row, _)| experiment.mask.as_ref().is_none_or(|mask| mask[*row]))
            .map(|(_, e)| *e)
            .collect();
        let squares: f64 = counted.iter().map(|e| e * e).sum();
        let order = largest_order(counted.len());
        let colour = Autoregression::fit(&[&counted], order, OrderCriterion::Bic);
        Self {
            colour: colour.unwrap_or_else(|| Autoregression::white(1.0)),
            deviation: (squares / counted.len().max(1) as f64).sqrt(),
            measured: false,
        }
    }

    /// A series of this noise.
    pub fn draw(&self, rows: usize, rng: &mut ChaCha8Rng) -> Vec<f64> {
        let innovations: Vec<f64> = (0..rows + RUN_IN)
            .map(|_| StandardNormal.sample(rng))
            .collect();
        let response = self.colour.impulse_response(RUN_IN);
        let energy: f64 = response.iter().map(|x| x * x).sum();
        let scale = self.deviation / energy.sqrt();
        let series = self.colour.shape(&innovations);
        series[RUN_IN..].iter().map(|x| scale * x).collect()
    }
}

/// The generator of one recording's noise.
pub fn stream(seed: u64, recording: usize, purpose: u64) -> ChaCha8Rng {
    let mut rng = generator(seed);
    rng.set_stream(2 * recording as u64 + purpose);
    rng
}

/// Errors of every joint, of the covariance R Rᵀ.
pub fn draw(root: &DMatrix<f64>, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let normal = DVector::from_fn(root.ncols(), |_, _| StandardNormal.sample(rng));
    (root * normal).as_slice().to_vec()
}
