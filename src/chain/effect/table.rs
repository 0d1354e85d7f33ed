//! The table of all effects of the vocabulary.

use crate::chain::effect::definition::Effect;
use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::{
    asymmetric_friction, backlash, base_tilt, channel_crosstalk, coulomb_friction, drive_gain,
    encoder_offset, external_contact, joint_elasticity, joint_spring, kinematic_coupling,
    load_dependent_friction, position_dependent_friction, presliding_hysteresis, rotor_inertia,
    sigmoid_friction, stribeck_friction, thermal_drift, time_delay, torque_current_nonlinearity,
    torque_offset, torque_ripple, transmission_efficiency, unmodelled_payload, viscous_friction,
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
    &encoder_offset::EFFECT,
    &time_delay::EFFECT,
    &channel_crosstalk::EFFECT,
    &thermal_drift::EFFECT,
    &external_contact::EFFECT,
];

/// The effect that a usual term of a joint is.
pub fn of_term(term: JointTerm) -> &'static Effect {
    match term {
        JointTerm::DryFriction => &coulomb_friction::EFFECT,
        JointTerm::ViscousFriction => &viscous_friction::EFFECT,
        JointTerm::Offset => &torque_offset::EFFECT,
        JointTerm::RotorInertia => &rotor_inertia::EFFECT,
        JointTerm::Spring => &joint_spring::EFFECT,
        JointTerm::Gain => &drive_gain::EFFECT,
    }
}

/// The size of a usual term of a joint by the part of its name behind that of the joint: `EFFECT.PARAMETER`.
pub fn term_name(term: JointTerm) -> String {
    let effect = of_term(term);
    format!("{}.{}", effect.id, effect.parameters[0].name)
}

/// The transition speed w of `sign(v)`.
pub const TRANSITION: EffectParameter = EffectParameter {
    effect: &coulomb_friction::EFFECT,
    parameter: coulomb_friction::WIDTH,
};

/// A parameter of an effect of the table.
#[derive(Debug, Clone, Copy)]
pub struct EffectParameter {
    /// The effect of the vocabulary that has it.
    pub effect: &'static Effect,
    /// Its position among the effect's.
    pub parameter: usize,
}

impl EffectParameter {
    /// Its name within the effect.
    pub fn name(self) -> &'static str {
        self.effect.parameters[self.parameter].name
    }
}

/// The effect that is a factor of the torque constant.
pub const GAIN: &Effect = &drive_gain::EFFECT;

/// The effect that is friction which changes as a joint warms up.
pub const WARMING: &Effect = &thermal_drift::EFFECT;

/// The effect that is a late signal.
pub const DELAY: &Effect = &time_delay::EFFECT;

/// The effect that adds entries to the matrix from motors to joints.
pub const COUPLING: &Effect = &kinematic_coupling::EFFECT;

/// The effect that puts shares of other joints' signals into what is recorded of one.
pub const CROSSTALK: &Effect = &channel_crosstalk::EFFECT;

/// The effect that is a body on a link.
pub const LOAD: &Effect = &unmodelled_payload::EFFECT;

/// The effect that turns gravity.
pub const TILT: &Effect = &base_tilt::EFFECT;

/// The effect that replaces the torque constant of a current.
pub const CURRENT_LAW: &Effect = &torque_current_nonlinearity::EFFECT;
