//! The quadratic programme of one step: min ½ dᵀB d + cᵀd + ν Σ s subject to a_i d = b_i, a_i d <= b_i, and
//! g_i + j_i d + s_i >= 0 with s_i >= 0.

use std::panic::{AssertUnwindSafe, catch_unwind};

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT as Cone,
};
use nalgebra::{DMatrix, DVector};

/// Gap and infeasibility of the programme, relative where its numbers exceed one: the next programme corrects
/// what is left.
const TOLERANCE: f64 = 1e-6;

/// Residual of the linear systems inside the method.
const REFINED: f64 = 1e-9;

/// A row `numbers · d[first..]` of the programme with its right-hand side.
#[derive(Debug, Clone)]
pub(super) struct Row {
    pub first: usize,
    pub numbers: Vec<f64>,
    pub right: f64,
}

/// The programme; d has as many entries as the cost.
pub(super) struct Quadratic<'a> {
    pub hessian: &'a DMatrix<f64>,
    pub cost: DVector<f64>,
    /// a d = b.
    pub equations: Vec<Row>,
    /// a d <= b.
    pub inequalities: Vec<Row>,
    /// −j d <= g + s: the right-hand side is g.
    pub elastic: Vec<Row>,
    /// ν.
    pub penalty: f64,
}

/// The solution of a programme.
#[derive(Debug, Clone)]
pub(super) struct Step {
    pub d: DVector<f64>,
    /// Multipliers of the elastic rows, >= 0.
    pub multipliers: Vec<f64>,
    /// Multipliers of the inequalities, >= 0.
    pub pressed: Vec<f64>,
    /// Σ s.
    pub slack: f64,
}

impl Quadratic<'_> {
    /// The step, or `None` where the method gives none.
    pub(super) fn solve(&self) -> Option<Step> {
        let (n, elastic) = (self.cost.len(), self.elastic.len());
        let p = self.quadratic_part();
        let (a, right) = self.rows();
        let mut linear: Vec<f64> = self.cost.iter().copied().collect();
        linear.extend(std::iter::repeat_n(self.penalty, elastic));
        let cones = [
            Cone::ZeroConeT(self.equations.len()),
            Cone::NonnegativeConeT(self.inequalities.len() + 2 * elastic),
        ];
        let settings = DefaultSettings {
            verbose: false,
            tol_gap_abs: TOLERANCE,
            tol_gap_rel: TOLERANCE,
            tol_feas: TOLERANCE,
            max_threads: 1,
            presolve_enable: false,
            // Directions as accurate as the programme is solved; the library's own targets are those of rounding.
            iterative_refinement_reltol: REFINED,
            iterative_refinement_abstol: REFINED,
            ..DefaultSettings::default()
        };
        let mut solver = DefaultSolver::new(&p, &linear, &a, &right, &cones, settings).ok()?;
        // The method unwraps factorisations that fail on numbers at the edge of the range: no step.
        catch_unwind(AssertUnwindSafe(|| solver.solve())).ok()?;
        use SolverStatus as S;
        let found = &solver.solution;
        let usable = matches!(
            found.status,
            S::Solved | S::AlmostSolved | S::InsufficientProgress | S::MaxIterations
        );
        if !usable || !found.x.iter().chain(&found.z).all(|v| v.is_finite()) {
            return None;
        }
        let first = self.equations.len();
        let then = first + self.inequalities.len();
        Some(Step {
            d: DVector::from_column_slice(&found.x[..n]),
            slack: found.x[n..].iter().map(|s| s.max(0.0)).sum(),
            pressed: found.z[first..then].iter().map(|z| z.max(0.0)).collect(),
            multipliers: found.z[then..then + elastic]
                .iter()
                .map(|z| z.max(0.0))
                .collect(),
        })
    }

    /// Upper triangle of B, zero for the slacks.
    fn quadratic_part(&self) -> CscMatrix<f64> {
        let (n, size) = (self.cost.len(), self.cost.len() + self.elastic.len());
        let entries = n * (n + 1) / 2;
        let (mut starts, mut rows) = (Vec::with_capacity(size + 1), Vec::with_capacity(entries));
        let mut values = Vec::with_capacity(entries);
        starts.push(0);
        for j in 0..size {
            if j < n {
                for i in 0..=j {
                    rows.push(i);
                    values.push(0.5 * (self.hessian[(i, j)] + self.hessian[(j, i)]));
                }
            }
            starts.push(rows.len());
        }
        CscMatrix::new(size, size, starts, rows, values)
    }

    /// Rows of all constraints, column by column, and their right-hand sides.
    fn rows(&self) -> (CscMatrix<f64>, Vec<f64>) {
        let (n, elastic) = (self.cost.len(), self.elastic.len());
        let mut columns: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n + elastic];
        let mut right = Vec::new();
        let all = self.equations.iter().chain(&self.inequalities);
        for row in all.chain(&self.elastic) {
            for (k, value) in row.numbers.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                columns[row.first + k].push((right.len(), *value));
            }
            right.push(row.right);
        }
        let first = right.len() - elastic;
        for k in 0..elastic {
            columns[n + k].push((first + k, -1.0));
            columns[n + k].push((first + elastic + k, -1.0));
        }
        right.extend(std::iter::repeat_n(0.0, elastic));
        let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for column in columns {
            for (row, value) in column {
                rows.push(row);
                values.push(value);
            }
            starts.push(rows.len());
        }
        let matrix = CscMatrix::new(right.len(), n + elastic, starts, rows, values);
        (matrix, right)
    }
}
