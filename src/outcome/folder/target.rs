//! The place of a results folder: where it is, and whether what is there may be replaced.

use std::ffi::{OsStr, OsString};
use std::io;
use std::path::{Path, PathBuf};

use crate::outcome::RESULT_FILE;
use crate::outcome::error::{Action, OutcomeError, OutcomeErrorKind};

/// Keys that every result has, by which a folder is known to be one.
const MARKS: [&str; 3] = ["name", "verb", "version"];

/// The place of a results folder.
#[derive(Debug)]
pub(super) struct Target {
    /// As the user wrote it, for messages.
    pub given: PathBuf,
    /// Absolute, behind any symbolic link.
    pub path: PathBuf,
    pub parent: PathBuf,
    name: OsString,
}

impl Target {
    pub fn resolve(given: &Path) -> Result<Self, OutcomeError> {
        // A link is followed, so that the folder behind it is replaced and the link stays.
        let path = match std::fs::canonicalize(given) {
            Ok(path) => path,
            Err(_) => std::path::absolute(given)
                .map_err(|error| OutcomeError::io(given, Action::InspectFolder, &error))?,
        };
        let (Some(parent), Some(name)) = (path.parent(), path.file_name()) else {
            let error = io::Error::other("the path does not end in the name of a folder");
            return Err(OutcomeError::io(given, Action::CreateFolder, &error));
        };
        Ok(Self {
            given: given.to_path_buf(),
            parent: parent.to_path_buf(),
            name: name.to_os_string(),
            path,
        })
    }

    /// Refuses a target that is neither absent, nor empty, nor an earlier result.
    pub fn inspect(&self) -> Result<(), OutcomeError> {
        let refuse = |kind| Err(OutcomeError::new(&self.given, kind));
        match std::fs::symlink_metadata(&self.path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            Err(error) => return Err(self.failed(Action::InspectFolder, &error)),
            Ok(found) if !found.is_dir() => return refuse(OutcomeErrorKind::FileInTheWay),
            Ok(_) => {}
        }
        if let Some(working) = self.working_folder_inside() {
            return refuse(OutcomeErrorKind::WorkingFolder { working });
        }
        let first = std::fs::read_dir(&self.path)
            .and_then(|mut entries| entries.next().transpose())
            .map_err(|error| self.failed(Action::InspectFolder, &error))?;
        match first {
            Some(entry) if !is_result(&self.path) => refuse(OutcomeErrorKind::ForeignFolder {
                found: entry.file_name().display().to_string(),
            }),
            _ => Ok(()),
        }
    }

    /// The working directory, if it is the target or lies in it: a replaced folder would leave
    /// the user's shell in a folder that no longer exists.
    fn working_folder_inside(&self) -> Option<PathBuf> {
        let working = std::env::current_dir()
            .and_then(std::fs::canonicalize)
            .ok()?;
        working.starts_with(&self.path).then_some(working)
    }

    pub fn failed(&self, action: Action, error: &io::Error) -> OutcomeError {
        OutcomeError::io(&self.given, action, error)
    }

    /// Name of a partial folder beside the target, of the process and the folder's number in it.
    pub fn partial(&self, process: u32, number: u64) -> PathBuf {
        let mut name = self.partial_prefix();
        name.push(format!("{process}-{number}"));
        self.parent.join(name)
    }

    /// Whether `name` is that of a partial folder of this target.
    pub fn owns_partial(&self, name: &OsStr) -> bool {
        name.as_encoded_bytes()
            .strip_prefix(self.partial_prefix().as_encoded_bytes())
            .is_some_and(|rest| {
                !rest.is_empty() && rest.iter().all(|c| c.is_ascii_digit() || *c == b'-')
            })
    }

    /// Where the earlier result waits on a file system that cannot exchange two folders.
    pub fn previous(&self) -> PathBuf {
        let mut name = self.hidden_name();
        name.push(".previous");
        self.parent.join(name)
    }

    fn partial_prefix(&self) -> OsString {
        let mut name = self.hidden_name();
        name.push(".partial-");
        name
    }

    fn hidden_name(&self) -> OsString {
        let mut name = OsString::from(".");
        name.push(&self.name);
        name
    }
}

/// Whether the folder holds the result of a run.
fn is_result(folder: &Path) -> bool {
    std::fs::read(folder.join(RESULT_FILE))
        .ok()
        .and_then(|text| serde_json::from_slice::<serde_json::Value>(&text).ok())
        .is_some_and(|value| MARKS.iter().all(|mark| value[*mark].is_string()))
}
