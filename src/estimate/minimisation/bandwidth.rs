//! The bandwidth of motions that do not repeat, chosen by the likelihood of the signal.
//!
//! The spectrum of a motion tells where its acceleration is lost in noise, and that is where the search begins. What
//! matters is the torque: friction turns over within a few milliseconds of a reversal, an inertia asks for the
//! acceleration at large, and a smoother that suits one may not suit the other. All recordings, those that are held out
//! too, therefore get the cut-off for which the model that is fitted leaves least of the training recordings,
//!
//! ```text
//! min over cut-offs   Σ_c N_c ln σ_c,    σ_c² = mean square of the residual of channel c,
//! ```
//!
//! over the same rows for all, those at which joints move: the profile likelihood of one parameter more. The signal is not
//! filtered, so that residuals may be compared. A wider band about reversals is taken where the likelihood gains more than by
//! chance (Wilks 1938).

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::prior::Prior;
use crate::estimate::fit_problem::estimator::{Estimator, Training};
use crate::estimate::fit_problem::unknowns::Unknowns;
use crate::estimate::minimisation::minimise::Minimisation;
use crate::estimate::minimisation::optimum::Optimum;
use crate::estimate::residual::noise::{counting_rows, residuals};
use crate::estimate::residual::standstill;
use crate::problem::solution::Control;
use crate::recording::experiment::Chosen;
use crate::recording::settings::{InCommon, Method, Width};
use crate::recording::split::Split;
use crate::setup::error::SetupError;
use crate::setup::recording_file::{ReadRecording, RecordedRobot};
use crate::setup::recordings::{prepare_all, read_all};
use crate::stats::likelihood_ratio::is_beyond_chance;
use crate::stats::robust::median;
use nalgebra::DVector;

/// Ratio of one cut-off to the next. About its optimum the error of a motion changes by less than a tenth of what noise
/// does over this much.
const STEP: f64 = 1.3;

/// Steps up or down at most: an eighth to eight times what the spectrum says.
const MOST_STEPS: i32 = 8;

/// With what probability a band that is even is not said to be wider about reversals.
const CONFIDENCE: f64 = 0.99;

/// Rows that are fitted for each cut-off, of all recordings together: as many as tell σ to half a per cent.
const ROWS: usize = 20_000;

/// Whether the bandwidth of a recording is for the data to choose.
fn is_open(recording: &Prepared) -> bool {
    let experiment = &recording.experiment;
    let chosen = experiment
        .bandwidth
        .iter()
        .any(|b| b.chosen == Chosen::Data);
    experiment.method == Method::Smoother && chosen
}

/// Geometric mean of the bandwidths that the training recordings show, Hz; `None` where none is for the data to choose.
fn in_common(data: &Dataset) -> Option<f64> {
    let of = |recording: &Prepared| {
        let bandwidths = recording.experiment.bandwidth.iter().map(|b| b.cutoff_hz);
        median(&bandwidths.collect::<Vec<f64>>())
    };
    let open = data.of(Split::Train).filter(|r| is_open(r));
    let logarithms: Vec<f64> = open.filter_map(of).map(f64::ln).collect();
    let mean = logarithms.iter().sum::<f64>() / logarithms.len() as f64;
    (!logarithms.is_empty()).then(|| mean.exp())
}

/// Whether the band of a joint is wider about reversals.
fn is_wider(recording: &Prepared) -> bool {
    recording
        .experiment
        .bandwidth
        .iter()
        .any(|b| b.reversals > 0)
}

/// What recordings are made ready for: a model of a robot that is to be fitted to them.
#[derive(Clone, Copy)]
pub struct Preparing<'a> {
    /// The recordings, and the model of the robot that they are of.
    pub recorded: RecordedRobot<'a>,
    /// What is known of its parameters.
    pub prior: &'a Prior,
    /// Who may interrupt.
    pub control: &'a Control<'a>,
}

impl Preparing<'_> {
    /// Reads the recordings and makes them ready; in the order of time for a model that changes with it, as averages
    /// over periods are of no one time. Channels count for nothing where their joints stand still.
    ///
    /// # Errors
    /// Those of files and of settings.
    pub fn prepared(&self) -> Result<Dataset, SetupError> {
        self.chosen(false)
    }

    /// The recordings with the motion that suits the model as it was fitted to `present` ones, where it is not the one that these
    /// have: what was chosen beside a model that lacks physics served to hide the lack of it.
    ///
    /// # Errors
    /// Those of files and of settings.
    pub fn anew(&self, present: &Dataset) -> Result<Option<Dataset>, SetupError> {
        if in_common(present).is_none() {
            return Ok(None);
        }
        let data = self.chosen(true)?;
        let of = |data: &Dataset| -> Vec<f64> {
            let bandwidths = data.recordings.iter().flat_map(|r| &r.experiment.bandwidth);
            bandwidths.map(|b| b.cutoff_hz).collect()
        };
        // Cut-offs are steps of one ladder.
        let differs = |(a, b): (&f64, &f64)| (a / b).ln().abs() > 0.5 * STEP.ln();
        let (old, new) = (of(present), of(&data));
        let other = old.len() == new.len() && old.iter().zip(&new).any(differs);
        Ok((other && !self.control.is_interrupted()).then_some(data))
    }

    fn chosen(&self, is_fitted: bool) -> Result<Dataset, SetupError> {
        let data = self.with_best_bandwidth(is_fitted)?;
        let data = match self.recorded.model.changes_with_time() {
            true => data.in_successive_periods(),
            false => data,
        };
        Ok(standstill::left_out(self.recorded.model, data))
    }

    /// The recordings with the bandwidth that the data choose.
    fn with_best_bandwidth(&self, is_fitted: bool) -> Result<Dataset, SetupError> {
        let read = read_all(self.recorded.table, self.recorded.robot)?;
        let first = self.prepare(read.clone(), InCommon::default())?;
        match in_common(&first) {
            None => Ok(first),
            Some(begin_hz) => Search {
                preparing: self,
                is_fitted,
                read,
                begin_hz,
                judged: standstill::left_out(self.recorded.model, first),
            }
            .run(),
        }
    }

    fn prepare(
        &self,
        read: Vec<ReadRecording<'_>>,
        in_common: InCommon,
    ) -> Result<Dataset, SetupError> {
        prepare_all(self.recorded, read, in_common)
    }
}

struct Search<'a> {
    preparing: &'a Preparing<'a>,
    /// The values of the model are those of a fit with another bandwidth.
    is_fitted: bool,
    read: Vec<ReadRecording<'a>>,
    begin_hz: f64,
    /// The recordings with the spectrum's bandwidth: every motion is judged where joints move in these, as one that takes most
    /// rows for standstill leaves little of the others.
    judged: Dataset,
}

impl Search<'_> {
    /// From the spectrum's bandwidth to the best, and from there to the best with a wider band about reversals where the motion
    /// shows one and the signal agrees.
    fn run(&self) -> Result<Dataset, SetupError> {
        let first = self.at(0, Width::Even)?;
        let Some(left) = self.left(&first, None) else {
            return Ok(first);
        };
        let first = Candidate {
            step: 0,
            data: first,
            left,
        };
        let even = self.climb(first, Width::Even)?;
        if self.preparing.control.is_interrupted() {
            return Ok(even.data);
        }
        let (step, data) = (even.step, self.at(even.step, Width::WiderAboutReversals)?);
        if !data.recordings.iter().any(is_wider) {
            return Ok(even.data);
        }
        let Some(left) = self.left(&data, Some(&even.left)) else {
            return Ok(even.data);
        };
        let wider = Candidate { step, data, left };
        match is_beyond_chance(wider.likelihood_ratio(&even), 1, CONFIDENCE) {
            true => Ok(self.climb(wider, Width::WiderAboutReversals)?.data),
            false => Ok(even.data),
        }
    }

    /// In the direction in which less is left, as long as less is left.
    fn climb(&self, begin: Candidate, width: Width) -> Result<Candidate, SetupError> {
        let from = begin.step;
        let mut best = begin;
        for direction in [1, -1] {
            let mut step = from + direction;
            while step.abs() <= MOST_STEPS && !self.preparing.control.is_interrupted() {
                let data = self.at(step, width)?;
                let Some(left) = self.left(&data, Some(&best.left)) else {
                    break;
                };
                let next = Candidate { step, data, left };
                if next.likelihood_ratio(&best) <= 0.0 {
                    break;
                }
                best = next;
                step += direction;
            }
            if best.step != from {
                break;
            }
        }
        Ok(best)
    }

    fn at(&self, step: i32, width: Width) -> Result<Dataset, SetupError> {
        let in_common = InCommon {
            cutoff_hz: Some(self.begin_hz * STEP.powi(step)),
            width,
        };
        self.preparing.prepare(self.read.clone(), in_common)
    }

    /// What a fit leaves, begun from where that of a neighbour ended; `None` where the model cannot be fitted, which the fit
    /// itself will say.
    fn left(&self, data: &Dataset, neighbour: Option<&Left>) -> Option<Left> {
        let &Preparing {
            recorded: RecordedRobot { model, .. },
            prior,
            control,
        } = self.preparing;
        let all: Vec<&Prepared> = data.of(Split::Train).collect();
        let every = counting_rows(&all).div_ceil(ROWS).max(1);
        let thinned: Vec<Prepared> = all.iter().map(|r| r.thinned(every)).collect();
        let recordings: Vec<&Prepared> = thinned.iter().collect();
        let unknowns = Unknowns::find(model, data, prior);
        let model_values = model.values();
        let known = match neighbour {
            Some(left) => Some(&left.values),
            None => self.is_fitted.then_some(&model_values),
        };
        let minimisation = Minimisation {
            model,
            unknowns: &unknowns,
            training: Training {
                recordings: &recordings,
                prior,
            },
            estimator: Estimator::Weighted,
            control,
        };
        let Optimum { solution, problem } = match known {
            Some(values) => minimisation.near(unknowns.among(values)).ok()?,
            None => minimisation.run().ok()?,
        };
        let values = problem.parameters(&solution.x);
        let residuals = residuals(model, &values, &recordings);
        let channels = model.channels().iter().enumerate();
        let of = |c: usize| {
            let (mut squares, mut rows) = (0.0, 0.0);
            let judged = self.judged.of(Split::Train);
            for ((recording, series), judged) in recordings.iter().zip(&residuals).zip(judged) {
                let stands = |row: &usize| judged.stands_at(c, recording.time(*row));
                for row in recording.counting().filter(|row| !stands(row)) {
                    squares += series[c][row].powi(2);
                    rows += 1.0;
                }
            }
            (squares > 0.0).then(|| 0.5 * f64::ln(squares / rows))
        };
        let logarithms: f64 = channels
            .filter(|(_, channel)| channel.active)
            .filter_map(|(c, _)| of(c))
            .sum();
        logarithms
            .is_finite()
            .then_some(Left { logarithms, values })
    }
}

/// What a fit leaves of the training recordings.
struct Left {
    /// `Σ_c ln σ_c`.
    logarithms: f64,
    /// Of all parameters, where it ended.
    values: DVector<f64>,
}

/// A motion of all recordings.
struct Candidate {
    /// Of the cut-off.
    step: i32,
    data: Dataset,
    left: Left,
}

impl Candidate {
    /// Twice the logarithm of how many times likelier the signal is with this motion than with another.
    fn likelihood_ratio(&self, other: &Self) -> f64 {
        let rows = counting_rows(&self.data.of(Split::Train).collect::<Vec<_>>());
        2.0 * (other.left.logarithms - self.left.logarithms) * rows as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::experiment::Bandwidth;
    use crate::recording::preprocess::prepare;
    use crate::recording::samples::Recording;
    use crate::recording::settings::Preparation;

    /// A recording of two joints whose motion is made ready by a method, with the bandwidths chosen and their cut-offs, Hz.
    fn recording(split: Split, method: Method, bandwidths: [(Chosen, f64); 2]) -> Prepared {
        let series = |k: usize| -> Vec<f64> {
            let at = |row: usize| (0.05 * (k + 1) as f64 * row as f64).sin();
            (0..400).map(at).collect()
        };
        let motion = vec![series(0), series(1)];
        let recording = Recording::of_samples("made", motion.clone(), motion);
        let preparation = Preparation {
            rate: Some(100.0),
            ..Preparation::default()
        };
        let mut experiment = prepare(recording, &preparation).unwrap();
        experiment.method = method;
        let of = |(chosen, cutoff_hz)| Bandwidth {
            harmonics: None,
            cutoff_hz,
            clear_hz: cutoff_hz,
            chosen,
            reversals: 0,
        };
        experiment.bandwidth = bandwidths.map(of).to_vec();
        Prepared::new("made".to_string(), split, false, experiment)
    }

    fn begin(recordings: Vec<Prepared>) -> Option<f64> {
        in_common(&Dataset { recordings })
    }

    const FREE: [(Chosen, f64); 2] = [(Chosen::Data, 4.0), (Chosen::Data, 6.0)];

    /// Those of smoothers that nobody asked for, of what is fitted.
    #[test]
    fn only_bandwidths_of_smoothed_motions_are_open_unless_they_are_given() {
        let given = FREE.map(|(_, hz)| (Chosen::Given, hz));
        let one = [(Chosen::Given, 4.0), (Chosen::Data, 6.0)];
        for (method, bandwidths, open) in [
            (Method::Smoother, FREE, true),
            (Method::Smoother, one, true),
            (Method::Smoother, given, false),
            (Method::Fourier, FREE, false),
            (Method::Lowpass, FREE, false),
        ] {
            let found = begin(vec![recording(Split::Train, method, bandwidths)]);
            assert_eq!(found.is_some(), open, "{method:?}, {bandwidths:?}");
        }
        let held_out = recording(Split::Validation, Method::Smoother, FREE);
        assert_eq!(begin(vec![held_out]), None);
        assert_eq!(begin(Vec::new()), None);
    }

    /// The geometric mean over training recordings of the median over joints, 5 Hz and 20 Hz.
    #[test]
    fn a_search_begins_in_the_middle_of_what_the_recordings_show() {
        let wide = [(Chosen::Data, 16.0), (Chosen::Data, 24.0)];
        let closed = [(Chosen::Given, 1.0), (Chosen::Given, 1.0)];
        let found = begin(vec![
            recording(Split::Train, Method::Smoother, FREE),
            recording(Split::Train, Method::Smoother, wide),
            recording(Split::Train, Method::Smoother, closed),
            recording(Split::Validation, Method::Smoother, closed),
        ]);
        assert!((found.unwrap() - 10.0).abs() < 1e-12, "{found:?}");
    }
}
