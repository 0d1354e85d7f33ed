//! Whether the delays of a group of joints are one delay of all or that of one joint.

use crate::chain::effect::Law;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::effect_size::least_delay;
use crate::recording::split::Split;

/// Delay of a joint as it was fitted.
#[derive(Debug, Clone, Copy)]
struct FittedDelay {
    /// s.
    value: f64,
    /// 1/s², the inverse of the variance of its estimate and of what the stamps of samples are good for.
    weight: f64,
}

impl FittedDelay {
    /// `(d − m)²/σ²` beside a delay of m s.
    fn squares_beside(self, other: f64) -> f64 {
        self.weight * (self.value - other).powi(2)
    }
}

/// Whether the delays that a model has in a group of joints are better described by the delay of one of them, and none in the
/// others, than by one delay of all. What makes a group late, a cable or a clock, makes all of it late alike; a delay that is small
/// beside that of another joint is what other missing physics of its own joint looks like. `false` for what is no group of delays, and
/// where they are no estimates.
pub fn is_of_one(context: &Context<'_>, fit: &ModelFit, group: &Hypothesis) -> bool {
    if !matches!(group.effect.law, Law::Delay) || group.joints.len() < 2 {
        return false;
    }
    let recordings = context.recordings(Split::Train);
    let deviations = fit.parameter_deviations(&recordings);
    let least = least_delay(&recordings);
    let fitted = |&joint: &usize| {
        let index = fit.model.joints()[joint].delay?;
        let variance = deviations[index]?.powi(2) + least * least;
        Some(FittedDelay {
            value: fit.values[index],
            weight: variance.recip(),
        })
    };
    let delays: Option<Vec<FittedDelay>> = group.joints.iter().map(fitted).collect();
    delays.is_some_and(|delays| left_by_one(&delays) < left_by_all(&delays))
}

/// `Σ d²/σ²` without the largest of them.
fn left_by_one(delays: &[FittedDelay]) -> f64 {
    let squares = || delays.iter().map(|d| d.squares_beside(0.0));
    squares().sum::<f64>() - squares().fold(0.0, f64::max)
}

/// `Σ (d − d̄)²/σ²` with the weighted mean `d̄`.
fn left_by_all(delays: &[FittedDelay]) -> f64 {
    let total: f64 = delays.iter().map(|d| d.weight).sum();
    let mean = delays.iter().map(|d| d.weight * d.value).sum::<f64>() / total;
    delays.iter().map(|d| d.squares_beside(mean)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Delays in ms, each with a deviation of 0.1 ms.
    fn is_late_alone(values: &[f64]) -> bool {
        let of = |value: &f64| FittedDelay {
            value: 1e-3 * value,
            weight: 1e8,
        };
        let delays: Vec<FittedDelay> = values.iter().map(of).collect();
        left_by_one(&delays) < left_by_all(&delays)
    }

    #[test]
    fn a_joint_is_late_alone_where_the_others_are_nearer_to_none_than_to_one_delay_of_all() {
        assert!(is_late_alone(&[0.1, 22.0, -2.5, 1.2, 0.0]));
        assert!(is_late_alone(&[22.0, 0.0]));
        assert!(!is_late_alone(&[5.0, 4.8, 5.3, 4.9]));
        assert!(!is_late_alone(&[20.0, 8.0, 8.0, 8.0]));
    }
}
