//! Which columns of a recording hold which channel of which joint, by their names.

use crate::init::error::InitError;
use crate::init::named_column::{ColumnKey, NamedColumn};
use crate::recording::column_map::{Column, ColumnsAt, Factors, expand};
use crate::recording::samples::SignalKind;
use crate::recording::units::{self, Quantity};
use std::collections::BTreeMap;
use std::path::Path;

/// What asks an amplifier for a current.
const VOLTAGE: &str = "voltage";

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
            "i", "cur", "curr", "current", "currents", "strom", "amps", "iq", VOLTAGE,
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

    /// Whether the columns say that they hold voltages.
    pub fn is_voltage(&self) -> bool {
        let mut names = self.columns.iter();
        names.any(|name| words(name).iter().any(|word| word == VOLTAGE))
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
    /// The channels that are named, and the others by the names of columns.
    ///
    /// # Errors
    /// No positions, or neither torques nor currents; a column that is named and not there.
    pub fn of(
        file: &Path,
        present: &[String],
        joints: &[String],
        named: &[NamedColumn],
    ) -> Result<Self, InitError> {
        let families_of = |of| families(present, joints, of);
        let families = families_of(quantity);
        for column in named {
            if given(column, present, joints).is_none() {
                return Err(InitError::NoColumn {
                    file: file.to_path_buf(),
                    column: column.column.clone(),
                    present: present.to_vec(),
                });
            }
        }
        let named = |key: ColumnKey| {
            let column = named.iter().find(|column| column.key == key)?;
            given(column, present, joints)
        };
        let find = |key: ColumnKey| {
            let by_name = || best(&families, key.quantity());
            named(key).or_else(by_name)
        };
        let missing = |what| InitError::NoChannel {
            file: file.to_path_buf(),
            what,
            joints: joints.to_vec(),
            present: present.to_vec(),
        };
        let position = find(ColumnKey::Position).ok_or_else(|| missing("positions"))?;
        let torque = |channel| (SignalKind::Torque, channel);
        let current = |channel| (SignalKind::Current, channel);
        let command = |channel| (SignalKind::PositionCommand, channel);
        let stated = (named(ColumnKey::Torque).map(torque))
            .or_else(|| named(ColumnKey::Current).map(current))
            .or_else(|| named(ColumnKey::Command).map(command));
        let asked = || best(&families_of(commanded_position), Quantity::Position);
        // A torque needs no torque constant.
        let signal = stated
            .or_else(|| find(ColumnKey::Torque).map(torque))
            .or_else(|| find(ColumnKey::Current).map(current))
            .or_else(|| asked().map(command));
        let what = "currents, torques or commanded positions";
        let (kind, signal) = signal.ok_or_else(|| missing(what))?;
        let same = |channel: &Channel| channel.joints == position.joints;
        if !same(&signal) {
            return Err(missing(
                "currents, torques or commanded positions of the same joints as positions",
            ));
        }
        Ok(Self {
            time: named(ColumnKey::Time).or_else(|| time(present)),
            velocity: find(ColumnKey::Velocity).filter(same),
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

/// The channel of a column that is named; `None` where it is not there.
fn given(named: &NamedColumn, present: &[String], joints: &[String]) -> Option<Channel> {
    let quantity = named.key.quantity();
    let listed = named.column.contains(',');
    let names: Vec<String> = match (listed, quantity) {
        (true, _) => named.column.split(',').map(str::to_owned).collect(),
        (false, Quantity::Time) => vec![named.column.clone()],
        (false, _) => {
            let numbered = (1..).zip(joints);
            numbered
                .map(|(number, joint)| expand(&named.column, joint, number))
                .collect()
        }
    };
    let at = match listed {
        true => ColumnsAt::Names(names.clone()),
        false => ColumnsAt::Pattern(named.column.clone()),
    };
    let members = names.into_iter().take(joints.len()).enumerate();
    let members = members.filter(|(_, name)| present.contains(name));
    let (of_joints, columns): (Vec<usize>, Vec<String>) = members.unzip();
    (!columns.is_empty()).then(|| Channel {
        quantity,
        at,
        joints: match quantity {
            Quantity::Time => Vec::new(),
            _ => of_joints,
        },
        columns,
        unit: unit(quantity, &without_joint(&named.column)),
    })
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
    let name = without_joint(pattern);
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

/// A pattern with blanks for the name and the number of a joint.
fn without_joint(pattern: &str) -> String {
    pattern.replace("{joint}", " ").replace("{n}", " ")
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

/// Letters of a word from which it is known at the end of another too, as in `Istposition`, and of what was asked for at its
/// beginning, as in `Sollposition`.
const KNOWN_WITHIN: usize = 3;

/// What words say; nothing of what was asked for and not measured.
fn quantity(words: &[String]) -> Option<Quantity> {
    let is_any = |list: &[&str], is: fn(&str, &str) -> bool| {
        let known = |word: &String| list.iter().any(|known| is(word, known));
        words.iter().any(known)
    };
    let begins = |word: &str, known: &str| known.len() >= KNOWN_WITHIN && word.starts_with(known);
    let ends = |word: &str, known: &str| known.len() >= KNOWN_WITHIN && word.ends_with(known);
    let same = |word: &str, known: &str| word == known;
    if is_any(ASKED, same) || is_any(ASKED, begins) {
        return None;
    }
    let by = |is| WORDS.iter().rev().find(|(_, list)| is_any(list, is));
    let composed = || by(ends).filter(|(quantity, _)| *quantity != Quantity::Time);
    by(same).or_else(composed).map(|(quantity, _)| *quantity)
}

/// A unit in a name that is not SI.
fn unit(quantity: Quantity, name: &str) -> Option<&'static str> {
    let stated = units::stated(quantity, name);
    stated.filter(|unit| units::factor(quantity, unit).is_some_and(|f| f != 1.0))
}
