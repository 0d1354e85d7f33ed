//! The Gauss-Newton model 1/2 |R d - z|² + constant at one point, and what it says about convergence.

use nalgebra::{DMatrix, DVector};

use crate::linalg::triangular::{System, Triangular};
use crate::problem::form::Form;
use crate::problem::{OutsideDomain, Problem, bounds};
use crate::solve::bounded::{self, Bounds};

/// A column with no more than this share of its norm outside the span of those before it is dependent.
const RANK_TOLERANCE: f64 = 1e-12;

/// Share of the largest scaled column norm that stands in for a column that vanishes.
const LEAST_NORM: f64 = 1e-8;

/// The model at an accepted point.
pub(super) struct Model {
    pub cost: f64,
    /// Triangular factor of the Jacobian, n x n.
    matrix: DMatrix<f64>,
    /// z = -Qᵀr, n entries.
    right: DVector<f64>,
    gradient: DVector<f64>,
    norms: DVector<f64>,
    /// Decrease of the cost that the undamped step promises, over the variables that no bound holds.
    pub promised: f64,
    /// The undamped step.
    newton: DVector<f64>,
}

impl Model {
    /// Linearises at x; `None` where a number is not finite.
    pub(super) fn at(
        problem: &dyn Problem,
        x: &DVector<f64>,
    ) -> Result<Option<Self>, OutsideDomain> {
        let point = problem.linearize(x)?;
        let Some(root) = point.square_root else {
            return Ok(None);
        };
        let numbers = root.matrix.iter().chain(root.residual.iter());
        if !point.cost.is_finite() || !numbers.chain(point.gradient.iter()).all(|v| v.is_finite()) {
            return Ok(None);
        }
        let system = Triangular::of_system(&root.matrix, &(-&root.residual)).system();
        let Some(System { matrix, right, .. }) = system else {
            return Ok(None);
        };
        let mut model = Self {
            cost: point.cost,
            norms: DVector::from_iterator(x.len(), matrix.column_iter().map(|c| c.norm())),
            matrix,
            right,
            gradient: point.gradient,
            promised: 0.0,
            newton: DVector::zeros(x.len()),
        };
        model.look_ahead(problem.form(), x);
        Ok(Some(model))
    }

    /// The undamped step and its promise, over independent columns of variables that no bound holds.
    fn look_ahead(&mut self, form: &Form, x: &DVector<f64>) {
        let columns: Vec<usize> = (0..x.len())
            .filter(|j| !bounds::is_held(&form.variables[*j], x[*j], self.gradient[*j]))
            .collect();
        let free = self.matrix.select_columns(&columns);
        let kept = Triangular::of(&free)
            .independent_columns(RANK_TOLERANCE)
            .kept;
        let system = Triangular::of_system(&free.select_columns(&kept), &self.right).system();
        let Some(system) = system else { return };
        self.promised = 0.5 * system.right.norm_squared();
        if let Some(step) = system.matrix.solve_upper_triangular(&system.right) {
            for (k, value) in kept.iter().zip(step.iter()) {
                self.newton[columns[*k]] = *value;
            }
        }
    }

    /// Column norms of the Jacobian, none of them zero.
    pub(super) fn damping_norms(&self, form: &Form) -> DVector<f64> {
        let scaled = self.norms.iter().zip(&form.variables);
        let largest = scaled.map(|(n, v)| n * v.scale).fold(0.0, f64::max);
        let floor = if largest > 0.0 {
            LEAST_NORM * largest
        } else {
            1.0
        };
        DVector::from_iterator(
            self.norms.len(),
            self.norms
                .iter()
                .zip(&form.variables)
                .map(|(n, v)| n.max(floor / v.scale)),
        )
    }

    /// The minimiser of |R d - z|² + lambda |D d|² within the bounds.
    pub(super) fn damped_step(
        &self,
        form: &Form,
        x: &DVector<f64>,
        lambda: f64,
        norms: &DVector<f64>,
    ) -> DVector<f64> {
        let count = x.len();
        let mut matrix = DMatrix::zeros(2 * count, count);
        matrix
            .view_mut((0, 0), (count, count))
            .copy_from(&self.matrix);
        for j in 0..count {
            matrix[(count + j, j)] = lambda.sqrt() * norms[j];
        }
        let mut right = DVector::zeros(2 * count);
        right.rows_mut(0, count).copy_from(&self.right);
        let of = |bound: fn(&crate::problem::form::Variable) -> f64| {
            let differences = form
                .variables
                .iter()
                .zip(x.iter())
                .map(|(v, x)| bound(v) - x);
            DVector::from_iterator(count, differences)
        };
        let bounds = Bounds {
            lower: of(|v| v.lower),
            upper: of(|v| v.upper),
        };
        bounded::minimize(&matrix, &right, &bounds)
    }

    /// Decrease of the cost that the model predicts for a step.
    pub(super) fn predicted_decrease(&self, step: &DVector<f64>) -> f64 {
        let change = &self.matrix * step;
        change.dot(&(&self.right - 0.5 * &change))
    }

    /// max |d_j| / (|x_j| + scale_j) of the undamped step.
    pub(super) fn relative_step(&self, form: &Form, x: &DVector<f64>) -> f64 {
        let sizes = form
            .variables
            .iter()
            .zip(x.iter())
            .map(|(v, x)| x.abs() + v.scale);
        let ratios = self
            .newton
            .iter()
            .zip(sizes)
            .map(|(d, size)| d.abs() / size);
        ratios.fold(0.0, f64::max)
    }

    /// Whether |g_j| <= tolerance · |J_j| sqrt(2 cost) for every variable that no bound holds.
    pub(super) fn is_stationary(&self, form: &Form, x: &DVector<f64>, tolerance: f64) -> bool {
        let size = (2.0 * self.cost).sqrt();
        (0..x.len()).all(|j| {
            bounds::is_held(&form.variables[j], x[j], self.gradient[j])
                || self.gradient[j].abs() <= tolerance * self.norms[j] * size
        })
    }
}
