//! The method on problems with known solutions.

use nalgebra::{DMatrix, DVector, dvector};

use crate::problem::examples::TestProblem;
use crate::problem::form::{Constraint, Form, Objective, Set, Structure, Variable};
use crate::problem::linear_rows::{LinearRow, LinearRows};
use crate::problem::solution::Control;
use crate::problem::view::Nlp;
use crate::problem::{Linearization, Problem};
use crate::solve::sqp::{Constrained, Settings, minimize};

type Model = fn(&DVector<f64>) -> (f64, DVector<f64>, DVector<f64>, DMatrix<f64>);

fn problem(variables: Vec<Variable>, sets: &[Set], model: Model) -> TestProblem {
    let constraints = sets.iter().enumerate().map(|(k, set)| Constraint {
        name: format!("c{k}"),
        unit: String::new(),
        rows: 1,
        set: *set,
    });
    TestProblem {
        form: Form {
            variables,
            objective: Objective::Smooth,
            constraints: constraints.collect(),
            structure: Structure::Smooth,
        },
        model: Box::new(move |x| {
            let (cost, gradient, constraints, jacobian) = model(x);
            Ok(Linearization {
                cost,
                gradient,
                square_root: None,
                constraints,
                jacobian,
            })
        }),
        spoil: None,
    }
}

fn solve(problem: &TestProblem, rows: Option<&LinearRows>, start: &[f64]) -> Constrained {
    let view = Nlp::try_from(problem as &dyn Problem).unwrap();
    let view = rows.map_or(view, |rows| view.within(rows));
    let start = DVector::from_column_slice(start);
    let settings = Settings {
        progress_tolerance: 0.0,
        cost_tolerance: 1e-12,
        ..Settings::default()
    };
    minimize(view, &start, &settings, &Control::default()).unwrap()
}

/// Hock and Schittkowski 1981, problem 71: one equation, one inequality, bounds.
#[test]
fn matches_published_optimum_of_hock_schittkowski_71() {
    let variables = (0..4).map(|k| Variable::free(format!("x{k}"), "").within(1.0, 5.0));
    let problem = problem(variables.collect(), &[Set::Nonnegative, Set::Zero], |x| {
        let (a, b, c, d) = (x[0], x[1], x[2], x[3]);
        let gradient = dvector![d * (2.0 * a + b + c), a * d, a * d + 1.0, a * (a + b + c)];
        let constraints = dvector![a * b * c * d - 25.0, x.norm_squared() - 40.0];
        let jacobian = DMatrix::from_row_slice(
            2,
            4,
            &[
                b * c * d,
                a * c * d,
                a * b * d,
                a * b * c,
                2.0 * a,
                2.0 * b,
                2.0 * c,
                2.0 * d,
            ],
        );
        (a * d * (a + b + c) + c, gradient, constraints, jacobian)
    });
    let found = solve(&problem, None, &[1.0, 5.0, 5.0, 1.0]);
    assert!(found.solution.stop.converged(), "{:?}", found.solution.stop);
    // The published value has ten digits; the cost is accurate to the square root's square.
    assert!((found.solution.cost - 17.014_017_289).abs() < 1e-6);
    assert!(found.infeasibility < 1e-6);
}

/// The point of a disk's corridor nearest to (2, 2): rows hold at every iterate, the answer is on them.
#[test]
fn keeps_constant_rows_and_ends_on_the_one_that_binds() {
    let problem = problem(
        vec![Variable::free("x", ""), Variable::free("y", "")],
        &[],
        |x| {
            let d = x - dvector![2.0, 2.0];
            (
                0.5 * d.norm_squared(),
                d,
                DVector::zeros(0),
                DMatrix::zeros(0, 2),
            )
        },
    );
    let row = |lower, upper| LinearRow {
        offset: 0,
        first: 0,
        width: 2,
        lower,
        upper,
    };
    let rows = LinearRows {
        table: vec![1.0, 1.0],
        rows: vec![row(-1.0, 1.0)],
        inside: None,
    };
    let found = solve(&problem, Some(&rows), &[0.3, -0.2]);
    assert!((found.solution.x - dvector![0.5, 0.5]).amax() < 1e-6);
}

/// Constraints that exclude each other: the end says so, and the least infeasible point is found.
#[test]
fn says_infeasible_where_no_point_satisfies_the_constraints() {
    let problem = problem(
        vec![Variable::free("x", "")],
        &[Set::Nonnegative, Set::Nonnegative],
        |x| {
            let g = dvector![x[0] - 2.0, 1.0 - x[0]];
            (
                x[0] * x[0],
                dvector![2.0 * x[0]],
                g,
                DMatrix::from_column_slice(2, 1, &[1.0, -1.0]),
            )
        },
    );
    let found = solve(&problem, None, &[5.0]);
    assert!(!found.solution.stop.converged());
    // Σ max(0, −g) is 1 for every x between 1 and 2.
    assert!((found.infeasibility - 1.0).abs() < 1e-6);
}
