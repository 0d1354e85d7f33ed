//! Coordinates in which the cost is as simple as it can be: d = origin + basis (w, v), with cost
//! cost_unit · 1/2 |w|² for a sum of squares, or a linear cost over scaled variables.

use nalgebra::{DMatrix, DVector};

use crate::linalg::triangular::{IndependentColumns, Triangular};
use crate::problem::Linearization;
use crate::problem::form::{Form, Objective};

/// Share of the reachable residual below which the unit of w does not go. Without noise w would reach any
/// size, and the method would take the steep cost for a sign of infeasibility.
const LEAST_NOISE: f64 = 1e-2;

/// The change of variables and the cost in it.
pub(super) struct Coordinates {
    /// Step at w = v = 0: the least squares solution, or zero.
    pub origin: DVector<f64>,
    /// n x n.
    pub basis: DMatrix<f64>,
    /// Diagonal of the Hessian: one for w, zero for v and for a linear cost.
    pub quadratic: DVector<f64>,
    pub linear: DVector<f64>,
    /// Cost of a unit of the cost in the coordinates.
    pub cost_unit: f64,
}

impl Coordinates {
    /// `None` where a sum of squares comes without its square root or with values that are not finite.
    pub(super) fn new(form: &Form, model: &Linearization, rank_tolerance: f64) -> Option<Self> {
        match form.objective {
            Objective::Smooth => Some(Self::scaled(form, model)),
            Objective::SumOfSquares { rows } => Self::whitened(form, model, rows, rank_tolerance),
        }
    }

    pub(super) fn is_sum_of_squares(&self) -> bool {
        self.linear.amax() == 0.0
    }

    /// The step of the variables.
    pub(super) fn step(&self, point: &DVector<f64>) -> DVector<f64> {
        &self.origin + &self.basis * point
    }

    /// Every variable in units of its scale, the cost in units of its largest slope.
    fn scaled(form: &Form, model: &Linearization) -> Self {
        let count = form.variables.len();
        let scales = DVector::from_iterator(count, form.variables.iter().map(|v| v.scale));
        let slope = model.gradient.component_mul(&scales);
        let largest = slope.amax();
        let cost_unit = if largest > 0.0 { largest } else { 1.0 };
        Self {
            origin: DVector::zeros(count),
            basis: DMatrix::from_diagonal(&scales),
            quadratic: DVector::zeros(count),
            linear: slope / cost_unit,
            cost_unit,
        }
    }

    /// d = origin + T w + N v: N spans what the residual does not see, T is R⁻¹ made orthogonal to it,
    /// both over scaled variables.
    fn whitened(form: &Form, model: &Linearization, rows: usize, tolerance: f64) -> Option<Self> {
        let root = model.square_root.as_ref()?;
        let count = form.variables.len();
        let scales = DVector::from_iterator(count, form.variables.iter().map(|v| v.scale));
        let mut numbers = root.matrix.iter().chain(root.residual.iter());
        if !numbers.all(|v| v.is_finite()) {
            return None;
        }
        let whole = Triangular::of_system(&root.matrix, &(-&root.residual)).system()?;
        let matrix = &whole.matrix * DMatrix::from_diagonal(&scales);
        let columns = Triangular::of(&matrix).independent_columns(tolerance);
        let kept = matrix.select_columns(&columns.kept);
        let system = Triangular::of_system(&kept, &whole.right).system()?;
        let rank = columns.kept.len();
        let null = null_space(count, &columns);
        let mut particular = DMatrix::zeros(count, rank);
        let inverse = system
            .matrix
            .solve_upper_triangular(&DMatrix::identity(rank, rank))?;
        for (k, j) in columns.kept.iter().enumerate() {
            particular.row_mut(*j).copy_from(&inverse.row(k));
        }
        let seen = &null * null.tr_mul(&particular);
        particular -= seen;
        let noise = noise_level(model.cost, &system.right, rows.saturating_sub(rank));
        let mut basis = DMatrix::zeros(count, count);
        basis.columns_mut(0, rank).copy_from(&(&particular * noise));
        basis.columns_mut(rank, count - rank).copy_from(&null);
        let unscale = DMatrix::from_diagonal(&scales);
        Some(Self {
            origin: &unscale * particular * &system.right,
            basis: unscale * basis,
            quadratic: DVector::from_fn(count, |j, _| if j < rank { 1.0 } else { 0.0 }),
            linear: DVector::zeros(count),
            cost_unit: noise * noise,
        })
    }
}

/// Orthonormal basis of {d : A d = 0}, from A_dependent = A_kept C: the columns of (-C; I).
fn null_space(count: usize, columns: &IndependentColumns) -> DMatrix<f64> {
    let mut spanning = DMatrix::zeros(count, columns.dependent.len());
    for (column, j) in columns.dependent.iter().enumerate() {
        spanning[(*j, column)] = 1.0;
        for (k, i) in columns.kept.iter().enumerate() {
            spanning[(*i, column)] = -columns.coefficients[(k, column)];
        }
    }
    spanning.qr().q()
}

/// Standard deviation of a residual at the unconstrained optimum, the unit of w.
fn noise_level(cost: f64, reachable: &DVector<f64>, freedom: usize) -> f64 {
    let rest = (2.0 * cost - reachable.norm_squared()).max(0.0);
    let noise = (rest / freedom.max(1) as f64).sqrt();
    let least = LEAST_NOISE * reachable.norm();
    let level = noise.max(least);
    if level > 0.0 { level } else { 1.0 }
}
