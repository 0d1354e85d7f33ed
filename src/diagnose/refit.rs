//! A model with hypotheses in it and all of its parameters fitted again.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::effect::Linearity;
use crate::chain::model::Model;
use crate::chain::prior::Prior;
use crate::diagnose::bench::Bench;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::own;
use crate::diagnose::rows::{Series, deviations, rms};
use crate::estimate::error::EstimateError;
use crate::estimate::problem::FitProblem;
use crate::estimate::unknowns::Unknowns;
use crate::estimate::weights::Weights;
use crate::problem::Problem;
use crate::problem::form::Structure;
use crate::problem::solution::{Control, Solution};
use crate::problem::view::LeastSquares;
use crate::recording::split::Split;
use crate::solve::{levenberg_marquardt, linear};
use nalgebra::DVector;

/// Parameter values by name, from which a fit starts.
pub type Start = Vec<(String, f64)>;

/// A fitted model and what it leaves.
#[derive(Debug, Clone)]
pub struct Refit {
    pub hypotheses: Vec<Hypothesis>,
    pub model: Model,
    pub prior: Prior,
    pub unknowns: Unknowns,
    pub values: DVector<f64>,
    /// Values in each recording that is held out, where parameters belong to a recording.
    pub own: Vec<DVector<f64>>,
    /// Residuals `ŝ − s`, `[channel][row]`, of what was fitted and of what was held out.
    pub train: Vec<Vec<f64>>,
    pub validation: Vec<Vec<f64>>,
    pub solution: Solution,
}

/// Share of the cost that a search may leave: for 1e4 residuals a hundredth of a standard deviation of one
/// parameter, far below what moves a held-out error by 1 %.
const COST_TOLERANCE: f64 = 1e-7;

/// Iterations of one search.
const ITERATION_LIMIT: usize = 40;

/// Rounds in which the weights follow the residuals.
const ROUNDS: usize = 4;

/// The weights have settled when no deviation changes by more than this share.
const SETTLED: f64 = 0.05;

impl Refit {
    /// Values of all parameters by name.
    pub fn start(&self) -> Start {
        let names = self.model.parameters().iter().map(|p| p.name.clone());
        names.zip(self.values.iter().copied()).collect()
    }

    /// Deviations of the fitted residuals, per channel; 1 for channels that are not active.
    pub fn deviations(&self) -> Vec<f64> {
        deviations(&self.train)
    }

    /// `Σ_c N_c ln(mean e_c²)` over what was held out: minus twice the logarithm of its likelihood, up to a
    /// constant, with the deviations at their best.
    pub fn held_out_score(&self) -> f64 {
        score(&self.validation)
    }

    /// The same over what was fitted.
    pub fn fitted_score(&self) -> f64 {
        score(&self.train)
    }

    /// Number of unknowns.
    pub fn freedom(&self) -> usize {
        self.unknowns.positions().len()
    }

    /// Values of the parameters in a recording of the dataset, by its number.
    pub fn values_in<'b>(&'b self, data: &Dataset, recording: usize) -> &'b DVector<f64> {
        let is_held_out = |k: &usize| data.recordings[*k].split == Split::Validation;
        match is_held_out(&recording) {
            true => {
                let number = (0..recording).filter(is_held_out).count();
                self.own.get(number).unwrap_or(&self.values)
            }
            false => &self.values,
        }
    }

    /// The same fit with what it leaves on the held-out rows of another bench.
    pub fn on(&self, bench: &Bench<'_>) -> Self {
        let held_out = bench.recordings(Split::Validation);
        Self {
            validation: held_out_residuals(&self.model, (&self.values, &self.own), &held_out),
            ..self.clone()
        }
    }

    /// The fit as a problem, weighted by the deviations of its residuals.
    pub fn problem<'b>(&'b self, recordings: &'b [&'b Prepared]) -> FitProblem<'b> {
        FitProblem::new(
            &self.model,
            &self.unknowns,
            (recordings, &self.prior),
            Weights::by_deviation(&self.deviations()),
        )
    }
}

fn score(residuals: &[Vec<f64>]) -> f64 {
    let of = |e: &Vec<f64>| e.len() as f64 * 2.0 * rms(e).max(f64::MIN_POSITIVE).ln();
    let active = residuals.iter().filter(|e| !e.is_empty());
    active.map(of).sum()
}

/// Fits the declared model with hypotheses, from values by name and with deviations of the residuals to
/// begin with.
pub fn refit(
    bench: &Bench<'_>,
    hypotheses: &[Hypothesis],
    from: (&Start, &[f64]),
) -> Result<Refit, DiagnoseError> {
    refit_holding(bench, hypotheses, from, &[])
}

/// The same while nonlinear parameters of some names stay at values.
pub fn refit_holding(
    bench: &Bench<'_>,
    hypotheses: &[Hypothesis],
    (start, first): (&Start, &[f64]),
    held: &[(String, f64)],
) -> Result<Refit, DiagnoseError> {
    let (mut model, prior) = bench.model(hypotheses)?;
    apply(&mut model, start);
    for (name, value) in held {
        let index = model.find(name).map_err(EstimateError::from)?;
        if model.parameters()[index].linearity == Linearity::Nonlinear {
            model.fix(index, *value).map_err(EstimateError::from)?;
        }
    }
    let unknowns = Unknowns::find(&model, bench.data, &prior);
    let recordings = bench.recordings(Split::Train);
    let mut scale = first.to_vec();
    let mut done: Option<(Solution, DVector<f64>, Vec<Vec<f64>>)> = None;
    for _ in 0..ROUNDS {
        let weights = Weights::by_deviation(&scale);
        let problem = FitProblem::new(&model, &unknowns, (&recordings, &prior), weights);
        let from = match &done {
            Some((solution, ..)) => solution.x.clone(),
            None => problem.start(),
        };
        let solution = solve(&problem, &from, bench.control)?;
        let values = problem.parameters(&solution.x);
        let train = Series::of(&model, &values, &[], &recordings).residuals();
        let next = deviations(&train);
        let change = next.iter().zip(&scale).map(|(a, b)| (a / b - 1.0).abs());
        let change = change.fold(0.0, f64::max);
        done = Some((solution, values, train));
        scale = next;
        if change <= SETTLED || bench.control.is_interrupted() {
            break;
        }
    }
    let (solution, values, train) = done.ok_or(EstimateError::NoTraining)?;
    let own = own::values(bench, &model, (&values, &scale))?;
    let held_out = bench.recordings(Split::Validation);
    let validation = held_out_residuals(&model, (&values, &own), &held_out);
    Ok(Refit {
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
    (values, own): (&DVector<f64>, &[DVector<f64>]),
    held_out: &[&Prepared],
) -> Vec<Vec<f64>> {
    if own.is_empty() {
        return Series::of(model, values, &[], held_out).residuals();
    }
    let mut all = vec![Vec::new(); model.channels().len()];
    for (recording, values) in held_out.iter().zip(own) {
        let residuals = Series::of(model, values, &[], &[*recording]).residuals();
        all.iter_mut()
            .zip(residuals)
            .for_each(|(to, e)| to.extend(e));
    }
    all
}

fn apply(model: &mut Model, start: &Start) {
    for (name, value) in start {
        if let Ok(index) = model.find(name)
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
