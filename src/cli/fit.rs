//! `exid fit`: parameters from recordings.

use crate::cli::args::Run;
use crate::cli::error::CliError;
use crate::cli::progress::Progress;
use crate::cli::{interrupt, motors, output};
use crate::estimate::task::{self, FitRun};
use crate::outcome::folder::ResultFolder;
use crate::outcome::predictions::{Block, PredictionsWriter, Quantity};
use crate::outcome::{Outcome, PREDICTIONS_FILE, Part};
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::problem_file::choices::Estimator;
use crate::problem_file::robot::RobotSource;
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;
use std::time::Instant;

pub fn run(run: &Run) -> Result<u8, CliError> {
    let started = Instant::now();
    let problem = output::open(run)?;
    let target = output::target(run, &problem, "fit")?;
    if problem.fit.estimator.value == Estimator::ConstantVelocity {
        return motors::run(run, &problem, &target, started);
    }
    let interrupt = interrupt::flag();
    let control = Control {
        interrupt: Some(interrupt),
        ..Control::default()
    };
    let progress = Progress::new(run);
    let result = task::run(&problem, &control, |step| progress.say(step.words()))?;
    progress.say("writing the results");
    let outcome = Outcome {
        name: problem.name.value.clone(),
        run: output::record(run, &problem, &files(&problem), started),
        estimate: result.fitted.estimate.clone(),
        part: Part::Fit(result.fitted.fit.clone()),
    };
    let converged = outcome.estimate.solver.as_ref().is_none_or(|s| s.converged);
    progress.done();
    output::finish(run, &target, &outcome, |folder| {
        predictions(folder, &result)
    })?;
    Ok(match (control.is_interrupted(), converged) {
        (true, _) => CliError::INTERRUPTED,
        (false, true) => 0,
        (false, false) => CliError::NO_SOLUTION,
    })
}

/// Every file that the problem file names, in its order.
pub fn files(problem: &ProblemFile) -> Vec<PathBuf> {
    let mut files = match &problem.robot.source {
        RobotSource::Urdf(path) | RobotSource::Mdh(path) => vec![path.resolved.clone()],
        RobotSource::Mechanism { .. } => Vec::new(),
    };
    files.extend(problem.robot.parameters.iter().map(|p| p.resolved.clone()));
    if let Some(table) = &problem.recordings {
        let groups = [&table.train, &table.loaded, &table.validation];
        for path in groups.into_iter().flatten() {
            if !files.contains(&path.resolved) {
                files.push(path.resolved.clone());
            }
        }
        files.extend(
            table
                .positions
                .iter()
                .map(|p| p.value.value.resolved.clone()),
        );
    }
    files
}

fn predictions(folder: &ResultFolder, run: &FitRun) -> Result<(), CliError> {
    folder.write(PREDICTIONS_FILE, |out| write_predictions(out, run))?;
    Ok(())
}

fn write_predictions<W: Write>(out: &mut BufWriter<W>, run: &FitRun) -> io::Result<()> {
    let channels: Vec<usize> = (0..run.fitted.model.channels().len())
        .filter(|&c| run.fitted.model.channels()[c].active)
        .collect();
    let names: Vec<String> = channels
        .iter()
        .map(|&c| run.fitted.model.channels()[c].name.clone())
        .collect();
    let with_velocity = run
        .fitted
        .model
        .channels()
        .iter()
        .all(|c| c.joint.is_some());
    let mut quantities = vec![Quantity::Recorded, Quantity::Predicted];
    if with_velocity {
        quantities.push(Quantity::Velocity);
    }
    let mut writer = PredictionsWriter::new(out, &names, &quantities)?;
    for (recording, predicted) in run.data.recordings.iter().zip(&run.fitted.predictions) {
        let rows: Vec<usize> = (0..recording.rows())
            .filter(|&r| recording.counts(r))
            .collect();
        let t: Vec<f64> = rows.iter().map(|&row| recording.time(row)).collect();
        let pick = |series: &[f64]| -> Vec<f64> { rows.iter().map(|&r| series[r]).collect() };
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for &c in &channels {
            columns.push(pick(recording.signal(c)));
            columns.push(pick(&predicted[c]));
            if let (true, Some(j)) = (with_velocity, run.fitted.model.channels()[c].joint) {
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
