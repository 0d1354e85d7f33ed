//! The program, as a user starts it.

use std::path::Path;
use std::process::{Command, Output};

/// Runs a command in a folder.
pub fn exid(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_exid"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

/// What a command prints, which ends with a code.
pub fn says(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = exid(folder, arguments);
    let [out, err] = [output.stdout, output.stderr].map(|b| String::from_utf8(b).unwrap());
    assert_eq!(
        output.status.code(),
        Some(code),
        "{arguments:?}\n{out}{err}"
    );
    out + &err
}
