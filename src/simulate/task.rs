//! What is simulated, and how it is recorded: the rate, and the recordings that are made.

use crate::fault::Place;
use crate::problem_file::{Located, RecordingsTable, SimulateTable};
use crate::setup::limits::JointLimits;
use crate::setup::recordings;
use crate::setup::robot::Robot;
use crate::simulate::error::{SimulateError, SimulateErrorKind};
use crate::simulate::truth::Truth;
use std::path::{Component, Path as FilePath, PathBuf};

/// Rate of a recording where none is stated, Hz.
const DEFAULT_RATE: f64 = 200.0;

/// What is simulated, and how it is recorded.
#[derive(Debug, Clone)]
pub struct SimulateTask<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// What is true of it.
    pub truth: &'a Truth,
    /// The files that are made, and their form; without them, one to fit and one to validate.
    pub recordings: Option<&'a RecordingsTable>,
    /// The motion, the sensors and their noise.
    pub settings: &'a SimulateTable,
    /// What a motion that is drawn keeps to.
    pub drawn: DrawnMotion,
    /// Where what cannot be recorded is to be mended.
    pub place: Place,
    /// Of everything that is drawn.
    pub seed: u64,
}

/// What a motion that is drawn keeps to.
#[derive(Debug, Clone)]
pub struct DrawnMotion {
    /// Of every joint, in the order of the tree.
    pub limits: Vec<JointLimits>,
    /// Of a Fourier series.
    pub harmonics: usize,
    /// s, where the recordings state none.
    pub period: f64,
}

/// A recording that is to be made.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    pub name: String,
    pub loaded: bool,
}

impl SimulateTask<'_> {
    /// The period that the recordings state, s.
    pub(super) fn stated_period(&self) -> Option<&Located<f64>> {
        self.recordings?.period.as_ref()
    }

    /// `simulate.rate`, else `recordings.rate`, else the default.
    pub(super) fn rate(&self) -> Result<f64, SimulateError> {
        let recorded = self.recordings.and_then(|r| r.rate.as_ref());
        match (&self.settings.rate, recorded) {
            (Some(own), Some(recorded)) if own.value != recorded.value => {
                let kind = SimulateErrorKind::RateConflict {
                    simulate: own.value,
                    recordings: recorded.value,
                };
                Err(SimulateError::new(&own.place, kind))
            }
            (own, recorded) => Ok(own.as_ref().or(recorded).map_or(DEFAULT_RATE, |r| r.value)),
        }
    }

    /// The recordings to make, under names that stay inside the results folder.
    pub(super) fn planned(&self) -> Result<Vec<Plan>, SimulateError> {
        let has_load = self.truth.plant.payload().is_some();
        let Some(table) = self.recordings else {
            let plan = |name: &str| Plan {
                name: name.to_string(),
                loaded: has_load,
            };
            return Ok(vec![plan("train.csv"), plan("validation.csv")]);
        };
        let listed = recordings::list(table);
        let place = self.place.clone().key("recordings");
        let mut plans: Vec<Plan> = Vec::new();
        let mut sources: Vec<&FilePath> = Vec::new();
        for named in &listed {
            // A file that trains and validates is one recording.
            if sources.contains(&named.path.resolved.as_path()) {
                continue;
            }
            sources.push(&named.path.resolved);
            let name = inside(&named.path.written);
            let fault = |kind| Err(SimulateError::new(&place, kind));
            if !name.ends_with(".csv") && !name.ends_with(".csv.gz") {
                return fault(SimulateErrorKind::FormatNotWritten { found: name });
            }
            if plans.iter().any(|p| p.name == name) {
                return fault(SimulateErrorKind::SameName { found: name });
            }
            plans.push(Plan {
                name,
                loaded: has_load && (named.loaded || self.truth.hidden_load),
            });
        }
        Ok(plans)
    }

    /// Of recordings that lie in several files: which one has every channel, and which are not written.
    pub(super) fn unwritten(&self) -> Option<String> {
        let table = self.recordings?;
        let lists = [&table.train, &table.loaded, &table.validation];
        let joined = lists.into_iter().flatten();
        let mut pairs: Vec<String> = Vec::new();
        for files in joined
            .map(|files| &files.value.files)
            .filter(|f| f.len() > 1)
        {
            let others = files[1..].iter().map(|f| f.path.written.as_str());
            let others: Vec<&str> = others.collect();
            let pair = format!("{} ({})", files[0].path.written, others.join(", "));
            if !pairs.contains(&pair) {
                pairs.push(pair);
            }
        }
        (!pairs.is_empty()).then(|| {
            format!(
                "every channel is in the first file of a recording, under the names that exid finds by itself, and the others of it \
                 are not written: {}; a problem that reads the simulation lists the first file alone, without a map of columns",
                pairs.join("; ")
            )
        })
    }
}

/// A path as written, without what leads out of a folder; of an absolute one, the file's name.
pub(super) fn inside(written: &str) -> String {
    let path = FilePath::new(written);
    if path.is_absolute() {
        return path
            .file_name()
            .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    }
    let parts = path
        .components()
        .filter(|c| matches!(c, Component::Normal(_)));
    let kept: PathBuf = parts.collect();
    kept.to_string_lossy().into_owned()
}
