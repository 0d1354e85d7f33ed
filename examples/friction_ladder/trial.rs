//! One truth and one seed: recordings, the fit by the right law beside the others, and who predicts best.

use crate::Outcome;
use crate::law::LAWS;
use exid::estimate::task;
use exid::problem::solution::Control;
use exid::problem_file::ProblemFile;
use exid::simulate::{self, write_csv};
use std::fs::{self, File};
use std::path::Path;

/// Name of the law that the fit itself has, in its contests.
const RIGHT: &str = "this fit";

/// What the comparison said.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    Right,
    /// Cannot tell, and the right law is among those that may be it.
    Open,
    /// Cannot tell, and it is not.
    OpenWithoutRight,
    Wrong,
}

/// One run.
pub struct Trial {
    pub truth: usize,
    pub verdict: Verdict,
    /// Held-out error of the nearest rival in deviations of the right law's.
    pub nearest: f64,
    /// Parameters of the right law in the paper's sense, and those whose 95 % interval holds the truth.
    pub parameters: usize,
    pub held: usize,
}

pub fn run(problem: &Path, folder: &Path, (truth, seed): (usize, u64)) -> Outcome<Trial> {
    let law = &LAWS[truth];
    let effects = format!("drive.effects={}", law.list());
    let values: Vec<String> = law
        .values()
        .iter()
        .map(|(name, value)| format!("{name:?}={value}"))
        .collect();
    let simulated = open(
        problem,
        &[
            effects.clone(),
            "simulate.trajectory=\"random\"".to_string(),
            "simulate.periods=3".to_string(),
            "simulate.noise=[0.1,0.1,0.1,0.1,0.04,0.04,0.04]".to_string(),
            format!("simulate.values={{{}}}", values.join(",")),
        ],
    )?;
    let made = simulate::run(&simulated, 1000 * truth as u64 + seed, &Control::default())?;
    let own = folder.join(format!("{truth}-{seed}"));
    fs::create_dir_all(&own)?;
    let mut overrides = vec![effects, compared(truth)];
    for (key, recording) in ["train", "validation"].iter().zip(&made.recordings) {
        let path = own.join(&recording.name);
        write_csv(File::create(&path)?, recording)?;
        overrides.push(format!(
            "recordings.{key}=[{:?}]",
            path.display().to_string()
        ));
    }
    let fitted = task::run(&open(problem, &overrides)?, &Control::default(), |_| {})?.fitted;
    fs::remove_dir_all(&own)?;
    let together = fitted.fit.contests.last().ok_or("no contest")?;
    let errors = together.models.iter().map(|m| m.judged().value);
    let errors: Vec<f64> = errors.collect();
    let rival = errors[1..].iter().copied().fold(f64::INFINITY, f64::min);
    let (mut parameters, mut held) = (0, 0);
    for (name, value) in law.values() {
        let found = fitted.estimate.parameters.iter().find(|p| p.name == name);
        if let Some([low, high]) = found.and_then(|p| p.ci95) {
            parameters += 1;
            held += usize::from((low..=high).contains(&value));
        }
    }
    Ok(Trial {
        truth,
        verdict: verdict(together.best.as_deref(), &together.level),
        nearest: ((rival / errors[0]).powi(2) - 1.0).max(0.0).sqrt(),
        parameters,
        held,
    })
}

fn open(problem: &Path, overrides: &[String]) -> Outcome<ProblemFile> {
    let ids = exid::chain::effect::ids();
    Ok(ProblemFile::read(problem, overrides, &ids)?)
}

/// The other laws, and none, as `[[fit.compare]]`.
fn compared(truth: usize) -> String {
    let others = LAWS.iter().enumerate().filter(|(k, _)| *k != truth);
    let entry = |(_, law): (usize, &crate::law::Law)| {
        format!("{{name={:?},effects={}}}", law.name, law.list())
    };
    let mut list: Vec<String> = others.map(entry).collect();
    list.push("{name=\"none\",effects=[]}".to_string());
    format!("fit.compare=[{}]", list.join(","))
}

fn verdict(best: Option<&str>, level: &[String]) -> Verdict {
    match best {
        Some(RIGHT) => Verdict::Right,
        Some(_) => Verdict::Wrong,
        None if level.iter().any(|name| name == RIGHT) => Verdict::Open,
        None => Verdict::OpenWithoutRight,
    }
}
