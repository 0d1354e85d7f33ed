//! What is wrong with the inputs, the worst first, each with what to do about it.

use crate::outcome::Part;
use crate::outcome::check::{Mistake, Severity};
use crate::report::escape::{breakable, escape};
use crate::report::facts;
use crate::report::section::{Section, Source};

pub(super) fn section(source: &Source) -> Option<Section> {
    let (title, found) = match &source.outcome.part {
        Part::Check(check) => ("Findings", &check.findings),
        _ => (title(&source.outcome.mistakes), &source.outcome.mistakes),
    };
    if found.is_empty() {
        return None;
    }
    let mut findings: Vec<&Mistake> = found.iter().collect();
    findings.sort_by_key(|finding| finding.severity);
    let cards: String = findings.into_iter().map(card).collect();
    let body = format!("<div class=\"cards\">\n{cards}</div>\n");
    Some(Section::new("mistakes", title, body))
}

fn title(found: &[Mistake]) -> &'static str {
    match found.iter().all(|one| one.severity == Severity::Note) {
        true => "Notes on the inputs",
        false => "Mistakes in the inputs",
    }
}

/// One finding: how grave, where, what, and what to do.
fn card(finding: &Mistake) -> String {
    let severity = finding.severity.as_str();
    let place = facts::finding_place(finding);
    let place = match place.is_empty() {
        true => String::new(),
        false => format!("<dt>Where</dt><dd><code>{}</code></dd>", breakable(&place)),
    };
    format!(
        "<article class=\"card {severity}\"><div class=\"head\"><h3>{}</h3><span class=\"badge {}\">{severity}</span></div>\n\
         <dl>{place}<dt>Code</dt><dd><code>{}</code></dd></dl>\n<p class=\"do\"><b>What to do:</b> {}</p></article>\n",
        escape(&finding.message),
        match finding.severity {
            Severity::Error => "bad",
            Severity::Warning => "fair",
            Severity::Note => "",
        },
        breakable(&finding.code),
        escape(&finding.remedy)
    )
}
