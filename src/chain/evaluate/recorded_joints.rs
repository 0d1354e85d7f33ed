//! Derivatives where positions were recorded at the joints: with another V the joints stay and the motors move.
//!
//! `m = V⁻¹ V_ref m_ref`, so that `q = V m + offset` is what was recorded whatever V is. Entries of V act on the
//! laws of the motors and on the torque that reaches them; their columns are central differences of the whole.

use crate::chain::evaluate::{Evaluator, Room, Segment};
use crate::robot::batch::Trajectory;
use nalgebra::DMatrix;
use std::ops::Range;

/// Half of the difference of an entry of V, which is of the order of one: what rounding and curvature leave is
/// below a millionth.
const STEP: f64 = 1e-5;

impl Evaluator<'_> {
    /// `V⁻¹ V_ref` where it is not the identity.
    pub(super) fn transfer_of_recorded(&self) -> Option<DMatrix<f64>> {
        let reference = self.model.reference()?;
        let coupling = self.model.coupling(&self.values);
        if coupling == *reference {
            return None;
        }
        Some(coupling.try_inverse()? * reference)
    }

    /// Motions of the motors over the samples of `range`.
    pub(super) fn motors(
        transfer: &DMatrix<f64>,
        motors: Trajectory<'_>,
        range: Range<usize>,
    ) -> [Vec<Vec<f64>>; 3] {
        let n = transfer.nrows();
        [motors.q, motors.dq, motors.ddq].map(|series| {
            let row = |i: usize| {
                let mut out = vec![0.0; range.len()];
                for j in (0..n).filter(|&j| transfer[(i, j)] != 0.0) {
                    for (to, x) in out.iter_mut().zip(&series[j][range.clone()]) {
                        *to += transfer[(i, j)] * x;
                    }
                }
                out
            };
            (0..n).map(row).collect()
        })
    }

    /// Columns of the entries of V.
    pub(super) fn entry_columns(&mut self, segment: Segment<'_>, range: Range<usize>) {
        if self.model.reference().is_none() {
            return;
        }
        for (column, i, j) in self.coupling_entries() {
            let position = self.model.coupling_position(i, j);
            let Some(position) = position else { continue };
            let at = |step: f64| {
                let mut values = self.values.clone();
                values[position] += step;
                let room = Room {
                    samples: range.len(),
                    along: self.along,
                };
                let mut other = Evaluator::with_room(self.model, &values, &[], room);
                other.wanted.clone_from(&self.wanted);
                other.states(segment, range.clone());
                other.block
            };
            let (ahead, behind) = (at(STEP), at(-STEP));
            for channel in (0..self.wanted.len()).filter(|&c| self.wanted[c]) {
                let series = self.block.series(channel, column);
                let pairs = ahead.value(channel).iter().zip(behind.value(channel));
                for (to, (a, b)) in series.iter_mut().zip(pairs) {
                    *to = (a - b) / (2.0 * STEP);
                }
            }
        }
    }
}
