//! What is wrong with the inputs, the worst first, each with what to do about it.

use crate::outcome::Part;
use crate::outcome::check::Finding;
use crate::report::facts;
use crate::report::html::escape;
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

pub(super) fn section(source: &Source) -> Option<Section> {
    let (title, found) = match &source.outcome.part {
        Part::Check(check) => ("Findings", &check.findings),
        _ => ("Mistakes in the inputs", &source.outcome.mistakes),
    };
    if found.is_empty() {
        return None;
    }
    let mut findings: Vec<&Finding> = found.iter().collect();
    findings.sort_by_key(|finding| finding.severity);
    let mut table = Table::new(&["", "Where", "What, and what to do", "Code"]);
    for finding in findings {
        table.row(vec![
            Cell::Mark(finding.severity.as_str()),
            Cell::name(&facts::finding_place(finding)),
            Cell::Html(format!(
                "{}<small>{}</small>",
                escape(&finding.message),
                escape(&finding.remedy)
            )),
            Cell::text(&finding.code),
        ]);
    }
    Some(Section::new("mistakes", title, table.html()))
}
