//! `exid check`: reads everything, runs nothing.

use crate::check::{self, AtFault};
use crate::cli::args::Run;
use crate::cli::error::CliError;
use crate::cli::progress::Progress;
use crate::cli::{inputs, interrupt, output};
use crate::outcome::check::Check;
use crate::outcome::estimate::Estimate;
use crate::outcome::{Outcome, Part};
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use std::time::Instant;

pub fn run(run: &Run, problem: &ProblemFile) -> Result<u8, CliError> {
    let started = Instant::now();
    let target = output::target(run, problem, "check")?;
    let control = Control {
        interrupt: Some(interrupt::flag()),
        ..Control::default()
    };
    let progress = Progress::new(run.printing);
    progress.say("reading the robot and the recordings");
    let findings = check::run(problem, &control);
    progress.done();
    let code = match check::at_fault(problem, &findings) {
        AtFault::Data => CliError::WRONG_DATA,
        AtFault::ProblemFile => CliError::WRONG_USE,
        AtFault::Nothing => 0,
    };
    let outcome = Outcome {
        name: problem.name.value.clone(),
        run: output::record(run, problem, &inputs::of_recordings(problem), started),
        mistakes: Vec::new(),
        estimate: Estimate::default(),
        part: Part::Check(Check { findings }),
    };
    output::finish(run.printing, &target, &outcome, |_| Ok(()))?;
    Ok(if control.is_interrupted() {
        CliError::INTERRUPTED
    } else {
        code
    })
}
