//! What a model predicts along its recordings, as a table and as `predictions.csv`.

use crate::chain::dataset::Dataset;
use crate::chain::model::Model;
use crate::estimate::goodness_of_fit::Predictions;
use crate::outcome::PREDICTIONS_FILE;
use crate::outcome::folder::ResultFolder;
use crate::outcome::predictions::{
    Block, Predictions as Table, PredictionsWriter, Quantity, RecordingPredictions,
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

/// Channels of the signal and what is told of each: the recorded signal, what each series gives, speed and position of the joints.
struct Columns {
    channels: Vec<usize>,
    names: Vec<String>,
    quantities: Vec<Quantity>,
    with_motion: bool,
}

impl Predicted<'_> {
    fn columns(&self) -> Columns {
        let all = self.model.channels();
        let channels: Vec<usize> = (0..all.len()).filter(|&c| all[c].active).collect();
        let with_motion = all.iter().all(|c| c.joint.is_some());
        let mut quantities = vec![Quantity::Recorded];
        quantities.extend(self.series.iter().map(|(quantity, _)| *quantity));
        if with_motion {
            quantities.extend([Quantity::Velocity, Quantity::Position]);
        }
        Columns {
            names: channels.iter().map(|&c| all[c].name.clone()).collect(),
            channels,
            quantities,
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
            for &c in &columns.channels {
                series.push(pick(recording.signal(c), &rows));
                series.extend(self.series.iter().map(|(_, p)| pick(&p[k][c], &rows)));
                if let (true, Some(j)) = (columns.with_motion, all[c].joint) {
                    let motors = recording.segment().motors;
                    series.push(pick(&motors.dq[j], &rows));
                    series.push(pick(&motors.q[j], &rows));
                }
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
            let mut writer = PredictionsWriter::new(out, &columns.names, &columns.quantities)?;
            self.blocks(&columns, |block| writer.block(block))
        })?;
        Ok(())
    }

    /// The table itself, with all digits.
    pub fn table(&self) -> Table {
        let columns = self.columns();
        let named = columns.names.iter().flat_map(|name| {
            let quantities = columns.quantities.iter();
            quantities.map(move |quantity| (name.clone(), *quantity))
        });
        let mut table = Table {
            columns: named.collect(),
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
