//! The fit as an optimisation problem: `½ ‖W (ŝ(x) − s)‖² + ½ ‖prior(x)‖²` over the unknowns x, which every solver takes.

use crate::chain::dataset::Prepared;
use crate::chain::evaluate::KnownBodies;
use crate::chain::model::Model;
use crate::chain::prior::Prior;
use crate::estimate::fit_problem::estimator::Training;
use crate::estimate::fit_problem::unknowns::Unknowns;
use crate::estimate::residual::compress::{Request, factor, sum_of_squares};
use crate::estimate::residual::noise::{ResidualSeries, residuals};
use crate::estimate::residual::rows::whole_motion;
use crate::estimate::residual::standstill;
use crate::estimate::residual::weights::{RowFactors, Weights};
use crate::linalg::triangular::Triangular;
use crate::problem::form::{Form, Objective, Structure, Variable};
use crate::problem::{Linearization, OutsideDomain, Problem, SquareRoot, Values};
use nalgebra::DVector;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Where the weights of the channels come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseSource {
    /// The scatter of the periods about their average.
    Periods,
    /// What the fit leaves.
    Residuals,
}

/// A weighted fit of a model to recordings.
#[derive(Debug)]
pub struct FitProblem<'a> {
    /// Predicts ŝ.
    pub model: &'a Model,
    /// What is estimated, and in which order.
    pub unknowns: &'a Unknowns,
    /// What is fitted.
    pub recordings: &'a [&'a Prepared],
    /// What is known before the data, as rows of the residual.
    pub prior: &'a Prior,
    weights: Weights,
    /// Where the deviations of the noise come from.
    pub noise: NoiseSource,
    /// Factors of single rows, of robust estimates; none where every row counts the same.
    pub factors: Option<RowFactors>,
    /// 0 where a joint stands still.
    moving: Option<RowFactors>,
    form: Form,
    columns: Vec<usize>,
    /// The model with the switches of losses smoothed, while an optimum is searched.
    smoothed: Option<Box<Model>>,
    /// What the bodies do along the recordings, shared by problems that differ in neither.
    bodies: Arc<OnceLock<Vec<Option<KnownBodies>>>>,
    /// The factor that was asked for last, and where.
    last: Mutex<Option<(DVector<f64>, Triangular)>>,
}

impl<'a> FitProblem<'a> {
    /// A residual over the rows of all recordings and those of the prior, `weights` times predictions minus recordings.
    pub fn new(
        model: &'a Model,
        unknowns: &'a Unknowns,
        training: Training<'a>,
        weights: Weights,
    ) -> Self {
        let Training { recordings, prior } = training;
        let columns = unknowns.positions();
        let moving = standstill::factors(model, recordings);
        let active = model.channels().iter().filter(|c| c.active).count();
        let rows: usize = recordings.iter().map(|r| r.rows() * active).sum();
        let variables = columns.iter().enumerate().map(|(k, &p)| {
            let parameter = &model.parameters()[p];
            let variable = Variable::free(&parameter.name, &parameter.unit).scale(parameter.scale);
            // A bound on one parameter says nothing about a combination that it leads.
            if unknowns.is_single(k) && parameter.keeps_limits() {
                variable.within(parameter.lower, parameter.upper)
            } else {
                variable
            }
        });
        Self {
            form: Form {
                variables: variables.collect(),
                objective: Objective::SumOfSquares {
                    rows: rows + prior.len(),
                },
                constraints: Vec::new(),
                structure: if unknowns.nonlinear.is_empty() && model.is_affine() {
                    Structure::Affine
                } else {
                    Structure::Smooth
                },
            },
            model,
            unknowns,
            recordings,
            prior,
            weights,
            noise: NoiseSource::Residuals,
            factors: moving.clone(),
            moving,
            columns,
            smoothed: None,
            bodies: Arc::default(),
            last: Mutex::default(),
        }
    }

    /// The same fit with the residuals of single rows weighted, beside leaving out standstill.
    pub fn with_factors(mut self, mut factors: RowFactors) -> Self {
        if let Some(moving) = &self.moving {
            for (series, moving) in factors.iter_mut().flatten().zip(moving.iter().flatten()) {
                series.iter_mut().zip(moving).for_each(|(f, m)| *f *= m);
            }
        }
        self.factors = Some(factors);
        self.last = Mutex::default();
        self
    }

    /// Weighs the channels anew.
    pub fn reweigh(&mut self, weights: Weights) {
        self.weights = weights;
        self.last = Mutex::default();
    }

    /// The same fit along other motions of the same recordings.
    pub fn along<'b>(&self, recordings: &'b [&'b Prepared]) -> FitProblem<'b>
    where
        'a: 'b,
    {
        FitProblem {
            model: self.model,
            unknowns: self.unknowns,
            recordings,
            prior: self.prior,
            weights: self.weights.clone(),
            noise: self.noise,
            factors: self.factors.clone(),
            moving: self.moving.clone(),
            form: self.form.clone(),
            columns: self.columns.clone(),
            smoothed: self.smoothed.clone(),
            bodies: Arc::default(),
            last: Mutex::default(),
        }
    }

    /// The same fit with the switches of losses smoothed, N·m (N) of transmitted torque of each joint.
    pub fn smoothed(&self, widths: &[f64]) -> Self {
        Self {
            smoothed: Some(Box::new(self.model.clone().smoothed(widths))),
            bodies: Arc::clone(&self.bodies),
            ..self.along(self.recordings)
        }
    }

    /// The same fit of some of the unknowns, with `model` for the rest: the same bodies, other laws or values.
    pub fn with_unknowns<'b>(&'b self, model: &'b Model, unknowns: &'b Unknowns) -> FitProblem<'b> {
        let training = Training {
            recordings: self.recordings,
            prior: self.prior,
        };
        // From here: what moves the robot may be among the unknowns here and not there.
        self.bodies.get_or_init(|| self.known_bodies());
        FitProblem {
            bodies: Arc::clone(&self.bodies),
            ..FitProblem::new(model, unknowns, training, self.weights.clone())
        }
    }

    /// Residuals `ŝ − s` at x, zero where rows are left out.
    pub fn counted_residuals(&self, x: &DVector<f64>) -> ResidualSeries {
        let mut series = residuals(self.model, &self.parameters(x), self.recordings);
        if let Some(moving) = &self.moving {
            for (series, moving) in series.iter_mut().flatten().zip(moving.iter().flatten()) {
                series.iter_mut().zip(moving).for_each(|(e, m)| *e *= m);
            }
        }
        series
    }

    /// Values of all parameters of the model at the unknowns x; parameters that base parameters stand for
    /// are zero.
    pub fn parameters(&self, x: &DVector<f64>) -> DVector<f64> {
        let mut values = self.model.values();
        for base in &self.unknowns.base.base {
            for (dependent, _) in &base.others {
                values[*dependent] = 0.0;
            }
        }
        for &parameter in &self.unknowns.base.without_effect {
            values[parameter] = 0.0;
        }
        for (k, &parameter) in self.columns.iter().enumerate() {
            values[parameter] = x[k];
        }
        self.model.spread(&mut values);
        values
    }

    /// The unknowns at the model's starting values.
    pub fn start(&self) -> DVector<f64> {
        let values = self.model.values();
        let start = self.columns.iter().map(|&p| values[p]);
        DVector::from_iterator(self.columns.len(), start)
    }

    /// What rows are multiplied by.
    pub fn weights(&self) -> &Weights {
        &self.weights
    }

    /// Triangular factor of the derivatives at x, weighted, prior included, and of the residual. The last one is
    /// kept: searches end where the next begins, and what is reported is taken there too.
    pub fn factor(&self, x: &DVector<f64>) -> Triangular {
        let last = || self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, factor)) = last().as_ref().filter(|(at, _)| at == x) {
            return factor.clone();
        }
        // Not locked meanwhile: a thread that waits for others may take up work that asks for a factor too.
        let factor = self.factor_anew(x);
        *last() = Some((x.clone(), factor.clone()));
        factor
    }

    fn factor_anew(&self, x: &DVector<f64>) -> Triangular {
        let values = self.parameters(x);
        let mut whole = factor(&self.request(&values), self.recordings);
        if !self.prior.is_empty() {
            let known = self.prior.system(&self.columns, 0, &values);
            whole.absorb(known.as_slice());
        }
        whole
    }

    /// The same factor without the prior over the unknowns, further parameters of the model and the
    /// residual.
    pub fn factor_over(&self, x: &DVector<f64>, further: &[usize]) -> Triangular {
        let values = self.parameters(x);
        let columns: Vec<usize> = self.columns.iter().chain(further).copied().collect();
        let request = Request {
            columns: &columns,
            ..self.request(&values)
        };
        factor(&request, self.recordings)
    }

    fn request<'b>(&'b self, values: &'b DVector<f64>) -> Request<'b> {
        Request {
            bodies: self.bodies.get_or_init(|| self.known_bodies()),
            model: self.smoothed.as_deref().unwrap_or(self.model),
            values,
            columns: &self.columns,
            weights: &self.weights,
            factors: self.factors.as_ref(),
        }
    }
}

/// With so few unknowns derivatives cost less than residuals a second time, and a search asks for both wherever the
/// cost falls.
const CHEAP_COLUMNS: usize = 32;

/// Columns that are kept: with few of them the recursion down the robot costs more than to read them; with the columns
/// of all links it is the other way round.
const FEW_COLUMNS: usize = 16;

/// Doubles that are kept, 16 MB.
const MOST_KEPT: usize = 2_000_000;

impl FitProblem<'_> {
    /// What the bodies do along every recording, where a search asks for it again and again and it is small.
    fn known_bodies(&self) -> Vec<Option<KnownBodies>> {
        let parameters = self.model.parameters();
        let inertial = self
            .columns
            .iter()
            .filter(|&&p| parameters[p].role.is_inertial());
        let count = inertial.count();
        let rows: usize = self.recordings.iter().map(|r| r.rows()).sum();
        let kept = rows * self.model.joints().len() * (count + 1);
        if self.form.structure == Structure::Affine || count > FEW_COLUMNS || kept > MOST_KEPT {
            return Vec::new();
        }
        let values = self.parameters(&self.start());
        let of = |recording: &&Prepared| {
            let whole_motion = whole_motion(self.model, recording);
            KnownBodies::linear(self.model, &values, &self.columns, whole_motion)
        };
        self.recordings.iter().map(of).collect()
    }
}

impl Problem for FitProblem<'_> {
    fn form(&self) -> &Form {
        &self.form
    }

    fn values(&self, x: &DVector<f64>) -> Result<Values, OutsideDomain> {
        if self.columns.len() <= CHEAP_COLUMNS {
            let last = self.columns.len();
            let whole = self.factor(x);
            let squares: f64 = (0..=last).map(|i| whole.entry(i, last).powi(2)).sum();
            return Ok(Values {
                cost: 0.5 * squares,
                constraints: DVector::zeros(0),
            });
        }
        let values = self.parameters(x);
        let squares = sum_of_squares(&self.request(&values), self.recordings);
        let prior = self.prior.residual(&values).norm_squared();
        Ok(Values {
            cost: 0.5 * (squares + prior),
            constraints: DVector::zeros(0),
        })
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, OutsideDomain> {
        let count = self.columns.len();
        let whole = self.factor(x).matrix();
        let matrix = whole.columns(0, count).into_owned();
        let residual = whole.column(count).into_owned();
        Ok(Linearization::of_squares(SquareRoot { matrix, residual }))
    }
}
