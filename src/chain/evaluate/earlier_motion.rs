//! The motion of a segment as it was some time before, between the samples.

use crate::chain::evaluate::segment::Segment;
use crate::robot::batch::Trajectory;
use crate::stats::range::within;

/// Times and motion as they were `delay` before every sample, s.
pub fn earlier(segment: Segment<'_>, delay: f64) -> (Vec<f64>, [Vec<Vec<f64>>; 3]) {
    let time = segment.time.iter().map(|t| t - delay).collect();
    (time, shift(segment, delay))
}

/// A time between a row and the next, with the weights of their values and of their slopes.
struct Place {
    before: usize,
    values: [f64; 2],
    slopes: [f64; 2],
}

impl Place {
    /// At a share of the way from a row to the next, which is so many seconds apart: cubic Hermite.
    fn after(before: usize, share: f64, apart: f64) -> Self {
        let s = share;
        let (s2, s3) = (s * s, s * s * s);
        Self {
            before,
            values: [2.0 * s3 - 3.0 * s2 + 1.0, 3.0 * s2 - 2.0 * s3],
            slopes: [apart * (s3 - 2.0 * s2 + s), apart * (s3 - s2)],
        }
    }

    /// The value between the k-th of a series and the next.
    fn of(&self, k: usize, x: &[f64], slopes: &[f64]) -> f64 {
        let ([va, vb], [sa, sb]) = (self.values, self.slopes);
        va * x[k] + vb * x[k + 1] + sa * slopes[k] + sb * slopes[k + 1]
    }
}

/// Where t − delay lies, for every row.
enum Places {
    /// In a motion that comes round: of every row as of the first, so many rows further on.
    Alike(Place),
    /// Behind a row of its own.
    Each(Vec<Place>),
}

impl Places {
    fn of(segment: Segment<'_>, delay: f64) -> Self {
        let (samples, time) = (segment.time.len(), segment.time);
        if segment.cyclic {
            let at = -delay / segment.step();
            let before = at.floor().rem_euclid(samples as f64) as usize;
            let share = at - at.floor();
            return Self::Alike(Place::after(before.min(samples - 1), share, segment.step()));
        }
        let mut before = 0;
        let of = |now: &f64| {
            let then = within(now - delay, [time[0], time[samples - 1]]);
            while before + 2 < samples && time[before + 1] <= then {
                before += 1;
            }
            let apart = time[before + 1] - time[before];
            Place::after(before, (then - time[before]) / apart, apart)
        };
        Self::Each(time.iter().map(of).collect())
    }

    /// A series with its slopes at these places.
    fn along(&self, x: &[f64], slopes: &[f64]) -> Vec<f64> {
        match self {
            Self::Alike(place) => {
                // From there once around, to where it began.
                let around = |x: &[f64]| [&x[place.before..], &x[..=place.before]].concat();
                let (around, slopes) = (around(x), around(slopes));
                let rows = 0..x.len();
                rows.map(|k| place.of(k, &around, &slopes)).collect()
            }
            Self::Each(places) => {
                let of = |place: &Place| place.of(place.before, x, slopes);
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
