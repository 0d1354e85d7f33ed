//! A law over what it depends on: values found one by one as dots, the law that was fitted to them as lines.

use plotters::prelude::*;

use crate::report::plots::{Area, Below, Drawn, INK, PREDICTED, axes, draw, line, padded_range};
use crate::report::series::Point;

/// Size of the drawing; half of it on the page.
const SIZE: (u32, u32) = (1040, 420);

/// Draws dots and lines; `x_title` names the horizontal axis.
pub(in crate::report) fn law(
    dots: &[Point],
    lines: &[Vec<Point>],
    x_title: &str,
    label: &str,
) -> String {
    draw(SIZE, label, |area| paint(area, dots, lines, x_title))
}

fn paint(area: &Area, dots: &[Point], lines: &[Vec<Point>], x_title: &str) -> Drawn {
    let all = || dots.iter().chain(lines.iter().flatten());
    let x = padded_range(all().map(|p| p.0));
    let y = padded_range(all().map(|p| p.1));
    let mut chart = axes(area, x, y, &Below::Title(x_title))?;
    for points in lines {
        chart.draw_series(line(points, PREDICTED, 4))?;
    }
    let dots = dots
        .iter()
        .map(|point| Circle::new(*point, 7, INK.filled()));
    chart.draw_series(dots)?;
    Ok(())
}
