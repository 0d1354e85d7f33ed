//! The recording that would tell a finding from its rivals: a problem file for `exid design` with the criterion
//! that sets their predictions apart (Atkinson and Fedorov 1975), within the limits of the same robot.

use crate::chain::effect::{COUPLING, CROSSTALK, LOAD, TILT};
use crate::chain::model::Model;
use crate::chain::parameter::Role;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::selection::rival_models::TestedRivals;
use crate::outcome::diagnose::NextExperiment;
use crate::problem_file::ProblemFile;
use crate::problem_file::located::FilePath;
use crate::problem_file::robot::RobotSource;
use serde_json::{Map, Value, json};

/// Starts of the search where the problem file states none.
const STARTS: usize = 8;

/// Models that the recordings do not tell apart: with the first finding that has rivals, and with these in its place.
#[derive(Debug, Clone)]
pub struct Discrimination {
    /// Names of the effects, the finding's first.
    names: Vec<String>,
    /// The models, as `[[design.rival]]` has them.
    models: Vec<Value>,
    /// Standard deviation of the noise of every channel, where it is known.
    noise: Option<Vec<f64>>,
}

impl Discrimination {
    /// `None` where no finding has rivals that the recordings cannot set aside.
    pub fn of(
        context: &Context<'_>,
        full: &ModelFit,
        comparisons: &[TestedRivals],
    ) -> Option<Self> {
        let (k, open) = comparisons.iter().enumerate().find_map(|(k, comparison)| {
            let fits: Vec<&ModelFit> = comparison.open().map(|a| &a.test.fit).collect();
            (!fits.is_empty()).then_some((k, fits))
        })?;
        let finding = &full.hypotheses[k];
        let all: Vec<&ModelFit> = std::iter::once(full).chain(open.iter().copied()).collect();
        let word = |fit: &ModelFit| fit.hypotheses.last().map_or("", |h| h.effect.id);
        let mut names = vec![finding.effect.id.to_string()];
        for fit in &open {
            let name = word(fit).to_string();
            names.push(match names.contains(&name) {
                true => format!("{name} {}", names.len()),
                false => name,
            });
        }
        let models = all.iter().zip(&names).map(|(fit, name)| rival(fit, name));
        Some(Self {
            models: models.collect(),
            names,
            noise: context.noise.clone(),
        })
    }

    /// The problem file of an experiment for the robot of a problem; `None` where its own file cannot be written out.
    pub fn experiment(&self, problem: &ProblemFile) -> Option<NextExperiment> {
        let mut next = declared(problem)?;
        let design = next.entry("design").or_insert_with(|| json!({}));
        let design = design.as_object_mut()?;
        design.insert("criterion".to_string(), json!("discriminate"));
        design.insert("rival".to_string(), Value::Array(self.models.clone()));
        if let Some(noise) = &self.noise {
            design.insert("noise".to_string(), json!(noise));
        }
        // With the same period the new recording fits the problem file of the old.
        let recordings = problem.recordings.as_ref();
        if let Some(period) = recordings.and_then(|r| r.period.as_ref()) {
            design.entry("period").or_insert(json!(period.value));
        }
        if !design.contains_key("budget_s") && !design.contains_key("starts") {
            design.insert("starts".to_string(), json!(STARTS));
        }
        Some(NextExperiment {
            sentence: format!(
                "These recordings cannot tell {} apart; the motion that `exid design` finds for this problem sets \
                 their predictions as far apart as the robot's limits allow.",
                self.names.join(" and ")
            ),
            problem: toml::to_string(&Value::Object(next)).ok()?,
        })
    }
}

/// Puts the next of these paths in the place of each file of an entry, which is a path, or a table with `file` or `files`.
fn whole_paths(entry: &mut Value, paths: &mut impl Iterator<Item = Value>) {
    match entry {
        Value::Object(table) => {
            if let Some(file) = table.get_mut("file") {
                whole_paths(file, paths);
            }
            if let Some(Value::Array(files)) = table.get_mut("files") {
                files.iter_mut().for_each(|file| whole_paths(file, paths));
            }
        }
        file => {
            if let Some(path) = paths.next() {
                *file = path;
            }
        }
    }
}

/// The problem file with paths that hold wherever it is written to.
fn declared(problem: &ProblemFile) -> Option<Map<String, Value>> {
    let mut written = without_nulls(&problem.json);
    let table = written.as_object_mut()?;
    let name = format!("{}_next", problem.name.value);
    table.insert("name".to_string(), json!(name));
    table.retain(|key, _| !matches!(key.as_str(), "diagnose" | "fit" | "simulate"));
    let path = |path: &FilePath| {
        let whole = std::path::absolute(&path.resolved).unwrap_or_else(|_| path.resolved.clone());
        json!(whole.to_string_lossy())
    };
    let robot = table.get_mut("robot")?.as_object_mut()?;
    match &problem.robot.source {
        RobotSource::Urdf(file) => robot.insert("urdf".to_string(), path(file)),
        RobotSource::Mjcf(file) => robot.insert("mjcf".to_string(), path(file)),
        RobotSource::Mdh(file) => robot.insert("mdh".to_string(), path(file)),
        RobotSource::Mechanism { .. } => return None,
    };
    if let Some(file) = &problem.robot.parameters {
        robot.insert("parameters".to_string(), path(file));
    }
    let recordings = problem.recordings.as_ref()?;
    let written = table.get_mut("recordings")?.as_object_mut()?;
    for (key, listed) in [
        ("train", &recordings.train),
        ("loaded", &recordings.loaded),
        ("validation", &recordings.validation),
        ("simulated", &recordings.simulated),
    ] {
        if let Some(Value::Array(entries)) = written.get_mut(key) {
            for (entry, recording) in entries.iter_mut().zip(listed) {
                let mut files = recording.files.iter().map(|file| path(&file.path));
                whole_paths(entry, &mut files);
            }
        }
    }
    Some(table.clone())
}

/// A model as `[[design.rival]]` has it: effects by joint, and the values to which it was fitted.
fn rival(fit: &ModelFit, name: &str) -> Value {
    let joints = fit.model.joints().iter().enumerate();
    let effects: Map<String, Value> = joints
        .filter(|(_, joint)| !joint.locked)
        .map(|(j, joint)| {
            let mut ids: Vec<&str> = joint.effects.iter().map(|(e, _)| e.id).collect();
            ids.extend(beside_own_laws(&fit.model, j));
            (joint.name.clone(), json!(ids))
        })
        .collect();
    let free = fit.model.parameters().iter().enumerate();
    let values: Map<String, Value> = free
        .filter(|(_, p)| p.is_free())
        .map(|(k, p)| (p.name.clone(), json!(fit.values[k])))
        .collect();
    json!({ "name": name, "effects_of": effects, "values": values })
}

/// The effects of a joint that are no laws of its own: those that it has with others, with which ones is in the names of their values; a
/// load that it carries, and the tilt of the base, which every joint has.
fn beside_own_laws(model: &Model, joint: usize) -> Vec<&'static str> {
    let roles = || model.parameters().iter().map(|p| p.role);
    let hears = |role: Role| matches!(role, Role::Crosstalk(heard) if heard.channel == joint);
    let is_moved = |role: Role| matches!(role, Role::Coupling { row, .. } if row == joint);
    let carries = model.payload().is_some_and(|(load, _)| load.link == joint);
    let all = [
        (roles().any(hears), CROSSTALK),
        (roles().any(is_moved), COUPLING),
        (carries, LOAD),
        (model.tilt().is_some(), TILT),
    ];
    let there = all.into_iter().filter(|(is_there, _)| *is_there);
    there.map(|(_, effect)| effect.id).collect()
}

fn without_nulls(value: &Value) -> Value {
    match value {
        Value::Object(table) => {
            let kept = table.iter().filter(|(_, v)| !v.is_null());
            Value::Object(kept.map(|(k, v)| (k.clone(), without_nulls(v))).collect())
        }
        Value::Array(items) => Value::Array(items.iter().map(without_nulls).collect()),
        other => other.clone(),
    }
}
