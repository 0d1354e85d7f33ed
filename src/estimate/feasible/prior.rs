//! Priors that pull the bodies towards those of the robot file, J_0, with S = D J D − margin·1:
//!
//! | kind | γ times |
//! |---|---|
//! | Euclidean | `½ ‖(m, h/ℓ, I/ℓ²) − (…)_0‖²` in the standard parameters, kg² |
//! | entropic | `tr(S_0⁻¹ S) − log det S + log det S_0 − 4`, the Bregman divergence of −log det (Lee, Wensing and Park 2020, eq. 25) |
//! | pullback | `½ ‖S_0^(−1/2) (S − S_0) S_0^(−1/2)‖²`, its second-order form at S_0 (Lee, Wensing and Park 2020, eq. 29) |
//!
//! All are convex in the parameters; the entropic one goes to infinity at the edge of what is possible.

use crate::estimate::feasible::standard::{LENGTH, ROWS, Standard, svec4};
use crate::linalg::svec::smat;
use crate::problem_file::choices::PriorKind;
use crate::robot::inertia::PER_LINK;
use crate::solve::interior::Terms;
use nalgebra::{DMatrix, DVector, Matrix4};

/// The prior of unit strength over the unknowns of a fit.
#[derive(Debug, Clone)]
pub struct InertialPrior {
    pub kind: PriorKind,
    /// Quadratic part `½ ‖rows x + offset‖²`; for the entropic kind that of its second-order form.
    rows: DMatrix<f64>,
    offset: DVector<f64>,
    /// Entropic: gradient of `Σ tr(S_0⁻¹ S)`.
    linear: DVector<f64>,
    bodies: usize,
}

impl InertialPrior {
    pub fn new(kind: PriorKind, standard: &Standard<'_>, margin: f64) -> Self {
        let references = standard.references();
        let reference = standard.reference();
        let (_, slopes) = standard.pseudo_inertias();
        let bodies = references.len();
        let mut rows = DMatrix::zeros(ROWS * bodies, standard.len());
        let mut linear = DVector::zeros(standard.len());
        for (body, whole) in references.iter().enumerate() {
            let shifted = whole - Matrix4::identity() * margin;
            let Some(factor) = shifted.cholesky() else {
                continue;
            };
            let (root, inverse) = (factor.l(), svec4(&factor.inverse()));
            let part = slopes.rows(ROWS * body, ROWS);
            for column in 0..standard.len() {
                let entries: Vec<f64> = part.column(column).iter().copied().collect();
                linear[column] += inverse
                    .iter()
                    .zip(&entries)
                    .map(|(a, b)| a * b)
                    .sum::<f64>();
                let scaled = match kind {
                    PriorKind::Euclidean => euclidean(standard, body, column),
                    _ => whitened(&root, &entries),
                };
                rows.view_mut((ROWS * body, column), (ROWS, 1))
                    .copy_from_slice(&scaled);
            }
        }
        Self {
            kind,
            offset: -&rows * &reference,
            rows,
            linear,
            bodies,
        }
    }

    /// Rows of a strength; none for the entropic kind.
    pub fn rows(&self, strength: f64) -> (DMatrix<f64>, DVector<f64>) {
        match self.kind {
            PriorKind::Entropic => (DMatrix::zeros(0, self.rows.ncols()), DVector::zeros(0)),
            _ => (&self.rows * strength.sqrt(), &self.offset * strength.sqrt()),
        }
    }

    /// What a strength adds to the cost beside rows.
    pub fn terms(&self, strength: f64) -> Terms {
        match self.kind {
            PriorKind::Entropic => Terms {
                linear: &self.linear * strength,
                log_det: vec![strength; self.bodies],
            },
            _ => Terms::default(),
        }
    }

    /// Curvature of the prior, that of the entropic one by its second-order form at the reference.
    pub fn information(&self, strength: f64) -> DMatrix<f64> {
        self.rows.tr_mul(&self.rows) * strength
    }
}

/// svec of `L⁻¹ A L⁻ᵀ`.
fn whitened(root: &Matrix4<f64>, entries: &[f64]) -> Vec<f64> {
    let a = Matrix4::from_iterator(smat(entries).iter().copied());
    let half = root.solve_lower_triangular(&a).unwrap_or(a);
    let whole = root
        .solve_lower_triangular(&half.transpose())
        .unwrap_or(half);
    svec4(&whole)
}

/// The standard parameters of a body in kg: moments over ℓ, inertias over ℓ².
fn euclidean(standard: &Standard<'_>, body: usize, column: usize) -> Vec<f64> {
    let first = standard.bodies[body];
    let parameter = standard.parameters[column];
    let mut rows = vec![0.0; ROWS];
    if (first..first + PER_LINK).contains(&parameter) {
        let entry = parameter - first;
        rows[entry] = match entry {
            0 => 1.0,
            1..=3 => 1.0 / LENGTH,
            _ => 1.0 / (LENGTH * LENGTH),
        };
    }
    rows
}
