//! Charts with one row per joint or parameter: bars of errors, and estimates with their intervals.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::report::number;
use crate::report::plots::{
    Area, Drawn, GRID, INK, PREDICTED, RECORDED, TEXT_HEIGHT, X_LABEL_UNITS, draw, padded_range,
    text_style,
};

/// Mean width of a character as a share of the text height, of a wide sans-serif face.
const CHARACTER_WIDTH: f64 = 0.58;

/// Most characters of a row's label; longer ones lose their beginning, which rows tend to share.
const LABEL_CHARACTERS: usize = 22;

/// Height of a row of two bars, and of one estimate.
const BAR_ROW_UNITS: u32 = 62;
const ESTIMATE_ROW_UNITS: u32 = 44;

/// Bars of one joint; both in the unit of the axis.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::report) struct Bars {
    pub label: String,
    pub train: f64,
    pub validation: Option<f64>,
}

/// One estimate with the ends of its interval.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::report) struct Estimated {
    pub label: String,
    pub value: f64,
    pub interval: [f64; 2],
}

/// Draws bars from zero, the training figure above the held-out one, and a line at `reference`.
pub(in crate::report) fn bars(rows: &[Bars], reference: Option<f64>, title: &str) -> String {
    let greatest = rows
        .iter()
        .flat_map(|row| [Some(row.train), row.validation])
        .chain([reference])
        .flatten()
        .filter(|value| value.is_finite())
        .fold(0.0, f64::max);
    let end = if greatest > 0.0 { 1.05 * greatest } else { 1.0 };
    let labels: Vec<&str> = rows.iter().map(|row| row.label.as_str()).collect();
    let layout = Layout::new(1040, BAR_ROW_UNITS, &labels, (0.0, end));
    draw(layout.size(), title, |area| {
        layout.frame(area, &labels, title)?;
        for (index, row) in rows.iter().enumerate() {
            layout.bar(area, index, 8..30, row.train, RECORDED)?;
            if let Some(validation) = row.validation {
                layout.bar(area, index, 32..54, validation, PREDICTED)?;
            }
        }
        match reference {
            Some(value) => layout.vertical(area, value, INK),
            None => Ok(()),
        }
    })
}

/// Draws each estimate as a dot on the bar of its interval; zero is marked where it is in range.
pub(in crate::report) fn estimates(rows: &[Estimated], title: &str) -> String {
    let ends = rows
        .iter()
        .flat_map(|row| [row.value, row.interval[0], row.interval[1]]);
    let labels: Vec<&str> = rows.iter().map(|row| row.label.as_str()).collect();
    let layout = Layout::new(700, ESTIMATE_ROW_UNITS, &labels, padded_range(ends));
    draw(layout.size(), title, |area| {
        layout.frame(area, &labels, title)?;
        if layout.range.0 < 0.0 && layout.range.1 > 0.0 {
            layout.vertical(area, 0.0, RECORDED)?;
        }
        for (index, row) in rows.iter().enumerate() {
            layout.interval(area, index, row)?;
        }
        Ok(())
    })
}

/// Where things are: labels on the left, rows from the top, the axis below.
struct Layout {
    width: i32,
    left: i32,
    row: i32,
    rows: i32,
    range: (f64, f64),
}

impl Layout {
    fn new(width: i32, row: u32, labels: &[&str], range: (f64, f64)) -> Self {
        let characters = labels
            .iter()
            .map(|label| short(label).chars().count())
            .max();
        let text = TEXT_HEIGHT * CHARACTER_WIDTH * characters.unwrap_or(0) as f64;
        Self {
            width,
            left: text.ceil() as i32 + 20,
            row: row as i32,
            rows: labels.len() as i32,
            range,
        }
    }

    fn size(&self) -> (u32, u32) {
        let height = self.rows * self.row + X_LABEL_UNITS as i32 + 8;
        (self.width as u32, height as u32)
    }

    fn x(&self, value: f64) -> i32 {
        // The last label stands centred below the end of the axis.
        let right = self.width - 50;
        let share = (value - self.range.0) / (self.range.1 - self.range.0);
        self.left + (share.clamp(0.0, 1.0) * f64::from(right - self.left)).round() as i32
    }

    fn bottom(&self) -> i32 {
        self.rows * self.row + 4
    }

    /// Labels of the rows, grid, ticks and the title of the axis.
    fn frame(&self, area: &Area, labels: &[&str], title: &str) -> Drawn {
        let right = text_style(INK, Pos::new(HPos::Right, VPos::Center));
        for (index, label) in labels.iter().enumerate() {
            let y = index as i32 * self.row + self.row / 2;
            area.draw_text(&short(label), &right, (self.left - 14, y))?;
        }
        let below = text_style(INK, Pos::new(HPos::Center, VPos::Top));
        for value in ticks(self.range, 5) {
            self.vertical(area, value, GRID)?;
            area.draw_text(
                &number::tick(value, self.range),
                &below,
                (self.x(value), self.bottom() + 10),
            )?;
        }
        self.vertical(area, self.range.0, RECORDED)?;
        let middle = (self.x(self.range.0) + self.x(self.range.1)) / 2;
        area.draw_text(title, &below, (middle, self.bottom() + 46))?;
        Ok(())
    }

    fn vertical(&self, area: &Area, value: f64, colour: RGBColor) -> Drawn {
        let ends = [(self.x(value), 0), (self.x(value), self.bottom())];
        let style = ShapeStyle::from(&colour).stroke_width(2);
        area.draw(&PathElement::new(ends, style))?;
        Ok(())
    }

    fn bar(
        &self,
        area: &Area,
        index: usize,
        rows: std::ops::Range<i32>,
        value: f64,
        colour: RGBColor,
    ) -> Drawn {
        let top = index as i32 * self.row;
        let corners = [
            (self.x(0.0), top + rows.start),
            (self.x(value), top + rows.end),
        ];
        area.draw(&Rectangle::new(corners, colour.filled()))?;
        Ok(())
    }

    fn interval(&self, area: &Area, index: usize, estimated: &Estimated) -> Drawn {
        let [low, high] = estimated.interval;
        let y = index as i32 * self.row + self.row / 2;
        let style = ShapeStyle::from(&PREDICTED).stroke_width(4);
        let (low, high) = (self.x(low), self.x(high));
        for ends in [
            [(low, y), (high, y)],
            [(low, y - 8), (low, y + 8)],
            [(high, y - 8), (high, y + 8)],
        ] {
            area.draw(&PathElement::new(ends, style))?;
        }
        area.draw(&Circle::new(
            (self.x(estimated.value), y),
            7,
            PREDICTED.filled(),
        ))?;
        Ok(())
    }
}

/// The label, its end if it is long.
fn short(label: &str) -> String {
    let count = label.chars().count();
    if count <= LABEL_CHARACTERS {
        return label.to_string();
    }
    let end = label.chars().skip(count + 1 - LABEL_CHARACTERS);
    std::iter::once('…').chain(end).collect()
}

/// Round numbers within the range: multiples of 1, 2 or 5 times a power of ten, about `count`.
fn ticks((low, high): (f64, f64), count: usize) -> Vec<f64> {
    let raw = (high - low) / count as f64;
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * power)
        .find(|step| *step >= raw)
        .unwrap_or(10.0 * power);
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last).map(|k| k as f64 * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_range() {
        let close = |found: Vec<f64>, wanted: &[f64]| {
            assert_eq!(found.len(), wanted.len(), "{found:?}");
            for (f, w) in found.iter().zip(wanted) {
                assert!((f - w).abs() <= 1e-12 * w.abs(), "{found:?}");
            }
        };
        close(ticks((0.0, 1.05), 5), &[0.0, 0.5, 1.0]);
        close(ticks((-0.3, 0.3), 5), &[-0.2, 0.0, 0.2]);
        close(ticks((1.1e-7, 3.9e-7), 5), &[2e-7, 3e-7]);
    }

    #[test]
    fn draws_rows_without_range_or_numbers() {
        for value in [0.0, 1.0, 1e300, 1e-300, f64::NAN, f64::INFINITY] {
            let label = "a".to_string();
            let row = Bars {
                label: label.clone(),
                train: value,
                validation: Some(value),
            };
            let estimate = Estimated {
                label,
                value,
                interval: [value, value],
            };
            for svg in [
                bars(&[row], Some(1.0), "x"),
                estimates(&[estimate], "x"),
                bars(&[], None, ""),
            ] {
                assert!(
                    svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"),
                    "{svg}"
                );
                assert!(!svg.contains("NaN") && !svg.contains("inf"));
            }
        }
    }

    #[test]
    fn long_labels_keep_their_end() {
        assert_eq!(short("joint1"), "joint1");
        let long = short("left_front_shoulder_pan_joint");
        assert_eq!(long, "…nt_shoulder_pan_joint");
        assert_eq!(long.chars().count(), LABEL_CHARACTERS);
    }
}
