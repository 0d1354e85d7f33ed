//! Linear least squares: min 1/2 |A x + b|² within bounds, for a residual that is affine in x.
//!
//! By QR, not normal equations. Columns that depend on those to their left keep their starting value, and
//! the others are estimated as if these were known: a basic solution in the sense of base parameters.

use nalgebra::DVector;

use crate::linalg::triangular::{IndependentColumns, System, Triangular};
use crate::problem::error::{ProblemError, ProblemErrorKind};
use crate::problem::form::{Form, Structure};
use crate::problem::solution::{Solution, Stop, Trace};
use crate::problem::view::LeastSquares;
use crate::problem::{SquareRoot, bounds};
use crate::solve::admissible_start;
use crate::solve::bounded::{self, Bounds};
use crate::solve::error::{SolveError, SolveErrorKind};

/// What the cost has beyond the residual that it is given with is rounding below this share of it.
const ROUNDING: f64 = 1e-13;

/// How the linear solver tells dependent columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// A column is independent when |its part orthogonal to the columns kept| > rank_tolerance · |column|.
    pub rank_tolerance: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            // Above the rounding of a regressor of condition 1e6, below any excitation that is of use.
            rank_tolerance: 1e-9,
        }
    }
}

impl Settings {
    fn validate(&self) -> Result<(), SolveError> {
        let value = self.rank_tolerance;
        if (0.0..1.0).contains(&value) {
            return Ok(());
        }
        let range = "0 <= value < 1";
        Err(SolveError::at(
            "rank_tolerance",
            SolveErrorKind::Setting { value, range },
        ))
    }
}

/// The solution, and what it rests on.
#[derive(Debug, Clone)]
pub struct LinearSolution {
    /// The point and why it is the last one.
    pub solution: Solution,
    /// Which variables were estimated, and how the others would enter.
    pub columns: IndependentColumns,
    /// R of the estimated columns; [`Triangular::covariance`] is that of their values at unit variance.
    pub factor: Triangular,
}

/// Solves from a start, which sets the values of variables that the residual does not determine.
pub fn solve(
    view: LeastSquares,
    start: &DVector<f64>,
    settings: &Settings,
) -> Result<LinearSolution, SolveError> {
    settings.validate()?;
    let problem = view.problem();
    let form = problem.form();
    if form.structure != Structure::Affine {
        let view = "linear least squares";
        return Err(ProblemError::whole(ProblemErrorKind::NotAffine { view }).into());
    }
    let start = admissible_start(form, start)?;
    let not_finite = || SolveError::whole(SolveErrorKind::ModelNotFinite);
    let point = problem.linearize(&start)?;
    let root = point.square_root.ok_or_else(not_finite)?;
    let (columns, system) = reduce(&root, settings.rank_tolerance).ok_or_else(not_finite)?;
    let limits = step_bounds(form, &start, &columns.kept);
    let step = bounded::minimize(&system.matrix, &system.right, &limits);
    let mut x = start.clone();
    for (j, value) in columns.kept.iter().zip(step.iter()) {
        x[*j] += value;
    }
    let x = bounds::project(form, &x);
    // The residual is affine, so what it is at the optimum is known from the start.
    let constant = point.cost - 0.5 * root.residual.norm_squared();
    let is_rounding = constant.abs() <= ROUNDING * point.cost;
    let left = &root.matrix * (&x - start) + &root.residual;
    let cost = 0.5 * left.norm_squared() + if is_rounding { 0.0 } else { constant };
    Ok(LinearSolution {
        solution: Solution {
            active_bounds: bounds::active(form, &x),
            x,
            cost,
            stop: Stop::Optimal,
            iterations: 1,
            evaluations: 1,
            trace: Trace::default(),
        },
        factor: Triangular::of(&system.matrix),
        columns,
    })
}

/// The independent columns and the least squares problem in them; `None` where a number is not finite.
fn reduce(root: &SquareRoot, tolerance: f64) -> Option<(IndependentColumns, System)> {
    let mut numbers = root.matrix.iter().chain(root.residual.iter());
    if !numbers.all(|v| v.is_finite()) {
        return None;
    }
    let whole = Triangular::of_system(&root.matrix, &(-&root.residual)).system()?;
    let columns = Triangular::of(&whole.matrix).independent_columns(tolerance);
    let kept = whole.matrix.select_columns(&columns.kept);
    let system = Triangular::of_system(&kept, &whole.right).system()?;
    Some((columns, system))
}

/// The bounds as limits of the step of some variables.
fn step_bounds(form: &Form, start: &DVector<f64>, kept: &[usize]) -> Bounds {
    let of = |j: usize| &form.variables[j];
    Bounds {
        lower: DVector::from_iterator(kept.len(), kept.iter().map(|j| of(*j).lower - start[*j])),
        upper: DVector::from_iterator(kept.len(), kept.iter().map(|j| of(*j).upper - start[*j])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;
    use crate::problem::Problem;
    use crate::problem::examples;
    use nalgebra::{dmatrix, dvector};

    fn run(problem: &dyn Problem, start: DVector<f64>) -> Result<LinearSolution, SolveError> {
        solve(
            LeastSquares::try_from(problem)?,
            &start,
            &Settings::default(),
        )
    }

    #[test]
    fn matches_closed_form_of_a_line_through_three_points() {
        // y = (1, 2.5, 4.5) at 0, 1, 2: slope 7/4, intercept 8/3 - 7/4, variance of the slope 1/2.
        let line = examples::affine(
            dmatrix![1.0, 0.0; 1.0, 1.0; 1.0, 2.0],
            dvector![-1.0, -2.5, -4.5],
        );
        let found = run(&line, dvector![9.0, -7.0]).unwrap();
        assert!((found.solution.x - dvector![8.0 / 3.0 - 1.75, 1.75]).amax() <= 1e-14);
        let covariance = found.factor.covariance().unwrap();
        assert!((covariance[(1, 1)] - 0.5).abs() <= 1e-15);
        // Residuals (1, -2, 1) / 12.
        assert!((found.solution.cost - 3.0 / 144.0).abs() <= 1e-15);
    }

    #[test]
    fn a_dependent_column_keeps_its_start_and_is_reported() {
        let matrix = dmatrix![1.0, 2.0, 0.0; 2.0, 4.0, 1.0; 3.0, 6.0, 5.0];
        let truth = dvector![1.0, 0.5, -2.0];
        let offset = -&matrix * &truth;
        let found = run(&examples::affine(matrix, offset), dvector![0.0, 3.0, 0.0]).unwrap();
        assert_eq!(found.columns.dependent, [1]);
        // x0 + 2 x1 = 2 with x1 = 3.
        assert!((found.solution.x - dvector![-4.0, 3.0, -2.0]).amax() <= 1e-13);
    }

    #[test]
    fn bounds_are_kept_and_reported() {
        let mut problem = examples::affine(dmatrix![1.0, 1.0; 1.0, -1.0], dvector![-3.0, 0.0]);
        problem.form.variables[0].upper = 1.0;
        let found = run(&problem, dvector![0.0, 0.0]).unwrap().solution;
        assert!((found.x - dvector![1.0, 1.5]).amax() <= 1e-14);
        assert_eq!(found.active_bounds.len(), 1);
    }

    #[test]
    fn refuses_a_residual_that_is_not_affine() {
        let error = run(&examples::rosenbrock(), dvector![0.0, 0.0]).unwrap_err();
        assert_eq!(error.describe().code, "not-affine");
    }
}
