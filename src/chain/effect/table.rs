//! The table of all effects of the vocabulary.

use crate::chain::effect::definition::Effect;
use crate::chain::effect::{
    asymmetric_friction, backlash, base_tilt, coulomb_friction, drive_gain, external_contact,
    joint_elasticity, joint_spring, kinematic_coupling, load_dependent_friction,
    position_dependent_friction, presliding_hysteresis, rotor_inertia, sigmoid_friction,
    stribeck_friction, thermal_drift, time_delay, torque_current_nonlinearity, torque_offset,
    torque_ripple, transmission_efficiency, unmodelled_payload, viscous_friction,
    viscous_nonlinearity,
};

/// Every effect that the tool knows, in the order in which it lists them.
pub const EFFECTS: &[&Effect] = &[
    &coulomb_friction::EFFECT,
    &viscous_friction::EFFECT,
    &asymmetric_friction::EFFECT,
    &stribeck_friction::EFFECT,
    &viscous_nonlinearity::EFFECT,
    &sigmoid_friction::EFFECT,
    &presliding_hysteresis::EFFECT,
    &position_dependent_friction::EFFECT,
    &transmission_efficiency::EFFECT,
    &load_dependent_friction::EFFECT,
    &torque_current_nonlinearity::EFFECT,
    &drive_gain::EFFECT,
    &torque_offset::EFFECT,
    &rotor_inertia::EFFECT,
    &kinematic_coupling::EFFECT,
    &joint_elasticity::EFFECT,
    &backlash::EFFECT,
    &torque_ripple::EFFECT,
    &joint_spring::EFFECT,
    &unmodelled_payload::EFFECT,
    &base_tilt::EFFECT,
    &time_delay::EFFECT,
    &thermal_drift::EFFECT,
    &external_contact::EFFECT,
];
