//! The motion of a segment as it was some time before, between the samples.

use crate::chain::evaluate::segment::Segment;
use crate::robot::batch::Trajectory;
use crate::stats::range::within;

/// Times and motion as they were `delay` before every sample, s.
pub fn earlier(segment: Segment<'_>, delay: f64) -> (Vec<f64>, [Vec<Vec<f64>>; 3]) {
    let time = segment.time.iter().map(|t| t - delay).collect();
    (time, shift(segment, delay))
}

/// A time between two rows: their numbers, and the weights of their values and of their slopes.
struct Place {
    rows: [usize; 2],
    values: [f64; 2],
    slopes: [f64; 2],
}

impl Place {
    /// At a share of the way between two rows that are so many seconds apart: cubic Hermite.
    fn between(rows: [usize; 2], share: f64, apart: f64) -> Self {
        let s = share;
        let (s2, s3) = (s * s, s * s * s);
        Self {
            rows,
            values: [2.0 * s3 - 3.0 * s2 + 1.0, 3.0 * s2 - 2.0 * s3],
            slopes: [apart * (s3 - 2.0 * s2 + s), apart * (s3 - s2)],
        }
    }
}

/// t − delay, for every row.
fn places(segment: Segment<'_>, delay: f64) -> Vec<Place> {
    let (samples, h) = (segment.time.len(), segment.step());
    if segment.cyclic {
        let of = |k: usize| {
            let at = (k as f64 - delay / h).rem_euclid(samples as f64);
            let before = (at.floor() as usize).min(samples - 1);
            Place::between([before, (before + 1) % samples], at - before as f64, h)
        };
        return (0..samples).map(of).collect();
    }
    let time = segment.time;
    let mut before = 0;
    let mut of = |now: &f64| {
        let then = within(now - delay, [time[0], time[samples - 1]]);
        while before + 2 < samples && time[before + 1] <= then {
            before += 1;
        }
        let apart = time[before + 1] - time[before];
        Place::between([before, before + 1], (then - time[before]) / apart, apart)
    };
    time.iter().map(&mut of).collect()
}

/// Slopes of a series, by central differences.
fn slopes(x: &[f64], segment: Segment<'_>) -> Vec<f64> {
    let (samples, h, time) = (x.len(), segment.step(), segment.time);
    let of = |k: usize| {
        if segment.cyclic {
            let (before, after) = ((k + samples - 1) % samples, (k + 1) % samples);
            return (x[after] - x[before]) / (2.0 * h);
        }
        let (before, after) = (k.saturating_sub(1), (k + 1).min(samples - 1));
        (x[after] - x[before]) / (time[after] - time[before])
    };
    (0..samples).map(of).collect()
}

/// The motion at t − delay: cubic Hermite of position and velocity, and of velocity and acceleration; for
/// the acceleration the cubic through four neighbours' slopes.
fn shift(segment: Segment<'_>, delay: f64) -> [Vec<Vec<f64>>; 3] {
    let places = places(segment, delay);
    let along = |x: &[f64], slope: &[f64]| -> Vec<f64> {
        let of = |place: &Place| {
            let ([a, b], [va, vb], [sa, sb]) = (place.rows, place.values, place.slopes);
            va * x[a] + vb * x[b] + sa * slope[a] + sb * slope[b]
        };
        places.iter().map(of).collect()
    };
    let Trajectory { q, dq, ddq } = segment.motors;
    let pairs = |x: &[Vec<f64>], slope: &[Vec<f64>]| -> Vec<Vec<f64>> {
        x.iter().zip(slope).map(|(x, s)| along(x, s)).collect()
    };
    let jerk: Vec<Vec<f64>> = ddq.iter().map(|x| slopes(x, segment)).collect();
    [pairs(q, dq), pairs(dq, ddq), pairs(ddq, &jerk)]
}
