//! A trajectory from a file: columns `t` and `q_<joint>` of the joints that move, one period.
//!
//! A motion whose end leads back to its start becomes the Fourier series through its points, of as few
//! harmonics as pass by all of them within a millionth of the range; any other motion becomes a spline,
//! run through once. Velocities and accelerations follow from the positions.

use crate::chain::model::Model;
use crate::fault::Place;
use crate::problem_file::{FilePath, Located, RecordingsTable};
use crate::recording::error::{MissingColumn, RecordingError, RecordingErrorKind};
use crate::recording::format::{columns_at, read_at};
use crate::recording::missing::require_complete;
use crate::recording::reading::Reading;
use crate::simulate::error::{SimulateError, SimulateErrorKind};
use crate::simulate::path::{Fourier, Path, Spline};
use crate::stats::deviation::range;
use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

/// Root mean square of what harmonics are left out, over the range of the joint: above the rounding of
/// files with seven digits, and far below what a joint follows.
const LEFT_OUT: f64 = 1e-6;

/// Rounding of positions, rad or m: a joint at rest needs no harmonics.
const ROUNDING: f64 = 1e-12;

/// Steps may differ from their mean by this share: the last digit of time stamps in milliseconds at 1 kHz.
const EVEN: f64 = 0.05;

/// The end leads back to the start where the step between them is at most this many largest steps.
const CLOSED_STEPS: f64 = 2.0;

/// Share of a step within which the file's length agrees with the stated period.
const PERIOD_STEPS: f64 = 0.5;

/// Reads a path of the joints in the order of the tree; locked joints stand at their offset.
///
/// # Errors
/// Those of the file; a missing column; uneven time; a length that contradicts `recordings.period`.
pub(super) fn read(
    recordings: Option<&RecordingsTable>,
    path: &FilePath,
    model: &Model,
) -> Result<Path, SimulateError> {
    let file = &path.resolved;
    let joints = model.joints();
    let mut wanted = vec!["t".to_string()];
    let moving = joints.iter().filter(|j| !j.locked);
    wanted.extend(moving.map(|j| format!("q_{}", j.name)));
    let reading = recordings.map_or_else(Reading::default, |r| r.reading.clone());
    let present = columns_at(file, &reading)?;
    if let Some(name) = wanted.iter().find(|name| !present.contains(name)) {
        return Err(missing(path, name, present.clone()).into());
    }
    let mut table = read_at(file, &wanted, &reading)?;
    require_complete(file, &table)?;
    let time = table.take("t").unwrap_or_default();
    if let Some(k) = (1..time.len()).find(|&k| time[k] <= time[k - 1]) {
        let kind = RecordingErrorKind::TimeNotIncreasing {
            before: time[k - 1],
            found: time[k],
        };
        let place = Place::file(file).line(table.line(k)).key("t");
        return Err(RecordingError { place, kind }.into());
    }
    let position: Vec<Vec<f64>> = joints
        .iter()
        .enumerate()
        .map(|(j, joint)| {
            let recorded = table.take(&format!("q_{}", joint.name));
            recorded.unwrap_or_else(|| vec![model.offset()[j]; time.len()])
        })
        .collect();
    let period = recordings.and_then(|r| r.period.clone());
    to_path(&time, position, &Place::file(file).key("t"), period)
}

fn missing(path: &FilePath, name: &str, present: Vec<String>) -> RecordingError {
    let kind = RecordingErrorKind::MissingColumn(Box::new(MissingColumn {
        purpose: "trajectory".to_string(),
        accepted: vec![name.to_string()],
        nearest: None,
        present,
    }));
    RecordingError {
        place: Place::file(&path.resolved).key(name),
        kind,
    }
}

fn to_path(
    time: &[f64],
    mut position: Vec<Vec<f64>>,
    place: &Place,
    stated: Option<Located<f64>>,
) -> Result<Path, SimulateError> {
    let rows = time.len();
    let step = (time[rows - 1] - time[0]) / (rows - 1) as f64;
    let stated = stated.map(|period| period.value);
    let is_closed = position.iter().all(|x| closes(x));
    if !is_closed && stated.is_none() {
        return Ok(Path::Spline(Spline::through(time, position)));
    }
    let uneven = time.windows(2).map(|pair| pair[1] - pair[0]);
    if let Some(found) = uneven.into_iter().find(|s| (s - step).abs() > EVEN * step) {
        let kind = SimulateErrorKind::UnevenTime {
            step: found,
            mean: step,
        };
        return Err(SimulateError::new(place, kind));
    }
    // A last row that is the first row again belongs to the next period.
    if stated.is_none() && position.iter().all(|x| comes_back(x)) {
        position.iter_mut().for_each(|x| x.truncate(rows - 1));
        let period = (rows - 1) as f64 * step;
        return Ok(Path::Fourier(series(&position, period)));
    }
    let period = rows as f64 * step;
    let agrees = |length: f64, stated: f64| (length - stated).abs() <= PERIOD_STEPS * step;
    match stated {
        None => Ok(Path::Fourier(series(&position, period))),
        Some(stated) if agrees(period, stated) => Ok(Path::Fourier(series(&position, stated))),
        Some(stated) if agrees(period - step, stated) => {
            position.iter_mut().for_each(|x| x.truncate(rows - 1));
            Ok(Path::Fourier(series(&position, stated)))
        }
        Some(recordings) => Err(SimulateError::new(
            place,
            SimulateErrorKind::PeriodConflict {
                file: period,
                recordings,
            },
        )),
    }
}

fn closes(x: &[f64]) -> bool {
    let largest = x.windows(2).fold(0.0_f64, |largest, pair| {
        largest.max((pair[1] - pair[0]).abs())
    });
    (x[0] - x[x.len() - 1]).abs() <= CLOSED_STEPS * largest
}

fn comes_back(x: &[f64]) -> bool {
    (x[0] - x[x.len() - 1]).abs() <= LEFT_OUT * range(x)
}

/// The series through even samples of one period.
fn series(position: &[Vec<f64>], period: f64) -> Fourier {
    let spectra: Vec<Vec<Complex<f64>>> = position.iter().map(|x| coefficients(x)).collect();
    let needed = position
        .iter()
        .zip(&spectra)
        .map(|(x, spectrum)| needed_harmonics(spectrum, LEFT_OUT * range(x) + ROUNDING))
        .max()
        .unwrap_or(1);
    // The harmonic at half the rate has no derivative.
    let most = (position[0].len() - 1) / 2;
    let kept = 1..=needed.max(1).min(most);
    let part = |of: fn(&Complex<f64>) -> f64| -> Vec<Vec<f64>> {
        let rows = spectra.iter();
        rows.map(|s| s[kept.clone()].iter().map(of).collect())
            .collect()
    };
    Fourier {
        period,
        centre: spectra.iter().map(|s| s[0].re).collect(),
        cosine: part(|c| 2.0 * c.re),
        sine: part(|c| -2.0 * c.im),
    }
}

/// The least number of harmonics that leaves out at most `tolerance` (root mean square).
fn needed_harmonics(spectrum: &[Complex<f64>], tolerance: f64) -> usize {
    let mut left_out = 0.0;
    for h in (1..spectrum.len()).rev() {
        left_out += 2.0 * spectrum[h].norm_sqr();
        if left_out > tolerance * tolerance {
            return h;
        }
    }
    1
}

fn coefficients(series: &[f64]) -> Vec<Complex<f64>> {
    let n = series.len();
    let plan = RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let mut input = series.to_vec();
    let mut output = plan.make_output_vec();
    // Both buffers come from the plan's own length, so the transform cannot refuse them.
    let _ = plan.process(&mut input, &mut output);
    output.iter_mut().for_each(|c| *c /= n as f64);
    output
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::path::Instants;

    fn place() -> Place {
        Place::file("made.csv")
    }

    fn stated(value: f64) -> Option<Located<f64>> {
        let place = place();
        Some(Located { value, place })
    }

    #[test]
    fn recovers_known_series_from_rounded_points_with_and_without_the_closing_one() {
        let truth = Path::Fourier(Fourier {
            period: 8.0,
            centre: vec![0.4],
            cosine: vec![vec![0.5, 0.0, -0.2]],
            sine: vec![vec![-0.3, 0.6, 0.1]],
        });
        for (rows, period) in [
            (400, None),
            (401, None),
            (400, stated(8.0)),
            (401, stated(8.0)),
        ] {
            let time: Vec<f64> = (0..rows).map(|k| 0.02 * k as f64).collect();
            let mut q = truth.sample(Instants {
                start: 0.0,
                rate: 50.0,
                count: rows,
            })[0]
                .clone();
            q[0].iter_mut().for_each(|x| *x = (*x * 1e7).round() / 1e7);
            let path = to_path(&time, q, &place(), period).unwrap();
            assert!((path.duration() - 8.0).abs() < 1e-12);
            let (a, b) = (
                truth.sample(Instants {
                    start: 0.0,
                    rate: 33.0,
                    count: 300,
                }),
                path.sample(Instants {
                    start: 0.0,
                    rate: 33.0,
                    count: 300,
                }),
            );
            let omega = std::f64::consts::TAU / 8.0;
            for k in 0..300 {
                // Rounding of 5e-8 in three harmonics, the third one twice differentiated.
                let bound = 3.0 * 1e-7 * (3.0 * omega).powi(2);
                assert!((a[2][0][k] - b[2][0][k]).abs() < bound);
            }
        }
    }

    #[test]
    fn an_open_motion_is_a_spline_and_contradicts_a_period_of_another_length() {
        let time: Vec<f64> = (0..100).map(|k| 0.01 * k as f64).collect();
        let ramp = vec![time.clone()];
        let path = to_path(&time, ramp.clone(), &place(), None).unwrap();
        assert!(!path.repeats());
        assert!((path.duration() - 0.99).abs() < 1e-12);
        assert!(to_path(&time, ramp, &place(), stated(2.0)).is_err());
    }
}
