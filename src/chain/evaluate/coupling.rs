//! Derivatives with respect to entries of V.
//!
//! `∂τ_M/∂V_ij = Vᵀ (∂τ/∂q_i m_j + ∂τ/∂q̇_i ṁ_j + ∂τ/∂q̈_i m̈_j) + e_j τ_i`

use crate::chain::evaluate::{BLOCK, Evaluator, Segment};
use std::ops::Range;
use std::rc::Rc;

impl Evaluator<'_> {
    /// The part in brackets, of joint torques and base wrench.
    pub(super) fn coupling_motion_columns(&mut self, segment: Segment<'_>, range: Range<usize>) {
        let entries = self.coupling_entries();
        if entries.is_empty() {
            return;
        }
        let bodies = Rc::clone(&self.bodies[usize::from(segment.loaded)]);
        let motors = segment.motors;
        let mut derivatives = self.lend_derivatives();
        for start in (0..range.len()).step_by(BLOCK) {
            let part = start..range.len().min(start + BLOCK);
            derivatives.evaluate(&self.tree, &bodies, (self.trajectory(), part.clone()));
            for &(column, i, j) in &entries {
                for (i, multiplier) in self.model.moved_with(i) {
                    for row in 0..self.rigid.values.len() {
                        let [by_q, by_dq, by_ddq] = self.by_motion(&derivatives, (row, i));
                        let spring = self.stiffness.get(i);
                        let spring = spring.filter(|_| row == i && row < self.torque_rows());
                        let damper = self.damping.get(i).filter(|_| spring.is_some());
                        let series = self.rigid.series(row, column);
                        for (at, k) in part.clone().enumerate() {
                            let sample = range.start + k;
                            let m = [motors.q, motors.dq, motors.ddq]
                                .map(|series| multiplier * series[j][sample]);
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
