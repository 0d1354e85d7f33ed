//! Where what the drives remember stands in the one array of numbers.

use crate::export::drive::Drives;

/// Entries of the state in front of those of effects: the time, and whether a step was made.
pub(super) const CLOCK: usize = 2;

/// Shortest step for which a line of delayed signals is long enough, s.
pub const SHORTEST_STEP: f64 = 1e-4;

/// Where the signals on their way to a motor stand, the newest first, and how many there are.
#[derive(Debug, Clone, Copy)]
pub(super) struct DelayLine {
    pub(super) first: usize,
    pub(super) count: usize,
}

/// Where the state of each law stands.
#[derive(Debug)]
pub(super) struct Layout {
    /// Of each joint's motor laws: state and velocity before, where the law has one.
    pub(super) bristles: Vec<Vec<Option<usize>>>,
    /// Of each joint: lag, the lag before it, and the rates of both.
    pub(super) lags: Vec<Option<usize>>,
    /// Of each joint: signals on their way.
    pub(super) lines: Vec<Option<DelayLine>>,
    pub(super) size: usize,
}

impl Layout {
    pub(super) fn of(drives: &Drives) -> Self {
        let mut size = CLOCK;
        let mut take = |count: usize| {
            size += count;
            size - count
        };
        let bristles = drives.drives.iter().map(|drive| {
            let laws = drive.motor.iter();
            laws.map(|law| (!law.states.is_empty()).then(|| take(law.states.len() + 1)))
                .collect()
        });
        let bristles = bristles.collect();
        let lags = drives.drives.iter();
        let lags = lags
            .map(|drive| drive.contact.as_ref().map(|_| take(4)))
            .collect();
        let lines = drives.drives.iter().map(|drive| {
            let count = (-drive.delay / SHORTEST_STEP).ceil() as usize + 2;
            (drive.delay < 0.0).then(|| DelayLine {
                first: take(count),
                count,
            })
        });
        let lines = lines.collect();
        Self {
            bristles,
            lags,
            lines,
            size,
        }
    }
}
