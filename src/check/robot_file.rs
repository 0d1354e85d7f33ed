//! The robot file: bodies that cannot be, masses and limits that are absent.

use crate::check::report::finding;
use crate::fault::{Description, Place};
use crate::outcome::check::{Mistake, Severity};
use crate::problem_file::ProblemFile;
use crate::problem_file::choices::Inertials;
use crate::problem_file::robot::RobotSource;
use crate::robot::description::{Note, Weight};
use crate::robot::tree::{Joint, JointKind};
use crate::setup::robot::Robot;
use nalgebra::SymmetricEigen;
use std::f64::consts::TAU;
use std::fs;
use std::ops::RangeInclusive;

/// Share of the largest eigenvalue that decimal numbers in a robot file may miss zero by.
const ROUNDING: f64 = 1e-6;

/// A centre of mass lies within this distance of the link's frame, m, or within [`EXTENTS`] of the link.
const FARTHEST_CENTRE_M: f64 = 1.0;

/// A link that weighs so many times what all others weigh together is a slip of the decimal point.
const OUTLYING_MASS: f64 = 10.0;

/// No joint turns more than four times to one side, rad: cables.
const FARTHEST_TURN: f64 = 4.0 * TAU;

/// Acceleration of free fall at the surface of the Earth, m/s² (Hirt et al. 2013: from the summit of Huascarán to the
/// Arctic Ocean), rounded outwards.
const GRAVITY_OF_EARTH: RangeInclusive<f64> = 9.76..=9.84;

/// Times the largest distance from the link's frame to that of a link it carries.
const EXTENTS: f64 = 2.0;

pub(super) fn check(problem: &ProblemFile, robot: &Robot) -> Vec<Mistake> {
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
    findings.extend(outlying_mass(robot));
    findings.extend(limits_in_degrees(robot));
    findings.extend(angles_in_degrees(problem));
    findings.extend(no_gravity_of_earth(problem, robot));
    findings.extend(robot.description.notes.iter().map(of_note));
    findings
}

/// What the reader of the robot file made of its elements.
fn of_note(note: &Note) -> Mistake {
    let severity = match note.weight {
        Weight::Remark => Severity::Note,
        Weight::LeftOut => Severity::Warning,
    };
    finding(severity, note.place.clone(), note.words.clone())
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

fn impossible(robot: &Robot, joint: &Joint, known: bool) -> Option<Mistake> {
    let eigenvalues = SymmetricEigen::new(joint.inertia.pseudo_inertia()).eigenvalues;
    let (least, largest) = (eigenvalues.min(), eigenvalues.amax());
    (least < -ROUNDING * largest).then(|| {
        finding(
            matters(known),
            at(robot, &joint.link),
            Description::new(
                "impossible-inertia",
                format!(
                    "no body has these inertial parameters: mass {} kg, least eigenvalue of the pseudo-inertia \
                     {least:.3e}",
                    joint.inertia.mass()
                ),
                "correct mass and inertia in the robot file (principal moments obey the triangle inequality)",
            ),
        )
    })
}

fn massless(robot: &Robot, known: bool) -> Option<Mistake> {
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
        Description::new(
            "no-mass",
            format!("links without mass: {}", without.join(", ")),
            "give every moving link its mass, or use inertials = \"estimate\"",
        ),
    ))
}

fn far_centre(robot: &Robot, link: usize) -> Option<Mistake> {
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
            Description::new(
                "far-centre-of-mass",
                format!("the centre of mass is {centre:.3} m from the link's frame, the next frame {reach:.3} m"),
                "give lengths in metres, and the centre of mass in the link's own frame",
            ),
        )
    })
}

fn without_limits(robot: &Robot) -> Option<Mistake> {
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
            Description::new(
                "no-limits",
                format!("no limit of velocity or effort: {}", without.join(", ")),
                "give limits, so that recordings can be checked and motions designed against them",
            ),
        )
    })
}

fn outlying_mass(robot: &Robot) -> Option<Mistake> {
    let joints = robot.tree.joints();
    let heaviest = joints
        .iter()
        .max_by(|a, b| a.inertia.mass().total_cmp(&b.inertia.mass()))?;
    let mass = heaviest.inertia.mass();
    let others = joints.iter().map(|j| j.inertia.mass()).sum::<f64>() - mass;
    (others > 0.0 && mass > OUTLYING_MASS * others).then(|| {
        finding(
            Severity::Warning,
            at(robot, &heaviest.link),
            Description::new(
                "outlying-mass",
                format!(
                    "this link weighs {mass} kg, all other moving links together {others:.4} kg"
                ),
                "give masses in kilograms",
            ),
        )
    })
}

fn limits_in_degrees(robot: &Robot) -> Option<Mistake> {
    let turning = |j: &&Joint| j.kind == JointKind::Revolute;
    let farthest = |j: &Joint| {
        let ends = [j.limits.lower, j.limits.upper].into_iter().flatten();
        ends.map(f64::abs).fold(0.0, f64::max)
    };
    let joints = robot.tree.joints().iter().filter(turning);
    let joint = joints
        .max_by(|a, b| farthest(a).total_cmp(&farthest(b)))
        .filter(|j| farthest(j) > FARTHEST_TURN)?;
    Some(finding(
        Severity::Warning,
        at(robot, &joint.name),
        Description::new(
            "limits-in-degrees",
            format!(
                "a limit of position of {} rad is {:.0} turns",
                farthest(joint),
                farthest(joint) / TAU
            ),
            "give limits of turning joints in radians: multiply degrees by pi/180",
        ),
    ))
}

/// Roll, pitch and yaw of a URDF that go beyond one turn, which nobody writes in radians.
fn angles_in_degrees(problem: &ProblemFile) -> Option<Mistake> {
    let RobotSource::Urdf(path) = &problem.robot.source else {
        return None;
    };
    let text = fs::read_to_string(&path.resolved).ok()?;
    let document = roxmltree::Document::parse(&text).ok()?;
    let (node, angles) = document.descendants().find_map(|node| {
        let angles = node.attribute("rpy")?;
        let mut values = angles
            .split_whitespace()
            .filter_map(|x| x.parse::<f64>().ok());
        values.any(|x| x.abs() > TAU).then_some((node, angles))
    })?;
    let line = document.text_pos_at(node.range().start).row as usize;
    Some(finding(
        Severity::Warning,
        Place {
            line: Some(line),
            ..Place::file(&path.resolved)
        },
        Description::new(
            "angles-in-degrees",
            format!("rpy=\"{angles}\" goes beyond one turn"),
            "give roll, pitch and yaw in radians: multiply degrees by pi/180",
        ),
    ))
}

fn no_gravity_of_earth(problem: &ProblemFile, robot: &Robot) -> Option<Mistake> {
    let size = robot.tree.gravity().norm();
    let place = match &problem.robot.gravity {
        Some(stated) => stated.place.clone(),
        None => at(robot, "gravity"),
    };
    (!GRAVITY_OF_EARTH.contains(&size)).then(|| {
        finding(
            Severity::Warning,
            place,
            Description::new(
                "gravity-size",
                format!("gravity of {size} m/s² is not that of the Earth, 9.76 to 9.84 m/s²"),
                "give the acceleration of free fall in m/s², in the axes of the base: [0.0, 0.0, -9.81] where z points up",
            ),
        )
    })
}
