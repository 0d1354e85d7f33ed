//! The robot file: bodies that cannot be, masses and limits that are absent.

use crate::check::finding;
use crate::fault::Place;
use crate::outcome::check::{Finding, Severity};
use crate::problem_file::ProblemFile;
use crate::problem_file::choices::Inertials;
use crate::robot::tree::Joint;
use crate::setup::robot::Robot;
use nalgebra::SymmetricEigen;

/// Share of the largest eigenvalue that decimal numbers in a robot file may miss zero by.
const ROUNDING: f64 = 1e-6;

/// A centre of mass lies within this distance of the link's frame, m, or within [`EXTENTS`] of the link.
const FARTHEST_CENTRE_M: f64 = 1.0;

/// Times the largest distance from the link's frame to that of a link it carries.
const EXTENTS: f64 = 2.0;

pub(super) fn check(problem: &ProblemFile, robot: &Robot) -> Vec<Finding> {
    let known = problem.robot.inertials.value == Inertials::Known;
    let mut findings = Vec::new();
    for joint in robot.tree.joints() {
        findings.extend(impossible(robot, joint, known));
    }
    findings.extend(massless(robot, known));
    for link in 0..robot.tree.len() {
        findings.extend(far_centre(robot, link));
    }
    findings.extend(without_limits(robot));
    findings
}

fn matters(known: bool) -> Severity {
    if known {
        Severity::Error
    } else {
        Severity::Warning
    }
}

fn at(robot: &Robot, name: &str) -> Place {
    Place::file(&robot.file).key(name)
}

fn impossible(robot: &Robot, joint: &Joint, known: bool) -> Option<Finding> {
    let eigenvalues = SymmetricEigen::new(joint.inertia.pseudo_inertia()).eigenvalues;
    let (least, largest) = (eigenvalues.min(), eigenvalues.amax());
    (least < -ROUNDING * largest).then(|| {
        finding(
            matters(known),
            at(robot, &joint.link),
            (
                "impossible-inertia",
                format!(
                    "no body has these inertial parameters: mass {} kg, least eigenvalue of the pseudo-inertia \
                     {least:.3e}",
                    joint.inertia.mass()
                ),
                "correct mass and inertia in the robot file (principal moments obey the triangle inequality)"
                    .to_string(),
            ),
        )
    })
}

fn massless(robot: &Robot, known: bool) -> Option<Finding> {
    let joints = robot.tree.joints().iter();
    let without: Vec<&str> = joints
        .filter(|j| j.inertia.mass() == 0.0)
        .map(|j| j.link.as_str())
        .collect();
    let all = without.len() == robot.tree.len();
    // A file of kinematics only is usual where inertials are estimated.
    if without.is_empty() || (all && !known) {
        return None;
    }
    let place = match without.as_slice() {
        [one] => at(robot, one),
        _ => Place::file(&robot.file),
    };
    let severity = if known {
        Severity::Warning
    } else {
        Severity::Note
    };
    Some(finding(
        severity,
        place,
        (
            "no-mass",
            format!("links without mass: {}", without.join(", ")),
            "give every moving link its mass, or use inertials = \"estimate\"".to_string(),
        ),
    ))
}

fn far_centre(robot: &Robot, link: usize) -> Option<Finding> {
    let joint = &robot.tree.joints()[link];
    let centre = joint.inertia.central()?.centre.norm();
    let children = robot
        .tree
        .joints()
        .iter()
        .filter(|j| j.parent == Some(link));
    let frames = robot.tree.frames().iter().filter(|f| f.joint == Some(link));
    let reach = children
        .map(|j| j.translation.norm())
        .chain(frames.map(|f| f.placement.translation.vector.norm()))
        .fold(0.0, f64::max);
    (centre > (EXTENTS * reach).max(FARTHEST_CENTRE_M)).then(|| {
        finding(
            Severity::Warning,
            at(robot, &joint.link),
            (
                "far-centre-of-mass",
                format!("the centre of mass is {centre:.3} m from the link's frame, the next frame {reach:.3} m"),
                "give lengths in metres, and the centre of mass in the link's own frame".to_string(),
            ),
        )
    })
}

fn without_limits(robot: &Robot) -> Option<Finding> {
    let lacks = |j: &&Joint| {
        let limits = &j.limits;
        limits.velocity.is_none() || limits.effort.is_none()
    };
    let joints = robot.tree.joints().iter();
    let without: Vec<&str> = joints.filter(lacks).map(|j| j.name.as_str()).collect();
    (!without.is_empty()).then(|| {
        finding(
            Severity::Note,
            Place::file(&robot.file),
            (
                "no-limits",
                format!("no limit of velocity or effort: {}", without.join(", ")),
                "give limits, so that recordings can be checked and motions designed against them"
                    .to_string(),
            ),
        )
    })
}
