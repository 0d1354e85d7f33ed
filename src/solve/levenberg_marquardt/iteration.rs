//! One iteration: a damped step, its trial on the nonlinear cost, and the update of the damping.

use argmin::core::{Error, IterState, KV, Problem, Solver, TerminationReason, TerminationStatus};
use nalgebra::DVector;

use crate::problem::bounds;
use crate::problem::form::Form;
use crate::problem::solution::{Control, Stop, Trace, TraceRow};
use crate::problem::view::LeastSquares;
use crate::solve::levenberg_marquardt::model::Model;
use crate::solve::levenberg_marquardt::settings::Settings;

/// The state that argmin carries: the point and its cost.
pub(super) type Iterate = IterState<DVector<f64>, (), (), (), (), f64>;

/// Damping never falls below this: its square root times D is lost against R in rounding.
const LEAST_DAMPING: f64 = 1e-30;

/// Beyond this damping a step changes nothing in double precision.
const LARGEST_DAMPING: f64 = 1e24;

/// Where no step lowers the cost although the model promises up to this share of it, rounding in the
/// residual hides the rest: the point is within sqrt(2e-8 rows) standard deviations of the optimum.
const HIDDEN_BY_ROUNDING: f64 = 1e-8;

/// Least factor by which an accepted step lowers the damping (Nielsen 1999).
const LARGEST_RELIEF: f64 = 1.0 / 3.0;

/// The method and its memory.
pub(super) struct Iteration<'a> {
    settings: &'a Settings,
    control: &'a Control<'a>,
    model: Model,
    /// Largest column norms seen, D.
    norms: Option<DVector<f64>>,
    lambda: f64,
    /// Factor by which the next rejection raises lambda.
    growth: f64,
    stop: Option<Stop>,
    trace: Trace,
}

impl<'a> Iteration<'a> {
    pub(super) fn new(settings: &'a Settings, control: &'a Control<'a>, model: Model) -> Self {
        Self {
            lambda: settings.initial_damping,
            settings,
            control,
            model,
            norms: None,
            growth: 2.0,
            stop: None,
            trace: Trace::default(),
        }
    }

    pub(super) fn cost(&self) -> f64 {
        self.model.cost
    }

    pub(super) fn stop(&self) -> Option<Stop> {
        self.stop
    }

    pub(super) fn into_trace(self) -> Trace {
        self.trace
    }

    /// The test of convergence that holds at the current point, if one does.
    fn convergence(&self, form: &Form, x: &DVector<f64>) -> Option<Stop> {
        let settings = self.settings;
        let model = &self.model;
        if model.is_stationary(form, x, settings.gradient_tolerance) {
            Some(Stop::GradientTolerance)
        } else if model.promised <= settings.cost_tolerance * model.cost {
            Some(Stop::CostTolerance)
        } else if model.relative_step(form, x) <= settings.step_tolerance {
            Some(Stop::StepTolerance)
        } else {
            None
        }
    }

    /// The model at the trial point if its nonlinear cost is lower.
    fn try_point(
        &mut self,
        problem: &mut Problem<LeastSquares>,
        trial: &DVector<f64>,
    ) -> Result<Option<Model>, Error> {
        let values = problem.problem("values", |view| Ok(view.problem().values(trial)))?;
        // A cost that is not a number fails the comparison, like a point outside the domain.
        if !values.is_ok_and(|v| v.cost < self.model.cost) {
            return Ok(None);
        }
        let model = problem.problem("linearizations", |view| {
            Ok(Model::at(view.problem(), trial))
        })?;
        Ok(model.ok().flatten())
    }

    /// Nielsen's rule: the better the model predicted, the less damping.
    fn accept(&mut self, model: Model, predicted: f64) {
        let gain = (self.model.cost - model.cost) / predicted;
        let relief = 1.0 - (2.0 * gain.clamp(0.0, 1.0) - 1.0).powi(3);
        self.lambda = (self.lambda * relief.max(LARGEST_RELIEF)).max(LEAST_DAMPING);
        self.growth = 2.0;
        self.model = model;
    }

    fn reject(&mut self) {
        self.lambda *= self.growth;
        self.growth *= 2.0;
        if self.lambda > LARGEST_DAMPING {
            let hidden = self.model.promised <= HIDDEN_BY_ROUNDING * self.model.cost;
            self.stop = Some(if hidden {
                Stop::CostTolerance
            } else {
                Stop::Stalled
            });
        }
    }

    fn record(&mut self, iteration: usize, step: f64) {
        let cost = self.model.cost;
        let row = TraceRow {
            iteration,
            cost,
            step,
            stationarity: if cost > 0.0 {
                self.model.promised / cost
            } else {
                0.0
            },
            regularization: self.lambda,
        };
        self.control.report(&row);
        self.trace.rows.push(row);
    }
}

/// max |d_j| / scale_j.
fn scaled_length(form: &Form, step: &DVector<f64>) -> f64 {
    let ratios = form
        .variables
        .iter()
        .zip(step.iter())
        .map(|(v, d)| d.abs() / v.scale);
    ratios.fold(0.0, f64::max)
}

impl<'a> Solver<LeastSquares<'a>, Iterate> for Iteration<'a> {
    fn name(&self) -> &str {
        "Levenberg-Marquardt"
    }

    fn init(
        &mut self,
        problem: &mut Problem<LeastSquares<'a>>,
        mut state: Iterate,
    ) -> Result<(Iterate, Option<KV>), Error> {
        if let (Some(view), Some(x)) = (&problem.problem, state.take_param()) {
            let form = view.problem().form();
            self.stop = self.convergence(form, &x);
            self.norms = Some(self.model.damping_norms(form));
            state = state.param(x);
        }
        Ok((state.cost(self.model.cost), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<LeastSquares<'a>>,
        mut state: Iterate,
    ) -> Result<(Iterate, Option<KV>), Error> {
        let view = problem.problem.ok_or_else(|| Error::msg("no problem"))?;
        let form = view.problem().form();
        let x = state.take_param().ok_or_else(|| Error::msg("no point"))?;
        let iteration = state.iter as usize;
        if self.control.is_interrupted() {
            self.stop = Some(Stop::Interrupted);
            return Ok((state.param(x).cost(self.model.cost), None));
        }
        let current = self.model.damping_norms(form);
        let norms = match self.norms.take() {
            Some(largest) => largest.sup(&current),
            None => current,
        };
        let step = self.model.damped_step(form, &x, self.lambda, &norms);
        self.norms = Some(norms);
        let trial = bounds::project(form, &(&x + &step));
        let step = &trial - &x;
        let predicted = self.model.predicted_decrease(&step);
        let accepted = if predicted > 0.0 {
            self.try_point(problem, &trial)?
        } else {
            None
        };
        let x = match accepted {
            Some(model) => {
                self.accept(model, predicted);
                self.stop = self.convergence(form, &trial);
                self.record(iteration, scaled_length(form, &step));
                trial
            }
            None => {
                self.reject();
                self.record(iteration, 0.0);
                x
            }
        };
        Ok((state.param(x).cost(self.model.cost), None))
    }

    fn terminate(&mut self, _state: &Iterate) -> TerminationStatus {
        match self.stop {
            None => TerminationStatus::NotTerminated,
            Some(Stop::Interrupted) => TerminationStatus::Terminated(TerminationReason::Interrupt),
            Some(stop) if stop.converged() => {
                TerminationStatus::Terminated(TerminationReason::SolverConverged)
            }
            Some(stop) => {
                let reason = TerminationReason::SolverExit(stop.name().to_string());
                TerminationStatus::Terminated(reason)
            }
        }
    }
}
