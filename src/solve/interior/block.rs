//! One cone of the program, S = C + Σ_j d_j A_j ⪰ 0 with its multiplier Z, and the scaling of Nesterov and
//! Todd (1997), in which both are the same diagonal matrix: `r⁻¹ S r⁻ᵀ = rᵀ Z r = diag(λ)`.

use crate::solve::interior::small::{self, LARGEST, ROWS, Small};
use nalgebra::{DMatrix, DVector};

/// S as a function of the step, and the weight γ of `−γ log det S` in the cost.
pub(super) struct Cone {
    pub order: usize,
    /// Variables that S depends on, and A of each.
    pub columns: Vec<usize>,
    pub slopes: Vec<Small>,
    pub constant: Small,
    pub weight: f64,
}

impl Cone {
    /// S at a step.
    pub fn at(&self, step: &DVector<f64>) -> Small {
        let terms = self.columns.iter().zip(&self.slopes);
        terms.fold(self.constant, |sum, (&j, slope)| sum + slope * step[j])
    }

    /// Largest entry of the terms of S at a step: what its rounding is relative to.
    pub fn size(&self, step: &DVector<f64>) -> f64 {
        let terms = self.columns.iter().zip(&self.slopes);
        terms.fold(self.constant.amax(), |sum, (&j, slope)| {
            sum + slope.amax() * step[j].abs()
        })
    }

    /// `out_j += ⟨A_j, Z⟩`.
    pub fn add_adjoint(&self, z: &Small, out: &mut DVector<f64>) {
        for (&j, slope) in self.columns.iter().zip(&self.slopes) {
            out[j] += slope.dot(z);
        }
    }

    /// Rows of the svec of S.
    pub fn rows(&self) -> usize {
        self.order * (self.order + 1) / 2
    }
}

/// S, Z and their scaling.
pub(super) struct State {
    pub s: Small,
    pub z: Small,
    /// C + A d − S.
    pub miss: Small,
    pub lambda: [f64; LARGEST],
    r: Small,
    inverse: Small,
    /// svec of r⁻¹ A_j r⁻ᵀ per coordinate, rows x coordinates.
    pub slopes: DMatrix<f64>,
    /// r⁻¹ miss r⁻ᵀ.
    scaled_miss: Small,
}

/// Scaled changes of S and Z.
pub(super) struct ScaledChange {
    pub s: Small,
    pub z: Small,
}

impl State {
    pub fn new(s: Small, z: Small) -> Self {
        Self {
            s,
            z,
            miss: Small::zeros(),
            lambda: [0.0; LARGEST],
            r: Small::zeros(),
            inverse: Small::zeros(),
            slopes: DMatrix::zeros(0, 0),
            scaled_miss: Small::zeros(),
        }
    }

    /// Computes the scaling; `None` where S or Z has left its cone by rounding.
    pub fn scale(&mut self, cone: &Cone, basis: &DMatrix<f64>) -> Option<()> {
        let order = cone.order;
        let (l, m) = (
            small::cholesky(&self.s, order)?,
            small::cholesky(&self.z, order)?,
        );
        let (u, lambda, v) = small::singular(&(m.transpose() * l), order);
        if !lambda[..order].iter().all(|x| *x > 0.0 && x.is_finite()) {
            return None;
        }
        let mut root = small::identity(order);
        for k in 0..order {
            root[(k, k)] = 1.0 / lambda[k].sqrt();
        }
        self.lambda = lambda;
        self.r = l * v * root;
        self.inverse = root * u.transpose() * m.transpose();
        let own = cone
            .slopes
            .iter()
            .map(|a| small::svec(&self.scaled(a), order));
        let entries: Vec<f64> = own
            .flat_map(|rows| rows.into_iter().take(cone.rows()))
            .collect();
        let own = DMatrix::from_vec(cone.rows(), cone.columns.len(), entries);
        self.slopes = own * basis.select_rows(&cone.columns);
        self.scaled_miss = self.scaled(&self.miss);
        Some(())
    }

    /// r⁻¹ A r⁻ᵀ.
    fn scaled(&self, a: &Small) -> Small {
        self.inverse * a * self.inverse.transpose()
    }

    /// Rows `λ + v − miss` of the least squares problem whose solution is the step.
    pub fn right(&self, cone: &Cone, wanted: &Small) -> [f64; ROWS] {
        let mut rows = wanted - self.scaled_miss;
        for k in 0..cone.order {
            rows[(k, k)] += self.lambda[k];
        }
        small::svec(&rows, cone.order)
    }

    /// Scaled changes of S and Z for a step and `ΔS + ΔZ = v`.
    pub fn directions(&self, cone: &Cone, wanted: &Small, step: &DVector<f64>) -> ScaledChange {
        let rows = &self.slopes * step;
        let s = small::smat(rows.as_slice(), cone.order) + self.scaled_miss;
        ScaledChange { s, z: wanted - s }
    }

    /// v with `λ ∘ v = target·1 − λ² − correction`, ∘ the symmetric product.
    pub fn wanted(&self, order: usize, target: f64, correction: &Small) -> Small {
        let mut v = Small::zeros();
        for i in 0..order {
            for j in 0..order {
                let own = if i == j {
                    target - self.lambda[i].powi(2)
                } else {
                    0.0
                };
                v[(i, j)] = 2.0 * (own - correction[(i, j)]) / (self.lambda[i] + self.lambda[j]);
            }
        }
        v
    }

    /// Longest step in [0, ∞] along a scaled direction.
    pub fn longest(&self, order: usize, direction: &Small) -> f64 {
        let mut relative = Small::zeros();
        for i in 0..order {
            for j in 0..order {
                relative[(i, j)] = direction[(i, j)] / (self.lambda[i] * self.lambda[j]).sqrt();
            }
        }
        let least = small::least_eigenvalue(&relative, order);
        if least < 0.0 {
            -1.0 / least
        } else {
            f64::INFINITY
        }
    }

    /// Takes a step along scaled directions; S itself follows from the variables where it can.
    pub fn advance(&mut self, order: usize, length: f64, change: &ScaledChange) {
        let mut lambda = Small::zeros();
        for k in 0..order {
            lambda[(k, k)] = self.lambda[k];
        }
        let s = self.r * (lambda + change.s * length) * self.r.transpose();
        let z = self.inverse.transpose() * (lambda + change.z * length) * self.inverse;
        self.s = (s + s.transpose()) * 0.5;
        self.z = (z + z.transpose()) * 0.5;
    }

    /// ⟨S, Z⟩.
    pub fn complementarity(&self, order: usize) -> f64 {
        self.lambda[..order].iter().map(|x| x * x).sum()
    }

    /// This cone's share of the duality gap: `Σ_i λ_i² − γ − γ log(λ_i²/γ)`, `Σ_i λ_i²` for γ = 0.
    pub fn gap(&self, cone: &Cone) -> f64 {
        let gamma = cone.weight;
        if gamma == 0.0 {
            return self.complementarity(cone.order);
        }
        let of = |x: &f64| gamma * (x * x / gamma - 1.0 - (x * x / gamma).ln());
        self.lambda[..cone.order].iter().map(of).sum()
    }
}
