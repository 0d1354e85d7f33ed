//! Which files outside the folder of effects name one, in a text or in a path.

use std::collections::BTreeSet;
use std::path::Path;

use crate::source::{Source, bare, uncommented};

/// Where effects are at home.
const HOME: &str = "src/chain/effect";

/// A file or folder that names effects although it is not their home, and why.
struct Exception {
    path: &'static str,
    reason: &'static str,
}

const EXCEPTIONS: &[Exception] = &[
    Exception {
        path: "src/problem_file",
        reason: "examples in the reference of keys, and the key drive.rotor_inertia",
    },
    Exception {
        path: "src/cli/args.rs",
        reason: "examples in the help",
    },
    Exception {
        path: "src/robot/mjcf",
        reason: "remedies of messages, on a layer below the effects",
    },
    Exception {
        path: "src/simulate/error.rs",
        reason: "the key drive.rotor_inertia",
    },
    Exception {
        path: "src/trials/files.rs",
        reason: "the key drive.rotor_inertia",
    },
];

/// A place that names an effect.
struct Mention {
    file: String,
    line: usize,
    effect: String,
}

/// The identifiers of the vocabulary, as its files state them.
fn identifiers(sources: &[Source]) -> BTreeSet<String> {
    let at_home = sources.iter().filter(|source| {
        source.path.parent() == Some(Path::new(HOME)) && source.text.contains("EFFECT: Effect =")
    });
    let stated = |source: &Source| {
        let (_, rest) = source.text.split_once("    id: \"")?;
        Some(rest.split_once('"')?.0.to_owned())
    };
    at_home.filter_map(stated).collect()
}

/// What a file says of effects outside of its tests and comments: in a text or a path. The field of a structure and a
/// variable that have the name of a quantity are neither.
fn mentions(source: &Source, identifiers: &BTreeSet<String>) -> Vec<Mention> {
    let own = source.text.split("#[cfg(test)]\nmod tests {").next();
    let own = own.unwrap_or(&source.text);
    let (with_texts, without) = (uncommented(own), bare(own));
    let mut found = Vec::new();
    for (number, (line, code)) in with_texts.lines().zip(without.lines()).enumerate() {
        let code: Vec<char> = code.chars().collect();
        for (at, word) in words(line) {
            let in_text = code.get(at) == Some(&' ');
            let rest: String = line.chars().skip(at + word.len()).take(2).collect();
            let before: String = line.chars().take(at).collect();
            let in_path = before.ends_with("::") || rest == "::";
            if identifiers.contains(word) && (in_text || in_path) {
                found.push(Mention {
                    file: source.path.display().to_string(),
                    line: number + 1,
                    effect: word.to_owned(),
                });
            }
        }
    }
    found
}

/// The words of a line, each with how many characters stand before it.
fn words(line: &str) -> Vec<(usize, &str)> {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut words = Vec::new();
    let mut rest = line;
    while let Some(start) = rest.find(is_word) {
        let end = rest[start..]
            .find(|c| !is_word(c))
            .map_or(rest.len(), |n| start + n);
        let passed = line.len() - rest.len() + start;
        words.push((line[..passed].chars().count(), &rest[start..end]));
        rest = &rest[end..];
    }
    words
}

#[test]
fn no_file_outside_their_folder_names_an_effect() {
    let sources = crate::source::sources("src");
    let identifiers = identifiers(&sources);
    assert!(identifiers.len() > 20, "{identifiers:?}");
    let mut excepted = BTreeSet::new();
    let mut faults = Vec::new();
    for source in &sources {
        let is_test = source
            .path
            .iter()
            .any(|part| part == "tests" || part == "tests.rs");
        if is_test || source.path.starts_with(HOME) {
            continue;
        }
        for Mention { file, line, effect } in mentions(source, &identifiers) {
            let mut exceptions = EXCEPTIONS.iter();
            match exceptions.find(|exception| source.path.starts_with(exception.path)) {
                Some(exception) => {
                    excepted.insert(exception.path);
                }
                None => faults.push(format!("{file}:{line}: {effect}")),
            }
        }
    }
    assert!(
        faults.is_empty(),
        "effects are named outside {HOME}:\n{}",
        faults.join("\n")
    );
    for Exception { path, reason } in EXCEPTIONS {
        assert!(
            excepted.contains(path),
            "{path} names no effect any more ({reason})"
        );
    }
}

#[test]
fn texts_and_paths_name_an_effect_and_fields_do_not() {
    let identifiers = BTreeSet::from(["backlash".to_owned()]);
    let of = |text: &str| {
        let source = Source {
            path: "src/a.rs".into(),
            text: text.to_owned(),
        };
        mentions(&source, &identifiers).len()
    };
    assert_eq!(of("let x = find(\"backlash\");"), 1);
    assert_eq!(of("let x = \"a2.backlash.gap\";"), 1);
    assert_eq!(
        of("use crate::chain::effect::backlash;\nlet x = backlash::EFFECT.id;"),
        2
    );
    assert_eq!(
        of("joint.backlash = backlash; // \"backlash\"\nlet backlash_width = 1;"),
        0
    );
    assert_eq!(
        of("#[cfg(test)]\nmod tests { fn f() { find(\"backlash\") } }"),
        0
    );
}
