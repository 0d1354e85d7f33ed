//! The motion of a design: which joints move, and positions, velocities and accelerations over all trajectories, sample after
//! sample.

use nalgebra::{DMatrix, DVector};

use crate::design::trajectory::fourier_series::{Basis, Series};
use crate::mechanism::loops::Mechanism;
use crate::robot::batch::Trajectory;
use crate::setup::limits::JointLimits;

/// Derivatives of position that the dynamics need.
pub const MOTION: usize = 3;

/// The joints and their coefficients: x holds trajectory after trajectory, in each moving joint after
/// moving joint, of each q0, a, b.
#[derive(Debug, Clone)]
pub struct Joints {
    /// The series of every joint that moves.
    pub series: Series,
    /// Joints of the robot.
    pub count: usize,
    /// Those that move, in the order of the tree.
    pub moving: Vec<usize>,
    /// Harmonics of each moving joint, at most those of the series; what is beyond is zero.
    pub harmonics: Vec<usize>,
    /// Positions of those that stand still; of no use for the others.
    pub standing: Vec<f64>,
    /// Trajectories designed together.
    pub trajectories: usize,
    /// The loops that the joints close; joints without a motor are none of those that move.
    pub loops: Option<Mechanism>,
}

impl Joints {
    /// Number of coefficients of all trajectories.
    pub fn coefficients(&self) -> usize {
        self.trajectories * self.of_trajectory()
    }

    /// Number of coefficients of one trajectory.
    pub fn of_trajectory(&self) -> usize {
        self.moving.len() * self.series.width()
    }

    /// First coefficient of the m-th moving joint in a trajectory.
    pub fn first(&self, trajectory: usize, m: usize) -> usize {
        trajectory * self.of_trajectory() + m * self.series.width()
    }

    /// Coefficients of the m-th moving joint in a trajectory.
    pub fn coefficients_of<'a>(
        &self,
        x: &'a DVector<f64>,
        trajectory: usize,
        m: usize,
    ) -> &'a [f64] {
        let first = self.first(trajectory, m);
        &x.as_slice()[first..first + self.series.width()]
    }

    /// Moves the joints without a motor with the others, trajectory by trajectory; a motion along which the loops do not
    /// close is open.
    pub fn close(&self, motion: &mut Motion) {
        let Some(mechanism) = &self.loops else {
            return;
        };
        let samples = motion.len() / self.trajectories;
        motion.carried.clear();
        motion.is_open = (0..self.trajectories).any(|trajectory| {
            let own = trajectory * samples..(trajectory + 1) * samples;
            let values = motion.values.each_mut().map(Vec::as_mut_slice);
            let maps = mechanism.complete_motion(values, own);
            maps.map(|maps| motion.carried.extend(maps)).is_err()
        });
    }

    /// Limits of the joints, without any of those that loops move.
    pub fn of_motors(&self, limits: &[JointLimits]) -> Vec<JointLimits> {
        let mut own = limits.to_vec();
        for &joint in self.loops.iter().flat_map(|m| m.passive()) {
            own[joint] = JointLimits::NONE;
        }
        own
    }

    /// The same joints in one trajectory.
    pub fn single(&self) -> Self {
        Self {
            trajectories: 1,
            ..self.clone()
        }
    }
}

/// A motion `[order][joint][sample]`, the trajectories one after the other.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Positions, velocities and accelerations, rad (m), 1/s and 1/s² of these.
    pub values: [Vec<Vec<f64>>; MOTION],
    /// P of a closed motion at every sample (joints without a motor x motors), which carries torques to the motors.
    pub carried: Vec<DMatrix<f64>>,
    /// The loops of the robot do not close somewhere along it.
    pub is_open: bool,
}

impl Motion {
    /// Room for a motion at the instants of a basis; joints that stand still do so already.
    pub fn new(joints: &Joints, samples: usize) -> Self {
        let length = joints.trajectories * samples;
        let mut values = std::array::from_fn(|_| vec![vec![0.0; length]; joints.count]);
        for j in (0..joints.count).filter(|j| !joints.moving.contains(j)) {
            values[0][j].fill(joints.standing[j]);
        }
        Self::of_values(values)
    }

    /// A motion that is sampled already, its loops not closed yet where there are any.
    pub fn of_values(values: [Vec<Vec<f64>>; MOTION]) -> Self {
        Self {
            values,
            carried: Vec::new(),
            is_open: false,
        }
    }

    /// A motion of coefficients x.
    pub fn of(joints: &Joints, basis: &Basis, x: &DVector<f64>) -> Self {
        let mut motion = Self::new(joints, basis.samples);
        motion.set(joints, basis, x);
        motion
    }

    /// Fills in the motion of coefficients x, over samples of a basis; joints that stand keep their positions.
    pub fn set(&mut self, joints: &Joints, basis: &Basis, x: &DVector<f64>) {
        let width = joints.series.width();
        for trajectory in 0..joints.trajectories {
            let range = trajectory * basis.samples..(trajectory + 1) * basis.samples;
            for (m, &j) in joints.moving.iter().enumerate() {
                let first = joints.first(trajectory, m);
                let own = &x.as_slice()[first..first + width];
                for order in 0..MOTION {
                    basis.evaluate(order, own, &mut self.values[order][j][range.clone()]);
                }
            }
        }
        joints.close(self);
    }

    /// Adds the gradient with respect to the coefficients of a function whose slopes along the motion are
    /// these.
    pub fn pull(&self, joints: &Joints, basis: &Basis, gradient: &mut DVector<f64>) {
        let width = joints.series.width();
        for trajectory in 0..joints.trajectories {
            let range = trajectory * basis.samples..(trajectory + 1) * basis.samples;
            for (m, &j) in joints.moving.iter().enumerate() {
                let first = joints.first(trajectory, m);
                let own = &mut gradient.as_mut_slice()[first..first + width];
                for order in 0..MOTION {
                    basis.pull(order, &self.values[order][j][range.clone()], own);
                }
            }
        }
    }

    /// Sets every value to zero.
    pub fn clear(&mut self) {
        for series in self.values.iter_mut().flatten() {
            series.fill(0.0);
        }
    }

    /// The motion as the recursions over the robot take it.
    pub fn trajectory(&self) -> Trajectory<'_> {
        let [q, dq, ddq] = &self.values;
        Trajectory { q, dq, ddq }
    }

    /// Samples of all trajectories together.
    pub fn len(&self) -> usize {
        self.values[0].first().map_or(0, Vec::len)
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Motion of the motors at joint scale, `m = V⁻¹ (q − offset)`; without V⁻¹ every motor has its joint.
pub fn of_motors(
    motion: &Motion,
    to_motors: Option<&DMatrix<f64>>,
    offset: &DVector<f64>,
) -> Motion {
    let n = offset.len();
    let shift = |order: usize, i: usize| if order == 0 { offset[i] } else { 0.0 };
    let values = std::array::from_fn(|order| {
        let shifted = |i: usize| -> Vec<f64> {
            let by = shift(order, i);
            motion.values[order][i].iter().map(|x| x - by).collect()
        };
        let joints: Vec<Vec<f64>> = (0..n).map(shifted).collect();
        let Some(inverse) = to_motors else {
            return joints;
        };
        let mixed = |m: usize| -> Vec<f64> {
            let mut out = vec![0.0; motion.len()];
            for (i, series) in joints.iter().enumerate() {
                let factor = inverse[(m, i)];
                out.iter_mut()
                    .zip(series)
                    .for_each(|(o, x)| *o += factor * x);
            }
            out
        };
        (0..n).map(mixed).collect()
    });
    Motion::of_values(values)
}
