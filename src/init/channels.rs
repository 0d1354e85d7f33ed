//! Which columns of a recording hold which channel of which joint, by their names.

use crate::init::error::InitError;
use crate::recording::column_map::{Column, ColumnsAt, Factors};
use crate::recording::samples::SignalKind;
use crate::recording::units::{self, Quantity};
use std::collections::BTreeMap;
use std::path::Path;

/// Words in the names of columns, in lower case. A later quantity is looked for first: `q_vel` is a velocity.
const WORDS: &[(Quantity, &[&str])] = &[
    (Quantity::Time, &["t", "time", "timestamp", "stamp", "zeit"]),
    (
        Quantity::Position,
        &[
            "q",
            "qm",
            "qpos",
            "pos",
            "position",
            "positions",
            "angle",
            "angles",
            "theta",
            "winkel",
            "lage",
            "encoder",
        ],
    ),
    (
        Quantity::Torque,
        &[
            "tau",
            "taum",
            "torque",
            "torques",
            "effort",
            "force",
            "forces",
            "kraft",
            "trq",
            "drehmoment",
            "moment",
            "qfrc",
        ],
    ),
    (
        Quantity::Current,
        &[
            "i", "cur", "curr", "current", "currents", "strom", "amps", "iq", "voltage",
        ],
    ),
    (
        Quantity::Velocity,
        &[
            "dq",
            "qd",
            "qvel",
            "vel",
            "velocity",
            "velocities",
            "speed",
            "omega",
            "drehzahl",
            "geschwindigkeit",
        ],
    ),
    (
        Quantity::Acceleration,
        &["ddq", "qdd", "qacc", "acc", "acceleration", "accelerations"],
    ),
];

/// Words of what was asked for and not measured.
const ASKED: &[&str] = &[
    "ref",
    "reference",
    "cmd",
    "command",
    "commanded",
    "target",
    "desired",
    "des",
    "set",
    "setpoint",
    "soll",
    "goal",
];

/// A channel: its columns, and their unit where that is not SI.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Channel {
    pub quantity: Quantity,
    pub at: ColumnsAt,
    /// Joints that have a column, by their place in the tree; none of a channel of no joint.
    pub joints: Vec<usize>,
    /// The columns of these joints.
    pub columns: Vec<String>,
    pub unit: Option<&'static str>,
}

impl Channel {
    /// As it stands in a map of columns.
    pub fn column(&self) -> Column {
        let factor = self
            .unit
            .and_then(|unit| units::factor(self.quantity, unit));
        Column {
            at: self.at.clone(),
            factors: factor.map_or(Factors::SI, Factors::Same),
        }
    }

    /// The names of the columns, for people.
    pub fn written(&self) -> String {
        match &self.at {
            ColumnsAt::Pattern(pattern) => pattern.clone(),
            _ => self.columns.join(", "),
        }
    }
}

/// The channels of a recording.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Channels {
    pub time: Option<Channel>,
    pub position: Channel,
    pub velocity: Option<Channel>,
    /// Currents, torques or commanded positions.
    pub signal: Channel,
    pub kind: SignalKind,
}

impl Channels {
    /// The channels by the names of columns.
    ///
    /// # Errors
    /// No positions, or neither torques nor currents.
    pub fn of(file: &Path, present: &[String], joints: &[String]) -> Result<Self, InitError> {
        let families_of = |of| families(present, joints, of);
        let families = families_of(quantity);
        let find = |quantity| best(&families, quantity);
        let missing = |what| InitError::NoChannel {
            file: file.to_path_buf(),
            what,
            joints: joints.to_vec(),
            present: present.to_vec(),
        };
        let position = find(Quantity::Position).ok_or_else(|| missing("positions"))?;
        // A torque needs no torque constant.
        let torque = find(Quantity::Torque).map(|channel| (SignalKind::Torque, channel));
        let current = || Some((SignalKind::Current, find(Quantity::Current)?));
        let command = || {
            let asked = best(&families_of(commanded_position), Quantity::Position)?;
            Some((SignalKind::PositionCommand, asked))
        };
        let signal = torque.or_else(current).or_else(command);
        let what = "currents, torques or commanded positions";
        let (kind, signal) = signal.ok_or_else(|| missing(what))?;
        let same = |channel: &Channel| channel.joints == position.joints;
        if !same(&signal) {
            return Err(missing(
                "currents, torques or commanded positions of the same joints as positions",
            ));
        }
        Ok(Self {
            time: time(present),
            velocity: find(Quantity::Velocity).filter(same),
            position,
            signal,
            kind,
        })
    }

    /// Every column that is read.
    pub fn columns(&self) -> impl Iterator<Item = &String> {
        let optional = self.time.iter().chain(&self.velocity);
        let all = optional.chain([&self.position, &self.signal]);
        all.flat_map(|channel| &channel.columns)
    }
}

/// The family of a quantity with most joints; of several the one with the shortest name.
fn best(families: &[Channel], quantity: Quantity) -> Option<Channel> {
    let of = families.iter().filter(|f| f.quantity == quantity);
    let best = of.max_by_key(|f| (f.joints.len(), std::cmp::Reverse(f.written().len())));
    best.cloned()
}

fn time(present: &[String]) -> Option<Channel> {
    let is_time = |name: &&String| quantity(&words(name)) == Some(Quantity::Time);
    let shortest = present
        .iter()
        .filter(is_time)
        .min_by_key(|name| name.len())?;
    Some(Channel {
        quantity: Quantity::Time,
        at: ColumnsAt::Pattern(shortest.clone()),
        joints: Vec::new(),
        columns: vec![shortest.clone()],
        unit: unit(Quantity::Time, shortest),
    })
}

/// Columns that differ by the name or the number of a joint alone.
fn families(present: &[String], joints: &[String], of: QuantityOf) -> Vec<Channel> {
    // By what is left without the name or number: the joint, or the number as it is written, and the column.
    let mut by_name: BTreeMap<String, Vec<(usize, String)>> = BTreeMap::new();
    let mut by_number: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
    for column in present {
        if let Some((pattern, joint)) = with_joint(column, joints) {
            by_name
                .entry(pattern)
                .or_default()
                .push((joint, column.clone()));
        } else if let Some((pattern, number)) = with_number(column) {
            by_number
                .entry(pattern)
                .or_default()
                .push((number, column.clone()));
        }
    }
    let mut families = Vec::new();
    if let [_] = joints {
        // The one joint needs neither name nor number.
        let plain = |column: &&String| {
            with_joint(column, joints).is_none() && with_number(column).is_none()
        };
        families.extend(present.iter().filter(plain).filter_map(|column| {
            let at = ColumnsAt::Pattern(column.clone());
            family(column, at, vec![(0, column.clone())], of)
        }));
    }
    for (pattern, mut members) in by_name {
        members.sort();
        families.extend(family(
            &pattern,
            ColumnsAt::Pattern(pattern.clone()),
            members,
            of,
        ));
    }
    for (pattern, members) in by_number {
        families.extend(numbered(&pattern, members, joints.len(), of));
    }
    families
}

/// Columns by numbers, from 1 on as a pattern, from 0 on as a list of names.
fn numbered(
    pattern: &str,
    members: Vec<(String, String)>,
    count: usize,
    of: QuantityOf,
) -> Option<Channel> {
    let mut joints = Vec::new();
    for (written, column) in members {
        joints.push((written.parse::<usize>().ok()?, written, column));
    }
    joints.sort();
    let from_zero = joints.first()?.0 == 0;
    let padded = joints
        .iter()
        .any(|(number, written, _)| number.to_string() != *written);
    let is_complete = joints.len() == count;
    let numbers = joints.iter().map(|(number, ..)| *number);
    let within = numbers.clone().all(|n| n + usize::from(from_zero) <= count);
    if !within || (from_zero || padded) && !is_complete {
        return None;
    }
    let first = usize::from(!from_zero);
    let members: Vec<(usize, String)> = joints
        .iter()
        .map(|(n, _, column)| (n - first, column.clone()))
        .collect();
    let at = match from_zero || padded {
        true => ColumnsAt::Names(members.iter().map(|(_, column)| column.clone()).collect()),
        false => ColumnsAt::Pattern(pattern.to_owned()),
    };
    family(pattern, at, members, of)
}

fn family(
    pattern: &str,
    at: ColumnsAt,
    members: Vec<(usize, String)>,
    of: QuantityOf,
) -> Option<Channel> {
    let name = pattern.replace("{joint}", " ").replace("{n}", " ");
    let quantity = of(&words(&name)).filter(|q| *q != Quantity::Time)?;
    let (joints, columns) = members.into_iter().unzip();
    Some(Channel {
        quantity,
        at,
        joints,
        columns,
        unit: unit(quantity, &name),
    })
}

/// The column with `{joint}` for the longest name of a joint in it, and which joint that is.
fn with_joint(column: &str, joints: &[String]) -> Option<(String, usize)> {
    let mut order: Vec<usize> = (0..joints.len()).collect();
    order.sort_by_key(|&j| std::cmp::Reverse(joints[j].len()));
    order.into_iter().find_map(|j| {
        let (before, after) = column.split_once(&joints[j])?;
        let is_apart = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric());
        let apart = is_apart(before.chars().last()) && is_apart(after.chars().next());
        apart.then(|| (format!("{before}{{joint}}{after}"), j))
    })
}

/// The column with `{n}` for the last number in it, and the number as it is written.
fn with_number(column: &str) -> Option<(String, String)> {
    let end = column.rfind(|c: char| c.is_ascii_digit())? + 1;
    let start = column[..end]
        .rfind(|c: char| !c.is_ascii_digit())
        .map_or(0, |at| {
            at + column[at..].chars().next().map_or(1, char::len_utf8)
        });
    let number = column[start..end].to_owned();
    Some((
        format!("{}{{n}}{}", &column[..start], &column[end..]),
        number,
    ))
}

/// The words of a name in lower case: runs of letters, parted where a capital follows a small letter.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_small = false;
    for c in name.chars() {
        if !c.is_alphabetic() || (was_small && c.is_uppercase()) {
            words.push(String::new());
        }
        if c.is_alphabetic() {
            words
                .last_mut()
                .into_iter()
                .for_each(|w| w.extend(c.to_lowercase()));
        }
        was_small = c.is_lowercase();
    }
    words.retain(|word| !word.is_empty());
    words
}

/// What the words of a name say that a column holds.
type QuantityOf = fn(&[String]) -> Option<Quantity>;

/// A position where it is one that was asked for, and nothing of anything else.
fn commanded_position(words: &[String]) -> Option<Quantity> {
    let (asked, rest): (Vec<String>, Vec<String>) =
        (words.iter().cloned()).partition(|word| ASKED.contains(&word.as_str()));
    let is_position = rest.is_empty() || quantity(&rest) == Some(Quantity::Position);
    (!asked.is_empty() && is_position).then_some(Quantity::Position)
}

/// What words say; nothing of what was asked for and not measured.
fn quantity(words: &[String]) -> Option<Quantity> {
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    if has(ASKED) {
        return None;
    }
    let found = WORDS.iter().rev().find(|(_, list)| has(list));
    found.map(|(quantity, _)| *quantity)
}

/// A unit in a name that is not SI.
fn unit(quantity: Quantity, name: &str) -> Option<&'static str> {
    let parts: Vec<&str> = name
        .split(|c: char| !(c.is_alphabetic() || c == '/'))
        .collect();
    let names = units::names(quantity).into_iter();
    let mut other = names.filter(|name| units::factor(quantity, name).is_some_and(|f| f != 1.0));
    other.find(|unit| parts.iter().any(|part| part.eq_ignore_ascii_case(unit)))
}
