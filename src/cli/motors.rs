//! `exid fit` with the estimator `constant_velocity`: motor constants from motions at constant speed.

use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::time::Instant;

use crate::cli::args::Run;
use crate::cli::error::CliError;
use crate::cli::progress::Progress;
use crate::cli::{inputs, output};
use crate::motors::task::{self, MotorRun};
use crate::outcome::check::Finding;
use crate::outcome::predictions::{Block, PredictionsWriter, Quantity};
use crate::outcome::{Outcome, PREDICTIONS_FILE, Part};
use crate::problem_file::ProblemFile;

pub fn run(
    run: &Run,
    problem: &ProblemFile,
    target: &Path,
    mistakes: Vec<Finding>,
    started: Instant,
) -> Result<u8, CliError> {
    let progress = Progress::new(run.printing);
    progress.say("reading the recordings and finding their steady parts");
    let result = task::run(problem)?;
    progress.say("writing the results");
    let outcome = Outcome {
        name: problem.name.value.clone(),
        run: output::record(run, problem, &inputs::of_recordings(problem), started),
        mistakes,
        estimate: result.estimate.clone(),
        part: Part::Fit(result.fit.clone()),
    };
    progress.done();
    output::finish(run.printing, target, &outcome, |folder| {
        folder.write(PREDICTIONS_FILE, |out| write_predictions(out, &result))?;
        Ok(())
    })?;
    Ok(0)
}

fn write_predictions<W: Write>(out: &mut BufWriter<W>, run: &MotorRun) -> io::Result<()> {
    let quantities = [Quantity::Recorded, Quantity::Predicted];
    let mut writer = PredictionsWriter::new(out, &run.joints, &quantities)?;
    for predicted in &run.predictions {
        let columns: Vec<&[f64]> = predicted.columns.iter().map(Vec::as_slice).collect();
        writer.block(&Block {
            recording: &predicted.recording,
            split: predicted.split,
            t: &predicted.t,
            columns: &columns,
        })?;
    }
    Ok(())
}
