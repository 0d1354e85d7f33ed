//! One recording from several files, joined by time on the clock of the first.
//!
//! Each file has time stamps of its own, on one clock. Positions come to the first file's times by the natural cubic spline
//! through them, other channels by straight lines; where stamps agree, both give the samples themselves. What the files
//! do not have in common at their ends is cut, and times within a gap of a file are masked.

use crate::fault::Place;
use crate::recording::channels::columns::RecordedJoint;
use crate::recording::channels::samples::{Recording, SignalKind};
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::reading::Reading;
use crate::recording::formats::table::require_rows;
use crate::recording::join::columns::{Channel, Chosen, File, Files, Pick};
use crate::recording::join::content::Content;
use crate::recording::series::interpolation::{brackets, on_lines};
use crate::recording::series::spline::Spline;

pub use crate::recording::join::columns::Source;

mod columns;
mod content;
pub mod separate_encoder;

/// A step of more than this many usual ones is a gap: across one sample that is missing a line is as good as across a step.
const GAP_STEPS: f64 = 2.5;

/// Stamps that agree within this share of a step are those of one instant.
const SAME_INSTANT: f64 = 0.01;

/// Reads a recording of the joints, in their order, from files with time stamps of one clock. Each channel comes from the
/// first file that has it for all joints or, joint by joint, from the first that has it.
///
/// Errors: those of the files and their tables, a column that no file has, a file without time stamps, files without
/// common time.
pub fn read_joined(
    sources: &[Source<'_>],
    joints: &[RecordedJoint],
    kind: SignalKind,
    reading: &Reading,
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
        read.push(Content::read(&files, number, &chosen)?);
    }
    joined(&chosen, &files, read)
}

/// Brings all channels to the times of the first file.
fn joined(
    chosen: &Chosen,
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
        for (counts, at) in mask.iter_mut().zip(&brackets) {
            let between = (SAME_INSTANT..=1.0 - SAME_INSTANT).contains(&at.share);
            moved |= between;
            let apart = content.stamps[at.before + 1] - content.stamps[at.before];
            let is_gap = apart > GAP_STEPS * step;
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
            (_, Way::Line) => on_lines(series, &brackets(&content.stamps, &times)),
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
        velocity: chosen.velocity.as_ref().map(|picks| all(picks, Way::Line)),
        acceleration: chosen
            .acceleration
            .as_ref()
            .map(|picks| all(picks, Way::Line)),
        temperature: chosen
            .temperature
            .as_ref()
            .map(|picks| all(picks, Way::Line)),
        mask: mask.contains(&false).then_some(mask),
        missing: first.missing.clone(),
        commanded: chosen.signal.commanded,
        remarks,
        ..Recording::of_samples(
            path,
            all(&chosen.position, Way::Spline),
            all(&chosen.signal.picks, Way::Line),
        )
    }
    .at(times))
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
