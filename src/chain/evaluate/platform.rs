//! What a force platform reads beside the bodies: moments of spinning rotors, and its tare.

use crate::chain::evaluate::Evaluator;
use crate::chain::model::Signal;
use crate::robot::batch::Trajectory;
use std::ops::Range;

impl Evaluator<'_> {
    /// Row of the first component of the base wrench, if it is measured.
    pub(super) fn wrench_row(&self) -> Option<usize> {
        match self.model.signal() {
            Signal::BaseWrench => Some(0),
            Signal::Both => Some(self.model.joints().len()),
            _ => None,
        }
    }

    /// Moments of the spinning rotors on the base.
    pub(super) fn spin_rotors(&mut self, motors: Trajectory<'_>, range: Range<usize>) {
        let platform = self.model.platform();
        if let (Some(row), false) = (self.wrench_row(), platform.rotors.is_empty()) {
            let [q, dq, ddq] = &self.joint_motion;
            let joints = Trajectory { q, dq, ddq };
            let wrench = &mut self.rigid.values[row..];
            let tree = self.model.tree();
            platform.add_rotors(tree, motors, joints, range, wrench);
        }
    }

    /// What the platform reads without the robot.
    pub(super) fn add_tare(&mut self) {
        let (Some(row), Some(first)) = (self.wrench_row(), self.model.tare()) else {
            return;
        };
        for component in 0..6 {
            let value = self.values[first + component];
            for x in &mut self.block.values[row + component] {
                *x += value;
            }
            if let Some(column) = self.column[first + component] {
                self.block.series(row + component, column).fill(1.0);
            }
        }
    }
}
