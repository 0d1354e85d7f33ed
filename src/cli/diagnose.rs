//! `exid diagnose`: where model and recordings differ, what physics is missing, the model with it.

use crate::cli::args::Run;
use crate::cli::error::CliError;
use crate::cli::fit::files;
use crate::cli::progress::Progress;
use crate::cli::{interrupt, output};
use crate::diagnose::task::{self, DiagnoseRun};
use crate::outcome::folder::ResultFolder;
use crate::outcome::predictions::{Block, PredictionsWriter, Quantity};
use crate::outcome::{Outcome, PREDICTIONS_FILE, Part};
use crate::problem::solution::Control;
use std::io::{self, BufWriter, Write};
use std::time::Instant;

pub fn run(run: &Run) -> Result<u8, CliError> {
    let started = Instant::now();
    let problem = output::open(run)?;
    let target = output::folder(run, &problem, "diagnose");
    // A folder that cannot be written is refused before the work, not after it.
    drop(ResultFolder::prepare(&target)?);
    let control = Control {
        interrupt: Some(interrupt::flag()),
        ..Control::default()
    };
    let progress = Progress::new(run);
    let mut result = task::run(&problem, &control, &|stage| progress.say(stage.words()))?;
    progress.say("writing the results");
    if let (true, Some(solver)) = (control.is_interrupted(), &mut result.estimate.solver) {
        solver.stop = "interrupted".to_string();
        solver.converged = false;
    }
    let outcome = Outcome {
        name: problem.name.value.clone(),
        run: output::record(run, &problem, &files(&problem), started),
        estimate: result.estimate.clone(),
        part: Part::Diagnose(Box::new(result.diagnosis.clone())),
    };
    let converged = outcome.estimate.solver.as_ref().is_none_or(|s| s.converged);
    progress.done();
    output::finish(run, &target, &outcome, |folder| {
        folder.write(PREDICTIONS_FILE, |out| write_predictions(out, &result))?;
        Ok(())
    })?;
    Ok(match (control.is_interrupted(), converged) {
        (true, _) => CliError::INTERRUPTED,
        (false, true) => 0,
        (false, false) => CliError::NO_SOLUTION,
    })
}

fn write_predictions<W: Write>(out: &mut BufWriter<W>, run: &DiagnoseRun) -> io::Result<()> {
    let channels: Vec<usize> = (0..run.model.channels().len())
        .filter(|&c| run.model.channels()[c].active)
        .collect();
    let name = |&c: &usize| run.model.channels()[c].name.clone();
    let names: Vec<String> = channels.iter().map(name).collect();
    let with_velocity = run.model.channels().iter().all(|c| c.joint.is_some());
    let mut quantities = vec![Quantity::Recorded, Quantity::Baseline, Quantity::Final];
    if with_velocity {
        quantities.push(Quantity::Velocity);
    }
    let mut writer = PredictionsWriter::new(out, &names, &quantities)?;
    let both = run.baseline.iter().zip(&run.finally);
    for (recording, (baseline, finally)) in run.data.recordings.iter().zip(both) {
        let rows: Vec<usize> = (0..recording.rows())
            .filter(|&r| recording.counts(r))
            .collect();
        let t: Vec<f64> = rows.iter().map(|&row| recording.time(row)).collect();
        let pick = |series: &[f64]| -> Vec<f64> { rows.iter().map(|&r| series[r]).collect() };
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for &c in &channels {
            columns.push(pick(recording.signal(c)));
            columns.push(pick(&baseline[c]));
            columns.push(pick(&finally[c]));
            if let (true, Some(j)) = (with_velocity, run.model.channels()[c].joint) {
                columns.push(pick(&recording.segment().motors.dq[j]));
            }
        }
        let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        writer.block(&Block {
            recording: &recording.name,
            split: recording.split,
            t: &t,
            columns: &slices,
        })?;
    }
    Ok(())
}
