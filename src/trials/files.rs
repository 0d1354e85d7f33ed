//! The files of a trial: the robot, the declared problem with its recordings, the same without noise, and the truth.

use crate::chain::effect;
use crate::chain::effect::knowledge::Trial;
use crate::chain::effect::{EFFECTS, Effect};
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::simulate::sensors::Table;
use crate::simulate::{self, Simulated, SimulatedRecording, write_csv};
use crate::trials::error::TrialError;
use crate::trials::outside_law::LAW;
use crate::trials::plan::{Plan, RATE};
use crate::trials::robot::ENCODER_COUNTS;
use crate::trials::unmodelled_physics::{Unmodelled, UnmodelledTorque};
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// The declared problem in the folder of a trial.
pub const PROBLEM: &str = "problem.toml";

/// The truth behind the recordings in it, as a problem for `exid simulate`.
const TRUTH: &str = "truth.toml";

/// The folder in it with the same problem and recordings without noise.
pub const CLEAN: &str = "clean";

/// The recording that is fitted.
const TRAIN: &str = "train.csv";

/// The recording of a larger motion, and what was commanded for it.
const LARGER: &str = "larger.csv";
const COMMANDED: &str = "commanded.csv";

/// The amplitude of the larger motion over that of the fitted one.
pub const AMPLITUDE: f64 = 1.3;

/// Writes everything of a trial into an empty folder: the robot, the declared problem with its recordings, the
/// same without noise, and the truth as a problem for `exid simulate`.
pub fn prepare(plan: &Plan, folder: &Path, control: &Control<'_>) -> Result<Simulated, TrialError> {
    let period = plan.length.period;
    let recordings = [TRAIN, "validation.csv"];
    let stated = plan.motion.states_period().then_some(period);
    let declared = declared(plan, stated, recordings);
    let clean = folder.join(CLEAN);
    fs::create_dir(&clean)?;
    for own in [folder, &clean] {
        fs::write(own.join("robot.urdf"), plan.robot.urdf())?;
        fs::write(own.join(PROBLEM), &declared)?;
    }
    let path = folder.join(TRUTH);
    let repeating = plan.motion.repeats().then_some(period);
    let repeating = self::declared(plan, repeating, recordings);
    let simulated = simulated(plan, plan.motion.trajectory());
    fs::write(&path, format!("{repeating}\n{simulated}"))?;
    let truth = ProblemFile::read(&path, &[], &effect::ids())?;
    let made = simulate::run(&truth, plan.simulation, control)?;
    let law = beyond_vocabulary(plan, &made);
    write(&made.recordings, law, folder)?;
    write(&without_noise(&made), law, &clean)?;
    Ok(made)
}

/// Writes a problem into a new folder within that of a trial: it has the training recording of the trial, and for validation one
/// without noise of the same motion with [`AMPLITUDE`] times the amplitude.
pub fn prepare_larger(
    plan: &Plan,
    made: &Simulated,
    trial: &Path,
    control: &Control<'_>,
) -> Result<PathBuf, TrialError> {
    let folder = trial.join("larger");
    fs::create_dir(&folder)?;
    let period = plan.length.period;
    if let Some(trajectory) = made.trajectories.first() {
        let commanded = enlarged(trajectory);
        let file = File::create(folder.join(COMMANDED))?;
        write_csv(BufWriter::new(file), &commanded)?;
    }
    fs::write(folder.join("robot.urdf"), plan.robot.urdf())?;
    let repeating = plan.motion.repeats().then_some(period);
    let repeating = declared(plan, repeating, [LARGER, LARGER]);
    let path = folder.join(TRUTH);
    fs::write(
        &path,
        format!("{repeating}\n{}", simulated(plan, COMMANDED)),
    )?;
    let truth = ProblemFile::read(&path, &[], &effect::ids())?;
    let larger = simulate::run(&truth, plan.simulation, control)?;
    write(&without_noise(&larger), None, &folder)?;
    fs::copy(trial.join(TRAIN), folder.join(TRAIN))?;
    let stated = plan.motion.states_period().then_some(period);
    let problem = folder.join(PROBLEM);
    fs::write(&problem, declared(plan, stated, [TRAIN, LARGER]))?;
    Ok(problem)
}

fn without_noise(made: &Simulated) -> Vec<SimulatedRecording> {
    let mut noiseless = made.recordings.clone();
    for recording in &mut noiseless {
        recording.remove_noise(&made.realised_noise);
    }
    noiseless
}

/// The motion of a trajectory with another amplitude about the mean of each joint.
fn enlarged(trajectory: &SimulatedRecording) -> SimulatedRecording {
    let mut larger = trajectory.clone();
    let Table { header, data } = &mut larger.table;
    for (_, series) in header.iter().zip(data).filter(|(h, _)| h.starts_with("q_")) {
        let mean = series.iter().sum::<f64>() / series.len().max(1) as f64;
        series
            .iter_mut()
            .for_each(|q| *q = mean + AMPLITUDE * (*q - mean));
    }
    larger
}

/// The declared model with its recordings for training and validation, with their period or without.
fn declared(plan: &Plan, period: Option<f64>, [train, validation]: [&str; 2]) -> String {
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
    let laws = match plan.laws.is_empty() {
        true => String::new(),
        false => format!("laws = {:?}\n", plan.laws),
    };
    let is_declared = |effect: &&&Effect| matches!(effect.knowledge.trial, Trial::Declared);
    let declared = EFFECTS.iter().filter(is_declared);
    let effects: Vec<&str> = declared.map(|effect| effect.id).collect();
    format!(
        "name = \"trial\"\n{laws}[robot]\nurdf = \"robot.urdf\"\ninertials = \"{inertials}\"\n[drive]\n\
         torque_constant = {:?}\n{rotors}effects = {:?}\n\
         [recordings]\ntrain = [\"{train}\"]\nvalidation = [\"{validation}\"]\nsignal = \"current\"\n\
         rate = {RATE:?}\n{period}",
        robot.torque_constant, effects
    )
}

/// How the recordings of a trajectory are made, and the truth behind them.
fn simulated(plan: &Plan, trajectory: &str) -> String {
    let robot = &plan.robot;
    let mut text = format!(
        "[design]\nperiod = {:?}\n[simulate]\ntrajectory = \"{trajectory}\"\nmode = \"closed_loop\"\nperiods = {}\n\
         warmup_periods = 1\nnoise = {:?}\nnoise_correlation = {:?}\nencoder_counts = {ENCODER_COUNTS:?}\n\
         [simulate.values]\n",
        plan.length.period, plan.length.periods, robot.noise, plan.correlation
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
    if let Some(law) = &plan.law {
        let joint = robot.name(law.joint);
        for (name, value) in law.parameters(robot) {
            text.push_str(&format!("\"{joint}.{LAW}.{name}\" = {value:?}\n"));
        }
        text.push_str(&law.table(robot));
    }
    text
}

/// What the robot has beyond the vocabulary, of its size in the first recording.
fn beyond_vocabulary(plan: &Plan, made: &Simulated) -> Option<UnmodelledTorque> {
    let Unmodelled { law, at, share } = plan.outside?;
    let current = plan.robot.torque[at.joint] / plan.robot.torque_constant[at.joint];
    let first = made.recordings.first()?;
    UnmodelledTorque::of_size(law, at, &first.table, share * current, RATE)
}

/// Writes recordings, with a law beyond the vocabulary where there is one.
fn write(
    recordings: &[SimulatedRecording],
    law: Option<UnmodelledTorque>,
    folder: &Path,
) -> Result<(), TrialError> {
    for recording in recordings {
        let mut recording = recording.clone();
        if let Some(law) = law {
            law.add_to(&mut recording.table);
        }
        let file = File::create(folder.join(&recording.name))?;
        write_csv(BufWriter::new(file), &recording)?;
    }
    Ok(())
}
