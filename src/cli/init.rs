//! `exid init`: a problem file from what the files show.

use crate::cli::args::Drafting;
use crate::cli::error::CliError;
use crate::cli::interrupt;
use crate::cli::messages::complain;
use crate::cli::output::print;
use crate::init::{self, Sources};
use crate::outcome::check::Severity;
use crate::problem::solution::Control;
use crate::report::text;
use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The problem file where none is named.
const FILE: &str = "problem.toml";

/// The name that stands for standard output.
const STANDARD_OUTPUT: &str = "-";

pub fn run(query: &Drafting) -> Result<u8, CliError> {
    let (robots, recordings): (Vec<PathBuf>, Vec<PathBuf>) = query
        .files
        .iter()
        .cloned()
        .partition(|file| is_description(file));
    let robots: Vec<PathBuf> = query
        .urdf
        .iter()
        .chain(&query.mjcf)
        .cloned()
        .chain(robots)
        .collect();
    let robot = match robots.as_slice() {
        [robot] => robot,
        [] => {
            return Err(wrong(
                "no description of the robot is given; name its URDF with --urdf or its MJCF with --mjcf",
            ));
        }
        [first, second, ..] => {
            let (first, second) = (first.display(), second.display());
            return Err(wrong(&format!(
                "both {first} and {second} describe a robot; name one of them"
            )));
        }
    };
    let prints = query.out.as_deref() == Some(Path::new(STANDARD_OUTPUT));
    let target = match (&query.out, prints) {
        (Some(out), false) => out.clone(),
        _ => PathBuf::from(FILE),
    };
    if !prints && !query.force && target.exists() {
        return Err(CliError::WrongUse(format!(
            "{}: exists already; --force replaces it, and --out names another file",
            target.display()
        )));
    }
    let control = Control {
        interrupt: Some(interrupt::flag()),
        ..Control::default()
    };
    let sources = Sources {
        robot: robot.clone(),
        recordings,
        target: target.clone(),
        columns: query.columns.clone(),
        rate: query.rate,
    };
    let draft = init::draft(&sources, &control)?;
    if control.is_interrupted() {
        return Ok(CliError::INTERRUPTED);
    }
    let mut said: Vec<String> = draft
        .assumed
        .iter()
        .map(|sentence| format!("assumed: {sentence}"))
        .collect();
    let weighty = draft
        .findings
        .iter()
        .filter(|f| f.severity < Severity::Note);
    said.extend(weighty.flat_map(text::finding_lines));
    if prints {
        said.iter().for_each(|line| complain(line));
        print(&draft.text)?;
    } else {
        write(&target, &draft.text, query.force)?;
        said.push(format!("problem file: {}", target.display()));
        print(&said.join("\n"))?;
    }
    Ok(0)
}

fn wrong(what: &str) -> CliError {
    CliError::WrongUse(what.to_owned())
}

/// Whether a file describes a robot and not what it did.
fn is_description(file: &Path) -> bool {
    let ending = file
        .extension()
        .map(|end| end.to_string_lossy().to_lowercase());
    ending.is_some_and(|end| ["urdf", "xml", "xacro", "mjcf", "toml"].contains(&end.as_str()))
}

/// Writes the file; one that came there meanwhile is kept as one that was there before.
fn write(target: &Path, text: &str, force: bool) -> Result<(), CliError> {
    let mut options = OpenOptions::new();
    match force {
        true => options.write(true).create(true).truncate(true),
        false => options.write(true).create_new(true),
    };
    let folder = target
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let written = folder
        .map_or(Ok(()), fs::create_dir_all)
        .and_then(|()| options.open(target))
        .and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(|e| {
        let remedy = match e.kind() {
            ErrorKind::AlreadyExists => "--force replaces it",
            _ => "name another file with --out",
        };
        CliError::WrongUse(format!(
            "{}: cannot be written: {e}; {remedy}",
            target.display()
        ))
    })
}
