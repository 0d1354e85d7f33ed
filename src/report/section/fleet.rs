//! Fleets: robots to look at with their history, what the types are like, items that were set aside.

use crate::outcome::Part;
use crate::outcome::fleet::{Failure, Fleet, LookAt, Reason, Shown, TypeFigures};
use crate::report::escape::{breakable, escape, prose};
use crate::report::facts::moment;
use crate::report::number::{optional, percent, significant, with_deviation};
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

/// Robots that a page shows; the result has all of them.
const MOST_ROBOTS: usize = 300;

/// Parameters beside the first that are named of a robot.
const MOST_OTHERS: usize = 4;

/// Robots to look at.
pub(super) fn look_at(source: &Source) -> Option<Section> {
    let fleet = fleet(source)?;
    let mut body = String::new();
    if fleet.look_at.is_empty() {
        body.push_str("<p>No robot has changed, and none stands out among its type.</p>\n");
        return Some(Section::new("look_at", "Look at these robots", body));
    }
    body.push_str(&format!(
        "<p class=\"hint\">The surest first. Of the robots listed at most {} may have nothing, in the mean over many fleets. \
         Pictures show the parameter by night, one standard deviation of each fit up and down, the level before (grey) \
         and after (red).</p>\n",
        short_percent(fleet.rate)
    ));
    let mut table = Table::new(&[
        "Robot",
        "Joint",
        "What",
        "Since",
        "Size [σ]",
        "Sure",
        "By night",
    ]);
    for look in fleet.look_at.iter().take(MOST_ROBOTS) {
        let shown = &look.evidence;
        table.row(vec![
            Cell::Name {
                name: look.robot.clone(),
                remark: look.kind_of_robot.clone(),
            },
            Cell::Html(look.joint.as_deref().map_or(String::new(), breakable)),
            Cell::Html(what(look)),
            Cell::text(shown.since.map_or(String::new(), moment)),
            Cell::Number(format!("{:+.1}", shown.z)),
            Cell::Number(sure(shown.probability)),
            Cell::Html(picture(look)),
        ]);
    }
    body.push_str(&table.html());
    if fleet.look_at.len() > MOST_ROBOTS {
        let more = fleet.look_at.len() - MOST_ROBOTS;
        body.push_str(&format!(
            "<p class=\"hint\">{more} more are in result.json.</p>\n"
        ));
    }
    Some(Section::new("look_at", "Look at these robots", body))
}

/// Types with their parameters.
pub(super) fn types(source: &Source) -> Option<Section> {
    let fleet = fleet(source)?;
    let mut body = String::from(
        "<p class=\"hint\">Mean and standard deviation between robots, standard deviation between nights of one robot beyond \
         that of a fit, and the median standard deviation of a fit.</p>\n",
    );
    for of_type in &fleet.types {
        body.push_str(&one_type(of_type));
    }
    Some(Section::new("types", "Types", body))
}

/// Items without a result.
pub(super) fn failures(source: &Source) -> Option<Section> {
    let fleet = fleet(source)?;
    if fleet.failures.is_empty() {
        return None;
    }
    let mut table = Table::new(&["Robot", "Time", "Error"]);
    for Failure {
        robot,
        time,
        code,
        message,
    } in &fleet.failures
    {
        table.row(vec![
            Cell::name(robot),
            Cell::text(moment(*time)),
            Cell::Html(format!(
                "<code class=\"long\">{}</code><small>{}</small>",
                breakable(code),
                prose(message)
            )),
        ]);
    }
    let mut body = table.html();
    if fleet.set_aside as usize > fleet.failures.len() {
        let more = fleet.set_aside as usize - fleet.failures.len();
        body.push_str(&format!(
            "<p class=\"hint\">{more} more are in summary.parquet.</p>\n"
        ));
    }
    Some(Section::new("failures", "Set aside", body))
}

fn fleet<'a>(source: &Source<'a>) -> Option<&'a Fleet> {
    match &source.outcome.part {
        Part::Fleet(fleet) => Some(fleet),
        _ => None,
    }
}

/// A rate as it was given: `5 %`.
fn short_percent(rate: f64) -> String {
    format!("{} %", (1e4 * rate).round() / 100.0)
}

/// A probability that is never rounded to certainty.
pub(in crate::report) fn sure(probability: f64) -> String {
    match probability {
        p if p > 0.9999 => "> 99.99 %".to_string(),
        p => percent(p),
    }
}

fn what(look: &LookAt) -> String {
    let shown = &look.evidence;
    let unit = match shown.unit.as_str() {
        "1" => "",
        unit => unit,
    };
    let size = match shown.reason {
        Reason::UnlikeItsType => format!(
            "<code>{}</code> {} {}, the type has {}",
            breakable(&shown.parameter),
            significant(shown.after),
            escape(unit),
            escape(&with_deviation(shown.before, shown.before_std)),
        ),
        _ => format!(
            "<code>{}</code> {} → {} {}",
            breakable(&shown.parameter),
            significant(shown.before),
            significant(shown.after),
            escape(unit)
        ),
    };
    let others: Vec<&Shown> = look
        .also
        .iter()
        .filter(|s| s.parameter != shown.parameter)
        .collect();
    let mut names: Vec<String> = others
        .iter()
        .take(MOST_OTHERS)
        .map(|s| breakable(&s.parameter))
        .collect();
    if others.len() > MOST_OTHERS {
        names.push(format!("{} more", others.len() - MOST_OTHERS));
    }
    let also = match names.is_empty() {
        true => String::new(),
        false => format!("<small>also {}</small>", names.join(", ")),
    };
    format!(
        "<b>{}</b>, {}<small>{size}</small>{also}",
        escape(&look.kind),
        shown.reason.words()
    )
}

/// Size of a picture in units of its own.
const WIDTH: f64 = 220.0;
const HEIGHT: f64 = 52.0;
const MARGIN: f64 = 4.0;

/// The history of the parameter: a bar for each night, and the two levels.
fn picture(look: &LookAt) -> String {
    let shown = &look.evidence;
    let levels = [shown.before, shown.after];
    let ends = look
        .history
        .iter()
        .flat_map(|p| [p.value - p.std, p.value + p.std]);
    let all: Vec<f64> = ends.chain(levels).filter(|x| x.is_finite()).collect();
    let low = all.iter().copied().fold(f64::INFINITY, f64::min);
    let high = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if look.history.is_empty() || high <= low {
        return String::new();
    }
    let count = look.history.len();
    let step = (WIDTH - 2.0 * MARGIN) / count as f64;
    let x = |k: usize| MARGIN + (k as f64 + 0.5) * step;
    let y = |value: f64| HEIGHT - MARGIN - (value - low) / (high - low) * (HEIGHT - 2.0 * MARGIN);
    let is_behind = |time: f64| shown.since.is_some_and(|since| time >= since);
    let first = look
        .history
        .iter()
        .position(|p| is_behind(p.time))
        .unwrap_or(count);
    let line = |level: f64, from: f64, to: f64, class: &str| {
        let at = y(level);
        format!("<path class=\"{class}\" d=\"M{from:.1} {at:.1}H{to:.1}\"/>")
    };
    let [left, right] = [MARGIN, WIDTH - MARGIN];
    let mut out = format!(
        "<svg class=\"nights\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">",
        escape(&look.sentence)
    );
    match shown.reason {
        Reason::UnlikeItsType => {
            out.push_str(&line(shown.before, left, right, "before"));
            out.push_str(&line(shown.after, left, right, "after"));
        }
        _ => {
            let border = MARGIN + first as f64 * step;
            out.push_str(&line(shown.before, left, border, "before"));
            out.push_str(&line(shown.after, border, right, "after"));
        }
    }
    for (k, point) in look.history.iter().enumerate() {
        let (x, top, bottom) = (x(k), y(point.value + point.std), y(point.value - point.std));
        out.push_str(&format!(
            "<path d=\"M{x:.1} {top:.1}V{bottom:.1}\"/><circle cx=\"{x:.1}\" cy=\"{:.1}\" r=\"2.1\"/>",
            y(point.value)
        ));
    }
    out.push_str("</svg>");
    out
}

fn one_type(of_type: &TypeFigures) -> String {
    let mut table = Table::new(&[
        "Parameter",
        "Unit",
        "Mean",
        "Between robots",
        "Between nights",
        "Of a fit",
    ]);
    for figures in &of_type.parameters {
        table.row(vec![
            Cell::name(&figures.name),
            Cell::text(&figures.unit),
            Cell::Number(optional(figures.mean)),
            Cell::Number(optional(figures.between_robots)),
            Cell::Number(significant(figures.between_nights)),
            Cell::Number(significant(figures.of_a_fit)),
        ]);
    }
    let robots = of_type.robots;
    let plural = if robots == 1 { "" } else { "s" };
    format!(
        "<h3>{}</h3>\n<p>{robots} robot{plural}</p>\n{}",
        escape(&of_type.name),
        table.html()
    )
}
