//! What runs share: reading the problem, the results folder, printing.

use crate::chain::effect;
use crate::check::{self, Extent};
use crate::cli::args::{Printing, Run};
use crate::cli::error::CliError;
use crate::cli::{colour, complain, interrupt};
use crate::outcome::check::{Finding, Severity};
use crate::outcome::estimate::Solver;
use crate::outcome::folder::ResultFolder;
use crate::outcome::input::Input;
use crate::outcome::provenance::Provenance;
use crate::outcome::run::{Run as Record, VERSION};
use crate::outcome::{Outcome, REPORT_FILE, RESULT_FILE};
use crate::problem::defect::Defect;
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::report;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

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

/// Sets the number of threads of everything that runs in parallel.
pub fn set_threads(threads: Option<u16>) -> Result<(), CliError> {
    let Some(threads) = threads else {
        return Ok(());
    };
    rayon::ThreadPoolBuilder::new()
        .num_threads(usize::from(threads))
        .build_global()
        .map_err(|e| CliError::WrongUse(format!("--threads {threads}: {e}")))
}

/// Mistakes in what the inputs say, before any work is done with them.
///
/// # Errors
/// Where they make every figure meaningless, unless the run is forced.
pub fn mistakes(
    run: &Run,
    problem: &ProblemFile,
    control: &Control<'_>,
    extent: Extent,
) -> Result<Vec<Finding>, CliError> {
    let mistakes = check::mistakes(problem, control, extent);
    if check::has_error(&mistakes) && !run.force {
        let of_error = |m: &Finding| m.severity == Severity::Error;
        return Err(CliError::Mistakes(
            mistakes.into_iter().filter(of_error).collect(),
        ));
    }
    Ok(mistakes)
}

/// The results folder of a run.
pub fn folder(run: &Run, problem: &ProblemFile, verb: &str) -> PathBuf {
    match &run.out {
        Some(folder) => folder.clone(),
        None => Path::new("results").join(&problem.name.value).join(verb),
    }
}

/// The results folder of a run, made sure that it can be written: refused before the work, not after it.
pub fn target(run: &Run, problem: &ProblemFile, verb: &str) -> Result<PathBuf, CliError> {
    writable(folder(run, problem, verb))
}

/// A results folder, made sure that it can be written.
pub fn writable(target: PathBuf) -> Result<PathBuf, CliError> {
    drop(ResultFolder::prepare(&target)?);
    Ok(target)
}

/// The exit code of a run that a defect ended, where what it had found before is written; standard error says so.
pub fn exit_code_of_defect(defect: &Defect, target: &Path) -> u8 {
    complain(&format!(
        "error: {defect}\nwhat was found before it is in {}",
        target.join(RESULT_FILE).display()
    ));
    CliError::DEFECT
}

/// The exit code of a run whose result is written; standard error says why it is none of success.
pub fn exit_code(interrupted: bool, solver: Option<&Solver>) -> u8 {
    match (interrupted, solver.filter(|s| !s.converged)) {
        (true, _) => CliError::INTERRUPTED,
        (false, None) => 0,
        (false, Some(solver)) => {
            let sentence = report::text::solver_sentence(solver);
            complain(&format!(
                "error: no solution: {sentence}; what was reached is written, and no figure of it can be relied on"
            ));
            CliError::NO_SOLUTION
        }
    }
}

/// The common head of a result; files that cannot be read any more are left out.
pub fn record(run: &Run, problem: &ProblemFile, files: &[PathBuf], started: Instant) -> Record {
    let all = std::iter::once(&problem.path).chain(files);
    Record {
        version: VERSION.to_string(),
        seed: run.seed,
        problem: problem.json.clone(),
        inputs: all.filter_map(|file| Input::of(file).ok()).collect(),
        wall_s: started.elapsed().as_secs_f64(),
        provenance: provenance(),
    }
}

/// Where the results of this process come from.
pub fn provenance() -> Provenance {
    let words = std::env::args_os().skip(1);
    Provenance::of_this_process(words.map(|w| w.to_string_lossy().into_owned()).collect())
}

/// Writes result and report beside what `fill` writes, replaces the folder, and prints.
pub fn finish(
    printing: Printing,
    target: &Path,
    outcome: &Outcome,
    fill: impl FnOnce(&ResultFolder) -> Result<(), CliError>,
) -> Result<(), CliError> {
    let json = write(target, outcome, fill)?;
    if printing.json {
        print(&json)?;
    } else if !printing.quiet {
        print(&report::text::summary(
            outcome,
            Some(&target.join(REPORT_FILE)),
        ))?;
    }
    Ok(())
}

/// Writes result and report beside what `fill` writes and replaces the folder; gives the result as JSON.
pub fn write(
    target: &Path,
    outcome: &Outcome,
    fill: impl FnOnce(&ResultFolder) -> Result<(), CliError>,
) -> Result<String, CliError> {
    let folder = ResultFolder::prepare(target)?;
    let json = outcome.to_json()?;
    folder.write(RESULT_FILE, |out| out.write_all(json.as_bytes()))?;
    fill(&folder)?;
    let html = report::render(folder.path())?;
    folder.write(REPORT_FILE, |out| out.write_all(html.as_bytes()))?;
    folder.commit()?;
    Ok(json)
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
    match write() {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::Output(error)),
        _ => Ok(()),
    }
}
