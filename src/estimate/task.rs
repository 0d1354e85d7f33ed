//! The task behind `exid fit`: from a problem file to what is reported.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::model::Model;
use crate::estimate::error::EstimateError;
use crate::estimate::fit::{Estimator, Fitted, fit};
use crate::fault::Place;
use crate::outcome::fit::{Comparison, Preprocessing};
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::problem_file::choices::{self, Choice};
use crate::recording::experiment::Chosen;
use crate::setup;
use crate::setup::error::{Mismatch, SetupError};
use thiserror::Error;

/// Why `fit` gives no result.
#[derive(Debug, Error)]
pub enum FitError {
    #[error(transparent)]
    Setup(#[from] SetupError),
    #[error("{place}: {error}")]
    Estimate {
        place: String,
        error: Box<EstimateError>,
    },
}

/// A fit with the recordings that it was made from.
#[derive(Debug)]
pub struct FitRun {
    pub fitted: Fitted,
    pub data: Dataset,
}

/// Steps of a fit, as progress shows them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    Reading,
    Fitting,
    Comparing,
}

impl Step {
    pub fn words(self) -> &'static str {
        match self {
            Self::Reading => "reading and differentiating the recordings",
            Self::Fitting => "fitting",
            Self::Comparing => "fitting the models to compare with",
        }
    }
}

/// Runs a fit; `watch` hears of every step.
pub fn run(
    problem: &ProblemFile,
    control: &Control<'_>,
    watch: impl Fn(Step),
) -> Result<FitRun, FitError> {
    let estimator = estimator(problem)?;
    let robot = setup::robot::open(problem)?;
    let mut model = setup::model::build(problem, &robot)?;
    let prior = setup::prior::build(problem, &mut model)?;
    watch(Step::Reading);
    let data = setup::recordings::open(problem, &robot, &model)?;
    watch(Step::Fitting);
    let failed = |error: EstimateError| FitError::Estimate {
        place: Place::file(&problem.path).key("fit").to_string(),
        error: Box::new(error),
    };
    let mut fitted = fit(&model, &data, (estimator, &prior), control).map_err(failed)?;
    fitted.fit.preprocessing = preprocessing(&model, &data);
    fitted.fit.notes = notes(&model, &data);
    if !problem.fit.compare.is_empty() {
        watch(Step::Comparing);
    }
    for compared in &problem.fit.compare {
        let mut other = setup::model::build_compared(problem, &robot, &compared.effects.value)?;
        let prior = setup::prior::build(problem, &mut other)?;
        let result = fit(&other, &data, (estimator, &prior), control).map_err(failed)?;
        fitted.fit.comparison.push(Comparison {
            name: compared.name.value.clone(),
            effects: compared
                .effects
                .value
                .iter()
                .map(|e| e.value.clone())
                .collect(),
            joints: result.estimate.joints,
        });
    }
    Ok(FitRun { fitted, data })
}

fn estimator(problem: &ProblemFile) -> Result<Estimator, SetupError> {
    let chosen = &problem.fit.estimator;
    match chosen.value {
        choices::Estimator::OrdinaryLeastSquares => Ok(Estimator::Ordinary),
        choices::Estimator::WeightedLeastSquares => Ok(Estimator::Weighted),
        choices::Estimator::IterativelyReweightedLeastSquares => Ok(Estimator::Robust),
        choices::Estimator::MaximumLikelihood => Ok(Estimator::MaximumLikelihood),
        other => Err(SetupError::mismatch(
            &chosen.place,
            Mismatch::NotYet {
                what: format!("the estimator `{}`", other.word()),
                instead: "use \"maximum_likelihood\", \"wls\", \"irls\" or \"ols\"".to_string(),
            },
        )),
    }
}

/// What was done to the recordings before the fit, in words.
fn preprocessing(model: &Model, data: &Dataset) -> Vec<Preprocessing> {
    let mut lines = Vec::new();
    for recording in &data.recordings {
        lines.push(Preprocessing {
            recording: recording.name.clone(),
            channel: None,
            text: of_recording(recording),
        });
        for (joint, bandwidth) in model.joints().iter().zip(&recording.experiment.bandwidth) {
            if joint.locked {
                continue;
            }
            let chosen = match bandwidth.chosen {
                Chosen::Given => "given",
                Chosen::Data => "chosen from the data",
            };
            let text = match bandwidth.harmonics {
                Some(count) => format!(
                    "{count} harmonics, up to {:.4} Hz, {chosen}",
                    bandwidth.cutoff_hz
                ),
                None => format!("low-pass at {:.4} Hz, {chosen}", bandwidth.cutoff_hz),
            };
            lines.push(Preprocessing {
                recording: recording.name.clone(),
                channel: Some(joint.name.clone()),
                text,
            });
        }
    }
    lines
}

fn of_recording(recording: &Prepared) -> String {
    let experiment = &recording.experiment;
    let mut text = format!(
        "{} samples at {:.6} Hz",
        experiment.raw.t.len(),
        experiment.timing.rate_hz
    );
    if !experiment.timing.uniform {
        text.push_str(&format!(
            ", jitter {:.2} ms, resampled",
            1e3 * experiment.timing.jitter_rms_s
        ));
    }
    match &experiment.periods {
        Some(periods) => text.push_str(&format!(
            "; average over {} periods of {:.6} s",
            periods.count, periods.period
        )),
        None => text.push_str(&format!(
            "; zero-phase low-pass of position and signal, {:.3} s dropped at both ends",
            experiment.edge_s
        )),
    }
    if let Some(filter) = &experiment.parallel {
        text.push_str(&format!(
            "; low-pass at {:.4} Hz over the signal and every column of the model",
            filter.cutoff_hz()
        ));
    }
    if recording.stride > 1 {
        text.push_str(&format!("; every {}th row used", recording.stride));
    }
    text
}

/// What the reader of a result should know.
fn notes(model: &Model, data: &Dataset) -> Vec<String> {
    let mut notes = Vec::new();
    let filtered = data
        .recordings
        .iter()
        .any(|r| r.experiment.periods.is_none());
    if filtered {
        notes.push(
            "Errors are of low-passed signals, which hides what lies above the cut-off; the figures \
             named raw are of every recorded sample."
                .to_string(),
        );
    }
    if data.recordings.iter().all(|r| r.experiment.noise.is_none()) {
        notes.push(
            "No recording repeats its motion, so nothing tells noise from lack of fit; state \
             recordings.period for periodic motion."
                .to_string(),
        );
    }
    let assumed = model.joints().iter().any(|joint| joint.width.is_some());
    if assumed
        && model
            .joints()
            .iter()
            .all(|j| j.width.is_none_or(|w| !model.parameters()[w].is_free()))
    {
        notes.push(
            "The transition speed w of Coulomb friction is taken as given; maximum_likelihood \
             estimates it."
                .to_string(),
        );
    }
    notes
}
