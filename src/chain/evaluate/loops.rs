//! Torques of joints without a motor, carried to the motors by the loops that they close; known forces.

use crate::chain::evaluate::Evaluator;
use std::ops::Range;

impl Evaluator<'_> {
    /// `τ = τ − f`: what the surroundings exert, the motors need not.
    pub(super) fn push_links(&mut self, forces: &[Vec<f64>], range: Range<usize>) {
        let rows = self.torque_rows();
        for (torque, force) in self.rigid.values[..rows].iter_mut().zip(forces) {
            for (torque, force) in torque.iter_mut().zip(&force[range.clone()]) {
                *torque -= force;
            }
        }
    }

    /// `τ_a = τ_a + Pᵀ τ_p`, values and columns alike, sample by sample.
    pub(super) fn close_loops(&mut self, samples: usize) {
        let (Some(mechanism), true) = (self.model.mechanism(), self.torque_rows() > 0) else {
            return;
        };
        let (passive, actuated) = (mechanism.passive(), mechanism.actuated());
        let maps: Vec<_> = (0..samples)
            .map(|sample| {
                let q: Vec<f64> = self.joint_motion[0].iter().map(|s| s[sample]).collect();
                mechanism.velocity_map(&q)
            })
            .collect();
        let columns = self.rigid.columns;
        for (p, &from) in passive.iter().enumerate() {
            for (a, &to) in actuated.iter().enumerate() {
                let factors = || maps.iter().map(|map| map[(p, a)]);
                let given = std::mem::take(&mut self.rigid.values[from]);
                add(&mut self.rigid.values[to], &given, factors());
                self.rigid.values[from] = given;
                for column in 0..columns {
                    let given = self.rigid.lend(from, column);
                    if !given.is_empty() {
                        add(self.rigid.series(to, column), &given, factors());
                    }
                    self.rigid.give_back(from, column, given);
                }
            }
        }
    }
}

fn add(to: &mut [f64], given: &[f64], factors: impl Iterator<Item = f64>) {
    for ((to, x), factor) in to.iter_mut().zip(given).zip(factors) {
        *to += factor * x;
    }
}
