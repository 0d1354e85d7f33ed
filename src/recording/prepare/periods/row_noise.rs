//! The noise of rows from how periods scatter.

use nalgebra::DMatrix;

use crate::recording::prepare::experiment::Noise;
use crate::recording::series::spectrum::lagged_products;

/// Most lags of the autocovariance, rows; beyond it drift and noise cannot be told apart.
const MOST_LAGS: usize = 500;

/// Differences of periods, of every channel and joint: of samples in the order of time, 0 where one does not count.
pub(super) struct Scatter {
    /// In the unit of the signal, behind the parallel filter if there is one.
    pub signal: Vec<Vec<f64>>,
    /// rad or m.
    pub position: Vec<Vec<f64>>,
    /// Sums of squares over this are variances of a sample.
    pub divisor: f64,
    /// Degrees of freedom.
    pub degrees: f64,
    /// Samples that are averaged in a row.
    pub averaged: f64,
    /// s.
    pub period: f64,
    /// Samples of a period.
    pub samples: usize,
}

impl Scatter {
    /// The noise of a row.
    pub fn noise(&self) -> Noise {
        let row = self.divisor * self.averaged;
        let product = |a: usize, b: usize| -> f64 {
            let pairs = self.signal[a].iter().zip(&self.signal[b]);
            pairs.map(|(x, y)| x * y).sum::<f64>() / row
        };
        let lags = MOST_LAGS.min(self.samples / 2);
        let spread = |e: &Vec<f64>| (e.iter().map(|e| e * e).sum::<f64>() / self.divisor).sqrt();
        let channels = self.signal.len();
        Noise {
            period: self.period,
            degrees: self.degrees,
            signal_covariance: DMatrix::from_fn(channels, channels, product),
            autocovariance: self
                .signal
                .iter()
                .map(|e| autocovariance(e, lags, row))
                .collect(),
            recorded_position_sd: self.position.iter().map(spread).collect(),
        }
    }
}

/// Σ_i e(i) e(i + l) / divisor for the lags 0..=lags, corrected for the products lost at the end.
fn autocovariance(differences: &[f64], lags: usize, divisor: f64) -> Vec<f64> {
    let n = differences.len();
    let products = lagged_products(differences, lags.min(n - 1));
    let lost = |l: usize| n as f64 / (n - l) as f64;
    let lags = products.iter().enumerate();
    lags.map(|(l, sum)| sum / divisor * lost(l)).collect()
}
