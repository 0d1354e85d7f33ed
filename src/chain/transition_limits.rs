//! Up to where transition speeds w of a regularised `sign(v)` are searched for.
//!
//! A friction `F v/(|v| + w)` that motions do not bring near its full size F is extrapolated: the rest of its curve, which a wide
//! w shows, is as well a viscous friction that is not linear. Where recordings determine F all the same, they may have any w at
//! which half of F is reached; where they do not, w stays where the fastest motion shows F but for a share of 5 %.

use crate::chain::dataset::Dataset;
use crate::chain::effect::knowledge::Transition;
use crate::chain::joint_model::JointModel;
use crate::chain::model::Model;
use crate::problem::solution::Control;
use nalgebra::DVector;

/// Share of its full size that a friction may lack at the fastest motion and count as seen: the usual band within which a value
/// counts as settled.
const UNSEEN: f64 = 0.05;

/// Relative standard deviation up to which a parameter counts as well determined (Khalil and Dombre 2002, section 12.4).
const DETERMINED: f64 = 0.1;

/// Share of a limit within which a transition has ended at it.
const AT_LIMIT: f64 = 1e-6;

/// Limits of the transition speeds of all joints.
#[derive(Debug, Clone, PartialEq)]
pub struct TransitionLimits {
    /// Largest speed of each joint, rad/s or m/s at joint scale.
    fastest: Vec<f64>,
    /// Joints whose friction the recordings determine beyond what their motion shows of it.
    determined: Vec<bool>,
}

/// A fit of a model whose transition speeds are limited.
pub trait TransitionFit {
    /// The model, with its limits.
    fn model(&self) -> &Model;
    /// All its parameters at the optimum.
    fn values(&self) -> &DVector<f64>;
    /// Standard deviation of each parameter; `None` where there is none.
    fn deviations(&self) -> Vec<Option<f64>>;
}

/// A fit with the limits that suit the recordings.
#[derive(Debug)]
pub struct SettledFit<F> {
    /// The fit.
    pub fit: F,
    /// Its limits.
    pub limits: TransitionLimits,
}

impl TransitionLimits {
    /// Those of what motions show.
    pub fn of(data: &Dataset) -> Self {
        let fastest = data.fastest();
        Self {
            determined: vec![false; fastest.len()],
            fastest,
        }
    }

    /// Fits within what the motions show; and where transitions end at that, once more within wider limits, which are kept at
    /// the joints whose friction comes out determined.
    ///
    /// # Errors
    /// Those of the first fit, and of the last.
    pub fn settle<F: TransitionFit, E>(
        self,
        control: &Control<'_>,
        fit: impl Fn(&Self) -> Result<F, E>,
    ) -> Result<SettledFit<F>, E> {
        let limits = self;
        let narrow = fit(&limits)?;
        let ended = limits.reached(&narrow);
        if ended.is_empty() || control.is_interrupted() {
            return Ok(SettledFit {
                fit: narrow,
                limits,
            });
        }
        let wider = limits.widened(&ended);
        let Some(wide) = fit(&wider).ok().filter(|_| !control.is_interrupted()) else {
            return Ok(SettledFit {
                fit: narrow,
                limits,
            });
        };
        let determined = determined(&wide, &ended);
        match determined.len() {
            0 => Ok(SettledFit {
                fit: narrow,
                limits,
            }),
            all if all == ended.len() => Ok(SettledFit {
                fit: wide,
                limits: wider,
            }),
            _ => {
                let limits = limits.widened(&determined);
                Ok(SettledFit {
                    fit: fit(&limits)?,
                    limits,
                })
            }
        }
    }

    /// Joints whose transition ends at its limit.
    fn reached(&self, fit: &impl TransitionFit) -> Vec<usize> {
        let joints = fit.model().joints().iter().enumerate();
        let ends = |(j, joint): (usize, &JointModel)| {
            let friction = Limited::of(joint)?;
            let open = j < self.fastest.len() && fit.model().has_usual_limits(friction.speed);
            let limit = open.then(|| self.widest(j, &friction.transition))?;
            (fit.values()[friction.speed] >= (1.0 - AT_LIMIT) * limit).then_some(j)
        };
        joints.filter_map(ends).collect()
    }

    /// The same with wider limits at joints.
    fn widened(&self, joints: &[usize]) -> Self {
        let mut wider = self.clone();
        for &j in joints {
            wider.determined[j] = true;
        }
        wider
    }

    /// The widest transition of a joint whose friction has one.
    fn widest(&self, joint: usize, transition: &Transition) -> f64 {
        let unseen = if self.determined[joint] { 0.5 } else { UNSEEN };
        transition.shown(self.fastest[joint], unseen)
    }
}

/// Joints, of some, whose friction a fit determines.
fn determined(fit: &impl TransitionFit, of: &[usize]) -> Vec<usize> {
    let deviations = fit.deviations();
    let is_determined = |joint: &&usize| {
        let friction = Limited::of(&fit.model().joints()[**joint]);
        friction.is_some_and(|friction| {
            let size = fit.values()[friction.size].abs();
            deviations[friction.size].is_some_and(|deviation| deviation <= DETERMINED * size)
        })
    };
    of.iter().filter(is_determined).copied().collect()
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

    /// v/(v + w) = 0.95 at 1 rad/s for w = 1/19 rad/s, and 0.5 for w = 1 rad/s.
    #[test]
    fn a_transition_is_as_wide_as_its_friction_is_seen() {
        let knowledge = find("coulomb_friction").unwrap().knowledge;
        let transition = knowledge.transition.unwrap();
        let shown = TransitionLimits {
            fastest: vec![1.0],
            determined: vec![false],
        };
        assert!((shown.widest(0, &transition) - 1.0 / 19.0).abs() < 1e-12);
        assert!((shown.widened(&[0]).widest(0, &transition) - 1.0).abs() < 1e-12);
    }
}
