//! Up to where transition speeds w of a regularised `sign(v)` are searched for.
//!
//! A friction `F v/(|v| + w)` that motions do not bring near its full size F is extrapolated: the rest of its curve, which a wide
//! w shows, is as well a viscous friction that is not linear. Where recordings determine F all the same, they may have any w at
//! which half of F is reached; where they do not, w stays where the fastest motion shows F but for a share of 5 %.
//! Speeds over which a law that remembers changes are searched for up to the fastest motion.

use crate::chain::dataset::Dataset;
use crate::chain::effect::knowledge::Transition;
use crate::chain::effect::{Effect, Memory, Search};
use crate::chain::joint_model::JointModel;
use crate::chain::model::Model;
use crate::problem::solution::Control;
use nalgebra::DVector;

/// Share of its full size that a friction may lack at the fastest motion and count as seen: the usual band within which a value
/// counts as settled.
const UNSEEN: f64 = 0.05;

/// The same where recordings determine its size.
const MOST_UNSEEN: f64 = 0.5;

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
    /// What its limits keep out, where transitions end at them.
    pub wider: Option<WiderFit<F>>,
}

/// A fit with wider transitions than the motions show.
#[derive(Debug)]
pub struct WiderFit<F> {
    /// The fit.
    pub fit: F,
    /// Joints of which the recordings do not determine the friction.
    pub joints: Vec<usize>,
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
        let narrow = SettledFit {
            fit: fit(&self)?,
            limits: self,
            wider: None,
        };
        let ended = narrow.limits.reached(&narrow.fit);
        if ended.is_empty() || control.is_interrupted() {
            return Ok(narrow);
        }
        let limits = narrow.limits.widened(&ended);
        let Some(fitted) = fit(&limits).ok().filter(|_| !control.is_interrupted()) else {
            return Ok(narrow);
        };
        let (determined, open): (Vec<usize>, Vec<usize>) = ended
            .iter()
            .partition(|joint| is_determined(&fitted, **joint));
        if open.is_empty() {
            return Ok(SettledFit {
                fit: fitted,
                limits,
                wider: None,
            });
        }
        let wider = Some(WiderFit {
            fit: fitted,
            joints: open,
        });
        if determined.is_empty() {
            return Ok(SettledFit { wider, ..narrow });
        }
        let limits = narrow.limits.widened(&determined);
        Ok(SettledFit {
            fit: fit(&limits)?,
            limits,
            wider,
        })
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
        let unseen = match self.determined[joint] {
            true => MOST_UNSEEN,
            false => UNSEEN,
        };
        transition.shown(self.fastest[joint], unseen)
    }
}

/// Whether a fit determines the friction of a joint.
fn is_determined(fit: &impl TransitionFit, joint: usize) -> bool {
    let friction = Limited::of(&fit.model().joints()[joint]);
    friction.is_some_and(|friction| {
        let size = fit.values()[friction.size].abs();
        let deviation = fit.deviations()[friction.size];
        deviation.is_some_and(|deviation| deviation <= DETERMINED * size)
    })
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

/// Positions of the speeds over which a law that remembers changes, as bristles do over that of Stribeck. Beyond the fastest motion
/// such a change is a bend: any size of it is then the same torque, and so is any speed where the change is nothing.
fn scales_of_speed(&(effect, first): &(&'static Effect, usize)) -> impl Iterator<Item = usize> {
    let remembers = effect.needs.memory == Memory::WholeMotion;
    let parameters = effect.parameters.iter().enumerate();
    let scales = parameters.filter(move |(_, info)| {
        remembers && matches!(info.search, Search::Speed(_)) && info.lower >= 0.0
    });
    scales.map(move |(k, _)| first + k)
}

impl Model {
    /// Narrows the transition speeds of `sign(v)`, and the speeds over which laws that remember change. A joint without the term that a
    /// wide transition stands for keeps its limits; limits and values that were stated stay.
    pub fn limit_transitions(&mut self, limits: &TransitionLimits) {
        let joints = self.joints().iter().enumerate();
        let widest = |(j, joint): (usize, &JointModel)| {
            let friction = Limited::of(joint)?;
            (j < limits.fastest.len())
                .then(|| (friction.speed, limits.widest(j, &friction.transition)))
        };
        let mut widths: Vec<(usize, f64)> = joints.filter_map(widest).collect();
        let moving = self.joints().iter().zip(&limits.fastest);
        widths.extend(moving.flat_map(|(joint, &fastest)| {
            let scales = joint.effects.iter().flat_map(scales_of_speed);
            scales.map(move |index| (index, fastest))
        }));
        for (index, widest) in widths {
            self.lower_limit(index, widest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::effect::find;
    use crate::chain::model::{ModelSettings, Signal};
    use crate::robot::urdf;
    use std::cell::Cell;
    use std::convert::Infallible;
    use std::path::Path;

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

    const ARM: &str = r#"<robot name="arm"><link name="base"/><link name="l1"/><link name="l2"/>
<joint name="a" type="continuous"><parent link="base"/><child link="l1"/><axis xyz="0 1 0"/></joint>
<joint name="b" type="continuous"><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/></joint></robot>"#;

    /// A fit that comes as close to wanted transitions as its limits let it.
    struct Fit {
        model: Model,
        values: DVector<f64>,
        deviation: [f64; 2],
    }

    impl TransitionFit for Fit {
        fn model(&self) -> &Model {
            &self.model
        }

        fn values(&self) -> &DVector<f64> {
            &self.values
        }

        fn deviations(&self) -> Vec<Option<f64>> {
            let of = |(name, deviation)| (self.model.find(name).unwrap(), deviation);
            let sizes = ["a.coulomb_friction.Fc", "b.coulomb_friction.Fc"];
            let known = sizes.into_iter().zip(self.deviation).map(of);
            let mut deviations = vec![None; self.values.len()];
            known.for_each(|(at, deviation)| deviations[at] = Some(deviation));
            deviations
        }
    }

    /// Transitions at which fits of joints that move at 1 rad/s settle, and how many fits that took; sizes of 1 N·m with
    /// deviations.
    fn settled(wanted: [f64; 2], deviation: [f64; 2]) -> ([f64; 2], usize) {
        let effects = ["coulomb_friction", "viscous_friction"].map(|id| find(id).unwrap());
        let tree = urdf::parse(ARM, Path::new("arm.urdf")).unwrap();
        let model = Model::new(ModelSettings {
            effects: vec![effects.to_vec(); 2],
            ..ModelSettings::bodies(tree, Signal::Torque)
        })
        .unwrap();
        let widths = ["a.coulomb_friction.w", "b.coulomb_friction.w"];
        let positions = widths.map(|name| model.find(name).unwrap());
        let fits = Cell::new(0);
        let limits = TransitionLimits {
            fastest: vec![1.0; 2],
            determined: vec![false; 2],
        };
        let settled = limits.settle(&Control::default(), |limits| {
            fits.set(fits.get() + 1);
            let mut model = model.clone();
            model.limit_transitions(limits);
            let mut values = DVector::from_element(model.parameters().len(), 1.0);
            for (at, wanted) in positions.into_iter().zip(wanted) {
                values[at] = wanted.min(model.parameters()[at].upper);
            }
            Ok::<_, Infallible>(Fit {
                model,
                values,
                deviation,
            })
        });
        let Ok(settled) = settled;
        let open = settled.wider.map_or(0, |wider| wider.joints.len());
        let ended = (0..2).filter(|&j| wanted[j] > 1.0 / 19.0 && deviation[j] > DETERMINED);
        assert_eq!(open, ended.count());
        (positions.map(|at| settled.fit.values[at]), fits.get())
    }

    /// Bristles change over no speed that the joint does not reach, unless one is stated.
    #[test]
    fn the_scale_of_a_law_that_remembers_lies_within_the_motion() {
        let effects = ["coulomb_friction", "presliding_hysteresis"].map(|id| find(id).unwrap());
        let tree = urdf::parse(ARM, Path::new("arm.urdf")).unwrap();
        let mut model = Model::new(ModelSettings {
            effects: vec![effects.to_vec(); 2],
            ..ModelSettings::bodies(tree, Signal::Torque)
        })
        .unwrap();
        let [free, stated] = ["a", "b"].map(|joint| {
            model
                .find(&format!("{joint}.presliding_hysteresis.vs"))
                .unwrap()
        });
        model.fix(stated, 7.0).unwrap();
        model.limit_transitions(&TransitionLimits {
            fastest: vec![0.8; 2],
            determined: vec![false; 2],
        });
        assert_eq!(model.parameters()[free].upper, 0.8);
        assert_eq!(model.parameters()[stated].value, 7.0);
    }

    /// Joints of which the recordings tell 1 N·m to 10 % have what they want, and others what their motion shows.
    #[test]
    fn a_wide_transition_stays_where_friction_is_determined() {
        let shown = 1.0 / 19.0;
        for (wanted, deviation, expected, fits) in [
            ([0.04, 0.05], [1.0, 1.0], [0.04, 0.05], 1),
            ([0.3, 0.05], [0.09, 1.0], [0.3, 0.05], 2),
            ([0.3, 0.4], [0.09, 0.09], [0.3, 0.4], 2),
            ([0.3, 0.4], [0.11, 1.2], [shown, shown], 2),
            ([0.3, 0.4], [0.11, 0.09], [shown, 0.4], 3),
        ] {
            let (found, made) = settled(wanted, deviation);
            let off = (0..2).map(|j| (found[j] - expected[j]).abs());
            assert!(off.fold(0.0, f64::max) < 1e-12, "{wanted:?}: {found:?}");
            assert_eq!(made, fits, "{wanted:?}");
        }
    }
}
