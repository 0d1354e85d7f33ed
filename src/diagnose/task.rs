//! The task behind `exid diagnose`: from a robot, what its model is made of, and recordings to findings.

use crate::chain::dataset::Dataset;
use crate::chain::model::Model;
use crate::chain::transition_limits::TransitionLimits;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::findings::next_experiment::Discrimination;
use crate::diagnose::findings::report::{Nameless, Reported};
use crate::diagnose::fit::declared::Declared;
use crate::diagnose::fit::hypothesis::addition;
use crate::diagnose::search::{Found, Recorded, Search, Searched};
use crate::diagnose::selection::rival_models::Ambiguity;
use crate::diagnose::selection::stepwise::Rules;
use crate::diagnose::simulator::{self, Side};
use crate::diagnose::stage::Stage;
use crate::estimate::bandwidth::Preparing;
use crate::estimate::estimator::Estimator;
use crate::estimate::fit::fit;
use crate::estimate::goodness_of_fit::Predictions;
use crate::estimate::sharing::{self, Question};
use crate::estimate::task::{machine, possible_machine};
use crate::outcome::diagnose::Diagnosis;
use crate::outcome::estimate::Estimate;
use crate::outcome::fit::Fit;
use crate::outcome::sharing::Sharing;
use crate::problem::defect::Defect;
use crate::problem::solution::Control;
use crate::problem_file::diagnose::SoughtEffects;
use crate::problem_file::{DiagnoseTable, ProblemFile, RecordingsTable};
use crate::setup;
use crate::setup::error::SetupError;
use crate::setup::model_spec::{ModelSpec, ModelWithPrior};
use crate::setup::recording_file::RecordedRobot;
use crate::setup::robot::Robot;
use nalgebra::DVector;

/// A diagnosis with the recordings that it was made from.
#[derive(Debug)]
pub struct DiagnoseRun {
    /// Verdict, findings and what led to them.
    pub diagnosis: Diagnosis,
    /// Parameters of the final model with deviations, and its errors.
    pub estimate: Estimate,
    /// The final model as a fit gives it.
    pub fit: Fit,
    /// The declared model with all findings.
    pub model: Model,
    /// Values of the parameters of that model.
    pub values: DVector<f64>,
    /// The recordings, as they were fitted.
    pub data: Dataset,
    /// The recordings with all their rows, in the motion that suits the declared model.
    pub prepared: Dataset,
    /// Predictions of the declared and of the final model, `[recording][channel][row]`.
    pub baseline: Predictions,
    /// Predictions of the final model, in the same order.
    pub finally: Predictions,
    /// Findings with rivals that the recordings cannot set aside.
    pub ambiguities: Vec<Ambiguity>,
    /// What takes the place of what has no name.
    pub nameless: Nameless,
    /// Models that these recordings do not tell apart, to be told apart by others.
    pub rivals: Option<Discrimination>,
    /// What ended the search, where the rest is what was found before it.
    pub defect: Option<Defect>,
}

impl DiagnoseRun {
    /// What was identified, to be compared.
    fn side(&self) -> Side<'_> {
        Side {
            estimate: &self.estimate,
            fit: &self.fit,
            findings: &self.diagnosis.findings,
            model: &self.model,
            values: &self.values,
            data: &self.data,
        }
    }
}

/// Runs the diagnosis of a problem file; `on_stage` hears of every stage. What cannot be told apart gets a problem file for the
/// experiment that would.
///
/// # Errors
/// Faults of the file and of those that it names, and as [`DiagnoseTask::run`].
pub fn run(
    problem: &ProblemFile,
    control: &Control<'_>,
    on_stage: &(dyn Fn(Stage) + Sync),
) -> Result<DiagnoseRun, DiagnoseError> {
    let robot = setup::robot::open(problem)?;
    let declared = ModelSpec::of(problem, &robot)?;
    let task = DiagnoseTask {
        robot: &robot,
        declared: &declared,
        recordings: problem.recordings().map_err(SetupError::from)?,
        settings: &problem.diagnose,
    };
    let mut found = task.run(control, on_stage)?;
    let next = found.rivals.as_ref();
    found.diagnosis.next_experiment = next.and_then(|rivals| rivals.experiment(problem));
    Ok(found)
}

/// A model, the recordings that it is held against, and what is looked for.
#[derive(Debug, Clone, Copy)]
pub struct DiagnoseTask<'a> {
    /// The robot that the recordings are of.
    pub robot: &'a Robot,
    /// What its model is made of.
    pub declared: &'a ModelSpec,
    /// Those that are fitted and those that are held out, and those of a simulator.
    pub recordings: &'a RecordingsTable,
    /// What is looked for, and how sure a finding has to be.
    pub settings: &'a DiagnoseTable,
}

impl DiagnoseTask<'_> {
    /// Runs the diagnosis, of the simulator first where there are recordings of it; `on_stage` hears of every stage.
    ///
    /// # Errors
    /// Recordings that cannot be read; a declared model that they do not determine; a defect before anything was found.
    pub fn run(
        &self,
        control: &Control<'_>,
        on_stage: &(dyn Fn(Stage) + Sync),
    ) -> Result<DiagnoseRun, DiagnoseError> {
        let simulated = match self.recordings.of_simulator() {
            Some(recordings) => {
                on_stage(Stage::Simulator);
                let simulator = DiagnoseTask {
                    recordings: &recordings,
                    ..*self
                };
                // Its steps are not those of the robot.
                Some(of_robot(simulator, control, &|_| {})?)
            }
            None => None,
        };
        let mut found = of_robot(*self, control, on_stage)?;
        found.diagnosis.simulator =
            simulated.map(|simulated| simulator::compare(&simulated.side(), &found.side()));
        Ok(found)
    }
}

/// The diagnosis of the robot itself.
fn of_robot(
    task: DiagnoseTask<'_>,
    control: &Control<'_>,
    on_stage: &(dyn Fn(Stage) + Sync),
) -> Result<DiagnoseRun, DiagnoseError> {
    let DiagnoseTask {
        robot,
        declared: asked,
        recordings,
        settings,
    } = task;
    on_stage(Stage::Reading);
    // A motor that is taken for the like of another would look like missing physics: every joint is searched by itself.
    let separated = asked.separated();
    let ModelWithPrior { model, prior } = separated.build()?;
    let preparing = Preparing {
        recorded: RecordedRobot {
            table: recordings,
            robot,
            model: &model,
        },
        prior: &prior,
        control,
    };
    let prepared = preparing.prepared()?;
    let sought = sought(settings);
    let rules = Rules {
        sought: sought.as_deref(),
        significance: settings.significance.value,
    };
    let mut recorded = Recorded::of(prepared.clone());
    let mut motions = 1;
    let (found, defect, limits) = loop {
        on_stage(Stage::Fitting);
        let search = Search {
            recordings,
            robot,
            declared: &separated,
            rules,
            held_out: recorded.held_out,
            may_move: motions < MOTIONS,
            on_stage,
        };
        let declared = Declared::fit(&separated, &recorded.halves, control)?;
        match search.guarded(&recorded.halves, &declared, control)? {
            (Searched::Moved(data), _) => recorded = Recorded::of(data),
            (Searched::Found(found), defect) => break (*found, defect, declared.limits),
        }
        motions += 1;
    };
    let Recorded { halves, held_out } = recorded;
    let Found { mut reported, data } = found;
    let data = data.unwrap_or(halves.whole);
    if let Some(defect) = &defect {
        let summary = &mut reported.diagnosis.summary;
        *summary = format!("{ENDED_BY_DEFECT} ({defect}). {summary}");
    }
    let note = held_out.then(|| HELD_OUT.to_string());
    reported.diagnosis.notes.extend(note);
    let moved = (motions > 1).then(|| MOVED.to_string());
    reported.diagnosis.notes.extend(moved);
    let estimated = &reported.diagnosis.outcome.parameters;
    let differences = setup::declared::differences(separated.file_values(), &model, estimated);
    reported.diagnosis.notes.extend(differences);
    if asked.has_motors_of_one_type() && defect.is_none() && !control.is_interrupted() {
        match shared(asked, &reported, &data, &limits, control) {
            Ok(answers) => {
                reported.fitted.fit.sharing.clone_from(&answers);
                if let Some(fit) = &mut reported.diagnosis.fit {
                    fit.sharing = answers;
                }
            }
            Err(error) => reported.diagnosis.notes.push(sharing::unanswered(&error)),
        }
    }
    if let Some(fit) = &mut reported.diagnosis.fit {
        fit.machine = Some(machine(asked, robot, &reported.fitted));
        if robot.mechanism.is_none() {
            fit.possible_machine = possible_machine(asked, robot, &reported.fitted);
        }
    }
    Ok(DiagnoseRun {
        diagnosis: reported.diagnosis,
        estimate: reported.fitted.estimate,
        fit: reported.fitted.fit,
        model: reported.fitted.model,
        values: reported.fitted.values,
        baseline: reported.declared,
        finally: reported.last,
        ambiguities: reported.ambiguities,
        nameless: reported.nameless,
        rivals: reported.rivals,
        data,
        prepared,
        defect,
    })
}

/// Asks whether joints with motors of one type have parameters of the declared model or of findings in common.
fn shared(
    declared: &ModelSpec,
    reported: &Reported,
    data: &Dataset,
    limits: &TransitionLimits,
    control: &Control<'_>,
) -> Result<Vec<Sharing>, DiagnoseError> {
    let question = Question {
        declared,
        addition: &addition(&reported.hypotheses),
        data,
        limits,
    };
    question.answers(&reported.fitted, &|model, prior| {
        Ok(fit(
            model,
            data,
            Estimator::MaximumLikelihood,
            prior,
            control,
        )?)
    })
}

const ENDED_BY_DEFECT: &str =
    "The search was ended by an error within it, and this is what was found before";

const MOVED: &str = "The motion was estimated anew beside what was found: a bandwidth that is chosen beside a model that lacks \
                     physics is one that hides the lack of it.";

const HELD_OUT: &str = "No recording is kept for validation: every third of twelve blocks of each training \
                        recording was held out of the fits and is what the held-out figures are of.";

/// Times that the motion is estimated: beside the declared model, beside what was first found, and once more where that was
/// found in a motion that did not suit it.
const MOTIONS: usize = 3;

fn sought(settings: &DiagnoseTable) -> Option<Vec<String>> {
    match &settings.effects.value {
        SoughtEffects::All => None,
        SoughtEffects::Listed(ids) => Some(ids.iter().map(|id| id.value.clone()).collect()),
    }
}
