//! Files of users in a results folder: what no run has written survives the next run.

use std::fs;
use std::io;
use std::path::Path;

use crate::outcome::{FORMULAS_FILE, NEXT_FILE, PREDICTIONS_FILE, REPORT_FILE, RESULT_FILE};

/// Files that a run may write beside those that its result lists.
const OWN: [&str; 5] = [
    RESULT_FILE,
    PREDICTIONS_FILE,
    REPORT_FILE,
    NEXT_FILE,
    FORMULAS_FILE,
];

/// Ending of a user's file of which the new result has the name.
const ASIDE: &str = ".kept";

/// Puts what users have added to an earlier result into the folder that is to replace it: as links to the same content,
/// so that the earlier folder stays whole until it is replaced.
pub(super) fn carry_over(earlier: &Path, new: &Path) -> io::Result<()> {
    let entries = match fs::read_dir(earlier) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        entries => entries?,
    };
    let listed = listed(&earlier.join(RESULT_FILE));
    for entry in entries {
        let entry = entry?;
        let name = entry.file_name();
        let is_own = |own: &str| name.to_str() == Some(own);
        if OWN.into_iter().any(is_own) || listed.iter().any(|file| is_own(file)) {
            continue;
        }
        let mut place = new.join(&name);
        while place.symlink_metadata().is_ok() {
            place.as_mut_os_string().push(ASIDE);
        }
        link(&entry.path(), &place)?;
    }
    Ok(())
}

/// The files that a result lists.
fn listed(result: &Path) -> Vec<String> {
    let text = fs::read(result).unwrap_or_default();
    let result: serde_json::Value = serde_json::from_slice(&text).unwrap_or_default();
    let files = result["files"].as_array();
    let names = files.into_iter().flatten().filter_map(|file| file.as_str());
    names.map(str::to_string).collect()
}

/// A second name of a file, a copy where the file system has no such names, and the same of all in a folder.
fn link(from: &Path, to: &Path) -> io::Result<()> {
    let kind = from.symlink_metadata()?.file_type();
    if kind.is_dir() {
        fs::create_dir(to)?;
        for entry in fs::read_dir(from)? {
            let entry = entry?;
            link(&entry.path(), &to.join(entry.file_name()))?;
        }
        return Ok(());
    }
    fs::hard_link(from, to).or_else(|_| fs::copy(from, to).map(|_| ()))
}
