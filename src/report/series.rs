//! What the plots show: signals and residuals by recording and joint, thinned to what a page holds.

use crate::outcome::predictions::{Predictions, Quantity, RecordingPredictions};
use crate::recording::split::Split;

/// Most points of one line: about one for each pixel column of a still picture; the explorer has more.
pub const LINE_POINTS: usize = 500;

/// Most points of a scatter plot: more of them would only cover each other.
const SCATTER_POINTS: usize = 300;

/// A point of a plot.
pub type Point = (f64, f64);

/// The recordings of a result as the plots show them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Series {
    pub recordings: Vec<RecordingSeries>,
}

/// One recording.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingSeries {
    pub recording: String,
    pub split: Split,
    pub joints: Vec<JointSeries>,
}

/// One joint of a recording: times in s, the rest in the unit of the signal.
#[derive(Debug, Clone, PartialEq)]
pub struct JointSeries {
    pub joint: String,
    pub recorded: Vec<Point>,
    pub predicted: Vec<Point>,
    /// Predicted minus recorded over time.
    pub residual: Vec<Point>,
    /// Predicted minus recorded over speed; empty where the speed was not kept.
    pub residual_of_speed: Vec<Point>,
}

impl Series {
    /// Thins the table of predictions to what the plots show.
    pub fn of(predictions: &Predictions) -> Self {
        let joints: Vec<&str> = predictions
            .columns
            .iter()
            .filter(|column| column.quantity == Quantity::Recorded)
            .map(|column| column.joint.as_str())
            .collect();
        let recordings = predictions
            .recordings
            .iter()
            .map(|recording| RecordingSeries {
                recording: recording.recording.clone(),
                split: recording.split,
                joints: joints
                    .iter()
                    .filter_map(|joint| JointSeries::of(predictions, recording, joint))
                    .collect(),
            })
            .collect();
        Self { recordings }
    }
}

impl JointSeries {
    fn of(table: &Predictions, rows: &RecordingPredictions, joint: &str) -> Option<Self> {
        let values = |quantity| Some(&rows.values[table.column(joint, quantity)?]);
        let recorded = values(Quantity::Recorded)?;
        let predicted = values(Quantity::Predicted).or_else(|| values(Quantity::Final))?;
        let residual: Vec<f64> = predicted.iter().zip(recorded).map(|(p, r)| p - r).collect();
        Some(Self {
            joint: joint.to_string(),
            recorded: envelope(&rows.t, recorded, LINE_POINTS),
            predicted: envelope(&rows.t, predicted, LINE_POINTS),
            residual_of_speed: values(Quantity::Velocity)
                .map(|speed| every_nth(speed, &residual, SCATTER_POINTS))
                .unwrap_or_default(),
            residual: envelope(&rows.t, &residual, LINE_POINTS),
        })
    }
}

/// The line through `(t, y)` with at most `limit` points (at least 2): of each of `limit / 2`
/// equal stretches its least and greatest value, in the order of time. Values that are not finite
/// are left out.
pub fn envelope(t: &[f64], y: &[f64], limit: usize) -> Vec<Point> {
    let points: Vec<Point> = finite_points(t, y).collect();
    if points.len() <= limit.max(2) {
        return points;
    }
    let stretches = (limit / 2).max(1);
    let bound = |k: usize| k * points.len() / stretches;
    (0..stretches)
        .flat_map(|k| extremes(&points[bound(k)..bound(k + 1)]))
        .collect()
}

/// Points of least and greatest value, in the order in which they stand; one if they are the same.
fn extremes(points: &[Point]) -> impl Iterator<Item = Point> + use<> {
    let mut low = 0;
    let mut high = 0;
    for (index, point) in points.iter().enumerate() {
        if point.1 < points[low].1 {
            low = index;
        }
        if point.1 > points[high].1 {
            high = index;
        }
    }
    let first = points.get(low.min(high)).copied();
    let second = points.get(low.max(high)).copied().filter(|_| low != high);
    first.into_iter().chain(second)
}

/// Points at equal distances in the series, at most `limit` of them.
fn every_nth(x: &[f64], y: &[f64], limit: usize) -> Vec<Point> {
    let step = x.len().div_ceil(limit).max(1);
    finite_points(x, y).step_by(step).collect()
}

fn finite_points<'a>(x: &'a [f64], y: &'a [f64]) -> impl Iterator<Item = Point> + use<'a> {
    let both = x.iter().copied().zip(y.iter().copied());
    both.filter(|(x, y)| x.is_finite() && y.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_the_envelope_keeps_extremes_order_and_limit() {
        let t: Vec<f64> = (0..100_003).map(f64::from).collect();
        let mut y: Vec<f64> = t.iter().map(|t| (0.37 * t).sin()).collect();
        y[31_415] = 7.0;
        y[92_653] = -9.0;
        y[500] = f64::NAN;
        let line = envelope(&t, &y, 1000);
        assert!(line.len() <= 1000 && line.len() > 900);
        assert!(line.contains(&(31_415.0, 7.0)));
        assert!(line.contains(&(92_653.0, -9.0)));
        assert!(line.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }

    #[test]
    fn short_lines_and_constant_lines_stay_as_they_are() {
        let t: Vec<f64> = (0..10).map(f64::from).collect();
        assert_eq!(envelope(&t, &t, 10).len(), 10);
        assert_eq!(envelope(&[], &[], 10), []);
        assert_eq!(envelope(&t, &[3.0; 10], 4), [(0.0, 3.0), (5.0, 3.0)]);
    }

    #[test]
    fn residuals_are_predicted_minus_recorded() {
        use crate::outcome::predictions::Column;
        let table = Predictions {
            columns: [Quantity::Recorded, Quantity::Predicted, Quantity::Velocity]
                .map(|quantity| Column {
                    joint: "a".to_string(),
                    quantity,
                })
                .into(),
            recordings: vec![RecordingPredictions {
                recording: "r".to_string(),
                split: Split::Train,
                t: vec![0.0, 1.0],
                values: vec![vec![1.0, 2.0], vec![1.5, 1.0], vec![0.1, 0.2]],
            }],
        };
        let series = Series::of(&table);
        let joint = &series.recordings[0].joints[0];
        assert_eq!(joint.residual, [(0.0, 0.5), (1.0, -1.0)]);
        assert_eq!(joint.residual_of_speed, [(0.1, 0.5), (0.2, -1.0)]);
    }
}
