//! Problems as Python gives them: the path of a file, or the table that the file would hold.

use crate::arrays::Arrays;
use crate::error::Failure;
use exid::chain::effect;
use exid::problem_file::ProblemFile;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::PathBuf;

/// A problem, before it is read.
pub struct Source {
    /// The file; of a table, the file that its relative paths start from.
    pub path: PathBuf,
    /// The table as JSON, where it is not that of the file.
    pub table: Option<serde_json::Value>,
    pub overrides: Vec<String>,
    /// Recordings in memory by the names that the problem gives them.
    pub memory: Vec<(String, Py<Arrays>)>,
    pub most_rows: Option<usize>,
}

/// What Python hands over of a problem.
#[derive(FromPyObject)]
pub struct Given {
    path: PathBuf,
    table: Option<String>,
    overrides: Vec<String>,
    memory: Vec<(String, Py<Arrays>)>,
    max_rows: Option<usize>,
}

impl Given {
    pub fn source(self) -> PyResult<Source> {
        let table = self.table.map(|text| serde_json::from_str(&text));
        let table = table.transpose().map_err(|error| {
            PyValueError::new_err(format!("the table of the problem is no JSON: {error}"))
        })?;
        Ok(Source {
            path: self.path,
            table,
            overrides: self.overrides,
            memory: self.memory,
            most_rows: self.max_rows,
        })
    }
}

impl Source {
    /// Reads the problem and puts recordings in memory in their places.
    pub fn read(&self) -> Result<ProblemFile, Failure> {
        let ids = effect::ids();
        let mut problem = match &self.table {
            None => ProblemFile::read(&self.path, &self.overrides, &ids)?,
            Some(table) => ProblemFile::kept(&self.path, table, &self.overrides, &ids)?,
        };
        let folder = problem.path.parent().unwrap_or(std::path::Path::new(""));
        let folder = folder.to_path_buf();
        if let Some(recordings) = &mut problem.recordings {
            let reading = &mut recordings.reading;
            if let Some(rows) = self.most_rows {
                reading.most_rows = rows;
            }
            for (name, arrays) in &self.memory {
                let arrays = arrays.get().arrays.clone();
                reading.memory.insert(folder.join(name), arrays);
            }
        }
        Ok(problem)
    }
}

/// A problem file as the table that it holds, after overrides, as JSON.
#[pyfunction]
pub fn read_problem(py: Python<'_>, path: PathBuf, overrides: Vec<String>) -> PyResult<String> {
    let read = ProblemFile::read(&path, &overrides, &effect::ids());
    let problem = read.map_err(|error| Failure::from(error).raise(py))?;
    Ok(problem.json.to_string())
}
