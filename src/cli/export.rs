//! `exid export`: the identified robot in the formats of others.

use crate::cli::args::{Conversion, Target};
use crate::cli::error::CliError;
use crate::cli::output::print;
use crate::export::{self, Export, File, Format};
use crate::outcome::Outcome;
use serde_json::json;
use std::fs;
use std::path::{Path, PathBuf};

pub fn run(query: &Conversion) -> Result<u8, CliError> {
    let outcome = Outcome::read(&query.result)?;
    let export = export::export(&outcome, query.to.into())?;
    let folder = folder(query);
    fs::create_dir_all(&folder).map_err(|e| refused(&folder, &e))?;
    for file in &export.files {
        write(&folder, file)?;
    }
    if query.json {
        print(&as_json(&folder, &export))?;
    } else if !query.quiet {
        print(&as_text(&folder, &export))?;
    }
    Ok(0)
}

/// Beside the result, unless another folder is asked for.
fn folder(query: &Conversion) -> PathBuf {
    let result = || {
        if query.result.is_dir() {
            return query.result.clone();
        }
        query.result.parent().unwrap_or(Path::new("")).to_path_buf()
    };
    query.out.clone().unwrap_or_else(result)
}

/// A name beside it and a rename: the old file stays until the new one is whole.
fn write(folder: &Path, file: &File) -> Result<(), CliError> {
    let path = folder.join(&file.name);
    let partial = folder.join(format!(".{}.partial", file.name));
    let written = fs::write(&partial, &file.text).and_then(|()| fs::rename(&partial, &path));
    written.map_err(|e| {
        let _ = fs::remove_file(&partial);
        refused(&path, &e)
    })
}

fn refused(path: &Path, error: &std::io::Error) -> CliError {
    CliError::WrongUse(format!(
        "{}: cannot be written: {error}; give another folder with --out",
        path.display()
    ))
}

fn as_text(folder: &Path, export: &Export) -> String {
    let files = export.files.iter().map(|f| folder.join(&f.name));
    let mut lines: Vec<String> = files.map(|path| path.display().to_string()).collect();
    lines.extend(export.notes.iter().map(|note| format!("note: {note}")));
    lines.join("\n")
}

fn as_json(folder: &Path, export: &Export) -> String {
    let files = export.files.iter().map(|f| folder.join(&f.name));
    let files: Vec<String> = files.map(|path| path.display().to_string()).collect();
    format!("{:#}", json!({ "files": files, "notes": export.notes }))
}

impl From<Target> for Format {
    fn from(target: Target) -> Self {
        match target {
            Target::Urdf => Self::Urdf,
            Target::Mjcf => Self::Mjcf,
            Target::Mujoco => Self::Mujoco,
            Target::Toml => Self::Toml,
            Target::Rust => Self::Rust,
            Target::C => Self::C,
            Target::Numpy => Self::NumPy,
        }
    }
}
