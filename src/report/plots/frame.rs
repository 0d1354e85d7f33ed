//! What all plots share: the drawing, its axes and lines, colours and legends.

use crate::report::escape::escape;
use crate::report::number;
use crate::report::series::Point;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::Pos;
use std::error::Error;

pub(in crate::report) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

pub(in crate::report) type Drawn = Result<(), Box<dyn Error>>;

pub(in crate::report) type Cartesian<'a, 'b> = ChartContext<
    'a,
    SVGBackend<'b>,
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;

/// Colours that differ in lightness too, so that they survive a grey printer.
pub(in crate::report) const RECORDED: RGBColor = RGBColor(128, 136, 146);

pub(in crate::report) const PREDICTED: RGBColor = RGBColor(11, 95, 165);

pub(in crate::report) const RESIDUAL: RGBColor = RGBColor(190, 82, 22);

pub(in crate::report) const KIND: RGBColor = RGBColor(122, 62, 145);

pub(in crate::report) const INK: RGBColor = RGBColor(27, 31, 36);

pub(in crate::report) const GRID: RGBColor = RGBColor(226, 229, 233);

/// Height of text in drawing units: 13 px on a wide page, 9 px on a phone.
pub(in crate::report) const TEXT_HEIGHT: f64 = 27.0;

/// What the backend has to be given for it: it divides by 1.24.
pub(in crate::report) const TEXT_UNITS: f64 = 1.24 * TEXT_HEIGHT;

/// Width of the numbers left of a vertical axis, in drawing units.
pub(in crate::report) const Y_LABEL_UNITS: u32 = 124;

/// Height of the numbers and the title below a horizontal axis, in drawing units.
pub(in crate::report) const X_LABEL_UNITS: u32 = 80;

/// Room beyond the outermost point, as a share of the range.
pub(in crate::report) const PADDING: f64 = 0.04;

/// Least range of an axis as a share of its values: below it, ticks run into the spacing of
/// floating-point numbers, 2e-16 of the value.
pub(in crate::report) const LEAST_RANGE: f64 = 1e-9;

/// Draws an SVG of the given size and describes it to a screen reader by `label`; a sentence where
/// it cannot be drawn.
pub(in crate::report) fn draw(
    size: (u32, u32),
    label: &str,
    paint: impl FnOnce(&Area) -> Drawn,
) -> String {
    let mut svg = String::new();
    let drawn = {
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        paint(&area).and_then(|()| Ok(area.present()?))
    };
    let content = svg.split_once('>').map(|(_, content)| content);
    match (drawn, content) {
        (Ok(()), Some(content)) => format!(
            "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">{content}",
            size.0,
            size.1,
            escape(label)
        ),
        (Err(error), _) => {
            let reason = escape(&error.to_string());
            format!("<p class=\"hint\">This plot could not be drawn: {reason}.</p>")
        }
        (Ok(()), None) => String::new(),
    }
}

/// A plot with its caption; the caption is HTML.
pub(in crate::report) fn figure(caption: &str, svg: &str) -> String {
    format!("<figure><figcaption>{caption}</figcaption>{svg}</figure>\n")
}

/// An entry of a legend: a stroke of the colour, and what it stands for.
pub(in crate::report) fn key(colour: RGBColor, text: &str) -> String {
    let class = match colour {
        RECORDED => "recorded",
        PREDICTED => "model",
        RESIDUAL => "found",
        _ => "",
    };
    let RGBColor(r, g, b) = colour;
    let own = match class {
        "" => format!(" style=\"background:rgb({r},{g},{b})\""),
        _ => String::new(),
    };
    format!("<span class=\"entry\"><span class=\"key {class}\"{own}></span>{text}</span> ")
}

/// Text of the standard height.
pub(in crate::report) fn text_style<'a>(colour: RGBColor, position: Pos) -> TextStyle<'a> {
    ("sans-serif", TEXT_UNITS)
        .into_font()
        .color(&colour)
        .pos(position)
}

/// Least and greatest of the values with some room around; never empty.
pub(in crate::report) fn padded_range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    if low > high {
        return (-1.0, 1.0);
    }
    if high - low > resolvable(low, high) {
        let room = PADDING * (high - low);
        (low - room, high + room)
    } else {
        let room = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
        (low - room, high + room)
    }
}

/// Least range between two values over which ticks are distinct numbers.
pub(in crate::report) fn resolvable(low: f64, high: f64) -> f64 {
    LEAST_RANGE * low.abs().max(high.abs())
}

/// What stands below a horizontal axis.
pub(in crate::report) enum Below<'t> {
    /// Numbers and a title.
    Title(&'t str),
    /// Nothing: a plot below this one shares the axis.
    Nothing,
}

/// Axes with a light grid over the ranges `x` and `y`.
pub(in crate::report) fn axes<'a, 'b>(
    area: &'a Area<'b>,
    x: (f64, f64),
    y: (f64, f64),
    below: &Below,
) -> Result<Cartesian<'a, 'b>, Box<dyn Error>> {
    let (title, x_label_units) = match below {
        Below::Title(title) => (*title, X_LABEL_UNITS),
        Below::Nothing => ("", 0),
    };
    let mut chart = ChartBuilder::on(area)
        .margin_top(14)
        .margin_right(24)
        .x_label_area_size(x_label_units)
        .y_label_area_size(Y_LABEL_UNITS)
        .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
    chart
        .configure_mesh()
        .x_labels(6)
        .y_labels(5)
        .max_light_lines(0)
        .bold_line_style(ShapeStyle::from(&GRID).stroke_width(2))
        .axis_style(ShapeStyle::from(&RECORDED).stroke_width(2))
        .label_style(("sans-serif", TEXT_UNITS).into_font().color(&INK))
        .x_label_formatter(&|value| number::tick(*value, x))
        .y_label_formatter(&|value| number::tick(*value, y))
        .x_desc(title)
        .draw()?;
    Ok(chart)
}

/// A line through the points, `width` drawing units wide.
pub(in crate::report) fn line(
    points: &[Point],
    colour: RGBColor,
    width: u32,
) -> LineSeries<SVGBackend<'static>, Point> {
    LineSeries::new(
        points.iter().copied(),
        ShapeStyle::from(&colour).stroke_width(width),
    )
}
