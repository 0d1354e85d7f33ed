//! Results in the formats of other programs, and the schema of problems.

use crate::error::Failure;
use exid::chain::effect;
use exid::export::{self, Format};
use exid::outcome::Outcome;
use exid::problem_file;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Formats by their names on the command line.
const FORMATS: [(&str, Format); 7] = [
    ("urdf", Format::Urdf),
    ("mjcf", Format::Mjcf),
    ("mujoco", Format::Mujoco),
    ("toml", Format::Toml),
    ("rust", Format::Rust),
    ("c", Format::C),
    ("numpy", Format::NumPy),
];

/// Files by name, and what a reader should know.
#[derive(IntoPyObject)]
pub struct Exported {
    files: Vec<(String, String)>,
    notes: Vec<String>,
}

/// The identified robot of a result in another format.
pub fn export(py: Python<'_>, outcome: &Outcome, to: &str) -> PyResult<Exported> {
    let Some((_, format)) = FORMATS.into_iter().find(|(name, _)| *name == to) else {
        let known = FORMATS.map(|(name, _)| name).join(", ");
        return Err(PyValueError::new_err(format!(
            "{to:?} is no format; there are {known}"
        )));
    };
    let export = export::export(outcome, format).map_err(|e| Failure::from(e).raise(py))?;
    Ok(Exported {
        files: export.files.into_iter().map(|f| (f.name, f.text)).collect(),
        notes: export.notes,
    })
}

/// JSON schema of a problem.
#[pyfunction]
pub fn schema() -> String {
    problem_file::schema::schema(&effect::ids()).to_string()
}
