//! Paths of all joints over time: Fourier series, cubic splines through points, and motions that do not repeat.
//!
//! ```text
//! x_j(t) = c_j + Σ_h a_jh cos(hωt) + b_jh sin(hωt),   ω = 2π / period
//! ```

use crate::chain::model::Model;
use crate::mechanism::error::OpenLoop;
use crate::simulate::aperiodic::Aperiodic;
pub use crate::simulate::motion::{Instants, Motion};
use crate::stats::range::within;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// A motion of the motors with that of the joints without a motor where the model's loops are closed.
///
/// # Errors
/// A sample at which the loops stay open.
pub(super) fn with_loops(model: &Model, mut motion: Motion) -> Result<Motion, OpenLoop> {
    if let Some(mechanism) = model.mechanism() {
        let samples = motion[0].first().map_or(0, Vec::len);
        mechanism.complete_motion(motion.each_mut().map(Vec::as_mut_slice), 0..samples)?;
    }
    Ok(motion)
}

/// A path of all joints.
#[derive(Debug, Clone)]
pub enum Path {
    /// It repeats.
    Fourier(Fourier),
    /// Through given points.
    Spline(Spline),
    /// Tones, moves or sweeps, which do not repeat.
    Aperiodic(Aperiodic),
}

impl Path {
    /// The motion at even instants.
    pub fn sample(&self, instants: Instants) -> Motion {
        match self {
            Self::Fourier(series) => series.sample(instants),
            Self::Spline(spline) => spline.sample(instants),
            Self::Aperiodic(free) => free.sample(instants),
        }
    }

    /// Length of one pass, s.
    pub fn duration(&self) -> f64 {
        match self {
            Self::Fourier(series) => series.period,
            Self::Spline(spline) => spline.time.last().copied().unwrap_or(0.0),
            Self::Aperiodic(free) => free.duration,
        }
    }

    /// Whether it goes on after a period as before.
    pub fn repeats(&self) -> bool {
        matches!(self, Self::Fourier(_))
    }

    /// The path `A x + b`.
    pub fn mapped(&self, matrix: &DMatrix<f64>, shift: &DVector<f64>) -> Self {
        match self {
            Self::Fourier(series) => Self::Fourier(series.mapped(matrix, shift)),
            Self::Spline(spline) => {
                let zeros = DVector::zeros(shift.len());
                Self::Spline(Spline {
                    time: spline.time.clone(),
                    position: mixed(&spline.position, matrix, shift),
                    curvature: mixed(&spline.curvature, matrix, &zeros),
                })
            }
            Self::Aperiodic(free) => Self::Aperiodic(free.mapped(matrix, shift)),
        }
    }
}

fn mixed(series: &[Vec<f64>], matrix: &DMatrix<f64>, shift: &DVector<f64>) -> Vec<Vec<f64>> {
    let samples = series.first().map_or(0, Vec::len);
    (0..matrix.nrows())
        .map(|i| {
            (0..samples)
                .map(|k| (0..series.len()).fold(shift[i], |s, j| s + matrix[(i, j)] * series[j][k]))
                .collect()
        })
        .collect()
}

/// A finite Fourier series per joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Fourier {
    /// s.
    pub period: f64,
    /// Mean position of each joint, rad (m).
    pub centre: Vec<f64>,
    /// `[joint][h − 1]`, of as many harmonics for each joint.
    pub cosine: Vec<Vec<f64>>,
    /// The same of sines.
    pub sine: Vec<Vec<f64>>,
}

impl Fourier {
    /// Harmonics of each joint.
    pub fn harmonics(&self) -> usize {
        self.cosine.first().map_or(0, Vec::len)
    }

    fn sample(&self, instants: Instants) -> Motion {
        let Instants { start, rate, count } = instants;
        let n = self.centre.len();
        let omega = TAU / self.period;
        let mut motion: Motion = std::array::from_fn(|_| vec![Vec::with_capacity(count); n]);
        let mut waves = vec![(0.0, 0.0); self.harmonics()];
        for k in 0..count {
            // The phase within the period: sine and cosine of large arguments lose digits.
            let time = start + k as f64 / rate;
            let phase = TAU * (time / self.period).fract();
            for (h, wave) in waves.iter_mut().enumerate() {
                *wave = ((h + 1) as f64 * phase).sin_cos();
            }
            for j in 0..n {
                let mut at = [self.centre[j], 0.0, 0.0];
                for (h, (sine, cosine)) in waves.iter().enumerate() {
                    let (a, b) = (self.cosine[j][h], self.sine[j][h]);
                    let w = (h + 1) as f64 * omega;
                    let value = a * cosine + b * sine;
                    at[0] += value;
                    at[1] += w * (b * cosine - a * sine);
                    at[2] -= w * w * value;
                }
                for (series, value) in motion.iter_mut().zip(at) {
                    series[j].push(value);
                }
            }
        }
        motion
    }

    fn mapped(&self, matrix: &DMatrix<f64>, shift: &DVector<f64>) -> Self {
        let zeros = DVector::zeros(shift.len());
        let centre: Vec<Vec<f64>> = self.centre.iter().map(|c| vec![*c]).collect();
        Self {
            period: self.period,
            centre: mixed(&centre, matrix, shift).concat(),
            cosine: mixed(&self.cosine, matrix, &zeros),
            sine: mixed(&self.sine, matrix, &zeros),
        }
    }

    /// The same series about the same centre, amplitudes times `factor`.
    pub fn scaled(&self, factor: f64) -> Self {
        let times = |rows: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let row = |row: &Vec<f64>| row.iter().map(|x| factor * x).collect();
            rows.iter().map(row).collect()
        };
        Self {
            period: self.period,
            centre: self.centre.clone(),
            cosine: times(&self.cosine),
            sine: times(&self.sine),
        }
    }
}

/// A natural cubic spline per joint: curvature zero at both ends (de Boor 1978, chapter IV).
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    /// Knots, s, increasing from 0.
    time: Vec<f64>,
    position: Vec<Vec<f64>>,
    /// Second derivative at the knots.
    curvature: Vec<Vec<f64>>,
}

impl Spline {
    /// The spline through points at increasing times, at least two.
    pub fn through(time: &[f64], position: Vec<Vec<f64>>) -> Self {
        let start = time.first().copied().unwrap_or(0.0);
        let time: Vec<f64> = time.iter().map(|t| t - start).collect();
        let curvature = position.iter().map(|x| curvature(&time, x)).collect();
        Self {
            time,
            position,
            curvature,
        }
    }

    fn sample(&self, instants: Instants) -> Motion {
        let Instants { start, rate, count } = instants;
        let n = self.position.len();
        let mut motion: Motion = std::array::from_fn(|_| vec![Vec::with_capacity(count); n]);
        let last = self.time.len() - 2;
        for k in 0..count {
            let end = self.time[last + 1];
            let t = within(start + k as f64 / rate, [0.0, end]);
            let i = self.time.partition_point(|x| *x <= t).max(1).min(last + 1) - 1;
            let step = self.time[i + 1] - self.time[i];
            let (a, b) = ((self.time[i + 1] - t) / step, (t - self.time[i]) / step);
            let joints = self.position.iter().zip(&self.curvature);
            for (j, (x, c)) in joints.enumerate() {
                let bend = ((a.powi(3) - a) * c[i] + (b.powi(3) - b) * c[i + 1]) * step * step;
                let slope = (3.0 * b * b - 1.0) * c[i + 1] - (3.0 * a * a - 1.0) * c[i];
                motion[0][j].push(a * x[i] + b * x[i + 1] + bend / 6.0);
                motion[1][j].push((x[i + 1] - x[i]) / step + slope * step / 6.0);
                motion[2][j].push(a * c[i] + b * c[i + 1]);
            }
        }
        motion
    }
}

/// Second derivatives of the natural spline: a tridiagonal system, solved by elimination.
fn curvature(time: &[f64], x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let (mut factor, mut right) = (vec![0.0; n], vec![0.0; n]);
    for i in 1..n - 1 {
        let (before, after) = (time[i] - time[i - 1], time[i + 1] - time[i]);
        let jump = (x[i + 1] - x[i]) / after - (x[i] - x[i - 1]) / before;
        let pivot = 2.0 * (before + after) - before * factor[i - 1];
        factor[i] = after / pivot;
        right[i] = (6.0 * jump - before * right[i - 1]) / pivot;
    }
    for i in (1..n - 1).rev() {
        right[i] -= factor[i] * right[i + 1];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Fourier {
        Fourier {
            period: 4.0,
            centre: vec![0.5, -1.0],
            cosine: vec![vec![0.3, -0.1], vec![0.0, 0.2]],
            sine: vec![vec![0.0, 0.4], vec![0.7, -0.3]],
        }
    }

    #[test]
    fn invariant_derivatives_match_differences_of_the_series() {
        let h = 1e-4;
        let motion = example().sample(Instants {
            start: 0.3,
            rate: 1.0 / h,
            count: 5,
        });
        let [position, velocity, acceleration] = &motion;
        for ((q, dq), ddq) in position.iter().zip(velocity).zip(acceleration) {
            // Third and fourth derivatives stay below 10 and 100 here.
            assert!((dq[2] - (q[3] - q[1]) / (2.0 * h)).abs() < 10.0 * h * h);
            let second = (q[3] - 2.0 * q[2] + q[1]) / (h * h);
            assert!((ddq[2] - second).abs() < 100.0 * h * h + 1e-15 * 4.0 / (h * h));
        }
    }

    #[test]
    fn invariant_a_mapped_path_is_the_map_of_the_path() {
        let matrix = DMatrix::from_row_slice(2, 2, &[1.0, 0.2, -0.5, 2.0]);
        let shift = DVector::from_vec(vec![0.1, 0.2]);
        let series = Path::Fourier(example());
        let time: Vec<f64> = (0..30).map(|k| 0.1 * k as f64).collect();
        let points = series.sample(Instants {
            start: 0.0,
            rate: 10.0,
            count: 30,
        })[0]
            .clone();
        let spline = Path::Spline(Spline::through(&time, points));
        for path in [series, spline] {
            let (from, to) = (
                path.sample(Instants {
                    start: 0.05,
                    rate: 9.0,
                    count: 20,
                }),
                path.mapped(&matrix, &shift).sample(Instants {
                    start: 0.05,
                    rate: 9.0,
                    count: 20,
                }),
            );
            for order in 0..3 {
                let constant = if order == 0 { 0.1 } else { 0.0 };
                let expected = constant + from[order][0][7] + 0.2 * from[order][1][7];
                assert!((to[order][0][7] - expected).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn matches_closed_form_of_a_line_through_uneven_knots() {
        let time = [0.0, 0.4, 1.0, 1.5];
        let line = time.iter().map(|t| 2.0 - 3.0 * t).collect();
        let motion = Spline::through(&time, vec![line]).sample(Instants {
            start: 0.0,
            rate: 10.0,
            count: 16,
        });
        let [q, dq, _] = motion;
        for k in 0..16 {
            assert!((q[0][k] - (2.0 - 0.3 * k as f64)).abs() < 1e-14);
            assert!((dq[0][k] + 3.0).abs() < 1e-13);
        }
    }

    #[test]
    fn a_spline_converges_to_the_sine_it_passes_through() {
        let step = 0.01;
        let time: Vec<f64> = (0..=628).map(|k| step * k as f64).collect();
        let sine = time.iter().map(|t| t.sin()).collect();
        let motion = Spline::through(&time, vec![sine]).sample(Instants {
            start: 2.0,
            rate: 333.0,
            count: 400,
        });
        let [q, _, ddq] = motion;
        for k in 0..400 {
            let t = 2.0 + k as f64 / 333.0;
            // Error 5/384 h⁴ of the position and about h²/12 + of the second derivative, away from ends.
            assert!((q[0][k] - t.sin()).abs() < 2e-2 * step.powi(4) + 1e-14);
            assert!((ddq[0][k] + t.sin()).abs() < 0.3 * step * step);
        }
    }
}
