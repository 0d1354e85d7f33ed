//! The laws of the drives as statements that Rust and C read alike.
//!
//! In a formula v and a are speed and acceleration of the motor, t the torque that it transmits, s the
//! regularised sign of its speed, and `{name}` the value of a parameter.

use crate::export::language::number;
use crate::outcome::machine::{MachineEffect, MachineJoint};

/// Torque at the motor of each effect that adds one: identifier and formula.
const FORMULAS: &[(&str, &str)] = &[
    ("rotor_inertia", "{Jm} * a"),
    ("coulomb_friction", "{Fc} * s"),
    ("viscous_friction", "{Fv} * v"),
    ("asymmetric_friction", "{dFc} + {dFv} * magnitude(v)"),
    ("torque_offset", "{offset}"),
    (
        "stribeck_friction",
        "{Fs} * exponential(-square(v / {vs})) * s",
    ),
    ("load_dependent_friction", "{mu} * magnitude(t) * s"),
];

/// Effects that act elsewhere in the code, not as a torque of their own.
const ELSEWHERE: &[&str] = &["drive_gain", "kinematic_coupling", "unmodelled_payload"];

/// The formula of an effect with the values of its parameters; `None` where there is none.
pub fn formula(effect: &MachineEffect) -> Option<String> {
    let (_, formula) = FORMULAS.iter().find(|(id, _)| *id == effect.id)?;
    let mut text = formula.to_string();
    for parameter in &effect.parameters {
        let value = number(parameter.value);
        let value = if parameter.value < 0.0 {
            format!("({value})")
        } else {
            value
        };
        text = text.replace(&format!("{{{}}}", parameter.name), &value);
    }
    Some(text)
}

/// Effects of a joint that code has no formula for.
pub fn left_out(joint: &MachineJoint) -> Vec<&str> {
    let known =
        |id: &str| FORMULAS.iter().any(|(known, _)| *known == id) || ELSEWHERE.contains(&id);
    let ids = joint.effects.iter().map(|e| e.id.as_str());
    ids.filter(|id| !known(id)).collect()
}
