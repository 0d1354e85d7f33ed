//! What a parameter of an effect is, and where it acts.

use crate::chain::effect::{Effect, ParameterInfo};
use crate::chain::model::Model;
use crate::chain::parameter::Role;

/// A parameter of an effect at a joint.
#[derive(Debug, Clone, Copy)]
pub struct EffectParameter {
    /// Position of the joint.
    pub joint: usize,
    /// Position of the effect among those of the joint.
    pub number: usize,
    /// The effect that it is of.
    pub effect: &'static Effect,
    /// What the effect's table says of it.
    pub info: &'static ParameterInfo,
}

impl Model {
    /// What the parameter at a position is of an effect; `None` of bodies, loads, controllers and the like.
    pub fn effect_parameter(&self, position: usize) -> Option<EffectParameter> {
        let Role::Effect {
            joint,
            effect: number,
            parameter,
        } = self.parameters()[position].role
        else {
            return None;
        };
        let (effect, _) = self.joints()[joint].effects[number];
        Some(EffectParameter {
            joint,
            number,
            effect,
            info: &effect.parameters[parameter],
        })
    }
}
