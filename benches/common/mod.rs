//! The program as a user calls it, on a seven-joint arm in a folder of its own.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// A folder with the arm, `panda_like.mdh.toml`.
pub fn folder_with_arm() -> TempDir {
    let folder = TempDir::new().expect("a folder for the recordings");
    let robot =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/panda_like/panda_like.mdh.toml");
    fs::copy(robot, folder.path().join("panda_like.mdh.toml")).expect("the robot is copied");
    folder
}

/// Runs the program to its end.
pub fn exid(folder: &Path, arguments: &[&str]) {
    let status = Command::new(env!("CARGO_BIN_EXE_exid"))
        .current_dir(folder)
        .args(arguments)
        .arg("--quiet")
        .stdout(Stdio::null())
        .status()
        .expect("the program starts");
    assert!(status.success(), "{arguments:?}");
}
