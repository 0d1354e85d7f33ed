//! Currents taken for torques and the reverse: `τ = a·τ_file + friction + ...` with the robot file's
//! inertials as reference; a is near 1 where the unit is right.

use crate::chain::model::Signal;
use crate::chain::parameter::Role;
use crate::check::context::PreparedRecording;
use crate::check::regression::{Columns, Comparison, factor, last_coefficients, rest};
use crate::check::report::finding;
use crate::fault::Description;
use crate::outcome::check::{Mistake, Severity};
use crate::robot::inertia::PER_LINK;

/// Values of a over their standard deviation from which they count.
const DETERMINED: f64 = 10.0;

/// Share of the signal that the file's torques must explain by themselves.
const LEAST_SHARE: f64 = 0.3;

/// Inertials of a maker's file are right to a factor of two; a unit is wrong by more than this.
const WRONG: f64 = 3.0;

/// Factors of a wrong constant agree this closely between joints: inertials scatter more.
const AGREEMENT: f64 = 1.6;

/// The factor of a joint, by its name.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalScale {
    /// The joint's name.
    pub joint: String,
    /// The torques that were recorded, by the declared constants, over those that the robot file's inertials give; no unit.
    pub factor: f64,
}

impl SignalScale {
    /// Of the joints of a recording for which it is determined.
    pub(super) fn of(ready: &PreparedRecording<'_>) -> Vec<Self> {
        let joints = ready.model.tree().joints();
        let of = |factor: Factor| Self {
            joint: joints[factor.joint].name.clone(),
            factor: factor.value,
        };
        factors(ready).into_iter().map(of).collect()
    }
}

/// The factor of one joint.
#[derive(Debug, Clone, Copy)]
pub(super) struct Factor {
    pub channel: usize,
    pub joint: usize,
    pub value: f64,
}

pub(super) fn check(ready: &PreparedRecording<'_>) -> Vec<Mistake> {
    // A sensor behind the gears has no constant that could be mistaken, and gains of controllers may be unknown.
    let has_constant = !matches!(
        ready.model.signal(),
        Signal::BaseWrench | Signal::LinkTorque | Signal::PositionCommand
    );
    if !has_constant || !ready.other_reading.is_empty() {
        return Vec::new();
    }
    let factors: Vec<Factor> = factors(ready)
        .into_iter()
        .filter(|f| f.value > 0.0)
        .collect();
    let wrong = |f: &&Factor| f.value > WRONG || f.value < 1.0 / WRONG;
    let off: Vec<Factor> = factors.iter().filter(wrong).copied().collect();
    let same_side = off.iter().all(|f| f.value > 1.0) || off.iter().all(|f| f.value < 1.0);
    // Masses of single links, rotors and loads are often wrong; a wrong unit is wrong on every joint.
    let all = !off.is_empty() && off.len() == factors.len() && same_side;
    if all {
        vec![of_all(ready, &off)]
    } else {
        Vec::new()
    }
}

/// Factors of the joints whose torque the robot file's inertials explain.
pub(super) fn factors(ready: &PreparedRecording<'_>) -> Vec<Factor> {
    let comparison = &ready.comparison;
    let joints = ready.model.tree().joints();
    let carries_mass = |joint: usize| {
        (0..joints.len())
            .filter(|&link| ready.model.tree().moves(joint, link))
            .all(|link| joints[link].inertia.mass() > 0.0)
    };
    // A load that hangs on the robot is not in its file.
    if comparison.sampled.loaded && ready.model.payload().is_some() {
        return Vec::new();
    }
    let channels = comparison.joint_channels();
    channels
        .into_iter()
        .filter(|&(_, joint)| carries_mass(joint) && comparison.moves(joint))
        .filter_map(|(channel, joint)| {
            let value = factor_of(comparison, ready, channel)?;
            Some(Factor {
                channel,
                joint,
                value,
            })
        })
        .collect()
}

fn factor_of(
    comparison: &Comparison,
    ready: &PreparedRecording<'_>,
    channel: usize,
) -> Option<f64> {
    let inertials = ready.model.tree().parameters();
    let (bodies, drives): (Vec<_>, Vec<_>) =
        comparison.columns[channel]
            .iter()
            .cloned()
            .partition(|(p, _)| {
                matches!(
                    comparison.model.parameters()[*p].role,
                    Role::Inertial { .. }
                )
            });
    let mut rigid = vec![0.0; comparison.sampled.len()];
    for (parameter, series) in &bodies {
        debug_assert!(*parameter < PER_LINK * ready.model.tree().len());
        for (to, y) in rigid.iter_mut().zip(series) {
            *to += inertials[*parameter] * y;
        }
    }
    let without = drives.len();
    let mut columns: Columns = drives;
    columns.push((usize::MAX, rigid));
    let torque = comparison.torque[channel].as_slice();
    let factor = factor(&columns, &[torque]);
    let (value, covariance) = last_coefficients(&factor, columns.len(), 1)?;
    let left = rest(&factor, columns.len(), 0);
    let explained = factor.entry(without, columns.len()).abs();
    let deviation = left / (comparison.sampled.len() as f64).sqrt() * covariance[(0, 0)].sqrt();
    let share = explained / explained.hypot(left);
    let determined = value[0].abs() > DETERMINED * deviation && share > LEAST_SHARE;
    determined.then_some(value[0])
}

fn of_all(ready: &PreparedRecording<'_>, factors: &[Factor]) -> Mistake {
    let in_words = |f: &Factor| match (1e-3..1e4).contains(&f.value.abs()) {
        true => format!("{:.3}", f.value),
        false => format!("{:.2e}", f.value),
    };
    let list: Vec<String> = factors.iter().map(in_words).collect();
    let (what, remedy) = match ready.model.signal() {
        Signal::Current => of_current(ready, factors),
        _ => (
            "the signal looks like a current, or a torque at the motor's side",
            "set recordings.signal = \"current\" with drive.torque_constant, or \"motor_torque\" with \
             drive.ratio",
        ),
    };
    finding(
        Severity::Warning,
        ready.place(),
        Description::new(
            "signal-scale",
            format!(
                "the torques are {} times those that the robot file's inertials give: {what}",
                list.join(", ")
            ),
            remedy.to_string(),
        ),
    )
}

/// Too large by the torque constants themselves: the signal is a torque already.
fn of_current(ready: &PreparedRecording<'_>, factors: &[Factor]) -> (&'static str, &'static str) {
    let ratio = |f: &Factor| f.value / ready.model.joints()[f.joint].torque_constant.abs();
    let torque = factors
        .iter()
        .all(|f| (1.0 / AGREEMENT..AGREEMENT).contains(&ratio(f)));
    if torque {
        (
            "these are the torque constants, so the signal looks like a torque already",
            "set recordings.signal = \"torque\"",
        )
    } else {
        (
            "the torque constants look wrong",
            "give drive.torque_constant in N·m/A at the joint side: motor constant times ratio",
        )
    }
}
