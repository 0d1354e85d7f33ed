//! Lines over a common axis, with levels to compare them with.

use plotters::prelude::*;

use crate::report::plots::{Area, Below, Drawn, INK, axes, draw, line, padded_range};
use crate::report::series::Point;

/// Size of the drawing; 520 px wide on the page.
const SIZE: (u32, u32) = (1040, 460);

/// One line.
#[derive(Debug, Clone)]
pub(in crate::report) struct Curve {
    points: Vec<Point>,
    colour: RGBColor,
}

impl Curve {
    /// Points that are not finite are left out.
    pub fn new(points: Vec<Point>, colour: RGBColor) -> Self {
        let finite = |p: &Point| p.0.is_finite() && p.1.is_finite();
        Self {
            points: points.into_iter().filter(finite).collect(),
            colour,
        }
    }
}

/// Draws the curves, and horizontal lines at `levels`.
pub(in crate::report) fn curves(
    curves: &[Curve],
    levels: &[f64],
    x_title: &str,
    label: &str,
) -> String {
    draw(SIZE, label, |area| paint(area, curves, levels, x_title))
}

fn paint(area: &Area, curves: &[Curve], levels: &[f64], x_title: &str) -> Drawn {
    let points = || curves.iter().flat_map(|c| &c.points);
    let x = padded_range(points().map(|p| p.0));
    let y = padded_range(points().map(|p| p.1).chain(levels.iter().copied()));
    let mut chart = axes(area, x, y, &Below::Title(x_title))?;
    for level in levels {
        chart.draw_series(line(&[(x.0, *level), (x.1, *level)], INK, 2))?;
    }
    for curve in curves {
        chart.draw_series(line(&curve.points, curve.colour, 3))?;
    }
    Ok(())
}
