//! The part of a residual at frequencies at which the motion stands clear of its noise.
//!
//! Beyond them a model predicts with what is mostly noise of the encoders, and a spring between motor and link, which
//! holds high frequencies back, lowers the error of any prediction: that is a better filter and not physics.

use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::estimate::spectrum::Transform;
use crate::recording::split::Split;

/// The highest frequency at which all that a hypothesis moves stands clear of its noise, in units of the rate of the
/// rows that are held out.
pub fn band(context: &Context<'_>, hypothesis: &Hypothesis) -> f64 {
    let recordings = context.data.of(Split::Validation);
    let bands = recordings.flat_map(|r| {
        let rate_hz = r.experiment.rate_hz / r.stride as f64;
        let joints = hypothesis.joints.iter();
        joints.map(move |&joint| r.experiment.bandwidth[joint].clear_hz / rate_hz)
    });
    bands.fold(0.5, f64::min)
}

/// Root mean square of what a series has up to a frequency, in units of its rate.
pub fn rms(series: &[f64], band: f64) -> f64 {
    let transform = Transform::new(series.len());
    let spectrum = transform.of(series);
    let counts = ((band * series.len() as f64) as usize + 1).min(spectrum.len());
    let power = |f: usize| transform.multiplicity(f) * spectrum[f].norm_sqr();
    let squares: f64 = (0..counts).map(power).sum();
    (squares / series.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::rms;
    use std::f64::consts::TAU;

    #[test]
    fn counts_what_is_in_the_band_alone() {
        let tone = |k: usize, cycles: f64| (TAU * cycles * k as f64 / 400.0).sin();
        let series: Vec<f64> = (0..400)
            .map(|k| tone(k, 10.0) + 3.0 * tone(k, 90.0))
            .collect();
        assert!((rms(&series, 0.1) - 0.5_f64.sqrt()).abs() < 1e-12);
        assert!((rms(&series, 0.5) - 5.0_f64.sqrt()).abs() < 1e-12);
    }
}
