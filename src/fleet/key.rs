//! The key of an item: SHA-256 of everything that its result depends on.
//!
//! Program version, verb, the problem without the names of recordings, and the content of every file that is read, in the
//! order of the problem. Names of files, robot, type and time are no part of it: a recording that is moved is not done again.

use crate::fleet::manifest::Verb;
use crate::outcome::error::OutcomeError;
use crate::outcome::input::Input;
use crate::outcome::provenance::VERSION;
use crate::problem_file::ProblemFile;
use sha2::{Digest, Sha256};
use std::path::PathBuf;

/// Names of recordings in a problem, which the manifest gives.
const NAMES: [&str; 3] = ["train", "validation", "loaded"];

/// Bumped whenever what is kept of an item changes its form.
const FORM: &str = "exid item 1";

/// The key as 64 hexadecimal digits.
///
/// # Errors
/// `not-readable` of a file that cannot be read.
pub fn of(problem: &ProblemFile, verb: Verb, files: &[PathBuf]) -> Result<String, OutcomeError> {
    let mut stated = problem.json.clone();
    if let Some(recordings) = stated.get_mut("recordings").and_then(|r| r.as_object_mut()) {
        NAMES.iter().for_each(|name| {
            recordings.shift_remove(*name);
        });
    }
    let mut parts = vec![
        FORM.to_string(),
        verb.as_str().to_string(),
        stated.to_string(),
    ];
    for file in files {
        parts.push(Input::of(file)?.sha256);
    }
    Ok(of_parts(&parts))
}

/// The key of what depends on texts and on the program alone.
pub fn of_parts(parts: &[String]) -> String {
    let mut hash = Sha256::new();
    let program = [VERSION, env!("EXID_REVISION")];
    for text in program.into_iter().chain(parts.iter().map(String::as_str)) {
        // The length before each part: no two lists of parts are one text.
        hash.update((text.len() as u64).to_le_bytes());
        hash.update(text);
    }
    let digest = hash.finalize();
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}
