//! The user's simulator beside the robot: both are identified from the declared model, each from its own recordings, and compared.
//!
//! ```text
//! d_k = b_k(robot) − b_k(simulator),   Var d_k = Var b_k(robot) + Var b_k(simulator)
//! ```
//!
//! for every combination b_k of parameters that both determine. p-values are corrected by Holm's method (1979), intervals by
//! Bonferroni's. A simulator has no noise: its variances are those of a model that leaves a coloured error, the lack of fit of
//! the simulator's numbers (its integration, the rounding of its file), by the same sandwich as for noise.

mod contrast;
mod one_sided;
mod sentences;
mod side;
mod subject;

pub use side::Side;

use crate::diagnose::simulator::contrast::{LEVEL, contrasts};
use crate::diagnose::simulator::one_sided::sort;
use crate::outcome::simulator::Simulator;

/// Compares a simulator with the robot.
pub fn compare(simulator: &Side<'_>, robot: &Side<'_>) -> Simulator {
    let contrasts = contrasts(simulator, robot);
    let compared = contrasts.len();
    let sorted = sort(contrasts, simulator, robot);
    let mut differences = sorted.differences;
    differences.sort_by(|a, b| b.share_of_signal.total_cmp(&a.share_of_signal));
    let mut result = Simulator {
        summary: String::new(),
        parameters: simulator.estimate.parameters.clone(),
        joints: simulator.estimate.joints.clone(),
        findings: simulator.findings.to_vec(),
        differences,
        only_robot: sorted.only_robot,
        only_simulator: sorted.only_simulator,
        agree: sorted.agree,
        compared,
        level: LEVEL,
        notes: sorted.notes,
    };
    result.summary = sentences::summary(&result);
    result
}
