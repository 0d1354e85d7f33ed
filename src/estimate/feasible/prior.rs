//! Priors that pull the bodies towards those of the robot file, J_0, with S = D J D − margin·1:
//!
//! | kind | γ times |
//! |---|---|
//! | Euclidean | `½ ‖(m, h/ℓ, I/ℓ²) − (…)_0‖²` in the standard parameters, kg² |
//! | entropic | `tr(S_0⁻¹ S) − log det S + log det S_0 − 4`, the Bregman divergence of −log det (a) |
//! | lasso | `Σ_j |x_j| / u_j` over the linear unknowns, u_j the units of the Euclidean kind or the parameter's scale (b) |
//! | pullback | `½ ‖S_0^(−1/2) (S − S_0) S_0^(−1/2)‖²`, its second-order form at S_0 (c) |
//!
//! (a) Lee, Wensing and Park 2020, eq. 25; (b) Gilbert, Maina and Byiringiro 2024, eq. 29; (c) Lee, Wensing
//! and Park 2020, eq. 29.
//!
//! The lasso pulls to zero and not to J_0. Gilbert, Maina and Byiringiro add up numbers in different
//! units, and the scales and shapes of friction laws with them, whose absolute values mean nothing; here every term is in its unit, and shapes are free.
//!
//! All are convex in the parameters; the entropic one goes to infinity at the edge of what is possible.

use crate::estimate::derived::pseudo_inertia::{LENGTH, ROWS, svec4};
use crate::estimate::feasible::standard::StandardParameters;
use crate::linalg::svec::smat;
use crate::problem::affine::AffineRows;
use crate::problem_file::choices::PriorKind;
use crate::robot::inertia::PER_LINK;
use crate::solve::interior::Terms;
use nalgebra::{DMatrix, DVector, Matrix4};

/// The prior of unit weight over the unknowns of a fit.
#[derive(Debug, Clone)]
pub struct InertialPrior {
    /// By what norm or divergence bodies are held to those of the robot file.
    pub kind: PriorKind,
    /// Quadratic part `½ ‖rows x + offset‖²`; for the entropic kind that of its second-order form.
    rows: DMatrix<f64>,
    offset: DVector<f64>,
    /// Entropic: gradient of `Σ tr(S_0⁻¹ S)`.
    linear: DVector<f64>,
    /// Lasso: 1/u_j of every unknown, 0 for those that are free.
    inverse_units: DVector<f64>,
    bodies: usize,
}

impl InertialPrior {
    /// Lays out the prior about the bodies of the robot file; `margin` is the least eigenvalue of a scaled pseudo-inertia,
    /// kg.
    pub fn new(kind: PriorKind, standard: &StandardParameters<'_>, margin: f64) -> Self {
        let references = standard.references();
        let reference = standard.reference();
        let slopes = standard.pseudo_inertias().matrix;
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
            inverse_units: inverse_units(standard),
            rows,
            linear,
            bodies,
        }
    }

    /// Rows of a weight; none for the entropic kind.
    pub fn rows(&self, weight: f64) -> AffineRows {
        match self.kind {
            PriorKind::Entropic | PriorKind::Lasso => AffineRows {
                matrix: DMatrix::zeros(0, self.rows.ncols()),
                offset: DVector::zeros(0),
            },
            _ => AffineRows {
                matrix: &self.rows * weight.sqrt(),
                offset: &self.offset * weight.sqrt(),
            },
        }
    }

    /// What a weight adds to the cost beside rows.
    pub fn terms(&self, weight: f64) -> Terms {
        match self.kind {
            PriorKind::Entropic => Terms {
                linear: &self.linear * weight,
                log_det: vec![weight; self.bodies],
            },
            _ => Terms::default(),
        }
    }

    /// Weight of |x_j| in the cost; zeros for the kinds without absolute values.
    pub fn absolute(&self, weight: f64) -> DVector<f64> {
        match self.kind {
            PriorKind::Lasso => &self.inverse_units * weight,
            _ => DVector::zeros(self.inverse_units.len()),
        }
    }

    /// Curvature of the prior: that of the entropic one by its second-order form at the reference, that of the lasso
    /// as `|x| ~ x²/|x_0|` at the estimate (Tibshirani 1996, section 2.5).
    pub fn information(&self, weight: f64, x: &DVector<f64>) -> DMatrix<f64> {
        if self.kind != PriorKind::Lasso {
            return self.rows.tr_mul(&self.rows) * weight;
        }
        let weights = self.absolute(weight);
        let curvature = |k: usize| match weights[k] {
            0.0 => 0.0,
            weight => weight / x[k].abs().max(ZERO / self.inverse_units[k]),
        };
        DMatrix::from_diagonal(&DVector::from_fn(x.len(), |k, _| curvature(k)))
    }

    /// How sparse a lasso makes the unknowns.
    pub fn sparsity(&self, x: &DVector<f64>) -> Sparsity {
        let counted = (0..x.len()).filter(|&k| self.inverse_units[k] > 0.0);
        let small = |k: &usize| x[*k].abs() * self.inverse_units[*k] < ZERO;
        Sparsity {
            counted: counted.clone().count(),
            zero: counted.filter(small).count(),
        }
    }
}

/// How sparse a lasso makes the unknowns.
#[derive(Debug, Clone, Copy)]
pub struct Sparsity {
    /// Unknowns that it counts.
    pub counted: usize,
    /// Those among them that it takes to zero.
    pub zero: usize,
}

/// A parameter below this share of its unit is zero: a few margins of the bodies.
const ZERO: f64 = 1e-5;

/// 1/u_j: those of a body in kg, those of an effect by their scale; shapes are free.
fn inverse_units(standard: &StandardParameters<'_>) -> DVector<f64> {
    let mut units = DVector::zeros(standard.len());
    for column in 0..standard.linear {
        let in_body = (0..standard.bodies.len())
            .map(|body| euclidean(standard, body, column).iter().sum::<f64>())
            .fold(0.0, f64::max);
        let parameter = &standard.model.parameters()[standard.parameters[column]];
        units[column] = if in_body > 0.0 {
            in_body
        } else {
            1.0 / parameter.scale
        };
    }
    units
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
fn euclidean(standard: &StandardParameters<'_>, body: usize, column: usize) -> Vec<f64> {
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
