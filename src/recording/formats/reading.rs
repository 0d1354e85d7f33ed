//! Limits on reading a file: rows and bytes at most, and an interrupt.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result as IoResult};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::fault::Place;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::memory::ArraysInMemory;

/// Rows of a file: 14 hours at 200 Hz, or nearly three at 1 kHz.
pub const MOST_ROWS: usize = 10_000_000;

/// Bytes of a file, unpacked: 400 for each of so many rows.
pub const MOST_BYTES: u64 = 4 << 30;

/// How files are read.
#[derive(Debug, Clone)]
pub struct Reading {
    /// Rows of one file.
    pub most_rows: usize,
    /// Bytes of one file after decompression.
    pub most_bytes: u64,
    /// Reading ends when this is set.
    pub interrupt: Option<Arc<AtomicBool>>,
    /// What stands in the place of files.
    pub memory: ArraysInMemory,
}

impl Default for Reading {
    fn default() -> Self {
        Self {
            most_rows: MOST_ROWS,
            most_bytes: MOST_BYTES,
            interrupt: None,
            memory: ArraysInMemory::default(),
        }
    }
}

impl Reading {
    /// Whether somebody has asked for the end, from whichever thread.
    pub fn is_interrupted(&self) -> bool {
        let flag = self.interrupt.as_ref();
        flag.is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// Errors: an interrupt.
    pub(super) fn goes_on(&self, path: &Path) -> Result<(), RecordingError> {
        match self.is_interrupted() {
            true => Err(Stop::Interrupted.at(Place::file(path))),
            false => Ok(()),
        }
    }

    /// Errors: an interrupt, more rows than the limit.
    pub(super) fn takes_rows(&self, path: &Path, rows: usize) -> Result<(), RecordingError> {
        self.goes_on(path)?;
        match rows > self.most_rows {
            true => Err(Stop::Rows(self.most_rows).at(Place::file(path))),
            false => Ok(()),
        }
    }

    /// The limit of bytes as a size in memory.
    pub(in crate::recording) fn most_bytes(&self) -> usize {
        usize::try_from(self.most_bytes).unwrap_or(usize::MAX)
    }

    /// The bytes of a file. Errors: those of the system, an interrupt, more than the limit.
    pub(super) fn whole_file(&self, path: &Path) -> Result<Vec<u8>, RecordingError> {
        let place = || Place::file(path);
        let file = File::open(path).map_err(|error| from_io(place(), &error))?;
        let mut bytes = Vec::new();
        let read = self.metered(file).read_to_end(&mut bytes);
        read.map_err(|error| from_io(place(), &error))?;
        Ok(bytes)
    }

    /// A source that ends with an error at an interrupt, and beyond the limit of bytes.
    pub(super) fn metered<R: Read>(&self, source: R) -> Metered<R> {
        Metered {
            source,
            left: self.most_bytes,
            reading: self.clone(),
        }
    }
}

/// The error of a reader that was interrupted.
pub(in crate::recording) fn interrupted(path: &Path) -> RecordingError {
    Stop::Interrupted.at(Place::file(path))
}

/// Why reading stopped, as the error of a source.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub(super) enum Stop {
    #[error("interrupted")]
    Interrupted,
    #[error("more than {0} rows")]
    Rows(usize),
    #[error("more than {0} bytes")]
    Bytes(u64),
}

impl Stop {
    /// The stop that an error of a source carries.
    pub fn of(error: &Error) -> Option<Self> {
        error.get_ref()?.downcast_ref().copied()
    }

    pub fn at(self, place: Place) -> RecordingError {
        let kind = match self {
            Self::Interrupted => RecordingErrorKind::Interrupted,
            Self::Rows(most) => RecordingErrorKind::TooManyRows { most },
            Self::Bytes(most) => RecordingErrorKind::TooManyBytes { most },
        };
        RecordingError::new(place, kind)
    }
}

/// A source with a limit and an interrupt.
pub(super) struct Metered<R> {
    source: R,
    left: u64,
    reading: Reading,
}

impl<R: Read> Read for Metered<R> {
    fn read(&mut self, buffer: &mut [u8]) -> IoResult<usize> {
        if self.reading.is_interrupted() {
            return Err(Error::other(Stop::Interrupted));
        }
        let count = self.source.read(buffer)?;
        match self.left.checked_sub(count as u64) {
            Some(left) => self.left = left,
            None => return Err(Error::other(Stop::Bytes(self.reading.most_bytes))),
        }
        Ok(count)
    }
}

/// The recording error of an error of the operating system.
pub(super) fn from_io(place: Place, error: &std::io::Error) -> RecordingError {
    if let Some(stop) = Stop::of(error) {
        return stop.at(place);
    }
    let kind = match error.kind() {
        ErrorKind::NotFound => RecordingErrorKind::NotFound,
        ErrorKind::PermissionDenied => RecordingErrorKind::NoPermission,
        ErrorKind::IsADirectory => RecordingErrorKind::IsDirectory,
        _ => RecordingErrorKind::Unreadable {
            reason: error.to_string(),
        },
    };
    RecordingError::new(place, kind)
}
