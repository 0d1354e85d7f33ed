//! Box plots over a number, such as torque constants over the speed: quartiles, median, whiskers to the
//! ends.

use plotters::prelude::*;

use crate::report::plots::{Area, Below, Drawn, INK, PREDICTED, axes, draw, padded_range};

/// Size of the drawing; half of it on the page.
const SIZE: (u32, u32) = (1040, 420);

/// Half the width of a box as a share of the axis.
const HALF_WIDTH: f64 = 0.012;

/// Values at one place of the horizontal axis, and a line that spans all boxes.
pub(in crate::report) struct Boxes<'a> {
    pub groups: Vec<(f64, &'a [f64])>,
    pub reference: Option<f64>,
}

/// Draws the boxes; `x_title` names the horizontal axis.
pub(in crate::report) fn boxes(boxes: &Boxes, x_title: &str, label: &str) -> String {
    draw(SIZE, label, |area| paint(area, boxes, x_title))
}

fn paint(area: &Area, boxes: &Boxes, x_title: &str) -> Drawn {
    let x = padded_range(boxes.groups.iter().map(|group| group.0));
    let values = boxes
        .groups
        .iter()
        .flat_map(|group| group.1.iter().copied());
    let y = padded_range(values.chain(boxes.reference));
    let mut chart = axes(area, x, y, &Below::Title(x_title))?;
    let half = HALF_WIDTH * (x.1 - x.0);
    let stroke = ShapeStyle::from(&INK).stroke_width(3);
    for (at, values) in &boxes.groups {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (Some(&low), Some(&high)) = (sorted.first(), sorted.last()) else {
            continue;
        };
        let [first, median, third] = [0.25, 0.5, 0.75].map(|share| quantile(&sorted, share));
        let corners = [(at - half, first), (at + half, third)];
        chart.draw_series([Rectangle::new(corners, PREDICTED.mix(0.35).filled())])?;
        let lines = [
            vec![(*at, low), (*at, first)],
            vec![(*at, third), (*at, high)],
            vec![(at - half, median), (at + half, median)],
        ];
        chart.draw_series(lines.map(|points| PathElement::new(points, stroke)))?;
    }
    if let Some(value) = boxes.reference {
        let points = vec![(x.0, value), (x.1, value)];
        let style = ShapeStyle::from(&PREDICTED).stroke_width(2);
        chart.draw_series([PathElement::new(points, style)])?;
    }
    Ok(())
}

/// Quantile of sorted values, linear between them.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * (sorted.len() - 1) as f64;
    let (below, above) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
    below + (at - at.floor()) * (above - below)
}
