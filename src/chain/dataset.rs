//! Recordings as estimates use them: motor motion at joint scale, signal, weights of rows, the way back
//! to every recorded sample.

use crate::chain::evaluate::Segment;
use crate::recording::experiment::Experiment;
use crate::recording::split::Split;
use crate::robot::batch::Trajectory;

/// A low-passed signal holds nothing above its cut-off: rows closer than this many to a period of the
/// cut-off only repeat each other. Eight leave the fastest term within 1 % of its peak.
const ROWS_PER_CUTOFF_PERIOD: f64 = 8.0;

/// A recording ready for estimates. The experiment is in motor coordinates at joint scale.
#[derive(Debug, Clone)]
pub struct Prepared {
    pub name: String,
    pub split: Split,
    /// The load hangs on the robot.
    pub loaded: bool,
    pub experiment: Experiment,
    /// Every `stride`-th row of the experiment is used.
    pub stride: usize,
    rows: Option<Rows>,
}

#[derive(Debug, Clone)]
struct Rows {
    motion: [Vec<Vec<f64>>; 3],
    signal: Vec<Vec<f64>>,
}

impl Prepared {
    pub fn new(name: String, split: Split, loaded: bool, experiment: Experiment) -> Self {
        let stride = stride(&experiment);
        let every = |series: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let thin = |s: &Vec<f64>| s.iter().step_by(stride).copied().collect();
            series.iter().map(thin).collect()
        };
        let rows = (stride > 1).then(|| Rows {
            motion: [
                every(&experiment.motion.position),
                every(&experiment.motion.velocity),
                every(&experiment.motion.acceleration),
            ],
            signal: every(&experiment.signal),
        });
        Self {
            name,
            split,
            loaded,
            experiment,
            stride,
            rows,
        }
    }

    /// Number of rows used.
    pub fn rows(&self) -> usize {
        self.experiment.rows().div_ceil(self.stride)
    }

    /// Time of a used row, s.
    pub fn time(&self, row: usize) -> f64 {
        self.experiment.t[row * self.stride]
    }

    /// Whether a used row counts.
    pub fn counts(&self, row: usize) -> bool {
        let mask = self.experiment.mask.as_ref();
        mask.is_none_or(|mask| mask[row * self.stride])
    }

    /// Motion and load of the used rows.
    pub fn segment(&self) -> Segment<'_> {
        match &self.rows {
            None => self.whole(),
            Some(Rows {
                motion: [q, dq, ddq],
                ..
            }) => Segment {
                motors: Trajectory { q, dq, ddq },
                loaded: self.loaded,
            },
        }
    }

    /// Motion and load of all rows of the experiment.
    pub fn whole(&self) -> Segment<'_> {
        let motion = &self.experiment.motion;
        Segment {
            motors: Trajectory {
                q: &motion.position,
                dq: &motion.velocity,
                ddq: &motion.acceleration,
            },
            loaded: self.loaded,
        }
    }

    /// Signal of a channel at the used rows.
    pub fn signal(&self, channel: usize) -> &[f64] {
        match &self.rows {
            None => &self.experiment.signal[channel],
            Some(rows) => &rows.signal[channel],
        }
    }
}

fn stride(experiment: &Experiment) -> usize {
    if experiment.periods.is_some() {
        return 1;
    }
    let widest = experiment
        .bandwidth
        .iter()
        .map(|b| b.cutoff_hz)
        .fold(0.0, f64::max);
    let widest = match &experiment.parallel {
        Some(filter) => widest.min(filter.cutoff_hz()),
        None => widest,
    };
    let needed = ROWS_PER_CUTOFF_PERIOD * widest;
    if needed > 0.0 {
        ((experiment.rate_hz / needed) as usize).max(1)
    } else {
        1
    }
}

/// All recordings of a fit.
#[derive(Debug, Clone, Default)]
pub struct Dataset {
    pub recordings: Vec<Prepared>,
}

impl Dataset {
    pub fn of(&self, split: Split) -> impl Iterator<Item = &Prepared> {
        self.recordings.iter().filter(move |r| r.split == split)
    }

    /// Loads with which the training recordings were made: without, with, or both.
    pub fn loads(&self) -> Vec<bool> {
        let made = |loaded: bool| self.of(Split::Train).any(|r| r.loaded == loaded);
        [false, true].into_iter().filter(|&l| made(l)).collect()
    }
}
