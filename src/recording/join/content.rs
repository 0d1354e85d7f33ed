//! What a file has of the columns that were chosen, on a clock of its own.

use crate::fault::Place;
use crate::recording::channels::missing::{CompleteTable, MissingValues, Roles, bridge};
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::format::read_at;
use crate::recording::join::columns::{Chosen, File, Files, Pick};
use crate::stats::robust::median;
use std::path::Path;

/// What was read of one file.
pub(super) struct Content {
    /// s.
    pub(super) stamps: Vec<f64>,
    /// When the stamps begin, ns since 1970, where the file says it.
    pub(super) origin: Option<i64>,
    pub(super) first_line: usize,
    pub(super) lines: Option<Vec<usize>>,
    /// false: the row is left out.
    pub(super) counts: Vec<bool>,
    pub(super) missing: Option<MissingValues>,
    pub(super) columns: Vec<(String, Vec<f64>)>,
}

impl Content {
    /// The chosen columns of one file.
    pub(super) fn read(
        files: &Files<'_>,
        number: usize,
        chosen: &Chosen,
    ) -> Result<Self, RecordingError> {
        let File { source, time, .. } = &files.files[number];
        let of_file = |picks: &[Pick]| -> Vec<String> {
            let own = picks.iter().filter(|pick| pick.file == number);
            own.map(|pick| pick.name.clone()).collect()
        };
        let slow = of_file(chosen.temperature.as_deref().unwrap_or_default());
        let mask = of_file(&chosen.mask);
        let mut wanted = vec![time.clone()];
        for name in chosen.all().into_iter().flat_map(|picks| of_file(picks)) {
            if wanted.contains(&name) {
                let place = Place::file(source.path).key(name.as_str());
                let kind = RecordingErrorKind::ColumnUsedTwice { name };
                return Err(RecordingError::new(place, kind));
            }
            wanted.push(name);
        }
        let table = read_at(source.path, &wanted, files.reading)?;
        let origin = table.origin(time);
        let lines = table.lines.clone();
        let first_line = table.first_line;
        let roles = Roles {
            time: Some(time),
            mask: mask.first().map(String::as_str),
            slow: &slow,
        };
        let CompleteTable {
            mut table,
            valid,
            missing,
        } = bridge(source.path, table, roles)?;
        let mut stamps = table.take(time).unwrap_or_default();
        let unit = source.map.time.as_ref().map_or(1.0, |c| c.factor(1));
        stamps.iter_mut().for_each(|t| *t *= unit);
        let rows = stamps.len();
        let mut counts = valid.unwrap_or_else(|| vec![true; rows]);
        if let Some(masked) = mask.first().and_then(|name| table.take(name)) {
            counts
                .iter_mut()
                .zip(masked)
                .for_each(|(a, b)| *a &= b != 0.0);
        }
        let content = Self {
            stamps,
            origin,
            first_line,
            lines,
            counts,
            missing,
            columns: table.columns.into_iter().zip(table.data).collect(),
        };
        content.require_increasing(source.path)?;
        Ok(content)
    }

    fn require_increasing(&self, path: &Path) -> Result<(), RecordingError> {
        let time = &self.stamps;
        let Some(k) = (1..time.len()).find(|&k| time[k] <= time[k - 1]) else {
            return Ok(());
        };
        let lines = self.lines.as_ref();
        let line = lines.map_or(self.first_line + k, |lines| lines[k]);
        let kind = RecordingErrorKind::TimeNotIncreasing {
            before: time[k - 1],
            found: time[k],
        };
        Err(RecordingError::new(
            Place::file(path).line(line).key("time"),
            kind,
        ))
    }

    /// Rows that are left out are a gap in time.
    pub(super) fn leave_out_rows(&mut self) {
        let counts = std::mem::take(&mut self.counts);
        let keep = |series: &mut Vec<f64>| {
            let mut counts = counts.iter();
            series.retain(|_| counts.next().copied().unwrap_or(true));
        };
        keep(&mut self.stamps);
        self.columns.iter_mut().for_each(|(_, series)| keep(series));
    }

    pub(super) fn step(&self) -> f64 {
        let steps: Vec<f64> = self.stamps.windows(2).map(|t| t[1] - t[0]).collect();
        median(&steps).unwrap_or(0.0)
    }

    pub(super) fn span(&self) -> [f64; 2] {
        let [first, .., last] = self.stamps[..] else {
            return [f64::NAN; 2];
        };
        [first, last]
    }

    pub(super) fn series(&self, name: &str) -> &[f64] {
        let found = self.columns.iter().find(|(column, _)| column == name);
        found.map_or(&[], |(_, series)| series)
    }
}
