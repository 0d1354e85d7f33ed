//! `exid check`: reads everything, runs nothing.

use crate::check;
use crate::cli::args::Run;
use crate::cli::error::CliError;
use crate::cli::progress::Progress;
use crate::cli::{fit, interrupt, output};
use crate::outcome::check::{Check, Finding, Severity};
use crate::outcome::estimate::Estimate;
use crate::outcome::{Outcome, Part};
use crate::problem::solution::Control;
use std::path::Path;
use std::time::Instant;

pub fn run(run: &Run) -> Result<u8, CliError> {
    let started = Instant::now();
    let problem = output::open(run)?;
    let target = output::folder(run, &problem, "check");
    let control = Control {
        interrupt: Some(interrupt::flag()),
        ..Control::default()
    };
    let progress = Progress::new(run);
    progress.say("reading the robot and the recordings");
    let findings = check::run(&problem, &control);
    progress.done();
    let code = exit_code(&findings, &problem.path);
    let outcome = Outcome {
        name: problem.name.value.clone(),
        run: output::record(run, &problem, &fit::files(&problem), started),
        estimate: Estimate::default(),
        part: Part::Check(Check { findings }),
    };
    output::finish(run, &target, &outcome, |_| Ok(()))?;
    Ok(if control.is_interrupted() {
        CliError::INTERRUPTED
    } else {
        code
    })
}

/// 3 if a recording or robot file is at fault, 2 if only the problem file is.
fn exit_code(findings: &[Finding], problem: &Path) -> u8 {
    let problem = problem.display().to_string();
    let errors = || findings.iter().filter(|f| f.severity == Severity::Error);
    let of_problem = |f: &&Finding| f.file.as_deref().is_none_or(|file| file == problem);
    match (
        errors().any(|f| !of_problem(&f)),
        errors().any(|f| of_problem(&f)),
    ) {
        (true, _) => CliError::WRONG_DATA,
        (false, true) => CliError::WRONG_USE,
        (false, false) => 0,
    }
}
