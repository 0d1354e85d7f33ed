//! Shares over the probabilities that were stated for them: what is stated honestly lies on the diagonal.

use plotters::prelude::*;

use crate::report::plots::{Area, Below, Drawn, INK, PREDICTED, RECORDED, axes, draw, line};

/// Size of the drawing; 390 px wide on the page.
const SIZE: (u32, u32) = (780, 620);

/// Room around 0 and 1, so that points at the ends are seen whole.
const RANGE: (f64, f64) = (-0.03, 1.03);

/// A share that was measured, with its interval.
#[derive(Debug, Clone, Copy)]
pub(in crate::report) struct Measured {
    pub stated: f64,
    pub right: f64,
    pub interval: [f64; 2],
}

/// Draws the diagonal and the points with their intervals.
pub(in crate::report) fn agreement(points: &[Measured], x_title: &str, label: &str) -> String {
    draw(SIZE, label, |area| paint(area, points, x_title))
}

fn paint(area: &Area, points: &[Measured], x_title: &str) -> Drawn {
    let mut chart = axes(area, RANGE, RANGE, &Below::Title(x_title))?;
    chart.draw_series(line(&[(0.0, 0.0), (1.0, 1.0)], RECORDED, 2))?;
    for point in points {
        let [low, high] = point.interval;
        chart.draw_series(line(&[(point.stated, low), (point.stated, high)], INK, 2))?;
    }
    let dots = points
        .iter()
        .map(|p| Circle::new((p.stated, p.right), 7, PREDICTED.filled()));
    chart.draw_series(dots)?;
    Ok(())
}
