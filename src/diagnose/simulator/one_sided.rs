//! Differences and agreements of robot and simulator, and physics that only one of them has.

use crate::diagnose::simulator::contrast::{LEVEL, Tested};
use crate::diagnose::simulator::sentences;
use crate::diagnose::simulator::side::{NEGLIGIBLE, Named, Side};
use crate::diagnose::simulator::subject::Subject;
use crate::outcome::finding::Finding;
use crate::outcome::simulator::{Contrast, OneSided};

/// Contrasts by what they say.
#[derive(Default)]
pub(super) struct Sorted {
    pub differences: Vec<Contrast>,
    pub agree: Vec<Contrast>,
    pub only_robot: Vec<OneSided>,
    pub only_simulator: Vec<OneSided>,
    pub notes: Vec<String>,
}

pub(super) fn sort(tested: Vec<Tested>, simulator: &Side<'_>, robot: &Side<'_>) -> Sorted {
    let mut sorted = Sorted::default();
    for Tested {
        contrast,
        leading,
        single,
    } in tested
    {
        let matters = contrast.share_of_signal.is_nan() || contrast.share_of_signal >= NEGLIGIBLE;
        if !(contrast.p_value < LEVEL && matters) {
            sorted.agree.push(contrast);
            continue;
        }
        let named = single.then(|| Named::of(&leading)).flatten();
        let alone =
            named
                .as_ref()
                .and_then(|named| match (simulator.shows(named), robot.shows(named)) {
                    (false, true) => Some(Subject::Robot),
                    (true, false) => Some(Subject::Simulator),
                    _ => None,
                });
        match (alone, &named) {
            (Some(subject), Some(named)) => {
                let (list, side) = match subject {
                    Subject::Robot => (&mut sorted.only_robot, robot),
                    Subject::Simulator => (&mut sorted.only_simulator, simulator),
                };
                add(list, subject, side, named, contrast);
            }
            _ => sorted.differences.push(contrast),
        }
    }
    let sides = [
        (Subject::Robot, robot, simulator),
        (Subject::Simulator, simulator, robot),
    ];
    for (subject, own, other) in sides {
        let left = own.unexplained();
        if !left.is_empty() && !sorted.differences.is_empty() {
            sorted
                .notes
                .push(sentences::left_unexplained(subject, &left));
        }
        for finding in own.findings.iter().filter(|finding| own.matters(finding)) {
            let lists = match subject {
                Subject::Robot => &mut sorted.only_robot,
                Subject::Simulator => &mut sorted.only_simulator,
            };
            if lists.iter().any(|l| is_same(l, finding)) {
                continue;
            }
            match counterpart(finding, other) {
                Counterpart::None => lists.push(of_finding(subject, finding)),
                Counterpart::Same => {}
                Counterpart::Alike(effect) => sorted
                    .notes
                    .push(sentences::not_told_apart(subject, finding, &effect)),
            }
        }
    }
    sorted
}

/// A contrast of an effect that one side has.
fn add(
    list: &mut Vec<OneSided>,
    subject: Subject,
    side: &Side<'_>,
    named: &Named<'_>,
    contrast: Contrast,
) {
    let joints: Vec<String> = named.joint.iter().map(|j| j.to_string()).collect();
    let known = list
        .iter_mut()
        .find(|o| o.effect == named.effect.id && o.joints == joints);
    if let Some(known) = known {
        known.contrasts.push(contrast);
        return;
    }
    list.push(OneSided {
        effect: named.effect.id.to_string(),
        sentence: sentences::alone(subject, &contrast),
        joints,
        parameters: side.of_effect(named).into_iter().cloned().collect(),
        contrasts: vec![contrast],
    });
}

fn of_finding(subject: Subject, finding: &Finding) -> OneSided {
    OneSided {
        effect: finding.effect.clone(),
        joints: finding.joints.clone(),
        parameters: finding.parameters.clone(),
        contrasts: Vec::new(),
        sentence: sentences::finding_alone(subject, finding),
    }
}

fn is_same(one: &OneSided, finding: &Finding) -> bool {
    one.effect == finding.effect && one.joints == finding.joints
}

/// What the other side has of a finding.
enum Counterpart {
    None,
    Same,
    /// Physics that the recordings cannot tell from it.
    Alike(String),
}

fn counterpart(finding: &Finding, other: &Side<'_>) -> Counterpart {
    let declares = |effect: &str| {
        let mut all = other.estimate.parameters.iter();
        all.any(|p| {
            Named::of(&p.name).is_some_and(|n| {
                n.effect.id == effect
                    && n.joint
                        .is_none_or(|j| finding.joints.iter().any(|own| own == j))
            })
        })
    };
    let finds = |effect: &str, joints: &[String]| {
        let mut all = other.findings.iter();
        all.any(|f| f.effect == effect && f.joints == joints)
    };
    if finds(&finding.effect, &finding.joints) || declares(&finding.effect) {
        return Counterpart::Same;
    }
    let own_rivals = finding.rivals.iter().filter(|r| !r.separable);
    for rival in own_rivals {
        if finds(&rival.effect, &rival.joints) {
            return Counterpart::Alike(rival.effect.clone());
        }
    }
    let theirs = other.findings.iter().find(|f| {
        let mut alike = f.rivals.iter().filter(|r| !r.separable);
        alike.any(|r| r.effect == finding.effect && r.joints == finding.joints)
    });
    // What has no name on one side may be what has one on the other, at the same joint.
    let nameless = other.findings.iter().find(|f| {
        let shares_a_joint = f.joints.iter().any(|joint| finding.joints.contains(joint));
        shares_a_joint && (f.has_no_name() || finding.has_no_name())
    });
    match theirs.or(nameless) {
        Some(finding) => Counterpart::Alike(finding.effect.clone()),
        None => Counterpart::None,
    }
}
