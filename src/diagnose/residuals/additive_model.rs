//! A smooth model of what no effect of the vocabulary explains: a sum of piecewise linear functions of speed, of
//! position and of load, the latter two for either direction of motion.
//!
//! ```text
//! e ≈ Σ_k a_k h_k(v) + Σ_k b_k h_k(q) + c_k h_k(q) d + Σ_k p_k h_k(τ) + r_k h_k(τ) d,    d = sign(v)
//! ```
//!
//! and of one variable more, another joint's motion for example, where that alone leaves much and forecasts the rest;
//! with hat functions h over knots at quantiles; a generalised additive model (Hastie and Tibshirani 1986)
//! with a ridge that keeps what the rows do not determine at zero.

use crate::diagnose::fit::channel_series::ChannelSeries;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::covariates::Covariates;
use crate::diagnose::residuals::effect_size::{MATTERS, OF_NOISE};
use crate::linalg::triangular::Triangular;
use crate::recording::split::Split;
use crate::stats::deviation::rms;
use crate::stats::encompassing::{Encompassing, Known, ResidualPair, ResidualRows};
use crate::stats::range::within;
use nalgebra::{DMatrix, DVector};

/// Knots of a variable.
const KNOTS: usize = 12;

/// Ridge as a share of the mean square of a column.
const RIDGE: f64 = 1e-3;

/// Variables that every smooth model takes: the first three of a joint's covariates.
const VARIABLES: usize = 3;

/// A residual of so many times the variance of the noise is looked at over one variable more.
const MUCH: f64 = 1.5;

/// A smooth model of one channel.
#[derive(Debug, Clone)]
pub struct AdditiveModel {
    /// Its place among the channels.
    pub channel: usize,
    /// Names of its variables.
    pub over: Vec<String>,
    /// Models of the channel that it was chosen from.
    pub tried: usize,
    /// Whether it forecasts the residual on held-out rows.
    pub evidence: Encompassing,
    /// Share by which the held-out RMS error falls.
    pub error_reduction: f64,
    /// RMS of what it takes from the held-out rows over that of what it leaves.
    pub taken: f64,
    /// To be subtracted from the residual, over the fitted and over the held-out rows.
    pub train: Vec<f64>,
    /// The same over the held-out rows.
    pub validation: Vec<f64>,
    curves: Curves,
}

/// Factors of hat functions over some variables of a joint.
#[derive(Debug, Clone)]
struct Curves {
    /// Numbers of the variables among the covariates of the joint.
    variables: Vec<usize>,
    knots: Vec<Vec<f64>>,
    factors: DVector<f64>,
}

impl Curves {
    fn at(&self, covariates: &Covariates) -> Vec<f64> {
        let forecast = design(&covariates.of_some(&self.variables), &self.knots) * &self.factors;
        forecast.as_slice().to_vec()
    }
}

impl AdditiveModel {
    /// Whether it says something that is significant and matters, on the rows that chose it among so many channels' models.
    pub fn is_needed(&self, significance: f64, channels: usize) -> bool {
        let tried = (channels * self.tried) as f64;
        self.evidence.p_value * tried < significance
            && self.error_reduction >= MATTERS
            && self.taken >= OF_NOISE
    }

    /// Whether rows that have not chosen it confirm it, as one of so many tests.
    pub fn is_confirmed(&self, significance: f64, tests: usize) -> bool {
        self.evidence.p_value * (tests as f64) < significance && self.error_reduction > 0.0
    }

    /// The same correction over other rows than those by which it was chosen, with the evidence of these.
    pub fn on(&self, context: &Context<'_>, fit: &ModelFit) -> Self {
        let model = &fit.model;
        let Some(joint) = model.channels()[self.channel].joint else {
            return self.clone();
        };
        let [train, validation] = [Split::Train, Split::Validation].map(|split| {
            let recordings = context.recordings(split);
            let series = ChannelSeries::of(model, &fit.values, &[], &recordings);
            self.curves.at(&Covariates::of(
                model,
                joint,
                &series.predicted,
                &recordings,
            ))
        });
        let before = &fit.validation[self.channel];
        let after: Vec<f64> = before.iter().zip(&validation).map(|(e, f)| e - f).collect();
        Self {
            error_reduction: 1.0 - rms(&after) / rms(before),
            taken: taken(before, &after),
            evidence: evidence(before, &after, context.residual_rows()),
            train,
            validation,
            over: self.over.clone(),
            curves: self.curves.clone(),
            ..*self
        }
    }
}

/// Held-out residuals of a model with smooth corrections.
pub fn left(fit: &ModelFit, corrections: &[&AdditiveModel]) -> Vec<Vec<f64>> {
    let mut left = fit.validation.clone();
    for correction in corrections {
        let pairs = left[correction.channel]
            .iter_mut()
            .zip(&correction.validation);
        pairs.for_each(|(e, f)| *e -= f);
    }
    left
}

/// Of a residual and what a correction leaves of it.
fn evidence(before: &[f64], after: &[f64], rows: ResidualRows) -> Encompassing {
    let pair = ResidualPair {
        poorer: &[before.to_vec()],
        richer: &[after.to_vec()],
    };
    pair.encompassing(Known::default(), rows)
}

/// RMS of what a correction takes over that of what it leaves.
fn taken(before: &[f64], after: &[f64]) -> f64 {
    let squares = rms(before).powi(2) - rms(after).powi(2);
    squares.max(0.0).sqrt() / rms(after)
}

/// Smooth models of what a fit leaves, one per channel of a joint.
pub fn of_all(context: &Context<'_>, fit: &ModelFit) -> Vec<AdditiveModel> {
    let recordings = [Split::Train, Split::Validation].map(|split| context.recordings(split));
    let model = &fit.model;
    let series = [0, 1].map(|k| ChannelSeries::of(model, &fit.values, &[], &recordings[k]));
    let of_channel = |c: usize| {
        let joint = model.channels()[c]
            .joint
            .filter(|_| model.channels()[c].active)?;
        let covariates =
            [0, 1].map(|k| Covariates::of(model, joint, &series[k].predicted, &recordings[k]));
        let channel = Channel {
            number: c,
            train: Observed {
                covariates: &covariates[0],
                residual: &fit.train[c],
            },
            held_out: Observed {
                covariates: &covariates[1],
                residual: &fit.validation[c],
            },
            noise: context.noise.as_ref().map_or(0.0, |noise| noise[c]),
            rows: context.residual_rows(),
        };
        channel.best()
    };
    (0..model.channels().len()).filter_map(of_channel).collect()
}

/// What a model leaves of a channel, with the covariates of its joint over the same rows.
struct Observed<'a> {
    covariates: &'a Covariates,
    residual: &'a [f64],
}

/// A channel for which a smooth model is sought.
struct Channel<'a> {
    number: usize,
    train: Observed<'a>,
    held_out: Observed<'a>,
    /// RMS noise of a row; 0 where it is not known.
    noise: f64,
    rows: ResidualRows,
}

impl Channel<'_> {
    /// The model over the first variables, or the one with the least held-out error among those with one variable more.
    fn best(&self) -> Option<AdditiveModel> {
        let first: Vec<usize> = (0..VARIABLES).collect();
        let plain = self.over(&first)?;
        let left = rms(self.held_out.residual) * (1.0 - plain.error_reduction);
        if left * left <= MUCH * self.noise * self.noise {
            return Some(plain);
        }
        let count = self.train.covariates.variables.len();
        let more =
            (VARIABLES..count).filter_map(|extra| self.over(&[&first[..], &[extra]].concat()));
        let all = std::iter::once(plain).chain(more);
        let mut best = all.max_by(|a, b| a.error_reduction.total_cmp(&b.error_reduction))?;
        best.tried = count - VARIABLES + 1;
        Some(best)
    }

    /// The model over some variables, by number.
    fn over(&self, variables: &[usize]) -> Option<AdditiveModel> {
        let of_train = self.train.covariates.of_some(variables);
        let knots: Vec<Vec<f64>> = of_train
            .variables
            .iter()
            .map(|v| knots(&v.values))
            .collect();
        let design = design(&of_train, &knots);
        let factors = ridge(&design, self.train.residual)?;
        let fitted = &design * &factors;
        let curves = Curves {
            variables: variables.to_vec(),
            knots,
            factors,
        };
        let before = self.held_out.residual;
        let validation = curves.at(self.held_out.covariates);
        let after: Vec<f64> = before.iter().zip(&validation).map(|(e, f)| e - f).collect();
        Some(AdditiveModel {
            channel: self.number,
            over: of_train.variables.iter().map(|v| v.name.clone()).collect(),
            tried: 1,
            error_reduction: 1.0 - rms(&after) / rms(before),
            taken: taken(before, &after),
            evidence: evidence(before, &after, self.rows),
            train: fitted.as_slice().to_vec(),
            validation,
            curves,
        })
    }
}

fn knots(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1);
    let mut knots: Vec<f64> = (0..KNOTS)
        .map(|k| sorted.get(k * last / (KNOTS - 1)).copied().unwrap_or(0.0))
        .collect();
    knots.dedup();
    knots
}

/// Hat functions at all rows; outside the knots the outermost hats are 1.
fn design(covariates: &Covariates, knots: &[Vec<f64>]) -> DMatrix<f64> {
    let rows = covariates.direction.len();
    let mut columns: Vec<DVector<f64>> = Vec::new();
    for (variable, knots) in covariates.variables.iter().zip(knots) {
        for k in 0..knots.len() {
            let hat = DVector::from_fn(rows, |row, _| hat(knots, k, variable.values[row]));
            if variable.by_direction {
                let turned = DVector::from_fn(rows, |row, _| hat[row] * covariates.direction[row]);
                columns.push(turned);
            }
            columns.push(hat);
        }
    }
    DMatrix::from_columns(&columns)
}

fn hat(knots: &[f64], k: usize, x: f64) -> f64 {
    let x = within(x, [knots[0], knots[knots.len() - 1]]);
    if k > 0 && x < knots[k] {
        return ((x - knots[k - 1]) / (knots[k] - knots[k - 1])).max(0.0);
    }
    if k + 1 < knots.len() && x > knots[k] {
        return ((knots[k + 1] - x) / (knots[k + 1] - knots[k])).max(0.0);
    }
    1.0
}

/// `min ‖D x − e‖² + λ ‖x‖²`.
fn ridge(design: &DMatrix<f64>, residual: &[f64]) -> Option<DVector<f64>> {
    let count = design.ncols();
    let weight = (RIDGE * design.norm_squared() / count as f64).sqrt();
    let right = DVector::from_column_slice(residual);
    let mut factor = Triangular::of_system(design, &right);
    let mut rows = DMatrix::zeros(count, count + 1);
    for k in 0..count {
        rows[(k, k)] = weight;
    }
    factor.absorb(rows.as_slice());
    let system = factor.system()?;
    system.matrix.solve_upper_triangular(&system.right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::residuals::covariates::Covariate;
    use crate::robot::random::{generator, symmetric};

    /// Hats over knots add up to one everywhere, and their combination with the knots is the identity between these.
    #[test]
    fn invariant_hats_interpolate_between_knots() {
        let knots = knots(&[3.0, 0.0, 1.0, 7.0, 1.0, 0.5, 2.0, 4.0, 5.0, 6.0, 1.0, 1.0]);
        assert_eq!(knots, [0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        for x in [-3.0, 0.0, 0.2, 0.5, 1.7, 6.99, 7.0, 12.0] {
            let hats: Vec<f64> = (0..knots.len()).map(|k| hat(&knots, k, x)).collect();
            assert!((hats.iter().sum::<f64>() - 1.0).abs() < 1e-14, "{x}");
            let value: f64 = hats.iter().zip(&knots).map(|(h, k)| h * k).sum();
            assert!((value - within(x, [0.0, 7.0])).abs() < 1e-14, "{x}");
            assert!(hats.iter().all(|h| (0.0..=1.0).contains(h)), "{x}");
        }
    }

    /// √(before² − after²)/after.
    #[test]
    fn what_is_taken_is_the_root_of_the_difference_of_squares() {
        assert!((taken(&[5.0, -5.0], &[3.0, 3.0]) - 4.0 / 3.0).abs() < 1e-15);
        assert_eq!(taken(&[1.0], &[2.0]), 0.0);
    }

    /// Bonferroni: as many channels as there are, and as many models of each as it was chosen from.
    #[test]
    fn a_correction_that_was_chosen_among_several_needs_more_evidence() {
        let chosen_among = |tried: usize| AdditiveModel {
            channel: 0,
            over: Vec::new(),
            tried,
            evidence: Encompassing {
                slope: 1.0,
                ratio: 3.0,
                distance: 3.0,
                freedom: 1e3,
                p_value: 1e-4,
            },
            error_reduction: 2.0 * MATTERS,
            taken: 2.0 * OF_NOISE,
            train: Vec::new(),
            validation: Vec::new(),
            curves: Curves {
                variables: Vec::new(),
                knots: Vec::new(),
                factors: DVector::zeros(0),
            },
        };
        assert!(chosen_among(1).is_needed(1.01e-4, 1));
        assert!(!chosen_among(1).is_needed(1.99e-4, 2));
        assert!(chosen_among(3).is_needed(6.01e-4, 2));
        assert!(!chosen_among(3).is_needed(5.99e-4, 2));
        // What has been chosen is one test more, however it was chosen.
        assert!(chosen_among(3).is_confirmed(2.01e-4, 2));
        assert!(!chosen_among(3).is_confirmed(1.99e-4, 2));
    }

    /// Of covariates of which a further one alone has the residual, that one is taken, and all are counted.
    #[test]
    fn every_variable_that_was_tried_is_counted() {
        let rows = 400;
        let series = |k: usize| -> Vec<f64> {
            let mut rng = generator(k as u64);
            (0..rows).map(|_| symmetric(&mut rng, 1.0)).collect()
        };
        let variables = (0..5).map(|k| Covariate {
            name: format!("x{k}"),
            unit: "",
            values: series(k),
            by_direction: false,
            of_another: k >= VARIABLES,
        });
        let covariates = Covariates {
            direction: vec![1.0; rows],
            variables: variables.collect(),
        };
        let residual = covariates.variables[4].values.clone();
        let observed = || Observed {
            covariates: &covariates,
            residual: &residual,
        };
        let channel = Channel {
            number: 0,
            train: observed(),
            held_out: observed(),
            noise: 0.0,
            rows: ResidualRows::Recorded,
        };
        let best = channel.best().unwrap();
        assert_eq!(best.over.last().map(String::as_str), Some("x4"));
        // The three of every model, and either of two more.
        assert_eq!(best.tried, 3);
    }
}
