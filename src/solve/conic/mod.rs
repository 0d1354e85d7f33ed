//! Conic programs by Clarabel's interior-point method: min 1/2 |A x + b|² or cᵀx subject to G x + h in K.
//!
//! A sum of squares is whitened first: with A = Q R and the least squares solution x_ls, x = x_ls + R⁻¹ w
//! turns it into 1/2 |w|². Passing AᵀA to the method instead loses half of the digits. Directions that the
//! residual does not see are completed by an orthonormal basis, so that the constraints decide there.

use std::panic::{AssertUnwindSafe, catch_unwind};

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT as Cone,
};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::linalg::{lapack, svec};
use crate::problem::Linearization;
use crate::problem::bounds;
use crate::problem::form::{Form, Set};
use crate::problem::solution::{Control, Solution, Stop, Trace};
use crate::problem::view::ConeProgram;
use crate::solve::conic::coordinates::Coordinates;
use crate::solve::error::{SolveError, SolveErrorKind};
use crate::solve::finite_model;

mod coordinates;

/// Iterations for the eigenvalues of a block; a few per row are usual, and only NaN needs more.
const EIGEN_ITERATIONS: usize = 10_000;

/// Accuracy and limits.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Optimal when gap and infeasibility <= tolerance, relative to the problem's size where that exceeds one.
    pub tolerance: f64,
    /// Where the tolerance is out of reach, as on a degenerate cone, optimal when they are <= this.
    pub reduced_tolerance: f64,
    /// Interior-point iterations after which it stops with [`Stop::IterationLimit`](crate::problem::solution::Stop).
    pub max_iterations: usize,
    /// A column of A is independent when |its part orthogonal to the columns kept| > rank_tolerance · |column|.
    pub rank_tolerance: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            tolerance: 1e-10,
            reduced_tolerance: 1e-8,
            max_iterations: 200,
            rank_tolerance: 1e-9,
        }
    }
}

/// A solution with its certificate.
#[derive(Debug, Clone)]
pub struct ConicSolution {
    /// The point and why it is the last one.
    pub solution: Solution,
    /// |primal - dual cost|, which bounds cost - optimal cost, in units of the cost. Infinity or NaN where
    /// the run found that there is no optimum.
    pub gap: f64,
    /// Smallest eigenvalue of a semidefinite constraint, smallest row of a nonnegative one, minus the size of
    /// an equality: negative by what the constraints are missed. Infinity without constraints.
    pub margin: f64,
}

impl Settings {
    fn validate(&self) -> Result<(), SolveError> {
        let settings = [
            ("tolerance", self.tolerance),
            ("reduced_tolerance", self.reduced_tolerance),
            ("rank_tolerance", self.rank_tolerance),
        ];
        match settings
            .into_iter()
            .find(|(_, value)| !(*value > 0.0 && *value < 1.0))
        {
            Some((name, value)) => {
                let range = "0 < value < 1";
                Err(SolveError::at(
                    name,
                    SolveErrorKind::Setting { value, range },
                ))
            }
            None => Ok(()),
        }
    }
}

/// Solves; the start sets the point of linearisation and variables that nothing determines.
pub fn solve(
    view: ConeProgram,
    start: &DVector<f64>,
    settings: &Settings,
    control: &Control,
) -> Result<ConicSolution, SolveError> {
    lapack::keep();
    settings.validate()?;
    let problem = view.problem();
    let form = problem.form();
    let (start, model) = finite_model(problem, start)?;
    let coordinates = Coordinates::new(form, &model, settings.rank_tolerance)
        .ok_or_else(|| SolveError::whole(SolveErrorKind::ModelNotFinite))?;
    let rows = Rows::new(form, &start, &model);
    let run = if coordinates.is_sum_of_squares() && rows.strictly_hold(&coordinates.origin) {
        // The unconstrained optimum is feasible: nothing left to solve.
        Run::at_origin(&coordinates)
    } else {
        interior_point(&coordinates, &rows, settings, control)?
    };
    let step = if run.is_a_point() {
        coordinates.step(&run.point)
    } else {
        coordinates.origin.clone()
    };
    let x = bounds::project(form, &(&start + step));
    let values = problem.values(&x)?;
    Ok(ConicSolution {
        gap: run.gap,
        margin: margin(form, &values.constraints),
        solution: Solution {
            active_bounds: bounds::active(form, &x),
            x,
            cost: values.cost,
            stop: run.stop,
            iterations: run.iterations,
            evaluations: 2,
            trace: Trace::default(),
        },
    })
}

/// G d + h in K over the step d from the start, bounds included.
struct Rows {
    matrix: DMatrix<f64>,
    offset: DVector<f64>,
    cones: Vec<Cone<f64>>,
}

impl Rows {
    fn new(form: &Form, start: &DVector<f64>, model: &Linearization) -> Self {
        let count = start.len();
        let mut cones: Vec<Cone<f64>> = form
            .constraints
            .iter()
            .map(|c| cone(c.set, c.rows))
            .collect();
        let mut bound_rows: Vec<(usize, f64, f64)> = Vec::new();
        for (j, variable) in form.variables.iter().enumerate() {
            let (below, above) = (start[j] - variable.lower, variable.upper - start[j]);
            if variable.lower == variable.upper {
                cones.push(Cone::ZeroConeT(1));
                bound_rows.push((j, 1.0, 0.0));
                continue;
            }
            for (sign, room) in [(1.0, below), (-1.0, above)] {
                if room.is_finite() {
                    // In units of the scale, like the other rows after equilibration.
                    cones.push(Cone::NonnegativeConeT(1));
                    bound_rows.push((j, sign / variable.scale, room / variable.scale));
                }
            }
        }
        let own = model.constraints.len();
        let mut matrix = DMatrix::zeros(own + bound_rows.len(), count);
        let mut offset = DVector::zeros(own + bound_rows.len());
        matrix.rows_mut(0, own).copy_from(&model.jacobian);
        offset.rows_mut(0, own).copy_from(&model.constraints);
        for (k, (j, slope, room)) in bound_rows.into_iter().enumerate() {
            matrix[(own + k, j)] = slope;
            offset[own + k] = room;
        }
        Self {
            matrix,
            offset,
            cones,
        }
    }

    /// Whether every row lies inside its cone at a step; an equality never does.
    fn strictly_hold(&self, step: &DVector<f64>) -> bool {
        let rows = &self.matrix * step + &self.offset;
        let mut first = 0;
        self.cones.iter().all(|cone| {
            let block = rows.rows(first, cone_rows(cone));
            first += block.len();
            block.is_empty() || least(cone, block.as_slice()) > 0.0
        })
    }
}

fn cone(set: Set, rows: usize) -> Cone<f64> {
    match set {
        Set::Zero => Cone::ZeroConeT(rows),
        Set::Nonnegative => Cone::NonnegativeConeT(rows),
        Set::Psd { order } => Cone::PSDTriangleConeT(order),
    }
}

fn cone_rows(cone: &Cone<f64>) -> usize {
    match cone {
        Cone::ZeroConeT(rows) | Cone::NonnegativeConeT(rows) => *rows,
        Cone::PSDTriangleConeT(order) => svec::rows(*order),
        _ => 0,
    }
}

/// The smallest eigenvalue or row; minus the largest entry of an equality.
fn least(cone: &Cone<f64>, rows: &[f64]) -> f64 {
    match cone {
        Cone::ZeroConeT(_) => -rows.iter().fold(0.0, |m: f64, r| m.max(r.abs())),
        Cone::PSDTriangleConeT(_) => {
            SymmetricEigen::try_new(svec::smat(rows), f64::EPSILON, EIGEN_ITERATIONS)
                .map_or(f64::NEG_INFINITY, |eigen| eigen.eigenvalues.min())
        }
        _ => rows.iter().fold(f64::INFINITY, |m, r| m.min(*r)),
    }
}

fn margin(form: &Form, rows: &DVector<f64>) -> f64 {
    let mut first = 0;
    let mut margin = f64::INFINITY;
    for constraint in form.constraints.iter().filter(|c| c.rows > 0) {
        let block = rows.rows(first, constraint.rows);
        first += constraint.rows;
        margin = margin.min(least(
            &cone(constraint.set, constraint.rows),
            block.as_slice(),
        ));
    }
    margin
}

/// The end of a run in the coordinates.
struct Run {
    point: DVector<f64>,
    gap: f64,
    stop: Stop,
    iterations: usize,
}

impl Run {
    fn at_origin(coordinates: &Coordinates) -> Self {
        Self {
            point: DVector::zeros(coordinates.basis.ncols()),
            gap: 0.0,
            stop: Stop::Optimal,
            iterations: 0,
        }
    }

    /// The start, where the method broke down.
    fn failed(coordinates: &Coordinates) -> Self {
        Self {
            gap: f64::INFINITY,
            stop: Stop::Stalled,
            ..Self::at_origin(coordinates)
        }
    }

    /// Whether the end is a point, not a certificate that there is none.
    fn is_a_point(&self) -> bool {
        !matches!(self.stop, Stop::Infeasible | Stop::Unbounded)
            && self.point.iter().all(|v| v.is_finite())
    }
}

fn interior_point(
    coordinates: &Coordinates,
    rows: &Rows,
    settings: &Settings,
    control: &Control,
) -> Result<Run, SolveError> {
    let a = sparse(&(-&rows.matrix * &coordinates.basis));
    let b = &rows.offset + &rows.matrix * &coordinates.origin;
    let p = sparse(&DMatrix::from_diagonal(&coordinates.quadratic));
    let q = coordinates.linear.as_slice();
    let attempt = |tolerance: f64| -> Result<Run, SolveError> {
        let (b, options) = (b.as_slice(), options(tolerance, settings, control));
        let solver = DefaultSolver::new(&p, q, &a, b, &rows.cones, options);
        let mut solver = solver.map_err(|error| {
            SolveError::whole(SolveErrorKind::Defect {
                message: error.to_string(),
            })
        })?;
        if let Some(flag) = control.interrupt.clone() {
            solver.set_termination_callback(move |_: &_| {
                flag.load(std::sync::atomic::Ordering::Relaxed)
            });
        }
        // The solver unwraps factorisations that fail on numbers at the edge of the range: that is no
        // solution, and no reason to end the caller's process.
        if catch_unwind(AssertUnwindSafe(|| solver.solve())).is_err() {
            return Ok(Run::failed(coordinates));
        }
        let found = &solver.solution;
        Ok(Run {
            point: DVector::from_column_slice(&found.x),
            gap: (found.obj_val - found.obj_val_dual).abs() * coordinates.cost_unit,
            stop: stop_of(found.status),
            iterations: found.iterations as usize,
        })
    };
    let run = attempt(settings.tolerance)?;
    match run.stop {
        Stop::NearlyOptimal | Stop::Stalled => attempt(settings.reduced_tolerance),
        _ => Ok(run),
    }
}

fn options(tolerance: f64, settings: &Settings, control: &Control) -> DefaultSettings<f64> {
    DefaultSettings {
        verbose: false,
        max_iter: u32::try_from(settings.max_iterations).unwrap_or(u32::MAX),
        time_limit: control
            .time_limit
            .map_or(f64::INFINITY, |limit| limit.as_secs_f64()),
        tol_gap_abs: tolerance,
        tol_gap_rel: tolerance,
        tol_feas: tolerance,
        max_threads: 1,
        presolve_enable: false,
        chordal_decomposition_enable: false,
        ..DefaultSettings::default()
    }
}

/// The nonzero entries, column by column.
fn sparse(matrix: &DMatrix<f64>) -> CscMatrix<f64> {
    let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for column in matrix.column_iter() {
        for (i, value) in column.iter().enumerate().filter(|(_, v)| **v != 0.0) {
            rows.push(i);
            values.push(*value);
        }
        starts.push(rows.len());
    }
    CscMatrix::new(matrix.nrows(), matrix.ncols(), starts, rows, values)
}

fn stop_of(status: SolverStatus) -> Stop {
    use SolverStatus as S;
    match status {
        S::Solved => Stop::Optimal,
        S::AlmostSolved => Stop::NearlyOptimal,
        S::PrimalInfeasible | S::AlmostPrimalInfeasible => Stop::Infeasible,
        S::DualInfeasible | S::AlmostDualInfeasible => Stop::Unbounded,
        S::MaxIterations => Stop::IterationLimit,
        S::MaxTime => Stop::TimeLimit,
        S::CallbackTerminated => Stop::Interrupted,
        S::Unsolved | S::NumericalError | S::InsufficientProgress => Stop::Stalled,
    }
}

#[cfg(test)]
mod tests;
