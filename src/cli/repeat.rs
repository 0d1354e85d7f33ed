//! `exid repeat`: the same run again, from the problem kept in the result, and whether it gives the same.

use crate::cli::args::{Campaign, Printing, Repetition, Run, Simulation};
use crate::cli::error::CliError;
use crate::cli::output::{self, print};
use crate::cli::problem_of_result::{absolute, prepare};
use crate::cli::{rollout, runs, trials};
use crate::outcome::difference::{Difference, differences};
use crate::outcome::document::answer;
use crate::outcome::provenance::VERSION;
use crate::outcome::rollout::Rollout;
use crate::outcome::trials::Trials;
use crate::outcome::{Outcome, Part, REPORT_FILE, RESULT_FILE};
use crate::verb::Verb;
use serde_json::json;
use std::fs;
use std::path::{Path, PathBuf};

/// Differences that a terminal shows.
const SHOWN: usize = 20;

pub fn run(query: &Repetition) -> Result<u8, CliError> {
    let earlier = Outcome::read(&query.result)?;
    let first = Answer::read(&query.result)?;
    let kept = tempfile::tempdir().map_err(|e| {
        CliError::WrongUse(format!(
            "no folder for the repetition: {e}; free space there"
        ))
    })?;
    let out = match &query.out {
        Some(out) => absolute(out)?,
        None => kept.path().join("result"),
    };
    let mut notes = notes_before(&earlier);
    let code = match &earlier.part {
        Part::Trials(made) => trials::run(&campaign(query, &earlier, made, out.clone()))?,
        Part::Rollout(made) => rollout::run(&simulation(query, &earlier, made, out.clone()))?,
        Part::Fleet(_) => {
            return Err(CliError::WrongUse(
                "a fleet is repeated by `exid fleet` with its manifest and other folders: --out and --items".to_string(),
            ));
        }
        part => {
            let mut problem = prepare(&earlier, &[], &mut notes)?;
            // What has been read once is not too long.
            output::bound(&mut problem, Some(u64::MAX));
            let options = Run {
                problem: problem.path.clone(),
                out: Some(out.clone()),
                set: Vec::new(),
                laws: Vec::new(),
                threads: query.threads,
                seed: earlier.run.seed,
                max_rows: None,
                // What a forced run was forced past is compared like the rest.
                force: true,
                printing: Printing::SILENT,
            };
            output::set_threads(options.threads)?;
            match part {
                Part::Fit(_) => runs::run(Verb::Fit, &options, &problem)?,
                Part::Check(_) => runs::run(Verb::Check, &options, &problem)?,
                Part::Simulate(_) => runs::run(Verb::Simulate, &options, &problem)?,
                Part::Design(_) => runs::run(Verb::Design, &options, &problem)?,
                Part::Diagnose(_) | Part::Trials(_) | Part::Rollout(_) | Part::Fleet(_) => {
                    runs::run(Verb::Diagnose, &options, &problem)?
                }
            }
        }
    };
    if code == CliError::INTERRUPTED {
        return Ok(code);
    }
    let comparison = Comparison {
        differences: differences(&first.result, &Answer::read(&out)?.result),
        files: first.other_files(&Answer::read(&out)?),
        notes,
    };
    if query.printing.json {
        print(&comparison.json())?;
    } else if !query.printing.quiet {
        print(&comparison.text(&query.result))?;
    }
    Ok(match comparison.is_same() {
        true => 0,
        false => CliError::ANOTHER_ANSWER,
    })
}

/// What a results folder answers, read before another run may take its place.
struct Answer {
    result: serde_json::Value,
    /// Names and contents of the other files; none where the file alone was named.
    files: Vec<(String, Vec<u8>)>,
}

impl Answer {
    fn read(result: &Path) -> Result<Self, CliError> {
        let mut files = Vec::new();
        for entry in fs::read_dir(result).into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            // The report is made of the result, and tells its provenance.
            if [RESULT_FILE, REPORT_FILE].contains(&name.as_str()) {
                continue;
            }
            if let Ok(bytes) = fs::read(entry.path()) {
                files.push((name, bytes));
            }
        }
        files.sort();
        Ok(Self {
            result: answer(result)?,
            files,
        })
    }

    /// Files of the repetition that the result has with other contents.
    fn other_files(&self, again: &Self) -> Vec<String> {
        let differs = |(name, bytes): &&(String, Vec<u8>)| {
            let mut same_name = self.files.iter().filter(|(own, _)| own == name);
            same_name.any(|(_, own)| own != bytes)
        };
        let other = again.files.iter().filter(differs);
        other.map(|(name, _)| name.clone()).collect()
    }
}

/// What a repetition gave beside the result.
struct Comparison {
    differences: Vec<Difference>,
    files: Vec<String>,
    notes: Vec<String>,
}

impl Comparison {
    fn is_same(&self) -> bool {
        self.differences.is_empty() && self.files.is_empty()
    }

    fn text(&self, result: &Path) -> String {
        let mut lines: Vec<String> = self.notes.iter().map(|n| format!("note: {n}")).collect();
        let shown = self.differences.iter().take(SHOWN);
        lines.extend(shown.map(|d| format!("{}: {} before, {} now", d.path, d.first, d.second)));
        if let more @ 1.. = self.differences.len().saturating_sub(SHOWN) {
            lines.push(format!("and {more} more; --json has them all"));
        }
        lines.extend(
            self.files
                .iter()
                .map(|file| format!("{file}: other contents")),
        );
        let result = result.display();
        lines.push(match self.is_same() {
            true => format!("{result}: the repetition gives the same, to the bit"),
            false => format!("{result}: the repetition gives another answer"),
        });
        lines.join("\n")
    }

    fn json(&self) -> String {
        let Self {
            differences,
            files,
            notes,
        } = self;
        let same = self.is_same();
        format!(
            "{:#}",
            json!({ "same": same, "differences": differences, "files": files, "notes": notes })
        )
    }
}

/// Why an answer may differ although nothing is wrong.
fn notes_before(earlier: &Outcome) -> Vec<String> {
    let mut notes = Vec::new();
    if earlier.run.version != VERSION {
        let made = &earlier.run.version;
        notes.push(format!(
            "the result was made by version {made}, this is version {VERSION}"
        ));
    }
    let stop = earlier.estimate.solver.as_ref().map(|s| s.stop.as_str());
    if stop == Some("interrupted") {
        notes.push("the run was interrupted, and such runs need not give the same".to_owned());
    }
    let budget = earlier.run.problem.pointer("/design/budget_s");
    if let (Part::Design(_), Some(budget)) = (&earlier.part, budget) {
        notes.push(format!(
            "the run had a budget of {budget} s, and such runs need not give the same"
        ));
    }
    notes
}

/// The same trials, drawn from the same.
fn campaign(query: &Repetition, earlier: &Outcome, made: &Trials, out: PathBuf) -> Campaign {
    let listed = |key: &str| -> Vec<String> {
        let list = earlier
            .run
            .problem
            .get(key)
            .and_then(|list| list.as_array());
        let words = list.into_iter().flatten().filter_map(|word| word.as_str());
        words.map(str::to_owned).collect()
    };
    let outside = earlier.run.problem.get("outside").is_some();
    let numbers: Vec<u64> = made.trials.iter().map(|trial| trial.seed).collect();
    let at_once = earlier.run.problem.get("at_once");
    let count = numbers.len() as u64;
    Campaign {
        effects: match outside {
            true => Vec::new(),
            false => listed("effects"),
        },
        outside,
        laws: listed("laws").into_iter().next().map(PathBuf::from),
        at_once: at_once.and_then(|counts| counts.as_str()?.parse().ok()),
        robots: listed("robots"),
        motion: listed("motion"),
        noise: listed("noise"),
        count,
        seed: earlier.run.seed,
        only: numbers,
        keep: None,
        out: Some(out),
        items: None,
        shard: None,
        threads: query.threads,
        printing: Printing::SILENT,
    }
}

/// The same rollout of the same result.
fn simulation(query: &Repetition, earlier: &Outcome, made: &Rollout, out: PathBuf) -> Simulation {
    let source = PathBuf::from(&made.source);
    let recorded = Path::new(&earlier.run.provenance.directory).join(&source);
    Simulation {
        result: if source.exists() { source } else { recorded },
        out: Some(out),
        set: made.set.clone(),
        threads: query.threads,
        seed: earlier.run.seed,
        printing: Printing::SILENT,
    }
}
