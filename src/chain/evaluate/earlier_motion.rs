//! The motion of a segment as it was some time before, between the samples.

use crate::chain::evaluate::segment::Segment;
use crate::robot::batch::Trajectory;
use crate::stats::range::within;

/// Times and motion as they were `delay` before every sample, s.
pub fn earlier(segment: Segment<'_>, delay: f64) -> (Vec<f64>, [Vec<Vec<f64>>; 3]) {
    let time = segment.time.iter().map(|t| t - delay).collect();
    (time, shift(segment, delay))
}

/// Weights of values and of slopes at two rows, for a time between them.
#[derive(Clone, Copy)]
struct Weights {
    values: [f64; 2],
    slopes: [f64; 2],
}

impl Weights {
    /// At a share of the way between two rows that are so many seconds apart: cubic Hermite.
    fn between(share: f64, apart: f64) -> Self {
        let s = share;
        let (s2, s3) = (s * s, s * s * s);
        Self {
            values: [2.0 * s3 - 3.0 * s2 + 1.0, 3.0 * s2 - 2.0 * s3],
            slopes: [apart * (s3 - 2.0 * s2 + s), apart * (s3 - s2)],
        }
    }

    fn of(&self, values: [f64; 2], slopes: [f64; 2]) -> f64 {
        let along = |weights: [f64; 2], of: [f64; 2]| weights[0] * of[0] + weights[1] * of[1];
        along(self.values, values) + along(self.slopes, slopes)
    }
}

/// Where t − delay lies, for every row.
enum Places {
    /// In a motion that comes round: equally far behind the row that is so many rows further on.
    Alike(usize, Weights),
    /// After a row of its own.
    Each(Vec<(usize, Weights)>),
}

impl Places {
    fn of(segment: Segment<'_>, delay: f64) -> Self {
        let (samples, time) = (segment.time.len(), segment.time);
        if segment.cyclic {
            let at = -delay / segment.step();
            let before = at.floor().rem_euclid(samples as f64) as usize;
            let weights = Weights::between(at - at.floor(), segment.step());
            return Self::Alike(before.min(samples - 1), weights);
        }
        let mut before = 0;
        let of = |now: &f64| {
            let then = within(now - delay, [time[0], time[samples - 1]]);
            while before + 2 < samples && time[before + 1] <= then {
                before += 1;
            }
            let apart = time[before + 1] - time[before];
            let share = (then - time[before]) / apart;
            (before, Weights::between(share, apart))
        };
        Self::Each(time.iter().map(of).collect())
    }

    /// A series with its slopes at these places.
    fn along(&self, x: &[f64], slopes: &[f64]) -> Vec<f64> {
        match self {
            Self::Alike(before, weights) => {
                // From there once around, to where it began.
                let around = |x: &[f64]| [&x[*before..], &x[..=*before]].concat();
                let (x, slopes) = (around(x), around(slopes));
                let pairs = x.windows(2).zip(slopes.windows(2));
                let of = |(x, slopes): (&[f64], &[f64])| {
                    weights.of([x[0], x[1]], [slopes[0], slopes[1]])
                };
                pairs.map(of).collect()
            }
            Self::Each(places) => {
                let at = |x: &[f64], k: usize| [x[k], x[k + 1]];
                let of = |(k, weights): &(usize, Weights)| weights.of(at(x, *k), at(slopes, *k));
                places.iter().map(of).collect()
            }
        }
    }
}

/// Slopes of a series, by central differences.
fn slopes(x: &[f64], segment: Segment<'_>) -> Vec<f64> {
    let (samples, h, time) = (x.len(), segment.step(), segment.time);
    let of = |k: usize| {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(samples - 1));
        (x[after] - x[before]) / (time[after] - time[before])
    };
    if !segment.cyclic {
        return (0..samples).map(of).collect();
    }
    let around = [&x[samples - 1..], x, &x[..1]].concat();
    let of = |three: &[f64]| (three[2] - three[0]) / (2.0 * h);
    around.windows(3).map(of).collect()
}

/// The motion at t − delay: cubic Hermite of position and velocity, and of velocity and acceleration; for
/// the acceleration the cubic through four neighbours' slopes.
fn shift(segment: Segment<'_>, delay: f64) -> [Vec<Vec<f64>>; 3] {
    let places = Places::of(segment, delay);
    let Trajectory { q, dq, ddq } = segment.motors;
    let pairs = |x: &[Vec<f64>], slopes: &[Vec<f64>]| -> Vec<Vec<f64>> {
        let pairs = x.iter().zip(slopes);
        pairs.map(|(x, slopes)| places.along(x, slopes)).collect()
    };
    let jerk: Vec<Vec<f64>> = ddq.iter().map(|x| slopes(x, segment)).collect();
    [pairs(q, dq), pairs(dq, ddq), pairs(ddq, &jerk)]
}
