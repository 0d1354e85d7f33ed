//! Recorded and predicted signal of one joint over time, with the residual below on its own scale.

use crate::report::plots::{
    Area, Drawn, PREDICTED, RECORDED, RESIDUAL, axes, draw, line, padded_range,
};
use crate::report::series::{JointSeries, Point};

/// Size of the drawing; 520 px wide on the page.
const SIZE: (u32, u32) = (1040, 720);

/// Height of the upper part.
const SIGNAL_HEIGHT: u32 = 430;

/// Draws the signals of a joint.
pub(in crate::report) fn signals(series: &JointSeries, label: &str) -> String {
    draw(SIZE, label, |area| paint(area, series))
}

fn paint(area: &Area, series: &JointSeries) -> Drawn {
    let (upper, lower) = area.split_vertically(SIGNAL_HEIGHT);
    let both = || series.recorded.iter().chain(&series.predicted);
    let (start, end) = time_range(&series.recorded);
    let mut chart = axes(&upper, (start, end), padded_range(both().map(|p| p.1)), "")?;
    // The prediction is thinner and on top: where the two agree, both can be seen.
    chart.draw_series(line(&series.recorded, RECORDED, 5))?;
    chart.draw_series(line(&series.predicted, PREDICTED, 2))?;

    let residuals = padded_range(series.residual.iter().map(|p| p.1).chain([0.0]));
    let mut chart = axes(&lower, (start, end), residuals, "t [s]")?;
    chart.draw_series(line(&[(start, 0.0), (end, 0.0)], RECORDED, 2))?;
    chart.draw_series(line(&series.residual, RESIDUAL, 2))?;
    Ok(())
}

/// First and last time, apart even for a single sample.
fn time_range(points: &[Point]) -> (f64, f64) {
    match (points.first(), points.last()) {
        (Some(first), Some(last)) if first.0 < last.0 => (first.0, last.0),
        (Some(first), _) => (first.0, first.0 + 1.0),
        _ => (0.0, 1.0),
    }
}
