//! From base reactions to joint torques: the parameters θ_d of the joint-torque model as combinations of the
//! parameters θ_r that the reaction of the base determines (Raucent, Campion, Bastin, Samin and Willems 1992, eq. 5):
//!
//! ```text
//! θ_d = S θ_r        θ_d = S_d π,   θ_r = S_r π,   S S_r = S_d
//! ```
//!
//! In echelon form every row of S_r has a parameter of its own with coefficient 1, and so S is what S_d says
//! of those. Base reactions know nothing of the forces inside, and θ_d comes out free of friction.

use crate::chain::base_parameters::BaseParameters;
use crate::chain::model::{Model, Signal};
use crate::chain::rigid_bodies_only::rigid_bodies_only;
use crate::outcome::fit::{BaseParameter, Posterior};
use crate::stats::distribution::Distribution;
use nalgebra::{DMatrix, DVector};

/// Largest share of a combination that its image may miss it by: rounding of the coefficients.
const INSIDE: f64 = 1e-6;

/// Rows over all parameters, one per combination.
fn rows(base: &BaseParameters, parameters: usize) -> DMatrix<f64> {
    let mut rows = DMatrix::zeros(base.base.len(), parameters);
    for (k, combination) in base.base.iter().enumerate() {
        rows[(k, combination.parameter)] = 1.0;
        for &(parameter, coefficient) in &combination.others {
            rows[(k, parameter)] = coefficient;
        }
    }
    rows
}

/// S (N_d x N_r) with `θ_d = S θ_r`; `None` where θ_r does not determine θ_d.
///
/// Both bases are over the same list of parameters, of which there are `parameters`.
pub fn map(
    joint: &BaseParameters,
    base: &BaseParameters,
    parameters: usize,
) -> Option<DMatrix<f64>> {
    let (s_d, s_r) = (rows(joint, parameters), rows(base, parameters));
    let map = s_d.select_columns(&base.kept());
    let missed = (&map * s_r - &s_d).amax();
    (missed <= INSIDE * s_d.amax()).then_some(map)
}

/// θ_d with the uncertainty of a fit to base reactions; combinations that the fit does not determine are
/// left out.
pub fn joint_torque_parameters(model: &Model, posterior: &Posterior) -> Vec<BaseParameter> {
    let Ok(bodies) = rigid_bodies_only(model, Signal::Torque) else {
        return Vec::new();
    };
    let loads: &[bool] = if model.payload().is_some() {
        &[false, true]
    } else {
        &[false]
    };
    let count = bodies.parameters().len();
    let base = BaseParameters::structural(&bodies, loads, &DMatrix::zeros(0, count));
    let s_d = rows(&base, count);
    let known = Combinations::of(&bodies, posterior);
    let quantile = Distribution::Normal.two_sided(0.95);
    let mut parameters = Vec::new();
    for k in 0..base.base.len() {
        let wanted = s_d.row(k).transpose();
        let Some(factors) = known.factors(&wanted) else {
            continue;
        };
        let value = factors.dot(&known.values);
        let std_dev = (factors.transpose() * &known.covariance * &factors)[(0, 0)]
            .max(0.0)
            .sqrt();
        let half = quantile * std_dev;
        parameters.push(BaseParameter {
            expression: base.expression(&bodies, k),
            unit: bodies.parameters()[base.base[k].parameter].unit.clone(),
            value: Some(value),
            std_dev: Some(std_dev),
            ci95: Some([value - half, value + half]),
        });
    }
    parameters
}

/// The combinations that a fit knows, over the parameters of the bodies alone.
struct Combinations {
    rows: DMatrix<f64>,
    /// The parameter that leads each combination; `None` where it is not one of the bodies.
    leading: Vec<Option<usize>>,
    values: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl Combinations {
    fn of(bodies: &Model, posterior: &Posterior) -> Self {
        let count = posterior.combinations.len();
        let mut rows = DMatrix::zeros(count, bodies.parameters().len());
        let mut leading = Vec::with_capacity(count);
        for (k, combination) in posterior.combinations.iter().enumerate() {
            let mut first = None;
            for (order, term) in combination.terms.iter().enumerate() {
                if let Some(position) = bodies.position(&term.parameter) {
                    rows[(k, position)] = term.coefficient;
                    if order == 0 {
                        first = Some(position);
                    }
                }
            }
            leading.push(first);
        }
        let values = posterior.combinations.iter().map(|c| c.value);
        Self {
            rows,
            leading,
            values: DVector::from_iterator(count, values),
            covariance: DMatrix::from_fn(count, count, |i, j| posterior.covariance[i][j]),
        }
    }

    /// Factors of the combinations that sum up to the wanted one.
    fn factors(&self, wanted: &DVector<f64>) -> Option<DVector<f64>> {
        let of = |first: &Option<usize>| first.map_or(0.0, |position| wanted[position]);
        let factors = DVector::from_iterator(self.leading.len(), self.leading.iter().map(of));
        let missed = (self.rows.tr_mul(&factors) - wanted).amax();
        (missed <= INSIDE * wanted.amax()).then_some(factors)
    }
}
