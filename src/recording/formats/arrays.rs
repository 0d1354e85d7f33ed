//! Named arrays as one table. A vector `t` is the column `t`; a matrix `q` gives the columns `q1`,
//! `q2`, ..., so that `q{n}` names the column of joint n. Samples lie along the longer side.

use std::borrow::Cow;
use std::path::Path;

use crate::fault::Place;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::table::{Table, require_rows};

/// Most channels of one array: as many joints no robot has, and the names of all are kept in memory.
const MOST_CHANNELS: usize = 10_000;

/// Name and arrangement of an array that can hold channels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::recording) struct Layout {
    pub name: String,
    samples: usize,
    /// Channels of a matrix; None for a vector.
    channels: Option<usize>,
    /// Distance in the file from one sample of a channel to its next, and from one channel to the next.
    sample_stride: usize,
    channel_stride: usize,
}

/// Which side of an array varies fastest in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::recording) enum Storage {
    RowMajor,
    ColumnMajor,
}

impl Layout {
    /// The layout of an array of these dimensions, sides of length 1 left out; None where it is a
    /// scalar, empty, or still has three sides or more: such an array holds no channels.
    pub fn new(name: &str, dimensions: &[usize], storage: Storage) -> Option<Self> {
        let sides: Vec<usize> = dimensions.iter().copied().filter(|&d| d != 1).collect();
        let (samples, channels, along_first) = match sides[..] {
            [samples] => (samples, None, true),
            [first, second] if first >= second => (first, Some(second), true),
            [first, second] => (second, Some(first), false),
            _ => return None,
        };
        if samples == 0 || channels.is_some_and(|c| c == 0 || c > MOST_CHANNELS) {
            return None;
        }
        let contiguous = channels.is_none() || along_first == (storage == Storage::ColumnMajor);
        let (sample_stride, channel_stride) = match contiguous {
            true => (1, samples),
            false => (channels.unwrap_or(1), 1),
        };
        Some(Self {
            name: name.into(),
            samples,
            channels,
            sample_stride,
            channel_stride,
        })
    }

    /// Names of its columns.
    fn columns(&self) -> Vec<String> {
        match self.channels {
            None => vec![self.name.clone()],
            Some(channels) => (1..=channels)
                .map(|n| format!("{}{n}", self.name))
                .collect(),
        }
    }

    /// The channel, from 0, whose column has this name.
    fn channel(&self, column: &str) -> Option<usize> {
        let rest = column.strip_prefix(self.name.as_str())?;
        match self.channels {
            None => rest.is_empty().then_some(0),
            Some(channels) => {
                let number: usize = rest.parse().ok()?;
                // The spelling has to be the one of the column: `q1`, not `q01`.
                let named = (1..=channels).contains(&number) && rest == number.to_string();
                named.then(|| number - 1)
            }
        }
    }

    fn take(&self, values: &[f64], channel: usize) -> Vec<f64> {
        let at = values.iter().skip(channel * self.channel_stride);
        at.step_by(self.sample_stride)
            .take(self.samples)
            .copied()
            .collect()
    }
}

/// Names of all columns.
pub(in crate::recording) fn column_names(layouts: &[Layout]) -> Vec<String> {
    layouts.iter().flat_map(Layout::columns).collect()
}

/// The wanted columns; `load` gives all numbers of an array, by its index, as they lie in the file.
///
/// Errors: two columns of one name, columns of unequal length, too few rows, and those of `load`.
pub(in crate::recording) fn assemble<'v>(
    path: &Path,
    layouts: &[Layout],
    wanted: &[String],
    mut load: impl FnMut(usize) -> Result<Cow<'v, [f64]>, RecordingError>,
) -> Result<Table, RecordingError> {
    let sources: Vec<(usize, usize)> = wanted
        .iter()
        .map(|name| locate(path, layouts, name))
        .collect::<Result<_, _>>()?;
    require_equal_lengths(path, layouts, wanted, &sources)?;
    require_rows(path, sources.first().map_or(0, |s| layouts[s.0].samples))?;
    let mut data = vec![Vec::new(); wanted.len()];
    for array in 0..layouts.len() {
        let slots: Vec<usize> = (0..wanted.len())
            .filter(|&slot| sources[slot].0 == array)
            .collect();
        if slots.is_empty() {
            continue;
        }
        let values = load(array)?;
        for slot in slots {
            data[slot] = layouts[array].take(&values, sources[slot].1);
        }
    }
    Ok(Table {
        columns: wanted.to_vec(),
        data,
        first_line: 1,
        lines: None,
        origins: Vec::new(),
    })
}

/// Array and channel of a column; the callers ask for columns that exist.
fn locate(path: &Path, layouts: &[Layout], column: &str) -> Result<(usize, usize), RecordingError> {
    let named = layouts.iter().enumerate();
    let mut found = named.filter_map(|(at, layout)| Some((at, layout.channel(column)?)));
    let fault = |kind| RecordingError::new(Place::file(path).key(column), kind);
    let Some(first) = found.next() else {
        let kind = RecordingErrorKind::Corrupt {
            format: "array file",
            reason: format!("the array of column {column:?} is gone").into(),
        };
        return Err(fault(kind));
    };
    match found.next() {
        None => Ok(first),
        Some(_) => Err(fault(RecordingErrorKind::DuplicateColumn {
            name: column.into(),
        })),
    }
}

fn require_equal_lengths(
    path: &Path,
    layouts: &[Layout],
    wanted: &[String],
    sources: &[(usize, usize)],
) -> Result<(), RecordingError> {
    let lengths = sources.iter().map(|s| layouts[s.0].samples);
    let named: Vec<(&String, usize)> = wanted.iter().zip(lengths).collect();
    let Some(&(first, expected)) = named.first() else {
        return Ok(());
    };
    match named.iter().find(|(_, length)| *length != expected) {
        None => Ok(()),
        Some((name, found)) => Err(RecordingError::new(
            Place::file(path).key(name.as_str()),
            RecordingErrorKind::UnequalLengths {
                found: *found,
                other: first.clone().into(),
                expected,
            },
        )),
    }
}
