//! The task behind `exid fit`: from a robot, what its model is made of, and recordings to the reported estimate.

use crate::chain::dataset::Dataset;
use crate::chain::model::{Model, Signal};
use crate::chain::parameter::Parameter;
use crate::chain::prior::Prior;
use crate::chain::transition_limits::{SettledFit, TransitionFit, TransitionLimits};
use crate::estimate::derived::model_comparison::{self, ComparedModel};
use crate::estimate::derived::remarks::{misfit, notes, preprocessing, undetermined_load};
use crate::estimate::derived::{load, reactions};
use crate::estimate::error::EstimateError;
use crate::estimate::feasible::{self, Form};
use crate::estimate::fit::{Fitted, fit, in_full};
use crate::estimate::fit_problem::estimator::Estimator;
use crate::estimate::initial::search_range;
use crate::estimate::minimisation::bandwidth::Preparing;
use crate::estimate::sharing::{self, Question};
use crate::estimate::{errors_in_variables, load_by_difference, unshown_friction};
use crate::fault::Place;
use crate::outcome::estimate::Estimate;
use crate::outcome::fit::Comparison;
use crate::outcome::machine::Machine;
use crate::outcome::sharing::Sharing;
use crate::problem::defect::{Defect, guarded};
use crate::problem::solution::{Control, Stop};
use crate::problem_file::choices::{LoadFrom, Motion};
use crate::problem_file::{FitTable, ProblemFile, RecordingsTable, choices};
use crate::setup;
use crate::setup::error::{Mismatch, SetupError};
use crate::setup::model_spec::{Addition, ModelSpec, ModelWithPrior};
use crate::setup::recording_file::RecordedRobot;
use crate::setup::robot::Robot;
use nalgebra::DVector;
use thiserror::Error;

/// Why `fit` gives no result.
#[derive(Debug, Error)]
pub enum FitError {
    /// The problem, its robot or its recordings.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The model cannot be fitted to the recordings.
    #[error("{place}: {error}")]
    Estimate {
        /// The problem file, as text.
        place: String,
        /// Why.
        error: Box<EstimateError>,
    },
    /// Nothing was found before it.
    #[error(transparent)]
    Defect(#[from] Defect),
}

/// A fit with the recordings that it was made from.
#[derive(Debug)]
pub struct FitRun {
    /// The fit, with the model that it is of.
    pub fitted: Fitted,
    /// The recordings as they were fitted.
    pub data: Dataset,
    /// What ended the search, where the rest is what was found before it.
    pub defect: Option<Defect>,
}

/// Steps of a fit, as progress shows them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// Recordings are read, differentiated and averaged over periods.
    Reading,
    /// The model is fitted.
    Fitting,
    /// Models to compare with are fitted.
    Comparing,
    /// It is asked whether joints have parameters in common.
    Sharing,
}

impl Step {
    /// As progress shows it.
    pub fn words(self) -> &'static str {
        match self {
            Self::Reading => "reading and differentiating the recordings",
            Self::Fitting => "fitting",
            Self::Comparing => "fitting the models to compare with",
            Self::Sharing => "asking whether joints have parameters in common",
        }
    }
}

/// Runs the fit of a problem file; `on_step` hears of every step.
///
/// # Errors
/// Faults of the file and of those that it names, and as [`FitTask::run`].
pub fn run(
    problem: &ProblemFile,
    control: &Control<'_>,
    on_step: impl Fn(Step),
) -> Result<FitRun, FitError> {
    let robot = setup::robot::open(problem)?;
    let declared = ModelSpec::of(problem, &robot)?;
    let task = FitTask {
        robot: &robot,
        declared: &declared,
        recordings: problem.recordings().map_err(SetupError::from)?,
        settings: &problem.fit,
    };
    task.run(control, on_step)
}

/// A model, the recordings that it is fitted to, and how.
#[derive(Debug, Clone, Copy)]
pub struct FitTask<'a> {
    /// The robot that the recordings are of.
    pub robot: &'a Robot,
    /// What its model is made of.
    pub declared: &'a ModelSpec,
    /// Those that are fitted and those that are held out.
    pub recordings: &'a RecordingsTable,
    /// The estimator, limits, priors, and models to compare with.
    pub settings: &'a FitTable,
}

impl FitTask<'_> {
    /// Runs the fit; `on_step` hears of every step.
    ///
    /// # Errors
    /// Recordings that cannot be read; a model that they do not determine; a defect before anything was found.
    pub fn run(&self, control: &Control<'_>, on_step: impl Fn(Step)) -> Result<FitRun, FitError> {
        let ModelWithPrior { mut model, prior } = self.declared.build()?;
        on_step(Step::Reading);
        let preparing = Preparing {
            recorded: RecordedRobot {
                table: self.recordings,
                robot: self.robot,
                model: &model,
            },
            prior: &prior,
            control,
        };
        let data = preparing.prepared()?;
        on_step(Step::Fitting);
        let settled = TransitionLimits::of(&data).settle(control, |limits| {
            let mut model = model.clone();
            model.limit_transitions(limits);
            search_range::start_within_motion(&mut model, &data);
            let found = or_before_defect(control, |control| {
                let task = ModelTask {
                    settings: self.settings,
                    model: &model,
                    data: &data,
                    prior: &prior,
                    control,
                };
                task.fitted()
            });
            found.map(|(fitted, defect)| Attempt { fitted, defect })
        })?;
        let SettledFit { fit, limits, wider } = settled;
        let (mut fitted, mut defect) = (fit.fitted, fit.defect);
        if let Some(wider) = wider.filter(|wider| wider.fit.defect.is_none()) {
            let note = unshown_friction::admit(&mut fitted, &wider.fit.fitted, &wider.joints);
            fitted.fit.notes.extend(note);
        }
        model.limit_transitions(&limits);
        search_range::start_within_motion(&mut model, &data);
        fitted.fit.preprocessing = preprocessing(&model, &data);
        fitted.fit.payload = load::describe(&fitted.estimate);
        fitted.fit.notes.extend(undetermined_load(&fitted.fit));
        fitted.fit.notes.extend(notes(&model, &data));
        fitted.fit.notes.extend(misfit(&fitted.estimate.joints));
        let estimated = &fitted.estimate.parameters;
        let differences =
            setup::declared::differences(self.declared.file_values(), &model, estimated);
        fitted.fit.notes.extend(differences);
        if matches!(model.signal(), Signal::BaseWrench | Signal::Both) {
            let theta_d = reactions::joint_torque_parameters(&fitted.model, &fitted.fit.posterior);
            fitted.fit.joint_torque_parameters = theta_d;
        }
        fitted.fit.machine = Some(machine(self.declared, self.robot, &fitted));
        if self.robot.mechanism.is_none() {
            fitted.fit.possible_machine = possible_machine(self.declared, self.robot, &fitted);
        }
        fitted.fit.model = Some(in_full(&fitted.model, &fitted.values));
        let others = OtherModels {
            task: *self,
            data: &data,
            limits: &limits,
            control,
        };
        if !self.settings.compare.is_empty() {
            on_step(Step::Comparing);
            let compared = guarded(|| others.compare(&mut fitted));
            match compared {
                Ok(compared) => compared?,
                Err(found) => defect = defect.or(Some(found)),
            }
        }
        if self.declared.has_motors_of_one_type() && defect.is_none() && !control.is_interrupted() {
            on_step(Step::Sharing);
            match guarded(|| others.shared(&fitted)) {
                Ok(Ok(answers)) => fitted.fit.sharing = answers,
                Ok(Err(error)) => fitted.fit.notes.push(sharing::unanswered(&error)),
                Err(found) => defect = Some(found),
            }
        }
        if let Some(defect) = &defect {
            stopped(&mut fitted.estimate, Stop::Defect);
            let note = format!("{ENDED_BY_DEFECT} ({defect}).");
            fitted.fit.notes.insert(0, note);
        } else if control.is_interrupted() {
            stopped(&mut fitted.estimate, Stop::Interrupted);
        }
        Ok(FitRun {
            fitted,
            data,
            defect,
        })
    }
}

/// A model that is fitted to recordings.
#[derive(Clone, Copy)]
struct ModelTask<'a> {
    settings: &'a FitTable,
    model: &'a Model,
    data: &'a Dataset,
    prior: &'a Prior,
    control: &'a Control<'a>,
}

impl ModelTask<'_> {
    /// Fits by the estimator, a load as the settings have it.
    fn fitted(&self) -> Result<Fitted, FitError> {
        let fitted = match self.settings.load.value {
            LoadFrom::Together => self.estimate()?,
            LoadFrom::Difference => self.by_difference()?,
        };
        fitted.map_err(|error| self.failed(error))
    }

    fn failed(&self, error: EstimateError) -> FitError {
        let file = &self.settings.estimator.place.file;
        FitError::Estimate {
            place: Place::file(file).key("fit").to_string(),
            error: Box::new(error),
        }
    }

    /// Fits by the estimator.
    fn estimate(&self) -> Result<Result<Fitted, EstimateError>, SetupError> {
        let ModelTask {
            model,
            data,
            prior,
            control,
            ..
        } = *self;
        let plain = |estimator| Ok(fit(model, data, estimator, prior, control));
        let form = match self.settings.estimator.value {
            choices::Estimator::OrdinaryLeastSquares => return plain(Estimator::Ordinary),
            choices::Estimator::WeightedLeastSquares => return plain(Estimator::Weighted),
            choices::Estimator::IterativelyReweightedLeastSquares => {
                return plain(Estimator::Robust);
            }
            choices::Estimator::MaximumLikelihood
                if self.settings.motion.value == Motion::Noisy =>
            {
                return Ok(errors_in_variables::fit::fit(model, data, prior, control));
            }
            choices::Estimator::MaximumLikelihood => return plain(Estimator::MaximumLikelihood),
            choices::Estimator::Feasible => Form::Weighted,
            choices::Estimator::FeasibleMaximumLikelihood => Form::MaximumLikelihood,
            choices::Estimator::ConstantVelocity => {
                return Err(SetupError::mismatch(
                    &self.settings.estimator.place,
                    Mismatch::NotYet {
                        what: "the estimator `constant_velocity`".to_string(),
                        instead: "it has a task of its own, over steady parts of the recordings"
                            .to_string(),
                    },
                ));
            }
        };
        let chosen = &self.settings.prior;
        let settings = feasible::Settings {
            form,
            by: self.settings.feasible_by.value,
            prior: chosen
                .kind
                .as_ref()
                .map(|kind| (kind.value, chosen.strength.value)),
            limits: setup::combined_limits::build(self.settings, model)?,
        };
        Ok(feasible::fit(model, data, prior, &settings, control))
    }

    /// Fits the recordings without the load, then the load on top.
    fn by_difference(&self) -> Result<Result<Fitted, EstimateError>, SetupError> {
        let unloaded = match load_by_difference::without_load(self.model, self.data) {
            Ok(unloaded) => unloaded,
            Err(error) => return Ok(Err(error)),
        };
        let estimator = match self.settings.estimator.value {
            choices::Estimator::OrdinaryLeastSquares => Estimator::Ordinary,
            choices::Estimator::WeightedLeastSquares | choices::Estimator::Feasible => {
                Estimator::Weighted
            }
            choices::Estimator::IterativelyReweightedLeastSquares => Estimator::Robust,
            _ => Estimator::MaximumLikelihood,
        };
        let unloaded = ModelTask {
            data: &unloaded,
            ..*self
        };
        let first = unloaded.estimate()?;
        Ok(first.and_then(|first| {
            load_by_difference::second(first, self.data, estimator, self.control)
        }))
    }
}

/// A fit, or where it would have begun and the defect that ended it.
struct Attempt {
    fitted: Fitted,
    defect: Option<Defect>,
}

impl TransitionFit for Attempt {
    fn model(&self) -> &Model {
        &self.fitted.model
    }

    fn values(&self) -> &DVector<f64> {
        &self.fitted.values
    }

    fn deviations(&self) -> Vec<Option<f64>> {
        let of = |parameter: &Parameter| {
            let sound = self.defect.is_none();
            let estimated = self.fitted.estimate.find(&parameter.name);
            estimated.filter(|_| sound)?.std_dev
        };
        self.fitted.model.parameters().iter().map(of).collect()
    }
}

const ENDED_BY_DEFECT: &str = "The fit was ended by an error within it: parameters are those that it had come to or would have begun \
                               with, and comparisons those that were done";

/// What a search gives, or the point that it would begin at where a defect ends it.
fn or_before_defect<T>(
    control: &Control<'_>,
    search: impl Fn(&Control<'_>) -> Result<T, FitError>,
) -> Result<(T, Option<Defect>), FitError> {
    match guarded(|| search(control)) {
        Ok(found) => Ok((found?, None)),
        Err(defect) => match guarded(|| search(&Control::stopped())) {
            Ok(Ok(start)) => Ok((start, Some(defect))),
            _ => Err(defect.into()),
        },
    }
}

/// Name of the fit that others are compared with.
const THIS_FIT: &str = "this fit";

/// Models that are fitted beside that of the problem.
struct OtherModels<'a> {
    task: FitTask<'a>,
    data: &'a Dataset,
    limits: &'a TransitionLimits,
    control: &'a Control<'a>,
}

impl OtherModels<'_> {
    /// Fits the models to compare with and sets them side by side.
    fn compare(&self, fitted: &mut Fitted) -> Result<(), FitError> {
        let (task, data) = (self.task, self.data);
        let mut others = Vec::new();
        let count = self.control.counting(task.settings.compare.len());
        for compared in &task.settings.compare {
            if self.control.is_interrupted() {
                break;
            }
            let effects = &compared.effects.value;
            let built = task.declared.compared(effects).build()?;
            let ModelWithPrior {
                model: mut other,
                prior,
            } = built;
            other.limit_transitions(self.limits);
            search_range::start_within_motion(&mut other, data);
            let task = ModelTask {
                settings: task.settings,
                model: &other,
                data,
                prior: &prior,
                control: self.control,
            };
            let result = task.estimate()?.map_err(|error| task.failed(error))?;
            fitted.fit.comparison.push(Comparison {
                name: compared.name.value.clone(),
                effects: effects.iter().map(|e| e.value.clone()).collect(),
                joints: result.estimate.joints,
            });
            others.push(result.predictions);
            count.one();
        }
        if self.control.is_interrupted() {
            let note = "The comparison was interrupted: no model is called better than another.";
            fitted.fit.notes.push(note.to_string());
            return Ok(());
        }
        let this = ComparedModel {
            name: THIS_FIT,
            predictions: &fitted.predictions,
        };
        let compared = fitted.fit.comparison.iter().zip(&others);
        let compared = compared.map(|(c, predictions)| ComparedModel {
            name: &c.name,
            predictions,
        });
        let models: Vec<ComparedModel<'_>> = std::iter::once(this).chain(compared).collect();
        fitted.fit.contests = model_comparison::comparisons(&fitted.model, data, &models);
        Ok(())
    }

    /// Asks whether joints with motors of one type have parameters in common.
    fn shared(&self, fitted: &Fitted) -> Result<Vec<Sharing>, FitError> {
        let question = Question {
            declared: self.task.declared,
            addition: &Addition::default(),
            data: self.data,
            limits: self.limits,
        };
        question.answers(fitted, &|model, prior| {
            let task = ModelTask {
                settings: self.task.settings,
                model,
                data: self.data,
                prior,
                control: self.control,
            };
            task.fitted()
        })
    }
}

/// Direct solutions within a search do not know that the search was cut short.
fn stopped(estimate: &mut Estimate, stop: Stop) {
    if let Some(solver) = &mut estimate.solver {
        solver.stop = stop.name().to_string();
        solver.converged = false;
    }
}

/// The identified robot, with the bodies of the realization where there is one.
pub fn machine(declared: &ModelSpec, robot: &Robot, fitted: &Fitted) -> Machine {
    let mut values = fitted.values.clone();
    for realized in &fitted.fit.realization {
        if let Some(position) = fitted.model.position(&realized.name) {
            values[position] = realized.value;
        }
    }
    let feasible = fitted.fit.feasible;
    setup::machine::record(declared, robot, &fitted.model, &values, feasible)
}

/// The nearest possible robot, where that of the realization is none.
pub fn possible_machine(declared: &ModelSpec, robot: &Robot, fitted: &Fitted) -> Option<Machine> {
    let mut values = fitted.values.clone();
    for realized in &fitted.fit.nearest {
        if let Some(position) = fitted.model.position(&realized.name) {
            values[position] = realized.value;
        }
    }
    let has_one = !fitted.fit.nearest.is_empty();
    has_one.then(|| setup::machine::record(declared, robot, &fitted.model, &values, Some(true)))
}
