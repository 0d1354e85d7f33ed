//! One iteration: the step of the quadratic programme, its length, and what the Hessian learns from it.

use nalgebra::{DMatrix, DVector};

use crate::problem::form::Form;
use crate::problem::linear_rows::LinearRows;
use crate::problem::solution::{Control, Stop, Trace, TraceRow};
use crate::problem::view::Nlp;
use crate::problem::{Linearization, Values};
use crate::solve::error::{SolveError, SolveErrorKind};
use crate::solve::sqp::hessian::Hessian;
use crate::solve::sqp::quadratic::{Quadratic, Row, Step};
use crate::solve::sqp::settings::Settings;
use crate::solve::sqp::working_set::{self, Side, Smooth};

/// Share of the promised decrease of the penalty that a step has to give (Armijo).
const SUFFICIENT: f64 = 1e-4;

/// Factor by which a step is shortened, and the most times.
const SHORTENING: f64 = 0.5;
const MOST_TRIALS: usize = 20;

/// Times that the quadratic programme is solved in one iteration, violated rows added: what is left of
/// violations is drawn back.
const MOST_ROUNDS: usize = 3;

/// Rows of the problem farther from zero than this enter only when a step violates them: the rows of a
/// problem are stated in shares of what they limit.
const NEAR: f64 = 0.15;

/// First weight of infeasibility against cost, its growth and its limit.
const FIRST_PENALTY: f64 = 10.0;
const PENALTY_GROWTH: f64 = 10.0;
const LARGEST_PENALTY: f64 = 1e8;

/// Where the method has come.
pub(super) struct Iteration<'a> {
    view: Nlp<'a>,
    settings: &'a Settings,
    none: LinearRows,
    scale: DVector<f64>,
    signed: Vec<Smooth>,
    x: DVector<f64>,
    model: Linearization,
    hessian: Hessian,
    /// Rows that pressed on the last step.
    pressed: Vec<Side>,
    penalty: f64,
    count: usize,
    evaluations: usize,
    merits: Vec<f64>,
    trace: Trace,
}

/// The end of a run.
pub(super) struct End {
    pub x: DVector<f64>,
    pub cost: f64,
    pub infeasibility: f64,
    pub iterations: usize,
    pub evaluations: usize,
    pub trace: Trace,
}

impl<'a> Iteration<'a> {
    pub(super) fn at(
        view: Nlp<'a>,
        x: DVector<f64>,
        settings: &'a Settings,
    ) -> Result<Self, SolveError> {
        let problem = view.problem();
        let model = problem.linearize(&x)?;
        if !is_finite(&model) {
            return Err(SolveError::whole(SolveErrorKind::ModelNotFinite));
        }
        let form = problem.form();
        let scale =
            DVector::from_iterator(form.variables.len(), form.variables.iter().map(|v| v.scale));
        Ok(Self {
            hessian: Hessian::first(&model.gradient.component_mul(&scale)),
            none: LinearRows::default(),
            signed: working_set::signed_rows(form),
            view,
            settings,
            scale,
            x,
            model,
            pressed: Vec::new(),
            penalty: FIRST_PENALTY,
            count: 0,
            evaluations: 1,
            merits: Vec::new(),
            trace: Trace::default(),
        })
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    fn rows(&self) -> &LinearRows {
        self.view.rows().unwrap_or(&self.none)
    }

    fn form(&self) -> &Form {
        self.view.problem().form()
    }

    fn infeasibility(&self, g: &DVector<f64>) -> f64 {
        working_set::infeasibility(&self.signed, g)
    }

    pub(super) fn finish(self) -> End {
        End {
            infeasibility: working_set::infeasibility(&self.signed, &self.model.constraints),
            cost: self.model.cost,
            x: self.x,
            iterations: self.count,
            evaluations: self.evaluations,
            trace: self.trace,
        }
    }

    /// One iteration; the reason to stop, if there is one.
    pub(super) fn advance(&mut self, control: &Control) -> Result<Option<Stop>, SolveError> {
        self.count += 1;
        let Some((step, smooth)) = self.step() else {
            return Ok(Some(Stop::Stalled));
        };
        let d = step.d.component_mul(&self.scale);
        let before = self.infeasibility(&self.model.constraints);
        let curvature = step.d.dot(&(self.hessian.matrix() * &step.d));
        let promised =
            -(self.model.gradient.dot(&d)) - 0.5 * curvature + self.penalty * (before - step.slack);
        let feasible = before <= self.settings.feasibility_tolerance * self.signed.len() as f64;
        if promised <= self.settings.cost_tolerance * (1.0 + self.model.cost.abs()) {
            self.record(control, 0.0, promised);
            return Ok(Some(if feasible {
                Stop::CostTolerance
            } else {
                Stop::Infeasible
            }));
        }
        let decrease = -(self.model.gradient.dot(&d)) + self.penalty * (before - step.slack);
        let Some(x) = self.search(&d, decrease) else {
            // The model misleads: forget it once, and stop if that does not help.
            let scaled = self.model.gradient.component_mul(&self.scale);
            let fresh = self.merits.is_empty();
            self.hessian.reset(&scaled);
            self.merits.clear();
            return Ok(fresh.then_some(Stop::Stalled));
        };
        let largest = (&x - &self.x).component_div(&self.scale).amax();
        self.accept(x, &step, &smooth)?;
        self.record(control, largest, promised);
        Ok(self.stalled().then_some(Stop::Stalled))
    }

    /// The step of the quadratic programme, with the rows of the problem that entered it.
    fn step(&mut self) -> Option<(Step, Vec<usize>)> {
        let at = self.rows().values(&self.x);
        let mut sides = working_set::near(self.rows(), &at);
        sides.extend(self.pressed.iter().copied());
        let none = DVector::zeros(self.x.len());
        let mut smooth = working_set::smooth_below(&self.signed, &self.model, &none, NEAR);
        let mut solved: Option<Step> = None;
        for _ in 0..MOST_ROUNDS {
            sides.sort_unstable();
            sides.dedup();
            let Some(step) = self.quadratic(&at, &sides, &smooth).solve() else {
                break;
            };
            let d = step.d.component_mul(&self.scale);
            let along = self.rows().values(&d);
            let moved: Vec<f64> = at.iter().zip(&along).map(|(a, b)| a + b).collect();
            let mut new = working_set::violated(self.rows(), &moved);
            new.retain(|side| sides.binary_search(side).is_err());
            let tolerance = -self.settings.feasibility_tolerance;
            let mut more = working_set::smooth_below(&self.signed, &self.model, &d, tolerance);
            more.retain(|k| !smooth.contains(k));
            self.keep_pressed(&sides, &step);
            let raise = self.weigh_infeasibility(&step);
            solved = Some(step);
            if new.is_empty() && more.is_empty() && !raise {
                break;
            }
            sides.extend(new);
            smooth.extend(more);
        }
        let mut step = solved?;
        // Rows that entered after the last solve have no multiplier.
        step.multipliers.resize(smooth.len(), 0.0);
        Some((step, smooth))
    }

    fn keep_pressed(&mut self, sides: &[Side], step: &Step) {
        let largest = step.pressed.iter().fold(0.0_f64, |m, z| m.max(*z));
        self.pressed = sides
            .iter()
            .zip(&step.pressed)
            .filter(|(_, z)| **z > 1e-6 * largest)
            .map(|(side, _)| *side)
            .collect();
    }

    /// Raises the penalty where the programme prefers infeasibility; whether it did.
    fn weigh_infeasibility(&mut self, step: &Step) -> bool {
        let before = self.infeasibility(&self.model.constraints);
        let tolerance = self.settings.feasibility_tolerance * self.signed.len() as f64;
        let raise = step.slack > tolerance.max(0.1 * before) && self.penalty < LARGEST_PENALTY;
        if raise {
            self.penalty *= PENALTY_GROWTH;
        }
        raise
    }

    /// The programme in variables divided by their scales.
    fn quadratic(&self, at: &[f64], sides: &[Side], smooth: &[usize]) -> Quadratic<'_> {
        let rows = self.rows();
        let scaled = |row: usize, factor: f64| -> Vec<f64> {
            let first = rows.rows[row].first;
            let numbers = rows.numbers(row).iter().enumerate();
            numbers
                .map(|(k, a)| factor * a * self.scale[first + k])
                .collect()
        };
        let equation = |row: usize| Row {
            first: rows.rows[row].first,
            numbers: scaled(row, 1.0),
            right: rows.rows[row].upper - at[row],
        };
        let inequality = |side: &Side| {
            let row = &rows.rows[side.row];
            let (sign, room) = if side.upper {
                (1.0, row.upper - at[side.row])
            } else {
                (-1.0, at[side.row] - row.lower)
            };
            Row {
                first: row.first,
                numbers: scaled(side.row, sign / row.scale()),
                // An iterate keeps the rows up to rounding: no step is asked to correct that.
                right: room.max(0.0) / row.scale(),
            }
        };
        let elastic = |k: &usize| {
            let Smooth { row, sign } = self.signed[*k];
            let slopes = self.model.jacobian.row(row);
            Row {
                first: 0,
                numbers: (0..self.x.len())
                    .map(|j| -sign * slopes[j] * self.scale[j])
                    .collect(),
                right: sign * self.model.constraints[row],
            }
        };
        let equations = (0..rows.rows.len()).filter(|&row| rows.rows[row].is_equation());
        let mut inequalities: Vec<Row> = sides.iter().map(inequality).collect();
        inequalities.extend(self.bound_rows());
        Quadratic {
            hessian: self.hessian.matrix(),
            cost: self.model.gradient.component_mul(&self.scale),
            equations: equations.map(equation).collect(),
            inequalities,
            elastic: smooth.iter().map(elastic).collect(),
            penalty: self.penalty,
        }
    }

    /// Bounds of the variables as rows of the scaled step.
    fn bound_rows(&self) -> impl Iterator<Item = Row> + '_ {
        let variables = self.form().variables.iter().enumerate();
        variables.flat_map(|(j, v)| {
            let sides = [(1.0, v.upper - self.x[j]), (-1.0, self.x[j] - v.lower)];
            let finite = sides.into_iter().filter(|(_, room)| room.is_finite());
            finite.map(move |(sign, room)| Row {
                first: j,
                numbers: vec![sign],
                right: room.max(0.0) / v.scale,
            })
        })
    }

    /// The point along the step that lowers the penalty enough.
    fn search(&mut self, d: &DVector<f64>, decrease: f64) -> Option<DVector<f64>> {
        let merit = |this: &Self, values: &Values| {
            values.cost + this.penalty * this.infeasibility(&values.constraints)
        };
        let here = self.model.cost + self.penalty * self.infeasibility(&self.model.constraints);
        let mut length = 1.0;
        for _ in 0..MOST_TRIALS {
            let trial = self.rows().admissible(&self.x, &(d * length));
            self.evaluations += 1;
            if let Ok(values) = self.view.problem().values(&trial) {
                let lowered = here - merit(self, &values);
                if lowered.is_finite() && lowered >= SUFFICIENT * length * decrease.max(0.0) {
                    self.merits.push(here - lowered);
                    return Some(trial);
                }
            }
            length *= SHORTENING;
        }
        None
    }

    /// Moves to the new point and updates B with the change of the Lagrangian's gradient.
    fn accept(&mut self, x: DVector<f64>, step: &Step, smooth: &[usize]) -> Result<(), SolveError> {
        let moved = &x - &self.x;
        self.evaluations += 1;
        let model = self.view.problem().linearize(&x)?;
        if !is_finite(&model) {
            return Err(SolveError::whole(SolveErrorKind::ModelNotFinite));
        }
        let pull = |jacobian: &DMatrix<f64>| {
            let mut sum = DVector::zeros(self.x.len());
            for (k, multiplier) in smooth.iter().zip(&step.multipliers) {
                let Smooth { row, sign } = self.signed[*k];
                if *multiplier > 0.0 {
                    sum += jacobian.row(row).transpose() * (sign * multiplier);
                }
            }
            sum
        };
        let change = (&model.gradient - &self.model.gradient)
            - (pull(&model.jacobian) - pull(&self.model.jacobian));
        self.hessian.update(
            &moved.component_div(&self.scale),
            &change.component_mul(&self.scale),
        );
        self.x = x;
        self.model = model;
        Ok(())
    }

    fn stalled(&self) -> bool {
        let patience = self.settings.patience;
        let Some(first) = self.merits.len().checked_sub(patience + 1) else {
            return false;
        };
        let last = self.merits[self.merits.len() - 1];
        let gained = self.merits[first] - last;
        gained <= self.settings.progress_tolerance * (1.0 + last.abs())
    }

    fn record(&mut self, control: &Control, step: f64, promised: f64) {
        let row = TraceRow {
            iteration: self.count,
            cost: self.model.cost,
            step,
            stationarity: promised,
            regularization: self.penalty,
        };
        control.report(&row);
        self.trace.rows.push(row);
    }
}

fn is_finite(model: &Linearization) -> bool {
    model.cost.is_finite()
        && model.gradient.iter().all(|v| v.is_finite())
        && model.constraints.iter().all(|v| v.is_finite())
}
