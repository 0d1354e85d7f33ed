//! The samples of a recording as they were read, channel by channel.

use std::path::{Path, PathBuf};

use crate::recording::channels::lost::LostSignal;
use crate::recording::channels::missing::MissingValues;
use crate::recording::series::differences::steps;

/// Steps of time beyond which samples are missing.
const GAP_STEPS: f64 = 2.5;

/// What the signal of a recording is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SignalKind {
    /// Motor currents, A.
    Current,
    /// Motor torques at the joint side, N·m (N).
    Torque,
    /// Motor torques at the motor side, N·m (N).
    MotorTorque,
    /// Joint torques behind the gear, N·m (N).
    LinkTorque,
    /// Reaction of the base: force in N, moment in N·m.
    BaseWrench,
    /// Motor torques at the joint side, then the reaction of the base.
    Both,
    /// Commanded positions, rad (m), less the positions; then commanded speeds, rad/s (m/s), and torques that are fed
    /// forward, N·m (N), where there are columns of them.
    PositionCommand,
}

impl SignalKind {
    /// Channels of the signal of so many joints; what controllers are told beside the position is none of it.
    pub fn channels(self, joints: usize) -> usize {
        match self {
            Self::BaseWrench => 6,
            Self::Both => joints + 6,
            _ => joints,
        }
    }
}

/// What was measured, as read: nothing averaged, filtered or scaled.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// The file that was read, the first of several.
    pub file: PathBuf,
    /// Time stamps, s.
    pub time: Option<Vec<f64>>,
    /// Line of sample 0 in the file; sample k is line `first_line + k` where no rows are left out.
    pub first_line: usize,
    /// Line of every sample, where they do not follow one another.
    pub lines: Option<Vec<usize>>,
    /// `position[j][k]`: joint j, sample k; rad or m.
    pub position: Vec<Vec<f64>>,
    /// rad/s or m/s, if measured.
    pub velocity: Option<Vec<Vec<f64>>>,
    /// rad/s² or m/s², if measured.
    pub acceleration: Option<Vec<Vec<f64>>>,
    /// `signal[c][k]`: channel c (joints, six of a wrench, or joints and then six), sample k.
    pub signal: Vec<Vec<f64>>,
    /// What of the signal controllers are told beside the position.
    pub commanded: Commanded,
    /// °C, if measured.
    pub temperature: Option<Vec<Vec<f64>>>,
    /// false: the sample is left out.
    pub mask: Option<Vec<bool>>,
    /// Set where the file repeats or interpolates every sample and only the samples themselves are kept.
    pub held: Option<Upsampled>,
    /// Set where `time` is an even clock: the deviation of the file's stamps from it, s.
    pub stamp_jitter: Option<f64>,
    /// Set where `time` is made to agree with the periods of the motion.
    pub clock_drift: Option<ClockDrift>,
    /// Set where cells of the file hold no number; their rows are masked.
    pub missing: Option<MissingValues>,
    /// Set where channels of the signal are cut off or stand still.
    pub lost: Option<LostSignal>,
    /// What a reader of any result should know of how the files were put together.
    pub remarks: Vec<String>,
}

impl Recording {
    /// Positions and signals alone, as of a file with one line above them.
    pub fn of_samples(
        file: impl Into<PathBuf>,
        position: Vec<Vec<f64>>,
        signal: Vec<Vec<f64>>,
    ) -> Self {
        Self {
            file: file.into(),
            time: None,
            first_line: 2,
            lines: None,
            position,
            velocity: None,
            acceleration: None,
            signal,
            commanded: Commanded::default(),
            temperature: None,
            mask: None,
            held: None,
            stamp_jitter: None,
            clock_drift: None,
            missing: None,
            lost: None,
            remarks: Vec::new(),
        }
    }

    /// The same with time stamps, s.
    pub(in crate::recording) fn at(mut self, time: Vec<f64>) -> Self {
        self.time = Some(time);
        self
    }

    /// Whether the signal of every sample counts; `None`: all do. The motion of samples without a signal is known.
    pub fn signal_mask(&self) -> Option<Vec<bool>> {
        let Some(lost) = &self.lost else {
            return self.mask.clone();
        };
        let both = |mask: &Vec<bool>| {
            mask.iter()
                .zip(&lost.valid)
                .map(|(a, b)| *a && *b)
                .collect()
        };
        Some(self.mask.as_ref().map_or_else(|| lost.valid.clone(), both))
    }

    /// Keeps some samples.
    pub(in crate::recording) fn keep(&mut self, kept: &[usize]) {
        let pick = |series: &mut Vec<f64>| *series = kept.iter().map(|&k| series[k]).collect();
        let groups = [
            &mut self.velocity,
            &mut self.acceleration,
            &mut self.temperature,
        ];
        groups.into_iter().flatten().flatten().for_each(pick);
        self.position.iter_mut().for_each(pick);
        self.signal.iter_mut().for_each(pick);
        self.time.iter_mut().for_each(pick);
        let lost = self.lost.as_mut().map(|lost| &mut lost.valid);
        for mask in self.mask.as_mut().into_iter().chain(lost) {
            *mask = kept.iter().map(|&k| mask[k]).collect();
        }
        if let Some(lines) = &mut self.lines {
            *lines = kept.iter().map(|&k| lines[k]).collect();
        }
        self.first_line += kept.first().copied().unwrap_or(0);
    }
}

/// Commands that a recording has beside those of the position, behind them in its signal.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Commanded {
    /// Commanded velocities.
    pub velocity: bool,
    /// Torques that are fed forward.
    pub feed_forward: bool,
}

/// How rows between samples were filled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Manner {
    /// By the last sample, again and again.
    Repeated,
    /// By straight lines from sample to sample.
    Interpolated,
}

/// Samples that were taken out of a file with more rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Upsampled {
    /// What stands between samples.
    pub manner: Manner,
    /// Rows of the file for one sample, on average.
    pub factor: f64,
    /// Row of the file of every sample.
    pub rows: Vec<usize>,
    /// Which channels were held.
    pub channels: &'static str,
}

impl Upsampled {
    /// What a reader of any result should know, at so many samples per second.
    fn words(&self, file: &Path, rate_hz: f64) -> String {
        let (slow, fast) = (rate_hz, rate_hz * self.factor);
        let how = match self.manner {
            Manner::Repeated => "repeated",
            Manner::Interpolated => "with straight lines between them,",
        };
        format!(
            "The {} of {} were taken at {slow:.4} Hz and are written {how} at {fast:.4} Hz: {} samples are used, and the rows \
             between them are left out.",
            self.channels,
            file.display(),
            self.rows.len(),
        )
    }
}

/// A clock of stamps that drifted against the motion, and was steadied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockDrift {
    /// Shortest and longest period of the motion by the stamps of the file, s.
    pub periods: [f64; 2],
    /// Greatest shift of a stamp, s.
    pub shift: f64,
}

impl ClockDrift {
    /// What a reader of any result should know of it.
    pub fn words(&self, file: &Path) -> String {
        let [shortest, longest] = self.periods;
        format!(
            "By the time stamps of {} the periods of its motion last from {shortest:.6} to {longest:.6} s: their clock drifts. \
             They are shifted by up to {:.3} ms, so that all periods are equally long.",
            file.display(),
            1e3 * self.shift
        )
    }
}

impl Recording {
    /// Line of a sample in the file.
    pub fn line(&self, sample: usize) -> usize {
        if let Some(line) = self.lines.as_ref().and_then(|lines| lines.get(sample)) {
            return *line;
        }
        let rows = self.held.as_ref().map(|held| held.rows.as_slice());
        let row = rows.and_then(|rows| Some(rows.get(sample)? - rows.first()?));
        self.first_line + row.unwrap_or(sample)
    }

    /// What a reader should know of rows that repeat or interpolate samples. Samples that are some rows apart, and some more, have
    /// the rate of their mean, and not that of most steps, `rate_hz`, on which the time base rests.
    pub fn held_words(&self, rate_hz: f64) -> Option<String> {
        let held = self.held.as_ref()?;
        let mean = self.time.as_ref().map(|time| {
            let steps = steps(time);
            let usual: Vec<f64> = (steps.iter().copied())
                .filter(|step| *step < GAP_STEPS / rate_hz)
                .collect();
            usual.len() as f64 / usual.iter().sum::<f64>()
        });
        Some(held.words(&self.file, mean.unwrap_or(rate_hz)))
    }

    /// Rows of the file for one sample.
    pub fn rows_per_sample(&self) -> f64 {
        self.held.as_ref().map_or(1.0, |held| held.factor)
    }
}
