//! The motion of a segment as it was some time before, between the samples.

use crate::chain::evaluate::segment::Segment;
use crate::robot::batch::Trajectory;
use crate::stats::range::within;

/// The motion of a segment, for any delay.
pub struct EarlierMotion<'s> {
    /// As it was recorded.
    pub segment: Segment<'s>,
    jerk: Vec<Vec<f64>>,
}

impl<'s> EarlierMotion<'s> {
    /// Of a segment.
    pub fn of(segment: Segment<'s>) -> Self {
        let series = segment.motors.ddq.iter();
        Self {
            segment,
            jerk: series.map(|x| slopes(x, segment)).collect(),
        }
    }

    /// Times and motion as they were `delay` before every sample, s: cubic Hermite of position and velocity, and of velocity and
    /// acceleration; for the acceleration the cubic through four neighbours' slopes.
    pub fn at(&self, delay: f64) -> (Vec<f64>, [Vec<Vec<f64>>; 3]) {
        let places = Places::of(self.segment, delay);
        let Trajectory { q, dq, ddq } = self.segment.motors;
        let pairs = |x: &[Vec<f64>], slopes: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let pairs = x.iter().zip(slopes);
            pairs.map(|(x, slopes)| places.along(x, slopes)).collect()
        };
        let time = self.segment.time.iter().map(|t| t - delay).collect();
        (time, [pairs(q, dq), pairs(dq, ddq), pairs(ddq, &self.jerk)])
    }
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

    /// The value between two values of a series that follow each other.
    fn of(&self, [a, b]: [usize; 2], x: &[f64], slopes: &[f64]) -> f64 {
        let ([va, vb], [sa, sb]) = (self.values, self.slopes);
        va * x[a] + vb * x[b] + sa * slopes[a] + sb * slopes[b]
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
            // Times differ by much less than they are: as differences they are not rounded.
            let since = within((now - time[before]) - delay, [0.0, apart]);
            Place::after(before, since / apart, apart)
        };
        Self::Each(time.iter().map(of).collect())
    }

    /// A series with its slopes at these places.
    fn along(&self, x: &[f64], slopes: &[f64]) -> Vec<f64> {
        match self {
            Self::Alike(place) => {
                let last = x.len() - 1;
                let of = |a: usize, b: usize| place.of([a, b], x, slopes);
                // From there once around, to where it began.
                let mut along = Vec::with_capacity(x.len());
                along.extend((place.before..last).map(|k| of(k, k + 1)));
                along.push(of(last, 0));
                along.extend((0..place.before).map(|k| of(k, k + 1)));
                along
            }
            Self::Each(places) => {
                let of = |place: &Place| place.of([place.before, place.before + 1], x, slopes);
                places.iter().map(of).collect()
            }
        }
    }
}

/// Slopes of a series, by central differences; of fewer samples than two there are none.
fn slopes(x: &[f64], segment: Segment<'_>) -> Vec<f64> {
    let (samples, time) = (x.len(), segment.time);
    if samples < 2 {
        return vec![0.0; samples];
    }
    let of = |k: usize| {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(samples - 1));
        (x[after] - x[before]) / (time[after] - time[before])
    };
    if !segment.cyclic {
        return (0..samples).map(of).collect();
    }
    let around = [&x[samples - 1..], x, &x[..1]].concat();
    let apart = 2.0 * segment.step();
    let of = |three: &[f64]| (three[2] - three[0]) / apart;
    around.windows(3).map(of).collect()
}
