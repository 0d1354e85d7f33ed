//! Drift: the power that the signal feeds into the motion changes from period to period.

use crate::chain::effect::WARMING;
use crate::check::context::PreparedRecording;
use crate::check::report::finding;
use crate::fault::Description;
use crate::outcome::check::{Mistake, Severity};

/// Fewest periods that show a trend: three degrees of freedom are left for its error.
const LEAST_PERIODS: usize = 5;

/// A trend's standard errors that are not chance, over all joints and recordings.
const TREND_SIGMA: f64 = 8.0;

/// Share of the mean loss by which the ends differ for a trend to matter.
const TREND_SHARE: f64 = 0.05;

pub(super) fn check(ready: &PreparedRecording<'_>) -> Vec<Mistake> {
    let experiment = &ready.prepared.experiment;
    let Some(periods) = experiment.periods.filter(|p| p.count >= LEAST_PERIODS) else {
        return Vec::new();
    };
    let channels = ready.model.channels().iter().enumerate();
    let channels =
        channels.filter_map(|(c, channel)| Some((c, channel.joint.filter(|_| channel.active)?)));
    channels
        .filter_map(|(c, joint)| {
            let velocity = &experiment.motion.velocity[joint];
            let losses: Vec<f64> = (0..periods.count)
                .map(|p| mean_product(&experiment.period_signal(c, p), velocity))
                .collect();
            let trend = Trend::of(&losses)?;
            let change = trend.slope * (periods.count - 1) as f64;
            let share = change / trend.mean.abs();
            let drifts = trend.slope.abs() > TREND_SIGMA * trend.standard_error;
            (drifts && share.abs() > TREND_SHARE).then(|| {
                finding(
                    Severity::Note,
                    ready.at_channel(c),
                    Description::new(
                        "drift",
                        format!(
                            "the mean loss changes steadily, by {:.1} % from the first of {} periods to the last",
                            100.0 * share,
                            periods.count
                        ),
                        format!("warm the robot up before recording; {} describes it", WARMING.id),
                    ),
                )
            })
        })
        .collect()
}

fn mean_product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / a.len().max(1) as f64
}

/// A straight line through values at 0, 1, 2, ...
struct Trend {
    mean: f64,
    slope: f64,
    standard_error: f64,
}

impl Trend {
    fn of(values: &[f64]) -> Option<Self> {
        let n = values.len() as f64;
        let centre = 0.5 * (n - 1.0);
        let mean = values.iter().sum::<f64>() / n;
        let spread: f64 = (0..values.len()).map(|k| (k as f64 - centre).powi(2)).sum();
        let products = values
            .iter()
            .enumerate()
            .map(|(k, v)| (k as f64 - centre) * (v - mean));
        let slope = products.sum::<f64>() / spread;
        let residual = |(k, v): (usize, &f64)| (v - mean - slope * (k as f64 - centre)).powi(2);
        let squares: f64 = values.iter().enumerate().map(residual).sum();
        let standard_error = (squares / (n - 2.0) / spread).sqrt();
        (mean != 0.0).then_some(Self {
            mean,
            slope,
            standard_error,
        })
    }
}
