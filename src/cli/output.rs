//! What runs share: reading the problem, the results folder, printing.

use crate::chain::effect;
use crate::cli::args::{Printing, Run};
use crate::cli::error::CliError;
use crate::cli::messages::complain;
use crate::cli::{colour, interrupt};
use crate::outcome::estimate::Solver;
use crate::outcome::folder::ResultFolder;
use crate::outcome::provenance::Provenance;
use crate::outcome::{Outcome, REPORT_FILE, RESULT_FILE};
use crate::problem_file::ProblemFile;
use crate::report;
use crate::verb::completed::Completed;
use crate::verb::ending::Ending;
use crate::verb::folder;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Reads the problem file with its overrides and sets the number of threads.
pub fn open(run: &Run) -> Result<ProblemFile, CliError> {
    set_threads(run.threads)?;
    let mut set = run.set.clone();
    if !run.laws.is_empty() {
        set.push(named_laws(&run.laws)?);
    }
    let mut problem = ProblemFile::read(&run.problem, &set, &effect::ids())?;
    bound(&mut problem, run.max_rows);
    Ok(problem)
}

/// Files of laws as an override of the problem file, whose paths start from its own folder.
fn named_laws(paths: &[PathBuf]) -> Result<String, CliError> {
    let absolute = |path: &PathBuf| {
        std::path::absolute(path).map_err(|e| {
            let path = path.display();
            CliError::WrongUse(format!("--laws {path}: {e}; name a file or a folder"))
        })
    };
    let paths: Vec<PathBuf> = paths.iter().map(absolute).collect::<Result<_, _>>()?;
    let texts = paths
        .iter()
        .map(|path| format!("{:?}", path.display().to_string()));
    Ok(format!("laws=[{}]", texts.collect::<Vec<_>>().join(", ")))
}

/// Bounds what is read of the recordings of a problem: an interrupt ends it, and files have so many rows at most, where that
/// is given.
pub fn bound(problem: &mut ProblemFile, max_rows: Option<u64>) {
    if let Some(recordings) = &mut problem.recordings {
        let reading = &mut recordings.reading;
        reading.interrupt = Some(interrupt::flag());
        if let Some(rows) = max_rows {
            reading.most_rows = usize::try_from(rows).unwrap_or(usize::MAX);
        }
    }
}

/// Starts the threads of everything that runs in parallel: so many, or one for each processor.
pub fn set_threads(threads: Option<u16>) -> Result<(), CliError> {
    let most = usize::from(threads.unwrap_or_default());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(most);
    pool.build_global().map_err(|reason| {
        CliError::WrongUse(format!(
            "the threads could not be started: {reason}; free memory and processes, or give fewer with --threads"
        ))
    })
}

/// The results folder of a run.
fn folder_of(run: &Run, problem: &ProblemFile, verb: &str) -> PathBuf {
    match &run.out {
        Some(folder) => folder.clone(),
        None => Path::new("results").join(&problem.name.value).join(verb),
    }
}

/// The results folder of a run, made sure that it can be written: refused before the work, not after it.
pub fn target(run: &Run, problem: &ProblemFile, verb: &str) -> Result<PathBuf, CliError> {
    writable(folder_of(run, problem, verb))
}

/// A results folder, made sure that it can be written.
pub fn writable(target: PathBuf) -> Result<PathBuf, CliError> {
    drop(ResultFolder::prepare(&target)?);
    Ok(target)
}

/// Prints of an ending without success why it is none; gives its exit code.
pub fn exit_code(ending: &Ending, solver: Option<&Solver>, target: &Path) -> u8 {
    match (ending, solver) {
        (Ending::Defect(defect), _) => complain(&format!(
            "error: {defect}\nwhat was found before it is in {}",
            target.join(RESULT_FILE).display()
        )),
        (Ending::NoSolution, Some(solver)) => {
            let sentence = report::text::solver_sentence(solver);
            complain(&format!(
                "error: no solution: {sentence}; what was reached is written, and no figure of it can be relied on"
            ));
        }
        _ => {}
    }
    ending.exit_code()
}

/// Arguments of the command that this process was given.
pub fn command() -> Vec<String> {
    let words = std::env::args_os().skip(1);
    words.map(|w| w.to_string_lossy().into_owned()).collect()
}

/// Where the results of this process come from.
pub fn provenance() -> Provenance {
    Provenance::of_this_process(command())
}

/// A path as one would type it where the process stands.
fn from_here(path: PathBuf) -> PathBuf {
    match std::env::current_dir() {
        Ok(here) => path.strip_prefix(here).unwrap_or(&path).to_path_buf(),
        Err(_) => path,
    }
}

/// Writes the results folder of a run and prints its result.
pub fn finish(printing: Printing, target: &Path, completed: Completed) -> Result<(), CliError> {
    // The words are few, and the recordings behind the result many.
    let summary = Summary::of(&completed.outcome, target, printing);
    let json = completed.write(target)?;
    summary.print(&json)
}

/// As [`finish`], of a result without files beside it.
pub fn finish_alone(printing: Printing, target: &Path, outcome: &Outcome) -> Result<(), CliError> {
    let json = folder::write(target, outcome, |_| Ok(()))?;
    Summary::of(outcome, target, printing).print(&json)
}

/// What is printed of a result.
enum Summary {
    Nothing,
    Json,
    Words(String),
}

impl Summary {
    fn of(outcome: &Outcome, target: &Path, printing: Printing) -> Self {
        if printing.json {
            Self::Json
        } else if printing.quiet {
            Self::Nothing
        } else {
            let report = target.join(REPORT_FILE);
            Self::Words(report::text::summary(outcome, Some(&from_here(report))))
        }
    }

    fn print(&self, json: &str) -> Result<(), CliError> {
        match self {
            Self::Nothing => Ok(()),
            Self::Json => print(json),
            Self::Words(words) => print(words),
        }
    }
}

/// Prints to standard output; a reader that went away is no error.
pub fn print(text: &str) -> Result<(), CliError> {
    let mut out = std::io::stdout().lock();
    let text = colour::for_stream(text, &out);
    let mut write = || {
        out.write_all(text.as_bytes())?;
        if !text.ends_with('\n') {
            out.write_all(b"\n")?;
        }
        out.flush()
    };
    unless_gone(write())
}

/// What became of printing; a reader that went away is no error.
pub fn unless_gone(printed: std::io::Result<()>) -> Result<(), CliError> {
    match printed {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::Output(error)),
        _ => Ok(()),
    }
}
