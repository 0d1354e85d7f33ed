//! Rows of a recording, block by block: predicted and recorded signal and their derivatives, behind the filter that runs over
//! signal and model alike, if the recording has one.

use crate::chain::dataset::Prepared;
use crate::chain::effect::Memory;
use crate::chain::evaluate::{BLOCK, Block, Evaluator, KnownBodies, Segment};
use crate::chain::model::{Channel, Model};
use nalgebra::DVector;
use std::ops::Range;

/// Rows of a task: a recording is shared out among a few threads even if it is short.
fn task_rows(rows: usize) -> usize {
    rows.div_ceil(4)
        .next_multiple_of(BLOCK)
        .clamp(4 * BLOCK, 64 * BLOCK)
}

/// A part of a recording that one task works on.
#[derive(Debug, Clone)]
pub(crate) struct Task<'a> {
    pub recording: &'a Prepared,
    pub range: Range<usize>,
    /// What the bodies do along [`whole_motion`], where it is known.
    pub bodies: Option<&'a KnownBodies>,
}

/// Whether rows cannot be had without all rows: a filter runs over them, or a law has memory.
pub(in crate::estimate) fn needs_all(model: &Model, recording: &Prepared) -> bool {
    recording.experiment.parallel.is_some() || model.memory() == Memory::WholeMotion
}

/// What rows of a recording are computed along: all of it, or the rows that are used.
pub(in crate::estimate) fn whole_motion<'a>(model: &Model, recording: &'a Prepared) -> Segment<'a> {
    match needs_all(model, recording) {
        true => recording.whole(),
        false => recording.segment(),
    }
}

/// Splits recordings into tasks; the split depends on nothing but the model and the recordings.
pub(crate) fn tasks<'a>(
    model: &Model,
    recordings: impl Iterator<Item = &'a Prepared>,
) -> Vec<Task<'a>> {
    let mut tasks = Vec::new();
    for recording in recordings {
        let rows = recording.rows();
        let size = if needs_all(model, recording) {
            rows.max(1)
        } else {
            task_rows(rows)
        };
        for start in (0..rows).step_by(size) {
            tasks.push(Task {
                recording,
                range: start..rows.min(start + size),
                bodies: None,
            });
        }
    }
    tasks
}

/// Rows that a visitor is shown together.
pub(crate) struct RowBlock<'a> {
    recording: &'a Prepared,
    /// Rows of the recording.
    pub range: Range<usize>,
    source: Source<'a>,
}

enum Source<'a> {
    Block(&'a Block),
    Stored(&'a Stored),
    Torques(&'a Torques),
}

impl RowBlock<'_> {
    pub fn predicted(&self, channel: usize) -> &[f64] {
        match self.source {
            Source::Block(block) => block.value(channel),
            Source::Stored(stored) => &stored.values[channel][self.range.clone()],
            Source::Torques(torques) => &torques.values[channel],
        }
    }

    pub fn recorded(&self, channel: usize) -> &[f64] {
        &self.recording.signal(channel)[self.range.clone()]
    }

    pub fn derivative(&self, channel: usize, column: usize) -> Option<&[f64]> {
        match self.source {
            Source::Block(block) => block.derivative(channel, column),
            Source::Stored(stored) => {
                let series = &stored.columns[channel * stored.count + column];
                series.get(self.range.clone())
            }
            Source::Torques(torques) => {
                torques.columns[channel * torques.count + column].as_deref()
            }
        }
    }

    /// Position of the first row among the recording's rows.
    pub fn start(&self) -> usize {
        self.range.start
    }

    /// Which of the rows count for a channel; `None` where all do.
    pub fn counting_for(&self, channel: usize) -> Option<Vec<bool>> {
        let counts = |row| self.recording.counts_for(channel, row);
        let mut rows = self.range.clone();
        (!rows.all(counts)).then(|| self.range.clone().map(counts).collect())
    }

    /// Which of the rows count; `None` where all do.
    pub fn counting(&self) -> Option<Vec<bool>> {
        let counts = |row| self.recording.counts(row);
        let mut rows = self.range.clone();
        (!rows.all(counts)).then(|| self.range.clone().map(counts).collect())
    }
}

/// Shows every row of a task to a visitor, in order.
pub(crate) fn visit(
    model: &Model,
    values: &DVector<f64>,
    columns: &[usize],
    task: &Task<'_>,
    mut visitor: impl FnMut(&RowBlock<'_>),
) {
    let recording = task.recording;
    let own = whole_motion(model, recording);
    let segment = Segment {
        bodies: task.bodies.or(own.bodies),
        ..own
    };
    let mut show = |range: Range<usize>, source: Source<'_>| {
        visitor(&RowBlock {
            recording,
            range,
            source,
        });
    };
    let blocks = task.range.clone().step_by(BLOCK);
    let blocks = blocks.map(|start| start..task.range.end.min(start + BLOCK));
    if needs_all(model, recording) {
        let stored = Stored::whole(model, values, columns, recording, segment);
        blocks.for_each(|range| show(range, Source::Stored(&stored)));
    } else {
        let mut evaluator = Evaluator::new(model, values, columns);
        blocks.for_each(|range| {
            let block = evaluator.evaluate(segment, range.clone());
            show(range, Source::Block(block));
        });
    }
}

/// Gain of every channel whose errors count as torques, and its position among the parameters: those of currents with
/// an unknown gain where the forces on the links are measured. Such a recording says which torque a current gives, so
/// the current is what is known and the torque what errs, and
///
/// ```text
/// e = gain·(ŝ − s),   ∂e/∂gain = −s,   ∂e/∂θ = gain·∂ŝ/∂θ
/// ```
///
/// Errors of a torque in the place of an input would pull ŝ towards zero, as those of a regressor do.
pub(crate) fn torque_gains(model: &Model, recording: &Prepared) -> Vec<Option<usize>> {
    let of = |channel: &Channel| {
        let joint = &model.joints()[channel.joint?];
        joint.gain.filter(|_| joint.polynomial.is_none())
    };
    let channels = model.channels().iter();
    channels
        .map(|channel| of(channel).filter(|_| recording.has_forces()))
        .collect()
}

/// Rows as errors count: like [`visit`], but with errors of torques where [`torque_gains`] has them.
pub(crate) fn visit_errors(
    model: &Model,
    values: &DVector<f64>,
    columns: &[usize],
    task: &Task<'_>,
    mut visitor: impl FnMut(&RowBlock<'_>),
) {
    let gains = torque_gains(model, task.recording);
    if gains.iter().all(Option::is_none) {
        return visit(model, values, columns, task, visitor);
    }
    visit(model, values, columns, task, |block| {
        let torques = Torques::of(block, values, columns, &gains);
        visitor(&RowBlock {
            recording: block.recording,
            range: block.range.clone(),
            source: Source::Torques(&torques),
        });
    });
}

/// Series of a block with errors of torques: `s + e` in the place of ŝ.
struct Torques {
    values: Vec<Vec<f64>>,
    count: usize,
    columns: Vec<Option<Vec<f64>>>,
}

impl Torques {
    fn of(
        block: &RowBlock<'_>,
        values: &DVector<f64>,
        columns: &[usize],
        gains: &[Option<usize>],
    ) -> Self {
        let mut out = Self {
            values: Vec::with_capacity(gains.len()),
            count: columns.len(),
            columns: Vec::with_capacity(gains.len() * columns.len()),
        };
        for (channel, at) in gains.iter().enumerate() {
            let (predicted, recorded) = (block.predicted(channel), block.recorded(channel));
            let gain = at.map_or(1.0, |at| values[at]);
            let pairs = predicted.iter().zip(recorded);
            let shifted = pairs.map(|(p, s)| s + gain * (p - s));
            out.values.push(shifted.collect());
            for (k, column) in columns.iter().enumerate() {
                let derivative = match *at == Some(*column) {
                    true => Some(recorded.iter().map(|s| -s).collect()),
                    false => (block.derivative(channel, k))
                        .map(|series| series.iter().map(|x| gain * x).collect()),
                };
                out.columns.push(derivative);
            }
        }
        out
    }
}

/// Series of a whole recording at its used rows, filtered where it has a filter.
struct Stored {
    values: Vec<Vec<f64>>,
    count: usize,
    columns: Vec<Vec<f64>>,
}

impl Stored {
    fn whole(
        model: &Model,
        values: &DVector<f64>,
        columns: &[usize],
        recording: &Prepared,
        segment: Segment<'_>,
    ) -> Self {
        let (channels, count) = (model.channels().len(), columns.len());
        let rows = recording.experiment.rows();
        let mut out = Self {
            values: vec![Vec::with_capacity(rows); channels],
            count,
            columns: vec![Vec::new(); channels * count],
        };
        let whole_motion = model.memory() == Memory::WholeMotion;
        let (mut evaluator, size) = match whole_motion {
            true => (Evaluator::along(model, values, columns, rows), rows.max(1)),
            false => (Evaluator::new(model, values, columns), BLOCK),
        };
        for start in (0..rows).step_by(size) {
            let block = match whole_motion {
                true => evaluator.evaluate_whole(segment),
                false => {
                    let range = start..rows.min(start + size);
                    evaluator.evaluate(segment, range)
                }
            };
            for channel in 0..channels {
                out.values[channel].extend_from_slice(block.value(channel));
                for column in 0..count {
                    if let Some(series) = block.derivative(channel, column) {
                        let to = &mut out.columns[channel * count + column];
                        // A column can appear late; what came before is zero.
                        to.resize(start, 0.0);
                        to.extend_from_slice(series);
                    }
                }
            }
        }
        let finish = |series: &mut Vec<f64>| {
            if !series.is_empty() {
                series.resize(rows, 0.0);
                recording.experiment.apply_parallel(series);
                *series = series.iter().step_by(recording.stride).copied().collect();
            }
        };
        out.values.iter_mut().for_each(finish);
        out.columns.iter_mut().for_each(finish);
        out
    }
}
