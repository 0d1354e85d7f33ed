//! Combinations that both determine, in the terms of the robot's:
//!
//! ```text
//! b_k = Σ_j c_kj s_j,   d_k = b_k − Σ_j c_kj ŝ_j,   Var d_k = Var b_k + c_kᵀ Σ_s c_k
//! ```
//!
//! A combination s_j has a parameter that no other one has, so that c_kj is the coefficient of that parameter in b_k; what
//! the simulator's recordings leave open has no such sum and is not compared.

use crate::chain::dataset::Dataset;
use crate::diagnose::simulator::sentences;
use crate::diagnose::simulator::side::{Determined, Named, Side};
use crate::estimate::goodness_of_fit::predictions;
use crate::outcome::simulator::Contrast;
use crate::recording::split::Split;
use crate::stats::distribution::Distribution;
use nalgebra::DVector;

/// Chance of calling anything different where nothing is, over all quantities.
pub(super) const LEVEL: f64 = 0.05;

/// Share of a combination's coefficients that rounding leaves.
const ROUNDING: f64 = 1e-6;

/// A contrast with what decides where it belongs.
pub(super) struct Tested {
    pub contrast: Contrast,
    /// The raw parameter that is the robot's alone among its combinations, by name.
    pub leading: String,
    /// Of one parameter and not of a sum.
    pub single: bool,
}

/// All contrasts of what shows in at least one of the two.
pub(super) fn contrasts(simulator: &Side<'_>, robot: &Side<'_>) -> Vec<Tested> {
    let simulated = simulator.determined();
    let mut tested: Vec<Tested> = robot
        .determined()
        .into_iter()
        .filter_map(|(_, own)| {
            let alike = in_terms_of(&own, &simulated, simulator)?;
            Some(contrast(own, alike))
        })
        .filter(|t| !t.single || is_shown(&t.leading, simulator, robot))
        .collect();
    correct(&mut tested);
    let size = SignalSize::of(robot);
    for tested in &mut tested {
        tested.contrast.share_of_signal = size.share(&tested.leading, tested.contrast.difference);
        tested.contrast.sentence = sentences::contrast(&tested.contrast, robot);
    }
    tested
}

/// Whether one of the two has the effect of a parameter; its shape is compared where both have it.
fn is_shown(name: &str, simulator: &Side<'_>, robot: &Side<'_>) -> bool {
    let Some(named) = Named::of(name) else {
        return true;
    };
    let (there, here) = (simulator.shows(&named), robot.shows(&named));
    match named.nothing() {
        Some(_) => there || here,
        None => there && here,
    }
}

/// The simulator's value of a combination of the robot's.
struct Alike {
    value: f64,
    variance: f64,
}

fn in_terms_of(
    own: &Determined,
    simulated: &[(usize, Determined)],
    simulator: &Side<'_>,
) -> Option<Alike> {
    let covariance = &simulator.fit.posterior.covariance;
    let parts: Vec<(usize, f64, &Determined)> = simulated
        .iter()
        .filter_map(|(k, s)| {
            let coefficient = *own.terms.get(&s.leading)?;
            Some((*k, coefficient, s))
        })
        .collect();
    if parts.is_empty() {
        return None;
    }
    let mut left = own.terms.clone();
    for (_, coefficient, s) in &parts {
        for (name, term) in &s.terms {
            *left.entry(name.clone()).or_insert(0.0) -= coefficient * term;
        }
    }
    let size = own.terms.values().map(|c| c.abs()).fold(0.0, f64::max);
    if left.values().any(|c| c.abs() > ROUNDING * size) {
        return None;
    }
    let value = parts.iter().map(|(_, c, s)| c * s.value).sum();
    let pairs = parts
        .iter()
        .flat_map(|(i, a, _)| parts.iter().map(move |(j, b, _)| (i, a, j, b)));
    let variance: f64 = pairs.map(|(i, a, j, b)| a * b * covariance[*i][*j]).sum();
    variance.is_finite().then_some(Alike {
        value,
        variance: variance.max(0.0),
    })
}

fn contrast(own: Determined, alike: Alike) -> Tested {
    let difference = own.value - alike.value;
    let deviation = (own.variance + alike.variance).sqrt();
    let p_value = match deviation > 0.0 {
        true => 2.0 * Distribution::Normal.upper_tail((difference / deviation).abs()),
        false => 1.0,
    };
    Tested {
        single: own.terms.len() == 1,
        leading: own.leading,
        contrast: Contrast {
            parameter: own.expression,
            unit: own.unit,
            simulated: alike.value,
            simulated_std_dev: alike.variance.sqrt(),
            robot: own.value,
            robot_std_dev: own.variance.sqrt(),
            difference,
            ci95: None,
            p_value,
            share_of_signal: f64::NAN,
            sentence: String::new(),
        },
    }
}

/// Holm's correction of p-values: the k-th smallest of m times m − k + 1, none smaller than the one before it. Bonferroni's of
/// intervals: each holds with 1 − 0.05/m.
fn correct(tested: &mut [Tested]) {
    let count = tested.len();
    let quantile = Distribution::Normal.two_sided(1.0 - LEVEL / count.max(1) as f64);
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| {
        let p = |k: usize| tested[k].contrast.p_value;
        p(a).total_cmp(&p(b))
    });
    let mut least = 0.0_f64;
    for (rank, k) in order.into_iter().enumerate() {
        let contrast = &mut tested[k].contrast;
        least = least.max((contrast.p_value * (count - rank) as f64).min(1.0));
        contrast.p_value = least;
        let half = quantile * contrast.robot_std_dev.hypot(contrast.simulated_std_dev);
        contrast.ci95 = Some([contrast.difference - half, contrast.difference + half]);
    }
}

/// What a change of a parameter makes of the robot's signals.
struct SignalSize<'a> {
    robot: &'a Side<'a>,
    data: Dataset,
    at: Vec<Vec<Vec<f64>>>,
}

impl<'a> SignalSize<'a> {
    fn of(robot: &'a Side<'a>) -> Self {
        let data = Dataset {
            recordings: robot.data.of(Split::Train).cloned().collect(),
        };
        let at = predictions(robot.model, robot.values, &data);
        Self { robot, data, at }
    }

    /// RMS change over RMS signal of the channel in which it is largest; NaN where nothing moves.
    fn share(&self, parameter: &str, change: f64) -> f64 {
        let parameters = self.robot.model.parameters();
        let Some(p) = parameters.iter().position(|q| q.name == parameter) else {
            return f64::NAN;
        };
        let mut moved: DVector<f64> = self.robot.values.clone();
        moved[p] -= change;
        let moved = predictions(self.robot.model, &moved, &self.data);
        let channels = self.at.first().map_or(0, Vec::len);
        let share = |channel: usize| {
            let (mut change, mut size) = (0.0, 0.0);
            for (recording, (at, moved)) in
                self.data.recordings.iter().zip(self.at.iter().zip(&moved))
            {
                let Some(signal) = recording.experiment.signal.get(channel) else {
                    continue;
                };
                for ((a, b), s) in at[channel].iter().zip(&moved[channel]).zip(signal) {
                    change += (a - b).powi(2);
                    size += s * s;
                }
            }
            (change / size).sqrt()
        };
        (0..channels)
            .map(share)
            .filter(|s| s.is_finite())
            .fold(f64::NAN, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn determined(value: f64, variance: f64) -> Determined {
        Determined {
            expression: "a".to_string(),
            unit: "kg".to_string(),
            terms: BTreeMap::from([("a".to_string(), 1.0)]),
            leading: "a".to_string(),
            value,
            variance,
        }
    }

    /// A difference of 1.96 of its standard deviations has p = 0.05, and one without a deviation says nothing.
    #[test]
    fn matches_the_normal_test_of_a_difference() {
        let p_value = |difference: f64, [own, alike]: [f64; 2]| {
            let alike = Alike {
                value: 2.0,
                variance: alike,
            };
            contrast(determined(2.0 + difference, own), alike)
                .contrast
                .p_value
        };
        let deviation = f64::sqrt(0.09 + 0.16);
        let of_normal = 1.959_963_984_540_054 * deviation;
        assert!((p_value(of_normal, [0.09, 0.16]) - 0.05).abs() < 1e-9);
        assert!((p_value(-of_normal, [0.09, 0.16]) - 0.05).abs() < 1e-9);
        assert_eq!(p_value(1.0, [0.0, 0.0]), 1.0);
    }

    /// Holm 1979: the smallest p-value times their number, the next times one less, none smaller than one before it.
    #[test]
    fn matches_holm_s_correction() {
        let alike = || Alike {
            value: 0.0,
            variance: 0.5,
        };
        let mut tested: Vec<Tested> = [0.01, 0.04, 0.03]
            .into_iter()
            .map(|p_value| {
                let mut tested = contrast(determined(1.0, 0.5), alike());
                tested.contrast.p_value = p_value;
                tested
            })
            .collect();
        correct(&mut tested);
        let found: Vec<f64> = tested.iter().map(|t| t.contrast.p_value).collect();
        for (found, expected) in found.iter().zip([0.03, 0.06, 0.06]) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        // 1 − 0.05/6 of the normal distribution.
        let [low, high] = tested[0].contrast.ci95.unwrap();
        assert!((0.5 * (low + high) - 1.0).abs() < 1e-12);
        assert!((0.5 * (high - low) - 2.393_979_8).abs() < 1e-6);
    }
}
