//! Puts a finished folder in its place in one step, whatever stood there before.

use std::io;
use std::path::Path;

use crate::outcome::folder::target::Target;

/// Renames `partial` to the target. An earlier result then stands at `partial`, for removal.
pub(super) fn put_in_place(partial: &Path, target: &Target) -> io::Result<()> {
    // A plain rename replaces nothing and an empty folder; it refuses a folder with content.
    match std::fs::rename(partial, &target.path) {
        Err(error)
            if matches!(
                error.kind(),
                io::ErrorKind::DirectoryNotEmpty | io::ErrorKind::AlreadyExists
            ) =>
        {
            match exchange(partial, &target.path) {
                Err(error) if cannot_exchange(&error) => set_aside(partial, target),
                other => other,
            }
        }
        other => other,
    }
}

/// Exchanges two folders in one step.
#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
fn exchange(one: &Path, other: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE)?)
}

#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
fn exchange(_: &Path, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// Whether the system or the file system lacks the exchange, rather than refusing this one.
fn cannot_exchange(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::Unsupported | io::ErrorKind::InvalidInput
    )
}

/// Two renames: between them the target is absent, and a killed run is put right by the next.
pub(super) fn set_aside(partial: &Path, target: &Target) -> io::Result<()> {
    let previous = target.previous();
    std::fs::rename(&target.path, &previous)?;
    if let Err(error) = std::fs::rename(partial, &target.path) {
        std::fs::rename(&previous, &target.path)?;
        return Err(error);
    }
    // What cannot be removed now is removed by the next run.
    let _ = std::fs::remove_dir_all(&previous);
    Ok(())
}
