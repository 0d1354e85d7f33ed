//! An outcome as one flat JSON object, whose `verb` says which part it carries.

use std::path::{Path, PathBuf};

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::outcome::check::Mistake;
use crate::outcome::error::{Action, OutcomeError, OutcomeErrorKind};
use crate::outcome::estimate::Estimate;
use crate::outcome::run::Run;
use crate::outcome::{Outcome, Part, RESULT_FILE};

impl Outcome {
    /// The outcome as indented JSON, ended by a newline.
    ///
    /// # Errors
    /// `not-encodable` if the problem holds a key that is not text.
    pub fn to_json(&self) -> Result<String, OutcomeError> {
        let mut text = serde_json::to_string_pretty(self).map_err(|error| {
            OutcomeError::new(
                Path::new(RESULT_FILE),
                OutcomeErrorKind::NotEncodable(error.to_string()),
            )
        })?;
        text.push('\n');
        Ok(text)
    }

    /// Reads `result.json` of a results folder, or the file itself.
    ///
    /// # Errors
    /// `not-readable` if there is no such file, `results-within` if folders in it have one, `not-a-result` if it is not the result of a run.
    pub fn read(path: &Path) -> Result<Self, OutcomeError> {
        read_as(path)
    }
}

/// Folders with results directly in a folder, as the verbs of a problem leave them; none of what is no folder.
fn results_within(path: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    let folders = entries.map(|entry| entry.path());
    let mut found: Vec<PathBuf> = folders.filter(|f| f.join(RESULT_FILE).is_file()).collect();
    found.sort();
    found
}

/// Reads `result.json` of a results folder, or the file itself, as what it is to be.
fn read_as<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T, OutcomeError> {
    let file = match path.is_dir() {
        true => path.join(RESULT_FILE),
        false => path.to_path_buf(),
    };
    if !file.exists() {
        let folders = results_within(path);
        if !folders.is_empty() {
            let kind = OutcomeErrorKind::ResultsWithin { folders };
            return Err(OutcomeError::new(path, kind));
        }
    }
    let text = std::fs::read_to_string(&file)
        .map_err(|error| OutcomeError::io(&file, Action::ReadResult, &error))?;
    serde_json::from_str(&text)
        .map_err(|error| OutcomeError::new(&file, OutcomeErrorKind::NotAResult(error.to_string())))
}

/// The text of a result as JSON, without what differs between runs that are the same.
///
/// # Errors
/// As [`Outcome::read`].
pub fn answer(path: &Path) -> Result<serde_json::Value, OutcomeError> {
    read_as(path).map(|mut value| {
        remove_exempt(&mut value);
        value
    })
}

/// What says who made a result, of which files and how long it took, and not what was found.
const EXEMPT: [&str; 7] = [
    "version",
    "inputs",
    "wall_s",
    "provenance",
    "seconds",
    "core_seconds",
    "elapsed_s",
];

fn remove_exempt(value: &mut serde_json::Value) {
    match value {
        serde_json::Value::Object(entries) => {
            entries.retain(|key, _| !EXEMPT.contains(&key.as_str()));
            // The problem as read is a user's text, whose keys are names.
            let own = entries.iter_mut().filter(|(key, _)| *key != "problem");
            own.for_each(|(_, value)| remove_exempt(value));
        }
        serde_json::Value::Array(items) => items.iter_mut().for_each(remove_exempt),
        _ => {}
    }
}

#[derive(Serialize)]
struct Written<'a> {
    name: &'a str,
    verb: &'static str,
    #[serde(flatten)]
    run: &'a Run,
    #[serde(skip_serializing_if = "Option::is_none")]
    mistakes: Option<&'a [Mistake]>,
    #[serde(flatten)]
    estimate: &'a Estimate,
    #[serde(flatten)]
    part: &'a Part,
}

impl Serialize for Outcome {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let looks_for_mistakes = !matches!(
            self.part,
            Part::Check(_) | Part::Trials(_) | Part::Rollout(_) | Part::Fleet(_)
        );
        Written {
            name: &self.name,
            verb: self.part.verb(),
            run: &self.run,
            mistakes: looks_for_mistakes.then_some(&self.mistakes),
            estimate: &self.estimate,
            part: &self.part,
        }
        .serialize(serializer)
    }
}

#[derive(Deserialize)]
struct Head {
    name: String,
    verb: String,
    #[serde(flatten)]
    run: Run,
    #[serde(default)]
    mistakes: Vec<Mistake>,
    #[serde(flatten)]
    estimate: Estimate,
}

impl<'de> Deserialize<'de> for Outcome {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = serde_json::Value::deserialize(deserializer)?;
        let head = Head::deserialize(&value).map_err(D::Error::custom)?;
        let part = match head.verb.as_str() {
            "fit" => Deserialize::deserialize(&value).map(Part::Fit),
            "check" => Deserialize::deserialize(&value).map(Part::Check),
            "simulate" => Deserialize::deserialize(&value).map(Part::Simulate),
            "trials" => Deserialize::deserialize(&value).map(Part::Trials),
            "design" => Deserialize::deserialize(&value).map(Part::Design),
            "rollout" => {
                Deserialize::deserialize(&value).map(|rollout| Part::Rollout(Box::new(rollout)))
            }
            "fleet" => Deserialize::deserialize(&value).map(|fleet| Part::Fleet(Box::new(fleet))),
            "diagnose" => Deserialize::deserialize(&value)
                .map(|diagnosis| Part::Diagnose(Box::new(diagnosis))),
            other => {
                return Err(D::Error::custom(format!(
                    "the verb `{other}` is not known to version {}",
                    crate::outcome::provenance::VERSION
                )));
            }
        };
        Ok(Self {
            name: head.name,
            run: head.run,
            mistakes: head.mistakes,
            estimate: head.estimate,
            part: part.map_err(D::Error::custom)?,
        })
    }
}
