//! Whether a finding names what a trial concealed.

use crate::outcome::trials::{Found, Hidden};

/// A finding may list so many rivals that it cannot set aside and still be right by one of them.
pub const RIVALS: usize = 2;

/// Whether a finding is the effect, or lists it among the few rivals that it cannot set aside.
pub fn names(finding: &Found, hidden: &Hidden) -> bool {
    let same = |effect: &str, joints: &[String]| {
        effect == hidden.effect && same_joints(joints, &hidden.joints)
    };
    let rivals = &finding.inseparable;
    same(&finding.effect, &finding.joints)
        || (rivals.len() <= RIVALS && rivals.iter().any(|r| same(&r.effect, &r.joints)))
}

pub(super) fn same_joints(a: &[String], b: &[String]) -> bool {
    a.len() == b.len() && a.iter().all(|joint| b.contains(joint))
}
