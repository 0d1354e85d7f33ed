//! The task behind `exid diagnose`: from a problem file to findings.

use crate::chain::dataset::Dataset;
use crate::chain::model::Model;
use crate::check;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::findings::report::{Reported, Reporting};
use crate::diagnose::fit::context::is_in_time;
use crate::diagnose::fit::contexts::HeldOutHalves;
use crate::diagnose::fit::fitting::fit_declared;
use crate::diagnose::fit::held_out;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::fit::recording_parameters;
use crate::diagnose::residuals::standstill;
use crate::diagnose::selection::between_periods;
use crate::diagnose::selection::explanation::{Explaining, Explanation};
use crate::diagnose::selection::rival_models::Ambiguity;
use crate::diagnose::selection::stepwise::Rules;
use crate::diagnose::stage::Stage;
use crate::estimate::bandwidth;
use crate::estimate::figures::{Predictions, noise_rms};
use crate::outcome::check::Finding as Mistake;
use crate::outcome::diagnose::Diagnosis;
use crate::outcome::estimate::Estimate;
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::problem_file::diagnose::SoughtEffects;
use crate::setup;
use nalgebra::DVector;

/// A diagnosis with the recordings that it was made from.
#[derive(Debug)]
pub struct DiagnoseRun {
    pub diagnosis: Diagnosis,
    /// A mismatch that is a mistake in the input, not physics.
    pub mistakes: Vec<Mistake>,
    pub estimate: Estimate,
    pub model: Model,
    /// Values of the parameters of that model.
    pub values: DVector<f64>,
    pub data: Dataset,
    /// Predictions of the declared and of the final model, `[recording][channel][row]`.
    pub baseline: Predictions,
    pub finally: Predictions,
    /// Findings with rivals that the recordings cannot set aside.
    pub ambiguities: Vec<Ambiguity>,
}

/// Runs a diagnosis; `watch` hears of every stage.
pub fn run(
    problem: &ProblemFile,
    control: &Control<'_>,
    watch: &(dyn Fn(Stage) + Sync),
) -> Result<DiagnoseRun, DiagnoseError> {
    watch(Stage::Reading);
    let robot = setup::robot::open(problem)?;
    let mut model = setup::model::build(problem, &robot)?;
    let prior = setup::prior::build(problem, &robot, &mut model)?;
    let data = bandwidth::prepared(problem, &robot, &model, &prior, control)?;
    let (data, held_out) = held_out::with_held_out(standstill::left_out(&model, data));
    watch(Stage::Checking);
    let mistakes = check::run(problem, control);
    let mut halves = halves(data, held_out);
    let mut contexts = halves.contexts(problem, &robot, control);
    watch(Stage::Fitting);
    let declared = fit_declared(&contexts.selection)?;
    let noise = noise_rms(&declared.model, &declared.values, &halves.whole);
    contexts.set_noise(noise.clone());
    let sought = sought(problem);
    let rules = Rules {
        sought: sought.as_deref(),
        significance: problem.diagnose.significance.value,
    };
    let explaining = Explaining {
        contexts: &contexts,
        rules,
        watch,
    };
    let explanation = explaining.explain(declared)?;
    let reported = match between_periods::sought(&halves.whole, rules) {
        Some(effects) => {
            watch(Stage::Drift);
            let unrolled = self::halves(between_periods::unrolled(&halves.whole), held_out);
            let mut over_time = unrolled.contexts(problem, &robot, control);
            over_time.set_noise(noise);
            let explaining = Explaining {
                contexts: &over_time,
                ..explaining
            };
            let found = over_periods(&explaining, &explanation.full, &effects)?;
            found.map(|reported| (reported, unrolled))
        }
        None => None,
    };
    let mut reported = match reported {
        Some((over_time, unrolled)) => {
            halves = unrolled;
            over_time
        }
        None => report(&explaining, &explanation)?,
    };
    let note = held_out.then(|| HELD_OUT.to_string());
    reported.diagnosis.notes.extend(note);
    let estimated = &reported.diagnosis.outcome.parameters;
    let differences = setup::declared::differences(problem, &robot, &model, estimated);
    reported.diagnosis.notes.extend(differences);
    Ok(DiagnoseRun {
        diagnosis: reported.diagnosis,
        mistakes,
        estimate: reported.fitted.estimate,
        model: reported.fitted.model,
        values: reported.fitted.values,
        baseline: reported.declared,
        finally: reported.last,
        ambiguities: reported.ambiguities,
        data: halves.whole,
    })
}

const HELD_OUT: &str = "No recording is kept for validation: every third of twelve blocks of each training \
                        recording was held out of the fits and is what the held-out figures are of.";

/// The held-out rows in halves; parameters of one recording are fitted between them where these are samples in the order
/// of time and not blocks of what was fitted.
fn halves(data: Dataset, held_out: bool) -> HeldOutHalves {
    match held_out || !is_in_time(&data) {
        true => HeldOutHalves::of(data, Vec::new()),
        false => {
            let (judged, between) = recording_parameters::alternate(&data);
            HeldOutHalves::of(judged, between)
        }
    }
}

/// What is to be reported where effects that change from period to period are found beside what explains the averages.
fn over_periods(
    explaining: &Explaining<'_>,
    full: &ModelFit,
    effects: &[String],
) -> Result<Option<Reported>, DiagnoseError> {
    let of_time = Rules {
        sought: Some(effects),
        ..explaining.rules
    };
    let context = &explaining.contexts.selection;
    let Some(selection) = between_periods::found(context, full, of_time)? else {
        return Ok(None);
    };
    let explanation = explaining.conclude(selection)?;
    let is_of_time = |h: &Hypothesis| effects.iter().any(|id| id == h.effect.id);
    match explanation.full.hypotheses.iter().any(is_of_time) {
        true => report(explaining, &explanation).map(Some),
        false => Ok(None),
    }
}

fn report(
    explaining: &Explaining<'_>,
    explanation: &Explanation,
) -> Result<Reported, DiagnoseError> {
    let reporting = Reporting {
        contexts: explaining.contexts,
        explanation,
        rules: explaining.rules,
    };
    reporting.report()
}

fn sought(problem: &ProblemFile) -> Option<Vec<String>> {
    match &problem.diagnose.effects.value {
        SoughtEffects::All => None,
        SoughtEffects::Listed(ids) => Some(ids.iter().map(|id| id.value.clone()).collect()),
    }
}
