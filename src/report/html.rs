//! The page: one self-contained HTML file, legible on screen, on a phone and on paper.

use crate::outcome::Outcome;
use crate::report::escape::{breakable, escape};
use crate::report::explore::Exploration;
use crate::report::script;
use crate::report::section::{self, Section};
use crate::report::series::Series;
use crate::report::written::Tables;

/// The style sheets, part of every page.
const STYLES: [&str; 2] = [
    include_str!("vendor/uplot/uPlot.min.css"),
    include_str!("style.css"),
];

/// Renders the report of an outcome.
pub fn page(outcome: &Outcome, tables: &Tables) -> String {
    let exploration = Exploration::of(outcome, tables);
    let sections = section::all(outcome, &Series::of(&tables.predictions), &exploration);
    let title = escape(&format!("{}: {}", outcome.name, outcome.part.verb()));
    let script = script::text();
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n\
         <title>{title}</title>\n<style>\n{}</style>\n</head>\n<body>\n\
         <header>\n<h1>{}</h1>\n<p class=\"verb\">{}</p>\n<button id=\"theme\" type=\"button\" hidden>Dark</button>\n\
         </header>\n<nav aria-label=\"Sections\"><div>{}</div></nav>\n<main>\n",
        policy(&script),
        STYLES.join("\n"),
        breakable(&outcome.name),
        escape(&byline(outcome)),
        contents(&sections),
    );
    for Section { id, title, body } in &sections {
        out.push_str(&format!(
            "<section id=\"{id}\" aria-labelledby=\"{id}-title\">\n<h2 id=\"{id}-title\">{title}</h2>\n{body}</section>\n"
        ));
    }
    out.push_str(&format!(
        "</main>\n<script type=\"application/json\" id=\"exploration\">{}</script>\n<script>{script}</script>\n\
         </body>\n</html>\n",
        exploration.json()
    ));
    out
}

/// Forbids the page to load anything, and to run anything but its own script: a report must read the same in ten years, offline.
fn policy(script: &str) -> String {
    format!(
        "default-src 'none'; style-src 'unsafe-inline'; script-src '{}'",
        script::digest(script)
    )
}

fn byline(outcome: &Outcome) -> String {
    let verb = outcome.part.verb();
    format!(
        "exid {verb}, version {}, seed {}",
        outcome.run.version, outcome.run.seed
    )
}

fn contents(sections: &[Section]) -> String {
    sections
        .iter()
        .map(|section| format!("<a href=\"#{}\">{}</a>", section.id, section.title))
        .collect::<Vec<_>>()
        .join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_every_character_that_html_gives_a_meaning() {
        assert_eq!(
            escape("<a href='x'>\"&\""),
            "&lt;a href=&#39;x&#39;&gt;&quot;&amp;&quot;"
        );
        assert_eq!(breakable("0.5*a.b<c"), "0.5*<wbr>a.<wbr>b&lt;c");
    }
}
