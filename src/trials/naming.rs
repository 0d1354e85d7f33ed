//! Whether a finding names what a trial concealed.

use crate::outcome::trials::{Found, Hidden};

/// A finding may list so many rivals that it cannot set aside and still be right by one of them.
pub const RIVALS: usize = 2;

/// Whether a finding is the effect, of a pair of joints in its direction, or lists it among the few rivals that it cannot set
/// aside.
pub fn names(finding: &Found, hidden: &Hidden) -> bool {
    let same = |effect: &str, joints: &[String]| effect == hidden.effect && joints == hidden.joints;
    let rivals = &finding.inseparable;
    same(&finding.effect, &finding.joints)
        || (rivals.len() <= RIVALS && rivals.iter().any(|r| same(&r.effect, &r.joints)))
}
