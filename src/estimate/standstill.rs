//! Rows at which a joint rests: static friction lies anywhere between −Fc and Fc there, and its torque says
//! nothing of parameters. Where the transition speed w of Coulomb friction is known, stretches with
//! |ṁ| <= w for longer than a reversal takes are left out of the fit of that joint.

use crate::chain::dataset::Prepared;
use crate::chain::model::Model;
use crate::estimate::weights::RowFactors;

/// A joint that stays below w for longer rests; reversals pass faster: with w = 0.005 rad/s all that are
/// accelerated by more than 0.04 rad/s².
const LONGEST_REVERSAL_S: f64 = 0.25;

/// Factors 0 at standstill and 1 elsewhere, `[recording][channel][row]`; `None` where nothing stands still.
pub fn factors(model: &Model, recordings: &[&Prepared]) -> Option<RowFactors> {
    let speeds: Vec<Option<f64>> = model
        .channels()
        .iter()
        .map(|channel| {
            // A locked joint always stands, and nothing of it is fitted.
            let joint = channel.joint.filter(|_| channel.active)?;
            let width = model.joints()[joint].width?;
            let parameter = &model.parameters()[width];
            (!parameter.is_free()).then_some(parameter.value)
        })
        .collect();
    let moving = |recording: &&Prepared| -> Vec<Vec<f64>> {
        let dq = recording.segment().motors.dq;
        let reversal = LONGEST_REVERSAL_S * recording.experiment.rate_hz / recording.stride as f64;
        let of = |(channel, speed): (usize, &Option<f64>)| -> Vec<f64> {
            match (speed, model.channels()[channel].joint) {
                (Some(speed), Some(joint)) => of_joint(&dq[joint], (*speed, reversal)),
                _ => vec![1.0; recording.rows()],
            }
        };
        speeds.iter().enumerate().map(of).collect()
    };
    let all: RowFactors = recordings.iter().map(moving).collect();
    let stands = |series: &Vec<f64>| series.contains(&0.0);
    all.iter().flatten().any(stands).then_some(all)
}

/// Factors of one joint: stretches of more than `reversal` rows below the speed count for nothing.
fn of_joint(velocity: &[f64], (speed, reversal): (f64, f64)) -> Vec<f64> {
    let mut factors = vec![1.0; velocity.len()];
    let mut start = 0;
    for row in 0..=velocity.len() {
        if velocity.get(row).is_some_and(|v| v.abs() <= speed) {
            continue;
        }
        if (row - start) as f64 > reversal {
            factors[start..row].fill(0.0);
        }
        start = row + 1;
    }
    factors
}

#[cfg(test)]
mod tests {
    use super::of_joint;

    #[test]
    fn a_rest_is_left_out_and_a_reversal_is_not() {
        let velocity = [1.0, 0.0, 0.1, 0.0, -1.0, 0.1, -1.0, 0.0, 0.0, 0.0, 0.0];
        let factors = of_joint(&velocity, (0.1, 3.0));
        assert_eq!(
            factors,
            [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]
        );
    }
}
