//! The successive periods of a recording in place of their average, as rows of a fit that looks at changes between periods.

use crate::recording::experiment::{Experiment, Noise, RowMap};

/// The recording with one row for every recorded sample of its whole periods: the motion repeats, the
/// signal is what was recorded, the noise that of single samples. `None` where nothing was averaged.
pub fn successive_periods(experiment: &Experiment) -> Option<Experiment> {
    let periods = experiment.periods.filter(|periods| periods.count > 1)?;
    let (rows, count) = (experiment.rows(), periods.count);
    let tiled =
        |series: &[Vec<f64>]| -> Vec<Vec<f64>> { series.iter().map(|s| s.repeat(count)).collect() };
    let mut all = experiment.clone();
    all.t = (0..rows * count)
        .map(|k| experiment.t[0] + k as f64 / experiment.rate_hz)
        .collect();
    all.motion.position = tiled(&experiment.motion.position);
    all.motion.velocity = tiled(&experiment.motion.velocity);
    all.motion.acceleration = tiled(&experiment.motion.acceleration);
    all.signal = (0..experiment.signal.len())
        .map(|c| {
            let periods = (0..count).flat_map(|p| experiment.period_signal(c, p));
            periods.collect()
        })
        .collect();
    all.mask = experiment.masks_of_periods(count);
    all.noise = experiment.noise.as_ref().map(|noise| Noise {
        signal_covariance: &noise.signal_covariance * count as f64,
        autocovariance: noise
            .autocovariance
            .iter()
            .map(|lags| lags.iter().map(|x| x * count as f64).collect())
            .collect(),
        ..noise.clone()
    });
    all.periods = None;
    if let Some(filter) = &all.parallel {
        for series in &mut all.signal {
            filter.apply(series);
        }
    }
    all.raw.rows = rows * count;
    all.raw.map = RowMap::Grid {
        start: all.t[0],
        rate_hz: all.rate_hz,
    };
    Some(all)
}
