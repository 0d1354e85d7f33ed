//! What each hypothesis could take from the residual beyond what all other parameters can take.
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
use crate::chain::effect::Linearity;
use crate::chain::evaluate::Evaluator;
use crate::chain::model::Model;
use crate::diagnose::bench::Bench;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::grid::Grid;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::lead::{Lead, Naming, Point, Screening};
use crate::diagnose::passage::Chain;
use crate::diagnose::points::{best_first, halved};
use crate::diagnose::refit::{Refit, Start};
use crate::diagnose::reuse::Reusable;
use crate::diagnose::rows::{Series, rms};
use crate::estimate::reach::Motion;
use crate::linalg::triangular::Triangular;
use crate::recording::split::Split;
use nalgebra::{DMatrix, DVector, DVectorView};
use rayon::prelude::*;
use std::sync::OnceLock;

/// The model as it stands, linearised over the fitted recordings.
pub struct Linearised<'a> {
    refit: &'a Refit,
    recordings: Vec<Prepared>,
    /// The same with what the bodies do, which laws of drives leave as it is; made when first needed.
    known: OnceLock<Vec<Prepared>>,
    chain: Chain,
    scale: Vec<f64>,
    predicted: Vec<Vec<f64>>,
    /// Weighted: `[channel][column]`.
    columns: Vec<Vec<Option<Vec<f64>>>>,
    residual: Vec<Vec<f64>>,
    /// R⁻ᵀ of the factor of J.
    inverse: DMatrix<f64>,
}

/// A column of the weighted derivatives: the channels that it enters.
type Column = Vec<(usize, Vec<f64>)>;

/// Share of a column that the model as it stands must leave: less is rounding.
const INDEPENDENT: f64 = 1e-8;

/// Dry friction whose transition is narrower than this leaves it as it is.
const MOSTLY_REACHED: f64 = 0.8;

/// A value that makes the squared residual so many times larger is far too large.
const HOPELESS: f64 = 10.0;

/// A model with a hypothesis more, and the recordings along which it is evaluated.
struct Enlarged<'a> {
    model: Model,
    recordings: Vec<&'a Prepared>,
}

/// Rows that tell which hypotheses are worth a closer look: what takes 1 % of the squares of so many rows, the least that
/// matters, gains 25 where noise gives each parameter 1 (Wilks 1938).
const ENOUGH: usize = 2500;

/// Hypotheses that get a closer look, several times as many as are fitted.
const CLOSER: usize = 40;

impl<'a> Linearised<'a> {
    pub fn new(bench: &Bench<'_>, refit: &'a Refit) -> Self {
        Self::of_every(1, bench, refit)
    }

    fn of_every(every: usize, bench: &Bench<'_>, refit: &'a Refit) -> Self {
        let recordings = bench.recordings(Split::Train).into_iter();
        let recordings: Vec<Prepared> = recordings.map(|r| r.thinned(every)).collect();
        let scale = refit.deviations();
        let positions = refit.unknowns.positions();
        let of: Vec<&Prepared> = recordings.iter().collect();
        let series = Series::of(&refit.model, &refit.values, &positions, &of);
        let mut columns = series.columns;
        for (c, of_channel) in columns.iter_mut().enumerate() {
            for column in of_channel.iter_mut().flatten() {
                column.iter_mut().for_each(|x| *x /= scale[c]);
            }
        }
        let residual = weighted_difference(&series.predicted, &series.recorded, &scale);
        let known = refit.prior.rows().select_columns(&positions);
        let inverse = inverse_factor(&columns, &known);
        Self {
            refit,
            recordings,
            known: OnceLock::new(),
            chain: Chain::of(&refit.model),
            scale,
            predicted: series.predicted,
            columns,
            residual,
            inverse,
        }
    }

    /// The best point of a hypothesis; `None` where it cannot be in the model or takes nothing.
    pub fn examine(&self, bench: &Bench<'_>, hypothesis: &Hypothesis) -> Option<Lead> {
        let Enlarged { model, recordings } = self.enlarged(bench, hypothesis)?;
        let own = self.own_parameters(&model);
        let bases = self.bases(&model, hypothesis);
        let motion = Motion::of(&bench.recordings(Split::Train), hypothesis.joints[0]);
        let grid = Grid::new(&model, &own, (hypothesis.effect, &motion));
        let gain = |point: Vec<f64>| {
            let from = |(b, base): (usize, &DVector<f64>)| {
                let mut values = base.clone();
                own.iter().zip(&point).for_each(|(&p, x)| values[p] = *x);
                (self.gain(&model, (&values, &own), &recordings), b)
            };
            let all = bases.iter().map(|(base, _)| base).enumerate().map(from);
            let best = all.max_by(|a, b| a.0.total_cmp(&b.0));
            let (gain, base) = best.unwrap_or((f64::NEG_INFINITY, 0));
            Point {
                gain,
                base,
                at: point,
            }
        };
        let hopeless = -HOPELESS * self.residual.iter().map(|r| dot(r, r)).sum::<f64>();
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
            bases: bases.iter().map(|(_, start)| start).collect(),
            grid: &grid,
        };
        let mut lead = naming.lead(hypothesis, &points)?;
        lead.gain = scanned.map_or(0.0, |point| point.gain).max(lead.gain);
        Some(lead)
    }

    /// The same lead with what it gains at its start over these rows.
    fn confirmed(&self, bench: &Bench<'_>, lead: Lead) -> Option<Lead> {
        let Enlarged { model, recordings } = self.enlarged(bench, &lead.hypothesis)?;
        let own = self.own_parameters(&model);
        let mut values = self.transfer(&model);
        for (name, value) in &lead.start {
            values[model.find(name).ok()?] = *value;
        }
        let gain = self.gain(&model, (&values, &own), &recordings);
        Some(Lead { gain, ..lead })
    }

    /// The model with a hypothesis more; `None` where it cannot be in it.
    fn enlarged(&self, bench: &Bench<'_>, hypothesis: &Hypothesis) -> Option<Enlarged<'_>> {
        let mut all = self.refit.hypotheses.clone();
        all.push(hypothesis.clone());
        let (mut model, _) = bench.model(&all).ok()?;
        if hypothesis.joints.len() == 1 && self.chain.leaves_others(&self.refit.model, hypothesis) {
            model.predict_only(hypothesis.joints[0]);
        }
        let recordings = match self.chain.knows_bodies(&self.refit.model, hypothesis) {
            true => self.known().iter().collect(),
            false => self.recordings.iter().collect(),
        };
        Some(Enlarged { model, recordings })
    }

    /// What further columns of a channel would take.
    pub fn gain_of(&self, channel: usize, columns: &[Vec<f64>]) -> f64 {
        let weighted = |column: &Vec<f64>| -> Column {
            let over = column.iter().map(|x| x / self.scale[channel]);
            vec![(channel, over.collect())]
        };
        let columns: Vec<Column> = columns.iter().map(weighted).collect();
        self.one_step(&Column::new(), &columns, &|_, _| true)
    }

    fn known(&self) -> &[Prepared] {
        let with_bodies = |r: &Prepared| with_bodies((self.refit, self.chain), r);
        let make = || self.recordings.iter().map(with_bodies).collect();
        self.known.get_or_init(make)
    }

    /// Positions of the free parameters that a larger model has beyond the fitted one.
    fn own_parameters(&self, model: &Model) -> Vec<usize> {
        let is_own = |p: &usize| {
            let parameter = &model.parameters()[*p];
            parameter.is_free() && self.refit.model.find(&parameter.name).is_err()
        };
        (0..model.parameters().len()).filter(is_own).collect()
    }

    /// Values from which a hypothesis is examined: those of the fit, and where it takes a law's place and borrows its
    /// parameters, also those raised by what the fit leaves of the signal, as the poorer law may have found nothing,
    /// and those lowered to what the law came to at the speeds of the joint where its transition is wide.
    fn bases(&self, model: &Model, hypothesis: &Hypothesis) -> Vec<(DVector<f64>, Start)> {
        let fitted = self.transfer(model);
        let borrows = hypothesis.effect.needs.borrows;
        if borrows.is_empty() {
            return vec![(fitted, Start::new())];
        }
        let joint = &model.joints()[hypothesis.joints[0]].name;
        let reached = self.reached(hypothesis.joints[0]);
        let mut raised = (fitted.clone(), Start::new());
        let mut lowered = raised.clone();
        for (effect, parameter) in borrows {
            let name = format!("{joint}.{effect}.{parameter}");
            let (Ok(from), Ok(to)) = (self.refit.model.find(&name), model.find(&name)) else {
                continue;
            };
            let unknown = self
                .refit
                .unknowns
                .positions()
                .iter()
                .position(|&p| p == from);
            let columns = self.columns.iter().filter_map(|of| of[unknown?].as_ref());
            let largest = columns.map(|column| rms(column)).fold(0.0, f64::max);
            if largest > 0.0 {
                // Residuals are weighted to an RMS of one.
                raised.0[to] += 1.0 / largest;
                raised.1.push((name.clone(), raised.0[to]));
            }
            if reached < MOSTLY_REACHED {
                lowered.0[to] *= reached;
                lowered.1.push((name, lowered.0[to]));
            }
        }
        let mut bases = vec![(fitted, Start::new())];
        let others = [raised, lowered];
        bases.extend(others.into_iter().filter(|(_, start)| !start.is_empty()));
        bases
    }

    /// RMS of `v/(|v| + w)` of a joint: the share of its dry friction that it comes to.
    fn reached(&self, joint: usize) -> f64 {
        let width = self.refit.model.joints()[joint].width;
        let width = width.map_or(0.0, |index| self.refit.values[index]);
        let of = |r: &Prepared| {
            let speeds = r.segment().motors.dq[joint].iter();
            let share = |v: &f64| v / (v.abs() + width).max(f64::MIN_POSITIVE);
            speeds.map(share).collect::<Vec<f64>>()
        };
        rms(&self.recordings.iter().flat_map(of).collect::<Vec<f64>>())
    }

    /// The fitted values in a larger model.
    fn transfer(&self, model: &Model) -> DVector<f64> {
        let mut values = model.values();
        for (k, parameter) in model.parameters().iter().enumerate() {
            if let Ok(index) = self.refit.model.find(&parameter.name) {
                values[k] = self.refit.values[index];
            }
        }
        values
    }

    fn gain(
        &self,
        model: &Model,
        (values, own): (&DVector<f64>, &[usize]),
        recordings: &[&Prepared],
    ) -> f64 {
        let series = Series::of(model, values, own, recordings);
        let mut change: Column = Vec::new();
        let mut columns: Vec<Column> = vec![Vec::new(); own.len()];
        for (c, predicted) in series.predicted.iter().enumerate() {
            let pairs = predicted.iter().zip(&self.predicted[c]);
            let moved: Vec<f64> = pairs.map(|(a, b)| (a - b) / self.scale[c]).collect();
            if moved.iter().any(|x| *x != 0.0) {
                change.push((c, moved));
            }
            for (column, of_channel) in columns.iter_mut().zip(&series.columns[c]) {
                if let Some(column_series) = of_channel {
                    let scaled = column_series.iter().map(|x| x / self.scale[c]).collect();
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
        change: &Column,
        columns: &[Column],
        stays_possible: &dyn Fn(usize, f64) -> bool,
    ) -> f64 {
        let whitened: Vec<DVector<f64>> = columns.iter().map(|c| self.project(c)).collect();
        let shift = self.project(change);
        // r is orthogonal to J, so the changed residual loses only what J takes of the change.
        let before: f64 =
            -2.0 * self.against_residual(change) - inner(change, change) + shift.norm_squared();
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
            right[i] = self.against_residual(&columns[i]) + inner(&columns[i], change)
                - whitened[i].dot(&shift);
            for j in 0..=i {
                normal[(i, j)] = inner(&columns[i], &columns[j]) - whitened[i].dot(&whitened[j]);
                normal[(j, i)] = normal[(i, j)];
            }
        }
        loop {
            let (gain, step) = explained(
                &normal.select_rows(&kept).select_columns(&kept),
                &right.select_rows(&kept),
            );
            let possible: Vec<usize> = kept
                .iter()
                .zip(step.iter())
                .filter(|(k, step)| stays_possible(**k, -**step))
                .map(|(k, _)| *k)
                .collect();
            if possible.len() == kept.len() {
                return before + gain;
            }
            kept = possible;
        }
    }

    /// R⁻ᵀ Jᵀ c.
    fn project(&self, column: &Column) -> DVector<f64> {
        let count = self.inverse.nrows();
        let mut product = DVector::zeros(count);
        for (c, series) in column {
            for (k, own) in self.columns[*c].iter().enumerate() {
                if let Some(own) = own {
                    product[k] += dot(own, series);
                }
            }
        }
        self.inverse.tr_mul(&product)
    }

    fn against_residual(&self, column: &Column) -> f64 {
        let of = |(c, series): &(usize, Vec<f64>)| dot(&self.residual[*c], series);
        column.iter().map(of).sum()
    }
}

/// A recording with what the bodies of a fitted model do along it.
fn with_bodies((refit, chain): (&Refit, Chain), recording: &Prepared) -> Prepared {
    let rows = recording.experiment.rows();
    let mut evaluator = Evaluator::along(&refit.model, &refit.values, &[], rows);
    let bodies = match chain {
        Chain::Lagging => evaluator.settled_bodies(recording.whole()),
        Chain::Simple | Chain::Other => evaluator.known_bodies(recording.whole()),
    };
    recording.clone().with_bodies(bodies)
}

/// `bᵀ A⁻¹ b` and `A⁻¹ b` over the directions of A that are not rounding.
pub fn explained(normal: &DMatrix<f64>, right: &DVector<f64>) -> (f64, DVector<f64>) {
    if right.is_empty() {
        return (0.0, DVector::zeros(0));
    }
    let size = normal.diagonal().map(|d| 1.0 / d.sqrt());
    let scaled = DMatrix::from_fn(normal.nrows(), normal.ncols(), |i, j| {
        normal[(i, j)] * size[i] * size[j]
    });
    let eigen = scaled.symmetric_eigen();
    let rotated = eigen.eigenvectors.tr_mul(&right.component_mul(&size));
    let over = |x: f64, value: f64| if value > INDEPENDENT { x / value } else { 0.0 };
    let solved = rotated.zip_map(&eigen.eigenvalues, over);
    let step = (&eigen.eigenvectors * &solved).component_mul(&size);
    (rotated.dot(&solved), step)
}

/// R⁻¹ of the weighted derivatives and the rows of what is known beforehand.
fn inverse_factor(columns: &[Vec<Option<Vec<f64>>>], known: &DMatrix<f64>) -> DMatrix<f64> {
    let count = known.ncols();
    let mut factor = Triangular::new(count);
    factor.absorb(known.as_slice());
    for of_channel in columns {
        let rows = of_channel.iter().flatten().map(Vec::len).max().unwrap_or(0);
        let zero = vec![0.0; rows];
        let slices: Vec<&[f64]> = of_channel
            .iter()
            .map(|column| column.as_deref().unwrap_or(&zero))
            .collect();
        factor.absorb_columns(&slices);
    }
    factor
        .inverse()
        .unwrap_or_else(|| DMatrix::zeros(count, count))
}

fn weighted_difference(a: &[Vec<f64>], b: &[Vec<f64>], scale: &[f64]) -> Vec<Vec<f64>> {
    let of = |((a, b), scale): ((&Vec<f64>, &Vec<f64>), &f64)| {
        a.iter().zip(b).map(|(a, b)| (a - b) / scale).collect()
    };
    a.iter().zip(b).zip(scale).map(of).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let of = |x| DVectorView::from_slice(x, x.len());
    of(a).dot(&of(b))
}

fn inner(a: &Column, b: &Column) -> f64 {
    let of = |(c, x): &(usize, Vec<f64>)| {
        let other = b.iter().find(|(d, _)| d == c);
        other.map_or(0.0, |(_, y)| dot(x, y))
    };
    a.iter().map(of).sum()
}

/// What hypotheses promise beside a model: by a glance at some rows, and a look of those in front at all.
pub fn screen(
    bench: &Bench<'_>,
    refit: &Refit,
    open: Vec<Hypothesis>,
) -> Result<Screening, DiagnoseError> {
    let by_gain = |leads: &mut Vec<Lead>| leads.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let is_going_on = || !bench.control.is_interrupted();
    let train = bench.recordings(Split::Train);
    let rows: usize = train.iter().map(|r| r.counting().count()).sum();
    let every = (rows / ENOUGH).max(1);
    let rough = Linearised::of_every(every, bench, refit);
    let earlier = Reusable::of(bench, refit);
    let examined = open.par_iter().filter(|_| is_going_on());
    let examined = examined.filter_map(|hypothesis| match earlier.stands(hypothesis) {
        true => rough.confirmed(bench, earlier.lead(hypothesis)?),
        false => rough.examine(bench, hypothesis),
    });
    let mut glance: Vec<Lead> = examined.filter(|lead| lead.gain > 0.0).collect();
    by_gain(&mut glance);
    let mut leads = glance.clone();
    if every > 1 {
        let look = Linearised::new(bench, refit);
        leads.truncate(CLOSER);
        let closer = leads.into_par_iter().filter(|_| is_going_on());
        leads = closer
            .filter_map(|lead| look.confirmed(bench, lead))
            .collect();
        by_gain(&mut leads);
    }
    Ok(Screening {
        open,
        glance,
        leads,
    })
}
