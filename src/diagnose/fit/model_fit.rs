//! A fitted model with hypotheses, and its residuals.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::model::Model;
use crate::chain::prior::Prior;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::start::{Start, WarmStart};
use crate::estimate::covariance::of_unknowns;
use crate::estimate::estimator::Training;
use crate::estimate::problem::FitProblem;
use crate::estimate::unknowns::Unknowns;
use crate::estimate::weights::Weights;
use crate::problem::solution::Solution;
use crate::recording::split::Split;
use crate::stats::deviation::{deviations, rms};
use crate::stats::encompassing::ResidualPair;
use nalgebra::DVector;

/// A fitted model and what it leaves.
#[derive(Debug, Clone)]
pub struct ModelFit {
    /// What it has beyond the declared model.
    pub hypotheses: Vec<Hypothesis>,
    /// The declared model with the hypotheses in it.
    pub model: Model,
    /// What is known before the data.
    pub prior: Prior,
    /// What of its parameters is estimated, and in which order.
    pub unknowns: Unknowns,
    /// All its parameters at the optimum, in SI units.
    pub values: DVector<f64>,
    /// Values in each recording that is held out, where parameters belong to a recording.
    pub own: Vec<DVector<f64>>,
    /// Residuals `ŝ − s`, `[channel][row]`, of what was fitted and of what was held out.
    pub train: Vec<Vec<f64>>,
    /// The same of what was held out.
    pub validation: Vec<Vec<f64>>,
    /// How the solver ended.
    pub solution: Solution,
}

impl ModelFit {
    /// Values of all parameters by name.
    pub fn start(&self) -> Start {
        let names = self.model.parameters().iter().map(|p| p.name.clone());
        names.zip(self.values.iter().copied()).collect()
    }

    /// `v/(|v| + w)` of a joint's speed with its fitted transition speed w.
    pub fn direction(&self, joint: usize) -> impl Fn(&f64) -> f64 + use<> {
        let width = self.model.joints()[joint].width;
        let width = width.map_or(0.0, |index| self.values[index]);
        move |v: &f64| v / (v.abs() + width).max(f64::MIN_POSITIVE)
    }

    /// The fitted values in another model, which keeps its own where this one has no parameter of that name.
    pub fn values_of(&self, model: &Model) -> DVector<f64> {
        let mut values = model.values();
        for (k, parameter) in model.parameters().iter().enumerate() {
            if let Some(index) = self.model.position(&parameter.name) {
                values[k] = self.values[index];
            }
        }
        values
    }

    /// From where a fit of another model begins.
    pub fn warm_start(&self) -> WarmStart {
        WarmStart {
            values: self.start(),
            deviations: self.deviations(),
        }
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

    /// The fit as a problem, weighted by the deviations of its residuals.
    pub fn problem<'b>(&'b self, recordings: &'b [&'b Prepared]) -> FitProblem<'b> {
        FitProblem::new(
            &self.model,
            &self.unknowns,
            Training {
                recordings,
                prior: &self.prior,
            },
            Weights::by_deviation(&self.deviations()),
        )
    }

    /// Standard deviation of the estimate of each parameter of the model, as the given recordings tell it; `None` where a
    /// parameter is none of the unknowns, or the covariance is none.
    pub fn parameter_deviations(&self, recordings: &[&Prepared]) -> Vec<Option<f64>> {
        let problem = self.problem(recordings);
        let mut deviations = vec![None; self.model.parameters().len()];
        if let Some(covariance) = of_unknowns(&problem, &self.solution.x) {
            for (k, &p) in problem.unknowns.positions().iter().enumerate() {
                deviations[p] = Some(covariance[(k, k)].max(0.0).sqrt());
            }
        }
        deviations
    }
}

fn score(residuals: &[Vec<f64>]) -> f64 {
    let of = |e: &Vec<f64>| e.len() as f64 * 2.0 * rms(e).max(f64::MIN_POSITIVE).ln();
    let active = residuals.iter().filter(|e| !e.is_empty());
    active.map(of).sum()
}

/// A model and one that is richer, or that takes its place.
#[derive(Debug, Clone, Copy)]
pub struct FitPair<'a> {
    /// The simpler of the two, or the one whose place is taken.
    pub poorer: &'a ModelFit,
    /// The other.
    pub richer: &'a ModelFit,
}

impl<'a> FitPair<'a> {
    /// What both leave of the held-out rows.
    pub fn held_out(self) -> ResidualPair<'a> {
        ResidualPair {
            poorer: &self.poorer.validation,
            richer: &self.richer.validation,
        }
    }
}
