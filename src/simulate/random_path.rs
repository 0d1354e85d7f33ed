//! Random excitation: a Fourier series of the joints, scaled to 80 % of the tightest limit, or a
//! [motion that does not repeat](crate::simulate::random_aperiodic).
//!
//! Coefficients of harmonic h are normal with standard deviation 1/h, so that all harmonics move the
//! joint at the same speed. Each joint moves about the middle of its range; all amplitudes then shrink
//! together until the torques keep to their limits.

use crate::chain::effect::Memory;
use crate::chain::evaluate::{BLOCK, Evaluator, Segment};
use crate::chain::model::Model;
use crate::fault::Place;
use crate::robot::batch::Trajectory;
use crate::setup::limits::JointLimits;
use crate::simulate::error::{SimulateError, SimulateErrorKind};
use crate::simulate::path::{self, Fourier, Instants, Motion, Path};
use crate::simulate::random_aperiodic::{self, LOOK_RATE};
use crate::simulate::random_frame::Frame;

pub use crate::simulate::random_frame::{SHARE, Shape};
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// Instants per cycle of the highest harmonic at which limits are looked at: the peak of a sine between
/// two of them is less than 1 % higher.
const PER_CYCLE: usize = 24;

/// One step of shrinking all amplitudes, and the most steps: down to 1 %, which is standstill.
const SHRINK: f64 = 0.9;
const MOST_STEPS: usize = 44;

impl Frame<'_> {
    /// A feasible path of the motors at joint scale.
    ///
    /// # Errors
    /// The middle position alone takes more than 80 % of a torque limit.
    pub fn draw(
        &self,
        rng: &mut ChaCha8Rng,
        loaded: bool,
        place: &Place,
    ) -> Result<Path, SimulateError> {
        let joints = match self.shape {
            Shape::Fourier => Path::Fourier(self.joints(rng)),
            Shape::Aperiodic { kind, duration } => {
                Path::Aperiodic(random_aperiodic::draw(self, kind, duration, rng))
            }
        };
        let mut factor = 1.0;
        let mut worst = (0, 0.0);
        for _ in 0..MOST_STEPS {
            let path = to_motors(&scaled(&joints, factor), self.nominal);
            worst = self.worst_torque(&path, loaded);
            if worst.1 <= SHARE {
                return Ok(path);
            }
            factor *= SHRINK;
        }
        let (joint, ratio) = worst;
        if ratio.is_infinite() && self.plant.mechanism().is_some() {
            let kind = SimulateErrorKind::OpenLoops {
                time: 0.0,
                reason: "the loops do not close, however small it is".to_string(),
            };
            return Err(SimulateError::new(place, kind));
        }
        let limit = self.limits[joint].torque.unwrap_or(f64::INFINITY);
        Err(SimulateError::new(
            place,
            SimulateErrorKind::Unreachable {
                joint: self.plant.joints()[joint].name.clone(),
                found: ratio * limit,
                limit,
            },
        ))
    }

    fn instants(&self) -> usize {
        PER_CYCLE * self.harmonics
    }

    /// A series of the joints within the limits of their motion.
    fn joints(&self, rng: &mut ChaCha8Rng) -> Fourier {
        let n = self.limits.len();
        let mut normal = || -> f64 { StandardNormal.sample(rng) };
        let mut draw =
            || -> Vec<f64> { (1..=self.harmonics).map(|h| normal() / h as f64).collect() };
        let mut series = Fourier {
            period: self.period,
            centre: vec![0.0; n],
            cosine: (0..n).map(|_| draw()).collect(),
            sine: (0..n).map(|_| draw()).collect(),
        };
        for j in 0..n {
            let amplitude = if self.plant.joints()[j].locked {
                series.centre[j] = self.plant.offset()[j];
                0.0
            } else {
                series.centre[j] = 0.5 * (self.limits[j].lower + self.limits[j].upper);
                self.amplitude(&series.cosine[j], &series.sine[j], &self.limits[j])
            };
            let scaled = series.cosine[j].iter_mut().chain(&mut series.sine[j]);
            scaled.for_each(|x| *x *= amplitude);
        }
        series
    }

    /// The factor with which one joint's series reaches 80 % of its tightest limit.
    fn amplitude(&self, cosine: &[f64], sine: &[f64], limits: &JointLimits) -> f64 {
        let count = self.instants();
        let mut peaks = [0.0_f64; 4];
        for k in 0..count {
            let phase = TAU * k as f64 / count as f64;
            let mut at = [0.0; 4];
            for (h, (a, b)) in cosine.iter().zip(sine).enumerate() {
                let (s, c) = ((h + 1) as f64 * phase).sin_cos();
                let w = (h + 1) as f64 * TAU / self.period;
                at[0] += a * c + b * s;
                at[1] += w * (b * c - a * s);
                at[2] += w * w * (a * c + b * s);
                at[3] += w.powi(3) * (b * c - a * s);
            }
            for (peak, value) in peaks.iter_mut().zip(at) {
                *peak = peak.max(value.abs());
            }
        }
        let half_range = 0.5 * (limits.upper - limits.lower);
        let bounds = [
            half_range,
            limits.velocity,
            limits.acceleration,
            limits.jerk.unwrap_or(f64::INFINITY),
        ];
        let ratios = bounds.iter().zip(peaks).map(|(bound, peak)| bound / peak);
        SHARE * ratios.fold(f64::INFINITY, f64::min)
    }

    /// The joint with the largest torque over its limit, and that ratio; infinite where loops of the robot stay open.
    fn worst_torque(&self, path: &Path, loaded: bool) -> (usize, f64) {
        let limited = |j: &usize| self.limits[*j].torque.is_some();
        let joints: Vec<usize> = (0..self.limits.len()).filter(limited).collect();
        let mut worst = (0, 0.0);
        if joints.is_empty() && self.plant.mechanism().is_none() {
            return worst;
        }
        let (count, rate) = match self.shape {
            Shape::Fourier => (self.instants(), self.instants() as f64 / self.period),
            Shape::Aperiodic { duration, .. } => {
                ((duration * LOOK_RATE).ceil() as usize, LOOK_RATE)
            }
        };
        let Ok(motion) = path::with_loops(
            self.plant,
            path.sample(Instants {
                start: 0.0,
                rate,
                count,
            }),
        ) else {
            return (0, f64::INFINITY);
        };
        let conditions = RecordingConditions {
            rate,
            cyclic: path.repeats(),
            loaded,
        };
        for (j, torque) in joints
            .iter()
            .zip(torques(self.plant, &motion, conditions, &joints))
        {
            let limit = self.limits[*j].torque.unwrap_or(f64::INFINITY);
            let peak = torque.iter().fold(0.0_f64, |peak, x| peak.max(x.abs()));
            if peak / limit > worst.1 {
                worst = (*j, peak / limit);
            }
        }
        worst
    }
}

/// A random path of the joints with its amplitudes times `factor`.
fn scaled(path: &Path, factor: f64) -> Path {
    match path {
        Path::Fourier(series) => Path::Fourier(series.scaled(factor)),
        Path::Aperiodic(free) => Path::Aperiodic(free.scaled(factor)),
        Path::Spline(spline) => Path::Spline(spline.clone()),
    }
}

/// What a recording is made under, besides the motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct RecordingConditions {
    pub rate: f64,
    /// The last sample is followed by the first.
    pub cyclic: bool,
    pub loaded: bool,
}

/// Signals of some channels of a model along a motion of the motors.
pub(super) fn torques(
    model: &Model,
    motion: &Motion,
    conditions: RecordingConditions,
    channels: &[usize],
) -> Vec<Vec<f64>> {
    let [q, dq, ddq] = motion;
    let motors = Trajectory { q, dq, ddq };
    let count = motors.len();
    let time: Vec<f64> = (0..count).map(|k| k as f64 / conditions.rate).collect();
    let segment = Segment {
        motors,
        forces: &[],
        commands: None,
        bodies: None,
        time: &time,
        temperature: &[],
        cyclic: conditions.cyclic,
        loaded: conditions.loaded,
    };
    if model.memory() == Memory::WholeMotion {
        let mut evaluator = Evaluator::along(model, &model.values(), &[], count);
        let whole = evaluator.evaluate_whole(segment);
        return channels.iter().map(|&c| whole.value(c).to_vec()).collect();
    }
    let mut evaluator = Evaluator::new(model, &model.values(), &[]);
    let mut out = vec![Vec::with_capacity(count); channels.len()];
    for start in (0..count).step_by(BLOCK) {
        let block = evaluator.evaluate(segment, start..(start + BLOCK).min(count));
        for (series, &channel) in out.iter_mut().zip(channels) {
            series.extend_from_slice(block.value(channel));
        }
    }
    out
}

/// `m = V⁻¹ (q − offset)`.
pub(super) fn to_motors(joints: &Path, model: &Model) -> Path {
    let (inverse, shift) = from_joints(model);
    joints.mapped(&inverse, &shift)
}

/// A and b of `m = A q + b`.
pub(super) fn from_joints(model: &Model) -> (DMatrix<f64>, DVector<f64>) {
    let n = model.tree().len();
    let coupling = model.coupling(&model.values());
    // The setup refuses a coupling that cannot be inverted.
    let mut inverse = coupling.try_inverse().unwrap_or(DMatrix::identity(n, n));
    // Motors of joints that are held or follow others stand at zero.
    for (j, _) in model.joints().iter().enumerate().filter(|(_, j)| j.locked) {
        inverse.row_mut(j).fill(0.0);
    }
    let shift = -(&inverse * model.offset());
    (inverse, shift)
}
