//! The trajectories of a design over one period, from their coefficients.

use std::collections::BTreeMap;

use crate::design::trajectory::fourier_series::{Basis, Series};
use crate::outcome::design::{Design, JointCoefficients};
use crate::outcome::skeleton::Skeleton;
use crate::report::explore::encoded::{Quantised, floats};
use crate::report::explore::parts::{Channel, Line, Take};
use crate::report::explore::posture::Postures;

/// Samples of a period: 50 for each of twenty harmonics.
const SAMPLES: usize = 1000;

/// One take for each trajectory; none of a plan that is no series.
pub(super) fn takes(design: &Design, skeleton: Option<&Skeleton>) -> Vec<Take> {
    let series = Series {
        harmonics: design.coefficients.harmonics,
        period: design.coefficients.period,
    };
    if !(series.period > 0.0 && series.harmonics > 0) {
        return Vec::new();
    }
    let basis = Basis::new(series, SAMPLES);
    let trajectories = design.coefficients.trajectories.iter().enumerate();
    trajectories
        .filter_map(|(k, joints)| {
            let mut take = take(&basis, k + 1, joints)?;
            take.postures = skeleton.and_then(|skeleton| postures(skeleton, design, &basis, k));
            Some(take)
        })
        .collect()
}

/// s from the start of the period.
fn times(basis: &Basis) -> Vec<f64> {
    let at = |k: usize| k as f64 * basis.step();
    (0..basis.samples).map(at).collect()
}

/// Postures along the trajectory that has this number, from 0.
fn postures(
    skeleton: &Skeleton,
    design: &Design,
    basis: &Basis,
    number: usize,
) -> Option<Postures> {
    let joints = design.coefficients.trajectories[number].iter();
    let own = joints.filter_map(|joint| {
        let [position, ..] = motion(basis, joint)?;
        Some((joint.joint.as_str(), position))
    });
    let moved = design.carried.iter().filter_map(|joint| {
        let position = around(joint.positions.get(number)?, basis.samples);
        Some((joint.joint.as_str(), position))
    });
    let positions: BTreeMap<&str, Vec<f64>> = own.chain(moved).collect();
    Postures::new(skeleton, &times(basis), |name| {
        positions.get(name).map(Vec::as_slice)
    })
}

/// A periodic series at other, equal steps, straight between its points.
fn around(series: &[f64], samples: usize) -> Vec<f64> {
    let at = |k: usize| {
        let place = (k * series.len()) as f64 / samples as f64;
        let before = place as usize;
        let [low, high] = [before, before + 1].map(|k| series[k % series.len()]);
        low + (place - before as f64) * (high - low)
    };
    (0..samples).map(at).collect()
}

fn take(basis: &Basis, number: usize, joints: &[JointCoefficients]) -> Option<Take> {
    let orders: Vec<[Vec<f64>; 3]> = joints
        .iter()
        .map(|joint| motion(basis, joint))
        .collect::<Option<_>>()?;
    let channels = joints.iter().zip(&orders).map(|(joint, orders)| {
        let [lower, upper, velocity, acceleration] = joint.limits;
        let panels = [
            ("position", "", vec![lower, upper]),
            ("speed", "/s", vec![-velocity, velocity]),
            ("acceleration", "/s²", vec![-acceleration, acceleration]),
        ];
        let lines = panels
            .into_iter()
            .zip(orders)
            .map(|((panel, per, levels), y)| Line {
                panel,
                role: "designed",
                unit: format!("{}{per}", joint.unit),
                y: Quantised::of(y),
                levels: levels
                    .into_iter()
                    .filter(|level| level.is_finite())
                    .collect(),
            });
        Channel {
            name: joint.joint.clone(),
            lines: lines.collect(),
            cloud: None,
            spectrum: None,
        }
    });
    Some(Take {
        name: format!("trajectory {number}"),
        kind: "one period".to_string(),
        start: 0.0,
        t: floats(times(basis).into_iter()),
        channels: channels.collect(),
        postures: None,
    })
}

/// Position, velocity and acceleration; `None` where the coefficients do not fit the basis.
pub(in crate::report) fn motion(basis: &Basis, joint: &JointCoefficients) -> Option<[Vec<f64>; 3]> {
    let mut coefficients = vec![joint.q0];
    coefficients.extend(joint.a.iter().chain(&joint.b));
    (coefficients.len() == basis.series.width()).then(|| {
        std::array::from_fn(|order| {
            let mut out = vec![0.0; basis.samples];
            basis.evaluate(order, &coefficients, &mut out);
            out
        })
    })
}
