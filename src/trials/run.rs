//! One trial: the robot is simulated, its recordings written, diagnosed, and judged.

use crate::chain::dataset::Dataset;
use crate::chain::effect;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::fitting::fit_model;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::fit::start::{Start, WarmStart};
use crate::diagnose::residuals::standstill;
use crate::diagnose::selection::between_periods::unrolled;
use crate::diagnose::task::{self, DiagnoseRun};
use crate::estimate::bandwidth;
use crate::outcome::trials::Trial;
use crate::problem::defect::guarded;
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::recording::split::Split;
use crate::setup;
use crate::simulate::{self, Simulated, write_csv};
use crate::stats::deviation::rms;
use crate::trials::conceal::Concealed;
use crate::trials::error::TrialError;
use crate::trials::outside::Added;
use crate::trials::plan::{Plan, RATE, Scope};
use crate::trials::robot::ENCODER_COUNTS;
use crate::trials::{longer, score};
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;
use std::time::Instant;

/// Draws of a trial until a robot can follow its motion.
const ATTEMPTS: u64 = 8;

/// Runs one trial; a failure is an answer too.
pub fn run(scope: &Scope, number: u64, control: &Control<'_>) -> Trial {
    attempts(scope, number, |plan| {
        let scratch = tempfile::tempdir()?;
        one(plan, scratch.path(), control)
    })
}

/// Runs one trial and leaves its files, and what it came to, in `folder`, which is made.
///
/// # Errors
/// The folder exists, or cannot be written.
pub fn run_in(
    scope: &Scope,
    number: u64,
    (folder, control): (&Path, &Control<'_>),
) -> Result<Trial, std::io::Error> {
    fs::create_dir(folder)?;
    let trial = attempts(scope, number, |plan| {
        fs::remove_dir_all(folder)?;
        fs::create_dir(folder)?;
        one(plan, folder, control)
    });
    fs::write(folder.join(JUDGED), serde_json::to_string_pretty(&trial)?)?;
    Ok(trial)
}

/// Draws a trial until its robot can follow its motion, and runs it.
fn attempts(
    scope: &Scope,
    number: u64,
    mut one: impl FnMut(&Plan) -> Result<Trial, TrialError>,
) -> Trial {
    let started = Instant::now();
    let mut trial = Trial::default();
    for attempt in 0..ATTEMPTS {
        let plan = Plan::draw(scope, (number, attempt));
        match guarded(|| one(&plan)).unwrap_or_else(|defect| Err(defect.into())) {
            Ok(done) => {
                trial = done;
                break;
            }
            Err(error) => {
                let could_not_move = matches!(&error, TrialError::Simulate(e) if !e.is_interrupt());
                trial = score::failed(&plan, error.to_string());
                if !could_not_move {
                    break;
                }
            }
        }
    }
    trial.seconds = started.elapsed().as_secs_f64();
    trial
}

fn one(plan: &Plan, folder: &Path, control: &Control<'_>) -> Result<Trial, TrialError> {
    prepare(plan, folder, control)?;
    let problem = folder.join(PROBLEM);
    let diagnosed = {
        let read = ProblemFile::read(&problem, &[], &effect::ids())?;
        task::run(&read, control, &|_| ())?
    };
    let sizes = sizes(plan, &folder.join(CLEAN).join(PROBLEM), control)?;
    let informed = informed(plan, &problem, control)?;
    let mut trial = score::judge(plan, (&diagnosed, informed.as_ref()), &sizes);
    let longer = folder.join(LONGER_FOLDER);
    longer::judge(
        plan,
        &diagnosed.ambiguities,
        &mut trial.found,
        &longer,
        control,
    )?;
    Ok(trial)
}

/// The declared problem in the folder of a trial.
pub const PROBLEM: &str = "problem.toml";

/// The truth behind the recordings in it, as a problem for `exid simulate`.
const TRUTH: &str = "truth.toml";

/// The folder in it with the same problem and recordings without noise.
pub const CLEAN: &str = "clean";

/// What the trial came to, in a folder that is kept.
const JUDGED: &str = "trial.json";

/// The folder in it with longer recordings.
const LONGER_FOLDER: &str = "longer";

/// Writes everything of a trial into an empty folder: the robot, the declared problem with its recordings, the
/// same without noise, and the truth as a problem for `exid simulate`.
pub fn prepare(plan: &Plan, folder: &Path, control: &Control<'_>) -> Result<(), TrialError> {
    let period = plan.course.period;
    let declared = declared(plan, plan.motion.states_period().then_some(period));
    let clean = folder.join(CLEAN);
    fs::create_dir(&clean)?;
    for own in [folder, &clean] {
        fs::write(own.join("robot.urdf"), plan.robot.urdf())?;
        fs::write(own.join(PROBLEM), &declared)?;
    }
    let path = folder.join(TRUTH);
    let repeating = self::declared(plan, plan.motion.repeats().then_some(period));
    fs::write(&path, format!("{repeating}\n{}", simulated(plan)))?;
    let truth = ProblemFile::read(&path, &[], &effect::ids())?;
    let made = simulate::run(&truth, plan.simulation, control)?;
    write(plan, &made, (folder, true))?;
    write(plan, &made, (&clean, false))
}

/// The declared model and its recordings, with their period or without.
fn declared(plan: &Plan, period: Option<f64>) -> String {
    let robot = &plan.robot;
    let inertials = if plan.known_links {
        "known"
    } else {
        "estimate"
    };
    let rotors = match plan.known_rotors {
        true => format!("rotor_inertia = {:?}\n", robot.rotor_inertia),
        false => String::new(),
    };
    let period = period.map_or(String::new(), |seconds| format!("period = {seconds:?}\n"));
    format!(
        "name = \"trial\"\n[robot]\nurdf = \"robot.urdf\"\ninertials = \"{inertials}\"\n[drive]\n\
         torque_constant = {:?}\n{rotors}effects = [\"coulomb_friction\", \"viscous_friction\"]\n\
         [recordings]\ntrain = [\"train.csv\"]\nvalidation = [\"validation.csv\"]\nsignal = \"current\"\n\
         rate = {RATE:?}\n{period}",
        robot.torque_constant
    )
}

/// How the recordings are made, and the truth behind them.
fn simulated(plan: &Plan) -> String {
    let robot = &plan.robot;
    let mut text = format!(
        "[design]\nperiod = {:?}\n[simulate]\ntrajectory = \"{}\"\nmode = \"closed_loop\"\nperiods = {}\n\
         warmup_periods = 1\nnoise = {:?}\nnoise_correlation = {:?}\nencoder_counts = {ENCODER_COUNTS:?}\n\
         [simulate.values]\n",
        plan.course.period,
        plan.motion.trajectory(),
        plan.course.periods,
        robot.noise,
        plan.correlation
    );
    for (j, [dry, viscous]) in robot.friction.iter().enumerate() {
        let name = robot.name(j);
        text.push_str(&format!(
            "\"{name}.Fc\" = {dry:?}\n\"{name}.Fv\" = {viscous:?}\n"
        ));
    }
    for (name, value) in plan.concealed.iter().flat_map(|c| &c.values) {
        text.push_str(&format!("\"{name}\" = {value:?}\n"));
    }
    text
}

/// Writes the recordings with or without noise, with the law outside the vocabulary where there is one.
fn write(plan: &Plan, made: &Simulated, (folder, noisy): (&Path, bool)) -> Result<(), TrialError> {
    let law = plan.outside.and_then(|(law, joints, share)| {
        let current = plan.robot.torque[joints.0] / plan.robot.torque_constant[joints.0];
        let first = made.recordings.first()?;
        Added::of_size((law, joints), &first.table, (share * current, RATE))
    });
    for recording in &made.recordings {
        let mut recording = recording.clone();
        if !noisy {
            recording.remove_noise(&made.realised_noise);
        }
        if let Some(law) = law {
            law.add_to(&mut recording.table);
        }
        let file = File::create(folder.join(&recording.name))?;
        write_csv(BufWriter::new(file), &recording)?;
    }
    Ok(())
}

/// What is left of the concealed physics, per joint: held-out RMS over the noise of a row, of periods that are averaged,
/// where there are any, and of single samples.
#[derive(Debug, Clone, Default)]
pub struct Sizes {
    pub averaged: Vec<f64>,
    pub in_time: Vec<f64>,
}

fn sizes(plan: &Plan, problem: &Path, control: &Control<'_>) -> Result<Sizes, TrialError> {
    let opened = Opened::read(problem, control)?;
    let of = |data: &Dataset, periods: f64| -> Result<Vec<f64>, TrialError> {
        let left = opened.fit(data, &[], &Start::new(), control)?.validation;
        let pairs = left.iter().zip(&plan.robot.noise);
        Ok(pairs
            .map(|(e, noise)| rms(e) * periods.sqrt() / noise)
            .collect())
    };
    let averaged = match plan.motion.repeats() {
        true => plan.course.periods as f64,
        false => 1.0,
    };
    Ok(Sizes {
        averaged: of(&opened.data, averaged)?,
        in_time: match plan.concealed.iter().any(Concealed::changes_with_time) {
            true => of(&unrolled(&opened.data), 1.0)?,
            false => Vec::new(),
        },
    })
}

/// Fits of a declared model with the truth in it: what a diagnosis could reach.
pub struct Informed {
    pub declared: ModelFit,
    pub known: ModelFit,
}

fn informed(
    plan: &Plan,
    problem: &Path,
    control: &Control<'_>,
) -> Result<Option<Informed>, TrialError> {
    if plan.concealed.is_empty() {
        return Ok(None);
    }
    let opened = Opened::read(problem, control)?;
    let data = match plan.concealed.iter().any(Concealed::changes_with_time) {
        true => unrolled(&opened.data),
        false => opened.data.clone(),
    };
    let start: Start = plan
        .concealed
        .iter()
        .flat_map(|c| c.values.clone())
        .collect();
    let truth = plan.concealed.iter().map(|c| c.hypothesis.clone());
    let hypotheses: Vec<Hypothesis> = truth.collect();
    Ok(Some(Informed {
        declared: opened.fit(&data, &[], &Start::new(), control)?,
        known: opened.fit(&data, &hypotheses, &start, control)?,
    }))
}

/// A declared model with its recordings.
pub struct Opened {
    problem: ProblemFile,
    robot: setup::robot::Robot,
    pub data: Dataset,
}

impl Opened {
    pub fn read(path: &Path, control: &Control<'_>) -> Result<Self, TrialError> {
        let problem = ProblemFile::read(path, &[], &effect::ids())?;
        let robot = setup::robot::open(&problem)?;
        let mut model = setup::model::build(&problem, &robot)?;
        let prior = setup::prior::build(&problem, &robot, &mut model)?;
        let prepared = bandwidth::prepared(&problem, &robot, &model, &prior, control)?;
        let data = standstill::left_out(&model, prepared);
        Ok(Self {
            problem,
            robot,
            data,
        })
    }

    pub fn context<'b>(&'b self, data: &'b Dataset, control: &'b Control<'b>) -> Context<'b> {
        Context::new(&self.problem, &self.robot, data, control)
    }

    pub fn fit(
        &self,
        data: &Dataset,
        hypotheses: &[Hypothesis],
        start: &Start,
        control: &Control<'_>,
    ) -> Result<ModelFit, TrialError> {
        let context = self.context(data, control);
        let from = WarmStart {
            values: start.clone(),
            deviations: context.signal_rms(Split::Train),
        };
        Ok(fit_model(&context, hypotheses, &from)?)
    }
}

/// The parameters that a diagnosis came to, by name.
pub fn values(run: &DiagnoseRun) -> impl Iterator<Item = (&str, f64)> {
    let all = run.diagnosis.outcome.parameters.iter();
    all.filter_map(|p| Some((p.name.as_str(), p.value?)))
}
