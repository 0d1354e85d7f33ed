//! What is wrong with the inputs, the worst first, each with what to do about it.

use crate::outcome::Part;
use crate::outcome::check::{Mistake, Severity};
use crate::report::escape::{breakable, prose};
use crate::report::facts;
use crate::report::section::{Section, Source};

/// Characters of a note, message and remedy together, that stay open beside a result: about four lines of a card.
const SHORT: usize = 240;

pub(super) fn section(source: &Source) -> Option<Section> {
    let (title, found) = match &source.outcome.part {
        Part::Check(check) => ("Findings", &check.findings),
        _ => (title(&source.outcome.mistakes), &source.outcome.mistakes),
    };
    if found.is_empty() {
        return None;
    }
    let is_note = |finding: &&Mistake| finding.severity == Severity::Note;
    let (notes, mut grave): (Vec<&Mistake>, Vec<&Mistake>) = found.iter().partition(is_note);
    grave.sort_by_key(|finding| finding.severity);
    let body = match &source.outcome.part {
        Part::Check(_) => cards(&[grave, notes].concat()),
        _ => cards(&grave) + &beside_a_result(&notes),
    };
    Some(Section::new("mistakes", title, body))
}

/// Notes that leave the first screen to the result: folded where there are several, or where one is long.
fn beside_a_result(notes: &[&Mistake]) -> String {
    let length: usize = notes
        .iter()
        .map(|note| note.message.chars().count() + note.remedy.chars().count())
        .sum();
    if notes.len() <= 1 && length <= SHORT {
        return cards(notes);
    }
    let codes: Vec<String> = notes
        .iter()
        .map(|note| format!("<code>{}</code>", breakable(&note.code)))
        .collect();
    format!(
        "<details class=\"notes\"><summary>{}: {}</summary>\n{}</details>\n",
        facts::count(notes.len(), "note"),
        codes.join(", "),
        cards(notes)
    )
}

fn cards(findings: &[&Mistake]) -> String {
    if findings.is_empty() {
        return String::new();
    }
    let cards: String = findings.iter().map(|finding| card(finding)).collect();
    format!("<div class=\"cards\">\n{cards}</div>\n")
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
        prose(&finding.message),
        match finding.severity {
            Severity::Error => "bad",
            Severity::Warning => "fair",
            Severity::Note => "",
        },
        breakable(&finding.code),
        prose(&finding.remedy)
    )
}
