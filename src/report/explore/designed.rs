//! The trajectories of a design over one period, from their coefficients.

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
        .filter_map(|(k, joints)| take(&basis, k + 1, joints, skeleton))
        .collect()
}

fn take(
    basis: &Basis,
    number: usize,
    joints: &[JointCoefficients],
    skeleton: Option<&Skeleton>,
) -> Option<Take> {
    let t: Vec<f64> = (0..basis.samples)
        .map(|k| k as f64 * basis.step())
        .collect();
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
    let postures = skeleton.and_then(|skeleton| {
        Postures::new(skeleton, &t, |name| {
            let own = joints.iter().position(|joint| joint.joint == name)?;
            Some(&orders[own][0])
        })
    });
    Some(Take {
        name: format!("trajectory {number}"),
        kind: "one period".to_string(),
        start: 0.0,
        t: floats(t.iter().copied()),
        channels: channels.collect(),
        postures,
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
