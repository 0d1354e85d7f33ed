//! The successive periods of a recording in place of their average, as rows of a fit that looks at changes between periods.

use crate::recording::prepare::experiment::{Experiment, Raw};

/// The recording with one row for every recorded sample of its whole periods: the motion repeats, the
/// signal is what was recorded, the noise that of single samples. `None` where nothing was averaged.
pub fn successive_periods(experiment: &Experiment) -> Option<Experiment> {
    experiment.periods.filter(|periods| periods.count > 1)?;
    let all = experiment.unfolded()?;
    Some(Experiment {
        raw: Raw {
            rows: all.rows(),
            ..experiment.raw.clone()
        },
        white_noise: experiment.white_noise.clone(),
        ..all
    })
}
