//! `fit` with the estimator `constant_velocity`: motor constants from motions at constant speed.

use std::io::{self, BufWriter, Write};

use crate::motors::task::{self, MotorRun};
use crate::outcome::check::Mistake;
use crate::outcome::folder::ResultFolder;
use crate::outcome::predictions::{
    Block, Column, Predictions, PredictionsWriter, Quantity, RecordingPredictions,
};
use crate::outcome::{Outcome, PREDICTIONS_FILE, Part};
use crate::problem_file::ProblemFile;
use crate::verb::completed::{Completed, Found};
use crate::verb::ending::Ending;
use crate::verb::error::VerbError;
use crate::verb::inputs;
use crate::verb::settings::Settings;

pub(super) fn run(
    problem: &ProblemFile,
    settings: &Settings,
    mistakes: Vec<Mistake>,
) -> Result<Completed, VerbError> {
    settings.say("reading the recordings and finding their steady parts");
    let result = task::run(problem)?;
    Ok(Completed {
        outcome: Outcome {
            name: problem.name.value.clone(),
            run: settings.record(problem, &inputs::of_recordings(problem)),
            mistakes,
            estimate: result.estimate.clone(),
            part: Part::Fit(result.fit.clone()),
        },
        ending: Ending::Done,
        found: Found::Motors(Box::new(result)),
    })
}

pub(super) fn write(folder: &ResultFolder, run: &MotorRun) -> Result<(), VerbError> {
    folder.write(PREDICTIONS_FILE, |out| write_predictions(out, run))?;
    Ok(())
}

/// What the fitted constants give along the steady parts.
pub(super) fn table(run: &MotorRun) -> Predictions {
    let recordings = run
        .predictions
        .iter()
        .map(|predicted| RecordingPredictions {
            recording: predicted.recording.clone(),
            split: predicted.split,
            t: predicted.t.clone(),
            values: predicted.columns.clone(),
        });
    Predictions {
        columns: columns(run),
        recordings: recordings.collect(),
    }
}

/// What is recorded of each joint and what the constants give.
fn columns(run: &MotorRun) -> Vec<Column> {
    let of = |joint: &String| {
        [Quantity::Recorded, Quantity::Predicted].map(|quantity| Column {
            joint: joint.clone(),
            quantity,
        })
    };
    run.joints.iter().flat_map(of).collect()
}

fn write_predictions<W: Write>(out: &mut BufWriter<W>, run: &MotorRun) -> io::Result<()> {
    let mut writer = PredictionsWriter::new(out, &columns(run))?;
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
