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
use crate::diagnose::candidates::grid_search::{best_first, halved};
use crate::diagnose::candidates::motions::Motions;
use crate::diagnose::candidates::screening_reuse::Reusable;
use crate::diagnose::candidates::signal_path::SignalPath;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::fit::candidate::{Candidate, Naming, Point, Screening};
use crate::diagnose::fit::channel_series::ChannelSeries;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::linear_model::{ChannelColumn, LinearModel, inner};
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::fit::start::Start;
use crate::diagnose::fit::start_grid::Grid;
use crate::estimate::noise::counting_rows;
use crate::estimate::search_range::{MotionRange, lent_sizes};
use crate::linalg::lanes::inner_product::dot;
use crate::linalg::normal_equations::{INDEPENDENT, NormalSolution};
use crate::recording::split::Split;
use crate::stats::deviation::rms;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Score tests of hypotheses beside a fitted model, linearised along the fitted rows.
pub struct ScoreTests<'a> {
    fit: &'a ModelFit,
    motions: Motions<'a>,
    path: SignalPath,
    linear: LinearModel,
}

/// Dry friction whose transition is narrower than this leaves it as it is.
const MOSTLY_REACHED: f64 = 0.8;

/// A value that makes the squared residual so many times larger is far too large.
const HOPELESS: f64 = 10.0;

/// A model with a hypothesis more, and the recordings along which it is evaluated.
struct Enlarged<'a> {
    model: Model,
    /// Positions of the free parameters that it has beyond the fitted model.
    own: Vec<usize>,
    recordings: Vec<&'a Prepared>,
    /// What the fitted model predicts along them, `[channel][row]`.
    predicted: &'a [Vec<f64>],
}

/// Values from which a hypothesis is examined, and those of them that are not the fitted ones, by name.
#[derive(Clone)]
struct Base {
    values: DVector<f64>,
    changed: Start,
}

/// Rows that tell which hypotheses are worth a closer look: what takes 1 % of the squares of so many rows, the least that
/// matters, gains 25 where noise gives each parameter 1 (Wilks 1938).
const ENOUGH: usize = 2500;

/// Hypotheses that get a closer look, several times as many as are fitted.
const CLOSER: usize = 40;

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

    /// The best point of a hypothesis; `None` where it cannot be in the model or takes nothing.
    pub fn examine(&self, context: &Context<'_>, hypothesis: &Hypothesis) -> Option<Candidate> {
        let enlarged = self.enlarged(context, hypothesis)?;
        let Enlarged { model, own, .. } = &enlarged;
        let bases = self.bases(model, hypothesis);
        let motion = MotionRange::of(&context.recordings(Split::Train), hypothesis.joints[0]);
        let grid = Grid::new(model, own, hypothesis.effect, &motion);
        let gain = |point: Vec<f64>| {
            let from = |(b, base): (usize, &Base)| {
                let mut values = base.values.clone();
                own.iter().zip(&point).for_each(|(&p, x)| values[p] = *x);
                (self.gain(&enlarged, &values), b)
            };
            let all = bases.iter().enumerate().map(from);
            let best = all.max_by(|a, b| a.0.total_cmp(&b.0));
            let (gain, base) = best.unwrap_or((f64::NEG_INFINITY, 0));
            Point {
                gain,
                base,
                at: point,
            }
        };
        let hopeless = -HOPELESS * self.linear.residual.iter().map(|r| dot(r, r)).sum::<f64>();
        let rising = grid.is_rising().then_some(hopeless);
        let best_first = |points: Vec<Vec<f64>>| best_first(points, rising, &gain);
        let scanned = best_first(grid.scan());
        let scanned = scanned.first();
        let mut points = best_first(grid.all(scanned.map(|point| point.at.as_slice())));
        if grid.is_rising() {
            points = halved(points, &best_first);
        }
        let naming = Naming {
            own: own
                .iter()
                .map(|&p| model.parameters()[p].name.clone())
                .collect(),
            bases: bases.iter().map(|base| &base.changed).collect(),
            grid: &grid,
        };
        let mut candidate = naming.candidate(hypothesis, &points)?;
        candidate.gain = scanned.map_or(0.0, |point| point.gain).max(candidate.gain);
        Some(candidate)
    }

    /// The same candidate with what it gains at its start over these rows.
    fn confirmed(&self, context: &Context<'_>, candidate: Candidate) -> Option<Candidate> {
        let enlarged = self.enlarged(context, &candidate.hypothesis)?;
        let mut values = self.fit.values_of(&enlarged.model);
        for (name, value) in &candidate.start {
            values[enlarged.model.position(name)?] = *value;
        }
        let gain = self.gain(&enlarged, &values);
        Some(Candidate { gain, ..candidate })
    }

    /// The model with a hypothesis more; `None` where it cannot be in it.
    fn enlarged(&self, context: &Context<'_>, hypothesis: &Hypothesis) -> Option<Enlarged<'_>> {
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
    fn bases(&self, model: &Model, hypothesis: &Hypothesis) -> Vec<Base> {
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

    fn gain(&self, enlarged: &Enlarged<'_>, values: &DVector<f64>) -> f64 {
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
        let stays_possible = |k: usize, step: f64| {
            let parameter = &model.parameters()[own[k]];
            let value = values[own[k]] + step;
            parameter.linearity == Linearity::Nonlinear
                || (parameter.lower..=parameter.upper).contains(&value)
        };
        self.one_step(&change, &columns, &stays_possible)
    }

    /// The gain of one step from a residual that is changed, along further columns; those along which the step would
    /// leave what is possible stay out.
    fn one_step(
        &self,
        change: &ChannelColumn,
        columns: &[ChannelColumn],
        stays_possible: &dyn Fn(usize, f64) -> bool,
    ) -> f64 {
        let whitened: Vec<DVector<f64>> = columns.iter().map(|c| self.linear.project(c)).collect();
        let shift = self.linear.project(change);
        // r is orthogonal to J, so the changed residual loses only what J takes of the change.
        let before: f64 = -2.0 * self.linear.against_residual(change) - inner(change, change)
            + shift.norm_squared();
        let k = columns.len();
        let mut normal = DMatrix::zeros(k, k);
        let mut right = DVector::zeros(k);
        let mut kept = Vec::new();
        for i in 0..k {
            let norm = inner(&columns[i], &columns[i]);
            let left = norm - whitened[i].norm_squared();
            if norm > 0.0 && left > INDEPENDENT * norm {
                kept.push(i);
            }
            right[i] = self.linear.against_residual(&columns[i]) + inner(&columns[i], change)
                - whitened[i].dot(&shift);
            for j in 0..=i {
                normal[(i, j)] = inner(&columns[i], &columns[j]) - whitened[i].dot(&whitened[j]);
                normal[(j, i)] = normal[(i, j)];
            }
        }
        loop {
            let solution = NormalSolution::of(
                &normal.select_rows(&kept).select_columns(&kept),
                &right.select_rows(&kept),
            );
            let possible: Vec<usize> = kept
                .iter()
                .zip(solution.x.iter())
                .filter(|(k, step)| stays_possible(**k, -**step))
                .map(|(k, _)| *k)
                .collect();
            if possible.len() == kept.len() {
                return before + solution.gain;
            }
            kept = possible;
        }
    }
}

/// What hypotheses promise beside a model: by a glance at some rows, and a look of those in front at all.
pub fn screen(
    context: &Context<'_>,
    fit: &ModelFit,
    open: Vec<Hypothesis>,
) -> Result<Screening, DiagnoseError> {
    let by_gain =
        |candidates: &mut Vec<Candidate>| candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let is_going_on = || !context.control.is_interrupted();
    let train = context.recordings(Split::Train);
    let every = (counting_rows(&train) / ENOUGH).max(1);
    let rough = ScoreTests::of_every(every, context, fit);
    let earlier = Reusable::of(context, fit);
    let examined = open.par_iter().filter(|_| is_going_on());
    let examined = examined.filter_map(|hypothesis| match earlier.screening(hypothesis) {
        Some(screening) => rough.confirmed(context, screening.glance_at(hypothesis)?.clone()),
        None => rough.examine(context, hypothesis),
    });
    let mut glance: Vec<Candidate> = examined.filter(|candidate| candidate.gain > 0.0).collect();
    by_gain(&mut glance);
    let mut candidates = glance.clone();
    if every > 1 {
        let look = ScoreTests::new(context, fit);
        candidates.truncate(CLOSER);
        let closer = candidates.into_par_iter().filter(|_| is_going_on());
        candidates = closer
            .filter_map(|candidate| look.confirmed(context, candidate))
            .collect();
        by_gain(&mut candidates);
    }
    Ok(Screening {
        open,
        glance,
        candidates,
    })
}
