//! The interior-point method against closed forms and an independent barrier method.

use super::*;
use crate::linalg::svec;
use crate::linalg::triangular::Triangular;
use crate::problem::Problem;
use crate::problem::examples::{self, TestProblem, least_squares_form, sum_of_squares};
use crate::problem::form::{Constraint, Set, Structure, Variable};
use nalgebra::{Cholesky, DMatrix, dmatrix, dvector};

fn run(problem: &dyn Problem, start: &DVector<f64>, terms: &Terms) -> InteriorSolution {
    let view = ConeProgram::try_from(problem).unwrap();
    let settings = Settings::default();
    solve(view, start, &settings, terms, &Control::default()).unwrap()
}

/// Noisy observations of symmetric 4 x 4 matrices; every third true one has rank two. `unseen` of the ten
/// entries of every matrix are not observed.
pub(super) fn matrices(count: usize, unseen: usize, seed: u64) -> TestProblem {
    let entries = 10 * count;
    let mut state = seed | 1;
    let mut uniform = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
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
    let mut regressor = DMatrix::from_fn(3 * entries, entries, |_, _| uniform());
    for body in 0..count {
        for k in 0..unseen {
            // Entries of the last column: of what they are, the cone has the say.
            regressor.column_mut(10 * body + 9 - k).fill(0.0);
        }
    }
    let noise = DVector::from_fn(3 * entries, |_, _| uniform());
    let measured = &regressor * truth + noise;
    let names: Vec<String> = (0..entries).map(|i| format!("p{i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut form = least_squares_form(&names, 3 * entries, Structure::Affine);
    form.constraints = (0..count).map(psd).collect();
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

fn psd(index: usize) -> Constraint {
    Constraint {
        name: format!("matrix {index}"),
        unit: String::new(),
        rows: 10,
        set: Set::Psd { order: 4 },
    }
}

fn block(x: &DVector<f64>, index: usize) -> DMatrix<f64> {
    svec::smat(x.rows(10 * index, 10).as_slice())
}

fn is_inside(x: &DVector<f64>) -> bool {
    (0..x.len() / 10).all(|k| Cholesky::new(block(x, k)).is_some())
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
fn matches_an_independent_barrier_method_on_matrices_seen_through_noise() {
    for count in [1, 4, 9] {
        let problem = matrices(count, 0, 7 + count as u64);
        let start = DVector::zeros(10 * count);
        let found = run(&problem, &start, &Terms::default());
        assert_eq!(found.solution.stop, Stop::Optimal);
        assert!(is_inside(&found.solution.x));
        let root = problem.linearize(&start).unwrap().square_root.unwrap();
        let compressed = Triangular::of_system(&root.matrix, &(-&root.residual));
        let system = compressed.system().unwrap();
        let rest = 0.5 * system.rest * system.rest;
        let expected = rest + barrier_optimum(&system.matrix, &-&system.right, count);
        // Gap of the barrier: 4 · 1e-12 for every matrix and its last reduction.
        let cost = found.solution.cost;
        assert!(
            (cost - expected).abs() <= 1e-8 * cost,
            "{count}: {cost} {expected}"
        );
        assert!(found.gap <= 1e-10 * cost);
        assert!(cost > rest + 1e-3, "the constraints must matter");
    }
}

#[test]
fn matches_closed_form_of_the_nearest_semidefinite_matrix() {
    let found = run(
        &examples::nearest_psd(),
        &DVector::zeros(3),
        &Terms::default(),
    );
    assert_eq!(found.solution.stop, Stop::Optimal);
    let cost = found.solution.cost;
    assert!((cost - 0.5).abs() <= 1e-8, "{cost}");
    // The cost is flat to first order in the gap, the matrix only to its root.
    assert!((found.solution.x - dvector![1.5, 1.5, 1.5]).amax() <= 1e-5);
}

#[test]
fn matches_closed_form_of_the_largest_smallest_eigenvalue() {
    // At x0 = 1/2 the eigenvalues are 2, 2, 2.
    let start = dvector![0.1, 0.0];
    let found = run(&examples::max_min_eigenvalue(), &start, &Terms::default());
    assert_eq!(found.solution.stop, Stop::Optimal);
    let cost = found.solution.cost;
    assert!((cost + 2.0).abs() <= 1e-8, "{cost}");
    assert!((found.solution.x - dvector![0.5, 2.0]).amax() <= 1e-7);
}

/// ½ (x − 3)² with extra rows over (x, y) that are not negative; y is seen by the rows only.
fn with_rows(rows: DMatrix<f64>, offset: DVector<f64>) -> TestProblem {
    let mut form = least_squares_form(&["x", "y"], 1, Structure::Affine);
    form.constraints.push(Constraint {
        name: "rows".to_string(),
        unit: String::new(),
        rows: rows.nrows(),
        set: Set::Nonnegative,
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
    let band = with_rows(dmatrix![-1.0, 1.0; 0.0, -1.0], dvector![-1.0, 5.0]);
    let found = run(&band, &dvector![0.0, 0.0], &Terms::default());
    assert!(found.solution.stop.converged());
    let x = &found.solution.x;
    assert!((x[0] - 3.0).abs() <= 1e-6 && found.solution.cost <= 1e-10);
    assert!((4.0..=5.0).contains(&x[1]), "{}", x[1]);
}

#[test]
fn tells_infeasible_problems() {
    // y >= 1 and y <= 0.
    let empty = with_rows(dmatrix![0.0, 1.0; 0.0, -1.0], dvector![-1.0, 0.0]);
    let found = run(&empty, &dvector![0.0, 0.0], &Terms::default());
    assert_eq!(found.solution.stop, Stop::Infeasible);
}

#[test]
fn stops_when_asked_to() {
    let flag = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(true));
    let control = Control {
        interrupt: Some(flag),
        ..Control::default()
    };
    let problem = matrices(2, 0, 5);
    let view = ConeProgram::try_from(&problem as &dyn Problem).unwrap();
    let (start, settings) = (DVector::zeros(20), Settings::default());
    let found = solve(view, &start, &settings, &Terms::default(), &control).unwrap();
    assert_eq!(found.solution.stop, Stop::Interrupted);
}

#[test]
fn invariant_gradient_and_multipliers_balance_and_complement() {
    let problem = matrices(3, 0, 3);
    let found = run(&problem, &DVector::zeros(30), &Terms::default());
    let model = problem.linearize(&found.solution.x).unwrap();
    let balance = &model.gradient - model.jacobian.tr_mul(&found.multipliers);
    assert!(balance.amax() <= 1e-4 * model.gradient.amax());
    let product = found.multipliers.dot(&model.constraints);
    assert!((product - found.gap).abs() <= 1e-12 * model.cost);
}

/// Where the infimum is at infinity matrices grow large and nearly singular: they are inside by more than the rounding
/// of whoever looks at them next.
#[test]
fn strictly_inside_where_entries_are_not_observed() {
    for (seed, unseen) in (1..=40).zip((3..=6).cycle()) {
        let problem = matrices(5, unseen, seed);
        let found = run(&problem, &DVector::zeros(50), &Terms::default());
        assert_eq!(found.solution.stop, Stop::Optimal, "{seed}");
        for k in 0..5 {
            let matrix = block(&found.solution.x, k);
            let rounding = 4.0 * f64::EPSILON * matrix.amax();
            let within = matrix - DMatrix::identity(4, 4) * rounding;
            assert!(Cholesky::new(within).is_some(), "{seed}, matrix {k}");
        }
    }
}

#[test]
fn matches_closed_form_of_the_log_determinant() {
    // ½‖X − A‖² − γ log det X: X = V diag((a + sqrt(a² + 4γ))/2) Vᵀ with A = V diag(a) Vᵀ.
    let target =
        dmatrix![1.0, 2.0, 0.0, 0.0; 2.0, -1.0, 0.5, 0.0; 0.0, 0.5, 3.0, 0.1; 0.0, 0.0, 0.1, 0.2];
    let offset = -svec::svec(&target);
    let gamma = 0.3;
    let mut problem = examples::affine(DMatrix::identity(10, 10), offset.clone());
    problem.form.constraints = vec![psd(0)];
    problem.model = Box::new(move |x| {
        let mut model = sum_of_squares(x + &offset, DMatrix::identity(10, 10));
        model.constraints = x.clone();
        model.jacobian = DMatrix::identity(10, 10);
        Ok(model)
    });
    let terms = Terms {
        log_det: vec![gamma],
        ..Terms::default()
    };
    let found = run(&problem, &DVector::zeros(10), &terms);
    assert_eq!(found.solution.stop, Stop::Optimal);
    let eigen = target.symmetric_eigen();
    let values = eigen
        .eigenvalues
        .map(|a| 0.5 * (a + (a * a + 4.0 * gamma).sqrt()));
    let expected =
        &eigen.eigenvectors * DMatrix::from_diagonal(&values) * eigen.eigenvectors.transpose();
    // Gap 1e-10 of a cost of order one, quadratic in the distance.
    assert!((block(&found.solution.x, 0) - expected).amax() <= 1e-4);
}

#[test]
fn bounds_hold_strictly_and_a_linear_term_shrinks() {
    // ½(x + 1)² + ½(y − 2)² + ½ y for x, y >= 0: x = 0, y = 1.5.
    let mut problem = examples::affine(DMatrix::identity(2, 2), dvector![1.0, -2.0]);
    for variable in &mut problem.form.variables {
        *variable = Variable::free("v", "").within(0.0, f64::INFINITY);
    }
    let terms = Terms {
        linear: dvector![0.0, 0.5],
        log_det: Vec::new(),
    };
    let found = run(&problem, &dvector![1.0, 1.0], &terms);
    assert_eq!(found.solution.stop, Stop::Optimal);
    let x = &found.solution.x;
    assert!(x[0] > 0.0 && x[0] <= 1e-6, "{}", x[0]);
    assert!((x[1] - 1.5).abs() <= 1e-5, "{}", x[1]);
}

#[test]
fn refuses_an_equality_and_a_large_block() {
    for set in [Set::Zero, Set::Psd { order: 5 }] {
        let rows = if set == Set::Zero { 1 } else { 15 };
        let mut problem = examples::affine(DMatrix::identity(15, 15), DVector::zeros(15));
        problem.form.constraints = vec![Constraint {
            name: "g".to_string(),
            unit: String::new(),
            rows,
            set,
        }];
        problem.model = Box::new(move |x| {
            let mut model = sum_of_squares(x.clone(), DMatrix::identity(15, 15));
            model.constraints = x.rows(0, rows).into_owned();
            model.jacobian = DMatrix::identity(rows, 15);
            Ok(model)
        });
        let view = ConeProgram::try_from(&problem as &dyn Problem).unwrap();
        let (settings, terms) = (Settings::default(), Terms::default());
        let start = DVector::zeros(15);
        assert!(solve(view, &start, &settings, &terms, &Control::default()).is_err());
    }
}

#[test]
fn invariant_the_same_bits_on_every_run() {
    let x = || {
        run(&matrices(2, 1, 5), &DVector::zeros(20), &Terms::default())
            .solution
            .x
    };
    assert_eq!(x(), x());
}

/// Four matrices [A h; hᵀ m] of which m is not seen, with A that is not possible and h that is not zero: the infimum lies at
/// m without bound, where a weak pull ends the search at 1e6 times the entries that are seen.
fn runaway(seed: u64) -> TestProblem {
    const COUNT: usize = 4;
    const ROWS: usize = 200;
    let n = 10 * COUNT;
    let mut state = (seed * 7919) | 1;
    let mut uniform = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let mut mix = DMatrix::from_fn(9 * COUNT, n, |_, _| uniform());
    for body in 0..COUNT {
        mix.column_mut(10 * body + 9).fill(0.0);
    }
    let seen = DMatrix::from_fn(ROWS, 9 * COUNT, |_, _| 100.0 * uniform()) * mix;
    let mut truth = DVector::zeros(n);
    let mut start = DVector::zeros(n);
    for body in 0..COUNT {
        let mut matrix = DMatrix::from_diagonal(&dvector![-0.6, -0.6, -0.6, 0.0]);
        for _ in 0..2 {
            let point = dvector![uniform(), uniform(), uniform(), 1.0];
            matrix += &point * point.transpose() * (0.8 + 0.5 * uniform());
        }
        let rows = svec::svec(&matrix);
        truth.rows_mut(10 * body, 10).copy_from(&rows);
        let identity = svec::svec(&DMatrix::identity(4, 4));
        start.rows_mut(10 * body, 10).copy_from(&identity);
    }
    let measured = &seen * truth + DVector::from_fn(ROWS, |_, _| 30.0 * uniform());
    let pull = DMatrix::identity(n, n) * 1e-6;
    let mut matrix = seen.resize_vertically(ROWS + n, 0.0);
    matrix.rows_mut(ROWS, n).copy_from(&pull);
    let mut right = measured.resize_vertically(ROWS + n, 0.0);
    right.rows_mut(ROWS, n).copy_from(&(pull * start));
    let names: Vec<String> = (0..n).map(|i| format!("p{i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut form = least_squares_form(&names, ROWS + n, Structure::Affine);
    form.constraints = (0..COUNT).map(psd).collect();
    TestProblem {
        form,
        model: Box::new(move |x| {
            let mut model = sum_of_squares(&matrix * x - &right, matrix.clone());
            let identity = svec::svec(&DMatrix::identity(4, 4)) * SHORTFALL;
            model.constraints = DVector::from_fn(n, |k, _| x[k] - identity[k % 10]);
            model.jacobian = DMatrix::identity(n, n);
            Ok(model)
        }),
        spoil: None,
    }
}

const SHORTFALL: f64 = 5e-9;

/// Rounding of S is worth 1e-6 of the cost there: without the room of the margin no answer is as good as the tolerance.
#[test]
fn certified_to_the_tolerance_where_matrices_grow_without_bound() {
    let settings = Settings {
        shortfall: SHORTFALL,
        ..Settings::default()
    };
    for seed in 1..=20 {
        let problem = runaway(seed);
        let start = DVector::from_fn(40, |k, _| {
            f64::from(u8::from([0, 2, 5, 9].contains(&(k % 10))))
        });
        let view = ConeProgram::try_from(&problem as &dyn Problem).unwrap();
        let terms = Terms::default();
        let found = solve(view, &start, &settings, &terms, &Control::default()).unwrap();
        assert_eq!(found.solution.stop, Stop::Optimal, "{seed}");
        let share = found.gap / found.solution.cost;
        assert!(share <= settings.tolerance, "{seed}: {share:.1e}");
        assert!(
            found.solution.x.amax() > 1e4,
            "{seed}: the problem is to run away"
        );
        assert!(is_inside(&found.solution.x), "{seed}");
    }
}
