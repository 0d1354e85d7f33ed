//! One item: its problem with its recordings, its key, and what it comes to.

use crate::chain::effect;
use crate::diagnose;
use crate::estimate;
use crate::fault::Fault;
use crate::fleet::error::FleetError;
use crate::fleet::item::{Done, Found, ItemOutcome, SetAside, Value};
use crate::fleet::key;
use crate::fleet::manifest::{Entry, Verb};
use crate::fleet::settings::Settings;
use crate::fleet::store::Store;
use crate::outcome::estimate::Estimate;
use crate::outcome::fit::BaseParameter;
use crate::outcome::parameter::{Parameter, Source};
use crate::problem::defect::{Defect, guarded};
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::setup::error::SetupError;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Times that an item may be under way when its process is killed. Kills from outside meet an item once while all are
/// worked on, and again only while those that were met are worked on one by one; so often it is met by itself alone.
const MOST_ABANDONED: u32 = 5;

/// What an item came to, and whether this run has worked on it.
#[derive(Debug)]
pub struct AttemptedItem {
    pub came_to: ItemOutcome,
    pub work: Work,
}

/// Where a result comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Work {
    /// An earlier run.
    Earlier,
    /// This run.
    Now,
    /// Nobody: its problem or its recordings cannot be read.
    Unready,
}

/// The end of looking at an item.
#[derive(Debug)]
pub enum Looked {
    AttemptedItem(AttemptedItem),
    /// It was under way when a process was killed, and is to be done alone when all others are done.
    Later,
    /// The run is interrupted.
    Interrupted,
}

/// Whether an item that was under way when a process was killed may be done now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turn {
    First,
    /// All others are done.
    Last,
}

/// What one worker works with.
pub struct Worker<'a> {
    pub settings: &'a Settings,
    pub store: &'a Store<ItemOutcome>,
    /// The folder of the manifest, which messages leave out.
    pub folder: &'a Path,
    /// Set when an item's time is over, or the run is interrupted.
    pub flag: Arc<AtomicBool>,
    /// Set when the run is interrupted.
    pub interrupt: Arc<AtomicBool>,
}

/// Why an item came to nothing.
struct Failure {
    code: String,
    message: String,
    again: Again,
}

/// Whether the same may end otherwise when it is done again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Again {
    Never,
    Perhaps,
}

impl Failure {
    fn never(code: &str, message: String) -> Self {
        Self {
            code: code.to_string(),
            message,
            again: Again::Never,
        }
    }
}

impl From<SetupError> for Failure {
    fn from(error: SetupError) -> Self {
        Self::never(error.describe().code, error.to_string())
    }
}

impl From<Defect> for Failure {
    fn from(defect: Defect) -> Self {
        Self {
            again: Again::Perhaps,
            ..Self::never("defect", defect.to_string())
        }
    }
}

impl Worker<'_> {
    /// Looks at an item, and works on it where that is not done; `clock` hears when work begins and ends.
    ///
    /// # Errors
    /// The folder of items cannot be written.
    pub fn look(
        &self,
        entry: &Entry,
        turn: Turn,
        clock: &(dyn Fn(Running) + Sync),
    ) -> Result<Looked, FleetError> {
        let aside = |fault: Failure, attempts| {
            ItemOutcome::SetAside(SetAside {
                code: fault.code,
                message: self.without_folder(&fault.message),
                attempts,
            })
        };
        let earlier = |came_to| {
            Looked::AttemptedItem(AttemptedItem {
                came_to,
                work: Work::Earlier,
            })
        };
        let prepared = guarded(|| self.prepared(entry)).unwrap_or_else(|defect| Err(defect.into()));
        let (problem, key) = match prepared {
            Ok(prepared) => prepared,
            // Not kept: what is not there now may be there the next time.
            Err(fault) => {
                return Ok(Looked::AttemptedItem(AttemptedItem {
                    came_to: aside(fault, 0),
                    work: Work::Unready,
                }));
            }
        };
        match self.store.read(&key) {
            Some(ItemOutcome::SetAside(_)) if self.settings.again => {}
            Some(came_to) => return Ok(earlier(came_to)),
            None => {}
        }
        let abandoned = self.store.abandoned(&key);
        if abandoned > 0 && turn == Turn::First {
            return Ok(Looked::Later);
        }
        let came_to = if abandoned >= MOST_ABANDONED {
            let message = format!("the process ended while it was under way, {abandoned} times");
            aside(Failure::never("process-ended", message), abandoned)
        } else {
            self.store.begin(&key, abandoned)?;
            let mut attempts = 0;
            loop {
                attempts += 1;
                clock(Running::Begins);
                let result = guarded(|| self.work(entry, &problem))
                    .unwrap_or_else(|defect| Err(defect.into()));
                clock(Running::Ends);
                if self.interrupt.load(Ordering::Relaxed) {
                    self.store.give_up(&key, abandoned);
                    return Ok(Looked::Interrupted);
                }
                match result {
                    Ok(done) => break ItemOutcome::Done(done),
                    Err(fault)
                        if fault.again == Again::Perhaps && attempts <= self.settings.retries => {}
                    Err(fault) => break aside(fault, attempts),
                }
            }
        };
        self.store.keep(&key, &came_to)?;
        Ok(Looked::AttemptedItem(AttemptedItem {
            came_to,
            work: Work::Now,
        }))
    }

    /// The problem of an item, and its key.
    fn prepared(&self, entry: &Entry) -> Result<(ProblemFile, String), Failure> {
        let mut overrides = vec![
            format!("recordings.train={}", list(&entry.recordings)),
            format!("recordings.validation={}", list(&entry.validation)),
            "recordings.loaded=[]".to_string(),
        ];
        overrides.extend(self.settings.set.iter().cloned());
        let problem = ProblemFile::read(&entry.problem, &overrides, &effect::ids());
        let mut problem = problem.map_err(SetupError::from)?;
        if let Some(recordings) = &mut problem.recordings {
            recordings.reading.interrupt = Some(Arc::clone(&self.flag));
            if let Some(rows) = self.settings.max_rows {
                recordings.reading.most_rows = rows;
            }
        }
        let files = (self.settings.inputs)(&problem);
        let key = key::of(&problem, entry.verb, &files)
            .map_err(|error| Failure::never(error.describe().code, error.to_string()))?;
        Ok((problem, key))
    }

    fn work(&self, entry: &Entry, problem: &ProblemFile) -> Result<Done, Failure> {
        let control = Control {
            interrupt: Some(Arc::clone(&self.flag)),
            ..Control::default()
        };
        let result = match entry.verb {
            Verb::Fit => fitted(problem, &control),
            Verb::Diagnose => diagnosed(problem, &control),
        };
        // Whatever an interrupted search has come to.
        if self.flag.load(Ordering::Relaxed) {
            let seconds = self.settings.timeout.as_secs_f64();
            return Err(Failure {
                again: Again::Perhaps,
                ..Failure::never("timeout", format!("not done within {seconds} s"))
            });
        }
        result
    }

    /// A message that is the same wherever the fleet lies.
    fn without_folder(&self, message: &str) -> String {
        message.replace(&format!("{}/", self.folder.display()), "")
    }
}

/// What the watch over an item's time hears.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Running {
    Begins,
    Ends,
}

/// Paths as a list of TOML.
fn list(paths: &[PathBuf]) -> String {
    let texts: Vec<String> = paths.iter().map(|p| p.display().to_string()).collect();
    serde_json::Value::from(texts).to_string()
}

fn fitted(problem: &ProblemFile, control: &Control<'_>) -> Result<Done, Failure> {
    use crate::estimate::task::FitError;
    let run = estimate::task::run(problem, control, |_| ()).map_err(|error| match error {
        FitError::Setup(error) => error.into(),
        FitError::Estimate { .. } => Failure::never("no-solution", error.to_string()),
        FitError::Defect(defect) => defect.into(),
    })?;
    if let Some(defect) = run.defect {
        return Err(defect.into());
    }
    converged(&run.fitted.estimate)?;
    Ok(Done {
        values: values(&run.fitted.estimate, &run.fitted.fit.base_parameters),
        findings: Vec::new(),
    })
}

fn diagnosed(problem: &ProblemFile, control: &Control<'_>) -> Result<Done, Failure> {
    use crate::diagnose::error::DiagnoseError;
    let run = diagnose::task::run(problem, control, &|_| ()).map_err(|error| match error {
        DiagnoseError::Setup(error) => error.into(),
        DiagnoseError::Fit(_) => Failure::never("no-solution", error.to_string()),
        DiagnoseError::Defect(defect) => defect.into(),
    })?;
    if let Some(defect) = run.defect {
        return Err(defect.into());
    }
    converged(&run.estimate)?;
    let base = run.diagnosis.fit.as_ref().map(|fit| &fit.base_parameters);
    let findings = run.diagnosis.findings.iter().map(|finding| Found {
        effect: finding.effect.clone(),
        joints: finding.joints.clone(),
        sentence: finding.sentence.clone(),
        probability: Some(finding.probability),
    });
    Ok(Done {
        values: values(&run.estimate, base.map_or(&[], Vec::as_slice)),
        findings: findings.collect(),
    })
}

/// A search without a solution has no values that mean anything.
fn converged(estimate: &Estimate) -> Result<(), Failure> {
    match &estimate.solver {
        Some(solver) if !solver.converged => Err(Failure::never(
            "not-converged",
            format!(
                "{} ended after {} iterations: {}",
                solver.name, solver.iterations, solver.stop
            ),
        )),
        _ => Ok(()),
    }
}

/// Estimated parameters, and the combinations of those that are not determined one by one.
fn values(estimate: &Estimate, base: &[BaseParameter]) -> Vec<Value> {
    let estimated =
        |p: &&Parameter| matches!(p.source, Source::Data | Source::Prior | Source::Bound);
    let single = || estimate.parameters.iter().filter(estimated);
    let mut values: Vec<Value> = single().map(Value::from).collect();
    let known = |expression: &str| {
        // A mass that stands alone in a combination has the name of the regressor's column there.
        let mass = expression
            .strip_suffix(".m")
            .map(|body| format!("{body}.mass"));
        single().any(|p| p.name == expression || Some(&p.name) == mass.as_ref())
    };
    let combined = base.iter().filter(|b| !known(&b.expression));
    values.extend(combined.map(|base| Value {
        parameter: base.expression.clone(),
        unit: base.unit.clone(),
        value: base.value,
        std: base.std_dev,
        noise: base.std_dev,
        source: Source::Data,
    }));
    values
}
