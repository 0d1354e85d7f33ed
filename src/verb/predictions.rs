//! What a model predicts along its recordings, as a table and as `predictions.csv`.

use crate::chain::dataset::Dataset;
use crate::chain::model::Model;
use crate::estimate::goodness_of_fit::Predictions;
use crate::outcome::PREDICTIONS_FILE;
use crate::outcome::folder::ResultFolder;
use crate::outcome::predictions::{
    Block, Column, Predictions as Table, PredictionsWriter, Quantity, RecordingPredictions,
};
use crate::verb::error::VerbError;
use std::borrow::Cow;
use std::io;

/// What a model gives along its recordings.
pub(super) struct Predicted<'a> {
    pub model: &'a Model,
    pub data: &'a Dataset,
    pub series: &'a [(Quantity, &'a Predictions)],
}

/// Motion of a joint; of those with a motor, acceleration is left to the reader.
const MOTION: [Quantity; 3] = [
    Quantity::Velocity,
    Quantity::Position,
    Quantity::Acceleration,
];

/// Channels of the signal and what is told of each: the recorded signal, what each series gives, speed and position of the joints;
/// then the motion of joints that closed loops move.
struct Columns {
    channels: Vec<usize>,
    passive: Vec<usize>,
    header: Vec<Column>,
    with_motion: bool,
}

impl Predicted<'_> {
    fn columns(&self) -> Columns {
        let all = self.model.channels();
        let channels: Vec<usize> = (0..all.len()).filter(|&c| all[c].active).collect();
        let with_motion = all.iter().all(|c| c.joint.is_some());
        let mut quantities = vec![Quantity::Recorded];
        quantities.extend(self.series.iter().map(|(quantity, _)| *quantity));
        let mut passive: Vec<usize> = Vec::new();
        if with_motion {
            quantities.extend(&MOTION[..2]);
            passive.extend(self.model.mechanism().map_or(&[][..], |m| m.passive()));
        }
        let of = |joint: &str, quantities: &[Quantity]| -> Vec<Column> {
            let column = |&quantity: &Quantity| Column {
                joint: joint.to_owned(),
                quantity,
            };
            quantities.iter().map(column).collect()
        };
        let own = channels.iter().flat_map(|&c| of(&all[c].name, &quantities));
        let joints = self.model.tree().joints();
        let moved = passive.iter().flat_map(|&j| of(&joints[j].name, &MOTION));
        Columns {
            header: own.chain(moved).collect(),
            channels,
            passive,
            with_motion,
        }
    }

    /// Hands over the rows of one recording after the other.
    fn blocks(
        &self,
        columns: &Columns,
        mut each: impl FnMut(&Block<'_>) -> io::Result<()>,
    ) -> io::Result<()> {
        let all = self.model.channels();
        for (k, recording) in self.data.recordings.iter().enumerate() {
            let rows: Vec<usize> = (0..recording.rows())
                .filter(|&r| recording.counts(r))
                .collect();
            let t: Vec<f64> = rows.iter().map(|&row| recording.time(row)).collect();
            let mut series: Vec<Cow<'_, [f64]>> = Vec::new();
            let motors = recording.segment().motors;
            for &c in &columns.channels {
                series.push(pick(recording.signal(c), &rows));
                series.extend(self.series.iter().map(|(_, p)| pick(&p[k][c], &rows)));
                if let (true, Some(j)) = (columns.with_motion, all[c].joint) {
                    series.push(pick(&motors.dq[j], &rows));
                    series.push(pick(&motors.q[j], &rows));
                }
            }
            for &j in &columns.passive {
                series.extend([&motors.dq, &motors.q, &motors.ddq].map(|all| pick(&all[j], &rows)));
            }
            let slices: Vec<&[f64]> = series.iter().map(AsRef::as_ref).collect();
            each(&Block {
                recording: &recording.name,
                split: recording.split,
                t: &t,
                columns: &slices,
            })?;
        }
        Ok(())
    }

    /// Writes the table.
    pub fn write(&self, folder: &ResultFolder) -> Result<(), VerbError> {
        folder.write(PREDICTIONS_FILE, |out| {
            let columns = self.columns();
            let mut writer = PredictionsWriter::new(out, &columns.header)?;
            self.blocks(&columns, |block| writer.block(block))
        })?;
        Ok(())
    }

    /// The table itself, with all digits.
    pub fn table(&self) -> Table {
        let columns = self.columns();
        let mut table = Table {
            columns: columns.header.clone(),
            recordings: Vec::new(),
        };
        // Collecting in memory does not fail.
        let _ = self.blocks(&columns, |block| {
            table.recordings.push(RecordingPredictions::of(block));
            Ok(())
        });
        table
    }
}

/// A series at some of its rows.
fn pick<'s>(series: &'s [f64], rows: &[usize]) -> Cow<'s, [f64]> {
    if rows.len() == series.len() {
        Cow::Borrowed(series)
    } else {
        rows.iter().map(|&r| series[r]).collect()
    }
}
