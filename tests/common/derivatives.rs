//! Columns of derivatives against central differences of the prediction.

use exid::chain::evaluate::{Evaluator, Segment};
use exid::chain::model::Model;
use exid::robot::batch::Trajectory;
use nalgebra::DVector;

/// A motion `amplitude · sin(rate t)` of every joint, with rates in rad/s.
pub struct Sines<'a> {
    pub amplitude: f64,
    pub rates: &'a [f64],
    pub samples: usize,
    pub rate_hz: f64,
}

impl Sines<'_> {
    fn series(&self, time: &[f64], order: i32) -> Vec<Vec<f64>> {
        let of_joint = |rate: &f64| {
            let at = |t: &f64| {
                let wave = match order {
                    0 => (rate * t).sin(),
                    1 => rate * (rate * t).cos(),
                    _ => -rate * rate * (rate * t).sin(),
                };
                self.amplitude * wave
            };
            time.iter().map(at).collect()
        };
        self.rates.iter().map(of_joint).collect()
    }
}

/// Columns of derivatives that are held against differences.
pub struct Columns<'a> {
    pub model: &'a Model,
    pub values: &'a DVector<f64>,
    /// Positions of their parameters.
    pub parameters: &'a [usize],
    /// Share of a value over which differences are taken.
    pub step: f64,
    /// Where the value is smaller, the share is of this.
    pub least: f64,
    /// Share of the largest difference by which they may differ.
    pub tolerance: f64,
}

impl Columns<'_> {
    pub fn assert_derivatives_along(&self, motion: &Sines<'_>) {
        let (model, values) = (self.model, self.values);
        let samples = motion.samples;
        let time: Vec<f64> = (0..samples).map(|k| k as f64 / motion.rate_hz).collect();
        let [q, dq, ddq] = [0, 1, 2].map(|order| motion.series(&time, order));
        let motors = Trajectory {
            q: &q,
            dq: &dq,
            ddq: &ddq,
        };
        let segment = Segment {
            time: &time,
            ..Segment::states(motors, false)
        };
        let channels = motion.rates.len();
        let predicted = |values: &_| -> Vec<Vec<f64>> {
            let mut evaluator = Evaluator::along(model, values, &[], samples);
            let block = evaluator.evaluate_whole(segment);
            (0..channels).map(|c| block.value(c).to_vec()).collect()
        };
        let mut evaluator = Evaluator::along(model, values, self.parameters, samples);
        let block = evaluator.evaluate_whole(segment);
        for (k, &p) in self.parameters.iter().enumerate() {
            let step = self.step * values[p].abs().max(self.least);
            let [mut less, mut more] = [values.clone(), values.clone()];
            (less[p], more[p]) = (values[p] - step, values[p] + step);
            let (less, more) = (predicted(&less), predicted(&more));
            for c in 0..channels {
                let pairs = less[c].iter().zip(&more[c]);
                let differences: Vec<f64> = pairs.map(|(a, b)| (b - a) / (2.0 * step)).collect();
                let size = differences
                    .iter()
                    .fold(0.0, |most: f64, d| most.max(d.abs()));
                let zeros = vec![0.0; samples];
                let own = block.derivative(c, k).unwrap_or(&zeros);
                let errors = own.iter().zip(&differences).map(|(a, b)| (a - b).abs());
                let worst = errors.fold(0.0, f64::max);
                let name = &model.parameters()[p].name;
                assert!(
                    worst <= self.tolerance * size.max(1e-6),
                    "{name} on channel {c}: {worst} of {size}"
                );
            }
        }
    }
}
