//! Limits of mechanisms with closed loops: their distance from singularities, and the ranges of joints without a motor.

use crate::design::trajectory::motion::Motion;
use crate::mechanism::loops::{Mechanism, WELL_HELD};

/// Rows g ≥ 0 that keep a mechanism in one assembly and within the ranges of its joints without a motor.
#[derive(Debug, Clone)]
pub struct LoopRows {
    mechanism: Mechanism,
    /// Joints without a motor whose range the robot file states, and the range, rad or m.
    ranges: Vec<(usize, [f64; 2])>,
    limits: Vec<LoopLimit>,
}

impl LoopRows {
    /// The rows of a mechanism at each sample: its distance from a singularity, then one per joint without a motor whose
    /// range is stated.
    pub fn new(mechanism: &Mechanism) -> Self {
        let joints = mechanism.tree().joints();
        let range = |&joint: &usize| {
            let limits = joints[joint].limits;
            let stated = [limits.lower?, limits.upper?];
            (stated[0] < stated[1]).then_some((joint, stated))
        };
        let ranges: Vec<_> = mechanism.passive().iter().filter_map(range).collect();
        let of_range = ranges.iter().map(|(joint, [low, high])| LoopLimit {
            name: format!("range of {}", joints[*joint].name),
            unit: joints[*joint].kind.position_unit(),
            limit: 0.5 * (high - low),
        });
        let regular = LoopLimit {
            name: "distance from a singularity".to_string(),
            unit: "1",
            limit: WELL_HELD,
        };
        Self {
            limits: std::iter::once(regular).chain(of_range).collect(),
            ranges,
            mechanism: mechanism.clone(),
        }
    }

    /// What each series of rows is about.
    pub fn limits(&self) -> &[LoopLimit] {
        &self.limits
    }

    /// Rows along a closed motion, `[series][sample]`.
    pub fn values(&self, motion: &Motion) -> Vec<Vec<f64>> {
        let position = &motion.values[0];
        let hold = |sample: usize| {
            let q: Vec<f64> = position.iter().map(|s| s[sample]).collect();
            self.mechanism.determination(&q) - WELL_HELD
        };
        let of_range = self.ranges.iter().map(|(joint, [low, high])| {
            let inside = |q: &f64| 0.5 * (high - low) - (q - 0.5 * (low + high)).abs();
            position[*joint].iter().map(inside).collect()
        });
        std::iter::once((0..motion.len()).map(hold).collect())
            .chain(of_range)
            .collect()
    }
}

/// What keeps a mechanism in one assembly, or a joint without a motor within its range.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopLimit {
    /// What the row keeps, in words.
    pub name: String,
    /// Unit of the limit.
    pub unit: &'static str,
    /// What rows are measured against.
    pub limit: f64,
}
