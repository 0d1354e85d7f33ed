//! Channels that are recorded late: `s(t) = s_true(t − delay)`, from the motion at t − delay.

use crate::chain::evaluate::{Evaluator, Segment};
use crate::robot::batch::Trajectory;

/// Step of the difference that gives ∂s/∂delay, as a share of the time between samples: rounding leaves
/// seven digits, and the motion between samples is a smooth polynomial.
const STEP: f64 = 2e-5;

impl Evaluator<'_> {
    /// Every channel with its own delay; channels that share one share the evaluation.
    pub(super) fn delayed(&mut self, segment: Segment<'_>) {
        let samples = segment.motors.len();
        let channels = self.model.channels();
        let of_joint = |joint: usize| {
            let delay = self.model.joints()[joint].delay;
            delay.map_or((0.0, None), |at| (self.values[at], self.column[at]))
        };
        let wanted: Vec<(f64, Option<usize>)> = channels
            .iter()
            .map(|channel| match (channel.joint, channel.active) {
                (Some(joint), true) => of_joint(joint),
                _ => (0.0, None),
            })
            .collect();
        let mut distinct: Vec<f64> = wanted.iter().map(|(delay, _)| *delay).collect();
        distinct.sort_by(f64::total_cmp);
        distinct.dedup();
        let mut whole = self.block.clone();
        whole.clear(samples);
        for delay in distinct {
            let members: Vec<usize> = (0..wanted.len())
                .filter(|&c| wanted[c].0 == delay)
                .collect();
            self.shifted(segment, delay);
            for &c in &members {
                whole.take_channel(c, &self.block);
            }
            let columns: Vec<(usize, usize)> = members
                .iter()
                .filter_map(|&c| Some((c, wanted[c].1?)))
                .collect();
            if columns.is_empty() {
                continue;
            }
            let step = STEP * (segment.time[1] - segment.time[0]);
            let ahead = self.shifted_values(segment, delay + step);
            let behind = self.shifted_values(segment, delay - step);
            for (c, column) in columns {
                let series = whole.series(c, column);
                for (k, to) in series[..samples].iter_mut().enumerate() {
                    *to += (ahead[c][k] - behind[c][k]) / (2.0 * step);
                }
            }
        }
        self.block = whole;
    }

    fn shifted(&mut self, segment: Segment<'_>, delay: f64) {
        let samples = segment.motors.len();
        if delay == 0.0 || samples < 2 {
            self.states(segment, 0..samples);
            return;
        }
        let [q, dq, ddq] = shift(segment, delay);
        let time: Vec<f64> = segment.time.iter().map(|t| t - delay).collect();
        let moved = Segment {
            motors: Trajectory {
                q: &q,
                dq: &dq,
                ddq: &ddq,
            },
            time: &time,
            ..segment
        };
        self.states(moved, 0..samples);
    }

    fn shifted_values(&mut self, segment: Segment<'_>, delay: f64) -> Vec<Vec<f64>> {
        let none = vec![None; self.column.len()];
        let columns = std::mem::replace(&mut self.column, none);
        self.shifted(segment, delay);
        self.column = columns;
        self.block.values.clone()
    }
}

/// The motion at t − delay: cubic Hermite of position and velocity, and of velocity and acceleration; for
/// the acceleration the cubic through four neighbours' slopes.
fn shift(segment: Segment<'_>, delay: f64) -> [Vec<Vec<f64>>; 3] {
    let (samples, h) = (segment.time.len(), segment.time[1] - segment.time[0]);
    let place = |k: usize| -> (usize, usize, f64) {
        let at = k as f64 - delay / h;
        if segment.cyclic {
            let at = at.rem_euclid(samples as f64);
            let before = (at.floor() as usize).min(samples - 1);
            (before, (before + 1) % samples, at - before as f64)
        } else {
            let at = at.clamp(0.0, (samples - 1) as f64);
            let before = (at.floor() as usize).min(samples - 2);
            (before, before + 1, at - before as f64)
        }
    };
    let hermite = |x: &[f64], slope: &dyn Fn(usize) -> f64, k: usize| {
        let (a, b, s) = place(k);
        let (s2, s3) = (s * s, s * s * s);
        (2.0 * s3 - 3.0 * s2 + 1.0) * x[a]
            + (3.0 * s2 - 2.0 * s3) * x[b]
            + h * ((s3 - 2.0 * s2 + s) * slope(a) + (s3 - s2) * slope(b))
    };
    let central = |x: &[f64], k: usize| {
        let (before, after) = match (segment.cyclic, k) {
            (true, _) => ((k + samples - 1) % samples, (k + 1) % samples),
            (false, 0) => (0, 1),
            (false, _) => (k - 1, (k + 1).min(samples - 1)),
        };
        let steps = if segment.cyclic || (k > 0 && k + 1 < samples) {
            2.0
        } else {
            1.0
        };
        (x[after] - x[before]) / (steps * h)
    };
    let Trajectory { q, dq, ddq } = segment.motors;
    let joints = 0..q.len();
    let along = |x: &[f64], slope: &dyn Fn(usize) -> f64| -> Vec<f64> {
        (0..samples).map(|k| hermite(x, slope, k)).collect()
    };
    [
        joints
            .clone()
            .map(|j| along(&q[j], &|k| dq[j][k]))
            .collect(),
        joints
            .clone()
            .map(|j| along(&dq[j], &|k| ddq[j][k]))
            .collect(),
        joints
            .map(|j| along(&ddq[j], &|k| central(&ddq[j], k)))
            .collect(),
    ]
}
