//! Which column of which file each channel of a recording comes from.

use crate::fault::Place;
use crate::recording::channels::column_map::{Column, ColumnMap};
use crate::recording::channels::column_names::{
    ACCELERATION, COMMAND, CURRENT, FEED_FORWARD, POSITION, TEMPERATURE, TORQUE, VELOCITY,
    VELOCITY_COMMAND,
};
use crate::recording::channels::columns::{Finder, RecordedJoint};
use crate::recording::channels::samples::{Commanded, SignalKind};
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::format::columns_at;
use crate::recording::formats::reading::Reading;
use std::path::Path;

/// A file of a recording, and where its channels stand.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// Where it is opened.
    pub path: &'a Path,
    /// What its columns are called.
    pub map: &'a ColumnMap,
}

/// A kind of channel: where a map names it, its usual names, and what it is.
pub(super) struct Channel {
    column: fn(&ColumnMap) -> &Option<Column>,
    usual: &'static [&'static str],
    what: &'static str,
}

impl Channel {
    pub(super) const POSITION: Self = Self {
        column: |map| &map.position,
        usual: POSITION,
        what: "position",
    };
    pub(super) const VELOCITY: Self = Self {
        column: |map| &map.velocity,
        usual: VELOCITY,
        what: "velocity",
    };
    pub(super) const ACCELERATION: Self = Self {
        column: |map| &map.acceleration,
        usual: ACCELERATION,
        what: "acceleration",
    };
    const CURRENT: Self = Self {
        column: |map| &map.current,
        usual: CURRENT,
        what: "current",
    };
    const TORQUE: Self = Self {
        column: |map| &map.torque,
        usual: TORQUE,
        what: "torque",
    };
    const COMMAND: Self = Self {
        column: |map| &map.command,
        usual: COMMAND,
        what: "command",
    };
    const VELOCITY_COMMAND: Self = Self {
        column: |map| &map.velocity_command,
        usual: VELOCITY_COMMAND,
        what: "velocity_command",
    };
    const FEED_FORWARD: Self = Self {
        column: |map| &map.feed_forward,
        usual: FEED_FORWARD,
        what: "feed_forward",
    };
    pub(super) const TEMPERATURE: Self = Self {
        column: |map| &map.temperature,
        usual: TEMPERATURE,
        what: "temperature",
    };
}

/// A column of one of the files.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pick {
    pub(super) file: usize,
    pub(super) name: String,
    /// What turns its numbers into SI units.
    pub(super) factor: f64,
}

/// A file with the names of its columns.
pub(super) struct File<'a> {
    pub(super) source: Source<'a>,
    pub(super) present: Vec<String>,
    pub(super) time: String,
}

impl<'a> File<'a> {
    pub(super) fn open(
        source: Source<'a>,
        joints: &[RecordedJoint],
        reading: &Reading,
    ) -> Result<Self, RecordingError> {
        let present = columns_at(source.path, reading)?;
        let finder = Finder::new(source.path, joints, &present);
        let none = || {
            let place = Place::file(source.path);
            RecordingError::new(place, RecordingErrorKind::JoinWithoutTime)
        };
        let time = finder.time(source.map)?.ok_or_else(none)?;
        Ok(Self {
            source,
            present,
            time,
        })
    }

    /// The columns of a channel for some joints, where this file has them.
    fn find(
        &self,
        channel: &Channel,
        joints: &[RecordedJoint],
        always: Usual,
    ) -> Option<Vec<String>> {
        let finder = Finder::new(self.source.path, joints, &self.present);
        match (channel.column)(self.source.map) {
            Some(column) => finder.joints_at(column, channel.what).ok(),
            None if always == Usual::Always || *self.source.map == ColumnMap::default() => {
                finder.joints_by_convention(channel.usual)
            }
            None => None,
        }
    }
}

/// When usual names are looked for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Usual {
    Always,
    /// Where the map is empty.
    WithoutMap,
}

pub(super) struct Files<'a> {
    pub(super) files: Vec<File<'a>>,
    pub(super) joints: &'a [RecordedJoint],
    pub(super) reading: &'a Reading,
}

impl Files<'_> {
    fn find(&self, channel: &Channel, usual: Usual) -> Option<Vec<Pick>> {
        let pick = |file: usize, joint: &RecordedJoint, name: String| {
            let column = (channel.column)(self.files[file].source.map);
            let factor = column.as_ref().map_or(1.0, |c| c.factor(joint.number));
            Pick { file, name, factor }
        };
        let whole = self.files.iter().enumerate().find_map(|(number, file)| {
            let names = file.find(channel, self.joints, usual)?;
            let named = self.joints.iter().zip(names);
            Some(
                named
                    .map(|(joint, name)| pick(number, joint, name))
                    .collect(),
            )
        });
        whole.or_else(|| {
            let of = |joint: &RecordedJoint| {
                let alone = std::slice::from_ref(joint);
                self.files.iter().enumerate().find_map(|(number, file)| {
                    let name = file.find(channel, alone, usual)?.pop()?;
                    Some(pick(number, joint, name))
                })
            };
            self.joints.iter().map(of).collect()
        })
    }

    /// Errors: a column that no file has, among all that are present.
    pub(super) fn required(&self, channel: &Channel) -> Result<Vec<Pick>, RecordingError> {
        if let Some(picks) = self.find(channel, Usual::Always) {
            return Ok(picks);
        }
        let present: Vec<String> = self.files.iter().flat_map(|f| f.present.clone()).collect();
        let first = self.files[0].source;
        let finder = Finder::new(first.path, self.joints, &present);
        let maps = self.files.iter().map(|f| (channel.column)(f.source.map));
        let named = maps.flatten().next().cloned();
        match finder.required(&named, channel.usual, channel.what) {
            Err(error) => Err(error),
            // Each joint's column is somewhere, but not where its file's map says.
            Ok(names) => Err(finder.missing(names, channel.what)),
        }
    }

    pub(super) fn optional(&self, channel: &Channel) -> Result<Option<Vec<Pick>>, RecordingError> {
        let asked = |file: &File<'_>| (channel.column)(file.source.map).is_some();
        match self.find(channel, Usual::WithoutMap) {
            None if self.files.iter().any(asked) => self.required(channel).map(Some),
            found => Ok(found),
        }
    }

    fn commands(&self) -> Result<Signals, RecordingError> {
        let mut signals = Signals::of(self.required(&Channel::COMMAND)?);
        if let Some(speeds) = self.optional(&Channel::VELOCITY_COMMAND)? {
            signals.picks.extend(speeds);
            signals.commanded.velocity = true;
        }
        if let Some(torques) = self.optional(&Channel::FEED_FORWARD)? {
            signals.picks.extend(torques);
            signals.commanded.feed_forward = true;
        }
        Ok(signals)
    }

    pub(super) fn signal(&self, kind: SignalKind) -> Result<Signals, RecordingError> {
        if kind == SignalKind::PositionCommand {
            return self.commands();
        }
        Ok(Signals::of(match kind {
            SignalKind::Current => self.required(&Channel::CURRENT)?,
            SignalKind::BaseWrench => self.wrench()?,
            SignalKind::Both => [self.required(&Channel::TORQUE)?, self.wrench()?].concat(),
            _ => self.required(&Channel::TORQUE)?,
        }))
    }

    fn wrench(&self) -> Result<Vec<Pick>, RecordingError> {
        let of = |(number, file): (usize, &File<'_>)| {
            let finder = Finder::new(file.source.path, self.joints, &file.present);
            let names = finder.wrench(file.source.map)?.into_iter();
            let pick = |name| Pick {
                file: number,
                name,
                factor: 1.0,
            };
            Ok(names.map(pick).collect::<Vec<_>>())
        };
        let mut found = self.files.iter().enumerate().map(of);
        let first = found.next().unwrap_or_else(|| Ok(Vec::new()));
        first.or_else(|error| found.find_map(Result::ok).ok_or(error))
    }

    /// The masks of all files that have one.
    pub(super) fn mask(&self) -> Result<Vec<Pick>, RecordingError> {
        let mut masks = Vec::new();
        let mut fault = None;
        for (file, of) in self.files.iter().enumerate() {
            let finder = Finder::new(of.source.path, self.joints, &of.present);
            match finder.one(&of.source.map.mask, "mask") {
                Ok(name) => masks.extend(name.map(|name| Pick {
                    file,
                    name,
                    factor: 1.0,
                })),
                Err(error) => fault = Some(error),
            }
        }
        match fault.filter(|_| masks.is_empty()) {
            Some(error) => Err(error),
            None => Ok(masks),
        }
    }
}

/// The columns of the signal.
pub(super) struct Signals {
    pub(super) picks: Vec<Pick>,
    pub(super) commanded: Commanded,
}

impl Signals {
    /// Without commands beside those of the position.
    fn of(picks: Vec<Pick>) -> Self {
        Self {
            picks,
            commanded: Commanded::default(),
        }
    }
}

/// The columns of all channels.
pub(super) struct Chosen {
    pub(super) position: Vec<Pick>,
    pub(super) velocity: Option<Vec<Pick>>,
    pub(super) acceleration: Option<Vec<Pick>>,
    pub(super) signal: Signals,
    pub(super) temperature: Option<Vec<Pick>>,
    pub(super) mask: Vec<Pick>,
}

impl Chosen {
    pub(super) fn all(&self) -> Vec<&Vec<Pick>> {
        let optional = [&self.velocity, &self.acceleration, &self.temperature];
        let always = [&self.position, &self.signal.picks, &self.mask];
        always
            .into_iter()
            .chain(optional.into_iter().flatten())
            .collect()
    }
}
