//! Joints that follow others, from names to one affine law of a joint that follows none.
//!
//! `q_a = m₁ q_b + o₁` and `q_b = m₂ q_c + o₂` give `q_a = m₁ m₂ q_c + m₁ o₂ + o₁`.

use crate::fault::{Place, nearest};
use crate::robot::description::{Dependent, Held};
use crate::robot::error::{RobotError, RobotErrorKind};
use crate::robot::tree::Tree;

/// A joint that follows another as its file states it: `q_joint = multiplier · q_leader + offset`.
#[derive(Debug, Clone)]
pub(crate) struct RawDependent {
    pub joint: String,
    pub leader: String,
    pub multiplier: f64,
    pub offset: f64,
    pub place: Place,
}

/// The joints of a tree that follow others, and those that follow nothing that moves.
#[derive(Debug, Clone, Default)]
pub(crate) struct Resolved {
    pub dependents: Vec<Dependent>,
    pub held: Vec<Held>,
}

/// Finds the joints by name and follows chains to the joint that moves by itself. Joints that do not move, `still`, hold
/// what follows them at the offset.
///
/// # Errors
/// A leader that does not exist, a joint that follows two, joints that follow each other in a circle.
pub(crate) fn resolve(
    tree: &Tree,
    still: &[String],
    stated: &[RawDependent],
) -> Result<Resolved, RobotError> {
    let fail = |raw: &RawDependent, kind| Err(RobotError::new(raw.place.clone(), kind));
    let mut resolved = Resolved::default();
    for (k, raw) in stated.iter().enumerate() {
        let Some(joint) = tree.joint_index(&raw.joint) else {
            continue;
        };
        if let Some(other) = stated[..k].iter().find(|other| other.joint == raw.joint) {
            let leaders = [other.leader.clone(), raw.leader.clone()];
            return fail(raw, RobotErrorKind::TwoLeaders { leaders });
        }
        let (mut multiplier, mut offset) = (raw.multiplier, raw.offset);
        let mut circle = vec![raw.joint.clone()];
        let mut leader = &raw.leader;
        while let Some(next) = stated.iter().find(|next| next.joint == *leader) {
            circle.push(leader.clone());
            if circle.len() > stated.len() {
                return fail(raw, RobotErrorKind::LeadersInCircle { joints: circle });
            }
            offset += multiplier * next.offset;
            multiplier *= next.multiplier;
            leader = &next.leader;
        }
        match tree.joint_index(leader) {
            Some(leader) if leader == joint => {
                return fail(raw, RobotErrorKind::LeadersInCircle { joints: circle });
            }
            Some(leader) if multiplier != 0.0 => resolved.dependents.push(Dependent {
                joint,
                leader,
                multiplier,
                offset,
            }),
            None if !still.contains(leader) => {
                let names = tree.joints().iter().map(|j| j.name.as_str());
                let kind = RobotErrorKind::UnknownLeader {
                    found: leader.clone(),
                    nearest: nearest(leader, names),
                };
                return fail(raw, kind);
            }
            _ => resolved.held.push(Held {
                joint,
                position: offset,
            }),
        }
    }
    Ok(resolved)
}
