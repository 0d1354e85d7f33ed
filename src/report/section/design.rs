//! The motion that `design` found: limits, joints over time, phase planes, convergence, expected accuracy.

use crate::design::trajectory::fourier_series::{Basis, Series};
use crate::outcome::Part;
use crate::outcome::design::{Design, ExpectedDeviation, JointCoefficients};
use crate::report::escape::{breakable, escape, prose};
use crate::report::explore::designed::motion as series;
use crate::report::facts::count;
use crate::report::number::{optional, percent, significant};
use crate::report::plots::bars::bars;
use crate::report::plots::curves::{Curve, curves};
use crate::report::plots::{PREDICTED, RECORDED, RESIDUAL, figure, key};
use crate::report::section::explorer::explorer;
use crate::report::section::{Section, Source};
use crate::report::series::Point;
use crate::report::table::{Cell, Table};

/// Points of a plotted period.
const POINTS: usize = 600;

/// Periods that a series can have here without plots of noise: zero or less has none.
fn is_drawable(design: &Design) -> bool {
    design.coefficients.period > 0.0 && design.coefficients.harmonics > 0
}

/// The trajectories over time, beside the robot.
pub(super) fn motion(source: &Source) -> Option<Section> {
    let Part::Design(design) = &source.outcome.part else {
        return None;
    };
    if !is_drawable(design) {
        return None;
    }
    let trajectories = design.coefficients.trajectories.iter().enumerate();
    let still: String = trajectories
        .map(|(number, joints)| trajectory(design, number, joints))
        .collect();
    let body = explorer(source, None, &still);
    Some(Section::new("motion", "Motion", body))
}

pub(super) fn section(source: &Source) -> Option<Section> {
    let Part::Design(design) = &source.outcome.part else {
        return None;
    };
    let mut body = figures(design);
    body.push_str(&margins(design));
    body.push_str(&ways(design));
    body.push_str(&convergence(design));
    body.push_str(&accuracy(design));
    body.push_str(&coverage(design));
    Some(Section::new("design", "What the motion is worth", body))
}

fn figures(design: &Design) -> String {
    let files: String = design
        .files
        .iter()
        .map(|file| format!("<li><code>{}</code></li>\n", breakable(file)))
        .collect();
    format!(
        "<p>{}: {}. Condition number {}, log det {}. Scaling: {}.</p>\n<ul>\n{files}</ul>\n",
        prose(&design.criterion_meaning),
        significant(design.criterion_value),
        significant(design.condition_number),
        significant(design.log_det),
        prose(&design.scaling),
    )
}

fn margins(design: &Design) -> String {
    let mut table = Table::new(&["Limit", "Joint", "At [s]", "Least margin", "Share", "Unit"]);
    for m in &design.worst_margins {
        table.row(vec![
            Cell::text(&m.constraint),
            Cell::name(m.joint.as_deref().unwrap_or("")),
            Cell::Number(significant(m.time)),
            Cell::Number(significant(m.margin)),
            Cell::Number(percent(m.relative)),
            Cell::text(&m.unit),
        ]);
    }
    if table.is_empty() {
        return String::new();
    }
    let how = prose(&design.verification);
    format!(
        "<h3>Limits</h3>\n{}<p class=\"hint\">{how}</p>\n",
        table.html()
    )
}

/// A joint over time as shares of its limits, and its phase plane.
fn trajectory(design: &Design, number: usize, joints: &[JointCoefficients]) -> String {
    let basis = Basis::new(
        Series {
            harmonics: design.coefficients.harmonics,
            period: design.coefficients.period,
        },
        POINTS,
    );
    let open = if number == 0 { " open" } else { "" };
    let mut out = format!(
        "<details{open}><summary><b>Trajectory {}</b></summary>\n<p class=\"hint\">{}{}{} as shares \
         of their limits over time; below, velocity over position</p>\n<div class=\"plots\">\n",
        number + 1,
        key(PREDICTED, "position"),
        key(RESIDUAL, "velocity"),
        key(RECORDED, "acceleration"),
    );
    for joint in joints {
        let Some(orders) = series(&basis, joint) else {
            continue;
        };
        let [lower, upper, velocity, acceleration] = joint.limits;
        let (middle, half) = (0.5 * (lower + upper), 0.5 * (upper - lower));
        let share = |order: usize, centre: f64, limit: f64| -> Vec<Point> {
            let values = orders[order].iter().enumerate();
            values
                .map(|(k, v)| (k as f64 * basis.step(), (v - centre) / limit))
                .collect()
        };
        let lines = [
            Curve::new(share(2, 0.0, acceleration), RECORDED),
            Curve::new(share(1, 0.0, velocity), RESIDUAL),
            Curve::new(share(0, middle, half), PREDICTED),
        ];
        let caption = format!("<b>{}</b>", escape(&joint.joint));
        let label = format!("{} over time", joint.joint);
        out.push_str(&figure(
            &caption,
            &curves(&lines, &[-1.0, 1.0], "t [s]", &label),
        ));
        let plane = orders[0].iter().copied().zip(orders[1].iter().copied());
        let plane = [Curve::new(plane.collect(), PREDICTED)];
        let title = format!("position [{}]", joint.unit);
        let label = format!("phase plane of {}", joint.joint);
        out.push_str(&figure(&caption, &curves(&plane, &[], &title, &label)));
    }
    out.push_str("</div>\n</details>\n");
    out
}

fn convergence(design: &Design) -> String {
    if design.convergence.len() < 2 {
        return String::new();
    }
    let points = design.convergence.iter().map(|p| (p.elapsed_s, p.value));
    let line = [Curve::new(points.collect(), PREDICTED)];
    let caption = format!(
        "<b>Best value against time</b>, {}",
        count(design.starts as usize, "start")
    );
    figure(&caption, &curves(&line, &[], "t [s]", "convergence"))
}

/// Ways of points of the robot seen from above and from the front.
fn ways(design: &Design) -> String {
    let mut out = String::new();
    for way in &design.ways {
        let seen = |axis: usize| way.points.iter().map(|p| (p[0], p[axis])).collect();
        for (axis, name) in [(1, "y"), (2, "z")] {
            let line = [Curve::new(seen(axis), PREDICTED)];
            let caption = format!("<b>Way of {}</b>, {name} over x [m]", escape(&way.frame));
            let label = format!("way of {} along x and {name}", way.frame);
            out.push_str(&figure(&caption, &curves(&line, &[], "x [m]", &label)));
        }
    }
    if out.is_empty() {
        return out;
    }
    format!("<h3>Workspace</h3>\n<div class=\"plots\">\n{out}</div>\n")
}

/// Expected deviations, beside those of the motion that is compared with, and how far the values stand out.
fn accuracy(design: &Design) -> String {
    if design.expected_std_dev.is_empty() {
        return String::new();
    }
    let (head, plot) = (
        "<h3>Expected accuracy of one period</h3>\n",
        information(design),
    );
    let Some(reference) = &design.reference else {
        let mut table = Table::new(&["No.", "Parameter", "Value", "Expected std. dev.", "Unit"]);
        for (k, d) in design.expected_std_dev.iter().enumerate() {
            table.row(row(k, d));
        }
        return format!("{head}{plot}{}", table.html());
    };
    let columns = [
        "No.",
        "Parameter",
        "Value",
        "Expected std. dev.",
        "Unit",
        "Compared",
        "Ratio",
    ];
    let mut table = Table::new(&columns);
    let pairs = design
        .expected_std_dev
        .iter()
        .zip(&reference.expected_std_dev);
    for (k, (own, other)) in pairs.enumerate() {
        let ratio = own.std_dev.zip(other.std_dev).map(|(a, b)| a / b);
        let mut cells = row(k, own);
        cells.push(Cell::Number(optional(other.std_dev)));
        cells.push(Cell::Number(optional(ratio)));
        table.row(cells);
    }
    format!(
        "{head}<p class=\"hint\">Compared with <code>{}</code>, whose criterion is {}.</p>\n{plot}{}",
        escape(&reference.file),
        significant(reference.criterion_value),
        table.html()
    )
}

fn row(number: usize, d: &ExpectedDeviation) -> Vec<Cell> {
    vec![
        Cell::Number((number + 1).to_string()),
        Cell::name(&d.name),
        Cell::Number(optional(d.value)),
        Cell::Number(optional(d.std_dev)),
        Cell::text(&d.unit),
    ]
}

/// log10 of value over standard deviation, parameter by parameter.
fn information(design: &Design) -> String {
    let share = |d: &ExpectedDeviation| match (d.value, d.std_dev) {
        (Some(value), Some(deviation)) if value != 0.0 => (value.abs() / deviation).log10(),
        _ => f64::NAN,
    };
    let values: Vec<f64> = design.expected_std_dev.iter().map(share).collect();
    if values.iter().all(|v| v.is_nan()) {
        return String::new();
    }
    let caption = "<b>Information per parameter</b>: powers of ten by which the value exceeds its standard deviation";
    let svg = bars(&values, "number in the table", "information per parameter");
    format!("<div class=\"plots\">\n{}</div>\n", figure(caption, &svg))
}

fn coverage(design: &Design) -> String {
    let mut table = Table::new(&["Joint", "Effect", "Shown", "What the motion does"]);
    for c in &design.coverage {
        table.row(vec![
            Cell::name(&c.joint),
            Cell::name(&c.effect),
            Cell::text(if c.shown { "yes" } else { "little" }),
            Cell::text(&c.sentence),
        ]);
    }
    if table.is_empty() {
        return String::new();
    }
    format!("<h3>What the motion shows</h3>\n{}", table.html())
}
