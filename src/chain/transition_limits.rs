//! Up to where transition speeds w of a regularised `sign(v)` are searched for.
//!
//! A friction `F v/(|v| + w)` that motions do not bring near its full size F is extrapolated: the rest of its curve, which a wide
//! w shows, is as well a viscous friction that is not linear. Where recordings determine F all the same, they may have any w at
//! which half of F is reached; where they do not, w stays where the fastest motion shows F but for a share of 5 %.

use crate::chain::dataset::Dataset;
use crate::chain::effect::knowledge::Transition;
use crate::chain::joint_model::JointModel;
use crate::chain::model::Model;
use nalgebra::DVector;

/// Share of its full size that a friction may lack at the fastest motion and count as seen: the usual band within which a value
/// counts as settled.
const UNSEEN: f64 = 0.05;

/// Relative standard deviation up to which a parameter counts as well determined (Khalil and Dombre 2002, section 12.4).
const DETERMINED: f64 = 0.1;

/// Limits of the transition speeds of all joints.
#[derive(Debug, Clone, PartialEq)]
pub struct TransitionLimits {
    /// Largest speed of each joint, rad/s or m/s at joint scale.
    fastest: Vec<f64>,
    /// Joints whose friction would be extrapolated by a wider transition.
    extrapolated: Vec<bool>,
}

impl TransitionLimits {
    /// Those of motions, while all joints may determine their friction.
    pub fn of(data: &Dataset) -> Self {
        let fastest = data.fastest();
        Self {
            extrapolated: vec![false; fastest.len()],
            fastest,
        }
    }

    /// Holds joints to transitions that the motion shows whose fitted ones are wider and whose friction is not determined;
    /// `deviation` is the standard deviation of the estimate of a parameter of the model. Whether there are any such joints,
    /// so that the model has to be fitted again.
    pub fn hold(
        &mut self,
        model: &Model,
        values: &DVector<f64>,
        deviation: impl Fn(usize) -> Option<f64>,
    ) -> bool {
        let mut held = false;
        for (j, joint) in model.joints().iter().enumerate() {
            let Some(friction) = Limited::of(joint) else {
                continue;
            };
            let (Some(fastest), Some(extrapolated)) =
                (self.fastest.get(j), self.extrapolated.get_mut(j))
            else {
                continue;
            };
            if !model.has_usual_limits(friction.speed) {
                continue;
            }
            let is_wide = values[friction.speed] > friction.transition.shown(*fastest, UNSEEN);
            let determined = deviation(friction.size)
                .is_some_and(|deviation| deviation <= DETERMINED * values[friction.size].abs());
            if is_wide && !determined && !*extrapolated {
                (*extrapolated, held) = (true, true);
            }
        }
        held
    }

    /// The widest transition of a joint whose friction has one.
    fn widest(&self, joint: usize, transition: &Transition) -> f64 {
        let unseen = if self.extrapolated[joint] {
            UNSEEN
        } else {
            0.5
        };
        transition.shown(self.fastest[joint], unseen)
    }
}

/// The friction of a joint whose transition speed is limited, as positions in the model's list of parameters.
struct Limited {
    transition: Transition,
    speed: usize,
    size: usize,
}

impl Limited {
    /// `None` where there is no transition, or no term that a wide one could be told from.
    fn of(joint: &JointModel) -> Option<Self> {
        let mut effects = joint.effects.iter();
        let limited = effects.find_map(|(effect, first)| {
            let transition = effect.knowledge.transition?;
            Some(Self {
                speed: first + transition.speed,
                size: first + transition.size,
                transition,
            })
        })?;
        joint
            .has_term(limited.transition.stands_for)
            .then_some(limited)
    }
}

impl Model {
    /// Narrows the transition speeds of `sign(v)`. A joint without the term that a wide transition stands for keeps its limits;
    /// limits and values that were stated stay.
    pub fn limit_transitions(&mut self, limits: &TransitionLimits) {
        let joints = self.joints().iter().enumerate();
        let widest = |(j, joint): (usize, &JointModel)| {
            let friction = Limited::of(joint)?;
            (j < limits.fastest.len())
                .then(|| (friction.speed, limits.widest(j, &friction.transition)))
        };
        let widths: Vec<(usize, f64)> = joints.filter_map(widest).collect();
        for (index, widest) in widths {
            self.lower_limit(index, widest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::effect::find;

    fn transition() -> Transition {
        let knowledge = find("coulomb_friction").unwrap().knowledge;
        knowledge.transition.unwrap()
    }

    /// v/(v + w) = 0.95 at 1 rad/s for w = 1/19 rad/s, and 0.5 for w = 1 rad/s.
    #[test]
    fn a_transition_is_as_wide_as_its_friction_is_seen() {
        let mut limits = TransitionLimits {
            fastest: vec![1.0],
            extrapolated: vec![false],
        };
        assert!((limits.widest(0, &transition()) - 1.0).abs() < 1e-12);
        limits.extrapolated[0] = true;
        assert!((limits.widest(0, &transition()) - 1.0 / 19.0).abs() < 1e-12);
    }
}
