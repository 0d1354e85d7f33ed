//! Hypotheses: an effect of the vocabulary on a joint, on a pair of joints, or on all of them.

use crate::chain::assemble::has_others;
use crate::chain::crosstalk::Heard;
use crate::chain::effect::{Effect, Law, Memory};
use crate::chain::model::{Channel, Model};
use crate::chain::parameter::Role;
use crate::chain::prior::Prior;
use crate::setup::model_spec::Addition;

/// An effect with the joints that it acts on.
#[derive(Debug, Clone)]
pub struct Hypothesis {
    /// What acts.
    pub effect: &'static Effect,
    /// Joints in whose lists the effect stands.
    pub joints: Vec<usize>,
    /// The second joint of an effect of pairs: the motor that moves the joint too, or the channel that is heard.
    pub other: Option<usize>,
}

impl PartialEq for Hypothesis {
    fn eq(&self, other: &Self) -> bool {
        self.effect.id == other.effect.id
            && self.joints == other.joints
            && self.other == other.other
    }
}

impl Hypothesis {
    fn on(effect: &'static Effect, joints: Vec<usize>) -> Self {
        Self {
            effect,
            joints,
            other: None,
        }
    }

    /// Joints that a finding names: of an ordered pair the one that it acts on, then the other.
    pub fn named_joints(&self) -> Vec<usize> {
        let mut joints = self.joints.clone();
        joints.extend(self.other);
        joints
    }

    /// Whether it moves the signals of its joints alone, or mostly: a load and a tilted base move those of all that carry them.
    pub fn is_of_its_joints(&self) -> bool {
        !matches!(self.effect.law, Law::Body | Law::Tilt)
    }

    /// Channels that it moves.
    pub fn moved_channels(&self, model: &Model) -> Vec<usize> {
        if self.is_of_its_joints() {
            return channels_of(model, &self.named_joints());
        }
        let joints: Vec<usize> = (0..model.joints().len()).collect();
        channels_of(model, &joints)
    }

    /// The same physics on fewer of the same joints.
    pub fn is_part_of(&self, other: &Self) -> bool {
        let within = self.joints.iter().all(|j| other.joints.contains(j));
        self.effect.id == other.effect.id && within && self.joints.len() < other.joints.len()
    }

    /// The same physics on some of the same joints.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.effect.id == other.effect.id && self.joints.iter().any(|j| other.joints.contains(j))
    }
}

/// What a model has to be given for hypotheses to be in it.
pub fn addition(hypotheses: &[Hypothesis]) -> Addition {
    let mut addition = Addition::default();
    for hypothesis in hypotheses {
        for &joint in &hypothesis.joints {
            addition.add(hypothesis.effect, joint, hypothesis.other);
        }
    }
    addition
}

/// Every hypothesis that a model leaves open; `sought` are the effects to look for, all that are looked for unasked if `None`.
/// What changes with time shows only `in_time`; what moves joints away from their motors is none of closed loops.
pub fn open(
    model: &Model,
    prior: &Prior,
    sought: Option<&[String]>,
    in_time: bool,
) -> Vec<Hypothesis> {
    let wanted = |e: &&&'static Effect| {
        let shows = in_time || e.needs.memory != Memory::Time;
        let is_sought = match sought {
            Some(ids) => ids.iter().any(|id| id == e.id),
            None => e.law.is_sought(),
        };
        let follows = model.mechanism().is_none() || !e.law.moves_joints();
        shows && is_sought && follows
    };
    let joints: Vec<usize> = (0..model.joints().len())
        .filter(|&j| !model.joints()[j].locked)
        .collect();
    let mut open = Vec::new();
    for &effect in model.catalogue().effects().iter().filter(wanted) {
        match effect.law {
            Law::Coupling | Law::Crosstalk => open.extend(pairs(model, effect, &joints)),
            Law::Body => open.extend(bodies(model, prior, effect, &joints)),
            Law::Tilt if model.tilt().is_none() => {
                open.push(Hypothesis::on(effect, joints.clone()));
            }
            Law::Tilt => {}
            _ => {
                let single = joints.iter().filter(|j| may_have(model, **j, effect));
                open.extend(single.map(|&j| Hypothesis::on(effect, vec![j])));
                let all = joints.iter().all(|&j| may_have(model, j, effect));
                // One cable or one clock carries the channels of all joints.
                if matches!(effect.law, Law::Delay) && all && joints.len() > 1 {
                    open.push(Hypothesis::on(effect, joints.clone()));
                }
            }
        }
    }
    open
}

/// Whether a joint may have the effect and does not: no joint has it twice, a rotor inertia that is
/// given is known, and a parameter that it takes from another effect, or a law that it refines, is there.
fn may_have(model: &Model, joint: usize, effect: &Effect) -> bool {
    let listed = &model.joints()[joint].effects;
    let has = |id: &str| listed.iter().any(|(e, _)| e.id == id);
    let lent = effect.needs.borrows.iter().all(|(lender, _)| has(lender));
    let refines = effect.needs.refines;
    let refined = refines.is_empty() || refines.iter().any(|law| has(law));
    !has(effect.id) && lent && refined && has_others(model.tree(), joint, effect)
}

/// An effect on the pairs of joints that do not have it; of channels where every joint has its own.
fn pairs(model: &Model, effect: &'static Effect, joints: &[usize]) -> Vec<Hypothesis> {
    let is_of_channels = matches!(effect.law, Law::Crosstalk);
    let shows = !is_of_channels || model.signal().has_channels_of_motors();
    let taken = |joint: usize, other: usize| {
        let here = match is_of_channels {
            true => Role::Crosstalk(Heard {
                channel: joint,
                source: other,
            }),
            false => Role::Coupling {
                row: joint,
                column: other,
            },
        };
        model.parameters().iter().any(|p| p.role == here)
    };
    let mut open = Vec::new();
    for &joint in joints.iter().filter(|_| shows) {
        for &other in joints.iter().filter(|&&c| c != joint && !taken(joint, c)) {
            open.push(Hypothesis {
                effect,
                joints: vec![joint],
                other: Some(other),
            });
        }
    }
    open
}

/// A load on a link shows only where the links' own inertials are known, or something is known of them.
fn bodies(
    model: &Model,
    prior: &Prior,
    effect: &'static Effect,
    joints: &[usize],
) -> Vec<Hypothesis> {
    let known = |link: usize| {
        let own = |role: Role| matches!(role, Role::Inertial { link: l, .. } if l == link);
        let entries = model.parameters().iter().enumerate();
        let mut entries = entries.filter(|(_, p)| own(p.role));
        entries.any(|(k, p)| !p.is_free() || prior.rows().column(k).amax() > 0.0)
    };
    if model.payload().is_some() {
        return Vec::new();
    }
    let on = |&j: &usize| Hypothesis::on(effect, vec![j]);
    joints.iter().filter(|&&j| known(j)).map(on).collect()
}

/// Names of joints by their numbers.
pub fn joint_names(model: &Model, joints: &[usize]) -> Vec<String> {
    joints
        .iter()
        .map(|&j| model.joints()[j].name.clone())
        .collect()
}

/// Channels of joints; all channels where the signal is the wrench of the base.
pub fn channels_of(model: &Model, joints: &[usize]) -> Vec<usize> {
    let channels = model.channels().iter().enumerate();
    let of = |c: &Channel| c.joint.is_none_or(|j| joints.contains(&j));
    channels
        .filter(|(_, c)| c.active && of(c))
        .map(|(k, _)| k)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::effect::find;
    use crate::chain::model::{ModelSettings, Signal};
    use crate::robot::random::{generator, tree};

    /// Ids of what a model whose two joints have the same effects leaves open on the first.
    fn open_beside(effects: &[&str]) -> Vec<&'static str> {
        let effects: Vec<_> = effects.iter().map(|id| find(id).unwrap()).collect();
        let model = Model::new(ModelSettings {
            effects: vec![effects; 2],
            ..ModelSettings::bodies(tree(&mut generator(3), 2), Signal::Current)
        })
        .unwrap();
        let prior = Prior::none(model.parameters().len());
        let open = open(&model, &prior, None, true).into_iter();
        let first = open.filter(|hypothesis| hypothesis.joints == [0]);
        first.map(|hypothesis| hypothesis.effect.id).collect()
    }

    #[test]
    fn what_refines_a_law_is_open_beside_that_law_alone() {
        for (law, refinement) in [
            ("coulomb_friction", "stribeck_friction"),
            ("sigmoid_friction", "stribeck_friction"),
            ("viscous_friction", "viscous_nonlinearity"),
        ] {
            let (without, with) = (open_beside(&[]), open_beside(&[law]));
            assert!(without.contains(&law) && !without.contains(&refinement));
            assert!(
                !with.contains(&law) && with.contains(&refinement),
                "{with:?}"
            );
        }
    }

    #[test]
    fn no_joint_has_an_effect_twice() {
        for id in open_beside(&[]) {
            let has = find(id).unwrap().law;
            if !has.is_of_pairs() && !matches!(has, Law::Body) {
                assert!(!open_beside(&[id]).contains(&id), "{id}");
            }
        }
    }

    #[test]
    fn the_same_physics_is_told_by_effect_and_joints() {
        let of = |id: &str, joints: &[usize], other: Option<usize>| Hypothesis {
            effect: find(id).unwrap(),
            joints: joints.to_vec(),
            other,
        };
        let delay = of("time_delay", &[0, 1], None);
        assert_eq!(delay, of("time_delay", &[0, 1], None));
        for other in [
            of("torque_offset", &[0, 1], None),
            of("time_delay", &[0], None),
            of("time_delay", &[0, 1], Some(2)),
        ] {
            assert_ne!(delay, other);
        }
        let [part, apart] = [[1], [2]].map(|joints| of("time_delay", &joints, None));
        assert!(part.overlaps(&delay) && delay.overlaps(&part) && !apart.overlaps(&delay));
        assert!(part.is_part_of(&delay) && !delay.is_part_of(&part) && !delay.is_part_of(&delay));
        let offset = of("torque_offset", &[1], None);
        assert!(!apart.is_part_of(&delay) && !offset.is_part_of(&delay));
        assert!(!offset.overlaps(&delay));
    }
}
