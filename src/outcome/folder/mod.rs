//! The results folder: written beside its place, then put there in one step.
//!
//! Everything goes into a partial folder next to the target, reaches the disk, and is exchanged
//! with the target in one rename, so that an earlier result is replaced whole or not at all; what
//! users have added to it stays. What
//! a killed run leaves behind is removed by the next run to the same target: a partial folder is
//! locked by its run, and the lock goes with the process.

mod keep;
mod leftovers;
mod swap;
mod target;

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::outcome::error::{Action, OutcomeError};
use crate::outcome::folder::target::Target;

/// Bytes gathered before they are written: long tables go out in few calls.
const BUFFER_BYTES: usize = 256 * 1024;

/// A results folder on its way to its place. Dropped without [`commit`](Self::commit), it leaves
/// everything as it was.
#[derive(Debug)]
pub struct ResultFolder {
    target: Target,
    partial: PathBuf,
    /// Held for the life of the run: tells the partial folder from a leftover.
    _lock: Option<File>,
    created_parents: Vec<PathBuf>,
    committed: bool,
}

impl ResultFolder {
    /// Prepares to write the results folder `path`, which may be absent, empty, or an earlier
    /// result; nothing is changed there yet. Missing parents are created.
    ///
    /// # Errors
    /// `out-is-a-file`, `out-is-not-a-result` (not empty and no earlier result: never deleted),
    /// `out-is-the-working-folder`, `out-not-permitted`, `out-not-written`.
    pub fn prepare(path: &Path) -> Result<Self, OutcomeError> {
        let target = Target::resolve(path)?;
        let created_parents = create_parents(&target)?;
        let made = prepare_partial(&target);
        let (partial, lock) = made.inspect_err(|_| remove_empty(&created_parents))?;
        Ok(Self {
            target,
            partial,
            _lock: lock,
            created_parents,
            committed: false,
        })
    }

    /// The folder as it fills: where the files written so far can be read back.
    pub fn path(&self) -> &Path {
        &self.partial
    }

    /// Writes one file of the folder through `fill` and brings it to the disk.
    ///
    /// # Errors
    /// `out-not-written` or `out-not-permitted` with the system's reason.
    pub fn write(
        &self,
        name: &str,
        fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<(), OutcomeError> {
        let path = self.partial.join(name);
        let written = File::create(&path).and_then(|file| {
            let mut out = BufWriter::with_capacity(BUFFER_BYTES, file);
            fill(&mut out)?;
            out.into_inner()
                .map_err(io::IntoInnerError::into_error)?
                .sync_all()
        });
        written.map_err(|error| {
            OutcomeError::io(&self.target.given.join(name), Action::WriteFile, &error)
        })
    }

    /// Puts the folder in its place in one step and removes the result that was there, but for what users have added.
    ///
    /// # Errors
    /// As [`prepare`](Self::prepare); the earlier result then stands as it was.
    pub fn commit(mut self) -> Result<(), OutcomeError> {
        self.target.inspect()?;
        let replaced = keep::carry_over(&self.target.path, &self.partial)
            .and_then(|()| sync_folder(&self.partial))
            .and_then(|()| swap::put_in_place(&self.partial, &self.target))
            .and_then(|()| sync_folder(&self.target.parent));
        replaced
            .map_err(|error| OutcomeError::io(&self.target.given, Action::ReplaceFolder, &error))?;
        self.committed = true;
        Ok(())
    }
}

impl Drop for ResultFolder {
    fn drop(&mut self) {
        // After a swap this is the earlier result; without one it is the unfinished folder. What
        // cannot be removed now is a leftover of the next run.
        let _ = std::fs::remove_dir_all(&self.partial);
        if !self.committed {
            remove_empty(&self.created_parents);
        }
    }
}

/// Creates the missing parents of the target and returns them, the deepest first.
fn create_parents(target: &Target) -> Result<Vec<PathBuf>, OutcomeError> {
    let missing: Vec<PathBuf> = target
        .parent
        .ancestors()
        .take_while(|folder| !folder.exists())
        .map(Path::to_path_buf)
        .collect();
    std::fs::create_dir_all(&target.parent).map_err(|error| {
        remove_empty(&missing);
        target.failed(Action::CreateFolder, &error)
    })?;
    Ok(missing)
}

/// Removes folders as far as they are empty: what other runs have put there stays.
fn remove_empty(folders: &[PathBuf]) {
    for folder in folders {
        let _ = std::fs::remove_dir(folder);
    }
}

/// Clears leftovers, looks at the target, and creates the locked partial folder.
fn prepare_partial(target: &Target) -> Result<(PathBuf, Option<File>), OutcomeError> {
    // One run at a time from clearing to locking, or a new folder could pass for a leftover.
    let _turn = leftovers::wait_for_lock(&target.parent);
    leftovers::clear(target);
    target.inspect()?;
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let partial = target.partial(std::process::id(), number);
    std::fs::create_dir(&partial).map_err(|error| target.failed(Action::CreateFolder, &error))?;
    let lock = leftovers::wait_for_lock(&partial);
    Ok((partial, lock))
}

/// Brings the entries of a folder to the disk, where the file system can do so.
fn sync_folder(folder: &Path) -> io::Result<()> {
    match File::open(folder).and_then(|handle| handle.sync_all()) {
        Err(error)
            if matches!(
                error.kind(),
                io::ErrorKind::InvalidInput
                    | io::ErrorKind::Unsupported
                    | io::ErrorKind::PermissionDenied
            ) =>
        {
            Ok(())
        }
        other => other,
    }
}

#[cfg(test)]
mod tests;
