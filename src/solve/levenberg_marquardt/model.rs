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
    free: Free,
}

/// Independent columns of the variables that no bound holds.
#[derive(Default)]
struct Free {
    columns: Vec<usize>,
    /// Their triangular factor R.
    factor: DMatrix<f64>,
    /// R⁻ᵀ times the gradient.
    gradient: DVector<f64>,
}

/// A step that promises as much on either side of a kink.
pub(super) struct AlongKink {
    pub step: DVector<f64>,
    /// Decrease of the cost.
    pub promised: f64,
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
            free: Free::default(),
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
        self.free = Free {
            columns: kept.iter().map(|k| columns[*k]).collect(),
            factor: system.matrix,
            gradient: -system.right,
        };
    }

    /// The step by the shortest combination of the gradients here and beyond a kink, in the metric of the model:
    ///
    /// ```text
    /// min over θ in [0, 1]  |R⁻ᵀ((1 - θ) g + θ g_beyond)|
    /// ```
    ///
    /// It leads along the kink, which both sides have in common, and vanishes where the point is a minimum although neither
    /// gradient does (Lemaréchal 1975).
    pub(super) fn along_kink(&self, beyond: &Self) -> Option<AlongKink> {
        let Free {
            columns,
            factor,
            gradient: here,
        } = &self.free;
        let there =
            DVector::from_iterator(columns.len(), columns.iter().map(|&j| beyond.gradient[j]));
        let there = factor.tr_solve_upper_triangular(&there)?;
        let change = &there - here;
        let share = -here.dot(&change) / change.norm_squared();
        if !share.is_finite() {
            return None;
        }
        let shortest = here + share.clamp(0.0, 1.0) * change;
        let own = factor.solve_upper_triangular(&shortest)?;
        let mut step = DVector::zeros(self.norms.len());
        for (j, value) in columns.iter().zip(own.iter()) {
            step[*j] = -value;
        }
        Some(AlongKink {
            step,
            promised: 0.5 * shortest.norm_squared(),
        })
    }

    /// Half the square of a step's length in the metric of the model, in which a standard deviation is as long in every direction.
    pub(super) fn size(&self, step: &DVector<f64>) -> f64 {
        0.5 * (&self.matrix * step).norm_squared()
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
