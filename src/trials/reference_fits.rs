//! Fits that a trial is judged by: of the declared model without noise, and of a model that knows the truth.

use crate::chain::dataset::Dataset;
use crate::chain::effect;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::fitting::fit_model;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::fit::start::{Start, WarmStart};
use crate::estimate::bandwidth::Preparing;
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::recording::split::Split;
use crate::setup;
use crate::setup::model_spec::{ModelSpec, ModelWithPrior};
use crate::setup::recording_file::RecordedRobot;
use crate::stats::deviation::rms;
use crate::trials::concealed_effect::Concealed;
use crate::trials::error::TrialError;
use crate::trials::plan::Plan;
use std::path::Path;

/// How much each concealed law leaves where the model lacks it alone: held-out RMS over the noise of a row, at the joint
/// where that is most; of averages over periods, where there are any and it does not change with time, else of samples.
#[derive(Debug, Clone, Default)]
pub struct Sizes {
    /// Of the effects in their order.
    pub effects: Vec<f64>,
    /// Of the law outside the vocabulary.
    pub outside: Option<f64>,
}

pub(super) fn sizes(
    plan: &Plan,
    problem: &Path,
    control: &Control<'_>,
) -> Result<Sizes, TrialError> {
    let opened = DeclaredModel::read(problem, control)?;
    let periods = plan.averaged();
    let largest = |left: &[Vec<f64>], joints: &[usize], periods: f64| {
        let of_joint = |j: usize| rms(&left[j]) * periods.sqrt() / plan.robot.noise[j];
        joints.iter().map(|&j| of_joint(j)).fold(f64::NAN, f64::max)
    };
    let without = |k: usize, concealed: &Concealed| -> Result<f64, TrialError> {
        let others = plan.concealed.iter().enumerate().filter(|(i, _)| *i != k);
        let others: Vec<&Concealed> = others.map(|(_, other)| other).collect();
        let (data, periods) = match concealed.changes_with_time() {
            true => (opened.data.in_successive_periods(), 1.0),
            false => (opened.data.clone(), periods),
        };
        let left = opened.fit_with(&data, &others, control)?.validation;
        Ok(largest(&left, &concealed.joints(), periods))
    };
    let each = plan.concealed.iter().enumerate();
    let outside = plan.outside_joint().map(|joint| {
        let left = opened.fit_with(&opened.data, &[], control)?.validation;
        Ok::<f64, TrialError>(largest(&left, &[joint], periods))
    });
    Ok(Sizes {
        effects: each.map(|(k, c)| without(k, c)).collect::<Result<_, _>>()?,
        outside: outside.transpose()?,
    })
}

/// Fits of a declared model with the truth in it: what a diagnosis could reach.
pub struct ReferenceFits {
    /// Without what is concealed.
    pub declared: ModelFit,
    /// The declared model with what is concealed.
    pub known: ModelFit,
}

pub(super) fn informed(
    plan: &Plan,
    problem: &Path,
    control: &Control<'_>,
) -> Result<Option<ReferenceFits>, TrialError> {
    if plan.concealed.is_empty() {
        return Ok(None);
    }
    let opened = DeclaredModel::read(problem, control)?;
    let data = match plan.concealed.iter().any(Concealed::changes_with_time) {
        true => opened.data.in_successive_periods(),
        false => opened.data.clone(),
    };
    let concealed: Vec<&Concealed> = plan.concealed.iter().collect();
    Ok(Some(ReferenceFits {
        declared: opened.fit_with(&data, &[], control)?,
        known: opened.fit_with(&data, &concealed, control)?,
    }))
}

/// A declared model with its recordings.
pub struct DeclaredModel {
    /// What is declared.
    pub declared: ModelSpec,
    /// The recordings, prepared.
    pub data: Dataset,
}

impl DeclaredModel {
    /// Reads problem, robot and recordings of a trial.
    ///
    /// # Errors
    /// As the tasks that read them.
    pub fn read(path: &Path, control: &Control<'_>) -> Result<Self, TrialError> {
        let problem = ProblemFile::read(path, &[], &effect::ids())?;
        let robot = setup::robot::open(&problem)?;
        let declared = ModelSpec::of(&problem, &robot)?;
        let ModelWithPrior { model, prior } = declared.build()?;
        let preparing = Preparing {
            recorded: RecordedRobot {
                table: problem.recordings()?,
                robot: &robot,
                model: &model,
            },
            prior: &prior,
            control,
        };
        let data = preparing.prepared()?;
        Ok(Self { declared, data })
    }

    /// What fits of a diagnosis share.
    pub fn context<'b>(&'b self, data: &'b Dataset, control: &'b Control<'b>) -> Context<'b> {
        Context::new(&self.declared, data, control)
    }

    /// Fits the declared model with some of what is concealed in it, from its true values.
    fn fit_with(
        &self,
        data: &Dataset,
        concealed: &[&Concealed],
        control: &Control<'_>,
    ) -> Result<ModelFit, TrialError> {
        let values = concealed.iter().flat_map(|c| c.values.clone());
        let hypotheses: Vec<Hypothesis> = concealed.iter().map(|c| c.hypothesis.clone()).collect();
        self.fit(data, &hypotheses, &values.collect(), control)
    }

    /// Fits the declared model with hypotheses in it.
    ///
    /// # Errors
    /// A model that cannot be built or fitted.
    pub fn fit(
        &self,
        data: &Dataset,
        hypotheses: &[Hypothesis],
        start: &Start,
        control: &Control<'_>,
    ) -> Result<ModelFit, TrialError> {
        let context = self.context(data, control);
        let from = WarmStart {
            values: start.clone(),
            deviations: context.signal_rms(Split::Train),
        };
        Ok(fit_model(&context, hypotheses, &from)?)
    }
}
