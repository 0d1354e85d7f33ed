//! Semidefinite fits of 7 and 30 links after compression, set-up included: minimise ‖R x − z‖² with every
//! 4 x 4 pseudo-inertia positive semidefinite and friction that brakes.
//!
//! R and z are not shipped: `EXID_SDP` names the folder with `sdp7/R.npy`, `sdp7/z.npy`, and the same for the
//! cases 7a, 30 and 30a. Status, objective and smallest eigenvalue of every case are printed first.

use criterion::{Criterion, criterion_group, criterion_main};
use exid::linalg::svec::svec;
use exid::problem::form::{Constraint, Form, Objective, Set, Structure, Variable};
use exid::problem::solution::Control;
use exid::problem::view::ConeProgram;
use exid::problem::{Linearization, OutsideDomain, Problem, SquareRoot, Values};
use exid::robot::inertia::Inertia;
use exid::solve::interior::{InteriorSolution, Settings, Terms, solve};
use nalgebra::{DMatrix, DVector};
use std::fs;
use std::hint::black_box;
use std::path::Path;

const CASES: [(&str, usize); 4] = [("7", 7), ("7a", 7), ("30", 30), ("30a", 30)];

struct Fit {
    form: Form,
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    slopes: DMatrix<f64>,
}

/// Numbers of a file of NumPy, eight bytes each, after its header.
fn numbers(file: &Path) -> Vec<f64> {
    let bytes = fs::read(file).expect("a case that was written by the script of the peers");
    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let rest = bytes[header..].chunks_exact(8);
    rest.map(|b| f64::from_le_bytes(b.try_into().expect("eight bytes")))
        .collect()
}

fn pseudo_inertia(parameters: &[f64]) -> DVector<f64> {
    let body = Inertia(std::array::from_fn(|k| parameters[k]));
    svec(&DMatrix::from_column_slice(
        4,
        4,
        body.pseudo_inertia().as_slice(),
    ))
}

impl Fit {
    fn read(folder: &Path, links: usize) -> Self {
        let right = DVector::from_vec(numbers(&folder.join("z.npy")));
        let entries = numbers(&folder.join("R.npy"));
        let matrix = DMatrix::from_row_slice(right.len(), 12 * links, &entries);
        let mut slopes = DMatrix::zeros(10 * links, 12 * links);
        for k in 0..10 * links {
            let mut unit = [0.0; 10];
            unit[k % 10] = 1.0;
            let first = k - k % 10;
            slopes
                .view_mut((first, k), (10, 1))
                .copy_from(&pseudo_inertia(&unit));
        }
        let variable = |k: usize| {
            let free = Variable::free("parameter", "");
            if k < 10 * links {
                free
            } else {
                free.within(0.0, f64::INFINITY)
            }
        };
        let block = |_| Constraint {
            name: "pseudo-inertia".to_string(),
            unit: "kg".to_string(),
            rows: 10,
            set: Set::Psd { order: 4 },
        };
        Self {
            form: Form {
                variables: (0..12 * links).map(variable).collect(),
                objective: Objective::SumOfSquares { rows: right.len() },
                constraints: (0..links).map(block).collect(),
                structure: Structure::Affine,
            },
            matrix,
            right,
            slopes,
        }
    }

    /// Bodies of one kilogramme and friction of one.
    fn start(&self) -> DVector<f64> {
        let mut x = DVector::from_element(self.matrix.ncols(), 1.0);
        for k in 0..self.slopes.nrows() / 10 {
            let body = [1.0, 0.0, 0.0, 0.0, 0.02, 0.0, 0.02, 0.0, 0.0, 0.02];
            x.rows_mut(10 * k, 10).copy_from_slice(&body);
        }
        x
    }

    fn solve(&self) -> InteriorSolution {
        let view = ConeProgram::try_from(self as &dyn Problem).expect("an affine problem");
        let (settings, terms) = (Settings::default(), Terms::default());
        solve(view, &self.start(), &settings, &terms, &Control::default())
            .expect("a finite problem")
    }
}

impl Problem for Fit {
    fn form(&self) -> &Form {
        &self.form
    }

    fn values(&self, x: &DVector<f64>) -> Result<Values, OutsideDomain> {
        Ok(Values {
            cost: 0.5 * (&self.matrix * x - &self.right).norm_squared(),
            constraints: &self.slopes * x,
        })
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, OutsideDomain> {
        let residual = &self.matrix * x - &self.right;
        Ok(Linearization {
            cost: 0.5 * residual.norm_squared(),
            gradient: self.matrix.tr_mul(&residual),
            constraints: &self.slopes * x,
            jacobian: self.slopes.clone(),
            square_root: Some(SquareRoot {
                matrix: self.matrix.clone(),
                residual,
            }),
        })
    }
}

fn feasible(criterion: &mut Criterion) {
    let Some(folder) = std::env::var_os("EXID_SDP") else {
        eprintln!("EXID_SDP names no folder of cases: nothing is measured");
        return;
    };
    let mut group = criterion.benchmark_group("semidefinite fit");
    group.sample_size(20);
    for (case, links) in CASES {
        let fit = Fit::read(&Path::new(&folder).join(format!("sdp{case}")), links);
        let found = fit.solve();
        let x = &found.solution.x;
        let least = (0..links).map(|k| {
            let body = Inertia(std::array::from_fn(|i| x[10 * k + i]));
            body.pseudo_inertia().symmetric_eigenvalues().min()
        });
        let least = least.fold(f64::INFINITY, f64::min);
        let friction = x.rows(10 * links, 2 * links).min();
        eprintln!(
            "{case}: {:?} after {} iterations, objective {:.9}, gap {:.1e}, least eigenvalue {least:.2e}, friction {friction:.2e}",
            found.solution.stop,
            found.solution.iterations,
            2.0 * found.solution.cost,
            found.gap,
        );
        group.bench_function(case, |bencher| bencher.iter(|| black_box(fit.solve())));
    }
    group.finish();
}

criterion_group!(benches, feasible);
criterion_main!(benches);
