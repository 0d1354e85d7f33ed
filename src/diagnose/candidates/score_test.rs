//! Score test of each candidate effect, the fitted parameters projected out.
//!
//! ```text
//! gain = ‖r‖² − min_{δ, γ} ‖r_g + J δ + C γ‖²
//! ```
//!
//! with the weighted residual r and derivatives J of the model as it stands (r is orthogonal to J), the
//! residual r_g of the model with the hypothesis at a point g of its nonlinear parameters, and the
//! derivatives C with respect to its own parameters there. By the theorem of Frisch, Waugh and Lovell this
//! is the gain of one Gauss-Newton step of all parameters, for the price of projecting a few columns.

use crate::chain::dataset::Prepared;
use crate::chain::effect::{Law, Linearity};
use crate::chain::model::Model;
use crate::diagnose::candidates::motions::Motions;
use crate::diagnose::candidates::signal_path::SignalPath;
use crate::diagnose::fit::channel_series::ChannelSeries;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::linear_model::{ChannelColumn, LinearModel, inner};
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::fit::start::Start;
use crate::estimate::search_range::lent_sizes;
use crate::linalg::normal_equations::{INDEPENDENT, NormalSolution};
use crate::recording::split::Split;
use crate::stats::deviation::rms;
use nalgebra::{DMatrix, DVector};

/// Score tests of hypotheses beside a fitted model, linearised along the fitted rows.
pub struct ScoreTests<'a> {
    pub(super) fit: &'a ModelFit,
    motions: Motions<'a>,
    path: SignalPath,
    linear: LinearModel,
}

/// Dry friction whose transition is narrower than this leaves it as it is.
const MOSTLY_REACHED: f64 = 0.8;

/// A model with a hypothesis more, and the recordings along which it is evaluated.
pub(super) struct Enlarged<'a> {
    pub model: Model,
    /// Positions of the free parameters that it has beyond the fitted model.
    pub own: Vec<usize>,
    recordings: Vec<&'a Prepared>,
    /// What the fitted model predicts along them, `[channel][row]`.
    predicted: &'a [Vec<f64>],
}

/// Values from which a hypothesis is examined, and those of them that are not the fitted ones, by name.
#[derive(Clone)]
pub(super) struct Base {
    values: DVector<f64>,
    pub changed: Start,
}

impl Base {
    /// The values with those of some parameters.
    pub fn with(&self, own: &[usize], at: &[f64]) -> DVector<f64> {
        let mut values = self.values.clone();
        own.iter().zip(at).for_each(|(&p, x)| values[p] = *x);
        values
    }
}

/// A hypothesis at values of its parameters, linearised, the fitted parameters projected out.
pub(super) struct Linearised {
    /// Weighted sum of squares that it takes away with these values.
    pub reached: f64,
    normal: DMatrix<f64>,
    right: DVector<f64>,
    /// Own parameters, by their numbers, that do what no fitted one does.
    independent: Vec<usize>,
}

/// One step of own parameters and of all fitted ones.
pub(super) struct Step {
    /// Weighted sum of squares that it takes away.
    pub gain: f64,
    /// Of every own parameter.
    pub own: Vec<f64>,
}

impl<'a> ScoreTests<'a> {
    /// Derivatives of the signal by every parameter over all rows that were fitted.
    pub fn new(context: &Context<'_>, fit: &'a ModelFit) -> Self {
        Self::of_every(1, context, fit)
    }

    /// Over every n-th row.
    pub fn of_every(every: usize, context: &Context<'_>, fit: &'a ModelFit) -> Self {
        let recordings = context.recordings(Split::Train).into_iter();
        let recordings: Vec<Prepared> = recordings.map(|r| r.thinned(every)).collect();
        let of: Vec<&Prepared> = recordings.iter().collect();
        let linear = LinearModel::of(fit, every, &of);
        let path = SignalPath::of(&fit.model);
        Self {
            fit,
            motions: Motions::new(fit, path, recordings),
            path,
            linear,
        }
    }

    /// The model with a hypothesis more; `None` where it cannot be in it.
    pub(super) fn enlarged(
        &self,
        context: &Context<'_>,
        hypothesis: &Hypothesis,
    ) -> Option<Enlarged<'_>> {
        let mut all = self.fit.hypotheses.clone();
        all.push(hypothesis.clone());
        let mut model = context.model(&all).ok()?.model;
        let leaves_others = self.path.leaves_others(&self.fit.model, hypothesis);
        let alone = match hypothesis.joints[..] {
            [joint] if leaves_others => Some(joint),
            _ => None,
        };
        if let Some(joint) = alone {
            model.predict_only(joint);
        }
        let knows_bodies = |path: SignalPath| path.knows_bodies(&self.fit.model, hypothesis);
        let own = self.own_parameters(&model);
        let mut predicted = &self.linear.predicted;
        let is_delay = matches!(hypothesis.effect.law, Law::Delay);
        let all_late = self.motions.all_late().filter(|_| !is_delay);
        let recordings = match (self.path, alone, all_late) {
            (SignalPath::Late, Some(joint), _) => {
                model.predict_on_time();
                self.motions.late(joint)
            }
            (SignalPath::Late, None, Some(late)) => {
                model.predict_on_time();
                predicted = &late.predicted;
                match knows_bodies(SignalPath::Simple) {
                    true => &late.known,
                    false => &late.recordings,
                }
            }
            _ if knows_bodies(self.path) => self.motions.known(),
            _ => self.motions.recorded(),
        };
        Some(Enlarged {
            own,
            model,
            recordings: recordings.iter().collect(),
            predicted,
        })
    }

    /// The rows along which it is linearised.
    pub fn recordings(&self) -> &[Prepared] {
        self.motions.recorded()
    }

    /// Residual and derivatives along them.
    pub fn linear(&self) -> &LinearModel {
        &self.linear
    }

    /// Positions of the free parameters that a larger model has beyond the fitted one.
    fn own_parameters(&self, model: &Model) -> Vec<usize> {
        let is_own = |p: &usize| {
            let parameter = &model.parameters()[*p];
            parameter.is_free() && self.fit.model.position(&parameter.name).is_none()
        };
        (0..model.parameters().len()).filter(is_own).collect()
    }

    /// Values from which a hypothesis is examined: those of the fit, and where it takes a law's place and borrows its
    /// parameters, also those raised by what the fit leaves of the signal, and to shares of the torque of the joint, as the
    /// poorer law may have found nothing, and those lowered to what the law came to at the speeds of the joint where its
    /// transition is wide.
    pub(super) fn bases(&self, model: &Model, hypothesis: &Hypothesis) -> Vec<Base> {
        let fitted = Base {
            values: self.fit.values_of(model),
            changed: Start::new(),
        };
        let borrows = hypothesis.effect.needs.borrows;
        if borrows.is_empty() {
            return vec![fitted];
        }
        let joint = &model.joints()[hypothesis.joints[0]].name;
        let reached = self.reached(hypothesis.joints[0]);
        let mut raised = fitted.clone();
        let mut lowered = raised.clone();
        let mut larger = Vec::new();
        for (effect, parameter) in borrows {
            let name = format!("{joint}.{effect}.{parameter}");
            let (Some(from), Some(to)) = (self.fit.model.position(&name), model.position(&name))
            else {
                continue;
            };
            let unknown = self
                .fit
                .unknowns
                .positions()
                .iter()
                .position(|&p| p == from);
            let columns = self
                .linear
                .columns
                .iter()
                .filter_map(|of| of[unknown?].as_ref());
            let largest = columns.map(|column| rms(column)).fold(0.0, f64::max);
            if largest > 0.0 {
                // Residuals are weighted to an RMS of one.
                raised.values[to] += 1.0 / largest;
                raised.changed.push((name.clone(), raised.values[to]));
            }
            if hypothesis.effect.needs.replaces == Some(effect) {
                let recorded: Vec<&Prepared> = self.recordings().iter().collect();
                let sizes = lent_sizes(model, &recorded, hypothesis.joints[0]);
                let above = sizes.into_iter().filter(|size| *size > raised.values[to]);
                larger.extend(above.map(|size| {
                    let mut base = fitted.clone();
                    base.values[to] = size;
                    base.changed.push((name.clone(), size));
                    base
                }));
            }
            if reached < MOSTLY_REACHED {
                lowered.values[to] *= reached;
                lowered.changed.push((name, lowered.values[to]));
            }
        }
        let mut bases = vec![fitted];
        let others = [raised, lowered].into_iter();
        bases.extend(others.filter(|base| !base.changed.is_empty()));
        bases.extend(larger);
        bases
    }

    /// RMS of `v/(|v| + w)` of a joint: the share of its dry friction that it comes to.
    fn reached(&self, joint: usize) -> f64 {
        let of = |r: &Prepared| {
            let speeds = r.segment().motors.dq[joint].iter();
            speeds.map(self.fit.direction(joint)).collect::<Vec<f64>>()
        };
        rms(&self.recordings().iter().flat_map(of).collect::<Vec<f64>>())
    }

    /// A hypothesis' model at values of its parameters, beside the fitted one.
    pub(super) fn linearised(&self, enlarged: &Enlarged<'_>, values: &DVector<f64>) -> Linearised {
        let Enlarged {
            model,
            own,
            recordings,
            predicted: before,
        } = enlarged;
        let series = ChannelSeries::of(model, values, own, recordings);
        let mut change: ChannelColumn = Vec::new();
        let mut columns: Vec<ChannelColumn> = vec![Vec::new(); own.len()];
        for (c, predicted) in series.predicted.iter().enumerate() {
            let pairs = predicted.iter().zip(&before[c]);
            let moved: Vec<f64> = pairs.map(|(a, b)| (a - b) / self.linear.scale[c]).collect();
            if moved.iter().any(|x| *x != 0.0) {
                change.push((c, moved));
            }
            for (column, of_channel) in columns.iter_mut().zip(&series.columns[c]) {
                if let Some(column_series) = of_channel {
                    let scaled = column_series
                        .iter()
                        .map(|x| x / self.linear.scale[c])
                        .collect();
                    column.push((c, scaled));
                }
            }
        }
        self.projected(&change, &columns)
    }

    /// Normal equations of a changed residual along further columns, the fitted parameters projected out.
    fn projected(&self, change: &ChannelColumn, columns: &[ChannelColumn]) -> Linearised {
        let whitened: Vec<DVector<f64>> = columns.iter().map(|c| self.linear.project(c)).collect();
        let shift = self.linear.project(change);
        // r is orthogonal to J, so the changed residual loses only what J takes of the change.
        let reached: f64 = -2.0 * self.linear.against_residual(change) - inner(change, change)
            + shift.norm_squared();
        let k = columns.len();
        let mut normal = DMatrix::zeros(k, k);
        let mut right = DVector::zeros(k);
        let mut independent = Vec::new();
        for i in 0..k {
            let norm = inner(&columns[i], &columns[i]);
            let left = norm - whitened[i].norm_squared();
            if norm > 0.0 && left > INDEPENDENT * norm {
                independent.push(i);
            }
            right[i] = self.linear.against_residual(&columns[i]) + inner(&columns[i], change)
                - whitened[i].dot(&shift);
            for j in 0..=i {
                normal[(i, j)] = inner(&columns[i], &columns[j]) - whitened[i].dot(&whitened[j]);
                normal[(j, i)] = normal[(i, j)];
            }
        }
        Linearised {
            reached,
            normal,
            right,
            independent,
        }
    }
}

impl Enlarged<'_> {
    /// Whether an own parameter, by its number, is linear.
    pub fn is_linear(&self, own: usize) -> bool {
        self.model.parameters()[self.own[own]].linearity == Linearity::Linear
    }

    /// One step from values of those own parameters that move and of all fitted ones; those whose size would leave what is possible
    /// stay where they are.
    pub fn step(
        &self,
        values: &DVector<f64>,
        here: &Linearised,
        moves: &dyn Fn(usize) -> bool,
    ) -> Step {
        let stays_possible = |k: usize, step: f64| {
            let parameter = &self.model.parameters()[self.own[k]];
            let value = values[self.own[k]] + step;
            !self.is_linear(k) || (parameter.lower..=parameter.upper).contains(&value)
        };
        let independent = here.independent.iter().copied();
        let mut kept: Vec<usize> = independent.filter(|&k| moves(k)).collect();
        loop {
            let solution = NormalSolution::of(
                &here.normal.select_rows(&kept).select_columns(&kept),
                &here.right.select_rows(&kept),
            );
            let possible: Vec<usize> = kept
                .iter()
                .zip(solution.x.iter())
                .filter(|(k, step)| stays_possible(**k, -**step))
                .map(|(k, _)| *k)
                .collect();
            if possible.len() == kept.len() {
                let mut own = vec![0.0; self.own.len()];
                let steps = kept.iter().zip(solution.x.iter());
                steps.for_each(|(&k, step)| own[k] = -step);
                return Step {
                    gain: here.reached + solution.gain,
                    own,
                };
            }
            kept = possible;
        }
    }
}
