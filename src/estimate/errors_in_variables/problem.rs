//! Errors in variables: maximum likelihood where motion and signal are both noisy.
//!
//! ```text
//! min over θ, δ   ½ Σ_k ‖W (ŝ(θ, m_k + Φ_k δ) − s_k)‖² + ½ ‖prior(θ)‖² + ½ Σ_i (δ_i / σ_i)²
//! ```
//!
//! Joint angles and signals are both corrupted by independent Gaussian noise (Swevers, Ganseman, Tükel, De
//! Schutter and Van Brussel 1997, section IV). The motion m is the Fourier series that differentiation found; δ
//! are corrections of its coefficients, σ their deviations by the scatter of the periods, and Φ the series'
//! terms with their derivatives. White noise of variance ν per complex coefficient leaves the constant with ν and
//! the amplitude of a cosine or sine with 2ν.

use crate::chain::dataset::Prepared;
use crate::chain::effect::Memory;
use crate::estimate::error::EstimateError;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::residual::noise::predict;
use crate::estimate::residual::rows::{tasks, visit};
use crate::linalg::triangular::Triangular;
use crate::problem::form::{Form, Objective, Structure, Variable};
use crate::problem::{Linearization, OutsideDomain, Problem, SquareRoot, Values};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Steps of central differences of the signal by position, speed and acceleration, rad, rad/s, rad/s² (m):
/// far below any transition of friction, far above rounding.
const STEPS: [f64; 3] = [1e-6, 1e-6, 1e-4];

/// A term of a joint's Fourier series in one recording.
#[derive(Debug, Clone, Copy)]
struct Wave {
    recording: usize,
    joint: usize,
    /// rad per row.
    pulsation: f64,
    /// rad/s.
    rate: f64,
    sine: bool,
    deviation: f64,
}

impl Wave {
    /// The term and its first two derivatives by time at a row.
    fn at(&self, row: usize) -> [f64; 3] {
        let (s, c) = (self.pulsation * row as f64).sin_cos();
        let w = self.rate;
        match self.sine {
            true => [s, w * c, -w * w * s],
            false => [c, -w * s, -w * w * c],
        }
    }
}

/// A fit with corrections of the motion among its unknowns, in units of their deviations, behind the
/// parameters.
#[derive(Debug)]
pub struct ErrorsInVariables<'a> {
    inner: &'a FitProblem<'a>,
    waves: Vec<Wave>,
    form: Form,
}

impl<'a> ErrorsInVariables<'a> {
    /// # Errors
    /// A recording that is no average over periods; a law with memory.
    pub fn new(inner: &'a FitProblem<'a>) -> Result<Self, EstimateError> {
        if inner.model.memory() == Memory::WholeMotion {
            return Err(EstimateError::MotionWithMemory);
        }
        let mut waves = Vec::new();
        for (index, recording) in inner.recordings.iter().enumerate() {
            let averaged = recording.experiment.periods.is_some();
            if !averaged || recording.experiment.parallel.is_some() {
                let recording = recording.name.clone();
                return Err(EstimateError::MotionWithoutPeriods { recording });
            }
            waves.extend(waves_of(inner, index));
        }
        let own = inner.form();
        let Objective::SumOfSquares { rows } = own.objective else {
            return Err(EstimateError::NothingUnknown);
        };
        let mut variables = own.variables.clone();
        variables.extend((0..waves.len()).map(|k| Variable::free(format!("motion{k}"), "")));
        let form = Form {
            variables,
            objective: Objective::SumOfSquares {
                rows: rows + waves.len(),
            },
            constraints: Vec::new(),
            structure: Structure::Smooth,
        };
        Ok(Self { inner, waves, form })
    }

    /// Number of parameters; corrections of the motion come behind them.
    pub fn parameters(&self) -> usize {
        self.form.variables.len() - self.waves.len()
    }

    /// Number of parameters and corrections.
    pub fn unknowns(&self) -> usize {
        self.form.variables.len()
    }

    /// The recordings with their motion corrected.
    pub fn corrected(&self, x: &DVector<f64>) -> Vec<Prepared> {
        let mut recordings: Vec<Prepared> =
            self.inner.recordings.iter().map(|r| (*r).clone()).collect();
        for (wave, scaled) in self.waves.iter().zip(x.iter().skip(self.parameters())) {
            let size = wave.deviation * scaled;
            let experiment = Arc::make_mut(&mut recordings[wave.recording].experiment);
            let motion = &mut experiment.motion;
            let orders = [
                &mut motion.position,
                &mut motion.velocity,
                &mut motion.acceleration,
            ];
            for (order, series) in orders.into_iter().enumerate() {
                for (row, value) in series[wave.joint].iter_mut().enumerate() {
                    *value += size * wave.at(row)[order];
                }
            }
        }
        recordings
    }

    /// Weighted rows `[J, residual]` of one recording, parameters first.
    fn rows(&self, index: usize, recording: &Prepared, values: &DVector<f64>) -> DMatrix<f64> {
        let (model, count) = (self.inner.model, self.parameters());
        let (channels, rows) = (model.channels().len(), recording.rows());
        let columns = self.form.variables.len() + 1;
        let mut plain = vec![DMatrix::zeros(rows, columns); channels];
        let positions = self.inner.unknowns.positions();
        for task in tasks(model, std::iter::once(recording)) {
            visit(model, values, &positions, &task, |block| {
                for (c, matrix) in plain.iter_mut().enumerate() {
                    let pairs = block.predicted(c).iter().zip(block.recorded(c));
                    for (row, (p, r)) in pairs.enumerate() {
                        matrix[(block.start() + row, columns - 1)] = p - r;
                    }
                    for k in 0..count {
                        let derivative = block.derivative(c, k).unwrap_or_default();
                        for (row, x) in derivative.iter().enumerate() {
                            matrix[(block.start() + row, k)] = *x;
                        }
                    }
                }
            });
        }
        let slopes = self.slopes(index, recording, values);
        for (k, wave) in self
            .waves
            .iter()
            .enumerate()
            .filter(|(_, w)| w.recording == index)
        {
            for row in 0..rows {
                let term = wave.at(row);
                for (c, matrix) in plain.iter_mut().enumerate() {
                    let by = |order: usize| {
                        slopes[wave.joint][order]
                            .as_ref()
                            .map_or(0.0, |s| s[c][row])
                    };
                    let change: f64 = (0..3).map(|order| by(order) * term[order]).sum();
                    matrix[(row, count + k)] = wave.deviation * change;
                }
            }
        }
        self.weighted(index, recording, &plain)
    }

    /// Central differences of the signals by the motion: `[joint][order][channel][row]`, none for joints
    /// whose motion is exact.
    fn slopes(
        &self,
        index: usize,
        recording: &Prepared,
        values: &DVector<f64>,
    ) -> Vec<[Option<Vec<Vec<f64>>>; 3]> {
        let joints = self.inner.model.joints().len();
        let noisy = |joint: usize| {
            self.waves
                .iter()
                .any(|w| (w.recording, w.joint) == (index, joint))
        };
        let of = |joint: usize, order: usize| {
            let shifted = |step: f64| {
                let mut moved = recording.clone();
                let motion = &mut Arc::make_mut(&mut moved.experiment).motion;
                let series = [
                    &mut motion.position,
                    &mut motion.velocity,
                    &mut motion.acceleration,
                ];
                let [q, dq, ddq] = series;
                let series = [q, dq, ddq].into_iter().nth(order);
                series
                    .into_iter()
                    .for_each(|s| s[joint].iter_mut().for_each(|x| *x += step));
                predict(self.inner.model, values, &moved)
            };
            let (above, below) = (shifted(STEPS[order]), shifted(-STEPS[order]));
            let difference = |(a, b): (Vec<f64>, Vec<f64>)| -> Vec<f64> {
                a.iter()
                    .zip(&b)
                    .map(|(a, b)| (a - b) / (2.0 * STEPS[order]))
                    .collect()
            };
            above.into_iter().zip(below).map(difference).collect()
        };
        (0..joints)
            .map(|joint| [0, 1, 2].map(|order| noisy(joint).then(|| of(joint, order))))
            .collect()
    }

    /// W times the rows of all active channels; rows that do not count are zero.
    fn weighted(&self, index: usize, recording: &Prepared, plain: &[DMatrix<f64>]) -> DMatrix<f64> {
        let weights = self.inner.weights().matrix();
        let active = |c: &usize| self.inner.model.channels()[*c].active;
        let active: Vec<usize> = (0..plain.len()).filter(active).collect();
        let (rows, columns) = plain[0].shape();
        let mut out = DMatrix::zeros(rows * active.len(), columns);
        for (place, &i) in active.iter().enumerate() {
            let mut target = out.view_mut((place * rows, 0), (rows, columns));
            for &j in active.iter().filter(|&&j| weights[(i, j)] != 0.0) {
                for row in 0..rows {
                    let counts = f64::from(u8::from(recording.counts(row)));
                    let factor = self
                        .inner
                        .factors
                        .as_ref()
                        .map_or(1.0, |f| f[index][j][row]);
                    let weight = weights[(i, j)] * factor * counts;
                    for column in 0..columns {
                        target[(row, column)] += weight * plain[j][(row, column)];
                    }
                }
            }
        }
        out
    }

    /// Triangular factor of all rows at x.
    fn factor(&self, x: &DVector<f64>) -> Triangular {
        let (count, columns) = (self.parameters(), self.form.variables.len() + 1);
        let values = self.inner.parameters(&x.rows(0, count).into_owned());
        let mut whole = Triangular::new(columns);
        for (index, recording) in self.corrected(x).iter().enumerate() {
            whole.absorb(self.rows(index, recording, &values).as_slice());
        }
        let prior = self.inner.prior;
        let mut rest = DMatrix::zeros(prior.len() + self.waves.len(), columns);
        for (k, &p) in self.inner.unknowns.positions().iter().enumerate() {
            rest.view_mut((0, k), (prior.len(), 1))
                .copy_from(&prior.rows().column(p));
        }
        rest.view_mut((0, columns - 1), (prior.len(), 1))
            .copy_from(&prior.residual(&values));
        for k in 0..self.waves.len() {
            rest[(prior.len() + k, count + k)] = 1.0;
            rest[(prior.len() + k, columns - 1)] = x[count + k];
        }
        whole.absorb(rest.as_slice());
        whole
    }

    /// What the noise of the motion adds to the covariance of the parameters at x, to first order.
    pub fn added_covariance(&self, x: &DVector<f64>) -> Option<DMatrix<f64>> {
        let (count, all) = (self.parameters(), self.form.variables.len());
        let factor = self.factor(x).matrix();
        let covariance = |order: usize| {
            let triangle = factor.view((0, 0), (order, order));
            let inverse = triangle.solve_upper_triangular(&DMatrix::identity(order, order))?;
            Some(
                (&inverse * inverse.transpose())
                    .view((0, 0), (count, count))
                    .into_owned(),
            )
        };
        Some(covariance(all)? - covariance(count)?)
    }
}

impl Problem for ErrorsInVariables<'_> {
    fn form(&self) -> &Form {
        &self.form
    }

    fn values(&self, x: &DVector<f64>) -> Result<Values, OutsideDomain> {
        let corrected = self.corrected(x);
        let recordings: Vec<&Prepared> = corrected.iter().collect();
        let (parameters, motion) = (self.parameters(), self.waves.len());
        let inner = self
            .inner
            .along(&recordings)
            .values(&x.rows(0, parameters).into_owned())?;
        Ok(Values {
            cost: inner.cost + 0.5 * x.rows(parameters, motion).norm_squared(),
            constraints: DVector::zeros(0),
        })
    }

    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, OutsideDomain> {
        let count = self.form.variables.len();
        let whole = self.factor(x).matrix();
        let matrix = whole.columns(0, count).into_owned();
        let residual = whole.column(count).into_owned();
        Ok(Linearization::of_squares(SquareRoot { matrix, residual }))
    }
}

/// The terms of the series of every joint that scatters.
fn waves_of(problem: &FitProblem<'_>, index: usize) -> Vec<Wave> {
    let recording = problem.recordings[index];
    let experiment = &recording.experiment;
    let (Some(error), Some(_)) = (&experiment.motion_error, &experiment.noise) else {
        return Vec::new();
    };
    let (rows, period) = (
        recording.rows() as f64,
        recording.rows() as f64 / experiment.rate_hz,
    );
    let mut waves = Vec::new();
    for (joint, bandwidth) in experiment.bandwidth.iter().enumerate() {
        let harmonics = bandwidth.harmonics.unwrap_or(0);
        let variance = error.position.deviation(joint).powi(2) / (2 * harmonics + 1) as f64;
        if variance == 0.0 || problem.model.joints()[joint].locked {
            continue;
        }
        for h in 0..=harmonics {
            let sides = if h == 0 { &[false][..] } else { &[false, true] };
            waves.extend(sides.iter().map(|&sine| Wave {
                recording: index,
                joint,
                pulsation: TAU * h as f64 / rows,
                rate: TAU * h as f64 / period,
                sine,
                deviation: if h == 0 { variance } else { 2.0 * variance }.sqrt(),
            }));
        }
    }
    waves
}
