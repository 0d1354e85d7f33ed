//! Joint order, signs and zeros of positions, direction of gravity: which reading of the columns makes the
//! signal a function of the motion?
//!
//! Every hypothesis h changes the motion, gravity or the assignment of signals to joints; all parameters are
//! free, and the same in all rows. The gain of h is `G = Σ_c ln(σ_c(declared) / σ_c(h))`, σ the residual
//! deviations: N·G is the logarithm of the likelihood ratio for N rows of normal noise.

use crate::chain::effect::tilt::tilted;
use crate::check::context::PreparedRecording;
use crate::check::regression::{Comparison, Sampled, with_tree};
use crate::check::report::finding;
use crate::check::shared::{Rows, base};
use crate::fault::Description;
use crate::outcome::check::{Mistake, Severity};
use crate::robot::tree::JointKind;
use nalgebra::Vector3;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// Least gain that is no accident of what the model leaves out: the product of all residual deviations
/// falls by a factor of three.
const LEAST_GAIN: f64 = 1.1;

/// Gain of one channel that counts, and how many must have it: a column in the wrong place spoils at least
/// the two joints that it is about, while a weak signal may by chance follow the row of another joint.
const CHANNEL_GAIN: f64 = 0.4;
const CHANNELS: usize = 2;

/// Base parameters up to which all readings are tried, about those of 16 joints: each of some n² readings costs n³ and more, and
/// 40 joints take minutes.
const MOST_UNKNOWNS: usize = 200;

/// Largest tilt of a base that was put up as stated, rad; what is more is another mounting.
const STEEPEST: f64 = 0.25;

/// Steps of the search for a tilt, rad: the first halves the range, and the last is as much as levels of mountings are off.
const FIRST_STEP: f64 = 0.125;
const LAST_STEP: f64 = 0.002;

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
    /// A base that is tilted by roll and pitch, rad.
    Tilted([f64; 2]),
}

/// A hypothesis with the rows that the signals belong to.
#[derive(Clone)]
struct Reading {
    hypothesis: Hypothesis,
    /// Position, among the judged channels, of the row that each signal follows.
    assignment: Vec<usize>,
    /// ln σ of each signal.
    deviations: Vec<f64>,
}

impl Reading {
    fn cost(&self) -> f64 {
        self.deviations.iter().sum()
    }
}

/// What is judged: (channel, joint) of every joint that moves, and the parameters behind all of them.
struct Judged<'a> {
    comparison: &'a Comparison,
    channels: Vec<(usize, usize)>,
    base: Vec<usize>,
}

/// What [`find`] has found.
pub(super) fn check(ready: &PreparedRecording<'_>) -> Vec<Mistake> {
    ready.other_reading.clone()
}

/// Looks for a reading of the columns that explains the signal far better than the declared one.
pub(super) fn find(ready: &PreparedRecording<'_>) -> Vec<Mistake> {
    let comparison = &ready.comparison;
    // A joint that stands still follows any row, and any joint its row.
    let mut channels = comparison.joint_channels();
    channels.retain(|&(_, joint)| comparison.moves(joint));
    if !comparison.is_meaningful() || channels.is_empty() {
        return Vec::new();
    }
    let judged = Judged {
        comparison,
        channels,
        base: base(&comparison.model, comparison.sampled.loaded),
    };
    let (_, named) = judged.named(Hypothesis::Declared);
    if !judged.may_gain(&named) {
        return Vec::new();
    }
    if judged.base.len() > MOST_UNKNOWNS {
        return vec![not_tried(ready, judged.channels.len())];
    }
    let readings: Vec<(Reading, Reading)> = judged
        .hypotheses()
        .into_par_iter()
        .map(|h| judged.read(h))
        .collect();
    let Some((declared, _)) = readings.first() else {
        return Vec::new();
    };
    let stands = |best: &&Reading| {
        let gains = declared.deviations.iter().zip(&best.deviations);
        let gaining = gains
            .filter(|(before, after)| *before - *after > CHANNEL_GAIN)
            .count();
        gaining >= judged.channels.len().min(CHANNELS) && declared.cost() - best.cost() > LEAST_GAIN
    };
    // The first of equals: the plainest reading stands first.
    let best = readings.iter().rev().map(|(_, best)| best).filter(stands);
    let Some(best) = best.min_by(|a, b| a.cost().total_cmp(&b.cost())) else {
        return Vec::new();
    };
    // Half a turn of a first axis that leans does what a tilt of the base does, which is the lesser mistake.
    let tilted = judged.tilted(declared);
    let best = match tilted.cost() - best.cost() < LEAST_GAIN {
        true => &tilted,
        false => best,
    };
    describe(ready, &judged.channels, best, declared.cost() - best.cost())
}

impl Judged<'_> {
    /// Every hypothesis; the recording as declared comes first.
    fn hypotheses(&self) -> Vec<Hypothesis> {
        let joints: Vec<usize> = self.channels.iter().map(|(_, joint)| *joint).collect();
        let mut list = vec![Hypothesis::Declared];
        for (k, &i) in joints.iter().enumerate() {
            list.extend(joints[k + 1..].iter().map(|&j| Hypothesis::Exchanged(i, j)));
        }
        for &j in &joints {
            list.push(Hypothesis::Reversed(j));
            if self.comparison.model.joints()[j].kind == JointKind::Revolute {
                let angles = [FRAC_PI_2, -FRAC_PI_2, PI];
                list.extend(angles.map(|angle| Hypothesis::Turned(j, angle)));
            }
        }
        let gravity = self.comparison.model.tree().gravity();
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                // The declared direction is not another one.
                let other = sign * gravity[axis] < 0.9 * gravity.norm();
                list.extend(other.then_some(Hypothesis::Gravity(axis, sign)));
            }
        }
        list
    }

    /// The best reading with a tilted base, by steps to and fro in roll and pitch that are halved where none gains.
    fn tilted(&self, declared: &Reading) -> Reading {
        let mut best = Reading {
            hypothesis: Hypothesis::Tilted([0.0; 2]),
            ..declared.clone()
        };
        let (mut tilt, mut step) = ([0.0; 2], FIRST_STEP);
        while step >= LAST_STEP {
            let ways = [[step, 0.0], [-step, 0.0], [0.0, step], [0.0, -step]];
            let next = ways.map(|way| [tilt[0] + way[0], tilt[1] + way[1]]);
            let inside = next
                .into_par_iter()
                .filter(|t| t[0].hypot(t[1]) <= STEEPEST);
            let readings = inside.map(|t| (t, self.named(Hypothesis::Tilted(t)).1));
            let found = readings.min_by(|(_, a), (_, b)| a.cost().total_cmp(&b.cost()));
            match found.filter(|(_, reading)| reading.cost() < best.cost()) {
                Some((at, reading)) => (tilt, best) = (at, reading),
                None => step *= 0.5,
            }
        }
        best
    }

    /// Whether another reading can be a finding: none leaves less of a signal than its white noise.
    fn may_gain(&self, named: &Reading) -> bool {
        let of = |((channel, _), deviation): (&(usize, usize), &f64)| {
            let noise = self.comparison.noise[*channel];
            noise.map_or(f64::INFINITY, |noise| (deviation - noise.ln()).max(0.0))
        };
        let most: Vec<f64> = self
            .channels
            .iter()
            .zip(&named.deviations)
            .map(of)
            .collect();
        let gaining = most.iter().filter(|gain| **gain > CHANNEL_GAIN).count();
        gaining >= most.len().min(CHANNELS) && most.iter().sum::<f64>() > LEAST_GAIN
    }

    /// The rows of a hypothesis, and the signals as they are named.
    fn named(&self, hypothesis: Hypothesis) -> (Rows, Reading) {
        let sampled = moved(&self.comparison.sampled, hypothesis);
        let gravity = self.comparison.model.tree().gravity();
        let turned = match hypothesis {
            Hypothesis::Gravity(axis, sign) => {
                let mut along = Vector3::zeros();
                along[axis] = sign * gravity.norm();
                Some(along)
            }
            Hypothesis::Tilted(angles) => Some(tilted(&gravity, angles)),
            _ => None,
        };
        let turned = turned.map(|gravity| {
            let tree = self.comparison.model.tree().clone();
            with_tree(&self.comparison.model, tree.with_gravity(gravity.into()))
        });
        let model = turned.as_ref().unwrap_or(&self.comparison.model);
        let channels: Vec<usize> = self.channels.iter().map(|(c, _)| *c).collect();
        // A first axis that is no longer vertical shows more of the robot's mass.
        let base = turned.as_ref().map(|model| base(model, sampled.loaded));
        let base = base.as_ref().unwrap_or(&self.base);
        let rows = Rows::new(self.comparison, model, &sampled, &channels, base);
        let assignment: Vec<usize> = (0..channels.len()).collect();
        let reading = Reading {
            hypothesis,
            deviations: rows.deviations(&assignment),
            assignment,
        };
        (rows, reading)
    }

    /// The signals as they are named, and the best reading of the hypothesis.
    fn read(&self, hypothesis: Hypothesis) -> (Reading, Reading) {
        let (rows, plain) = self.named(hypothesis);
        let named = plain.clone();
        let best = match hypothesis {
            Hypothesis::Declared => reassigned(&rows, plain),
            Hypothesis::Exchanged(i, j) => {
                let at = |joint| self.channels.iter().position(|(_, j)| *j == joint);
                match (at(i), at(j)) {
                    (Some(a), Some(b)) => exchanged(&rows, plain, a, b),
                    _ => plain,
                }
            }
            _ => plain,
        };
        (named, best)
    }
}

/// The better of a reading and the one with two of its signals exchanged.
fn exchanged(rows: &Rows, reading: Reading, a: usize, b: usize) -> Reading {
    let mut other = reading.clone();
    other.assignment.swap(a, b);
    other.deviations = rows.deviations(&other.assignment);
    if other.cost() < reading.cost() {
        other
    } else {
        reading
    }
}

/// Exchanges pairs of signals, the best pair first, as long as that gains something.
fn reassigned(rows: &Rows, mut reading: Reading) -> Reading {
    let n = reading.assignment.len();
    loop {
        let mut best = reading.clone();
        for a in 0..n {
            for b in a + 1..n {
                let other = exchanged(rows, reading.clone(), a, b);
                if other.cost() < best.cost() {
                    best = other;
                }
            }
        }
        // An exchange that is right gains more than a tenth of what makes a finding.
        match reading.cost() - best.cost() > 0.1 * LEAST_GAIN {
            true => reading = best,
            false => return reading,
        }
    }
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
            for series in [
                &mut moved.position,
                &mut moved.velocity,
                &mut moved.acceleration,
            ] {
                series[j].iter_mut().for_each(|x| *x = -*x);
            }
        }
        Hypothesis::Turned(j, angle) => moved.position[j].iter_mut().for_each(|x| *x += angle),
        Hypothesis::Declared | Hypothesis::Gravity(..) | Hypothesis::Tilted(_) => {}
    }
    moved
}

/// Nothing is known of the order of so many joints.
fn not_tried(ready: &PreparedRecording<'_>, joints: usize) -> Mistake {
    finding(
        Severity::Note,
        ready.place(),
        Description::new(
            "order-not-tried",
            format!(
                "whether the columns are those of other joints is not looked at: {joints} joints have too many orders"
            ),
            "to have it looked at, lock all but some of the joints",
        ),
    )
}

fn describe(
    ready: &PreparedRecording<'_>,
    channels: &[(usize, usize)],
    reading: &Reading,
    gain: f64,
) -> Vec<Mistake> {
    let name = |joint: usize| &ready.model.joints()[joint].name;
    let factor = (gain / channels.len() as f64).exp();
    let evidence =
        format!("the residuals are then {factor:.2} times smaller, on the average over all joints");
    let severity = match reading.hypothesis {
        // What a fit can estimate makes no figure meaningless.
        Hypothesis::Tilted(_) => Severity::Warning,
        _ => Severity::Error,
    };
    let mistake = |place, description: Description| {
        let message = format!("{}; {evidence}", description.message);
        let description = Description {
            message,
            ..description
        };
        finding(severity, place, description)
    };
    let moved = |c: &usize| reading.assignment[*c] != *c;
    let moved: Vec<usize> = (0..channels.len()).filter(moved).collect();
    let of_signal = |&c: &usize| {
        let follows = name(channels[reading.assignment[c]].1);
        let words = Description::new(
            "joint-order",
            format!("the signal of this joint follows the motion of {follows}"),
            "put the columns of the signal into the order of the joints",
        );
        mistake(ready.at_channel(channels[c].0), words)
    };
    let of_exchanged = |(own, other): (usize, usize)| {
        let both = if moved.is_empty() {
            "positions"
        } else {
            "positions and signals"
        };
        let words = Description::new(
            "joint-order",
            format!("{both} of this joint look like those of {}", name(other)),
            "put the columns into the order of the joints, or correct robot.joints",
        );
        mistake(ready.at_channel_of(own), words)
    };
    match reading.hypothesis {
        Hypothesis::Declared => moved.iter().map(of_signal).collect(),
        Hypothesis::Exchanged(i, j) => [(i, j), (j, i)].map(of_exchanged).to_vec(),
        Hypothesis::Reversed(j) | Hypothesis::Turned(j, _) => {
            vec![mistake(
                ready.at_channel_of(j),
                of_frame(reading.hypothesis),
            )]
        }
        Hypothesis::Gravity(..) | Hypothesis::Tilted(_) => {
            let place = ready.place().key("robot.gravity");
            vec![mistake(place, of_frame(reading.hypothesis))]
        }
    }
}

/// Words for a sign, a zero or a direction that differs from the robot file's.
fn of_frame(hypothesis: Hypothesis) -> Description {
    match hypothesis {
        Hypothesis::Turned(_, angle) => Description::new(
            "position-zero",
            format!(
                "the zero of the position looks {:+.0} degrees away from the robot file's",
                angle.to_degrees()
            ),
            "set drive.offset for this joint",
        ),
        Hypothesis::Gravity(axis, sign) => Description::new(
            "gravity-direction",
            format!(
                "gravity looks as if it pointed along {}{} of the base frame",
                if sign < 0.0 { "-" } else { "+" },
                ["x", "y", "z"][axis]
            ),
            "set robot.gravity as the base is mounted",
        ),
        Hypothesis::Tilted([roll, pitch]) => Description::new(
            "base-tilt",
            format!(
                "gravity looks {:.1} degrees off the stated direction",
                roll.hypot(pitch).to_degrees()
            ),
            "set robot.gravity as the base is mounted, or estimate the tilt: `exid effects` has an effect for it",
        ),
        _ => Description::new(
            "position-sign",
            "the position looks as if it counted the other way than the robot file's joint",
            "change the sign of the position (a negative drive.ratio does), and of the signal if it has the \
             same sign convention",
        ),
    }
}
