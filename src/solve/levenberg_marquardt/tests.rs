//! Valleys, bounds, lost ranks and interrupts.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use nalgebra::{DMatrix, DVector, dmatrix, dvector};

use super::*;
use crate::fault::Fault;
use crate::problem::examples::{self, TestProblem, least_squares_form, sum_of_squares};
use crate::problem::form::Structure;
use crate::problem::{OutsideDomain, Problem};

fn run(problem: &TestProblem, start: DVector<f64>) -> Solution {
    let view = LeastSquares::try_from(problem as &dyn Problem).unwrap();
    minimize(view, &start, &Settings::default(), &Control::default()).unwrap()
}

#[test]
fn recovers_known_minimum_of_rosenbrock() {
    let solution = run(&examples::rosenbrock(), dvector![-1.2, 1.0]);
    assert!(solution.stop.converged(), "{:?}", solution.stop);
    assert!((solution.x - dvector![1.0, 1.0]).amax() <= 1e-12);
    assert!(solution.active_bounds.is_empty());
}

#[test]
fn matches_closed_form_of_rosenbrock_on_a_bound() {
    // With x <= 1/2 the minimum is at x = 1/2, y = 1/4: cost (1 - x)² / 2 = 1/8.
    let mut problem = examples::rosenbrock();
    problem.form.variables[0].upper = 0.5;
    for start in [dvector![-1.2, 1.0], dvector![0.5, -3.0], dvector![9.0, 9.0]] {
        let solution = run(&problem, start);
        assert!(solution.stop.converged(), "{:?}", solution.stop);
        assert!(
            (&solution.x - dvector![0.5, 0.25]).amax() <= 1e-7,
            "{}",
            solution.x
        );
        assert!((solution.cost - 0.125).abs() <= 1e-14);
        let active: Vec<&str> = solution
            .active_bounds
            .iter()
            .map(|b| b.variable.as_str())
            .collect();
        assert_eq!(active, ["x"]);
    }
}

#[test]
fn invariant_the_cost_never_rises_and_every_point_is_within_the_bounds() {
    let mut problem = examples::rosenbrock();
    problem.form.variables[0] = problem.form.variables[0].clone().within(-1.5, 0.9);
    let solution = run(&problem, dvector![-1.2, 1.0]);
    let costs: Vec<f64> = solution.trace.rows.iter().map(|r| r.cost).collect();
    assert!(costs.windows(2).all(|c| c[1] <= c[0]));
    assert_eq!(solution.trace.rows.len(), solution.iterations);
}

#[test]
fn a_rank_deficient_jacobian_leaves_the_undetermined_direction_near_the_start() {
    // Only the sum of both variables matters.
    let problem = examples::affine(
        dmatrix![1.0, 1.0; 2.0, 2.0; 3.0, 3.0],
        dvector![-1.0, -2.0, -3.5],
    );
    let solution = run(&problem, dvector![3.0, -1.0]);
    assert!(solution.stop.converged(), "{:?}", solution.stop);
    // Least squares: s = (1 + 4 + 10.5) / 14.
    assert!((solution.x.sum() - 15.5 / 14.0).abs() <= 1e-7);
    assert!((solution.x[0] - solution.x[1] - 4.0).abs() <= 1e-6);
}

#[test]
fn a_variable_without_effect_keeps_its_value() {
    let problem = examples::affine(dmatrix![1.0, 0.0; 1.0, 0.0], dvector![-1.0, -3.0]);
    let solution = run(&problem, dvector![0.0, 7.0]);
    assert!(solution.stop.converged());
    assert!((solution.x - dvector![2.0, 7.0]).amax() <= 1e-7);
}

/// r = log(x) - 1 with a domain x > 0; a full step from 20 would leave it.
fn logarithm() -> TestProblem {
    TestProblem {
        form: least_squares_form(&["x"], 1, Structure::Smooth),
        model: Box::new(|x| {
            if x[0] <= 0.0 {
                return Err(OutsideDomain::new("logarithm of x"));
            }
            Ok(sum_of_squares(
                dvector![x[0].ln() - 1.0],
                dmatrix![1.0 / x[0]],
            ))
        }),
        spoil: None,
    }
}

#[test]
fn a_trial_outside_the_domain_is_a_rejected_step() {
    let solution = run(&logarithm(), dvector![20.0]);
    assert!((solution.x[0] - std::f64::consts::E).abs() <= 1e-10);
    assert!(solution.trace.rows.iter().any(|row| row.step == 0.0));
}

#[test]
fn invariant_units_of_the_variables_do_not_change_the_path() {
    let reference = run(&examples::rosenbrock(), dvector![-1.2, 1.0]);
    let inner = examples::rosenbrock();
    let mut scaled = examples::rosenbrock();
    // y in thousandths: powers of two keep every product exact.
    let units = dvector![1024.0, 1.0 / 4096.0];
    for (variable, unit) in scaled.form.variables.iter_mut().zip(units.iter()) {
        variable.scale = 1.0 / unit;
    }
    let of = units.clone();
    scaled.model = Box::new(move |x| {
        let point = (inner.model)(&x.component_mul(&of))?;
        let root = point.square_root.unwrap();
        let matrix = DMatrix::from_fn(2, 2, |i, j| root.matrix[(i, j)] * of[j]);
        Ok(sum_of_squares(root.residual, matrix))
    });
    let solution = run(&scaled, dvector![-1.2, 1.0].component_div(&units));
    assert_eq!(solution.iterations, reference.iterations);
    assert_eq!(solution.x.component_mul(&units), reference.x);
}

#[test]
fn stops_for_iterations_interrupt_and_time_with_the_best_point() {
    let problem = examples::rosenbrock();
    let view = LeastSquares::try_from(&problem as &dyn Problem).unwrap();
    let start = dvector![-1.2, 1.0];
    let few = Settings {
        max_iterations: 3,
        ..Settings::default()
    };
    let seen = std::sync::Mutex::new(Vec::new());
    let watch = |row: &crate::problem::solution::TraceRow| {
        if let Ok(mut seen) = seen.lock() {
            seen.push(*row);
        }
    };
    let control = Control {
        progress: Some(&watch),
        ..Control::default()
    };
    let solution = minimize(view, &start, &few, &control).unwrap();
    assert_eq!(
        (solution.stop, solution.iterations),
        (Stop::IterationLimit, 3)
    );
    assert_eq!(*seen.lock().unwrap(), solution.trace.rows);
    assert_eq!(problem.values(&solution.x).unwrap().cost, solution.cost);

    let interrupt = Some(Arc::new(AtomicBool::new(true)));
    let control = Control {
        interrupt,
        ..Control::default()
    };
    let solution = minimize(view, &start, &Settings::default(), &control).unwrap();
    assert_eq!(solution.stop, Stop::Interrupted);
    assert_eq!(solution.x, start);

    let time_limit = Some(std::time::Duration::ZERO);
    let control = Control {
        time_limit,
        ..Control::default()
    };
    let solution = minimize(view, &start, &Settings::default(), &control).unwrap();
    assert_eq!(solution.stop, Stop::TimeLimit);
}

#[test]
fn refuses_bad_starts_and_settings_by_name() {
    let problem = logarithm();
    let view = LeastSquares::try_from(&problem as &dyn Problem).unwrap();
    let code = |start: DVector<f64>, settings: Settings| {
        let error = minimize(view, &start, &settings, &Control::default()).unwrap_err();
        error.describe().code
    };
    assert_eq!(
        code(dvector![1.0, 2.0], Settings::default()),
        "start-length"
    );
    assert_eq!(
        code(dvector![f64::NAN], Settings::default()),
        "start-not-finite"
    );
    assert_eq!(
        code(dvector![-1.0], Settings::default()),
        "start-outside-domain"
    );
    let settings = Settings {
        cost_tolerance: -1.0,
        ..Settings::default()
    };
    assert_eq!(code(dvector![1.0], settings), "setting-out-of-range");
    let mut problem = logarithm();
    problem.model = Box::new(|_| Ok(sum_of_squares(dvector![f64::NAN], dmatrix![1.0])));
    let view = LeastSquares::try_from(&problem as &dyn Problem).unwrap();
    let error = minimize(
        view,
        &dvector![1.0],
        &Settings::default(),
        &Control::default(),
    );
    assert_eq!(error.unwrap_err().describe().code, "model-not-finite");
}
