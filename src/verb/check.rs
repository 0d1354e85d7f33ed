//! `check`: reads everything, runs nothing.

use crate::check::{self, AtFault};
use crate::outcome::check::Check;
use crate::outcome::estimate::Estimate;
use crate::outcome::{Outcome, Part};
use crate::problem_file::ProblemFile;
use crate::verb::completed::{Completed, Found};
use crate::verb::ending::Ending;
use crate::verb::inputs;
use crate::verb::settings::Settings;

/// Checks a problem and what it names.
pub fn run(problem: &ProblemFile, settings: &Settings) -> Completed {
    let control = settings.control();
    settings.say("reading the robot and the recordings");
    let findings = check::run(problem, &control);
    let ending = match check::at_fault(problem, &findings) {
        _ if control.is_interrupted() => Ending::Interrupted,
        AtFault::Data => Ending::WrongData,
        AtFault::ProblemFile => Ending::WrongProblem,
        AtFault::Nothing => Ending::Done,
    };
    Completed {
        outcome: Outcome {
            name: problem.name.value.clone(),
            run: settings.record(problem, &inputs::of_recordings(problem)),
            mistakes: Vec::new(),
            estimate: Estimate::default(),
            part: Part::Check(Check { findings }),
        },
        ending,
        found: Found::Findings,
    }
}
