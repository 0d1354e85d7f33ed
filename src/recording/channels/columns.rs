//! Channels of a robot from the columns of a table.

use std::collections::HashSet;
use std::path::Path;

use crate::fault::Place;
use crate::recording::channels::column_map::{Column, ColumnMap, ColumnsAt, expand};
use crate::recording::channels::column_names::{
    ACCELERATION, COMMAND, CURRENT, FEED_FORWARD, POSITION, TEMPERATURE, TIME, TORQUE, VELOCITY,
    VELOCITY_COMMAND, WRENCH,
};
use crate::recording::channels::missing::{CompleteTable, Roles, bridge, require_complete};
use crate::recording::channels::samples::{Commanded, Recording, SignalKind};
use crate::recording::error::{MissingColumn, RecordingError, RecordingErrorKind};
use crate::recording::formats::format::{columns_at, read_at};
use crate::recording::formats::reading::Reading;

/// A joint whose channels are read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedJoint {
    /// The name that columns may bear, `q_<name>`.
    pub name: String,
    /// Number from 1 in the order of the problem's joints, for columns that are named by number.
    pub number: usize,
}

impl RecordedJoint {
    /// Joints numbered in the order of their names.
    pub fn all(names: &[String]) -> Vec<Self> {
        let numbered = names.iter().cloned().zip(1..);
        numbered
            .map(|(name, number)| Self { name, number })
            .collect()
    }
}

/// Reads a recording of the joints, in their order.
///
/// Errors: those of the file and its table, a column that is missing (naming the nearest one), and
/// a pattern that does not tell the joints apart.
pub fn read(
    path: &Path,
    map: &ColumnMap,
    joints: &[RecordedJoint],
    kind: SignalKind,
) -> Result<Recording, RecordingError> {
    read_within(path, map, joints, kind, &Reading::default())
}

/// As [`read`], within bounds.
///
/// Errors: as there; an interrupt, more than the bounds.
pub fn read_within(
    path: &Path,
    map: &ColumnMap,
    joints: &[RecordedJoint],
    kind: SignalKind,
    reading: &Reading,
) -> Result<Recording, RecordingError> {
    let file = File {
        path,
        parts: Parts::All,
    };
    file.read(map, joints, kind, reading)
}

/// Which channels a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::recording) enum Parts {
    All,
    /// Positions, velocities and accelerations are elsewhere.
    WithoutPosition,
    /// Nothing but positions.
    Position,
}

/// A file and the channels that are read of it.
#[derive(Debug, Clone, Copy)]
pub(in crate::recording) struct File<'a> {
    pub path: &'a Path,
    pub parts: Parts,
}

impl File<'_> {
    pub fn read(
        self,
        map: &ColumnMap,
        joints: &[RecordedJoint],
        kind: SignalKind,
        reading: &Reading,
    ) -> Result<Recording, RecordingError> {
        let File { path, parts } = self;
        let present = columns_at(path, reading)?;
        let finder = Finder {
            path,
            joints,
            present: &present,
            conventional: *map == ColumnMap::default(),
        };
        let names = match parts {
            Parts::All => finder.choose(map, kind)?,
            Parts::WithoutPosition => Names {
                signal: finder.signal(map, kind)?,
                commanded: finder.commanded(map, kind),
                mask: finder.one(&map.mask, "mask")?,
                ..Names::empty(finder.time(map)?)
            },
            Parts::Position => Names {
                position: finder.required(&map.position, POSITION, "position")?,
                ..Names::empty(finder.time(map)?)
            },
        };
        let table = read_at(path, &names.all(path)?, reading)?;
        let mut recording = names.assemble(path, bridge(path, table, names.roles())?);
        recording.commanded = names.commanded;
        into_si(&mut recording, map, joints, kind);
        Ok(recording)
    }
}

/// Turns what a file holds into SI units.
fn into_si(recording: &mut Recording, map: &ColumnMap, joints: &[RecordedJoint], kind: SignalKind) {
    let scale = |series: &mut [Vec<f64>], column: &Option<Column>| {
        let Some(column) = column else { return };
        for (series, joint) in series.iter_mut().zip(joints) {
            let factor = column.factor(joint.number);
            if factor != 1.0 {
                series.iter_mut().for_each(|x| *x *= factor);
            }
        }
    };
    let signals = match kind {
        SignalKind::Current => vec![&map.current],
        SignalKind::BaseWrench => Vec::new(),
        SignalKind::PositionCommand => recording.commanded.columns(map),
        _ => vec![&map.torque],
    };
    scale(&mut recording.position, &map.position);
    for (series, column) in recording
        .signal
        .chunks_mut(joints.len().max(1))
        .zip(signals)
    {
        scale(series, column);
    }
    if let Some(velocity) = &mut recording.velocity {
        scale(velocity, &map.velocity);
    }
    if let Some(acceleration) = &mut recording.acceleration {
        scale(acceleration, &map.acceleration);
    }
    if let (Some(time), Some(column)) = (&mut recording.time, &map.time) {
        let factor = column.factor(1);
        if factor != 1.0 {
            time.iter_mut().for_each(|t| *t *= factor);
        }
    }
}

/// Reads further columns of a recording, in the order of their names.
///
/// Errors: those of the file and its table, and a column that is missing (naming the nearest one), a cell
/// without a number.
pub fn read_further(
    path: &Path,
    names: &[String],
    reading: &Reading,
) -> Result<Vec<Vec<f64>>, RecordingError> {
    let present = columns_at(path, reading)?;
    let finder = Finder::new(path, &[], &present);
    for name in names {
        finder.single(name, "sensor at a joint without a motor")?;
    }
    let mut table = read_at(path, names, reading)?;
    require_complete(path, &table)?;
    let take = |name: &String| table.take(name).unwrap_or_default();
    Ok(names.iter().map(take).collect())
}

/// The columns chosen for each channel.
struct Names {
    time: Option<String>,
    position: Vec<String>,
    velocity: Option<Vec<String>>,
    acceleration: Option<Vec<String>>,
    signal: Vec<String>,
    commanded: Commanded,
    temperature: Option<Vec<String>>,
    mask: Option<String>,
}

impl Names {
    fn empty(time: Option<String>) -> Self {
        Self {
            time,
            position: Vec::new(),
            velocity: None,
            acceleration: None,
            signal: Vec::new(),
            commanded: Commanded::default(),
            temperature: None,
            mask: None,
        }
    }

    /// Every chosen column once; one column in two roles is a slip in the map.
    fn all(&self, path: &Path) -> Result<Vec<String>, RecordingError> {
        let groups = [&self.velocity, &self.acceleration, &self.temperature];
        let mut all: Vec<String> = self.time.iter().chain(&self.mask).cloned().collect();
        all.extend(self.position.iter().chain(&self.signal).cloned());
        all.extend(groups.into_iter().flatten().flatten().cloned());
        let mut seen = HashSet::new();
        match all.iter().find(|name| !seen.insert(*name)) {
            None => Ok(all),
            Some(name) => Err(RecordingError::new(
                Place::file(path).key(name),
                RecordingErrorKind::ColumnUsedTwice { name: name.clone() },
            )),
        }
    }

    fn roles(&self) -> Roles<'_> {
        Roles {
            time: self.time.as_deref(),
            mask: self.mask.as_deref(),
            slow: self.temperature.as_deref().unwrap_or_default(),
        }
    }

    fn assemble(&self, path: &Path, bridged: CompleteTable) -> Recording {
        let CompleteTable {
            mut table,
            valid,
            missing,
        } = bridged;
        let (first_line, lines) = (table.first_line, table.lines.take());
        let mut take = |name: &String| table.take(name).unwrap_or_default();
        let mut group = |names: &Vec<String>| names.iter().map(&mut take).collect::<Vec<_>>();
        let position = group(&self.position);
        let signal = group(&self.signal);
        let velocity = self.velocity.as_ref().map(&mut group);
        let acceleration = self.acceleration.as_ref().map(&mut group);
        let temperature = self.temperature.as_ref().map(&mut group);
        let counts = |column: Vec<f64>| column.iter().map(|&value| value != 0.0).collect();
        let masked: Option<Vec<bool>> = self.mask.as_ref().map(|name| counts(take(name)));
        let mask = match (masked, valid) {
            (Some(a), Some(b)) => Some(a.iter().zip(&b).map(|(a, b)| *a && *b).collect()),
            (masked, valid) => masked.or(valid),
        };
        Recording {
            time: self.time.as_ref().map(&mut take),
            first_line,
            lines,
            missing,
            velocity,
            acceleration,
            temperature,
            mask,
            ..Recording::of_samples(path, position, signal)
        }
    }
}

/// Finds the columns of one file.
pub(in crate::recording) struct Finder<'a> {
    path: &'a Path,
    joints: &'a [RecordedJoint],
    present: &'a [String],
    /// The map is empty: optional channels are looked for under their usual names.
    conventional: bool,
}

impl<'a> Finder<'a> {
    /// Of optional channels by their names in a map alone.
    pub(in crate::recording) fn new(
        path: &'a Path,
        joints: &'a [RecordedJoint],
        present: &'a [String],
    ) -> Self {
        Self {
            path,
            joints,
            present,
            conventional: false,
        }
    }

    fn choose(&self, map: &ColumnMap, kind: SignalKind) -> Result<Names, RecordingError> {
        let optional = |column: &Option<Column>, usual, what| match column {
            Some(column) => self.joints_at(column, what).map(Some),
            None if self.conventional => Ok(self.joints_by_convention(usual)),
            None => Ok(None),
        };
        Ok(Names {
            time: self.time(map)?,
            position: self.required(&map.position, POSITION, "position")?,
            velocity: optional(&map.velocity, VELOCITY, "velocity")?,
            acceleration: optional(&map.acceleration, ACCELERATION, "acceleration")?,
            signal: self.signal(map, kind)?,
            commanded: self.commanded(map, kind),
            temperature: optional(&map.temperature, TEMPERATURE, "temperature")?,
            mask: self.one(&map.mask, "mask")?,
        })
    }

    pub(in crate::recording) fn time(
        &self,
        map: &ColumnMap,
    ) -> Result<Option<String>, RecordingError> {
        match self.one(&map.time, "time")? {
            Some(name) => Ok(Some(name)),
            None => Ok(TIME
                .iter()
                .find(|&&name| self.has(name))
                .map(|&name| name.into())),
        }
    }

    /// A column of no joint.
    pub(in crate::recording) fn one(
        &self,
        column: &Option<Column>,
        what: &str,
    ) -> Result<Option<String>, RecordingError> {
        let Some(column) = column else {
            return Ok(None);
        };
        match &column.at {
            ColumnsAt::Pattern(name) => self.single(name, what),
            ColumnsAt::Names(names) => self.single(&names[0], what),
            ColumnsAt::Numbers(numbers) => self.numbered(numbers[0], what),
        }
        .map(Some)
    }

    /// The name of a column by its position from 1.
    fn numbered(&self, number: usize, what: &str) -> Result<String, RecordingError> {
        match self.present.get(number.wrapping_sub(1)) {
            Some(name) => Ok(name.clone()),
            None => Err(self.missing(vec![number.to_string()], what)),
        }
    }

    pub(in crate::recording) fn joints_at(
        &self,
        column: &Column,
        what: &str,
    ) -> Result<Vec<String>, RecordingError> {
        let given = match &column.at {
            ColumnsAt::Pattern(pattern) => return self.joints_by_pattern(pattern, what),
            ColumnsAt::Names(names) => names.len(),
            ColumnsAt::Numbers(numbers) => numbers.len(),
        };
        let of = |joint: &RecordedJoint| {
            let index = joint.number - 1;
            let purpose = format!("{what} of joint {}", joint.name);
            match &column.at {
                ColumnsAt::Names(names) if index < given => self.single(&names[index], &purpose),
                ColumnsAt::Numbers(numbers) if index < given => {
                    self.numbered(numbers[index], &purpose)
                }
                _ => Err(RecordingError::new(
                    Place::file(self.path).key(what),
                    RecordingErrorKind::TooFewColumns {
                        given,
                        joints: self.joints.len(),
                    },
                )),
            }
        };
        self.joints.iter().map(of).collect()
    }

    /// Which commands beside the position a file has: those that a map names, or under their usual names where it names
    /// no command at all.
    fn commanded(&self, map: &ColumnMap, kind: SignalKind) -> Commanded {
        if kind != SignalKind::PositionCommand {
            return Commanded::default();
        }
        let has = |column: &Option<Column>, usual| match column {
            Some(_) => true,
            None => self.conventional && self.joints_by_convention(usual).is_some(),
        };
        Commanded {
            velocity: has(&map.velocity_command, VELOCITY_COMMAND),
            feed_forward: has(&map.feed_forward, FEED_FORWARD),
        }
    }

    fn signal(&self, map: &ColumnMap, kind: SignalKind) -> Result<Vec<String>, RecordingError> {
        match kind {
            SignalKind::PositionCommand => {
                let commanded = self.commanded(map, kind);
                let mut names = self.required(&map.command, COMMAND, "command")?;
                if commanded.velocity {
                    let column = &map.velocity_command;
                    names.extend(self.required(column, VELOCITY_COMMAND, "velocity_command")?);
                }
                if commanded.feed_forward {
                    names.extend(self.required(&map.feed_forward, FEED_FORWARD, "feed_forward")?);
                }
                Ok(names)
            }
            SignalKind::Current => self.required(&map.current, CURRENT, "current"),
            SignalKind::BaseWrench => self.wrench(map),
            SignalKind::Both => {
                let mut names = self.required(&map.torque, TORQUE, "torque")?;
                names.extend(self.wrench(map)?);
                Ok(names)
            }
            _ => self.required(&map.torque, TORQUE, "torque"),
        }
    }

    pub(in crate::recording) fn wrench(
        &self,
        map: &ColumnMap,
    ) -> Result<Vec<String>, RecordingError> {
        let usual = WRENCH.map(String::from);
        let names = map.wrench.as_ref().unwrap_or(&usual);
        let purpose = |axis| format!("{axis} of the base wrench");
        let named = names.iter().zip(WRENCH);
        named
            .map(|(name, axis)| self.single(name, &purpose(axis)))
            .collect()
    }

    pub(in crate::recording) fn required(
        &self,
        column: &Option<Column>,
        usual: &[&str],
        what: &str,
    ) -> Result<Vec<String>, RecordingError> {
        if let Some(column) = column {
            return self.joints_at(column, what);
        }
        self.joints_by_convention(usual)
            .ok_or_else(|| self.missing_by_convention(usual, what))
    }

    /// The joint that the best-matching convention lacks, with all names that would do for it.
    fn missing_by_convention(&self, usual: &[&str], what: &str) -> RecordingError {
        let lacking = |pattern: &str| {
            let names = self.expand(pattern);
            names.iter().filter(|name| !self.has(name)).count()
        };
        let mut order: Vec<&str> = usual.to_vec();
        order.sort_by_key(|pattern| lacking(pattern));
        let best = self.expand(order.first().copied().unwrap_or_default());
        let joint = best.iter().position(|name| !self.has(name)).unwrap_or(0);
        let accepted = order
            .iter()
            .map(|pattern| self.expand_one(pattern, joint))
            .collect();
        self.missing(accepted, &self.purpose(what, joint))
    }

    /// One convention for all joints: joints of one file are not named in two ways.
    pub(in crate::recording) fn joints_by_convention(&self, usual: &[&str]) -> Option<Vec<String>> {
        usual
            .iter()
            .map(|pattern| self.expand(pattern))
            .find(|names| names.iter().all(|name| self.has(name)))
    }

    fn joints_by_pattern(&self, pattern: &str, what: &str) -> Result<Vec<String>, RecordingError> {
        self.check_pattern(pattern, what)?;
        let names = self.expand(pattern);
        match names.iter().position(|name| !self.has(name)) {
            None => Ok(names),
            Some(joint) => {
                let accepted = vec![names[joint].clone()];
                Err(self.missing(accepted, &self.purpose(what, joint)))
            }
        }
    }

    fn check_pattern(&self, pattern: &str, what: &str) -> Result<(), RecordingError> {
        let place = Place::file(self.path).key(what);
        let rest = pattern.replace("{joint}", "").replace("{n}", "");
        if let Some((start, end)) = rest.find('{').zip(rest.find('}'))
            && start < end
        {
            let kind = RecordingErrorKind::UnknownPlaceholder {
                found: rest[start..=end].into(),
            };
            return Err(RecordingError::new(place, kind));
        }
        if rest == pattern && self.joints.len() > 1 {
            let kind = RecordingErrorKind::PatternNotPerJoint {
                pattern: pattern.into(),
                joints: self.joints.len(),
            };
            return Err(RecordingError::new(place, kind));
        }
        Ok(())
    }

    fn single(&self, name: &str, purpose: &str) -> Result<String, RecordingError> {
        if self.has(name) {
            return Ok(name.into());
        }
        Err(self.missing(vec![name.into()], purpose))
    }

    pub(in crate::recording) fn missing(
        &self,
        accepted: Vec<String>,
        purpose: &str,
    ) -> RecordingError {
        let numbered = (1..).map(|n: usize| n.to_string());
        if !self.present.is_empty() && self.present.iter().zip(numbered).all(|(a, b)| *a == b) {
            return RecordingError::new(
                Place::file(self.path).line(1),
                RecordingErrorKind::NoHeader,
            );
        }
        let first = accepted.first().cloned().unwrap_or_default();
        let nearest = self
            .present
            .iter()
            .map(|name| (strsim::normalized_damerau_levenshtein(name, &first), name))
            .filter(|(similarity, _)| *similarity >= NEAREST_SIMILARITY)
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, name)| name.clone());
        let kind = RecordingErrorKind::MissingColumn(Box::new(MissingColumn {
            purpose: purpose.into(),
            accepted,
            nearest,
            present: self.present.to_vec(),
        }));
        RecordingError::new(Place::file(self.path).key(first), kind)
    }

    fn purpose(&self, what: &str, joint: usize) -> String {
        match self.joints.get(joint) {
            Some(joint) => format!("{what} of joint {}", joint.name),
            None => what.into(),
        }
    }

    fn expand(&self, pattern: &str) -> Vec<String> {
        (0..self.joints.len())
            .map(|joint| self.expand_one(pattern, joint))
            .collect()
    }

    fn expand_one(&self, pattern: &str, joint: usize) -> String {
        let RecordedJoint { name, number } = &self.joints[joint];
        expand(pattern, name, *number)
    }

    fn has(&self, name: &str) -> bool {
        self.present.iter().any(|column| column == name)
    }
}

/// Least similarity of a name worth proposing: half of its letters are in place.
const NEAREST_SIMILARITY: f64 = 0.5;
