//! Fits that a trial is judged by: of the declared model without noise, and of a model that knows the truth.

use crate::chain::dataset::Dataset;
use crate::chain::effect;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::fitting::fit_model;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::fit::start::{Start, WarmStart};
use crate::diagnose::residuals::standstill;
use crate::diagnose::selection::between_periods::successive_periods;
use crate::estimate::bandwidth;
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::recording::split::Split;
use crate::setup;
use crate::stats::deviation::rms;
use crate::trials::concealed_effect::Concealed;
use crate::trials::error::TrialError;
use crate::trials::plan::Plan;
use std::path::Path;

/// What is left of the concealed physics, per joint: held-out RMS over the noise of a row, of periods that are averaged,
/// where there are any, and of single samples.
#[derive(Debug, Clone, Default)]
pub struct Sizes {
    /// Of averages over periods; of samples where nothing repeats.
    pub averaged: Vec<f64>,
    /// Of samples in the order of time; empty where nothing concealed changes with time.
    pub in_time: Vec<f64>,
}

pub(super) fn sizes(
    plan: &Plan,
    problem: &Path,
    control: &Control<'_>,
) -> Result<Sizes, TrialError> {
    let opened = DeclaredModel::read(problem, control)?;
    let of = |data: &Dataset, periods: f64| -> Result<Vec<f64>, TrialError> {
        let left = opened.fit(data, &[], &Start::new(), control)?.validation;
        let pairs = left.iter().zip(&plan.robot.noise);
        Ok(pairs
            .map(|(e, noise)| rms(e) * periods.sqrt() / noise)
            .collect())
    };
    let averaged = match plan.motion.repeats() {
        true => plan.length.periods as f64,
        false => 1.0,
    };
    Ok(Sizes {
        averaged: of(&opened.data, averaged)?,
        in_time: match plan.concealed.iter().any(Concealed::changes_with_time) {
            true => of(&successive_periods(&opened.data), 1.0)?,
            false => Vec::new(),
        },
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
        true => successive_periods(&opened.data),
        false => opened.data.clone(),
    };
    let start: Start = plan
        .concealed
        .iter()
        .flat_map(|c| c.values.clone())
        .collect();
    let truth = plan.concealed.iter().map(|c| c.hypothesis.clone());
    let hypotheses: Vec<Hypothesis> = truth.collect();
    Ok(Some(ReferenceFits {
        declared: opened.fit(&data, &[], &Start::new(), control)?,
        known: opened.fit(&data, &hypotheses, &start, control)?,
    }))
}

/// A declared model with its recordings.
pub struct DeclaredModel {
    problem: ProblemFile,
    robot: setup::robot::Robot,
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
        let mut model = setup::model::build(&problem, &robot)?;
        let prior = setup::prior::build(&problem, &robot, &mut model)?;
        let prepared = bandwidth::prepared(&problem, &robot, &model, &prior, control)?;
        let data = standstill::left_out(&model, prepared);
        Ok(Self {
            problem,
            robot,
            data,
        })
    }

    /// What fits of a diagnosis share.
    pub fn context<'b>(&'b self, data: &'b Dataset, control: &'b Control<'b>) -> Context<'b> {
        Context::new(&self.problem, &self.robot, data, control)
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
