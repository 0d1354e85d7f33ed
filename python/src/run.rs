//! Runs of the verbs and their results, as Python sees them.

use crate::error::Failure;
use crate::exports::{self, Exported};
use crate::problem::Given;
use crate::supervise::Supervisor;
use exid::outcome::folder::ResultFolder;
use exid::outcome::input::Input;
use exid::outcome::predictions::Predictions;
use exid::outcome::{Outcome, PREDICTIONS_FILE, RESULT_FILE};
use exid::problem_file::ProblemFile;
use exid::report::text;
use exid::verb::Verb;
use exid::verb::completed::{Completed, Found};
use exid::verb::ending::Ending;
use exid::verb::error::VerbError;
use exid::verb::kept::KeptProblem;
use exid::verb::rollout::RolledResult;
use exid::verb::settings::{OnMistakes, Settings};
use numpy::{IntoPyArray, PyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// A result, and what it is made of.
enum Made {
    /// By a run of this process.
    Here {
        completed: Box<Completed>,
        problem: Box<ProblemFile>,
    },
    /// Read from a folder.
    Read {
        outcome: Box<Outcome>,
        folder: PathBuf,
    },
}

/// A result of a verb.
#[pyclass(frozen, module = "exid._core")]
pub struct Run {
    made: Made,
}

/// How a run is done.
#[derive(FromPyObject)]
pub struct Options {
    seed: u64,
    threads: Option<usize>,
    force: bool,
    progress: Option<Py<PyAny>>,
    command: Vec<String>,
}

impl Options {
    fn supervisor(&self, py: Python<'_>) -> Supervisor {
        Supervisor {
            progress: self.progress.as_ref().map(|p| p.clone_ref(py)),
            interrupt: Arc::new(AtomicBool::new(false)),
            threads: self.threads,
        }
    }

    fn settings<'a>(
        &self,
        supervisor: &Supervisor,
        progress: &'a (dyn Fn(&str) + Sync),
    ) -> Settings<'a> {
        Settings {
            seed: self.seed,
            on_mistakes: match self.force {
                true => OnMistakes::GoOn,
                false => OnMistakes::Refuse,
            },
            interrupt: Some(Arc::clone(&supervisor.interrupt)),
            progress,
            command: self.command.clone(),
            started: Instant::now(),
        }
    }
}

/// Runs a verb on a problem.
#[pyfunction]
pub fn run(py: Python<'_>, verb: &str, problem: Given, options: Options) -> PyResult<Run> {
    let Some(verb) = Verb::ALL.into_iter().find(|known| known.name() == verb) else {
        return Err(PyValueError::new_err(format!(
            "{verb:?} is no verb that runs a problem"
        )));
    };
    let source = problem.source()?;
    let supervisor = options.supervisor(py);
    supervisor.run(py, |say| {
        let mut problem = source.read()?;
        stop_reading(&mut problem, &supervisor.interrupt);
        let completed = verb.run(&problem, &options.settings(&supervisor, say))?;
        Ok(Run {
            made: Made::Here {
                completed: Box::new(completed),
                problem: Box::new(problem),
            },
        })
    })
}

/// Rolls out the models of a result.
#[pyfunction]
pub fn rollout(
    py: Python<'_>,
    result: &Run,
    set: Vec<String>,
    source: String,
    options: Options,
) -> PyResult<Run> {
    let supervisor = options.supervisor(py);
    supervisor.run(py, |say| {
        let settings = options.settings(&supervisor, say);
        let rollable = result.rollable(&set, &supervisor.interrupt)?;
        let completed = exid::verb::rollout::run(
            RolledResult {
                outcome: result.outcome(),
                problem: &rollable.problem,
                source,
                file: rollable.file,
                set: &set,
                notes: rollable.notes,
            },
            &settings,
        )?;
        Ok(Run {
            made: Made::Here {
                completed: Box::new(completed),
                problem: rollable.problem,
            },
        })
    })
}

/// Reads the result of a run of any verb from its folder.
#[pyfunction]
pub fn load(py: Python<'_>, folder: PathBuf) -> PyResult<Run> {
    let outcome = Outcome::read(&folder).map_err(|e| Failure::from(e).raise(py))?;
    let folder = match folder.is_dir() {
        true => folder,
        false => folder.parent().unwrap_or(Path::new("")).to_path_buf(),
    };
    Ok(Run {
        made: Made::Read {
            outcome: Box::new(outcome),
            folder,
        },
    })
}

/// An interrupt ends the reading of recordings too.
fn stop_reading(problem: &mut ProblemFile, interrupt: &Arc<AtomicBool>) {
    if let Some(recordings) = &mut problem.recordings {
        recordings.reading.interrupt = Some(Arc::clone(interrupt));
    }
}

/// The problem of a result with its inputs as they were.
struct Rollable {
    problem: Box<ProblemFile>,
    /// The file of the result, where it has one.
    file: Option<Input>,
    notes: Vec<String>,
}

impl Run {
    fn outcome(&self) -> &Outcome {
        match &self.made {
            Made::Here { completed, .. } => &completed.outcome,
            Made::Read { outcome, .. } => outcome,
        }
    }

    fn rollable(&self, set: &[String], interrupt: &Arc<AtomicBool>) -> Result<Rollable, Failure> {
        let outcome = self.outcome();
        exid::verb::rollout::require_robot(outcome)?;
        let mut rollable = match &self.made {
            Made::Here { problem, .. } => {
                let kept = ProblemFile::kept(
                    &problem.path,
                    &outcome.run.problem,
                    set,
                    &exid::chain::effect::ids(),
                )?;
                let mut kept = Box::new(kept);
                if let (Some(to), Some(from)) = (&mut kept.recordings, &problem.recordings) {
                    to.reading = from.reading.clone();
                }
                unchanged(outcome, &kept)?;
                Rollable {
                    problem: kept,
                    file: None,
                    notes: Vec::new(),
                }
            }
            Made::Read { folder, .. } => {
                let mut kept = KeptProblem::of(outcome)?;
                Rollable {
                    problem: Box::new(kept.read(set)?),
                    file: Input::of(&folder.join(RESULT_FILE)).ok(),
                    notes: std::mem::take(&mut kept.notes),
                }
            }
        };
        stop_reading(&mut rollable.problem, interrupt);
        if let Some(recordings) = &mut rollable.problem.recordings {
            // What has been read once is not too long.
            recordings.reading.most_rows = usize::MAX;
        }
        Ok(rollable)
    }
}

/// Arrays that have been changed since the result was made of them are not taken for what they were.
fn unchanged(outcome: &Outcome, problem: &ProblemFile) -> Result<(), VerbError> {
    let Some(recordings) = &problem.recordings else {
        return Ok(());
    };
    let memory = &recordings.reading.memory;
    let changed = outcome.run.inputs.iter().filter(|input| {
        let arrays = memory.at(Path::new(&input.path));
        arrays.is_some_and(|arrays| arrays.sha256() != input.sha256)
    });
    let changed: Vec<String> = changed
        .map(|input| format!("{}: the arrays have changed since", input.path))
        .collect();
    match changed.is_empty() {
        true => Ok(()),
        false => Err(VerbError::ChangedInputs(changed)),
    }
}

/// A table by its name: columns by theirs.
type Columns<'py> = Bound<'py, PyDict>;

fn column<'py>(py: Python<'py>, values: &[f64]) -> Bound<'py, PyArray1<f64>> {
    values.to_vec().into_pyarray(py)
}

#[pymethods]
impl Run {
    /// The result as the text of `result.json`.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        let json = self.outcome().to_json();
        json.map_err(|error| Failure::from(error).raise(py))
    }

    /// The exit code of the program, where the run was made here.
    fn exit_code(&self) -> Option<u8> {
        match &self.made {
            Made::Here { completed, .. } => Some(completed.ending.exit_code()),
            Made::Read { .. } => None,
        }
    }

    /// Words about a defect that ended the run.
    fn defect(&self) -> Option<String> {
        match &self.made {
            Made::Here { completed, .. } => match &completed.ending {
                Ending::Defect(defect) => Some(defect.to_string()),
                _ => None,
            },
            Made::Read { .. } => None,
        }
    }

    /// What the program prints.
    fn summary(&self) -> String {
        text::summary(self.outcome(), None)
    }

    /// Recordings with what was recorded and predicted: (name, split, columns by (joint, quantity)).
    fn predictions<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Vec<(String, &'static str, Columns<'py>)>> {
        let table = match &self.made {
            Made::Here { completed, .. } => py.detach(|| completed.found.predictions()),
            Made::Read { folder, .. } => {
                let path = folder.join(PREDICTIONS_FILE);
                let read = path
                    .exists()
                    .then(|| py.detach(|| Predictions::read(&path)));
                read.transpose()
                    .map_err(|error| Failure::from(error).raise(py))?
            }
        };
        let Some(table) = table else {
            return Ok(Vec::new());
        };
        let mut recordings = Vec::with_capacity(table.recordings.len());
        for recording in table.recordings {
            let columns = PyDict::new(py);
            columns.set_item(("", "t"), recording.t.into_pyarray(py))?;
            for (column, values) in table.columns.iter().zip(recording.values) {
                let key = (&column.joint, column.quantity.as_str());
                columns.set_item(key, values.into_pyarray(py))?;
            }
            recordings.push((recording.recording, recording.split.as_str(), columns));
        }
        Ok(recordings)
    }

    /// Tables of a design or a simulation by the names of their files, without ends; None of a result that was read.
    fn tables<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Made::Here { completed, .. } = &self.made else {
            return Ok(None);
        };
        let tables = PyDict::new(py);
        match &completed.found {
            Found::Design(designed) => {
                for trajectory in designed.trajectories.iter().chain(&designed.with_ramps) {
                    let sampled = &trajectory.sampled;
                    let columns = PyDict::new(py);
                    let count = sampled.values[0].first().map_or(0, Vec::len);
                    let times: Vec<f64> = (0..count).map(|k| k as f64 * sampled.step).collect();
                    columns.set_item("t", times.into_pyarray(py))?;
                    for (prefix, joints) in ["q", "dq", "ddq"].iter().zip(&sampled.values) {
                        for (joint, values) in sampled.joints.iter().zip(joints) {
                            columns.set_item(format!("{prefix}_{joint}"), column(py, values))?;
                        }
                    }
                    tables.set_item(&trajectory.name, columns)?;
                }
            }
            Found::Simulation(simulated) => {
                for recording in simulated.recordings.iter().chain(&simulated.trajectories) {
                    let columns = PyDict::new(py);
                    for (name, values) in recording.table.header.iter().zip(&recording.table.data) {
                        columns.set_item(name, column(py, values))?;
                    }
                    tables.set_item(&recording.name, columns)?;
                }
            }
            _ => {}
        }
        Ok(Some(tables))
    }

    /// The folder that the result was read from.
    fn folder(&self) -> Option<PathBuf> {
        match &self.made {
            Made::Here { .. } => None,
            Made::Read { folder, .. } => Some(folder.clone()),
        }
    }

    /// Writes the results folder.
    fn save(&self, py: Python<'_>, target: PathBuf) -> PyResult<()> {
        let saved = py.detach(|| match &self.made {
            Made::Here { completed, .. } => {
                completed.save(&target).map(drop).map_err(Failure::from)
            }
            Made::Read { folder, .. } => copy(folder, &target),
        });
        saved.map_err(|failure| failure.raise(py))
    }

    /// The identified robot in another format.
    fn export(&self, py: Python<'_>, to: &str) -> PyResult<Exported> {
        exports::export(py, self.outcome(), to)
    }
}

/// Makes sure that a results folder can be written: refused before the work, not after it.
#[pyfunction]
pub fn require_writable(py: Python<'_>, folder: PathBuf) -> PyResult<()> {
    let prepared = ResultFolder::prepare(&folder);
    prepared.map(drop).map_err(|e| Failure::from(e).raise(py))
}

/// Copies a results folder, whole or not at all.
fn copy(folder: &Path, target: &Path) -> Result<(), Failure> {
    let to = ResultFolder::prepare(target)?;
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_file() {
            let name = entry.file_name().to_string_lossy().into_owned();
            to.write(&name, |out| out.write_all(&fs::read(&path)?))?;
        }
    }
    to.commit()?;
    Ok(())
}
