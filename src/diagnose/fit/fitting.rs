//! Fits of models with hypotheses in them, all parameters free.

use crate::chain::dataset::Prepared;
use crate::chain::effect::Linearity;
use crate::chain::model::Model;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::fit::channel_series::ChannelSeries;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::fit::recording_parameters;
use crate::diagnose::fit::start::{Start, WarmStart};
use crate::estimate::canonical_sines;
use crate::estimate::error::EstimateError;
use crate::estimate::estimator::Training;
use crate::estimate::gap_search::{self, Measure};
use crate::estimate::problem::FitProblem;
use crate::estimate::unknowns::Unknowns;
use crate::estimate::weights::Weights;
use crate::problem::Problem;
use crate::problem::form::Structure;
use crate::problem::solution::{Control, Solution};
use crate::problem::view::LeastSquares;
use crate::recording::split::Split;
use crate::setup::model_spec::ModelWithPrior;
use crate::solve::{levenberg_marquardt, linear};
use crate::stats::deviation::deviations;
use nalgebra::DVector;

/// Share of the cost that one more step may promise where a search ends: for 1e4 residuals a tenth of a standard deviation of one
/// parameter, and less than a ten-thousandth of what moves an error by 1 %.
const COST_TOLERANCE: f64 = 1e-6;

/// Iterations of one search.
const ITERATION_LIMIT: usize = 40;

/// Rounds in which the weights follow the residuals.
const ROUNDS: usize = 4;

/// The weights have settled when no deviation changes by more than this share.
const SETTLED: f64 = 0.05;

impl ModelFit {
    /// The model as a further fit of it begins, at the values that were found.
    pub fn started(&self) -> Model {
        let mut model = self.model.clone();
        apply(&mut model, &self.start());
        model
    }

    /// The same model where a step has changed its unknowns, and what it leaves there.
    pub fn stepped(&self, context: &Context<'_>, step: &DVector<f64>) -> Self {
        let [recordings, held_out] =
            [Split::Train, Split::Validation].map(|split| context.recordings(split));
        let mut moved = self.clone();
        moved.solution.x += step;
        moved.values = self.problem(&recordings).parameters(&moved.solution.x);
        let change = &moved.values - &self.values;
        moved.own.iter_mut().for_each(|values| *values += &change);
        moved.train = ChannelSeries::of(&moved.model, &moved.values, &[], &recordings).residuals();
        moved.validation = held_out_residuals(&moved.model, &moved.values, &moved.own, &held_out);
        moved
    }

    /// The same fit with what it leaves on the held-out rows of another context.
    pub fn on(&self, context: &Context<'_>) -> Self {
        let held_out = context.recordings(Split::Validation);
        Self {
            validation: held_out_residuals(&self.model, &self.values, &self.own, &held_out),
            ..self.clone()
        }
    }
}

/// Fits the declared model; residuals are weighted by the signal to begin with.
pub fn fit_declared(context: &Context<'_>) -> Result<ModelFit, DiagnoseError> {
    let from = WarmStart {
        values: Start::new(),
        deviations: context.signal_rms(Split::Train),
    };
    let make = || fit_model(context, &[], &from);
    context.cache.fit_model(&[], make)
}

/// Fits the declared model with hypotheses; its weights follow the residuals.
pub fn fit_model(
    context: &Context<'_>,
    hypotheses: &[Hypothesis],
    from: &WarmStart,
) -> Result<ModelFit, DiagnoseError> {
    let model = context.model(hypotheses)?;
    fit(context, hypotheses, model, from, ROUNDS, Gaps::FromStart)
}

/// The same with the gaps of gears searched for, everything else fitted beside each of their values.
pub fn fit_model_searching_gaps(
    context: &Context<'_>,
    hypotheses: &[Hypothesis],
    from: &WarmStart,
) -> Result<ModelFit, DiagnoseError> {
    let model = context.model(hypotheses)?;
    fit(context, hypotheses, model, from, ROUNDS, Gaps::Searched)
}

/// With the weights with which it begins, and while nonlinear parameters of some names stay at values: the way to a start, or to
/// which of several starts is the best.
pub fn fit_model_holding(
    context: &Context<'_>,
    hypotheses: &[Hypothesis],
    from: &WarmStart,
    held: &[(String, f64)],
) -> Result<ModelFit, DiagnoseError> {
    let mut with_prior = context.model(hypotheses)?;
    let model = &mut with_prior.model;
    for (name, value) in held {
        let index = model.find(name).map_err(EstimateError::from)?;
        if model.parameters()[index].linearity == Linearity::Nonlinear {
            model.fix(index, *value).map_err(EstimateError::from)?;
        }
    }
    fit(context, hypotheses, with_prior, from, 1, Gaps::FromStart)
}

/// Where the gaps of gears come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Gaps {
    /// From the start, by steps of all parameters.
    FromStart,
    /// From their grids, everything else fitted beside each value.
    Searched,
}

fn fit(
    context: &Context<'_>,
    hypotheses: &[Hypothesis],
    ModelWithPrior { mut model, prior }: ModelWithPrior,
    from: &WarmStart,
    rounds: usize,
    gaps: Gaps,
) -> Result<ModelFit, DiagnoseError> {
    apply(&mut model, &from.values);
    let unknowns = Unknowns::find(&model, context.data, &prior);
    let recordings = context.recordings(Split::Train);
    let mut scale = from.deviations.clone();
    let mut done: Option<(Solution, DVector<f64>, Vec<Vec<f64>>)> = None;
    for _ in 0..rounds {
        let weights = Weights::by_deviation(&scale);
        let problem = FitProblem::new(
            &model,
            &unknowns,
            Training {
                recordings: &recordings,
                prior: &prior,
            },
            weights,
        );
        let from = match &done {
            Some((solution, ..)) => solution.x.clone(),
            None if gaps == Gaps::Searched => {
                gap_search::refined(&problem, problem.start(), Measure::Squares, context.control)
            }
            None => problem.start(),
        };
        let solution =
            canonical_sines::canonical(&problem, solve(&problem, &from, context.control)?);
        let values = problem.parameters(&solution.x);
        let train = ChannelSeries::of(&model, &values, &[], &recordings).residuals();
        let next = deviations(&train);
        let change = next.iter().zip(&scale).map(|(a, b)| (a / b - 1.0).abs());
        let change = change.fold(0.0, f64::max);
        done = Some((solution, values, train));
        scale = next;
        if change <= SETTLED || context.control.is_interrupted() {
            break;
        }
    }
    let (solution, values, train) = done.ok_or(EstimateError::NoTraining)?;
    let own = recording_parameters::values(context, &model, &values, &scale)?;
    let held_out = context.recordings(Split::Validation);
    let validation = held_out_residuals(&model, &values, &own, &held_out);
    Ok(ModelFit {
        own,
        hypotheses: hypotheses.to_vec(),
        model,
        prior,
        unknowns,
        values,
        train,
        validation,
        solution,
    })
}

fn held_out_residuals(
    model: &Model,
    values: &DVector<f64>,
    own: &[DVector<f64>],
    held_out: &[&Prepared],
) -> Vec<Vec<f64>> {
    if own.is_empty() {
        return ChannelSeries::of(model, values, &[], held_out).residuals();
    }
    let mut all = vec![Vec::new(); model.channels().len()];
    for (recording, values) in held_out.iter().zip(own) {
        let residuals = ChannelSeries::of(model, values, &[], &[*recording]).residuals();
        all.iter_mut()
            .zip(residuals)
            .for_each(|(to, e)| to.extend(e));
    }
    all
}

fn apply(model: &mut Model, start: &Start) {
    for (name, value) in start {
        if let Some(index) = model.position(name)
            && model.parameters()[index].is_free()
        {
            model.start(index, *value);
        }
    }
}

fn solve(
    problem: &FitProblem<'_>,
    start: &DVector<f64>,
    control: &Control<'_>,
) -> Result<Solution, EstimateError> {
    let view = LeastSquares::try_from(problem as &dyn Problem)?;
    if problem.form().structure == Structure::Affine {
        let solved = linear::solve(view, start, &linear::Settings::default())?;
        return Ok(solved.solution);
    }
    let settings = levenberg_marquardt::Settings {
        cost_tolerance: COST_TOLERANCE,
        max_iterations: ITERATION_LIMIT,
        ..levenberg_marquardt::Settings::default()
    };
    Ok(levenberg_marquardt::minimize(
        view, start, &settings, control,
    )?)
}
