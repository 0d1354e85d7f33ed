//! One recording from several files, joined by time on the clock of the first.
//!
//! Each file has time stamps of its own, on one clock. Positions come to the first file's times by the natural cubic spline
//! through them, other channels by straight lines; where stamps agree, both give the samples themselves. What the files
//! do not have in common at their ends is cut, and times within a gap of a file are masked.

use std::path::Path;

use crate::fault::Place;
use crate::recording::column_map::{Column, ColumnMap};
use crate::recording::column_names::{
    ACCELERATION, COMMAND, CURRENT, FEED_FORWARD, POSITION, TEMPERATURE, TORQUE, VELOCITY,
    VELOCITY_COMMAND,
};
use crate::recording::columns::{Finder, RecordedJoint};
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::format::{columns_at, read_at};
use crate::recording::missing::{Bridged, MissingValues, Roles, bridge};
use crate::recording::reading::Reading;
use crate::recording::samples::Commanded;
use crate::recording::samples::{Recording, SignalKind};
use crate::recording::spline::Spline;
use crate::recording::table::require_rows;
use crate::recording::timing::interpolate;
use crate::stats::robust::median;

/// A step of more than this many usual ones is a gap: across one sample that is missing a line is as good as across a step.
const GAP_STEPS: f64 = 2.5;

/// Stamps that agree within this share of a step are those of one instant.
const SAME_INSTANT: f64 = 0.01;

/// A file of a recording, and where its channels stand.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    pub path: &'a Path,
    pub map: &'a ColumnMap,
}

/// Reads a recording of the joints, in their order, from files with time stamps of one clock. Each channel comes from the
/// first file that has it for all joints or, joint by joint, from the first that has it.
///
/// Errors: those of the files and their tables, a column that no file has, a file without time stamps, files without
/// common time.
pub fn read_joined(
    sources: &[Source<'_>],
    joints: &[RecordedJoint],
    (kind, reading): (SignalKind, &Reading),
) -> Result<Recording, RecordingError> {
    let files = sources
        .iter()
        .map(|source| File::open(*source, joints, reading));
    let files = Files {
        files: files.collect::<Result<_, _>>()?,
        joints,
        reading,
    };
    let chosen = Chosen {
        position: files.required(&Channel::POSITION)?,
        velocity: files.optional(&Channel::VELOCITY)?,
        acceleration: files.optional(&Channel::ACCELERATION)?,
        signal: files.signal(kind)?,
        temperature: files.optional(&Channel::TEMPERATURE)?,
        mask: files.mask()?,
    };
    let mut read = Vec::with_capacity(files.files.len());
    for number in 0..files.files.len() {
        read.push(files.read(number, &chosen)?);
    }
    chosen.joined(&files, read)
}

/// A kind of channel: where a map names it, its usual names, and what it is.
struct Channel {
    column: fn(&ColumnMap) -> &Option<Column>,
    usual: &'static [&'static str],
    what: &'static str,
}

impl Channel {
    const POSITION: Self = Self {
        column: |map| &map.position,
        usual: POSITION,
        what: "position",
    };
    const VELOCITY: Self = Self {
        column: |map| &map.velocity,
        usual: VELOCITY,
        what: "velocity",
    };
    const ACCELERATION: Self = Self {
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
    const TEMPERATURE: Self = Self {
        column: |map| &map.temperature,
        usual: TEMPERATURE,
        what: "temperature",
    };
}

/// A column of one of the files.
#[derive(Debug, Clone, PartialEq)]
struct Pick {
    file: usize,
    name: String,
    /// What turns its numbers into SI units.
    factor: f64,
}

/// A file with the names of its columns.
struct File<'a> {
    source: Source<'a>,
    present: Vec<String>,
    time: String,
}

impl<'a> File<'a> {
    fn open(
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

struct Files<'a> {
    files: Vec<File<'a>>,
    joints: &'a [RecordedJoint],
    reading: &'a Reading,
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
    fn required(&self, channel: &Channel) -> Result<Vec<Pick>, RecordingError> {
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

    fn optional(&self, channel: &Channel) -> Result<Option<Vec<Pick>>, RecordingError> {
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

    fn signal(&self, kind: SignalKind) -> Result<Signals, RecordingError> {
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
    fn mask(&self) -> Result<Vec<Pick>, RecordingError> {
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

    /// The chosen columns of one file.
    fn read(&self, number: usize, chosen: &Chosen) -> Result<Content, RecordingError> {
        let File { source, time, .. } = &self.files[number];
        let of_file = |picks: &[Pick]| -> Vec<String> {
            let own = picks.iter().filter(|pick| pick.file == number);
            own.map(|pick| pick.name.clone()).collect()
        };
        let slow = of_file(chosen.temperature.as_deref().unwrap_or_default());
        let mask = of_file(&chosen.mask);
        let mut wanted = vec![time.clone()];
        for name in chosen.all().into_iter().flat_map(|picks| of_file(picks)) {
            if wanted.contains(&name) {
                let place = Place::file(source.path).key(name.as_str());
                let kind = RecordingErrorKind::ColumnUsedTwice { name };
                return Err(RecordingError::new(place, kind));
            }
            wanted.push(name);
        }
        let table = read_at(source.path, &wanted, self.reading)?;
        let origin = table.origin(time);
        let lines = table.lines.clone();
        let first_line = table.first_line;
        let roles = Roles {
            time: Some(time),
            mask: mask.first().map(String::as_str),
            slow: &slow,
        };
        let Bridged {
            mut table,
            valid,
            missing,
        } = bridge(source.path, table, roles)?;
        let mut stamps = table.take(time).unwrap_or_default();
        let unit = source.map.time.as_ref().map_or(1.0, |c| c.factor(1));
        stamps.iter_mut().for_each(|t| *t *= unit);
        let rows = stamps.len();
        let mut counts = valid.unwrap_or_else(|| vec![true; rows]);
        if let Some(masked) = mask.first().and_then(|name| table.take(name)) {
            counts
                .iter_mut()
                .zip(masked)
                .for_each(|(a, b)| *a &= b != 0.0);
        }
        let content = Content {
            stamps,
            origin,
            first_line,
            lines,
            counts,
            missing,
            columns: table.columns.into_iter().zip(table.data).collect(),
        };
        content.require_increasing(source.path)?;
        Ok(content)
    }
}

/// What was read of one file.
struct Content {
    /// s.
    stamps: Vec<f64>,
    /// When the stamps begin, ns since 1970, where the file says it.
    origin: Option<i64>,
    first_line: usize,
    lines: Option<Vec<usize>>,
    /// false: the row is left out.
    counts: Vec<bool>,
    missing: Option<MissingValues>,
    columns: Vec<(String, Vec<f64>)>,
}

impl Content {
    fn require_increasing(&self, path: &Path) -> Result<(), RecordingError> {
        let time = &self.stamps;
        let Some(k) = (1..time.len()).find(|&k| time[k] <= time[k - 1]) else {
            return Ok(());
        };
        let lines = self.lines.as_ref();
        let line = lines.map_or(self.first_line + k, |lines| lines[k]);
        let kind = RecordingErrorKind::TimeNotIncreasing {
            before: time[k - 1],
            found: time[k],
        };
        Err(RecordingError::new(
            Place::file(path).line(line).key("time"),
            kind,
        ))
    }

    /// Rows that are left out are a gap in time.
    fn leave_out_rows(&mut self) {
        let counts = std::mem::take(&mut self.counts);
        let keep = |series: &mut Vec<f64>| {
            let mut counts = counts.iter();
            series.retain(|_| counts.next().copied().unwrap_or(true));
        };
        keep(&mut self.stamps);
        self.columns.iter_mut().for_each(|(_, series)| keep(series));
    }

    fn step(&self) -> f64 {
        let steps: Vec<f64> = self.stamps.windows(2).map(|t| t[1] - t[0]).collect();
        median(&steps).unwrap_or(0.0)
    }

    fn span(&self) -> [f64; 2] {
        let [first, .., last] = self.stamps[..] else {
            return [f64::NAN; 2];
        };
        [first, last]
    }

    fn series(&self, name: &str) -> &[f64] {
        let found = self.columns.iter().find(|(column, _)| column == name);
        found.map_or(&[], |(_, series)| series)
    }
}

/// For each time the sample at or before it, and the weight of the sample after.
fn brackets(stamps: &[f64], times: &[f64]) -> Vec<(usize, f64)> {
    let mut k = 0;
    let bracket = |&t: &f64| {
        while k + 2 < stamps.len() && stamps[k + 1] <= t {
            k += 1;
        }
        let weight = (t - stamps[k]) / (stamps[k + 1] - stamps[k]);
        (k, weight.clamp(0.0, 1.0))
    };
    times.iter().map(bracket).collect()
}

/// The columns of the signal.
struct Signals {
    picks: Vec<Pick>,
    commanded: Commanded,
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
struct Chosen {
    position: Vec<Pick>,
    velocity: Option<Vec<Pick>>,
    acceleration: Option<Vec<Pick>>,
    signal: Signals,
    temperature: Option<Vec<Pick>>,
    mask: Vec<Pick>,
}

impl Chosen {
    fn all(&self) -> Vec<&Vec<Pick>> {
        let optional = [&self.velocity, &self.acceleration, &self.temperature];
        let always = [&self.position, &self.signal.picks, &self.mask];
        always
            .into_iter()
            .chain(optional.into_iter().flatten())
            .collect()
    }

    /// Brings all channels to the times of the first file.
    fn joined(
        &self,
        files: &Files<'_>,
        mut read: Vec<Content>,
    ) -> Result<Recording, RecordingError> {
        on_one_clock(files, &mut read)?;
        for content in &mut read[1..] {
            content.leave_out_rows();
        }
        let path = files.files[0].source.path;
        for (content, file) in read.iter().zip(&files.files) {
            require_rows(file.source.path, content.stamps.len())?;
        }
        let [begin, end] = common_span(files, &read)?;
        let first = &read[0];
        let inside = |&k: &usize| (begin..=end).contains(&first.stamps[k]);
        let kept: Vec<usize> = (0..first.stamps.len()).filter(inside).collect();
        require_rows(path, kept.len())?;
        let times: Vec<f64> = kept.iter().map(|&k| first.stamps[k]).collect();
        let mut mask: Vec<bool> = kept.iter().map(|&k| first.counts[k]).collect();
        let mut remarks = Vec::new();
        for (content, file) in read.iter().zip(&files.files).skip(1) {
            let step = content.step();
            let brackets = brackets(&content.stamps, &times);
            let mut moved = false;
            for (counts, &(k, weight)) in mask.iter_mut().zip(&brackets) {
                let between = (SAME_INSTANT..=1.0 - SAME_INSTANT).contains(&weight);
                moved |= between;
                let is_gap = content.stamps[k + 1] - content.stamps[k] > GAP_STEPS * step;
                *counts &= !(between && is_gap);
            }
            let missing = content.missing.as_ref();
            remarks.extend(missing.map(|m| m.words(file.source.path)));
            remarks.extend(moved.then(|| {
                format!(
                    "What {} has at {:.4} Hz comes to the times of {}, {:.4} Hz: positions by splines, other channels by \
                     straight lines.",
                    file.source.path.display(),
                    1.0 / step,
                    path.display(),
                    1.0 / first.step()
                )
            }));
        }
        let cut = first.stamps.len() - kept.len();
        remarks.extend((cut > 0).then(|| {
            format!(
                "{cut} rows of {} lie before or after what the other files have, and are cut.",
                path.display()
            )
        }));
        let on_clock = |pick: &Pick, way: Way| {
            let content = &read[pick.file];
            let series = content.series(&pick.name);
            let mut values: Vec<f64> = match (pick.file, way) {
                (0, _) => kept.iter().map(|&k| series[k]).collect(),
                (_, Way::Spline) => Spline::new(&content.stamps, series).at(&times),
                (_, Way::Line) => interpolate(series, &brackets(&content.stamps, &times)),
            };
            values.iter_mut().for_each(|x| *x *= pick.factor);
            values
        };
        let all = |picks: &Vec<Pick>, way: Way| -> Vec<Vec<f64>> {
            picks.iter().map(|pick| on_clock(pick, way)).collect()
        };
        let lines = |k: &usize| first.lines.as_ref().map(|lines| lines[*k]);
        Ok(Recording {
            first_line: first.first_line + kept.first().copied().unwrap_or(0),
            lines: kept.iter().map(lines).collect(),
            velocity: self.velocity.as_ref().map(|picks| all(picks, Way::Line)),
            acceleration: self
                .acceleration
                .as_ref()
                .map(|picks| all(picks, Way::Line)),
            temperature: self.temperature.as_ref().map(|picks| all(picks, Way::Line)),
            mask: mask.contains(&false).then_some(mask),
            missing: first.missing.clone(),
            commanded: self.signal.commanded,
            remarks,
            ..Recording::of_samples(
                path,
                all(&self.position, Way::Spline),
                all(&self.signal.picks, Way::Line),
            )
        }
        .at(times))
    }
}

/// How a channel comes to the times of another.
#[derive(Clone, Copy)]
enum Way {
    Spline,
    Line,
}

/// Stamps that count from the begin of their own file come to that of the first.
///
/// Errors: a file that says when it began beside one that does not.
fn on_one_clock(files: &Files<'_>, read: &mut [Content]) -> Result<(), RecordingError> {
    let origin = read[0].origin;
    for (content, file) in read.iter_mut().zip(&files.files) {
        match (origin, content.origin) {
            (Some(first), Some(own)) => {
                let later = own.wrapping_sub(first) as f64 * 1e-9;
                content.stamps.iter_mut().for_each(|t| *t += later);
            }
            (None, None) => {}
            _ => {
                let place = Place::file(file.source.path).key(file.time.as_str());
                let kind = RecordingErrorKind::ClocksDiffer;
                return Err(RecordingError::new(place, kind));
            }
        }
    }
    Ok(())
}

/// From when to when all files have samples, s.
fn common_span(files: &Files<'_>, read: &[Content]) -> Result<[f64; 2], RecordingError> {
    let mut common = read[0].span();
    for (content, file) in read.iter().zip(&files.files) {
        let [first, last] = content.span();
        let both = [common[0].max(first), common[1].min(last)];
        if both[0] >= both[1] {
            let kind = RecordingErrorKind::NoCommonTime {
                span: [first, last],
                others: common,
            };
            return Err(RecordingError::new(Place::file(file.source.path), kind));
        }
        common = both;
    }
    Ok(common)
}
