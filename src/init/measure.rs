//! What the numbers of a recording say: the unit of time, units of positions and velocities, rate and period.

use crate::check::STILL;
use crate::init::channels::Channels;
use crate::init::error::InitError;
use crate::recording::column_map::ColumnMap;
use crate::recording::columns::{RecordedJoint, read};
use crate::recording::period;
use crate::recording::samples::{Recording, SignalKind};
use crate::recording::timing::examine;
use crate::recording::units::{self, Quantity};
use crate::stats::robust::{median, quantile};
use std::path::{Path, PathBuf};

/// Rates that controllers and loggers have, Hz.
const RATES: std::ops::RangeInclusive<f64> = 5.0..=20_000.0;

/// Motors of robots take less, A; larger numbers are milliamperes.
const MOST_AMPERES: f64 = 500.0;

/// Share of the samples that are no transients and no faults of a recorder.
const USUAL: f64 = 0.99;

/// Length over which velocities are integrated, s: longer than their filters, shorter than a swing.
const WINDOW_S: f64 = 0.1;

/// Correlation of changes of position with integrals of velocity from which they are one motion.
const SAME: f64 = 0.9;

/// Share by which a factor may miss that of a unit.
const TOLERANCE: f64 = 0.05;

/// What is measured of the first recording.
pub(super) struct Measured {
    /// After how many seconds the motion repeats, to the noise.
    pub period: Option<f64>,
    /// Hz, where it does not follow from time stamps.
    pub rate: Option<f64>,
    /// What was found, one sentence each.
    pub remarks: Vec<String>,
}

/// Measures, and gives the channels their units; a rate is given where nothing else may tell it, Hz.
pub(super) fn measure(
    file: &Path,
    channels: &mut Channels,
    names: &[String],
    given: Option<f64>,
) -> Result<Measured, InitError> {
    let mut remarks = Vec::new();
    let raw = open(file, channels, names)?;
    let stamps = raw.time.as_deref().and_then(step);
    if let (Some(time), Some(step)) = (&mut channels.time, stamps)
        && time.unit.is_none()
    {
        time.unit = unit_of_time(step);
        remarks.extend(time.unit.map(|unit| {
            format!(
                "time ({}) is in {unit}: its steps of {step:.6} give a rate that a logger can have",
                time.written()
            )
        }));
    }
    if channels.signal.quantity == Quantity::Current && channels.signal.unit.is_none() {
        let mut sizes: Vec<f64> = raw.signal.iter().flatten().map(|i| i.abs()).collect();
        let usual = match sizes.is_empty() {
            true => 0.0,
            false => quantile(&mut sizes, USUAL),
        };
        if usual > MOST_AMPERES {
            channels.signal.unit = Some("mA");
            remarks.push(format!(
                "currents of {usual:.0} and more are taken as milliamperes"
            ));
        }
    }
    let mut recording = open(file, channels, names)?;
    let mut rate = given;
    let slope = slope(&recording);
    match (&recording.time, slope) {
        (None, None) if given.is_none() => {
            let file = file.to_path_buf();
            return Err(InitError::NoTimeBase { file });
        }
        (None, Some(step)) => rate = given.or(Some((1e6 / step).round() / 1e6)),
        (Some(_), Some(factor)) => {
            remarks.extend(unit_of_motion(channels, factor));
            recording = open(file, channels, names)?;
        }
        (_, None) => {}
    }
    let found = examine(&recording, rate)
        .ok()
        .and_then(|timing| period::find(&recording, &timing));
    Ok(Measured {
        period: found.filter(period::Repetition::is_exact).map(|f| f.period),
        rate,
        remarks,
    })
}

/// A joint that does not move.
pub(super) struct Standing {
    pub joint: String,
    /// Median of its positions, rad or m; zero of a joint without a column.
    pub at: f64,
    /// Whether it has a column.
    pub is_recorded: bool,
}

/// The joints that no recording moves or has a column for; where all that are recorded stand, those are not among them.
///
/// # Errors
/// Those of files.
pub(super) fn standing(
    files: &[PathBuf],
    channels: &Channels,
    names: &[String],
) -> Result<Vec<Standing>, InitError> {
    let recorded = &channels.position.joints;
    let mut all: Vec<Vec<f64>> = vec![Vec::new(); recorded.len()];
    for file in files {
        let recording = open(file, channels, names)?;
        for (to, series) in all.iter_mut().zip(recording.position) {
            to.extend(series);
        }
    }
    let stands = |series: &Vec<f64>| -> Option<f64> {
        let at = median(series)?;
        series.iter().all(|q| (q - at).abs() < STILL).then_some(at)
    };
    let stand: Vec<Option<f64>> = all.iter().map(stands).collect();
    let any_moves = stand.contains(&None);
    let of = |joint: usize| {
        let place = recorded.iter().position(|j| *j == joint);
        let at = match place {
            Some(place) => stand[place].filter(|_| any_moves)?,
            None => 0.0,
        };
        Some(Standing {
            joint: names[joint].clone(),
            at,
            is_recorded: place.is_some(),
        })
    };
    Ok((0..names.len()).filter_map(of).collect())
}

fn open(file: &Path, channels: &Channels, names: &[String]) -> Result<Recording, InitError> {
    let joints = channels.position.joints.iter().map(|&j| RecordedJoint {
        name: names[j].clone(),
        number: j + 1,
    });
    let joints: Vec<RecordedJoint> = joints.collect();
    let signal = Some(channels.signal.column());
    let only = |kind| signal.clone().filter(|_| channels.kind == kind);
    let map = ColumnMap {
        time: channels.time.as_ref().map(|c| c.column()),
        position: Some(channels.position.column()),
        velocity: channels.velocity.as_ref().map(|c| c.column()),
        current: only(SignalKind::Current),
        torque: only(SignalKind::Torque),
        command: only(SignalKind::PositionCommand),
        ..ColumnMap::default()
    };
    Ok(read(file, &map, &joints, channels.kind)?)
}

/// The median step of time stamps.
fn step(time: &[f64]) -> Option<f64> {
    let steps: Vec<f64> = time.windows(2).map(|t| t[1] - t[0]).collect();
    median(&steps).filter(|step| *step > 0.0)
}

/// The unit other than seconds in which steps of this size give a rate that a logger can have; none where seconds do.
fn unit_of_time(step: f64) -> Option<&'static str> {
    let fits = |factor: f64| RATES.contains(&(1.0 / (step * factor)));
    if fits(1.0) {
        return None;
    }
    ["ms", "us", "ns"]
        .into_iter()
        .find(|unit| units::factor(Quantity::Time, unit).is_some_and(fits))
}

/// f of `q(t + T) − q(t) = f ∫ q̇ dt` over all joints, in samples where there are no stamps; none without velocities, and
/// where they do not follow the positions.
fn slope(recording: &Recording) -> Option<f64> {
    let velocity = recording.velocity.as_ref()?;
    let step = recording.time.as_deref().and_then(step);
    let window = step.map_or(10, |step| (WINDOW_S / step).round().max(1.0) as usize);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (q, v) in recording.position.iter().zip(velocity) {
        for start in (0..q.len().saturating_sub(window)).step_by(window) {
            let end = start + window;
            let steps = (start..end).map(|k| {
                let step = recording.time.as_ref().map_or(1.0, |t| t[k + 1] - t[k]);
                0.5 * step * (v[k] + v[k + 1])
            });
            let (x, y) = (steps.sum::<f64>(), q[end] - q[start]);
            xx += x * x;
            xy += x * y;
            yy += y * y;
        }
    }
    let correlation = xy / (xx * yy).sqrt();
    (correlation > SAME).then(|| xy / xx)
}

/// Units that explain why positions are not the integrals of velocities.
fn unit_of_motion(channels: &mut Channels, factor: f64) -> Option<String> {
    let is = |expected: f64| (factor / expected - 1.0).abs() < TOLERANCE;
    let of = |quantity, unit| units::factor(quantity, unit).unwrap_or(1.0);
    let velocity = channels.velocity.as_mut()?;
    let position = &mut channels.position;
    let turned = ["deg", "rev"]
        .into_iter()
        .find(|unit| is(1.0 / of(Quantity::Position, unit)));
    if let (Some(unit), None) = (turned, position.unit) {
        position.unit = Some(unit);
        return Some(format!(
            "positions ({}) are in {unit}: velocities are their derivatives then",
            position.written()
        ));
    }
    let rates = ["deg/s", "rpm", "rev/s", "mm/s"].into_iter();
    let turning = rates
        .into_iter()
        .find(|unit| is(of(Quantity::Velocity, unit)));
    if let (Some(unit), None) = (turning, velocity.unit) {
        velocity.unit = Some(unit);
        return Some(format!(
            "velocities ({}) are in {unit}: they are the derivatives of positions then",
            velocity.written()
        ));
    }
    None
}
