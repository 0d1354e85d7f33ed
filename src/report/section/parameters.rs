//! The parameters: value, uncertainty, and what each rests on.

use crate::outcome::parameter::{Parameter, Source as Origin};
use crate::report::escape::breakable;
use crate::report::number::{ABSENT, optional, percent};
use crate::report::plots::figure;
use crate::report::plots::rows::{Estimated, estimates};
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};
use crate::report::terminal_parameters::LOAD;

/// Standard deviations to either end of a 95 % interval of a normal distribution.
const NORMAL_95: f64 = 1.96;

const EXPLANATION: &str = "<p class=\"hint\">Source: data, determined by the recordings; prior, by \
    the prior where the recordings alone do not; bound, on a bound or on the edge of what is \
    physically possible; known, given. An undetermined parameter has no value of its own: the base \
    parameters show in which combination it enters.</p>\n";

pub(super) fn section(source: &Source) -> Option<Section> {
    let parameters = &source.outcome.estimate.parameters;
    if parameters.is_empty() {
        return None;
    }
    let (open, valued): (Vec<&Parameter>, Vec<&Parameter>) = parameters
        .iter()
        .partition(|p| p.source == Origin::Undetermined);
    let mut body = String::new();
    if !valued.is_empty() {
        body.push_str(&table(&in_order(valued)).html());
    }
    body.push_str(&undetermined(&open));
    body.push_str(EXPLANATION);
    body.push_str(&charts(parameters));
    Some(Section::new("parameters", "Parameters", body))
}

/// What was asked for comes first: the load, then the drives, then the bodies of the links; else as in the result.
fn in_order(mut parameters: Vec<&Parameter>) -> Vec<&Parameter> {
    parameters.sort_by_key(|p| match p.name.matches('.').count() {
        _ if p.name.starts_with(LOAD) => 0,
        0 | 1 => 2,
        _ => 1,
    });
    parameters
}

/// Parameters without a value, by name, in one line that unfolds.
fn undetermined(parameters: &[&Parameter]) -> String {
    if parameters.is_empty() {
        return String::new();
    }
    let names: Vec<String> = parameters
        .iter()
        .map(|p| format!("<code>{}</code>", breakable(&p.name)))
        .collect();
    format!(
        "<details class=\"undetermined\"><summary>{} undetermined: the recordings show them in combinations only</summary>\n\
         <p class=\"names\">{}</p></details>\n",
        parameters.len(),
        names.join(", ")
    )
}

/// A column of the table: its head and what stands in it.
struct Column {
    head: &'static str,
    cell: fn(&Parameter) -> Cell,
}

const VALUE: [Column; 3] = [
    Column {
        head: "Parameter",
        cell: |p| Cell::Name {
            name: p.name.clone(),
            remark: p.description.clone(),
        },
    },
    Column {
        head: "Value",
        cell: |p| Cell::Number(optional(p.value)),
    },
    Column {
        head: "Unit",
        cell: |p| Cell::text(&p.unit),
    },
];

const DEVIATION: Column = Column {
    head: "Std. dev.",
    cell: |p| Cell::Number(optional(p.std_dev)),
};

/// The part of the deviation that noise makes, where uncertain torque constants make another.
const OF_NOISE: Column = Column {
    head: "of noise",
    cell: |p| Cell::Number(optional(p.std_dev_statistical)),
};

const INTERVAL: [Column; 3] = [
    Column {
        head: "Relative",
        cell: |p| Cell::Number(relative(p)),
    },
    Column {
        head: "95 % from",
        cell: |p| Cell::Number(optional(p.ci95.map(|ends| ends[0]))),
    },
    Column {
        head: "to",
        cell: |p| Cell::Number(optional(p.ci95.map(|ends| ends[1]))),
    },
];

const SOURCE: Column = Column {
    head: "Source",
    cell: |p| Cell::Mark(p.source.as_str()),
};

/// Values that are all known have no columns of uncertainty.
fn columns(parameters: &[&Parameter]) -> Vec<Column> {
    let uncertain = parameters.iter().any(|p| p.std_dev.is_some());
    let apart = parameters.iter().any(|p| p.std_dev_statistical.is_some());
    let mut columns = Vec::from(VALUE);
    columns.extend(uncertain.then_some(DEVIATION));
    columns.extend(apart.then_some(OF_NOISE));
    columns.extend(uncertain.then_some(INTERVAL).into_iter().flatten());
    columns.push(SOURCE);
    columns
}

fn table(parameters: &[&Parameter]) -> Table {
    let columns = columns(parameters);
    let headers: Vec<&str> = columns.iter().map(|column| column.head).collect();
    let mut table = Table::new(&headers);
    let mut owner = "";
    for parameter in parameters {
        if owner_of(parameter) != owner {
            owner = owner_of(parameter);
            table.begin_group();
        }
        let cells = columns.iter().map(|column| (column.cell)(parameter));
        table.row(cells.collect());
    }
    table
}

fn relative(parameter: &Parameter) -> String {
    match (parameter.value, parameter.std_dev) {
        (Some(value), Some(std_dev)) if value != 0.0 => percent(std_dev / value.abs()),
        _ => ABSENT.to_string(),
    }
}

/// The joint or link that a parameter belongs to.
fn owner_of(parameter: &Parameter) -> &str {
    parameter
        .name
        .split_once('.')
        .map_or("", |(owner, _)| owner)
}

/// One chart for each quantity that several joints or links have, such as all Coulomb frictions.
fn charts(parameters: &[Parameter]) -> String {
    let mut groups: Vec<(&str, &str, Vec<Estimated>)> = Vec::new();
    for parameter in parameters {
        let Some((owner, quantity)) = parameter.name.split_once('.') else {
            continue;
        };
        let Some(estimated) = estimated(owner, parameter) else {
            continue;
        };
        let unit = parameter.unit.as_str();
        match groups
            .iter_mut()
            .find(|(q, u, _)| *q == quantity && *u == unit)
        {
            Some((_, _, rows)) => rows.push(estimated),
            None => groups.push((quantity, unit, vec![estimated])),
        }
    }
    let plots: String = groups
        .iter()
        .filter(|(_, _, rows)| rows.len() > 1)
        .map(|(quantity, unit, rows)| {
            let caption = format!("<b>{}</b>", breakable(quantity));
            let title = if unit.is_empty() {
                String::new()
            } else {
                format!("[{unit}]")
            };
            figure(&caption, &estimates(rows, &title))
        })
        .collect();
    if plots.is_empty() {
        return String::new();
    }
    format!("<h3>Estimates with 95 % intervals</h3>\n<div class=\"plots small\">\n{plots}</div>\n")
}

fn estimated(owner: &str, parameter: &Parameter) -> Option<Estimated> {
    let (value, std_dev) = (parameter.value?, parameter.std_dev?);
    let half_width = NORMAL_95 * std_dev;
    Some(Estimated {
        label: owner.to_string(),
        value,
        interval: parameter
            .ci95
            .unwrap_or([value - half_width, value + half_width]),
    })
}
