//! What the run read, and how to repeat it.

use crate::outcome::provenance::Provenance;
use crate::outcome::run::Run;
use crate::report::escape::escape;
use crate::report::facts;
use crate::report::section::{Section, Source};
use crate::report::table::{Cell, Table};

pub(super) fn section(source: &Source) -> Option<Section> {
    let run = &source.outcome.run;
    let mut table = Table::new(&["File", "SHA-256"]);
    for input in &run.inputs {
        table.row(vec![
            Cell::name(&input.path),
            Cell::Html(format!(
                "<code class=\"long\">{}</code>",
                escape(&input.sha256)
            )),
        ]);
    }
    let mut body = provenance(run);
    if !table.is_empty() {
        body.push_str(&table.html());
    }
    body.push_str(&format!(
        "<details><summary>The problem as it was read, overrides included</summary>\n\
         <pre>{}</pre></details>\n",
        escape(&problem_text(&run.problem))
    ));
    Some(Section::new("repeat", "Repeat this run", body))
}

/// The command and what it ran on, as far as the result says.
fn provenance(run: &Run) -> String {
    let Provenance {
        command,
        date,
        threads,
        revision,
        features,
        processor,
        ..
    } = &run.provenance;
    let version = escape(&run.version);
    if command.is_empty() {
        return format!("<p>With version {version} of the program and these files:</p>\n");
    }
    let features = match features.is_empty() {
        true => String::new(),
        false => format!(" with {}", escape(&features.join(", "))),
    };
    format!(
        "<pre>{}</pre>\n<p>Version {version} ({}){features}, {} on {}, {}. <code>exid repeat</code> with this folder runs \
         it again and compares.</p>\n",
        escape(&facts::command(command)),
        escape(revision),
        facts::count(*threads, "thread"),
        escape(processor),
        escape(date),
    )
}

/// The problem as TOML, the form in which users write it; as JSON where TOML cannot hold it.
fn problem_text(problem: &serde_json::Value) -> String {
    toml::to_string(problem)
        .or_else(|_| serde_json::to_string_pretty(problem))
        .unwrap_or_default()
}
