//! Errors of an estimated motion: of one row, across joints.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Errors of one row of a motion: what noise leaves in it, and what smoothing takes from it.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionError {
    /// Of positions, rad or m.
    pub position: JointErrors,
    /// Of velocities, rad/s or m/s.
    pub velocity: JointErrors,
    /// Of accelerations, rad/s² or m/s².
    pub acceleration: JointErrors,
}

impl MotionError {
    /// Errors that know nothing of those of other joints: standard deviations of each joint's position, velocity and acceleration.
    pub fn independent(deviations: &[[f64; 3]]) -> Self {
        let of_order = |order: usize| {
            let variances = deviations.iter().map(|d| d[order] * d[order]);
            let variances = DVector::from_iterator(deviations.len(), variances);
            JointErrors(DMatrix::from_diagonal(&variances))
        };
        Self {
            position: of_order(0),
            velocity: of_order(1),
            acceleration: of_order(2),
        }
    }

    /// The errors of every order of derivative.
    pub fn orders(&self) -> [&JointErrors; 3] {
        [&self.position, &self.velocity, &self.acceleration]
    }

    /// The errors of every order of derivative, to be changed.
    pub fn orders_mut(&mut self) -> [&mut JointErrors; 3] {
        [
            &mut self.position,
            &mut self.velocity,
            &mut self.acceleration,
        ]
    }
}

/// Normal errors of one quantity of all joints: their covariance, joints x joints.
#[derive(Debug, Clone, PartialEq)]
pub struct JointErrors(DMatrix<f64>);

impl JointErrors {
    /// Errors of this covariance, which is symmetric and positive semidefinite.
    pub fn of_covariance(covariance: DMatrix<f64>) -> Self {
        Self(covariance)
    }

    /// Standard deviation of one joint.
    pub fn deviation(&self, joint: usize) -> f64 {
        self.0[(joint, joint)].sqrt()
    }

    /// R of the covariance R Rᵀ: the errors are R z, z of independent standard normal numbers, and its columns their independent parts.
    pub fn root(&self) -> DMatrix<f64> {
        let mut eigen = SymmetricEigen::new(self.0.clone());
        let deviations = eigen.eigenvalues.map(|variance| variance.max(0.0).sqrt());
        for (mut direction, deviation) in eigen.eigenvectors.column_iter_mut().zip(&deviations) {
            direction *= *deviation;
        }
        eigen.eigenvectors
    }

    /// The errors where one joint is measured in another unit.
    pub fn scale(&mut self, joint: usize, factor: f64) {
        self.0.row_mut(joint).scale_mut(factor);
        self.0.column_mut(joint).scale_mut(factor);
    }

    /// The errors among so many joints, in which these are the ones at the places of a list; the others have none.
    pub fn spread(&mut self, places: &[usize], joints: usize) {
        let mut all = DMatrix::zeros(joints, joints);
        for (a, &row) in places.iter().enumerate() {
            for (b, &column) in places.iter().enumerate() {
                all[(row, column)] = self.0[(a, b)];
            }
        }
        self.0 = all;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn correlated() -> JointErrors {
        JointErrors::of_covariance(DMatrix::from_row_slice(2, 2, &[4.0, 1.5, 1.5, 1.0]))
    }

    #[test]
    fn parts_add_up_to_the_covariance() {
        let of_parts = |errors: &JointErrors| errors.root() * errors.root().transpose();
        let errors = correlated();
        assert!((of_parts(&errors) - &errors.0).norm() < 1e-14);
        let errors = MotionError::independent(&[[1.0, 2.0, 4.0], [0.0; 3], [3.0; 3]]).velocity;
        assert!((of_parts(&errors) - &errors.0).norm() < 1e-14);
        assert_eq!([0, 1, 2].map(|j| errors.deviation(j)), [2.0, 0.0, 3.0]);
    }

    #[test]
    fn a_joint_in_another_unit_keeps_its_correlation() {
        let mut errors = correlated();
        errors.scale(0, -0.5);
        let expected = DMatrix::from_row_slice(2, 2, &[1.0, -0.75, -0.75, 1.0]);
        assert_eq!(errors.0, expected);
    }

    #[test]
    fn joints_that_stand_still_have_no_error() {
        let mut errors = correlated();
        errors.spread(&[2, 0], 3);
        let expected = [1.0, 0.0, 1.5, 0.0, 0.0, 0.0, 1.5, 0.0, 4.0];
        assert_eq!(errors.0, DMatrix::from_row_slice(3, 3, &expected));
    }
}
