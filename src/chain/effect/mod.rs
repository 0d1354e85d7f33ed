//! The vocabulary of physics: one file per effect, one table, [`EFFECTS`]; user-defined laws beside it, in a [`Catalogue`].
//!
//! Laws give the torque that the motor has to exert in addition. `sign(v)` means `v/(|v| + w)` with the
//! transition speed w of the joint's Coulomb friction, 0 where it has none.

pub mod asymmetric_friction;
pub mod backlash;
pub mod base_tilt;
pub mod catalogue;
pub mod channel_crosstalk;
pub mod coulomb_friction;
pub mod current_polynomial;
mod definition;
pub mod drive_gain;
pub mod encoder_offset;
pub mod expression;
pub mod external_contact;
pub mod fitted_effect;
pub mod flank;
pub mod formula;
pub mod joint_elasticity;
pub mod joint_spring;
pub mod kinematic_coupling;
pub mod knowledge;
pub mod law;
pub mod load_dependent_friction;
mod parameter;
pub mod position_dependent_friction;
pub mod presliding_hysteresis;
pub mod rotor_inertia;
pub mod sigmoid_friction;
pub mod sign;
pub mod site;
pub mod stribeck_friction;
mod table;
pub mod thermal_drift;
pub mod tilt;
pub mod time_delay;
pub mod torque_current_nonlinearity;
pub mod torque_offset;
pub mod torque_ripple;
pub mod transmission_efficiency;
pub mod unit;
pub mod unmodelled_payload;
pub mod user_law;
pub mod viscous_friction;
pub mod viscous_nonlinearity;

pub use crate::chain::effect::catalogue::{find, ids};
pub use crate::chain::effect::definition::{
    Confounder, Dependence, Effect, Lasts, Law, Memory, NEXT, Needs, PREVIOUS,
};
pub use crate::chain::effect::parameter::{Linearity, ParameterInfo, Search, Span};
pub use crate::chain::effect::table::{
    COUPLING, CROSSTALK, CURRENT_LAW, DELAY, EFFECTS, EffectParameter, GAIN, LOAD, TILT,
    TRANSITION, WARMING, of_term, term_name,
};
pub use catalogue::Catalogue;
pub use law::{
    Contribution, Flow, LawDynamics, Power, Samples, Surroundings, TorqueLaw, TransmissionLaw,
    Transmitted,
};
pub use unit::Unit;

#[cfg(test)]
mod tests;
