//! `fit` with the estimator `constant_velocity`: motor constants from motions at constant speed.

use std::io::{self, BufWriter, Write};

use crate::motors::task::{self, MotorRun};
use crate::outcome::check::Finding;
use crate::outcome::folder::ResultFolder;
use crate::outcome::predictions::{
    Block, Predictions, PredictionsWriter, Quantity, RecordingPredictions,
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
    mistakes: Vec<Finding>,
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
    let quantities = [Quantity::Recorded, Quantity::Predicted];
    let named = run
        .joints
        .iter()
        .flat_map(|joint| quantities.map(|quantity| (joint.clone(), quantity)));
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
        columns: named.collect(),
        recordings: recordings.collect(),
    }
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
