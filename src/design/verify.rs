//! Verification: the margins of a motion to every limit, on a grid many times finer than that of the design.
//!
//! Position, velocity, acceleration and jerk are kept between instants by a bound (see
//! [`crate::design::constraints::joint_limits`]); torques and workspace are not series of low degree, so for them the dense
//! grid decides.

use nalgebra::DVector;

use crate::design::constraints::joint_limits::Band;
use crate::design::problem::Experiment;
use crate::design::trajectory::fourier_series::{Basis, ORDERS};
use crate::design::trajectory::motion::{Joints, MOTION, Motion};
use crate::robot::tree::JointKind;

/// How many times finer than the design's the grid is.
pub const FINER: usize = 50;

/// Violation up to which a design counts as feasible: 0.1 % of a limit.
pub const TOLERANCE: f64 = 1e-3;

/// The least margin of one limit over all trajectories.
#[derive(Debug, Clone, PartialEq)]
pub struct Margin {
    /// position, velocity, acceleration, jerk, torque, or the name of a workspace rule.
    pub constraint: String,
    /// Joint, where the limit is one of a joint.
    pub joint: Option<String>,
    /// Trajectory, from 1.
    pub trajectory: usize,
    /// s within the period.
    pub time: f64,
    /// Distance to the limit, negative beyond it, in the limit's unit.
    pub margin: f64,
    /// The same as a share of the limit (of half the range for positions).
    pub relative: f64,
    /// The limit that is nearest.
    pub limit: f64,
    /// Of margin and limit.
    pub unit: String,
}

/// Names of the derivatives of position.
const ORDER_NAMES: [&str; ORDERS] = ["position", "velocity", "acceleration", "jerk"];

/// The margins of every limit of a design.
pub fn margins(experiment: &Experiment<'_>, x: &DVector<f64>) -> Vec<Margin> {
    margins_of(experiment, &experiment.joints, x)
}

/// The margins of another motion of the same joints.
pub fn margins_of(experiment: &Experiment<'_>, joints: &Joints, x: &DVector<f64>) -> Vec<Margin> {
    let basis = Basis::new(joints.series, FINER * experiment.basis.samples);
    let mut all = of_series(experiment, joints, &basis, x);
    let mut rest = Vec::new();
    let single = joints.single();
    for trajectory in 0..joints.trajectories {
        let first = trajectory * joints.of_trajectory();
        let own = x.rows(first, joints.of_trajectory()).into_owned();
        let motion = Motion::of(&single, &basis, &own);
        rest.push(of_dynamics(experiment, &motion, basis.step(), trajectory));
    }
    // The worst of all trajectories, limit by limit.
    let mut rest = rest.into_iter();
    if let Some(mut worst) = rest.next() {
        for others in rest {
            for (one, other) in worst.iter_mut().zip(others) {
                if other.relative < one.relative {
                    *one = other;
                }
            }
        }
        all.extend(worst);
    }
    all
}

/// The largest violation as a share of its limit; zero where every limit holds.
pub fn violation(margins: &[Margin]) -> f64 {
    margins.iter().map(|m| -m.relative).fold(0.0, f64::max)
}

/// The margins at the samples of a motion, `step` seconds apart: of torque and workspace, and of position,
/// velocity and acceleration.
pub fn of_samples(experiment: &Experiment<'_>, motion: &Motion, step: f64) -> Vec<Margin> {
    let joints = &experiment.joints;
    let model = experiment.observation.model();
    let mut all = Vec::new();
    for order in 0..MOTION {
        for &j in &joints.moving {
            let Some(band) = Band::of_order(&experiment.bounds[j], order) else {
                continue;
            };
            let joint = &model.tree().joints()[j];
            let series = &motion.values[order][j];
            let least = Least::of(series.iter().map(|value| band.margin(*value)));
            all.push(Margin {
                constraint: ORDER_NAMES[order].to_string(),
                joint: Some(joint.name.clone()),
                trajectory: 0,
                time: least.sample as f64 * step,
                margin: least.value,
                relative: least.value / band.half_width,
                limit: band.nearer_end(series[least.sample]),
                unit: unit(joint.kind, order),
            });
        }
    }
    all.extend(of_dynamics(experiment, motion, step, 0));
    all
}

fn of_series(
    experiment: &Experiment<'_>,
    joints: &Joints,
    basis: &Basis,
    x: &DVector<f64>,
) -> Vec<Margin> {
    let model = experiment.observation.model();
    let mut all = Vec::new();
    let mut values = vec![0.0; basis.samples];
    for order in 0..ORDERS {
        for (m, &j) in joints.moving.iter().enumerate() {
            let Some(band) = Band::of_order(&experiment.bounds[j], order) else {
                continue;
            };
            let joint = &model.tree().joints()[j];
            let mut worst: Option<Margin> = None;
            for trajectory in 0..joints.trajectories {
                let own = joints.coefficients_of(x, trajectory, m);
                basis.evaluate(order, own, &mut values);
                for (k, value) in values.iter().enumerate() {
                    let margin = band.margin(*value);
                    if worst.as_ref().is_none_or(|w| margin < w.margin) {
                        worst = Some(Margin {
                            constraint: ORDER_NAMES[order].to_string(),
                            joint: Some(joint.name.clone()),
                            trajectory,
                            time: k as f64 * basis.step(),
                            margin,
                            relative: margin / band.half_width,
                            limit: band.nearer_end(*value),
                            unit: unit(joint.kind, order),
                        });
                    }
                }
            }
            all.extend(worst);
        }
    }
    all
}

fn unit(kind: JointKind, order: usize) -> String {
    let position = kind.position_unit();
    match order {
        0 => position.to_string(),
        1 => format!("{position}/s"),
        2 => format!("{position}/s²"),
        _ => format!("{position}/s³"),
    }
}

/// The margins of torque and workspace at the samples of a motion, `step` seconds apart.
pub fn of_dynamics(
    experiment: &Experiment<'_>,
    motion: &Motion,
    step: f64,
    trajectory: usize,
) -> Vec<Margin> {
    let model = experiment.observation.model();
    let mut all = Vec::new();
    if motion.is_open {
        all.push(Margin {
            constraint: "closed loops".to_string(),
            joint: None,
            trajectory,
            time: 0.0,
            margin: -1.0,
            relative: -1.0,
            limit: 0.0,
            unit: "1".to_string(),
        });
        return all;
    }
    let torques = experiment.torques.values(motion);
    for (limited, series) in experiment.torques.limited.iter().zip(&torques) {
        let joint = &model.tree().joints()[limited.joint];
        let peak = Least::of(series.iter().map(|t| -t.abs()));
        all.push(Margin {
            constraint: "torque".to_string(),
            joint: Some(joint.name.clone()),
            trajectory,
            time: peak.sample as f64 * step,
            margin: limited.limit + peak.value,
            relative: 1.0 + peak.value / limited.limit,
            limit: limited.limit,
            unit: joint.kind.effort_unit().to_string(),
        });
    }
    let values = experiment.workspace.values(motion);
    for (rule, series) in experiment.workspace.rules.iter().zip(&values) {
        let least = Least::of(series.iter().copied());
        all.push(Margin {
            constraint: rule.name(),
            joint: None,
            trajectory,
            time: least.sample as f64 * step,
            margin: least.value,
            relative: least.value,
            limit: rule.limit(),
            unit: rule.unit().to_string(),
        });
    }
    if let Some(loops) = &experiment.loops {
        for (series, of) in loops.values(motion).iter().zip(loops.limits()) {
            let least = Least::of(series.iter().copied());
            all.push(Margin {
                constraint: of.name.clone(),
                joint: None,
                trajectory,
                time: least.sample as f64 * step,
                margin: least.value,
                relative: least.value / of.limit,
                limit: of.limit,
                unit: of.unit.to_string(),
            });
        }
    }
    all
}

/// The least value of a series and its sample.
struct Least {
    sample: usize,
    value: f64,
}

impl Least {
    fn of(series: impl Iterator<Item = f64>) -> Self {
        let none = Self {
            sample: 0,
            value: f64::INFINITY,
        };
        let less = |least: Self, (sample, value): (usize, f64)| {
            if value < least.value {
                Self { sample, value }
            } else {
                least
            }
        };
        series.enumerate().fold(none, less)
    }
}
