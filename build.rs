//! States which sources the program is built from, as the environment variable `EXID_REVISION` of the compiler.
//!
//! It runs again when the sources change and at no other time, so that it costs no build of its own: the revision is the
//! last commit that touched the sources, and says so where they were changed since.

use std::fs;
use std::path::Path;
use std::process::Command;

/// What the program is made of.
const SOURCES: [&str; 4] = ["src", "build.rs", "Cargo.toml", "Cargo.lock"];

fn main() {
    for source in SOURCES {
        println!("cargo::rerun-if-changed={source}");
    }
    let revision = packaged().or_else(committed).unwrap_or_default();
    println!("cargo::rustc-env=EXID_REVISION={revision}");
    let features = std::env::vars().filter_map(|(name, _)| {
        let feature = name.strip_prefix("CARGO_FEATURE_")?;
        Some(feature.to_lowercase())
    });
    let mut features: Vec<String> = features.collect();
    features.sort();
    println!("cargo::rustc-env=EXID_FEATURES={}", features.join(","));
}

/// The commit that cargo wrote into a package.
fn packaged() -> Option<String> {
    let text = fs::read_to_string(".cargo_vcs_info.json").ok()?;
    let (_, rest) = text.split_once("\"sha1\": \"")?;
    let (commit, _) = rest.split_once('"')?;
    let is_changed = text.contains("\"dirty\": true");
    Some(in_words(commit, is_changed))
}

/// The last commit that touched the sources, where they are in a repository.
fn committed() -> Option<String> {
    let commit = git(&["log", "-1", "--format=%H"])?;
    let is_changed = !git(&["status", "--porcelain"])?.is_empty();
    (!commit.is_empty()).then(|| in_words(&commit, is_changed))
}

fn git(arguments: &[&str]) -> Option<String> {
    let sources = SOURCES.iter().filter(|source| Path::new(source).exists());
    let mut command = Command::new("git");
    command.args(arguments).arg("--").args(sources);
    let output = command.output().ok().filter(|o| o.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}

fn in_words(commit: &str, is_changed: bool) -> String {
    match is_changed {
        true => format!("{commit} with changes"),
        false => commit.to_owned(),
    }
}
