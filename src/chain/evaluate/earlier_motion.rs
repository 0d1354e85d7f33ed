//! The motion of a segment as it was some time before, between the samples.

use crate::chain::evaluate::segment::Segment;
use crate::robot::batch::Trajectory;
use crate::stats::range::within;

/// Times and motion as they were `delay` before every sample, s.
pub fn earlier(segment: Segment<'_>, delay: f64) -> (Vec<f64>, [Vec<Vec<f64>>; 3]) {
    let time = segment.time.iter().map(|t| t - delay).collect();
    (time, shift(segment, delay))
}

/// A row between two others: their numbers, and the weights of their values and of their slopes.
struct Place {
    rows: [usize; 2],
    values: [f64; 2],
    slopes: [f64; 2],
}

/// Cubic Hermite at t − delay, for every row.
fn places(segment: Segment<'_>, delay: f64) -> Vec<Place> {
    let (samples, h) = (segment.time.len(), segment.time[1] - segment.time[0]);
    let of = |k: usize| {
        let at = k as f64 - delay / h;
        let (at, before) = if segment.cyclic {
            let at = at.rem_euclid(samples as f64);
            (at, (at.floor() as usize).min(samples - 1))
        } else {
            let at = within(at, [0.0, (samples - 1) as f64]);
            (at, (at.floor() as usize).min(samples - 2))
        };
        let s = at - before as f64;
        let (s2, s3) = (s * s, s * s * s);
        Place {
            rows: [before, (before + 1) % samples],
            values: [2.0 * s3 - 3.0 * s2 + 1.0, 3.0 * s2 - 2.0 * s3],
            slopes: [h * (s3 - 2.0 * s2 + s), h * (s3 - s2)],
        }
    };
    (0..samples).map(of).collect()
}

/// Slopes of a series, by central differences.
fn slopes(x: &[f64], segment: Segment<'_>) -> Vec<f64> {
    let (samples, h) = (x.len(), segment.time[1] - segment.time[0]);
    let of = |k: usize| {
        let (before, after, steps) = match (segment.cyclic, k) {
            (true, _) => ((k + samples - 1) % samples, (k + 1) % samples, 2.0),
            (false, 0) => (0, 1, 1.0),
            (false, _) if k + 1 == samples => (k - 1, k, 1.0),
            (false, _) => (k - 1, k + 1, 2.0),
        };
        (x[after] - x[before]) / (steps * h)
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
