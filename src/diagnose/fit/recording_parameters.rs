//! Parameters of single recordings: an external contact, a temperature at the start.
//!
//! In a recording that is held out they are fitted on every other row, with everything else as the training recordings
//! have it; the rows between judge the model.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::effect::Lasts;
use crate::chain::model::Model;
use crate::chain::parameter::Role;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::fit::channel_series::ChannelSeries;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::start_grid::Grid;
use crate::estimate::error::EstimateError;
use crate::estimate::search_range::MotionRange;
use crate::linalg::normal_equations::NormalSolution;
use crate::problem::form::{Form, Objective, Structure, Variable};
use crate::problem::view::LeastSquares;
use crate::problem::{Linearization, OutsideDomain, Problem, SquareRoot, Values};
use crate::recording::split::Split;
use crate::solve::levenberg_marquardt;
use nalgebra::{DMatrix, DVector};

/// The dataset with every other row of the recordings that are held out, and the rows between as recordings of
/// their own.
pub fn alternate(data: &Dataset) -> (Dataset, Vec<Prepared>) {
    let judged = |recording: &Prepared| match recording.split {
        Split::Train => recording.clone(),
        Split::Validation => recording.part(Split::Validation, |row| row % 2 == 1),
    };
    let fitted = data.of(Split::Validation);
    let between = fitted.map(|recording| recording.part(Split::Train, |row| row % 2 == 0));
    let judged = Dataset {
        recordings: data.recordings.iter().map(judged).collect(),
    };
    (judged, between.collect())
}

/// Free parameters of effects that belong to one recording.
fn own_parameters(model: &Model) -> Vec<usize> {
    let parameters = model.parameters().iter().enumerate();
    let own = parameters.filter(|(_, parameter)| match parameter.role {
        Role::Effect { joint, effect, .. } => {
            let (effect, _) = model.joints()[joint].effects[effect];
            effect.needs.lasts == Lasts::OneRecording && parameter.is_free()
        }
        _ => false,
    });
    own.map(|(p, _)| p).collect()
}

/// Values of all parameters in each recording that is held out; none where no effect has parameters of its own there.
pub fn values(
    context: &Context<'_>,
    model: &Model,
    fitted: &DVector<f64>,
    deviations: &[f64],
) -> Result<Vec<DVector<f64>>, DiagnoseError> {
    let own = own_parameters(model);
    if own.is_empty() {
        return Ok(Vec::new());
    }
    let of = |recording: &Prepared| {
        let problem = OwnProblem::new(model, fitted, &own, recording, deviations);
        let start = problem.start();
        let view = LeastSquares::try_from(&problem as &dyn Problem).map_err(EstimateError::from)?;
        let settings = levenberg_marquardt::Settings::default();
        let found = levenberg_marquardt::minimize(view, &start, &settings, context.control)
            .map_err(EstimateError::from)?;
        Ok(problem.values_at(&found.x))
    };
    context.between.iter().map(of).collect()
}

/// Least squares over the parameters of one recording.
struct OwnProblem<'a> {
    model: &'a Model,
    fitted: &'a DVector<f64>,
    own: &'a [usize],
    recordings: [&'a Prepared; 1],
    deviations: &'a [f64],
    form: Form,
}

impl<'a> OwnProblem<'a> {
    fn new(
        model: &'a Model,
        fitted: &'a DVector<f64>,
        own: &'a [usize],
        recording: &'a Prepared,
        deviations: &'a [f64],
    ) -> Self {
        let variable = |&p: &usize| {
            let parameter = &model.parameters()[p];
            Variable::free(&parameter.name, &parameter.unit)
                .scale(parameter.scale)
                .within(parameter.lower, parameter.upper)
        };
        let rows = recording.rows() * model.channels().len();
        Self {
            form: Form {
                variables: own.iter().map(variable).collect(),
                objective: Objective::SumOfSquares { rows },
                constraints: Vec::new(),
                structure: Structure::Smooth,
            },
            model,
            fitted,
            own,
            recordings: [recording],
            deviations,
        }
    }

    fn values_at(&self, x: &DVector<f64>) -> DVector<f64> {
        let mut values = self.fitted.clone();
        self.own
            .iter()
            .zip(x.iter())
            .for_each(|(&p, x)| values[p] = *x);
        values
    }

    /// Of the values fitted to the training recordings and the grid points of each effect, those from which one step
    /// leaves least.
    fn start(&self) -> DVector<f64> {
        let at = |values: &DVector<f64>| {
            DVector::from_iterator(self.own.len(), self.own.iter().map(|&p| values[p]))
        };
        let mut best = at(self.fitted);
        let mut least = self.after_one_step(&best);
        for own in self.effects() {
            let Role::Effect { joint, effect, .. } = self.model.parameters()[own[0]].role else {
                continue;
            };
            let (effect, _) = self.model.joints()[joint].effects[effect];
            let motion = MotionRange::of(&self.recordings, joint);
            let grid = Grid::new(self.model, &own, effect, &motion);
            for point in grid.all(None) {
                let mut values = self.values_at(&best);
                own.iter().zip(&point).for_each(|(&p, x)| values[p] = *x);
                let tried = at(&values);
                let left = self.after_one_step(&tried);
                if left < least {
                    (best, least) = (tried, left);
                }
            }
        }
        best
    }

    /// The own parameters of each effect of each joint.
    fn effects(&self) -> Vec<Vec<usize>> {
        let place = |p: usize| match self.model.parameters()[p].role {
            Role::Effect { joint, effect, .. } => Some((joint, effect)),
            _ => None,
        };
        let parts = self.own.chunk_by(|a, b| place(*a) == place(*b));
        parts.map(<[usize]>::to_vec).collect()
    }

    fn after_one_step(&self, x: &DVector<f64>) -> f64 {
        let SquareRoot { matrix, residual } = self.square_root(x);
        let kept: Vec<usize> = (0..matrix.ncols())
            .filter(|&k| matrix.column(k).norm_squared() > 0.0)
            .collect();
        let matrix = matrix.select_columns(&kept);
        let normal = matrix.tr_mul(&matrix);
        residual.norm_squared() - NormalSolution::of(&normal, &matrix.tr_mul(&residual)).gain
    }

    fn square_root(&self, x: &DVector<f64>) -> SquareRoot {
        let values = self.values_at(x);
        let series = ChannelSeries::of(self.model, &values, self.own, &self.recordings);
        let lengths = series.predicted.iter().map(Vec::len);
        let mut matrix = DMatrix::zeros(lengths.sum(), self.own.len());
        let mut residual = DVector::zeros(matrix.nrows());
        let mut start = 0;
        for (c, errors) in series.residuals().iter().enumerate() {
            for (row, e) in errors.iter().enumerate() {
                residual[start + row] = e / self.deviations[c];
            }
            for (k, column) in series.columns[c].iter().enumerate() {
                for (row, x) in column.iter().flatten().enumerate() {
                    matrix[(start + row, k)] = x / self.deviations[c];
                }
            }
            start += errors.len();
        }
        SquareRoot { matrix, residual }
    }
}

impl Problem for OwnProblem<'_> {
    fn form(&self) -> &Form {
        &self.form
    }

    fn values(&self, x: &DVector<f64>) -> Result<Values, OutsideDomain> {
        Ok(Values {
            cost: 0.5 * self.square_root(x).residual.norm_squared(),
            constraints: DVector::zeros(0),
        })
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, OutsideDomain> {
        Ok(Linearization::of_squares(self.square_root(x)))
    }
}
