//! Derivatives with respect to entries of V and to offsets of encoders, which move the joints.
//!
//! ```text
//! ∂τ_M/∂V_ij = Vᵀ (∂τ/∂q_i m_j + ∂τ/∂q̇_i ṁ_j + ∂τ/∂q̈_i m̈_j) + e_j τ_i
//! ∂τ_M/∂o_i = Vᵀ ∂τ/∂q_i
//! ```

use crate::chain::evaluate::{BLOCK, Evaluator, Segment};
use std::ops::Range;
use std::rc::Rc;

/// A column of a parameter that moves a joint: by the motion of a motor, or by a constant.
pub(super) struct MotionColumn {
    column: usize,
    joint: usize,
    motor: Option<usize>,
}

impl Evaluator<'_> {
    /// Columns of entries of V and of offsets of encoders.
    pub(super) fn motion_columns(&self) -> Vec<MotionColumn> {
        let entry = |(column, joint, motor)| MotionColumn {
            column,
            joint,
            motor: Some(motor),
        };
        let entries = self.coupling_entries().into_iter().map(entry);
        let joints = self.model.joints().iter().enumerate();
        let offsets = joints.filter_map(|(joint, of)| {
            Some(MotionColumn {
                column: self.column[of.encoder?]?,
                joint,
                motor: None,
            })
        });
        entries.chain(offsets).collect()
    }

    /// What the change of the joints' motion takes, of joint torques and base wrench.
    pub(super) fn add_motion_columns(&mut self, segment: Segment<'_>, range: Range<usize>) {
        let columns = self.motion_columns();
        if columns.is_empty() {
            return;
        }
        let bodies = Rc::clone(&self.bodies[usize::from(segment.loaded)]);
        let motors = segment.motors;
        let mut derivatives = self.lend_derivatives();
        for start in (0..range.len()).step_by(BLOCK) {
            let part = start..range.len().min(start + BLOCK);
            derivatives.evaluate(&self.tree, &bodies, self.trajectory(), part.clone());
            for moving in &columns {
                for (i, multiplier) in self.model.moved_with(moving.joint) {
                    for row in 0..self.rigid.values.len() {
                        let [by_q, by_dq, by_ddq] = self.by_motion(&derivatives, row, i);
                        let spring = self.stiffness.get(i);
                        let spring = spring.filter(|_| row == i && row < self.torque_rows());
                        let damper = self.damping.get(i).filter(|_| spring.is_some());
                        let series = self.rigid.series(row, moving.column);
                        for (at, k) in part.clone().enumerate() {
                            let sample = range.start + k;
                            let m = match moving.motor {
                                Some(j) => [motors.q, motors.dq, motors.ddq]
                                    .map(|series| multiplier * series[j][sample]),
                                None => [multiplier, 0.0, 0.0],
                            };
                            let own = spring.map_or(0.0, |stiffness| stiffness[k] * m[0])
                                + damper.map_or(0.0, |damping| damping[k] * m[1]);
                            series[k] +=
                                by_q[at] * m[0] + by_dq[at] * m[1] + by_ddq[at] * m[2] + own;
                        }
                    }
                }
            }
        }
        self.derivatives = Some(derivatives);
    }

    /// `e_j τ_i`.
    pub(super) fn coupling_torque_columns(&mut self, samples: usize) {
        if self.torque_rows() == 0 {
            return;
        }
        for (column, i, j) in self.coupling_entries() {
            let series = self.block.series(j, column);
            for (i, multiplier) in self.model.moved_with(i) {
                for (to, torque) in series[..samples].iter_mut().zip(&self.rigid.values[i]) {
                    *to += multiplier * torque;
                }
            }
        }
    }
}
