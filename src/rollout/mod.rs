//! Forward simulation of the models of a result beside held-out recordings.
//!
//! From each of many starts along a recording, the motion under the recorded torques is integrated in open loop,
//!
//! ```text
//! e(T) = q_model(t + T) − q(t + T),    q_model(t), q̇_model(t) those of the recording, T up to 2 s
//! ```
//!
//! by the model before and after, and by the final model under its own torques with the noise of the signal, from a start
//! with the errors of the estimated motion: what the noise alone would make of a model that is right. Where the recordings hold
//! commands of position controllers, the loop is closed: the identified controllers act on what they are told and on where
//! the model is, and `e` is what it then strays by. What lags behind a
//! motor and bristles begin where they come to along the recorded motion before the start.

pub mod candidate;
pub mod error;
pub mod error_statistics;
pub mod model_run;
mod noise;
mod simulated_windows;
mod summary;
mod task;
mod window;

use crate::chain::dataset::Dataset;
use crate::diagnose::fit::held_out;
use crate::estimate::bandwidth::Preparing;
use crate::outcome::Part;
use crate::outcome::rollout::HeldOutRows;
use crate::problem::solution::Control;
use crate::recording::split::Split;
use crate::rollout::candidate::Candidates;
use crate::rollout::error::RolloutError;
pub use crate::rollout::simulated_windows::HORIZONS;
use crate::rollout::simulated_windows::SimulatedWindows;
use crate::rollout::summary::Summary;
pub use crate::rollout::task::{RolloutRun, Task};
pub use crate::rollout::window::{Window, WindowJoint, table};
use crate::setup;
use crate::setup::error::SetupError;
use crate::setup::model_spec::ModelSpec;
use crate::setup::recording_file::RecordedRobot;

/// Rolls the models of a result out; `on_step` hears of every step.
///
/// # Errors
/// A result without a model; files that cannot be read; a model without forward dynamics; recordings that are too short; an
/// interrupt.
pub fn run(
    task: Task<'_>,
    control: &Control<'_>,
    on_step: &dyn Fn(&str),
) -> Result<RolloutRun, RolloutError> {
    let problem = task.problem;
    let robot = setup::robot::open(problem)?;
    let candidates = Candidates::of(task.outcome, problem, &robot)?;
    on_step("reading and differentiating the recordings");
    let declared = ModelSpec::of(problem, &robot)?.build()?;
    let preparing = Preparing {
        recorded: RecordedRobot {
            table: problem.recordings().map_err(SetupError::from)?,
            robot: &robot,
            model: &declared.model,
        },
        prior: &declared.prior,
        control,
    };
    let data = preparing.prepared()?;
    on_step("simulating forward");
    simulated(task, &candidates, data, control)
}

/// The same over recordings that a diagnosis has prepared.
///
/// # Errors
/// As [`run`].
pub fn over_prepared(
    task: Task<'_>,
    data: Dataset,
    control: &Control<'_>,
) -> Result<RolloutRun, RolloutError> {
    let robot = setup::robot::open(task.problem)?;
    let candidates = Candidates::of(task.outcome, task.problem, &robot)?;
    simulated(task, &candidates, data, control)
}

fn simulated(
    task: Task<'_>,
    candidates: &Candidates,
    data: Dataset,
    control: &Control<'_>,
) -> Result<RolloutRun, RolloutError> {
    let (data, held_out) = held_out_part(data, &task.outcome.part);
    let rolled = data
        .recordings
        .iter()
        .enumerate()
        .map(|(number, recording)| {
            SimulatedWindows::of(candidates, number, recording, task.seed, control)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let rolled: Vec<SimulatedWindows<'_>> = rolled.into_iter().flatten().collect();
    if rolled.is_empty() {
        let seconds = HORIZONS[0];
        return Err(RolloutError::NoWindow { seconds });
    }
    Summary {
        task,
        candidates,
        held_out,
        rolled: &rolled,
    }
    .run()
}

/// The recordings of the windows.
fn held_out_part(data: Dataset, part: &Part) -> (Dataset, HeldOutRows) {
    let of = |data: &Dataset, split: Split| Dataset {
        recordings: data.of(split).cloned().collect(),
    };
    if data.of(Split::Validation).next().is_some() {
        return (of(&data, Split::Validation), HeldOutRows::Validation);
    }
    match part {
        Part::Diagnose(_) => {
            let (blocks, _) = held_out::with_held_out(data);
            (of(&blocks, Split::Validation), HeldOutRows::Blocks)
        }
        _ => (data, HeldOutRows::Train),
    }
}
