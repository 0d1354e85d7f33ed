//! Bars from zero, one per numbered thing.

use plotters::prelude::*;

use crate::report::plots::{
    Area, Below, Drawn, INK, PREDICTED, RESIDUAL, axes, draw, padded_range,
};

/// Size of the drawing; 520 px wide on the page.
const SIZE: (u32, u32) = (1040, 460);

/// Half the width of a bar; neighbours are one apart.
const HALF_WIDTH: f64 = 0.35;

/// Draws values numbered from 1; those below zero have another colour.
pub(in crate::report) fn bars(values: &[f64], x_title: &str, label: &str) -> String {
    draw(SIZE, label, |area| paint(area, values, x_title))
}

fn paint(area: &Area, values: &[f64], x_title: &str) -> Drawn {
    let x = (0.0, values.len() as f64 + 1.0);
    let y = padded_range(values.iter().copied().chain([0.0]));
    let mut chart = axes(area, x, y, &Below::Title(x_title))?;
    for (k, value) in values.iter().enumerate().filter(|(_, v)| v.is_finite()) {
        let at = (k + 1) as f64;
        let colour = if *value < 0.0 { RESIDUAL } else { PREDICTED };
        let corners = [(at - HALF_WIDTH, 0.0), (at + HALF_WIDTH, *value)];
        chart.draw_series([Rectangle::new(corners, colour.filled())])?;
    }
    let zero = vec![(x.0, 0.0), (x.1, 0.0)];
    let stroke = ShapeStyle::from(&INK).stroke_width(2);
    chart.draw_series([PathElement::new(zero, stroke)])?;
    Ok(())
}
