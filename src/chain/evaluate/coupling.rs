//! Derivatives with respect to entries of V.
//!
//! `∂τ_M/∂V_ij = Vᵀ (∂τ/∂q_i m_j + ∂τ/∂q̇_i ṁ_j + ∂τ/∂q̈_i m̈_j) + e_j τ_i`

use crate::chain::evaluate::bodies::by_motion;
use crate::chain::evaluate::{Evaluator, Segment};
use std::ops::Range;
use std::rc::Rc;

impl Evaluator<'_> {
    /// The part in brackets, of joint torques and base wrench.
    pub(super) fn coupling_motion_columns(&mut self, segment: Segment<'_>, range: Range<usize>) {
        let entries = self.coupling_entries();
        if entries.is_empty() {
            return;
        }
        let n = self.model.joints().len();
        let torque_rows = self.torque_rows();
        let bodies = Rc::clone(&self.bodies[usize::from(segment.loaded)]);
        let motors = segment.motors;
        let mut state = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        let mut derivatives = self.lend_derivatives();
        for (k, sample) in range.enumerate() {
            self.state_at(k, &mut state);
            let slices = [&state[0][..], &state[1], &state[2]];
            derivatives.evaluate(&self.tree, &bodies, slices);
            for &(column, i, j) in &entries {
                let m = [motors.q, motors.dq, motors.ddq].map(|series| series[j][sample]);
                let spring = self.stiffness.get(i).map_or(0.0, |s| s[k]) * m[0];
                for row in 0..self.rigid.values.len() {
                    let [by_q, by_dq, by_ddq] = by_motion(&derivatives, (row, torque_rows), i);
                    let own = if row == i && row < torque_rows {
                        spring
                    } else {
                        0.0
                    };
                    let change = by_q * m[0] + by_dq * m[1] + by_ddq * m[2] + own;
                    self.rigid.series(row, column)[k] += change;
                }
            }
        }
        self.derivatives = Some(derivatives);
    }

    /// Joint motion of one sample.
    pub(super) fn state_at(&self, k: usize, state: &mut [Vec<f64>; 3]) {
        for (values, motion) in state.iter_mut().zip(&self.joint_motion) {
            for (value, series) in values.iter_mut().zip(motion) {
                *value = series[k];
            }
        }
    }

    /// `e_j τ_i`.
    pub(super) fn coupling_torque_columns(&mut self, samples: usize) {
        if self.torque_rows() == 0 {
            return;
        }
        for (column, i, j) in self.coupling_entries() {
            let series = self.block.series(j, column);
            for (to, torque) in series[..samples].iter_mut().zip(&self.rigid.values[i]) {
                *to += torque;
            }
        }
    }
}
