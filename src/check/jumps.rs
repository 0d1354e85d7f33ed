//! Steps of positions that no motion makes: slipped encoders, turns counted anew, lost samples, two recordings in one file.

use crate::check::context::RawRecording;
use crate::check::report::finding;
use crate::fault::Description;
use crate::outcome::check::{Mistake, Severity};
use crate::recording::jumps::{JointJump, Jump, jumps};
use crate::recording::samples::Recording;
use std::f64::consts::TAU;

/// Relative difference of a jump from a whole turn from which it is none.
const TURN: f64 = 0.02;

/// Difference of a delay from a whole number of samples, in samples, from which it is none.
const WHOLE: f64 = 0.1;

pub(super) fn check(read: &RawRecording<'_>) -> Vec<Mistake> {
    let mut all = jumps(read.recording);
    all.retain(|jump| read.counts(jump.before) && read.counts(jump.before + 1));
    let slips: Vec<&Jump> = all.iter().filter(|jump| is_slip(jump)).collect();
    let lost: Vec<&Jump> = all.iter().filter(|jump| is_lost(jump)).collect();
    let worst = slips
        .iter()
        .max_by(|a, b| largest(a).total_cmp(&largest(b)));
    let of_slips = worst.map(|worst| slipped(read, worst, slips.len()));
    let of_lost = lost.first().map(|first| unsteady(read, first, lost.len()));
    of_slips.into_iter().chain(of_lost).collect()
}

/// Whether a mistake is one that no physics makes, be it in one recording alone.
pub fn is_no_physics(mistake: &Mistake) -> bool {
    mistake.code == "position-jumps"
}

/// Whether no sample at a wrong time explains a jump.
fn is_slip(jump: &Jump) -> bool {
    jump.late.is_none() && jump.joints.iter().any(|of| of.is_beyond_motion)
}

/// Whether a whole number of samples is lost, or one is written twice.
fn is_lost(jump: &Jump) -> bool {
    let is_whole = |late: f64| {
        let whole = late.round();
        (late - whole).abs() < WHOLE && (whole == -1.0 || whole >= 1.0)
    };
    jump.late.is_some_and(is_whole)
}

fn largest(jump: &Jump) -> f64 {
    let sizes = jump.joints.iter().map(|of| of.size.abs());
    sizes.fold(0.0, f64::max)
}

fn slipped(read: &RawRecording<'_>, worst: &Jump, count: usize) -> Mistake {
    let name = |of: &JointJump| read.context.joint(of.joint).name.clone();
    let sizes: Vec<String> = match worst.joints[..] {
        [of] => vec![format!("by {:.4}", of.size)],
        _ => (worst.joints.iter())
            .map(|of| format!("{} by {:.4}", name(of), of.size))
            .collect(),
    };
    let turns = worst
        .joints
        .iter()
        .all(|of| read.context.is_revolute(of.joint) && is_turn(of));
    let remedy = match (turns, worst.joints.len() > 1) {
        (true, _) => "the angle starts anew after a turn: unwrap it, so that it goes on",
        (false, true) => {
            "if the file holds two recordings, write each into a file of its own; else cut the file there"
        }
        (false, false) => {
            "if the encoder slipped there, write the parts before and after into files of their own"
        }
    };
    let others = match count {
        1 => String::new(),
        count => format!("; there are {count} such steps"),
    };
    let place = match worst.joints[..] {
        [of] => read.at_joint(of.joint),
        _ => read.place(),
    };
    finding(
        Severity::Error,
        place.line(read.recording.line(worst.before + 1)),
        Description::new(
            "position-jumps",
            format!(
                "between two samples at {:.3} s the position jumps as no motion does, {}{others}",
                read.time(worst.before),
                sizes.join(", ")
            ),
            remedy,
        ),
    )
}

/// Joints whose angle starts anew after a turn.
pub(super) fn starting_anew(recording: &Recording) -> Vec<usize> {
    let all = jumps(recording);
    let of_joints = all.iter().flat_map(|jump| &jump.joints);
    of_joints
        .filter(|of| is_turn(of))
        .map(|of| of.joint)
        .collect()
}

fn is_turn(of: &JointJump) -> bool {
    let turns = of.size.abs() / TAU;
    turns.round() >= 1.0 && (turns / turns.round() - 1.0).abs() < TURN
}

/// Samples that are lost or written twice in a file whose stamps do not say so.
fn unsteady(read: &RawRecording<'_>, first: &Jump, count: usize) -> Mistake {
    let places = match count {
        1 => "one place".to_owned(),
        count => format!("{count} places"),
    };
    finding(
        Severity::Warning,
        read.place().line(read.recording.line(first.before + 1)),
        Description::new(
            "samples-lost",
            format!(
                "at {places} all joints move by a whole number of usual steps too far or not at all, as where samples are lost or \
                 written twice; first at {:.3} s",
                read.time(first.before)
            ),
            "record time stamps and name their column; every later sample is at a wrong time otherwise",
        ),
    )
}
