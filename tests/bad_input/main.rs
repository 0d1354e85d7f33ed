//! Broken robot files, problem files, recordings and command lines through the program itself: each
//! ends with its exit code and one message that names the place, the value found and a remedy, unlike
//! any other message, and leaves no trace. `EXID_SHOW=1` prints every message.

#[path = "../common/mod.rs"]
mod common;

mod bench;
mod command;
mod problem;
mod recording;
mod robot;

use bench::{Bench, Identity, Outcome};
use std::collections::BTreeMap;
use std::time::Duration;

/// Longest time a broken input may take, s: also a file of a gigabyte is refused by its first lines.
const LONGEST: Duration = Duration::from_secs(5);

/// One way in which an input breaks.
pub struct Case {
    what: &'static str,
    exit: i32,
    /// Parts of the message: file with line and column or key; the value found; what to do.
    place: &'static str,
    found: &'static str,
    remedy: &'static str,
    breaks: fn(&mut Bench),
}

const fn case(
    what: &'static str,
    exit: i32,
    [place, found, remedy]: [&'static str; 3],
    breaks: fn(&mut Bench),
) -> Case {
    Case {
        what,
        exit,
        place,
        found,
        remedy,
        breaks,
    }
}

/// What is wrong with the answer to a broken input; nothing where it is as stated.
fn complaints(case: &Case, outcome: &Outcome) -> Vec<String> {
    let text = &outcome.stderr;
    let mut wrong = Vec::new();
    let mut require = |holds: bool, words: String| {
        if !holds {
            wrong.push(words);
        }
    };
    require(
        outcome.exit == Some(case.exit),
        format!("exit {:?}, not {}", outcome.exit, case.exit),
    );
    require(text.starts_with("error: "), "no error".into());
    for part in [case.place, case.found, case.remedy] {
        require(
            !part.is_empty() && text.contains(part),
            format!("no {part:?}"),
        );
    }
    require(!text.contains("defect"), "a defect".into());
    require(outcome.stdout.is_empty(), "standard output".into());
    require(outcome.left.is_empty(), format!("left {:?}", outcome.left));
    require(
        outcome.took < LONGEST,
        format!("took {:.1} s", outcome.took.as_secs_f64()),
    );
    wrong
}

#[test]
fn every_broken_input_is_refused_with_place_value_and_remedy() {
    let tables = [
        robot::CASES,
        problem::CASES,
        problem::SETUP_CASES,
        recording::FILE_CASES,
        recording::CASES,
        command::CASES,
    ];
    let mut faults = Vec::new();
    let mut messages: BTreeMap<String, &str> = BTreeMap::new();
    let mut count = 0;
    for case in tables.into_iter().flatten() {
        let mut bench = Bench::new();
        (case.breaks)(&mut bench);
        if bench.identity == Identity::Unavailable {
            common::skip(&format!("{}: no other user to run as", case.what));
            continue;
        }
        let outcome = bench.run();
        count += 1;
        let show = || format!("{}\n    {}", case.what, outcome.stderr.trim_end());
        for words in complaints(case, &outcome) {
            faults.push(format!("{words}: {}", show()));
        }
        if let Some(other) = messages.insert(outcome.stderr.clone(), case.what) {
            faults.push(format!("same words as {other:?}: {}", show()));
        }
        if std::env::var_os("EXID_SHOW").is_some() {
            eprintln!("{}", show());
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n\n"));
    assert!(count >= 45, "{count} ways to break an input");
}

#[test]
fn the_input_that_is_broken_is_sound_before() {
    let outcome = Bench::new().run();
    assert_eq!(outcome.exit, Some(0), "{}", outcome.stderr);
    assert!(outcome.stderr.is_empty(), "{}", outcome.stderr);
    let wrote = |name: &str| outcome.left.iter().any(|path| path == name);
    for file in ["out/result.json", "out/predictions.csv", "out/report.html"] {
        assert!(wrote(file), "{file} among {:?}", outcome.left);
    }
}
