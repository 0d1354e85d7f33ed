//! What has to hold of a robot that is accepted: parents before children, unit axes, finite numbers, dynamics that can be
//! evaluated.

use exid::robot::error::RobotError;
use exid::robot::newton_euler::NewtonEuler;
use exid::robot::regressor::Rows;
use exid::robot::sample_regressor::SampleRegressor;
use exid::robot::tree::Tree;

/// Joints up to which dynamics are evaluated: memory and time of the regressor grow with the square.
const MOST_JOINTS: usize = 12;

/// A robot that was accepted can be worked with.
pub fn is_sound(read: Result<Tree, RobotError>) {
    let tree = match read {
        Ok(tree) => tree,
        Err(fault) => return crate::describes_itself(&fault),
    };
    assert!(!tree.is_empty());
    for (k, joint) in tree.joints().iter().enumerate() {
        assert!(
            joint.parent.is_none_or(|parent| parent < k),
            "parents first"
        );
        assert!((joint.axis.norm() - 1.0).abs() <= 1e-12, "unit axis");
        assert_eq!(tree.joint_index(&joint.name), Some(k), "names are unique");
        assert!(joint.inertia.0.iter().all(|p| p.is_finite()));
        assert_eq!(tree.frame(&joint.link).map(|f| f.0), Some(Some(k)));
        let limits = joint.limits;
        for limit in [limits.lower, limits.upper, limits.velocity, limits.effort] {
            assert!(limit.is_none_or(f64::is_finite));
        }
    }
    let n = tree.len();
    if n <= MOST_JOINTS {
        let state = vec![0.5; n];
        let mut torque = vec![0.0; n];
        let slices = [&state[..]; 3];
        NewtonEuler::new(&tree).torque(&tree, &tree.parameters(), slices, &mut torque);
        let mut y = nalgebra::DMatrix::zeros(Rows::Both.count(n), 10 * n);
        SampleRegressor::new(&tree, Rows::Both).fill(&tree, slices, &mut y);
    }
}
