//! Rival models, and how far apart a motion puts them (T-optimality, Atkinson and Fedorov 1975):
//!
//! ```text
//! D(a, b) = min over β of |f_a − f_b − W_b β|² + βᵀ M_b β        in units of the noise
//! ```
//!
//! is what is left of the prediction f_a when model b is fitted to it: W_b are the derivatives of f_b with
//! respect to what b estimates, M_b what is known of it beforehand. A pair counts with the mean of both
//! directions, and of all pairs the nearest decides. At the best β the derivative of D with respect to the
//! motion is that of the residual alone, which central differences of the predictions give.

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::chain::effect::Memory;
use crate::chain::evaluate::{Evaluator, Segment};
use crate::chain::model::Model;
use crate::design::criterion::eigenvalues::{LogMean, log_mean};
use crate::design::trajectory::fourier_series::Basis;
use crate::design::trajectory::motion::{Joints, MOTION, Motion, of_motors};
use crate::robot::batch::Trajectory;

/// The word of problem files.
pub const ID: &str = "discriminate";

/// What the reported value is.
pub const MEANING: &str = "minus the least distance between the predictions of two rivals after each was fitted to \
                           the other, in standard deviations of the noise over one period";

/// Exponent of the mean of distances that stands for the least.
const NEAREST: f64 = -8.0;

/// Half of a difference: rad or m, and seconds.
const STEP: f64 = 1e-6;

/// Share of a column's information that is added to it, so that what a motion does not show can be solved for.
const RIDGE: f64 = 1e-12;

/// Share of the predictions below which a distance is rounding.
const ROUNDING: f64 = 1e-12;

/// One model with its values and what would be estimated of it.
#[derive(Debug, Clone)]
pub struct Rival {
    /// As the problem file has it.
    pub name: String,
    /// The robot with the effects that this rival states.
    pub model: Model,
    /// All its parameters, in SI units.
    pub values: DVector<f64>,
    /// Parameters that a fit of it estimates, without the dependent ones.
    pub unknowns: Vec<usize>,
    /// Information about them that is there beforehand.
    pub prior: DMatrix<f64>,
}

/// Models of one robot, and how it is recorded.
#[derive(Debug)]
pub struct Rivals<'m> {
    /// Two at least.
    pub models: Vec<Rival>,
    /// Runs, each without (false) or with the load.
    pub loads: &'m [bool],
    /// Standard deviation of each channel.
    pub noise: &'m [f64],
}

/// What is minimised, with its gradient with respect to the coefficients.
#[derive(Debug, Clone)]
pub struct GradedDistance {
    /// Minus a mean of log D that lies near the least.
    pub value: f64,
    /// By the coefficients.
    pub gradient: DVector<f64>,
}

/// Prediction and derivatives in units of the noise, sample after sample, in each all channels.
struct Prediction {
    values: DVector<f64>,
    columns: DMatrix<f64>,
}

/// One model fitted to what another predicts.
struct Fitted {
    truth: usize,
    model: usize,
    change: DVector<f64>,
    residual: DVector<f64>,
    distance: f64,
}

/// A pair with both directions and what the two predictions measure.
struct Pair {
    fits: [Fitted; 2],
    distance: f64,
}

impl Rivals<'_> {
    /// −√D of the nearest pair; infinite where two rivals predict the same.
    pub fn value(&self, motion: &Motion, basis: &Basis) -> f64 {
        if motion.is_open {
            return f64::INFINITY;
        }
        let Some(pairs) = self.pairs(motion, basis) else {
            return f64::INFINITY;
        };
        let least = pairs
            .iter()
            .map(|p| p.distance)
            .fold(f64::INFINITY, f64::min);
        -least.sqrt()
    }

    /// What is minimised: minus a mean of log D that lies near the least.
    pub fn minimised(&self, motion: &Motion, basis: &Basis) -> Option<f64> {
        Some(-nearest(&self.pairs(motion, basis)?).value)
    }

    /// The same with its gradient.
    pub fn graded(
        &self,
        joints: &Joints,
        basis: &Basis,
        x: &DVector<f64>,
    ) -> Option<GradedDistance> {
        let motion = Motion::of(joints, basis, x);
        let pairs = self.pairs(&motion, basis)?;
        let nearest = nearest(&pairs);
        let weights: Vec<f64> = nearest.slopes.iter().map(|d| -d).collect();
        let along = |motion: &Motion| self.residuals(motion, basis, &pairs, &weights);
        // Joints without a motor move with more than one of the others.
        let stand_alone =
            joints.loops.is_none() && self.models.iter().all(|r| r.model.memory() == Memory::None);
        let gradient = if stand_alone {
            of_states(&motion, joints, basis, along)
        } else {
            let total = |x: &DVector<f64>| along(&Motion::of(joints, basis, x)).iter().sum::<f64>();
            of_coefficients(x, total)
        };
        Some(GradedDistance {
            value: -nearest.value,
            gradient,
        })
    }

    /// All pairs; `None` where two models predict the same.
    fn pairs(&self, motion: &Motion, basis: &Basis) -> Option<Vec<Pair>> {
        let all: Vec<Prediction> = self
            .models
            .iter()
            .map(|rival| self.predict(rival, motion, basis))
            .collect();
        let mut pairs = Vec::new();
        for a in 0..all.len() {
            for b in 0..a {
                let fits = [self.fitted(&all, a, b)?, self.fitted(&all, b, a)?];
                let distance = 0.5 * (fits[0].distance + fits[1].distance);
                let size = all[a].values.norm_squared() + all[b].values.norm_squared();
                if distance.partial_cmp(&(ROUNDING * size)) != Some(std::cmp::Ordering::Greater) {
                    return None;
                }
                pairs.push(Pair { fits, distance });
            }
        }
        Some(pairs)
    }

    /// A model fitted to the prediction of another, which is taken for the truth.
    fn fitted(&self, all: &[Prediction], truth: usize, model: usize) -> Option<Fitted> {
        let difference = &all[truth].values - &all[model].values;
        let (w, prior) = (&all[model].columns, &self.models[model].prior);
        let mut normal = w.tr_mul(w) + prior;
        let size = normal
            .diagonal()
            .map(|d| if d > 0.0 { d.sqrt() } else { 1.0 });
        for i in 0..size.len() {
            for j in 0..size.len() {
                normal[(i, j)] /= size[i] * size[j];
            }
            normal[(i, i)] += RIDGE + f64::from(u8::from(normal[(i, i)] == 0.0));
        }
        let right = w.tr_mul(&difference).component_div(&size);
        let change = Cholesky::new(normal)?.solve(&right).component_div(&size);
        let residual = difference - w * &change;
        let distance = residual.norm_squared() + change.dot(&(prior * &change));
        Some(Fitted {
            truth,
            model,
            change,
            residual,
            distance,
        })
    }

    /// Σ weight · 2 rᵀ (f_a − f_b − W_b β) of every sample, r and β of the pairs kept.
    fn residuals(
        &self,
        motion: &Motion,
        basis: &Basis,
        pairs: &[Pair],
        weights: &[f64],
    ) -> Vec<f64> {
        let all: Vec<Prediction> = self
            .models
            .iter()
            .map(|rival| self.predict(rival, motion, basis))
            .collect();
        let rows = all[0].values.len() / motion.len();
        let mut sums = vec![0.0; motion.len()];
        for (pair, weight) in pairs.iter().zip(weights) {
            for fit in &pair.fits {
                let own = &all[fit.model];
                let moved = &all[fit.truth].values - &own.values - &own.columns * &fit.change;
                // Half from the mean of both directions, two from the square.
                for (row, product) in moved.component_mul(&fit.residual).iter().enumerate() {
                    sums[row / rows] += weight * product;
                }
            }
        }
        sums
    }

    /// What a model predicts for a motion of the joints.
    fn predict(&self, rival: &Rival, motion: &Motion, basis: &Basis) -> Prediction {
        let model = &rival.model;
        let coupling = (!model.is_uncoupled())
            .then(|| model.coupling(&rival.values).try_inverse())
            .flatten();
        let motors = of_motors(motion, coupling.as_ref(), model.offset());
        let channels: Vec<usize> = (0..model.channels().len())
            .filter(|&c| model.channels()[c].active)
            .collect();
        let rows = channels.len() * self.loads.len();
        let time: Vec<f64> = (0..basis.samples)
            .map(|k| k as f64 * basis.step())
            .collect();
        let mut values = DVector::zeros(rows * motion.len());
        let mut columns = DMatrix::zeros(rows * motion.len(), rival.unknowns.len());
        for first in (0..motion.len()).step_by(basis.samples) {
            let part = cut(&motors, first..first + basis.samples);
            let [q, dq, ddq] = &part.values;
            for (l, &loaded) in self.loads.iter().enumerate() {
                let segment = Segment {
                    motors: Trajectory { q, dq, ddq },
                    time: &time,
                    temperature: &[],
                    cyclic: true,
                    forces: &[],
                    commands: None,
                    bodies: None,
                    loaded,
                };
                let unknowns = &rival.unknowns;
                let mut evaluator = Evaluator::along(model, &rival.values, unknowns, basis.samples);
                let block = evaluator.evaluate_whole(segment);
                for (c, &channel) in channels.iter().enumerate() {
                    let weight = self.noise[channel].recip();
                    let row = |k: usize| (first + k) * rows + l * channels.len() + c;
                    for (k, value) in block.value(channel).iter().enumerate() {
                        values[row(k)] = weight * value;
                    }
                    for column in 0..unknowns.len() {
                        let series = block.derivative(channel, column).unwrap_or(&[]);
                        for (k, value) in series.iter().enumerate() {
                            columns[(row(k), column)] = weight * value;
                        }
                    }
                }
            }
        }
        Prediction { values, columns }
    }
}

/// A mean of log D near the least, and its derivatives with respect to the distances D.
fn nearest(pairs: &[Pair]) -> LogMean {
    let distances = DVector::from_iterator(pairs.len(), pairs.iter().map(|p| p.distance));
    log_mean(&distances, NEAREST)
}

fn cut(motion: &Motion, range: std::ops::Range<usize>) -> Motion {
    Motion::of_values(std::array::from_fn(|order| {
        let joints = motion.values[order].iter();
        joints
            .map(|series| series[range.clone()].to_vec())
            .collect()
    }))
}

/// Gradient where a sample's signal follows from its state: every joint is moved at all samples at once.
fn of_states(
    motion: &Motion,
    joints: &Joints,
    basis: &Basis,
    along: impl Fn(&Motion) -> Vec<f64>,
) -> DVector<f64> {
    let mut slopes = motion.clone();
    slopes.clear();
    let mut moved = motion.clone();
    for order in 0..MOTION {
        for &j in &joints.moving {
            let from = &motion.values[order][j];
            moved.values[order][j] = from.iter().map(|x| x + STEP).collect();
            let after = along(&moved);
            moved.values[order][j] = from.iter().map(|x| x - STEP).collect();
            let before = along(&moved);
            moved.values[order][j].clone_from(from);
            let pairs = after.iter().zip(&before);
            let difference = pairs.map(|(a, b)| (a - b) / (2.0 * STEP));
            slopes.values[order][j] = difference.collect();
        }
    }
    let mut gradient = DVector::zeros(joints.coefficients());
    slopes.pull(joints, basis, &mut gradient);
    gradient
}

/// Gradient where the past matters: coefficient by coefficient.
fn of_coefficients(x: &DVector<f64>, total: impl Fn(&DVector<f64>) -> f64) -> DVector<f64> {
    let mut moved = x.clone();
    DVector::from_fn(x.len(), |k, _| {
        let mut at = |by: f64| {
            moved[k] = x[k] + by;
            total(&moved)
        };
        let difference = (at(STEP) - at(-STEP)) / (2.0 * STEP);
        moved[k] = x[k];
        difference
    })
}
