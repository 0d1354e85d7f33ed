//! Parameters of the usual terms of a joint: what other formats have places for.

use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::{ParameterInfo, of_term};
use crate::outcome::machine::MachineJoint;

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

fn parameter(joint: &MachineJoint, term: JointTerm, index: usize) -> Option<f64> {
    let effect = of_term(term);
    joint.value(effect.id, effect.parameters[index].name)
}
