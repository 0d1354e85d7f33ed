//! Small semidefinite programs with known optima, and against a barrier method of its own.

use nalgebra::{Cholesky, dmatrix, dvector};

use super::*;
use crate::problem::Problem;
use crate::problem::examples::{self, TestProblem, least_squares_form, sum_of_squares};
use crate::problem::form::{Constraint, Structure, Variable};

fn run(problem: &TestProblem, start: DVector<f64>) -> ConicSolution {
    let view = ConeProgram::try_from(problem as &dyn Problem).unwrap();
    solve(view, &start, &Settings::default(), &Control::default()).unwrap()
}

#[test]
fn matches_closed_form_of_the_nearest_semidefinite_matrix() {
    let found = run(&examples::nearest_psd(), dvector![0.0, 0.0, 0.0]);
    assert_eq!(found.solution.stop, Stop::Optimal);
    // The cost is flat to first order in the gap, the matrix only to its root.
    assert!(
        (found.solution.cost - 0.5).abs() <= 1e-8,
        "{}",
        found.solution.cost
    );
    assert!((found.solution.x - dvector![1.5, 1.5, 1.5]).amax() <= 1e-5);
    assert!(found.gap <= 1e-8 && found.margin >= -1e-8);
}

#[test]
fn matches_closed_form_of_the_largest_smallest_eigenvalue() {
    // At x0 = 1/2 the eigenvalues are 2, 2, 2.
    let found = run(&examples::max_min_eigenvalue(), dvector![0.1, 0.0]);
    assert_eq!(found.solution.stop, Stop::Optimal);
    assert!((found.solution.cost + 2.0).abs() <= 1e-8);
    assert!((found.solution.x - dvector![0.5, 2.0]).amax() <= 1e-7);
}

#[test]
fn a_feasible_least_squares_solution_is_returned_as_it_is() {
    let mut problem = examples::nearest_psd();
    problem.model = Box::new(|x| {
        let svec = DMatrix::from_diagonal(&dvector![1.0, 2f64.sqrt(), 1.0]);
        let mut model = sum_of_squares(&svec * (x - dvector![2.0, 0.5, 1.0]), svec.clone());
        model.constraints = &svec * x;
        model.jacobian = svec;
        Ok(model)
    });
    let found = run(&problem, dvector![5.0, 5.0, 5.0]);
    assert!((found.solution.x - dvector![2.0, 0.5, 1.0]).amax() <= 1e-14);
    assert_eq!((found.solution.iterations, found.gap), (0, 0.0));
}

/// min 1/2 (x - 3)² with extra rows over (x, y); y is seen by the rows only.
fn with_rows(rows: DMatrix<f64>, offset: DVector<f64>, set: Set) -> TestProblem {
    let mut form = least_squares_form(&["x", "y"], 1, Structure::Affine);
    form.constraints.push(Constraint {
        name: "rows".to_string(),
        unit: String::new(),
        rows: rows.nrows(),
        set,
    });
    TestProblem {
        form,
        model: Box::new(move |x| {
            let mut model = sum_of_squares(dvector![x[0] - 3.0], dmatrix![1.0, 0.0]);
            model.constraints = &rows * x + &offset;
            model.jacobian = rows.clone();
            Ok(model)
        }),
        spoil: None,
    }
}

#[test]
fn constraints_decide_where_the_residual_does_not_see() {
    // x = 3 needs y >= 4 and y <= 5: feasible at no cost, though the start violates both.
    let band = with_rows(
        dmatrix![-1.0, 1.0; 0.0, -1.0],
        dvector![-1.0, 5.0],
        Set::Nonnegative,
    );
    let found = run(&band, dvector![0.0, 0.0]);
    assert!(found.solution.stop.converged());
    assert!((found.solution.x[0] - 3.0).abs() <= 1e-6);
    assert!(found.solution.cost <= 1e-10 && found.margin >= -1e-8);
    // x + y = 1 with y = 0 forced by bounds: x = 1 at cost 2.
    let mut line = with_rows(dmatrix![1.0, 1.0], dvector![-1.0], Set::Zero);
    line.form.variables[1] = Variable::free("y", "").within(0.0, 0.0);
    let found = run(&line, dvector![0.0, 0.0]);
    assert!(
        (found.solution.cost - 2.0).abs() <= 1e-7,
        "{}",
        found.solution.cost
    );
    assert_eq!(found.solution.active_bounds[0].variable, "y");
}

#[test]
fn tells_infeasible_and_unbounded_problems() {
    let empty = with_rows(
        dmatrix![0.0, 1.0; 0.0, -1.0],
        dvector![-1.0, 0.0],
        Set::Nonnegative,
    );
    assert_eq!(
        run(&empty, dvector![0.0, 0.0]).solution.stop,
        Stop::Infeasible
    );
    let mut falling = examples::max_min_eigenvalue();
    falling.form.constraints.clear();
    let inner = examples::max_min_eigenvalue();
    falling.model = Box::new(move |x| {
        let mut model = (inner.model)(x)?;
        model.constraints = DVector::zeros(0);
        model.jacobian = DMatrix::zeros(0, 2);
        Ok(model)
    });
    assert_eq!(
        run(&falling, dvector![0.0, 0.0]).solution.stop,
        Stop::Unbounded
    );
}

/// Pseudo-inertias of `bodies` bodies as symmetric 4 x 4 matrices, ten entries each, seen through a
/// regressor with noise; every third true body is two point masses, so its matrix has rank two.
fn bodies(count: usize) -> TestProblem {
    let entries = 10 * count;
    let mut state = 88_172_645_463_325_252_u64;
    let mut uniform = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let mut truth = DVector::zeros(entries);
    for body in 0..count {
        let mut matrix = DMatrix::zeros(4, 4);
        for _ in 0..if body % 3 == 0 { 2 } else { 6 } {
            let point = dvector![0.2 * uniform(), 0.2 * uniform(), 0.2 * uniform(), 1.0];
            matrix += &point * point.transpose() * (0.8 + 0.5 * uniform());
        }
        truth
            .rows_mut(10 * body, 10)
            .copy_from(&svec::svec(&matrix));
    }
    let regressor = DMatrix::from_fn(20 * entries, entries, |_, _| uniform());
    let noise = DVector::from_fn(20 * entries, |_, _| uniform());
    let measured = &regressor * truth + noise;
    let names: Vec<String> = (0..entries).map(|i| format!("p{i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut form = least_squares_form(&names, 20 * entries, Structure::Affine);
    form.constraints = (0..count)
        .map(|body| Constraint {
            name: format!("body{body}"),
            unit: "kg".to_string(),
            rows: 10,
            set: Set::Psd { order: 4 },
        })
        .collect();
    TestProblem {
        form,
        model: Box::new(move |x| {
            let mut model = sum_of_squares(&regressor * x - &measured, regressor.clone());
            model.constraints = x.clone();
            model.jacobian = DMatrix::identity(x.len(), x.len());
            Ok(model)
        }),
        spoil: None,
    }
}

/// The optimum by Newton's method on f(x) - mu Σ log det S_k, S_k = smat of ten entries of x, to mu = 1e-12.
///
/// Its point is strictly feasible and its cost exceeds the optimum by at most 4 mu per body.
fn barrier_optimum(matrix: &DMatrix<f64>, offset: &DVector<f64>, count: usize) -> f64 {
    let basis: Vec<DMatrix<f64>> = (0..10)
        .map(|i| svec::smat(DVector::from_fn(10, |k, _| if k == i { 1.0 } else { 0.0 }).as_slice()))
        .collect();
    let factor =
        |x: &DVector<f64>, body: usize| Cholesky::new(svec::smat(x.rows(10 * body, 10).as_slice()));
    let mut x = DVector::zeros(10 * count);
    for body in 0..count {
        x.rows_mut(10 * body, 10)
            .copy_from(&svec::svec(&DMatrix::identity(4, 4)));
    }
    let hessian = matrix.tr_mul(matrix);
    let mut mu = 1.0;
    while mu > 1e-12 {
        for _ in 0..30 {
            let mut gradient = matrix.tr_mul(&(matrix * &x + offset));
            let mut curvature = hessian.clone();
            for body in 0..count {
                let inverse = factor(&x, body).unwrap().inverse();
                let products: Vec<DMatrix<f64>> = basis.iter().map(|b| &inverse * b).collect();
                for i in 0..10 {
                    gradient[10 * body + i] -= mu * products[i].trace();
                    for j in 0..10 {
                        curvature[(10 * body + i, 10 * body + j)] +=
                            mu * (&products[i] * &products[j]).trace();
                    }
                }
            }
            let step = Cholesky::new(curvature).unwrap().solve(&-&gradient);
            let mut length = 1.0;
            while (0..count).any(|body| factor(&(&x + length * &step), body).is_none()) {
                length *= 0.7;
            }
            x += if length < 1.0 { 0.9 * length } else { 1.0 } * &step;
            if -gradient.dot(&step) <= 1e-3 * mu {
                break;
            }
        }
        mu *= 0.2;
    }
    0.5 * (matrix * &x + offset).norm_squared()
}

#[test]
fn matches_an_independent_barrier_method_for_rigid_bodies() {
    for count in [3, 7] {
        let problem = bodies(count);
        let start = DVector::zeros(10 * count);
        let found = run(&problem, start.clone());
        assert!(found.solution.stop.converged(), "{:?}", found.solution.stop);
        let model = problem.linearize(&start).unwrap();
        let root = model.square_root.unwrap();
        let compressed =
            crate::linalg::triangular::Triangular::of_system(&root.matrix, &(-&root.residual));
        let system = compressed.system().unwrap();
        let rest = 0.5 * system.rest * system.rest;
        let expected = rest + barrier_optimum(&system.matrix, &-&system.right, count);
        // Gap of the barrier: 4 bodies · 1e-12 and its last reduction; of the conic method: 1e-10 relative.
        let difference = found.solution.cost - expected;
        assert!(difference.abs() <= 1e-8, "{count}: {difference:e}");
        assert!(
            found.solution.cost > rest + 1e-3,
            "the constraints must matter"
        );
        assert!(found.margin >= -1e-9, "{count}: {:e}", found.margin);
        assert!(found.gap <= 1e-8, "{count}: {:e}", found.gap);
    }
}

#[test]
fn invariant_the_same_bits_on_every_run() {
    let first = run(&bodies(2), DVector::zeros(20)).solution.x;
    assert_eq!(run(&bodies(2), DVector::zeros(20)).solution.x, first);
}

#[test]
fn stops_when_asked_to() {
    let flag = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(true));
    let control = Control {
        interrupt: Some(flag),
        ..Control::default()
    };
    let problem = bodies(2);
    let view = ConeProgram::try_from(&problem as &dyn Problem).unwrap();
    let found = solve(view, &DVector::zeros(20), &Settings::default(), &control).unwrap();
    assert_eq!(found.solution.stop, Stop::Interrupted);
}
