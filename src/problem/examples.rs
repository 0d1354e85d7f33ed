//! Example problems on which everything generic is tested: sums of squares, linear costs, rows and cones.

use nalgebra::{DMatrix, DVector, dmatrix, dvector};

use crate::problem::form::{Constraint, Form, Objective, Set, Structure, Variable};
use crate::problem::{Linearization, OutsideDomain, Problem, SquareRoot, Values};

type Model = Box<dyn Fn(&DVector<f64>) -> Result<Linearization, OutsideDomain> + Sync>;

/// A problem given by its form and its linearisation.
pub(crate) struct TestProblem {
    pub form: Form,
    pub model: Model,
    /// Changes every linearisation, so that a test can plant a mistake.
    pub spoil: Option<fn(&mut Linearization)>,
}

/// A problem with a point at which it has values and derivatives.
pub(crate) struct Example {
    pub name: &'static str,
    pub problem: Box<dyn Problem>,
    pub start: DVector<f64>,
}

impl Problem for TestProblem {
    fn form(&self) -> &Form {
        &self.form
    }

    fn values(&self, x: &DVector<f64>) -> Result<Values, OutsideDomain> {
        let model = (self.model)(x)?;
        Ok(Values {
            cost: model.cost,
            constraints: model.constraints,
        })
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, OutsideDomain> {
        let mut model = (self.model)(x)?;
        if let Some(spoil) = self.spoil {
            spoil(&mut model);
        }
        Ok(model)
    }
}

/// The linearisation of 1/2 |r|^2 without constraints.
pub(crate) fn sum_of_squares(residual: DVector<f64>, matrix: DMatrix<f64>) -> Linearization {
    Linearization {
        cost: 0.5 * residual.norm_squared(),
        gradient: matrix.tr_mul(&residual),
        constraints: DVector::zeros(0),
        jacobian: DMatrix::zeros(0, matrix.ncols()),
        square_root: Some(SquareRoot { matrix, residual }),
    }
}

/// Unbounded variables of these names, a sum of squares without constraints.
pub(crate) fn least_squares_form(names: &[&str], rows: usize, structure: Structure) -> Form {
    Form {
        variables: names.iter().map(|n| Variable::free(*n, "")).collect(),
        objective: Objective::SumOfSquares { rows },
        constraints: Vec::new(),
        structure,
    }
}

/// The affine least squares problem |matrix x + offset|^2 / 2.
pub(crate) fn affine(matrix: DMatrix<f64>, offset: DVector<f64>) -> TestProblem {
    let names: Vec<String> = (0..matrix.ncols()).map(|j| format!("x{j}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    TestProblem {
        form: least_squares_form(&names, matrix.nrows(), Structure::Affine),
        model: Box::new(move |x| Ok(sum_of_squares(&matrix * x + &offset, matrix.clone()))),
        spoil: None,
    }
}

/// Rosenbrock's valley, r = (10 (y - x^2), 1 - x), with its minimum 0 at (1, 1).
pub(crate) fn rosenbrock() -> TestProblem {
    TestProblem {
        form: least_squares_form(&["x", "y"], 2, Structure::Smooth),
        model: Box::new(|v| {
            let (x, y) = (v[0], v[1]);
            let matrix = dmatrix![-20.0 * x, 10.0; -1.0, 0.0];
            Ok(sum_of_squares(
                dvector![10.0 * (y - x * x), 1.0 - x],
                matrix,
            ))
        }),
        spoil: None,
    }
}

/// The symmetric matrix ((a, b), (b, c)) >= 0 nearest to ((1, 2), (2, 1)) in the Frobenius norm.
///
/// The eigenvalues of the target are 3 and -1, so the optimum is 3/2 ((1, 1), (1, 1)) at cost 1/2.
pub(crate) fn nearest_psd() -> TestProblem {
    let mut form = least_squares_form(&["a", "b", "c"], 3, Structure::Affine);
    form.constraints.push(Constraint {
        name: "matrix".to_string(),
        unit: String::new(),
        rows: 3,
        set: Set::Psd { order: 2 },
    });
    TestProblem {
        form,
        model: Box::new(|x| {
            let svec = DMatrix::from_diagonal(&dvector![1.0, 2f64.sqrt(), 1.0]);
            let residual = &svec * (x - dvector![1.0, 2.0, 1.0]);
            let mut model = sum_of_squares(residual, svec.clone());
            model.constraints = &svec * x;
            model.jacobian = svec;
            Ok(model)
        }),
        spoil: None,
    }
}

/// Maximise t subject to x0 A + (1 - x0) B - t I >= 0 and 0 <= x0 <= 1, A = diag(1, 2, 3), B = diag(3, 2, 1).
///
/// The smallest eigenvalue is min(3 - 2 x0, 2, 1 + 2 x0), so t = 2 at x0 = 1/2: cost -2.
pub(crate) fn max_min_eigenvalue() -> TestProblem {
    TestProblem {
        form: Form {
            variables: vec![
                Variable::free("x0", "").within(0.0, 1.0),
                Variable::free("t", ""),
            ],
            objective: Objective::Smooth,
            constraints: vec![Constraint {
                name: "information".to_string(),
                unit: String::new(),
                rows: 6,
                set: Set::Psd { order: 3 },
            }],
            structure: Structure::Affine,
        },
        model: Box::new(|x| {
            // svec rows of a diagonal matrix of order 3: diagonal entries are rows 0, 2 and 5.
            let mut jacobian = DMatrix::zeros(6, 2);
            let mut offset = DVector::zeros(6);
            for (row, (a, b)) in [(0, (1.0, 3.0)), (2, (2.0, 2.0)), (5, (3.0, 1.0))] {
                jacobian[(row, 0)] = a - b;
                jacobian[(row, 1)] = -1.0;
                offset[row] = b;
            }
            Ok(Linearization {
                cost: -x[1],
                gradient: dvector![0.0, -1.0],
                square_root: None,
                constraints: &jacobian * x + offset,
                jacobian,
            })
        }),
        spoil: None,
    }
}

/// A smooth cost with smooth rows: x0 log x1 + x1^2 with x0 x1 >= 1 and x0^2 + x1^2 = 4, x1 > 0.
pub(crate) fn smooth_rows() -> TestProblem {
    let constraint = |name: &str, set| Constraint {
        name: name.to_string(),
        unit: String::new(),
        rows: 1,
        set,
    };
    TestProblem {
        form: Form {
            variables: vec![Variable::free("x0", "m"), Variable::free("x1", "m")],
            objective: Objective::Smooth,
            constraints: vec![
                constraint("product", Set::Nonnegative),
                constraint("circle", Set::Zero),
            ],
            structure: Structure::Smooth,
        },
        model: Box::new(|x| {
            let (a, b) = (x[0], x[1]);
            if b <= 0.0 {
                return Err(OutsideDomain::new("logarithm of x1"));
            }
            Ok(Linearization {
                cost: a * b.ln() + b * b,
                gradient: dvector![b.ln(), a / b + 2.0 * b],
                square_root: None,
                constraints: dvector![a * b - 1.0, a * a + b * b - 4.0],
                jacobian: dmatrix![b, a; 2.0 * a, 2.0 * b],
            })
        }),
        spoil: None,
    }
}

/// Every example.
pub(crate) fn all() -> Vec<Example> {
    let line = affine(
        dmatrix![1.0, 0.0; 1.0, 1.0; 1.0, 2.0],
        dvector![-1.0, -2.5, -4.5],
    );
    let example = |name, problem: TestProblem, start| Example {
        name,
        problem: Box::new(problem),
        start,
    };
    vec![
        example("line", line, dvector![0.4, -0.3]),
        example("rosenbrock", rosenbrock(), dvector![-1.2, 1.0]),
        example("nearest_psd", nearest_psd(), dvector![0.3, -0.7, 0.2]),
        example(
            "max_min_eigenvalue",
            max_min_eigenvalue(),
            dvector![0.2, -1.0],
        ),
        example("smooth_rows", smooth_rows(), dvector![1.3, 0.9]),
    ]
}
