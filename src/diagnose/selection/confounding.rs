//! Confounding with another joint: names that only resemble what that joint does.
//!
//! Where a finding leaves a misfit that no name explains, what is missing may be something of another joint that the
//! vocabulary has no law for: a channel that hears the current of another, friction that grows with a neighbour's
//! position. Such a thing has shapes in common with many laws, and the one that it resembles most takes the largest part
//! of it. In the place of the finding there is put the variable x of another joint that fits best, its speed, position,
//! load or the product of both speeds, with every parameter of the model fitted again:
//!
//! ```text
//! min_{θ, γ} ‖e(θ) + γ x‖²    and where x acts by direction of motion, γ x + κ x d,  d = sign(v)
//! ```
//!
//! If that forecasts what the finding leaves on recordings that were not fitted, and leaves much less, the name is not
//! that of the physics, and it is withdrawn.

use crate::chain::dataset::Prepared;
use crate::chain::effect::Linearity;
use crate::diagnose::candidates::score_test::Linearised;
use crate::diagnose::fit::channel_series::ChannelSeries;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::channels_of;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::covariates::{Covariate, Covariates};
use crate::diagnose::residuals::noise_level::{NoiseLevel, UNEXPLAINED};
use crate::diagnose::selection::rival_models::{RivalComparison, leaves_more};
use crate::linalg::triangular::Triangular;
use crate::recording::split::Split;
use crate::stats::deviation::deviations;
use crate::stats::encompassing::{Known, ResidualPair};
use crate::stats::range::within;
use nalgebra::DVector;

/// Steps of all parameters in the place of a search: the first from a fitted model, the next with the weights and the
/// derivatives that it leads to.
const STEPS: usize = 4;

/// The first finding of a model that a variable of another joint explains better, if there is one; only where the noise
/// is measured.
pub fn first(
    context: &Context<'_>,
    noise_level: &NoiseLevel,
    full: &ModelFit,
    comparisons: &[RivalComparison],
    significance: f64,
) -> Option<usize> {
    let is_open = |c: &usize| {
        let joint = full.model.channels()[*c].joint;
        joint.is_some() && noise_level.lack_of_fit(&full.validation, &[*c]) > UNEXPLAINED
    };
    if !noise_level.measured {
        return None;
    }
    (0..comparisons.len()).find(|&k| {
        let joints = full.hypotheses[k].named_joints();
        let mut channels = channels_of(&full.model, &joints);
        channels.retain(is_open);
        if channels.is_empty() {
            return false;
        }
        let without = Without::new(context, &comparisons[k].without);
        let tried = channels.len() as f64;
        channels.iter().any(|&c| {
            let better = |left: &Vec<Vec<f64>>| {
                let pair = ResidualPair {
                    poorer: &full.validation,
                    richer: left,
                };
                let evidence = pair.encompassing(Known::default(), context.residual_rows());
                evidence.p_value * tried < significance && leaves_more(noise_level, pair, &[c])
            };
            without.with_another(c).as_ref().is_some_and(better)
        })
    })
}

/// The model that lacks a finding, over the fitted and the held-out rows.
struct Without<'a> {
    fit: &'a ModelFit,
    linearised: Linearised<'a>,
    recordings: [Vec<&'a Prepared>; 2],
}

/// A variable of another joint in one channel, `[split][column][row]`.
struct Another {
    channel: usize,
    columns: [Vec<Vec<f64>>; 2],
}

impl<'a> Without<'a> {
    fn new(context: &'a Context<'_>, fit: &'a ModelFit) -> Self {
        Self {
            fit,
            linearised: Linearised::new(context, fit),
            recordings: [Split::Train, Split::Validation].map(|split| context.recordings(split)),
        }
    }

    /// Held-out residuals with the variable of another joint in a channel that takes most.
    fn with_another(&self, channel: usize) -> Option<Vec<Vec<f64>>> {
        let model = &self.fit.model;
        let joint = model.channels()[channel].joint?;
        let covariates = self.recordings.each_ref().map(|recordings| {
            let series = ChannelSeries::of(model, &self.fit.values, &[], recordings);
            Covariates::of(model, joint, &series.predicted, recordings)
        });
        let variables = 0..covariates[0].variables.len();
        let others = variables.filter(|&k| covariates[0].variables[k].other.is_some());
        let tried = others.map(|k| {
            let of =
                |covariates: &Covariates| columns(&covariates.variables[k], &covariates.direction);
            let columns = covariates.each_ref().map(of);
            let gain = self.linearised.gain_of(channel, &columns[0]);
            (gain, Another { channel, columns })
        });
        let best = tried.max_by(|a, b| a.0.total_cmp(&b.0));
        best.and_then(|(_, another)| self.searched(&another))
    }

    /// Held-out residuals after a search of all parameters.
    fn searched(&self, another: &Another) -> Option<Vec<Vec<f64>>> {
        let (model, unknowns) = (&self.fit.model, self.fit.unknowns.positions());
        let mut values = self.fit.values.clone();
        let mut factors = DVector::zeros(another.columns[0].len());
        for _ in 0..STEPS {
            let series = ChannelSeries::of(model, &values, &unknowns, &self.recordings[0]);
            let residual = another.added(0, &factors, series.residuals());
            let step = self.step(&series, &residual, another, &values)?;
            for (&p, by) in unknowns.iter().zip(step.iter()) {
                let parameter = &model.parameters()[p];
                values[p] -= by;
                if parameter.linearity == Linearity::Nonlinear {
                    values[p] = within(values[p], [parameter.lower, parameter.upper]);
                }
            }
            factors -= step.rows(unknowns.len(), factors.len());
        }
        let held_out = ChannelSeries::of(model, &values, &[], &self.recordings[1]);
        Some(another.added(1, &factors, held_out.residuals()))
    }

    /// `min ‖e − [J, X] x‖²` over the fitted rows, each channel in units of what it leaves, and over what is known
    /// beforehand at parameter `values`.
    fn step(
        &self,
        series: &ChannelSeries,
        residual: &[Vec<f64>],
        another: &Another,
        values: &DVector<f64>,
    ) -> Option<DVector<f64>> {
        let unknowns = self.fit.unknowns.positions();
        let own = another.columns[0].len();
        let known = self.fit.prior.system(&unknowns, own, values);
        let mut factor = Triangular::new(known.ncols());
        factor.absorb(known.as_slice());
        let scale = deviations(residual);
        for (c, residual) in residual.iter().enumerate() {
            let over = |column: Option<&Vec<f64>>| -> Vec<f64> {
                let none = || vec![0.0; residual.len()];
                column.map_or_else(none, |x| x.iter().map(|x| x / scale[c]).collect())
            };
            let of_model = series.columns[c].iter().map(Option::as_ref);
            let all = of_model.chain(another.of(0, c)).chain([Some(residual)]);
            let all: Vec<Vec<f64>> = all.map(over).collect();
            factor.absorb_columns(&all.iter().map(Vec::as_slice).collect::<Vec<_>>());
        }
        let system = factor.system()?;
        system.matrix.solve_upper_triangular(&system.right)
    }
}

impl Another {
    /// Its columns in a channel.
    fn of(&self, split: usize, channel: usize) -> impl Iterator<Item = Option<&Vec<f64>>> {
        let columns = self.columns[split].iter();
        columns.map(move |x| (channel == self.channel).then_some(x))
    }

    fn added(
        &self,
        split: usize,
        factors: &DVector<f64>,
        mut residuals: Vec<Vec<f64>>,
    ) -> Vec<Vec<f64>> {
        for (column, by) in self.columns[split].iter().zip(factors.iter()) {
            let pairs = residuals[self.channel].iter_mut().zip(column);
            pairs.for_each(|(e, x)| *e += by * x);
        }
        residuals
    }
}

/// x, and where it acts by direction of motion x d.
fn columns(variable: &Covariate, direction: &[f64]) -> Vec<Vec<f64>> {
    let mut columns = vec![variable.values.clone()];
    if variable.by_direction {
        let pairs = variable.values.iter().zip(direction);
        columns.push(pairs.map(|(x, d)| x * d).collect());
    }
    columns
}
