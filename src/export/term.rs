//! Parameters of the usual terms of a joint: what other formats have places for.

use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::{Law, ParameterInfo, find, of_term};
use crate::outcome::machine::{MachineEffect, MachineJoint};

/// The size of a term, if the joint has it.
pub fn size(joint: &MachineJoint, term: JointTerm) -> Option<f64> {
    parameter(joint, term, 0)
}

/// Position of rest of the spring of a joint, if it has one.
pub fn rest(joint: &MachineJoint) -> Option<f64> {
    parameter(joint, JointTerm::Spring, 1)
}

/// The parameters of a term that other formats have places for.
pub fn written(term: JointTerm) -> &'static [ParameterInfo] {
    let all = of_term(term).parameters;
    match term {
        JointTerm::Spring => all,
        _ => &all[..1],
    }
}

/// Factor of the torque of a joint's motor.
pub fn torque_gain(joint: &MachineJoint) -> f64 {
    let found = joint.effects.iter().find(|e| is_drive_gain(e));
    let value = found.and_then(|e| e.parameters.first());
    value.map_or(1.0, |gain| gain.value)
}

/// s by which what is given to the motor of a joint acts later; negative of a signal that is recorded late.
pub fn delay(joint: &MachineJoint) -> f64 {
    let found = joint.effects.iter().find(|e| is_delay(e));
    let delay = found
        .and_then(|e| e.parameters.first())
        .map_or(0.0, |of| of.value);
    match joint.controller {
        Some(_) => delay,
        None => -delay,
    }
}

/// Whether an effect is the delay of a signal or of a command.
pub fn is_delay(effect: &MachineEffect) -> bool {
    find(&effect.id).is_some_and(|known| matches!(known.law, Law::Delay))
}

/// Whether an effect is a factor of the torque of a motor.
pub fn is_drive_gain(effect: &MachineEffect) -> bool {
    find(&effect.id).is_some_and(|known| matches!(known.law, Law::Gain))
}

fn parameter(joint: &MachineJoint, term: JointTerm, index: usize) -> Option<f64> {
    let effect = of_term(term);
    joint.value(effect.id, effect.parameters[index].name)
}
