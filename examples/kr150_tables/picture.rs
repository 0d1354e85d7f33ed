//! Two pictures: the errors of every experiment by approach, and of models that lack something.

use crate::Outcome;
use crate::experiment::Result;
use crate::lacking::Lacking;
use crate::render::inertia_error;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;

const COLOURS: [RGBColor; 3] = [
    RGBColor(213, 94, 0),
    RGBColor(230, 159, 0),
    RGBColor(0, 114, 178),
];

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Errors of mass and inertia, one point per experiment.
pub fn tables(file: &Path, experiments: &[Result]) -> Outcome<()> {
    let whole = SVGBackend::new(file, (860, 340)).into_drawing_area();
    whole.fill(&WHITE)?;
    let halves = whole.split_evenly((1, 2));
    let of = |error: &dyn Fn(&Result, usize) -> f64| -> Vec<Vec<f64>> {
        let by = |approach| experiments.iter().map(|e| error(e, approach)).collect();
        (0..3).map(by).collect()
    };
    let mass = of(&|e, a| e.approaches[a].load[0] - e.truth[0]);
    let inertia = of(&|e, a| inertia_error(&e.approaches[a].load, &e.truth));
    points(&halves[0], "error of the mass, kg", &mass)?;
    points(
        &halves[1],
        "norm of the error of the inertia, kg·m²",
        &inertia,
    )?;
    whole.present()?;
    Ok(())
}

/// One column of points per approach.
fn points(area: &Area<'_>, title: &str, errors: &[Vec<f64>]) -> Outcome<()> {
    let all = errors.iter().flatten().copied();
    let (low, high) = all.fold((0.0_f64, 0.0_f64), |(l, h), x| (l.min(x), h.max(x)));
    let margin = 0.08 * (high - low);
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 16))
        .margin(12)
        .x_label_area_size(28)
        .y_label_area_size(48)
        .build_cartesian_2d(0.5..3.5, low - margin..high + margin)?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .max_light_lines(0)
        .y_label_formatter(&|y| format!("{:.1}", (1e6 * y).round() / 1e6 + 0.0))
        .x_labels(3)
        .x_label_formatter(&|x| format!("approach {x:.0}"))
        .draw()?;
    chart.draw_series(LineSeries::new(
        [(0.5, 0.0), (3.5, 0.0)],
        BLACK.stroke_width(1),
    ))?;
    for (k, errors) in errors.iter().enumerate() {
        let spread = |i: usize| 0.4 * (i as f64 / (errors.len().max(2) - 1) as f64 - 0.5);
        let dots = errors
            .iter()
            .enumerate()
            .map(|(i, e)| (k as f64 + 1.0 + spread(i), *e));
        chart.draw_series(dots.map(|at| Circle::new(at, 4, COLOURS[k].filled())))?;
    }
    Ok(())
}

/// Errors of mass and inertia, one bar per model.
pub fn lacking(file: &Path, fits: &[Lacking]) -> Outcome<()> {
    let whole = SVGBackend::new(file, (860, 280)).into_drawing_area();
    whole.fill(&WHITE)?;
    let halves = whole.split_horizontally(500);
    let mass: Vec<f64> = fits
        .iter()
        .map(|f| (f.load[0] - f.truth[0]).abs())
        .collect();
    let inertia: Vec<f64> = fits
        .iter()
        .map(|f| inertia_error(&f.load, &f.truth))
        .collect();
    let names: Vec<&str> = fits.iter().map(|f| f.model).collect();
    bars(&halves.0, "error of the mass, kg", (&names, &mass))?;
    bars(&halves.1, "error of the inertia, kg·m²", (&[], &inertia))?;
    whole.present()?;
    Ok(())
}

/// Horizontal bars with their values; names to the left where there are any.
fn bars(area: &Area<'_>, title: &str, (names, values): (&[&str], &[f64])) -> Outcome<()> {
    let count = values.len();
    let most = values.iter().copied().fold(0.0, f64::max);
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 16))
        .margin(12)
        .x_label_area_size(24)
        .y_label_area_size(if names.is_empty() { 10 } else { 170 })
        .build_cartesian_2d(0.0..1.2 * most, 0.0..count as f64)?;
    chart
        .configure_mesh()
        .disable_y_mesh()
        .disable_y_axis()
        .max_light_lines(0)
        .x_labels(6)
        .draw()?;
    let style = ("sans-serif", 14)
        .into_font()
        .into_text_style(area)
        .pos(Pos::new(HPos::Left, VPos::Center));
    for (k, value) in values.iter().enumerate() {
        let top = (count - k) as f64;
        let colour = if k == 0 { COLOURS[2] } else { COLOURS[0] };
        let bar = [(0.0, top - 0.8), (*value, top - 0.2)];
        chart.draw_series([Rectangle::new(bar, colour.filled())])?;
        let middle = (value + 0.01 * most, top - 0.5);
        chart.draw_series([Text::new(format!("{value:.2}"), middle, style.clone())])?;
        if let Some(name) = names.get(k) {
            let (x, y) = chart.backend_coord(&(0.0, top - 0.5));
            let (left, above) = area.get_base_pixel();
            let at = (x - left - 165, y - above);
            area.draw(&Text::new((*name).to_string(), at, style.clone()))?;
        }
    }
    Ok(())
}
