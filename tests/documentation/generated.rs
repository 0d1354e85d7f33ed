//! Pages and pictures of the site that the program and its sources give, held to what they give now.

use crate::pages::{self, remakes, root, settle};
use crate::sources::{RESULT_FILES, as_cell, codes, structures};
use exid::problem_file::reference;
use std::fmt::Write;
use std::fs;
use std::process::Command;

fn exid(arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_exid"));
    let output = command
        .args(arguments)
        .env("NO_COLOR", "1")
        .output()
        .unwrap();
    assert!(output.status.success(), "{arguments:?}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn keys_are_those_of_the_reader() {
    settle("docs/src/reference/keys.md", &reference::markdown());
}

#[test]
fn catalogue_and_its_pictures_are_those_of_the_table() {
    settle("docs/src/effects.md", &exid(&["effects", "--markdown"]));
    let folder = tempfile::tempdir().unwrap();
    exid(&["effects", "--plots", folder.path().to_str().unwrap()]);
    let mut count = 0;
    for entry in fs::read_dir(folder.path()).unwrap() {
        let file = entry.unwrap().path();
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let path = format!("docs/src/effects/{name}");
        if remakes() {
            settle(&path, &fs::read_to_string(&file).unwrap());
        }
        // The last digits of a curve differ from processor to processor; that a law changed shows in the page.
        assert!(root().join(&path).exists(), "{path}; run docs/remake");
        count += 1;
    }
    assert_eq!(count, exid::chain::effect::EFFECTS.len());
}

#[test]
fn commands_are_those_of_the_help() {
    let help = exid(&["--help"]);
    let (_, rest) = help.split_once("Commands:\n").unwrap();
    let (list, _) = rest.split_once("\n\n").unwrap();
    let mut text = "# Commands\n\nWhat `exid --help` and `exid COMMAND --help` print. Exit codes are on a [page](exit_codes.md) of \
                    their own.\n"
        .to_owned();
    for line in list.lines() {
        let verb = line.strip_prefix("  ").filter(|l| !l.starts_with(' '));
        let verb = verb.and_then(|l| l.split_whitespace().next());
        let Some(verb) = verb.filter(|v| *v != "help") else {
            continue;
        };
        let help = exid(&[verb, "--help"]);
        let lines: Vec<&str> = help.lines().map(str::trim_end).collect();
        let _ = write!(
            text,
            "\n## exid {verb}\n\n```text\n{}\n```\n",
            lines.join("\n").trim_end()
        );
    }
    settle("docs/src/reference/commands.md", &text);
}

#[test]
fn codes_are_those_of_the_sources() {
    let codes = codes();
    assert!(codes.len() > 180, "{}", codes.len());
    let mut text = "# Codes of errors and findings\n\nEvery fault names its place, the value found and a remedy. Findings of \
                    `exid check`, and `mistakes` of other results, carry the code as `code`, and the terminal shows it in brackets. \
                    Codes do not change their meaning between versions. `…` stands for what the message fills in; the module is that \
                    of the [library](../CONTRIBUTING.md).\n"
        .to_owned();
    let mut modules: Vec<&str> = codes.values().map(|c| c.module.as_str()).collect();
    modules.sort_unstable();
    modules.dedup();
    for module in modules {
        let _ = write!(text, "\n## {module}\n\n| code | message |\n|---|---|\n");
        for (code, of) in codes.iter().filter(|(_, of)| of.module == module) {
            let _ = writeln!(text, "| `{code}` | {} |", of.message);
        }
    }
    settle("docs/src/reference/codes.md", &text);
}

#[test]
fn keys_of_results_are_those_of_the_sources() {
    let mut text = "# Keys of result.json\n\nOne flat object: `name`, `verb`, `mistakes`, the keys of `Run` and of `Estimate`, and those \
                    of the verb's own part, `Fit`, `Motors`, `Check`, `Simulation`, `Design`, `Diagnosis`, `Rollout`, `Trials`, `Fleet` or `Compared`. Numbers are in SI units; \
                    one that is not finite is `null`. Names in the column of types are sections of this page. How to read the most \
                    important ones is told in [Reading a result](../guide/results.md).\n"
        .to_owned();
    let mut named: Vec<String> = Vec::new();
    for file in RESULT_FILES {
        for structure in structures(file) {
            let meaning = without_item_links(&structure.meaning);
            let _ = write!(text, "\n## {}\n\n{meaning}\n\n", structure.name);
            named.extend(structure.fields.iter().filter_map(|field| {
                let (_, rest) = field.form.split_once('`')?;
                rest.split_once('`').map(|(name, _)| name.to_owned())
            }));
            text.push_str(match structure.words.is_empty() {
                true => "| key | type | meaning |\n|---|---|---|\n",
                false => "| word | meaning |\n|---|---|\n",
            });
            for field in structure.fields {
                let (form, meaning) = (field.form, as_cell(&without_item_links(&field.meaning)));
                let _ = writeln!(text, "| `{}` | {form} | {meaning} |", field.key);
            }
            for word in structure.words {
                let meaning = as_cell(&without_item_links(&word.meaning));
                let _ = writeln!(text, "| `{}` | {meaning} |", word.word);
            }
        }
    }
    let sections: Vec<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix("## "))
        .collect();
    let lost: Vec<&String> = named
        .iter()
        .filter(|name| !sections.contains(&name.as_str()))
        .collect();
    assert!(lost.is_empty(), "types of keys without a section: {lost:?}");
    let repeated = sections
        .iter()
        .filter(|name| sections.iter().filter(|n| n == name).count() > 1);
    assert_eq!(repeated.count(), 0, "two sections have one name");
    settle("docs/src/reference/result.md", &text);
}

/// The section of a folder's head that leads through its files, which is of no use to readers of a page.
const FILES: &str = "//!\n//! # Files";

/// What a source file says of itself at its head, as Markdown for a page: links to items are their names.
fn head_of(path: &str) -> String {
    let text = fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"));
    let text = text.split(FILES).next().unwrap();
    let head = text.lines().map_while(|line| line.strip_prefix("//!"));
    let head: Vec<&str> = head
        .map(|line| line.strip_prefix(' ').unwrap_or(line))
        .collect();
    let mut out = String::new();
    let mut inside = false;
    for line in head {
        inside ^= line.starts_with("```");
        out.push_str(&if inside {
            line.to_owned()
        } else {
            without_item_links(line)
        });
        out.push('\n');
    }
    out
}

/// `[`a::b`](c::d)` and `[`a::b`]` become `b`, and `[text](c::d)` the text.
fn without_item_links(line: &str) -> String {
    let mut out = String::new();
    let mut rest = line;
    while let Some(open) = rest.find('[') {
        let (before, from) = rest.split_at(open);
        out.push_str(before);
        let Some(close) = from.find(']') else {
            rest = from;
            break;
        };
        let (label, after) = (&from[1..close], &from[close + 1..]);
        let target = after.strip_prefix('(').and_then(|a| a.split_once(')'));
        let target = target.filter(|(t, _)| !t.contains([' ', '/', '.']) && t.contains(':'));
        if target.is_some() || (label.starts_with('`') && label.ends_with('`')) {
            let name = label.trim_matches('`').rsplit("::").next().unwrap();
            let name = if label.starts_with('`') {
                format!("`{name}`")
            } else {
                name.to_owned()
            };
            out.push_str(&name);
            rest = target.map_or(after, |(_, rest)| rest);
        } else {
            out.push_str(&from[..=close]);
            rest = after;
        }
    }
    out + rest
}

/// Between `<!-- from FILE -->` and `<!-- end -->` stands the head of that source file.
#[test]
fn theory_is_that_of_the_sources() {
    let mut count = 0;
    for page in pages::all() {
        let mut text = String::new();
        let mut skips = false;
        for line in page.text.lines() {
            let source = line
                .strip_prefix("<!-- from ")
                .and_then(|l| l.strip_suffix(" -->"));
            skips &= line != "<!-- end -->";
            if !skips {
                text.push_str(line);
                text.push('\n');
            }
            if let Some(source) = source {
                text.push_str(&format!("\n{}\n", head_of(source)));
                skips = true;
                count += 1;
            }
        }
        if skips {
            panic!("{}: no end", page.path.display());
        }
        if page.path.starts_with("docs/src/theory") {
            settle(page.path.to_str().unwrap(), &text);
        }
    }
    assert!(count > 40, "{count}");
}

#[test]
fn links_to_items_become_names() {
    let line =
        "the [Truth](truth::Truth) of [`crate::problem`], [`a::b`](crate::c) and [a page](x/y.md)";
    let expected = "the Truth of `problem`, `b` and [a page](x/y.md)";
    assert_eq!(without_item_links(line), expected);
}
