//! What the run read, and how to repeat it.

use crate::report::facts;
use crate::report::html::escape;
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
    let mut body = format!(
        "<p>With version {} of the program and these files:</p>\n<pre>{}</pre>\n",
        escape(&run.version),
        escape(&facts::command(source.outcome))
    );
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

/// The problem as TOML, the form in which users write it; as JSON where TOML cannot hold it.
fn problem_text(problem: &serde_json::Value) -> String {
    toml::to_string(problem)
        .or_else(|_| serde_json::to_string_pretty(problem))
        .unwrap_or_default()
}
