//! Parameters that joints with motors of one type have in common: the common value beside that of every joint.

use crate::outcome::sharing::{SeparateValue, Sharing};
use crate::report::escape::prose;
use crate::report::number::{optional, with_deviation};
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

pub(super) fn section(source: &Source) -> Option<Section> {
    let of_diagnosis = source
        .diagnosis()
        .and_then(|diagnosis| diagnosis.fit.as_ref());
    let answers = &source.fit().or(of_diagnosis)?.sharing;
    if answers.is_empty() {
        return None;
    }
    let body: String = answers.iter().map(answer).collect();
    Some(Section::new(
        "sharing",
        "Joints with motors of one type",
        body,
    ))
}

fn answer(answer: &Sharing) -> String {
    let mut headers = vec!["Parameter", "Unit", "In common", "95 % from", "to"];
    headers.extend(answer.joints.iter().map(String::as_str));
    let mut table = Table::new(&headers);
    for parameter in &answer.parameters {
        let ends = [0, 1].map(|k| optional(parameter.ci95.map(|ci| ci[k])));
        let mut cells = vec![
            Cell::name(&parameter.name),
            Cell::text(&parameter.unit),
            Cell::Number(optional(parameter.value)),
        ];
        cells.extend(ends.map(Cell::Number));
        cells.extend(
            parameter
                .separate
                .iter()
                .map(|own| Cell::Number(of_joint(own))),
        );
        table.row(cells);
    }
    format!("<p>{}</p>\n{}", prose(&answer.sentence), table.html())
}

fn of_joint(own: &SeparateValue) -> String {
    match (own.value, own.std_dev) {
        (Some(value), Some(std_dev)) => with_deviation(value, std_dev),
        (value, _) => optional(value),
    }
}
