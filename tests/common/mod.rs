//! What the tests from outside share: recordings that are not shipped, and a record of what was skipped.

#![allow(dead_code, reason = "each file of tests takes what it needs")]

pub mod arm;
pub mod derivatives;
pub mod interrupting;
pub mod program;

use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::thread;

/// Says on standard error that the running test leaves something out, and appends a line to
/// `target/skipped-tests.txt`, so that continuous integration can count them.
pub fn skip(why: &str) {
    let test = thread::current()
        .name()
        .unwrap_or("unnamed test")
        .to_owned();
    let message = format!("skipped: {test}: {why}\n");
    // Not eprintln!: the test runner keeps that to itself while a test passes.
    std::io::stderr().write_all(message.as_bytes()).unwrap();
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let mut record = OpenOptions::new()
        .create(true)
        .append(true)
        .open(target.join("skipped-tests.txt"))
        .unwrap();
    // One write, so that tests that run beside each other do not mix their lines.
    record
        .write_all(format!("{test}: {why}\n").as_bytes())
        .unwrap();
}

/// The folder with `data/` and `trials/`: `EXID_DATA`, or `../shared` beside the repository. `None`,
/// recorded as a skip, where there is none.
pub fn data_dir() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = match std::env::var_os("EXID_DATA") {
        Some(folder) => root.join(folder),
        None => root.join("../shared"),
    };
    if folder.join("data").is_dir() {
        return Some(folder);
    }
    skip(&format!(
        "no recordings in {}; set EXID_DATA to the folder that holds data/ and trials/",
        folder.display()
    ));
    None
}
