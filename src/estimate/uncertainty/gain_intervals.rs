//! Confidence intervals of controller gains and of the parameters that are estimated with them, by Fieller's theorem.
//!
//! The error of a controller is linear in 1/kp and in the ratios θ/kp of what its joint has, `s = (τ + kd (ṁ − v_c) − u)/kp`, and
//! their errors are normal as far out as those of the noise. Those of kp and θ are not where kp is not told well:
//!
//! ```text
//! kp = 1/y,   θ = r/y,   y = 1/kp,   r = θ/kp      intervals by Fieller's theorem
//! V_yy = σ_kp²/kp⁴,   V_ry = (r σ_kp² − σ_θ,kp)/kp³,   V_rr = (σ_θ² − 2 r σ_θ,kp + r² σ_kp²)/kp²
//! ```
//!
//! Where something is known of the gain before, it is known of kp, and intervals stay those of normal errors.

use crate::chain::effect::Linearity;
use crate::chain::parameter::Role;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::stats::distribution::Distribution;
use crate::stats::ratio::Ratio;
use nalgebra::{DMatrix, DVector};

/// Intervals of the unknowns at x with this covariance, 95 %; `None` of those that have the usual one.
pub(crate) fn find(
    problem: &FitProblem<'_>,
    x: &DVector<f64>,
    covariance: &DMatrix<f64>,
) -> Vec<Option<[f64; 2]>> {
    let positions = problem.unknowns.positions();
    let quantile = Distribution::Normal.two_sided(0.95);
    let of = |k: usize| {
        let gain = gain_beside(problem, &positions, k)?;
        let (kp, gain_variance) = (x[gain], covariance[(gain, gain)]);
        let (numerator, numerator_variance, shared) = match k == gain {
            true => (1.0, 0.0, 0.0),
            false => {
                let (r, both) = (x[k] / kp, covariance[(k, gain)]);
                let own = covariance[(k, k)] - 2.0 * r * both + r * r * gain_variance;
                (r, own / kp.powi(2), (r * gain_variance - both) / kp.powi(3))
            }
        };
        let ratio = Ratio {
            numerator,
            denominator: 1.0 / kp,
            numerator_variance,
            denominator_variance: gain_variance / kp.powi(4),
            covariance: shared,
        };
        let interval = ratio.interval(quantile)?;
        interval
            .iter()
            .all(|end| end.is_finite())
            .then_some(interval)
    };
    (0..x.len()).map(of).collect()
}

/// The place among the unknowns of a gain of which nothing is known before and by which an unknown of its joint is divided.
fn gain_beside(problem: &FitProblem<'_>, positions: &[usize], unknown: usize) -> Option<usize> {
    let model = problem.model;
    let parameter = &model.parameters()[positions[unknown]];
    let (Role::Effect { joint, .. } | Role::Controller { joint, .. }) = parameter.role else {
        return None;
    };
    let gain = model.joints()[joint].controller?;
    let is_divided = positions[unknown] == gain || parameter.linearity == Linearity::Linear;
    let is_single = problem.unknowns.is_single(unknown);
    let is_new = !problem.prior.speaks_of(gain);
    let place = positions.iter().position(|&p| p == gain)?;
    (is_divided && is_single && is_new).then_some(place)
}
