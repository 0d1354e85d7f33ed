//! Writes `predictions.csv` of a model along its recordings.

use crate::chain::dataset::Dataset;
use crate::chain::model::Model;
use crate::cli::error::CliError;
use crate::estimate::figures::Predictions;
use crate::outcome::PREDICTIONS_FILE;
use crate::outcome::folder::ResultFolder;
use crate::outcome::predictions::{Block, PredictionsWriter, Quantity};
use std::borrow::Cow;
use std::io::{self, BufWriter, Write};

/// Writes the recorded signal, what each of `predicted` gives, and the speed and the position of the joints.
pub fn write(
    folder: &ResultFolder,
    (model, data): (&Model, &Dataset),
    predicted: &[(Quantity, &Predictions)],
) -> Result<(), CliError> {
    folder.write(PREDICTIONS_FILE, |out| {
        write_rows(out, (model, data), predicted)
    })?;
    Ok(())
}

fn write_rows<W: Write>(
    out: &mut BufWriter<W>,
    (model, data): (&Model, &Dataset),
    predicted: &[(Quantity, &Predictions)],
) -> io::Result<()> {
    let all = model.channels();
    let channels: Vec<usize> = (0..all.len()).filter(|&c| all[c].active).collect();
    let names: Vec<String> = channels.iter().map(|&c| all[c].name.clone()).collect();
    let with_motion = all.iter().all(|c| c.joint.is_some());
    let mut quantities = vec![Quantity::Recorded];
    quantities.extend(predicted.iter().map(|(quantity, _)| *quantity));
    quantities.extend(
        with_motion
            .then_some([Quantity::Velocity, Quantity::Position])
            .into_iter()
            .flatten(),
    );
    let mut writer = PredictionsWriter::new(out, &names, &quantities)?;
    for (k, recording) in data.recordings.iter().enumerate() {
        let rows: Vec<usize> = (0..recording.rows())
            .filter(|&r| recording.counts(r))
            .collect();
        let t: Vec<f64> = rows.iter().map(|&row| recording.time(row)).collect();
        let mut columns: Vec<Cow<'_, [f64]>> = Vec::new();
        for &c in &channels {
            columns.push(pick(recording.signal(c), &rows));
            columns.extend(predicted.iter().map(|(_, p)| pick(&p[k][c], &rows)));
            if let (true, Some(j)) = (with_motion, all[c].joint) {
                let motors = recording.segment().motors;
                columns.push(pick(&motors.dq[j], &rows));
                columns.push(pick(&motors.q[j], &rows));
            }
        }
        let slices: Vec<&[f64]> = columns.iter().map(AsRef::as_ref).collect();
        writer.block(&Block {
            recording: &recording.name,
            split: recording.split,
            t: &t,
            columns: &slices,
        })?;
    }
    Ok(())
}

/// A series at some of its rows.
fn pick<'s>(series: &'s [f64], rows: &[usize]) -> Cow<'s, [f64]> {
    if rows.len() == series.len() {
        Cow::Borrowed(series)
    } else {
        rows.iter().map(|&r| series[r]).collect()
    }
}
