//! What the sources say of themselves: codes of errors with their messages, and the fields of results with their documentation.

use crate::pages::root;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// A source file without its tests.
struct Source {
    /// From `src`.
    path: PathBuf,
    text: String,
}

fn sources() -> Vec<Source> {
    let src = root().join("src");
    let mut folders = vec![src.clone()];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() && name != "tests" {
                folders.push(path);
            } else if name.ends_with(".rs") && name != "tests.rs" {
                let text = fs::read_to_string(&path).unwrap();
                let own = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
                found.push(Source {
                    path: path.strip_prefix(&src).unwrap().to_path_buf(),
                    text: own.to_owned(),
                });
            }
        }
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    found
}

/// A text in quotes and where it ends.
struct Literal {
    start: usize,
    end: usize,
    text: String,
}

/// Texts in quotes, lines that go on joined.
fn literals(source: &str) -> Vec<Literal> {
    let bytes = source.as_bytes();
    let mut found = Vec::new();
    let mut k = 0;
    while k < bytes.len() {
        match bytes[k] {
            b'/' if bytes.get(k + 1) == Some(&b'/') => {
                k += source[k..].find('\n').unwrap_or(source.len() - k);
            }
            b'\'' if bytes.get(k + 1) == Some(&b'"') => k += 3,
            b'"' => {
                let start = k;
                k += 1;
                while k < bytes.len() && bytes[k] != b'"' {
                    k += if bytes[k] == b'\\' { 2 } else { 1 };
                }
                k += 1;
                let mut text = String::new();
                let mut rest = source[start + 1..k - 1].chars().peekable();
                while let Some(c) = rest.next() {
                    match (c, rest.peek()) {
                        ('\\', Some('\n')) => {
                            while rest.next_if(|c| c.is_whitespace()).is_some() {}
                        }
                        ('\\', Some(_)) => text.extend(rest.next()),
                        _ => text.push(c),
                    }
                }
                found.push(Literal {
                    start,
                    end: k,
                    text,
                });
            }
            _ => k += 1,
        }
    }
    found
}

fn is_code(text: &str) -> bool {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    text.len() > 3
        && text.starts_with(|c: char| c.is_ascii_lowercase())
        && text.chars().all(allowed)
}

/// What a code stands for.
pub struct Code {
    /// Module that says it.
    pub module: String,
    /// With `…` in the place of values; empty where the message is put together.
    pub message: String,
}

/// Codes of errors and findings: a code directly before its message, or what a function `code` gives.
pub fn codes() -> BTreeMap<String, Code> {
    let mut found: BTreeMap<String, Code> = BTreeMap::new();
    for source in sources() {
        let is_fault = source.text.contains("Description") || source.path.starts_with("check");
        if !is_fault {
            continue;
        }
        let module = source.path.iter().next().unwrap().to_string_lossy();
        let module = module.trim_end_matches(".rs").to_owned();
        let literals = literals(&source.text);
        for (k, literal) in literals
            .iter()
            .enumerate()
            .filter(|(_, l)| is_code(&l.text))
        {
            let message = literals.get(k + 1).filter(|next| {
                let between = source.text[literal.end..next.start].split_whitespace();
                let between: String = between.collect();
                next.text.contains(' ')
                    && [",", ",format!(", ",&format!("].contains(&between.as_str())
            });
            let from_function = in_function_code(&source.text, literal.start);
            let before = source.text[..literal.start].trim_end();
            let is_given = before.ends_with("Description::new(");
            if message.is_none() && !from_function && !is_given {
                continue;
            }
            let message = match message {
                Some(message) => without_values(&message.text),
                None if is_given => "…".to_owned(),
                None => String::new(),
            };
            let code = found.entry(literal.text.clone()).or_insert_with(|| Code {
                module: module.clone(),
                message: String::new(),
            });
            if code.message.is_empty() {
                code.message = message;
            }
        }
    }
    found
}

/// Whether a place lies in the body of a function `code`.
fn in_function_code(text: &str, place: usize) -> bool {
    let Some(start) = text[..place].rfind("fn ") else {
        return false;
    };
    text[start..].starts_with("fn code(")
}

fn without_values(message: &str) -> String {
    let mut out = String::new();
    let mut depth = 0;
    for c in message.chars() {
        match c {
            '{' => {
                if depth == 0 {
                    out.push('…');
                }
                depth += 1;
            }
            '}' => depth -= 1,
            c if depth == 0 => out.push(c),
            _ => {}
        }
    }
    as_cell(&out)
}

/// Text as a cell of a table.
pub fn as_cell(text: &str) -> String {
    text.replace('|', "\\|").replace('<', "&lt;")
}

/// A structure of results, or the words that one of its fields may have.
pub struct Structure {
    pub name: String,
    pub meaning: String,
    /// Empty where these are words.
    pub fields: Vec<Field>,
    pub words: Vec<Word>,
}

pub struct Field {
    /// As it stands in the file.
    pub key: String,
    pub form: String,
    pub meaning: String,
}

pub struct Word {
    /// As it stands in the file.
    pub word: String,
    pub meaning: String,
}

/// The name of a variant as it stands in a file: `NothingMissing` is `nothing_missing` in snake case.
fn word_of(variant: &str, case: &str) -> String {
    let mut word = String::new();
    for (k, c) in variant.char_indices() {
        if k > 0 && c.is_uppercase() && case == "snake_case" {
            word.push('_');
        }
        word.extend(c.to_lowercase());
    }
    word
}

/// The structures of a file of `src/outcome` that are written to results.
pub fn structures(file: &str) -> Vec<Structure> {
    let text = fs::read_to_string(root().join("src/outcome").join(file)).unwrap();
    let mut found: Vec<Structure> = Vec::new();
    let (mut meaning, mut rename, mut written) = (String::new(), None, false);
    let (mut open, mut case) = (false, None);
    for line in text.lines() {
        let trimmed = line.trim();
        if let Some(words) = trimmed.strip_prefix("/// ") {
            meaning = format!("{meaning} {words}").trim().to_owned();
        } else if trimmed.starts_with("#[") {
            written |= trimmed.contains("Serialize");
            let quoted = |after: &str| {
                let (_, rest) = trimmed.split_once(after)?;
                rest.split_once('"').map(|(text, _)| text.to_owned())
            };
            rename = quoted("rename = \"").or(rename);
            case = quoted("rename_all = \"").or(case);
        } else if let Some(rest) = (line.strip_prefix("pub struct "))
            .or_else(|| line.strip_prefix("pub enum ").filter(|_| case.is_some()))
        {
            open = written && rest.ends_with('{');
            if open {
                found.push(Structure {
                    name: rest.trim_end_matches([' ', '{']).to_owned(),
                    meaning: std::mem::take(&mut meaning),
                    fields: Vec::new(),
                    words: Vec::new(),
                });
            }
            (meaning, written) = (String::new(), false);
        } else if line == "}" {
            (open, case) = (false, None);
            (meaning, written) = (String::new(), false);
        } else if let (true, Some(case), Some(variant)) = (open, &case, trimmed.strip_suffix(','))
            && variant.chars().all(char::is_alphanumeric)
        {
            found.last_mut().unwrap().words.push(Word {
                word: rename.take().unwrap_or_else(|| word_of(variant, case)),
                meaning: std::mem::take(&mut meaning),
            });
        } else if let (true, Some((key, form))) = (
            open,
            trimmed
                .strip_prefix("pub ")
                .and_then(|field| field.split_once(": ")),
        ) {
            found.last_mut().unwrap().fields.push(Field {
                key: rename.take().unwrap_or_else(|| key.to_owned()),
                form: in_words(form.trim_end_matches(',')),
                meaning: std::mem::take(&mut meaning),
            });
        } else if !trimmed.starts_with("#[") && !trimmed.is_empty() && !open {
            (meaning, written) = (String::new(), false);
        }
    }
    found
}

/// A type in the words of JSON; structures are named.
fn in_words(form: &str) -> String {
    let inner = |prefix: &str| form.strip_prefix(prefix)?.strip_suffix('>');
    if let Some(inner) = inner("Option<") {
        return format!("{} or null", in_words(inner));
    }
    if let Some(inner) = inner("Vec<") {
        return format!("list of {}", in_words(inner));
    }
    if let Some((item, count)) = form
        .strip_prefix('[')
        .and_then(|f| f.strip_suffix(']')?.rsplit_once("; "))
    {
        return format!("{count} of {}", in_words(item));
    }
    if let Some((_, value)) = inner("BTreeMap<").and_then(|inner| inner.split_once(", ")) {
        return format!("table by name of {}", in_words(value));
    }
    match form {
        "f64" => "number".to_owned(),
        "u64" | "u32" | "usize" => "whole number".to_owned(),
        "bool" => "true or false".to_owned(),
        "String" => "text".to_owned(),
        "serde_json::Value" | "Value" => "as read".to_owned(),
        other => format!("`{}`", other.rsplit("::").next().unwrap()),
    }
}

/// Files of `src/outcome` whose structures are part of a result, the common head first.
pub const RESULT_FILES: &[&str] = &[
    "run.rs",
    "input.rs",
    "provenance.rs",
    "estimate.rs",
    "parameter.rs",
    "joint.rs",
    "check.rs",
    "fit.rs",
    "feasibility.rs",
    "load.rs",
    "model_comparison.rs",
    "sharing.rs",
    "motors.rs",
    "machine.rs",
    "diagnose.rs",
    "finding.rs",
    "formula.rs",
    "simulator.rs",
    "difference.rs",
    "rollout.rs",
    "skeleton.rs",
    "design.rs",
    "simulation.rs",
    "trials.rs",
    "fleet.rs",
    "compare.rs",
];

#[test]
fn result_files_are_there() {
    for file in RESULT_FILES {
        assert!(
            Path::new(&root().join("src/outcome").join(file)).exists(),
            "{file}"
        );
    }
}
