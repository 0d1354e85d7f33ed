//! Recorded and predicted signal of one joint over time, with the residual below on its own scale.

use crate::report::plots::{
    Area, Below, Drawn, PREDICTED, RECORDED, RESIDUAL, axes, draw, line, padded_range, resolvable,
};
use crate::report::series::{JointSeries, Point};

/// Size of the drawing; 520 px wide on the page.
const SIZE: (u32, u32) = (1040, 690);

/// Height of the upper part.
const SIGNAL_HEIGHT: u32 = 390;

/// Draws the signals of a joint.
pub(in crate::report) fn signals(series: &JointSeries, label: &str) -> String {
    draw(SIZE, label, |area| paint(area, series))
}

fn paint(area: &Area, series: &JointSeries) -> Drawn {
    let (upper, lower) = area.split_vertically(SIGNAL_HEIGHT);
    let both = || series.recorded.iter().chain(&series.predicted);
    let (start, end) = time_range(&series.recorded);
    let mut chart = axes(
        &upper,
        (start, end),
        padded_range(both().map(|p| p.1)),
        &Below::Nothing,
    )?;
    // The prediction is thinner and on top: where the two agree, both can be seen.
    chart.draw_series(line(&series.recorded, RECORDED, 5))?;
    chart.draw_series(line(&series.predicted, PREDICTED, 2))?;

    let residuals = padded_range(series.residual.iter().map(|p| p.1).chain([0.0]));
    let mut chart = axes(&lower, (start, end), residuals, &Below::Title("t [s]"))?;
    chart.draw_series(line(&[(start, 0.0), (end, 0.0)], RECORDED, 2))?;
    chart.draw_series(line(&series.residual, RESIDUAL, 2))?;
    Ok(())
}

/// First and last time, apart even for a single sample.
fn time_range(points: &[Point]) -> (f64, f64) {
    let (Some(&(start, _)), Some(&(end, _))) = (points.first(), points.last()) else {
        return (0.0, 1.0);
    };
    if end - start > resolvable(start, end) {
        (start, end)
    } else {
        (start, start + 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_signals_without_range_or_points() {
        let steady = |t: f64, y: f64| (0..30).map(|k| (t + 0.01 * f64::from(k), y)).collect();
        let lines: [Vec<Point>; 6] = [
            vec![],
            vec![(3.0, 2.0)],
            vec![(1.7e9, 2.0), (1.7e9, 2.0 + 4e-16)],
            steady(1.7e9, 0.0),
            steady(0.0, 1e300),
            steady(0.0, 1e-300),
        ];
        for line in lines {
            let svg = signals(
                &JointSeries {
                    joint: "a".to_string(),
                    recorded: line.clone(),
                    predicted: line.clone(),
                    residual: line,
                    residual_of_speed: Vec::new(),
                },
                "a",
            );
            assert!(
                svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"),
                "{svg}"
            );
            assert!(!svg.contains("NaN") && !svg.contains("inf"));
        }
    }
}
