//! The task behind `exid diagnose`: from a robot, what its model is made of, and recordings to findings.

use crate::chain::dataset::Dataset;
use crate::chain::model::Model;
use crate::chain::transition_limits::TransitionLimits;
use crate::diagnose::conclusion::explanation::{Explaining, Explanation};
use crate::diagnose::conclusion::last_selection::LastSelection;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::findings::next_experiment::Discrimination;
use crate::diagnose::findings::report::{Nameless, Reported, Reporting};
use crate::diagnose::fit::context::is_in_time;
use crate::diagnose::fit::contexts::{Contexts, HeldOutHalves};
use crate::diagnose::fit::declared::Declared;
use crate::diagnose::fit::held_out;
use crate::diagnose::fit::hypothesis::{Hypothesis, addition};
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::fit::recording_parameters;
use crate::diagnose::selection::between_periods;
use crate::diagnose::selection::rival_models::Ambiguity;
use crate::diagnose::selection::stepwise::{Rules, Selection};
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
use crate::problem::defect::{Defect, guarded};
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

/// Recordings whose held-out rows are in two halves.
struct Recorded {
    halves: HeldOutHalves,
    /// Rows of the training recordings were held out.
    held_out: bool,
}

impl Recorded {
    fn of(data: Dataset) -> Self {
        let (data, held_out) = held_out::with_held_out(data);
        Self {
            halves: halves(data, held_out),
            held_out,
        }
    }
}

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

/// The search of a diagnosis over prepared recordings.
struct Search<'a> {
    recordings: &'a RecordingsTable,
    robot: &'a Robot,
    declared: &'a ModelSpec,
    rules: Rules<'a>,
    /// Rows of the training recordings were held out.
    held_out: bool,
    /// The motion may be estimated anew beside what is found.
    may_move: bool,
    on_stage: &'a (dyn Fn(Stage) + Sync),
}

/// What a search comes to.
enum Searched {
    Found(Box<Found>),
    /// The recordings with a motion that suits what was selected, in which the search begins again.
    Moved(Dataset),
}

/// What a search reports.
struct Found {
    reported: Reported,
    /// The recordings that it is of, where these are not the given ones.
    data: Option<Dataset>,
}

impl Search<'_> {
    /// What a search finds, or had found when a defect ended it.
    fn guarded(
        &self,
        halves: &HeldOutHalves,
        declared: &Declared,
        control: &Control<'_>,
    ) -> Result<(Searched, Option<Defect>), DiagnoseError> {
        let reached = LastSelection::default();
        let search = || self.whole(halves, declared, control, &reached);
        let defect = match guarded(search) {
            Ok(found) => return Ok((found?, None)),
            Err(defect) => defect,
        };
        // The declared model alone, where the defect lies in what was selected.
        for selection in [reached.get(), None] {
            let at = selection.unwrap_or_else(|| Selection::of(declared.fit.clone()));
            let report = || self.stopped_at(halves, declared, at);
            if let Ok(Ok(found)) = guarded(report) {
                return Ok((Searched::Found(Box::new(found)), Some(defect)));
            }
        }
        Err(defect.into())
    }

    /// Grows the declared model and reports what it has become.
    fn whole(
        &self,
        halves: &HeldOutHalves,
        declared: &Declared,
        control: &Control<'_>,
        reached: &LastSelection,
    ) -> Result<Searched, DiagnoseError> {
        let contexts = self.contexts(halves, declared, control)?;
        let explaining = self.explaining(&contexts, reached);
        let selection = explaining.select(declared.fit.clone())?;
        // An interrupt loses the motion that is estimated anew, and not what was selected.
        let moved = match self.moved(&selection.fit, &halves.whole, control) {
            Err(_) if control.is_interrupted() => None,
            moved => moved?,
        };
        if let Some(data) = moved {
            return Ok(Searched::Moved(data));
        }
        let explanation = explaining.conclude(selection)?;
        let changing =
            between_periods::sought(&halves.whole, declared.fit.model.catalogue(), self.rules);
        if let Some(effects) = changing.filter(|_| !control.is_interrupted()) {
            (self.on_stage)(Stage::Drift);
            let successive_periods =
                self::halves(halves.whole.in_successive_periods(), self.held_out);
            let mut over_time = successive_periods.contexts(self.declared, control);
            over_time.set(&declared.limits, declared.noise.as_deref());
            // What is selected there is of other rows than those that a defect leaves.
            let apart = LastSelection::default();
            let explaining = self.explaining(&over_time, &apart);
            if let Some(reported) = self.over_periods(&explaining, &explanation.full, &effects)? {
                return Ok(Searched::Found(Box::new(Found {
                    reported,
                    data: Some(successive_periods.whole),
                })));
            }
        }
        Ok(Searched::Found(Box::new(Found {
            reported: self.report(&explaining, explanation)?,
            data: None,
        })))
    }

    /// The recordings with the motion that suits a model with findings, if that is another one.
    fn moved(
        &self,
        found: &ModelFit,
        present: &Dataset,
        control: &Control<'_>,
    ) -> Result<Option<Dataset>, DiagnoseError> {
        if found.hypotheses.is_empty() || !self.may_move {
            return Ok(None);
        }
        let model = found.started();
        let preparing = Preparing {
            recorded: RecordedRobot {
                table: self.recordings,
                robot: self.robot,
                model: &model,
            },
            prior: &found.prior,
            control,
        };
        Ok(preparing.anew(present)?)
    }

    /// Reports a selected model as a search that is interrupted there does.
    fn stopped_at(
        &self,
        halves: &HeldOutHalves,
        declared: &Declared,
        selection: Selection,
    ) -> Result<Found, DiagnoseError> {
        let stopped = Control::stopped();
        let contexts = self.contexts(halves, declared, &stopped)?;
        let reached = LastSelection::default();
        let explaining = self.explaining(&contexts, &reached);
        let explanation = explaining.conclude(selection)?;
        Ok(Found {
            reported: self.report(&explaining, explanation)?,
            data: None,
        })
    }

    /// Contexts that know the declared model.
    fn contexts<'c>(
        &'c self,
        halves: &'c HeldOutHalves,
        declared: &Declared,
        control: &'c Control<'c>,
    ) -> Result<Contexts<'c>, DiagnoseError> {
        let mut contexts = halves.contexts(self.declared, control);
        contexts.set(&declared.limits, declared.noise.as_deref());
        let known = || Ok(declared.fit.clone());
        contexts.selection.cache.fit_model(&[], known)?;
        Ok(contexts)
    }

    fn explaining<'c>(
        &'c self,
        contexts: &'c Contexts<'c>,
        reached: &'c LastSelection,
    ) -> Explaining<'c> {
        Explaining {
            contexts,
            rules: self.rules,
            on_stage: self.on_stage,
            reached,
        }
    }

    /// What is to be reported where effects that change from period to period are found beside what explains the averages.
    fn over_periods(
        &self,
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
            true => self.report(explaining, explanation).map(Some),
            false => Ok(None),
        }
    }

    /// Reports an explanation, without the names in whose place formulas leave less.
    fn report(
        &self,
        explaining: &Explaining<'_>,
        mut explanation: Explanation,
    ) -> Result<Reported, DiagnoseError> {
        loop {
            let reporting = Reporting {
                contexts: explaining.contexts,
                explanation: &explanation,
                rules: explaining.rules,
            };
            let reported = reporting.report()?;
            let outdone = reported.nameless.outdone();
            if outdone.is_empty() {
                return Ok(reported);
            }
            explanation = explaining.without(&explanation, &outdone)?;
        }
    }
}

fn sought(settings: &DiagnoseTable) -> Option<Vec<String>> {
    match &settings.effects.value {
        SoughtEffects::All => None,
        SoughtEffects::Listed(ids) => Some(ids.iter().map(|id| id.value.clone()).collect()),
    }
}
