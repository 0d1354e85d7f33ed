//! The files of a trial: the robot, the declared problem with its recordings, the same without noise, and the truth.

use crate::chain::effect;
use crate::chain::effect::knowledge::Trial;
use crate::chain::effect::{EFFECTS, Effect};
use crate::problem::solution::Control;
use crate::problem_file::ProblemFile;
use crate::simulate::{self, Simulated, SimulatedRecording, write_csv};
use crate::trials::error::TrialError;
use crate::trials::plan::{Plan, RATE};
use crate::trials::robot::ENCODER_COUNTS;
use crate::trials::unmodelled_physics::{Unmodelled, UnmodelledTorque};
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;

/// The declared problem in the folder of a trial.
pub const PROBLEM: &str = "problem.toml";

/// The truth behind the recordings in it, as a problem for `exid simulate`.
const TRUTH: &str = "truth.toml";

/// The folder in it with the same problem and recordings without noise.
pub const CLEAN: &str = "clean";

/// Writes everything of a trial into an empty folder: the robot, the declared problem with its recordings, the
/// same without noise, and the truth as a problem for `exid simulate`.
pub fn prepare(plan: &Plan, folder: &Path, control: &Control<'_>) -> Result<(), TrialError> {
    let period = plan.length.period;
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
    let law = beyond_vocabulary(plan, &made);
    write(&made.recordings, law, folder)?;
    let mut noiseless = made.recordings.clone();
    for recording in &mut noiseless {
        recording.remove_noise(&made.realised_noise);
    }
    write(&noiseless, law, &clean)
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
         [recordings]\ntrain = [\"train.csv\"]\nvalidation = [\"validation.csv\"]\nsignal = \"current\"\n\
         rate = {RATE:?}\n{period}",
        robot.torque_constant, effects
    )
}

/// How the recordings are made, and the truth behind them.
fn simulated(plan: &Plan) -> String {
    let robot = &plan.robot;
    let mut text = format!(
        "[design]\nperiod = {:?}\n[simulate]\ntrajectory = \"{}\"\nmode = \"closed_loop\"\nperiods = {}\n\
         warmup_periods = 1\nnoise = {:?}\nnoise_correlation = {:?}\nencoder_counts = {ENCODER_COUNTS:?}\n\
         [simulate.values]\n",
        plan.length.period,
        plan.motion.trajectory(),
        plan.length.periods,
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
