//! Standstill: rows at which a joint does not move. Static friction lies anywhere between −Fc and Fc there, and its torque says
//! nothing of parameters. A joint stands where its speed cannot be told from zero, `|ṁ| <= 3σ` with the deviation σ of the
//! error of the speed, for longer than a reversal takes, and within half a period of the motion's bandwidth before and after
//! where its position is not told from that of its rest by one sample: a smooth motion does not tell more closely when a joint
//! came to rest. Where the transition speed w of Coulomb friction is known it also stands where it creeps, `|ṁ| <= w`. Such
//! stretches are left out of the fit of that joint, and of what its errors are said to be.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::model::Model;
use crate::estimate::residual::weights::RowFactors;

/// A joint that stays below w for longer creeps; reversals pass faster: with w = 0.005 rad/s all that are
/// accelerated by more than 0.04 rad/s².
const LONGEST_REVERSAL_S: f64 = 0.25;

/// A joint whose speed is not seen for longer rests: with an error of 0.5 mrad/s all reversals pass faster that are
/// accelerated by more than 0.03 rad/s².
const UNSEEN_S: f64 = 0.1;

/// Deviations of the error of a speed up to which it is not told from zero.
const UNSEEN: f64 = 3.0;

/// Factors 0 at standstill and 1 elsewhere, `[recording][channel][row]`; `None` where nothing stands still.
pub fn factors(model: &Model, recordings: &[&Prepared]) -> Option<RowFactors> {
    // A locked joint always stands, and nothing of it is fitted.
    let with_friction = |c: usize| {
        let channel = &model.channels()[c];
        let joint = channel.joint.filter(|_| channel.active)?;
        Some((joint, model.joints()[joint].width?))
    };
    let joints: Vec<Option<(usize, usize)>> =
        (0..model.channels().len()).map(with_friction).collect();
    let moving = |recording: &&Prepared| -> Vec<Vec<f64>> {
        let of = |joint: &Option<(usize, usize)>| match joint {
            Some((joint, width)) => of_joint(model, recording, *joint, *width),
            None => vec![1.0; recording.rows()],
        };
        joints.iter().map(of).collect()
    };
    let all: RowFactors = recordings.iter().map(moving).collect();
    let stands = |series: &Vec<f64>| series.contains(&0.0);
    all.iter().flatten().any(stands).then_some(all)
}

/// The dataset in which channels count for nothing where their joints stand still. A joint that never moves is judged at rest: how
/// badly the model does there is all that is known of it.
pub fn left_out(model: &Model, data: Dataset) -> Dataset {
    let all: Vec<&Prepared> = data.recordings.iter().collect();
    let Some(factors) = factors(model, &all) else {
        return data;
    };
    let moves = |c: usize| factors.iter().any(|of| of[c].iter().any(|f| *f != 0.0));
    let moves: Vec<bool> = (0..model.channels().len()).map(moves).collect();
    let pairs = data.recordings.into_iter().zip(&factors);
    let recordings = pairs.map(|(recording, factors)| {
        let stands = |c: usize| -> Vec<bool> {
            let series = factors[c].iter();
            series.map(|factor| moves[c] && *factor == 0.0).collect()
        };
        let standing: Vec<Vec<bool>> = (0..moves.len()).map(stands).collect();
        recording.with_standstill(&standing)
    });
    Dataset {
        recordings: recordings.collect(),
    }
}

fn of_joint(model: &Model, recording: &Prepared, joint: usize, width: usize) -> Vec<f64> {
    let motors = recording.segment().motors;
    let (position, velocity) = (&motors.q[joint], &motors.dq[joint]);
    let experiment = &recording.experiment;
    let rate_hz = experiment.rate_hz / recording.stride as f64;
    let mut factors = vec![1.0; velocity.len()];
    if let Some(error) = &experiment.motion_error {
        // White noise of samples of which the band of a motion keeps its share.
        let per_period = rate_hz / experiment.bandwidth[joint].cutoff_hz;
        let of_sample = error.position.deviation(joint) * (0.5 * per_period).max(1.0).sqrt();
        let unseen = Standstill {
            speed: UNSEEN * error.velocity.deviation(joint),
            longest: UNSEEN_S * rate_hz,
            around: Around {
                rows: (0.5 * per_period).round() as usize,
                way: UNSEEN * of_sample,
            },
        };
        unseen.leave_out(&mut factors, position, velocity);
    }
    let width = &model.parameters()[model.estimated_as(width)];
    if !width.is_free() {
        let creeping = Standstill {
            speed: width.value,
            longest: LONGEST_REVERSAL_S * rate_hz,
            around: Around::default(),
        };
        creeping.leave_out(&mut factors, position, velocity);
    }
    factors
}

/// What counts as standstill.
struct Standstill {
    /// rad/s (m/s), at most.
    speed: f64,
    /// Rows of a reversal, which is none.
    longest: f64,
    around: Around,
}

/// Rows before and after a standstill that may belong to it.
#[derive(Default)]
struct Around {
    /// So many at most.
    rows: usize,
    /// rad (m), as far as the position is at most from that of the standstill.
    way: f64,
}

impl Standstill {
    /// Stretches of standstill count for nothing.
    fn leave_out(&self, factors: &mut [f64], position: &[f64], velocity: &[f64]) {
        let rows = velocity.len();
        let mut start = 0;
        for row in 0..=rows {
            if velocity.get(row).is_some_and(|v| v.abs() <= self.speed) {
                continue;
            }
            if (row - start) as f64 > self.longest {
                factors[start..row].fill(0.0);
                let is_near =
                    |k: &usize, end: usize| (position[*k] - position[end]).abs() <= self.around.way;
                let before = start.saturating_sub(self.around.rows)..start;
                let before = before.rev().take_while(|k| is_near(k, start));
                let behind = row..rows.min(row + self.around.rows);
                let behind = behind.take_while(|k| is_near(k, row - 1));
                before.chain(behind).for_each(|k| factors[k] = 0.0);
            }
            start = row + 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Around, Standstill};

    #[test]
    fn a_rest_is_left_out_and_a_reversal_is_not() {
        let velocity = [1.0, 0.0, 0.1, 0.0, -1.0, 0.1, -1.0, 0.0, 0.0, 0.0, 0.0, 2.0];
        let position = [
            -9.0, -8.0, -7.0, -1.0, -0.4, -0.2, -0.1, 0.0, 0.0, 0.0, 0.0, 0.4,
        ];
        let left = |rows: usize| {
            let standstill = Standstill {
                speed: 0.1,
                longest: 3.0,
                around: Around { rows, way: 0.3 },
            };
            let mut factors = vec![1.0; velocity.len()];
            standstill.leave_out(&mut factors, &position, &velocity);
            (0..factors.len())
                .filter(|k| factors[*k] == 0.0)
                .collect::<Vec<_>>()
        };
        assert_eq!(left(0), [7, 8, 9, 10]);
        assert_eq!(left(1), [6, 7, 8, 9, 10]);
        // As far as the position is that of the rest.
        assert_eq!(left(4), [5, 6, 7, 8, 9, 10]);
    }
}
