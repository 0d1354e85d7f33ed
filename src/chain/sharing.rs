//! Parameters that joints have in common: `θ_b = θ_a` for every parameter of an effect on joints a, b, ... with the same
//! motor.
//!
//! One joint's parameters are estimated; those of the others are the same unknowns, so that a column of the derivatives is
//! the sum of the columns of all of them.

use crate::chain::effect::Effect;
use crate::chain::joint_model::JointModel;
use crate::chain::parameter::{Parameter, State};
use nalgebra::DVector;

/// An effect whose parameters joints have in common.
#[derive(Debug, Clone)]
pub struct Sharing {
    /// The effect.
    pub effect: &'static Effect,
    /// Positions of the joints in the tree.
    pub joints: Vec<usize>,
    /// Names of the parameters that every joint has for itself.
    pub separate: Vec<String>,
}

impl Sharing {
    /// Positions in the model's list of what is shared: a row for every parameter of the effect, an entry for every joint
    /// that has the effect. No row where fewer than two joints have it.
    pub fn positions(&self, joints: &[JointModel]) -> Vec<Vec<usize>> {
        let having = self.having(joints);
        if having.len() < 2 {
            return Vec::new();
        }
        let own = |joint: usize, name: &str| {
            let mut all = joints[joint].parameters_of(self.effect.id);
            all.find(|(info, _)| info.name == name).map(|(_, at)| at)
        };
        let parameters = self.effect.parameters.iter();
        let shared = parameters.filter(|info| self.separate.iter().all(|name| name != info.name));
        let row = |name: &str| having.iter().filter_map(|&j| own(j, name)).collect();
        shared.map(|info| row(info.name)).collect()
    }

    /// Those of the joints that move and have the effect.
    pub fn having(&self, joints: &[JointModel]) -> Vec<usize> {
        let has = |j: &usize| {
            let joint = &joints[*j];
            !joint.locked && joint.effects.iter().any(|(e, _)| e.id == self.effect.id)
        };
        self.joints.iter().copied().filter(has).collect()
    }
}

/// Makes parameters of joints one unknown each: that of the first joint. What is known on every joint stays so.
pub(super) fn tie(sharings: &[Sharing], joints: &[JointModel], parameters: &mut [Parameter]) {
    for row in sharings
        .iter()
        .flat_map(|sharing| sharing.positions(joints))
    {
        let free: Vec<usize> = row
            .into_iter()
            .filter(|&p| parameters[p].is_free())
            .collect();
        let Some((&first, others)) = free.split_first() else {
            continue;
        };
        for &other in others {
            parameters[other].state = State::Shared(first);
            // Inside another law of one of the joints it is no factor of its own.
            if !parameters[other].is_linear() {
                parameters[first].linearity = parameters[other].linearity;
            }
        }
    }
}

/// Gives parameters the values of those that they are shared with.
pub(super) fn spread(parameters: &[Parameter], values: &mut DVector<f64>) {
    for (p, parameter) in parameters.iter().enumerate() {
        if let State::Shared(with) = parameter.state {
            values[p] = values[with];
        }
    }
}
