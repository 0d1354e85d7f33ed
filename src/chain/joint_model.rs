//! A joint with its drive: its effects, and where their parameters stand among those of the model.

use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::{Effect, ParameterInfo};
use crate::robot::tree::JointKind;

/// A joint with its drive.
#[derive(Debug, Clone)]
pub struct JointModel {
    /// Name of the joint.
    pub name: String,
    /// Whether it turns or slides.
    pub kind: JointKind,
    /// N·m/A (N/A) at joint scale; 1 where the signal is a torque.
    pub torque_constant: f64,
    /// Relative; 0 where the constant is certain.
    pub torque_constant_std: f64,
    /// It stands still: neither its signal nor its drive is in the model.
    pub locked: bool,
    /// Effects and the position of their first parameter in the model's list.
    pub effects: Vec<(&'static Effect, usize)>,
    /// Positions of the parameters that each effect borrows from others.
    pub borrowed: Vec<Vec<usize>>,
    /// Joints whose motion each effect knows beside its own.
    pub others: Vec<Vec<usize>>,
    /// Whether another effect takes the place of each effect's torque.
    pub replaced: Vec<bool>,
    /// Position of the transition speed w if the joint has one.
    pub width: Option<usize>,
    /// Position of the gain, if the joint has one.
    pub gain: Option<usize>,
    /// Position of c0 of the current's polynomial, if the joint has one.
    pub polynomial: Option<usize>,
    /// Position of the proportional gain of the controller (the derivative gain is behind it), if the joint has one.
    pub controller: Option<usize>,
    /// Position of the delay, if the joint has one.
    pub delay: Option<usize>,
    /// Position of the stiffness (the damping is behind it), if the joint is elastic.
    pub elasticity: Option<usize>,
    /// Position of the play between motor and link, if the joint has one.
    pub play: Option<usize>,
    /// Position of the offset of the encoder, if the joint has one.
    pub encoder: Option<usize>,
    /// N·m (N) of transmitted torque about zero within which the switch of losses is rounded off; 0: not at all.
    pub rounding: f64,
}

impl JointModel {
    /// Whether the link lags behind the motor.
    pub fn has_lag(&self) -> bool {
        self.elasticity.is_some() || self.play.is_some()
    }

    /// Whether it has a usual term of a joint.
    pub fn has_term(&self, term: JointTerm) -> bool {
        let mut effects = self.effects.iter();
        effects.any(|(effect, _)| effect.knowledge.term == Some(term))
    }

    /// What is known of the parameters of one of its effects, with their positions in the model's list; none of an effect
    /// that it does not have.
    pub fn parameters_of(&self, id: &str) -> impl Iterator<Item = (&'static ParameterInfo, usize)> {
        let found = self.effects.iter().find(|(effect, _)| effect.id == id);
        let own =
            |&(effect, first): &(&'static Effect, usize)| effect.parameters.iter().zip(first..);
        found.map(own).into_iter().flatten()
    }
}
