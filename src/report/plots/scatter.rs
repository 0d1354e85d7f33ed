//! Residual over speed: friction that the model lacks shows as a curve here, noise as a cloud.

use plotters::prelude::*;

use crate::report::plots::{Area, Below, Drawn, RESIDUAL, axes, draw, padded_range};
use crate::report::series::Point;

/// Size of the drawing; 520 px wide on the page.
const SIZE: (u32, u32) = (1040, 460);

/// Draws residuals over speeds; `x_title` names the axis of the speed.
pub(in crate::report) fn scatter(points: &[Point], x_title: &str, label: &str) -> String {
    draw(SIZE, label, |area| paint(area, points, x_title))
}

fn paint(area: &Area, points: &[Point], x_title: &str) -> Drawn {
    let x = padded_range(points.iter().map(|p| p.0));
    let y = padded_range(points.iter().map(|p| p.1));
    let mut chart = axes(area, x, y, &Below::Title(x_title))?;
    let dots = points
        .iter()
        .map(|point| Circle::new(*point, 3, RESIDUAL.mix(0.5).filled()));
    chart.draw_series(dots)?;
    Ok(())
}
