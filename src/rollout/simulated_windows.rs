//! The windows of one recording, simulated forward by the declared and the final model.

use crate::chain::dataset::Prepared;
use crate::chain::forward::{Accuracy, Forward, NotForward};
use crate::problem::solution::Control;
use crate::rollout::candidate::{Candidate, Candidates};
use crate::rollout::error::RolloutError;
use crate::rollout::model_run::{ModelRun, MovingJoint, Track, predicted};
use crate::rollout::noise::{ChannelNoise, draw, stream};
use crate::rollout::window::{Window, WindowJoint};
use crate::stats::range::within;
use rayon::prelude::*;

/// Times after a start at which errors are told, s.
pub const HORIZONS: [f64; 5] = [0.1, 0.25, 0.5, 1.0, 2.0];

/// From one start to the next, s, where the recordings are long enough.
pub(super) const EVERY: f64 = 0.5;

/// Windows of a recording: at least so many, from starts that are closer, as far as it has rows, and at most.
pub(super) const WINDOWS: [f64; 2] = [40.0, 400.0];

/// Windows that are simulated again with every step halved.
pub(super) const CHECKED: usize = 12;

/// Starts of windows of a recording, and from one to the next, s.
pub(super) struct Starts {
    pub(super) rows: Vec<usize>,
    pub(super) every: f64,
    /// Rows of the longest window from each.
    pub(super) lengths: Vec<usize>,
}

impl Starts {
    /// Windows without rows that do not count, of which the shortest fits.
    pub(super) fn of(recording: &Prepared, margin: usize) -> Self {
        let experiment = &recording.experiment;
        let (count, rate) = (experiment.rows(), experiment.rate_hz);
        let counts = |row: &usize| experiment.mask.as_ref().is_none_or(|mask| mask[*row]);
        // Rows from each on that count in one go.
        let mut run = vec![0_usize; count + 1];
        for row in (0..count).rev() {
            run[row] = if counts(&row) { run[row + 1] + 1 } else { 0 };
        }
        let rows_of = |seconds: f64| (seconds * rate).round().max(1.0) as usize;
        let (shortest, longest) = (rows_of(HORIZONS[0]), rows_of(HORIZONS[HORIZONS.len() - 1]));
        let fits: f64 = run.iter().filter(|r| **r > shortest + margin).count() as f64;
        let wanted = within(fits / (EVERY * rate), WINDOWS);
        let every = (fits / wanted).round().max(1.0) as usize;
        let starts: Vec<usize> = (margin..count)
            .step_by(every)
            .filter(|row| run[*row] > shortest + margin)
            .collect();
        Self {
            lengths: starts
                .iter()
                .map(|&row| longest.min(run[row] - 1 - margin))
                .collect(),
            rows: starts,
            every: every as f64 / rate,
        }
    }
}

/// The windows of one recording.
pub(super) struct SimulatedWindows<'a> {
    pub(super) recording: &'a Prepared,
    pub(super) starts: Starts,
    pub(super) run: ModelRun<'a>,
    pub(super) before: Option<Vec<Track>>,
    pub(super) after: Vec<Track>,
    pub(super) noise: Vec<Track>,
    /// Windows that were simulated with every step halved.
    pub(super) halved: Vec<(usize, Track)>,
    /// Whether the recording itself shows the noise of its signal.
    pub(super) measured: bool,
    pub(super) has_start_errors: bool,
}

impl<'a> SimulatedWindows<'a> {
    /// `None` where no window fits.
    pub(super) fn of(
        candidates: &'a Candidates,
        number: usize,
        recording: &'a Prepared,
        seed: u64,
        control: &Control<'_>,
    ) -> Result<Option<Self>, RolloutError> {
        let after = &candidates.after;
        let before = candidates.before.as_ref().map(|(_, before)| before);
        let margin = margin([Some(after), before], recording)?;
        let starts = Starts::of(recording, margin);
        if starts.rows.is_empty() {
            return Ok(None);
        }
        let accuracy = Accuracy::default();
        let experiment = &recording.experiment;
        let of = |candidate: &'a Candidate, signal: &[Vec<f64>]| {
            ModelRun::new(candidate, recording, signal, &starts.rows, accuracy)
        };
        let roll =
            |run: &ModelRun<'a>, errors: &[[Vec<f64>; 2]]| -> Result<Vec<Track>, RolloutError> {
                let windows = 0..starts.rows.len();
                windows
                    .into_par_iter()
                    .map(|k| {
                        if control.is_interrupted() {
                            return Err(RolloutError::Interrupted);
                        }
                        Ok(run.roll(k, starts.lengths[k], accuracy, errors.get(k))?)
                    })
                    .collect()
            };
        let run = of(after, &experiment.signal)?;
        let rolled_after = roll(&run, &[])?;
        let rolled_before = match before {
            // Where nothing was found.
            Some(before) if before.is(after) => Some(rolled_after.clone()),
            Some(before) => Some(roll(&of(before, &experiment.signal)?, &[])?),
            None => None,
        };
        let own = predicted(after, recording);
        let channels = after.model.joints().len();
        let mut rng = stream(seed, number, 0);
        let mut measured = true;
        let mut noisy = own.clone();
        for (channel, series) in noisy.iter_mut().enumerate().take(channels) {
            if after.model.joints()[channel].locked {
                continue;
            }
            let pairs = own[channel].iter().zip(&experiment.signal[channel]);
            let residual: Vec<f64> = pairs.map(|(own, recorded)| own - recorded).collect();
            let noise = ChannelNoise::of(recording, channel, &residual);
            measured &= noise.measured;
            let drawn = noise.draw(series.len(), &mut rng);
            series.iter_mut().zip(drawn).for_each(|(s, n)| *s += n);
        }
        let mut rng = stream(seed, number, 1);
        let errors: Vec<[Vec<f64>; 2]> = match &experiment.motion_error {
            Some(error) => {
                let roots = [error.position.root(), error.velocity.root()];
                let of_start = |_| roots.each_ref().map(|root| draw(root, &mut rng));
                starts.rows.iter().map(of_start).collect()
            }
            None => Vec::new(),
        };
        let noise = roll(&of(after, &noisy)?, &errors)?;
        let step = starts.rows.len().div_ceil(CHECKED);
        let halved = (0..starts.rows.len())
            .step_by(step)
            .map(|k| Ok((k, run.roll(k, starts.lengths[k], accuracy.halved(), None)?)))
            .collect::<Result<_, NotForward>>()?;
        Ok(Some(Self {
            recording,
            run,
            before: rolled_before,
            after: rolled_after,
            noise,
            halved,
            measured,
            has_start_errors: experiment.motion_error.is_some(),
            starts,
        }))
    }
}

/// Rows by which the torques of a window are recorded beyond its ends.
pub(super) fn margin(
    candidates: [Option<&Candidate>; 2],
    recording: &Prepared,
) -> Result<usize, NotForward> {
    let mut rows = 0.0_f64;
    for candidate in candidates.into_iter().flatten() {
        let Candidate { model, values } = candidate;
        let forward = Forward::new(model, values, recording.loaded, Accuracy::default())?;
        for motor in 0..forward.motors().len() {
            rows = rows.max(forward.delay(motor).abs() * recording.experiment.rate_hz);
        }
    }
    Ok(rows.ceil() as usize)
}

/// A joint that moves.
pub(super) struct Named {
    pub(super) name: String,
    pub(super) unit: &'static str,
}

impl SimulatedWindows<'_> {
    /// Rows after a start at a time.
    pub(super) fn row(&self, time: f64) -> usize {
        (time * self.recording.experiment.rate_hz).round() as usize
    }

    pub(super) fn window(
        &self,
        kind: &'static str,
        k: usize,
        horizon: f64,
        joints: &[Named],
    ) -> Result<Window, NotForward> {
        let (start, rows) = (self.run.starts()[k], self.row(horizon));
        let recorded = (start..=start + rows)
            .map(|row| self.run.recorded(row))
            .collect::<Result<Vec<_>, _>>()?;
        let of = |(j, named): (usize, &Named)| {
            let joint = MovingJoint {
                index: j,
                count: joints.len(),
            };
            let along = |track: Option<&Track>| -> Vec<f64> {
                let at = |row: usize| {
                    let error = track.map_or(f64::NAN, |t| t.error(row, joint));
                    recorded[row][j] + error
                };
                (0..=rows).map(at).collect()
            };
            WindowJoint {
                joint: named.name.clone(),
                unit: named.unit,
                recorded: recorded.iter().map(|q| q[j]).collect(),
                before: along(self.before.as_ref().map(|tracks| &tracks[k])),
                after: along(Some(&self.after[k])),
            }
        };
        Ok(Window {
            kind,
            recording: self.recording.name.clone(),
            t: self.recording.experiment.t[start..=start + rows].to_vec(),
            joints: joints.iter().enumerate().map(of).collect(),
        })
    }
}
