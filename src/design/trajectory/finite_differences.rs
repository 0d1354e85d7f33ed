//! Derivatives along motions of mechanisms with closed loops, by central differences of the motion of the motors:
//!
//! ```text
//! q̇_p = P q̇_a,   τ_a = τ_a + Pᵀ τ_p
//! ```
//!
//! Everything at a sample depends on the motors' position, velocity and acceleration at that sample alone. So one shift of
//! one of these at all samples, with the loops closed anew, gives the slopes at all samples at once: six evaluations for
//! each motor that moves, whatever the number of coefficients.

use nalgebra::{DMatrix, DVector};

use crate::design::trajectory::fourier_series::Basis;
use crate::design::trajectory::motion::{Joints, MOTION, Motion};
use crate::setup::limits::JointLimits;

/// Half of a difference of position, velocity and acceleration as a share of the joint's limit. Rounding of the
/// closed loops has to be far below the shift of the position; signs of the velocity turn over within a hundredth of its limit, which its shift
/// has to be far below; torques are linear in the acceleration.
const STEP: [f64; MOTION] = [1e-4, 1e-5, 1e-3];

/// What has a value at every sample.
pub trait AlongMotion {
    /// Series over the samples of a closed motion, always as many.
    fn series(&mut self, motion: &Motion) -> Vec<Vec<f64>>;
}

/// One derivative of the motion of a motor, by its place among those that move.
#[derive(Debug, Clone, Copy)]
pub struct Shifted {
    /// 0 of the position, 1 of the velocity, 2 of the acceleration.
    pub order: usize,
    /// Place of the motor among those that move.
    pub motor: usize,
}

/// Slopes of series, `[series][sample]`, by every derivative of the motion of every motor that moves.
pub fn slopes(
    of: &mut impl AlongMotion,
    motion: &Motion,
    joints: &Joints,
    limits: &[JointLimits],
    mut visit: impl FnMut(Shifted, &[Vec<f64>]),
) {
    let mut shifted = motion.clone();
    for (motor, &joint) in joints.moving.iter().enumerate() {
        let scales = [
            limits[joint].half_range(),
            limits[joint].velocity,
            limits[joint].acceleration,
        ];
        for order in 0..MOTION {
            let h = STEP[order] * scales[order];
            let mut at = |change: f64| {
                let pairs = shifted.values[order][joint].iter_mut();
                pairs
                    .zip(&motion.values[order][joint])
                    .for_each(|(to, x)| *to = x + change);
                joints.close(&mut shifted);
                of.series(&shifted)
            };
            let (mut after, before) = (at(h), at(-h));
            for (after, before) in after.iter_mut().zip(&before) {
                for (a, b) in after.iter_mut().zip(before) {
                    *a = (*a - b) / (2.0 * h);
                }
            }
            visit(Shifted { order, motor }, &after);
            shifted.values[order][joint].clone_from(&motion.values[order][joint]);
        }
    }
}

/// Adds the derivatives by the coefficients of a motor of rows whose slopes by one derivative of its motion are given, all
/// samples of one series after the other.
pub fn to_coefficients(
    jacobian: &mut DMatrix<f64>,
    joints: &Joints,
    basis: &Basis,
    Shifted { order, motor }: Shifted,
    slopes: &[Vec<f64>],
) {
    for (block, series) in slopes.iter().enumerate() {
        for (s, slope) in series.iter().enumerate() {
            let (trajectory, k) = (s / basis.samples, s % basis.samples);
            let first = joints.first(trajectory, motor);
            for c in 0..joints.series.width() {
                jacobian[(block * series.len() + s, first + c)] +=
                    slope * basis.function(order, c)[k];
            }
        }
    }
}

/// The series of rows that lie one after the other.
pub fn blocks(rows: &DVector<f64>, samples: usize) -> Vec<Vec<f64>> {
    rows.as_slice()
        .chunks(samples)
        .map(<[f64]>::to_vec)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::base_parameters::BaseParameters;
    use crate::chain::evaluate::{Evaluator, Segment};
    use crate::chain::model::Model;
    use crate::design::criterion::CRITERIA;
    use crate::design::criterion::parameters_of_interest::{Scale, Target};
    use crate::design::information::columns::Columns;
    use crate::design::problem::{Excitation, Experiment, Plan};
    use crate::design::tests::{assert_slopes_of_constraints, assert_slopes_of_cost, some_motion};
    use crate::design::trajectory::fourier_series::Series;
    use crate::mechanism::loops::Mechanism;
    use crate::problem_file::ProblemFile;
    use crate::setup;
    use crate::setup::limits::JointLimits;
    use crate::setup::model_spec::ModelSpec;
    use std::path::Path;

    const NOISE: [f64; 4] = [0.3, 0.2, 1.0, 1.0];
    /// rad/s; wide against the steps of differences.
    const WIDTH: f64 = 0.4;

    /// A linkage of two motors and two joints without.
    struct Linkage {
        model: Model,
        columns: Columns,
        values: DVector<f64>,
        loops: Mechanism,
    }

    impl Linkage {
        fn new() -> Self {
            let root = Path::new(env!("CARGO_MANIFEST_DIR"));
            let ids = crate::chain::effect::ids();
            let problem =
                ProblemFile::read(&root.join("problems/parallelogram/problem.toml"), &[], &ids);
            let problem = problem.unwrap();
            let robot = setup::robot::open(&problem).unwrap();
            let model = ModelSpec::without_prior(&problem, &robot)
                .unwrap()
                .build()
                .unwrap()
                .model;
            let mut values = model.values();
            for (p, parameter) in model.parameters().iter().enumerate() {
                if parameter.name.ends_with(".w") {
                    values[p] = WIDTH;
                } else if parameter.name.contains("friction") {
                    values[p] = parameter.scale;
                }
            }
            let none = DMatrix::zeros(0, model.parameters().len());
            let kept = BaseParameters::structural(&model, &[false], &none).kept();
            // Two inertias, two couplings and four weights; two frictions for each motor.
            assert_eq!(kept.len(), 8 + 4);
            Self {
                columns: Columns::new(&model, kept, &[false], &NOISE),
                loops: robot.mechanism.unwrap(),
                values,
                model,
            }
        }

        fn experiment(&self) -> Experiment<'_> {
            let count = self.model.joints().len();
            let limits = JointLimits {
                lower: -0.6,
                upper: 0.6,
                velocity: 2.0,
                acceleration: 8.0,
                jerk: None,
                torque: Some(400.0),
            };
            let plan = Plan {
                model: &self.model,
                columns: &self.columns,
                values: &self.values,
                loads: &[false],
                joints: Joints {
                    series: Series {
                        harmonics: 3,
                        period: 5.0,
                    },
                    count,
                    moving: self.loops.actuated().to_vec(),
                    harmonics: vec![3; self.loops.actuated().len()],
                    standing: vec![0.0; count],
                    trajectories: 2,
                    loops: Some(self.loops.clone()),
                },
                samples: 25,
                bounds: vec![limits; count],
                rules: Vec::new(),
                target: Target {
                    criterion: CRITERIA[0],
                    wanted: None,
                    prior: DMatrix::identity(self.columns.len(), self.columns.len()) * 1e-3,
                    scale: Scale::Own,
                },
                rivals: None,
            };
            plan.experiment()
        }
    }

    /// Coefficients of a motion about home within some tenths of a radian.
    fn near_home(experiment: &Experiment<'_>, linkage: &Linkage, seed: u64) -> DVector<f64> {
        let joints = &experiment.joints;
        let mut x = 0.5 * some_motion(joints.coefficients(), seed);
        for trajectory in 0..joints.trajectories {
            for (m, &j) in joints.moving.iter().enumerate() {
                x[joints.first(trajectory, m)] = linkage.loops.home()[j];
            }
        }
        x
    }

    #[test]
    fn invariant_information_of_a_mechanism_is_that_of_the_chain() {
        let linkage = Linkage::new();
        let experiment = linkage.experiment();
        let x = near_home(&experiment, &linkage, 8);
        let motion = Motion::of(&experiment.joints, &experiment.basis, &x);
        assert!(!motion.is_open);
        let found = experiment.information(&x);
        let parameters = &linkage.columns.parameters;
        let [q, dq, ddq] = &motion.values;
        let motors = crate::robot::batch::Trajectory { q, dq, ddq };
        let mut evaluator =
            Evaluator::along(&linkage.model, &linkage.values, parameters, motion.len());
        let block = evaluator.evaluate_whole(Segment::states(motors, false));
        let mut expected = DMatrix::zeros(parameters.len(), parameters.len());
        for channel in &linkage.columns.channels {
            let w = DMatrix::from_fn(motion.len(), parameters.len(), |s, k| {
                let column = block.derivative(channel.joint, k);
                column.map_or(0.0, |d| d[s] * channel.weight)
            });
            expected += w.tr_mul(&w);
        }
        let size = expected.diagonal().map(f64::sqrt);
        for i in 0..size.len() {
            for j in 0..size.len() {
                let error = (found[(i, j)] - expected[(i, j)]).abs();
                // Sums of some hundred products, each rounded.
                assert!(error <= 1e-11 * size[i] * size[j], "{i} {j}: {error}");
            }
        }
    }

    #[test]
    fn invariant_slopes_of_a_mechanism_agree_with_differences_of_coefficients() {
        let linkage = Linkage::new();
        let experiment = linkage.experiment();
        let x = near_home(&experiment, &linkage, 5);
        let problem = Excitation::new(&experiment, CRITERIA[0].exponents()[0], 0.97);
        assert_slopes_of_cost(&problem, &x, "mechanism");
        assert_slopes_of_constraints(&problem, &x);
    }
}
