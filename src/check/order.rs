//! Joint order, signs and zeros of positions, direction of gravity: which reading of the columns makes the
//! signal a function of the motion?
//!
//! Every hypothesis h changes the motion (or gravity), then every channel is explained by the row of every
//! joint with all parameters free. The gain of h is `G = Σ_c ln(σ_c(declared) / σ_c(h))`, σ the residual
//! deviations: N·G is the logarithm of the likelihood ratio for N rows of normal noise.

use crate::chain::model::Model;
use crate::check::finding;
use crate::check::regression::{Comparison, Sampled, columns, factor, rest, with_tree};
use crate::check::setting::Ready;
use crate::outcome::check::{Finding, Severity};
use crate::robot::tree::JointKind;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// Least gain that is no accident of what the model leaves out: the product of all residual deviations
/// falls by a factor of three. In N·G standard terms anything above 0.02 is significant.
const LEAST_GAIN: f64 = 1.1;

/// Another reading of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Hypothesis {
    Declared,
    /// Position columns of two joints exchanged.
    Exchanged(usize, usize),
    /// Positions of a joint with the other sign.
    Reversed(usize),
    /// Zero of a turning joint elsewhere, rad.
    Turned(usize, f64),
    /// Gravity along another axis of the base: axis and sign.
    Gravity(usize, f64),
}

/// A hypothesis with the signal that each row explains best.
struct Reading {
    hypothesis: Hypothesis,
    /// Joint whose row each channel follows, by position in the list of channels.
    assignment: Vec<usize>,
    /// ln σ of each channel.
    deviations: Vec<f64>,
}

pub(super) fn check(ready: &Ready<'_>) -> Vec<Finding> {
    let comparison = &ready.comparison;
    let channels = comparison.joint_channels();
    if !comparison.is_meaningful() || channels.is_empty() {
        return Vec::new();
    }
    let declared = Reading {
        assignment: (0..channels.len()).collect(),
        ..read(comparison, &channels, Hypothesis::Declared, Assignment::Kept)
    };
    let hypotheses = hypotheses(comparison, &channels);
    let readings: Vec<Reading> = hypotheses
        .into_par_iter()
        .map(|(hypothesis, assignment)| read(comparison, &channels, hypothesis, assignment))
        .collect();
    let gain = |reading: &Reading| -> f64 {
        let pairs = declared.deviations.iter().zip(&reading.deviations);
        pairs.map(|(before, after)| before - after).sum()
    };
    // The first of equals: the plainest reading stands first.
    let best = readings.iter().rev().max_by(|a, b| gain(a).total_cmp(&gain(b)));
    match best {
        Some(best) if gain(best) > LEAST_GAIN => describe(ready, &channels, best, gain(best)),
        _ => Vec::new(),
    }
}

/// Whether channels may follow the rows of other joints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Assignment {
    Kept,
    Free,
}

fn hypotheses(
    comparison: &Comparison,
    channels: &[(usize, usize)],
) -> Vec<(Hypothesis, Assignment)> {
    let joints: Vec<usize> = channels.iter().map(|(_, joint)| *joint).collect();
    let mut list = vec![(Hypothesis::Declared, Assignment::Free)];
    for (k, &i) in joints.iter().enumerate() {
        for &j in &joints[k + 1..] {
            list.push((Hypothesis::Exchanged(i, j), Assignment::Free));
        }
    }
    for &j in &joints {
        list.push((Hypothesis::Reversed(j), Assignment::Kept));
        let revolute = comparison.model.joints()[j].kind == JointKind::Revolute;
        for angle in [FRAC_PI_2, -FRAC_PI_2, PI] {
            list.extend(revolute.then_some((Hypothesis::Turned(j, angle), Assignment::Kept)));
        }
    }
    let gravity = comparison.model.tree().gravity();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            // The declared direction is not another one.
            let other = sign * gravity[axis] < 0.9 * gravity.norm();
            let there = gravity.norm() > 0.0 && other;
            list.extend(there.then_some((Hypothesis::Gravity(axis, sign), Assignment::Kept)));
        }
    }
    list
}

fn read(
    comparison: &Comparison,
    channels: &[(usize, usize)],
    hypothesis: Hypothesis,
    assignment: Assignment,
) -> Reading {
    let sampled = moved(&comparison.sampled, hypothesis);
    let explained = explained(comparison, channels, (hypothesis, &sampled));
    let mut order: Vec<usize> = (0..channels.len()).collect();
    if assignment == Assignment::Free {
        exchange_while_better(&explained, &mut order);
    }
    let deviations = order.iter().enumerate().map(|(c, &row)| explained[(c, row)]);
    Reading {
        hypothesis,
        deviations: deviations.collect(),
        assignment: order,
    }
}

/// ln σ of every channel (rows) explained by the row of every joint (columns).
fn explained(
    comparison: &Comparison,
    channels: &[(usize, usize)],
    (hypothesis, sampled): (Hypothesis, &Sampled),
) -> DMatrix<f64> {
    let turned = match hypothesis {
        Hypothesis::Gravity(axis, sign) => Some(with_gravity(comparison, axis, sign)),
        _ => None,
    };
    let model = turned.as_ref().unwrap_or(&comparison.model);
    let fresh = columns(model, sampled, &comparison.parameters);
    let signals: Vec<&[f64]> =
        channels.iter().map(|&(c, _)| comparison.torque[c].as_slice()).collect();
    let mut out = DMatrix::zeros(channels.len(), channels.len());
    for (row, &(c, _)) in channels.iter().enumerate() {
        let factor = factor(&fresh[c], &signals);
        let freedom = sampled.len().saturating_sub(fresh[c].len()).max(1) as f64;
        for (signal, series) in signals.iter().enumerate() {
            let size = series.iter().map(|s| s * s).sum::<f64>().sqrt();
            // Simulated signals without noise leave rounding: below a part in 10^6 nothing is told apart.
            let left = rest(&factor, fresh[c].len(), signal).max(1e-6 * size).max(f64::MIN_POSITIVE);
            out[(signal, row)] = (left / freedom.sqrt()).ln();
        }
    }
    out
}

fn with_gravity(comparison: &Comparison, axis: usize, sign: f64) -> Model {
    let tree = comparison.model.tree();
    let mut gravity = [0.0; 3];
    gravity[axis] = sign * tree.gravity().norm();
    with_tree(&comparison.model, tree.clone().with_gravity(gravity))
}

fn moved(sampled: &Sampled, hypothesis: Hypothesis) -> Sampled {
    let mut moved = sampled.clone();
    match hypothesis {
        Hypothesis::Exchanged(i, j) => {
            moved.position.swap(i, j);
            moved.velocity.swap(i, j);
            moved.acceleration.swap(i, j);
        }
        Hypothesis::Reversed(j) => {
            for series in [&mut moved.position, &mut moved.velocity, &mut moved.acceleration] {
                series[j].iter_mut().for_each(|x| *x = -*x);
            }
        }
        Hypothesis::Turned(j, angle) => moved.position[j].iter_mut().for_each(|x| *x += angle),
        Hypothesis::Declared | Hypothesis::Gravity(..) => {}
    }
    moved
}

/// Exchanges two rows of the assignment as long as that lowers the sum of ln σ.
fn exchange_while_better(explained: &DMatrix<f64>, order: &mut [usize]) {
    let n = order.len();
    loop {
        let mut best: Option<(f64, usize, usize)> = None;
        for a in 0..n {
            for b in a + 1..n {
                let before = explained[(a, order[a])] + explained[(b, order[b])];
                let after = explained[(a, order[b])] + explained[(b, order[a])];
                if before - after > best.map_or(1e-9, |(gain, ..)| gain) {
                    best = Some((before - after, a, b));
                }
            }
        }
        let Some((_, a, b)) = best else {
            return;
        };
        order.swap(a, b);
    }
}

fn describe(
    ready: &Ready<'_>,
    channels: &[(usize, usize)],
    reading: &Reading,
    gain: f64,
) -> Vec<Finding> {
    let name = |joint: usize| ready.model.joints()[joint].name.clone();
    let factor = (gain / channels.len() as f64).exp();
    let evidence =
        format!("the residuals are then {factor:.2} times smaller, on the average over all joints");
    let error = |place, code: &str, message: String, remedy: &str| {
        finding(
            Severity::Error,
            place,
            (code, format!("{message}; {evidence}"), remedy.to_string()),
        )
    };
    let moved: Vec<usize> =
        (0..channels.len()).filter(|&c| reading.assignment[c] != c).collect();
    match reading.hypothesis {
        Hypothesis::Declared => moved
            .iter()
            .map(|&c| {
                let follows = name(channels[reading.assignment[c]].1);
                error(
                    ready.at_channel(channels[c].0),
                    "joint-order",
                    format!("the signal of this joint follows the motion of {follows}"),
                    "put the columns of the signal into the order of the joints",
                )
            })
            .collect(),
        Hypothesis::Exchanged(i, j) => {
            let what = if moved.is_empty() { "positions" } else { "positions and signals" };
            [(i, j), (j, i)]
                .map(|(own, other)| {
                    error(
                        ready.at_channel_of(own),
                        "joint-order",
                        format!("{what} of this joint look like those of {}", name(other)),
                        "put the columns into the order of the joints, or correct robot.joints",
                    )
                })
                .to_vec()
        }
        Hypothesis::Reversed(j) => vec![error(
            ready.at_channel_of(j),
            "position-sign",
            "the position looks as if it counted the other way than the robot file's joint".to_string(),
            "change the sign of the position (a negative drive.ratio does), and of the signal if it has the \
             same sign convention",
        )],
        Hypothesis::Turned(j, angle) => vec![error(
            ready.at_channel_of(j),
            "position-zero",
            format!(
                "the zero of the position looks {:+.0} degrees away from the robot file's",
                angle.to_degrees()
            ),
            "set drive.offset for this joint",
        )],
        Hypothesis::Gravity(axis, sign) => vec![error(
            ready.place().key("robot.gravity"),
            "gravity-direction",
            format!(
                "gravity looks as if it pointed along {}{} of the base frame",
                if sign < 0.0 { "-" } else { "+" },
                ["x", "y", "z"][axis]
            ),
            "set robot.gravity as the base is mounted",
        )],
    }
}
