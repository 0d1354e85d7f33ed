//! What killed runs leave beside a target: partial folders, or a result set aside.

use std::fs::File;
use std::path::Path;

use crate::outcome::folder::target::Target;

/// Locks a folder until the handle is dropped; waits for whoever holds it. Absent where the file
/// system has no locks: the run then goes on without.
pub(super) fn wait_for_lock(folder: &Path) -> Option<File> {
    let handle = File::open(folder).ok()?;
    handle.lock().ok()?;
    Some(handle)
}

/// Removes partial folders that no process holds, and finishes or undoes a swap that was cut
/// short. Whatever resists stays: it harms nothing.
pub(super) fn clear(target: &Target) {
    recover_previous(target);
    let Ok(entries) = std::fs::read_dir(&target.parent) else {
        return;
    };
    for entry in entries.flatten() {
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        if is_folder && target.owns_partial(&entry.file_name()) && is_abandoned(&entry.path()) {
            let _ = std::fs::remove_dir_all(entry.path());
        }
    }
}

/// A result that was set aside goes back if its place is empty, and away if its successor stands.
fn recover_previous(target: &Target) {
    let previous = target.previous();
    if !previous.is_dir() {
        return;
    }
    let _ = if target.path.exists() {
        std::fs::remove_dir_all(&previous)
    } else {
        std::fs::rename(&previous, &target.path)
    };
}

fn is_abandoned(folder: &Path) -> bool {
    File::open(folder).is_ok_and(|handle| handle.try_lock().is_ok())
}
