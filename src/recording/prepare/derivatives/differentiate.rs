//! Position, velocity and acceleration of all joints from what was recorded of a motion that does not repeat.

use std::ops::Range;

use crate::recording::channels::samples::Recording;
use crate::recording::error::RecordingError;
use crate::recording::prepare::derivatives::cutoff::{
    MotionSpectrum, Samples, Sampling, agree, choose_cutoffs,
};
use crate::recording::prepare::derivatives::reversals::about_reversals;
use crate::recording::prepare::derivatives::smoother::{Band, Channel, Smoothed, Smoother, Unrest};
use crate::recording::prepare::experiment::{Bandwidth, Chosen, Motion};
use crate::recording::prepare::filter::filter;
use crate::recording::prepare::motion_error::MotionError;
use crate::recording::prepare::settings::{Method, Preparation, Width};
use crate::recording::series::differences::{first, second};
use crate::recording::series::interpolation::{Bracket, Stencil, brackets};
use crate::recording::series::zero_phase::{ZeroPhase, edge_s};
use crate::recording::time_base::timing::{Grid, Timing};
use rayon::prelude::*;

/// A motion with its derivatives.
pub(in crate::recording) struct Differentiated {
    pub motion: Motion,
    pub error: MotionError,
    pub bandwidth: Vec<Bandwidth>,
    pub method: Method,
    /// Rows whose motion is known well enough, and in which the robot does not rest before or after it moves.
    pub known: Vec<bool>,
}

/// A robot that no joint of moves faster than this share of its RMS speed, before its first or after its last motion,
/// rests, moves off or comes to rest: static friction is anything there, and it has not slipped into its usual course.
const AT_REST: f64 = 0.03;

/// A joint moves whose RMS speed is so many times the error of its speed; another is held.
const MOVES: f64 = 10.0;

/// A time may lie behind the last row of a grid by this share of a step, which is rounding.
const BEHIND: f64 = 0.02;

impl Differentiated {
    /// Rows before the robot moves off and after it has come to rest.
    fn leave_out_ends_at_rest(&mut self) {
        let rms = |speed: &Vec<f64>| {
            let squares: f64 = speed.iter().map(|v| v * v).sum();
            (squares / speed.len().max(1) as f64).sqrt()
        };
        let joints = self.motion.velocity.iter().enumerate();
        let moving: Vec<(&Vec<f64>, f64)> = joints
            .map(|(j, speed)| (speed, rms(speed), self.error.velocity.deviation(j)))
            .filter(|(_, usual, error)| *usual > MOVES * error)
            .map(|(speed, usual, _)| (speed, AT_REST * usual))
            .collect();
        if moving.is_empty() {
            return;
        }
        let rests = |row: usize| moving.iter().all(|(v, least)| v[row].abs() <= *least);
        let rows = self.known.len();
        let before = (0..rows).take_while(|&row| rests(row)).count();
        let after = (0..rows).rev().take_while(|&row| rests(row)).count();
        self.known[..before].fill(false);
        self.known[rows - after..].fill(false);
    }

    /// The same at other times between the first and the last row of an even grid.
    pub fn at(mut self, times: &[f64], grid: Grid) -> Self {
        let knots = grid.times();
        let last = grid.time(grid.samples - 1);
        let places = brackets(&knots, times);
        let stencils: Vec<Stencil> = places.iter().map(|&at| Stencil::at(&knots, at)).collect();
        let motion = &mut self.motion;
        for series in [
            &mut motion.position,
            &mut motion.velocity,
            &mut motion.acceleration,
        ]
        .into_iter()
        .flatten()
        {
            *series = stencils.iter().map(|s| s.of(series)).collect();
        }
        // Behind the last row of the grid, by less than a step, there is no motion.
        let known = |(t, at): (&f64, &Bracket)| {
            let after = at.before + usize::from(at.share > 0.0);
            self.known[at.before] && self.known[after] && *t <= last + BEHIND / grid.rate_hz
        };
        self.known = times.iter().zip(&places).map(known).collect();
        self
    }

    /// The mask of some rows without those whose motion is not known well enough.
    pub fn mask(&self, mask: Option<Vec<bool>>, rows: &Range<usize>) -> Option<Vec<bool>> {
        let known = &self.known[rows.clone()];
        let counts = mask.map(|mask| mask[rows.clone()].to_vec());
        if !known.contains(&false) {
            return counts;
        }
        let counts = counts.unwrap_or_else(|| vec![true; known.len()]);
        Some(counts.iter().zip(known).map(|(a, b)| *a && *b).collect())
    }
}

/// Channels of a joint that were recorded, the position first; velocities that contradict it are left out.
fn channels<'a>(recording: &'a Recording, joint: usize, timing: &Timing) -> Vec<Samples<'a>> {
    let position = &recording.position[joint];
    let mut channels = vec![Samples {
        series: position,
        order: 0,
    }];
    if let Some(velocity) = &recording.velocity
        && agree(position, &velocity[joint], timing.rate_hz, sampling(timing))
    {
        channels.push(Samples {
            series: &velocity[joint],
            order: 1,
        });
        channels.extend(recording.acceleration.iter().map(|acceleration| Samples {
            series: &acceleration[joint],
            order: 2,
        }));
    }
    channels
}

fn sampling(timing: &Timing) -> Sampling {
    match timing.uniform {
        true => Sampling::Recorded,
        false => Sampling::Interpolated,
    }
}

/// Motion by the smoother, of all that was recorded of it. Its bandwidth and noise are those of the longest stretch
/// without a jerk.
pub(in crate::recording) fn smoothed(
    recording: &Recording,
    preparation: &Preparation,
    timing: &Timing,
) -> Result<Differentiated, RecordingError> {
    if let Some(cutoff) = preparation.differentiation.cutoff_hz {
        filter(&recording.file, cutoff, timing.rate_hz, "cutoff_hz")?;
    }
    let rows = recording.position.first().map_or(0, Vec::len);
    let joints = 0..recording.position.len();
    let channels = joints.map(|j| channels(recording, j, timing)).collect();
    let smoothing = Smoothing {
        recording,
        preparation,
        timing,
        channels,
    };
    let (mut differentiated, alike) = smoothing.by_spectra_of(0..rows);
    let longest = longest_run(&alike);
    if longest.len() < rows && 2 * longest.len() >= rows {
        differentiated = smoothing.by_spectra_of(longest).0;
    }
    differentiated.leave_out_ends_at_rest();
    Ok(differentiated)
}

/// What the smoother works on.
struct Smoothing<'a> {
    recording: &'a Recording,
    preparation: &'a Preparation,
    timing: &'a Timing,
    /// Of every joint.
    channels: Vec<Vec<Samples<'a>>>,
}

impl<'a> Smoothing<'a> {
    /// Of a joint, whose noise is that at its cut-off.
    fn smoother(
        &self,
        channels: &[Samples<'a>],
        spectrum: &MotionSpectrum,
        cutoff_hz: f64,
    ) -> Smoother<'a> {
        let of = |c: &Samples<'a>| Channel {
            series: c.series,
            order: c.order,
            variance: spectrum.variance(c.order, cutoff_hz),
        };
        let band = Band {
            cutoff_hz,
            rate_hz: self.timing.rate_hz,
        };
        let channels = channels.iter().map(of).collect();
        Smoother::new(channels, self.recording.mask.as_deref(), band)
    }

    /// The motion with the bandwidth and the noise of some rows, and which rows have no jerk.
    fn by_spectra_of(&self, some: Range<usize>) -> (Differentiated, Vec<bool>) {
        let rate_hz = self.timing.rate_hz;
        let of = |own: &Vec<Samples<'_>>| {
            let parts = own.iter().map(|c| Samples {
                series: &c.series[some.clone()],
                order: c.order,
            });
            MotionSpectrum::of(&parts.collect::<Vec<_>>(), rate_hz, sampling(self.timing))
        };
        let spectra: Vec<MotionSpectrum> = self.channels.par_iter().map(of).collect();
        let mut bandwidth = bandwidths(&spectra, self.preparation);
        let with = self.channels.iter().zip(&spectra).zip(&bandwidth);
        let smoothers: Vec<Smoother<'_>> = with
            .map(|((own, spectrum), bandwidth)| self.smoother(own, spectrum, bandwidth.cutoff_hz))
            .collect();
        let even = smoothers.par_iter().map(|s| s.smoothed(&Unrest::default()));
        let mut all: Vec<Smoothed> = even.collect();
        let rows = self.recording.position.first().map_or(0, Vec::len);
        let (mut motion, mut known) = (Motion::default(), vec![true; rows]);
        let mut alike = vec![true; rows];
        for (own, bandwidth) in all.iter().zip(&bandwidth) {
            let reach = (rate_hz / bandwidth.cutoff_hz).ceil() as usize;
            and(&mut alike, &like_the_others(&own.motion[2], reach));
            and(&mut known, &own.settled);
        }
        if self.preparation.differentiation.in_common.width == Width::WiderAboutReversals
            && let Some(about) = about_reversals(&smoothers, &all)
        {
            let with = smoothers.par_iter().zip(&about.unrest);
            all = with.map(|(s, unrest)| s.smoothed(unrest)).collect();
            for bandwidth in &mut bandwidth {
                bandwidth.reversals = about.reversals;
            }
        }
        for own in all {
            let [position, velocity, acceleration] = own.motion;
            motion.position.push(position);
            motion.velocity.push(velocity);
            motion.acceleration.push(acceleration);
        }
        and(&mut known, &alike);
        let differentiated = Differentiated {
            motion,
            error: motion_error(&spectra, &bandwidth),
            bandwidth,
            method: Method::Smoother,
            known,
        };
        (differentiated, alike)
    }
}

fn and(all: &mut [bool], own: &[bool]) {
    all.iter_mut().zip(own).for_each(|(a, b)| *a &= *b);
}

/// The longest run of rows that are true.
fn longest_run(rows: &[bool]) -> Range<usize> {
    let (mut best, mut start) = (0..0, 0);
    for part in rows.chunk_by(|a, b| a == b) {
        let run = start..start + part.len();
        start = run.end;
        if part[0] && run.len() > best.len() {
            best = run;
        }
    }
    best
}

/// Share of the rows whose accelerations are usual.
const USUAL: f64 = 0.99;

/// Accelerations beyond so many times the usual ones are no part of the motion: the largest of normal noise, or of a sum
/// of a few sines, are less than twice what 99 % of them stay below.
const BEYOND: f64 = 3.0;

/// Rows whose acceleration is like that of the others; not within `reach` rows of a jerk as when a controller catches a
/// robot that is elsewhere, or of a position that is wrong. A few such rows have more leverage than all others.
fn like_the_others(acceleration: &[f64], reach: usize) -> Vec<bool> {
    let rows = acceleration.len();
    let mut sizes: Vec<f64> = acceleration.iter().map(|a| a.abs()).collect();
    let at = ((USUAL * rows as f64) as usize).min(rows.saturating_sub(1));
    let mut alike = vec![true; rows];
    if rows == 0 {
        return alike;
    }
    let usual = *sizes.select_nth_unstable_by(at, f64::total_cmp).1;
    for row in (0..rows).filter(|&row| acceleration[row].abs() > BEYOND * usual) {
        alike[row.saturating_sub(reach)..(row + reach + 1).min(rows)].fill(false);
    }
    alike
}

fn motion_error(spectra: &[MotionSpectrum], bandwidth: &[Bandwidth]) -> MotionError {
    let joints = spectra.iter().zip(bandwidth);
    let deviations: Vec<[f64; 3]> = joints
        .map(|(spectrum, bandwidth)| spectrum.deviations(bandwidth.cutoff_hz))
        .collect();
    MotionError::independent(&deviations)
}

/// Motion by the zero-phase low-pass of what was measured of it; the rest by central differences.
pub(in crate::recording) fn low_passed(
    recording: &Recording,
    preparation: &Preparation,
    timing: &Timing,
) -> Result<Differentiated, RecordingError> {
    let rate_hz = timing.rate_hz;
    let finest = |j: usize| match (&recording.acceleration, &recording.velocity) {
        (Some(acceleration), _) => (&acceleration[j], 2),
        (None, Some(velocity)) => (&velocity[j], 1),
        (None, None) => (&recording.position[j], 0),
    };
    let spectrum = |j: usize| {
        let (series, order) = finest(j);
        MotionSpectrum::of(&[Samples { series, order }], rate_hz, sampling(timing))
    };
    let spectra: Vec<MotionSpectrum> = (0..recording.position.len()).map(spectrum).collect();
    let bandwidth = bandwidths(&spectra, preparation);
    let filters = bandwidth
        .iter()
        .map(|joint| filter(&recording.file, joint.cutoff_hz, rate_hz, "cutoff_hz"))
        .collect::<Result<Vec<_>, _>>()?;
    let longest = filters
        .iter()
        .map(|f| edge_s(f.cutoff_hz()))
        .fold(0.0, f64::max);
    let rows = recording.position.first().map_or(0, Vec::len);
    let edge = ((longest * rate_hz).ceil() as usize).min(rows);
    let mut known = vec![true; rows];
    known[..edge].fill(false);
    known[rows - edge..].fill(false);
    let longest = (LONG_GAP * longest * rate_hz) as usize;
    for gap in gaps(recording.mask.as_deref(), longest) {
        known[gap.start.saturating_sub(edge)..(gap.end + edge).min(rows)].fill(false);
    }
    Ok(Differentiated {
        motion: low_passed_motion(recording, &filters, 1.0 / rate_hz),
        error: motion_error(&spectra, &bandwidth),
        bandwidth,
        method: Method::Lowpass,
        known,
    })
}

/// A gap of less than this share of a filter's edge, a tenth of a period of its cut-off, is bridged without loss.
pub(in crate::recording) const LONG_GAP: f64 = 0.05;

/// Runs of more than so many rows that a mask leaves out.
pub(in crate::recording) fn gaps(mask: Option<&[bool]>, longest: usize) -> Vec<Range<usize>> {
    let mut gaps = Vec::new();
    let mut end = 0;
    for run in mask.unwrap_or_default().chunk_by(|a, b| a == b) {
        let start = end;
        end += run.len();
        if !run[0] && run.len() > longest {
            gaps.push(start..end);
        }
    }
    gaps
}

/// Filters what was measured of the motion and differentiates the rest, step in s.
fn low_passed_motion(recording: &Recording, filters: &[ZeroPhase], step: f64) -> Motion {
    let filtered = |channels: &Vec<Vec<f64>>| {
        let mut channels = channels.clone();
        for (series, filter) in channels.iter_mut().zip(filters) {
            filter.apply(series);
        }
        channels
    };
    let derived = |channels: &[Vec<f64>], derivative: fn(&[f64], f64) -> Vec<f64>| {
        let series = channels.iter().map(|series| derivative(series, step));
        series.collect::<Vec<_>>()
    };
    let position = filtered(&recording.position);
    let measured = recording.velocity.as_ref().map(filtered);
    let acceleration = match (&recording.acceleration, &measured) {
        (Some(acceleration), _) => filtered(acceleration),
        (None, Some(velocity)) => derived(velocity, first),
        (None, None) => derived(&position, second),
    };
    Motion {
        velocity: measured.unwrap_or_else(|| derived(&position, first)),
        position,
        acceleration,
    }
}

/// Bandwidths of all joints: given, or from the data.
fn bandwidths(spectra: &[MotionSpectrum], preparation: &Preparation) -> Vec<Bandwidth> {
    let given = preparation.differentiation.cutoff_hz;
    let cutoffs = match given {
        Some(hz) => vec![hz; spectra.len()],
        None => choose_cutoffs(spectra, preparation.differentiation.in_common.cutoff_hz),
    };
    let of = |(cutoff_hz, spectrum): (f64, &MotionSpectrum)| Bandwidth {
        harmonics: None,
        cutoff_hz,
        clear_hz: match given {
            Some(hz) => hz,
            None => spectrum.clear_hz(cutoff_hz),
        },
        chosen: match given {
            Some(_) => Chosen::Given,
            None => Chosen::Data,
        },
        reversals: 0,
    };
    cutoffs.into_iter().zip(spectra).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The known rows of joints with these speeds, whose errors are small.
    fn known(velocity: &[Vec<f64>]) -> Vec<bool> {
        let joints = velocity.len();
        let mut differentiated = Differentiated {
            motion: Motion {
                velocity: velocity.to_vec(),
                ..Motion::default()
            },
            error: MotionError::independent(&vec![[1e-6, 1e-3, 1e-3]; joints]),
            bandwidth: Vec::new(),
            method: Method::Smoother,
            known: vec![true; velocity[0].len()],
        };
        differentiated.leave_out_ends_at_rest();
        differentiated.known
    }

    #[test]
    fn ends_at_rest_are_left_out_whichever_way_the_robot_moves() {
        let speed = vec![0.0, -0.01, -1.0, -2.0, 0.0, 2.0, 1.0, 0.01, 0.0];
        let expected = [false, false, true, true, true, true, true, false, false];
        assert_eq!(known(std::slice::from_ref(&speed)), expected);
        let turned: Vec<f64> = speed.iter().map(|v| -v).collect();
        assert_eq!(known(&[turned]), expected);
        // As long as one joint moves the robot does; one that is held has noise alone.
        let other = vec![-1.0, -1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let both = known(&[speed.clone(), other]);
        assert_eq!(both[..2], [true, true]);
        assert_eq!(both[7..], [false, false]);
        let held = vec![0.002; 9];
        assert_eq!(known(&[speed, held.clone()]), expected);
        assert_eq!(known(&[held]), [true; 9]);
    }

    #[test]
    fn long_runs_that_a_mask_leaves_out_are_gaps() {
        let mask = [false, true, false, false, true, true, false, false, false];
        assert_eq!(gaps(Some(&mask), 0), [0..1, 2..4, 6..9]);
        assert_eq!(gaps(Some(&mask), 1), [2..4, 6..9]);
        assert!(gaps(Some(&mask), 3).is_empty());
        assert!(gaps(None, 0).is_empty());
    }
}
