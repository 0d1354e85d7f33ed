//! Channels that are recorded late: `s(t) = s_true(t − delay)`, from the motion at t − delay.
//!
//! A command that acts late is answered by the motion at t + delay: with the error ŝ that this motion asks for
//!
//! ```text
//! m_c(t) = (m + ŝ)(t + delay),   s(t) = m_c(t) − m(t)
//! ```

use crate::chain::evaluate::earlier_motion::EarlierMotion;
use crate::chain::evaluate::{Evaluator, Segment};
use crate::chain::model::Signal;
use crate::robot::batch::Trajectory;

/// Step of the difference that gives ∂s/∂delay, as a share of the time between samples: rounding leaves
/// seven digits, and the motion between samples is a smooth polynomial.
const STEP: f64 = 2e-5;

impl Evaluator<'_> {
    /// Every channel with its own delay; channels that share one share the evaluation.
    pub(super) fn delayed(&mut self, segment: Segment<'_>) {
        let channels = self.model.channels();
        let ahead = match self.model.signal() {
            Signal::PositionCommand => -1.0,
            _ => 1.0,
        };
        let of_joint = |joint: usize| {
            let delay = self.model.joints()[joint].delay;
            delay.map_or((0.0, None), |at| (ahead * self.values[at], self.column[at]))
        };
        // By channel: its delay, and the column of that.
        let late: Vec<(f64, Option<usize>)> = channels
            .iter()
            .map(|channel| channel.joint.map_or((0.0, None), of_joint))
            .collect();
        let is_wanted = self.wanted.clone();
        let mut distinct: Vec<f64> = (0..late.len())
            .filter(|&c| is_wanted[c])
            .map(|c| late[c].0)
            .collect();
        distinct.sort_by(f64::total_cmp);
        distinct.dedup();
        let mut whole = self.block.like();
        whole.clear(segment.motors.len());
        let motion = EarlierMotion::of(segment);
        for delay in distinct {
            let is_member = |c: usize| is_wanted[c] && late[c].0 == delay;
            self.wanted = (0..late.len()).map(is_member).collect();
            self.shifted(&motion, delay);
            let members: Vec<usize> = (0..late.len()).filter(|&c| is_member(c)).collect();
            for &c in &members {
                whole.exchange_channel(c, &mut self.block);
            }
            let columns: Vec<(usize, usize)> = members
                .iter()
                .filter_map(|&c| Some((c, late[c].1?)))
                .collect();
            if columns.is_empty() {
                continue;
            }
            let step = STEP * segment.step();
            let later = self.shifted_values(&motion, delay + step);
            let sooner = self.shifted_values(&motion, delay - step);
            for (c, column) in columns {
                let pairs = later[c].iter().zip(&sooner[c]);
                let slopes = pairs.map(|(later, sooner)| ahead * (later - sooner) / (2.0 * step));
                let series = whole.series(c, column).iter_mut();
                series.zip(slopes).for_each(|(to, slope)| *to += slope);
            }
        }
        self.wanted = is_wanted;
        self.block = whole;
    }

    fn shifted(&mut self, motion: &EarlierMotion<'_>, delay: f64) {
        let segment = motion.segment;
        let samples = segment.motors.len();
        if delay == 0.0 || samples < 2 {
            self.states(segment, 0..samples);
            return;
        }
        let (time, [q, dq, ddq]) = motion.at(delay);
        let moved = Segment {
            motors: Trajectory {
                q: &q,
                dq: &dq,
                ddq: &ddq,
            },
            time: &time,
            bodies: None,
            ..segment
        };
        self.states(moved, 0..samples);
        for (j, joint) in self.model.joints().iter().enumerate() {
            if joint.controller.is_some() && self.wanted[j] {
                let moved = q[j].iter().zip(&segment.motors.q[j]);
                let pairs = self.block.values[j].iter_mut().zip(moved);
                pairs.for_each(|(error, (then, now))| *error += then - now);
            }
        }
    }

    /// Values alone: without columns nothing is spent on derivatives.
    fn shifted_values(&mut self, motion: &EarlierMotion<'_>, delay: f64) -> Vec<Vec<f64>> {
        let none = vec![None; self.column.len()];
        let columns = std::mem::replace(&mut self.column, none);
        let (block, rigid) = (self.block.without_columns(), self.rigid.without_columns());
        let block = std::mem::replace(&mut self.block, block);
        let rigid = std::mem::replace(&mut self.rigid, rigid);
        self.shifted(motion, delay);
        self.column = columns;
        self.rigid = rigid;
        std::mem::replace(&mut self.block, block).values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::dataset::Prepared;
    use crate::chain::effect::find;
    use crate::chain::model::{Model, ModelSettings};
    use crate::recording::preprocess::prepare;
    use crate::recording::samples::Recording;
    use crate::recording::settings::Preparation;
    use crate::recording::split::Split;
    use crate::robot::urdf;
    use std::path::Path;

    const ARM: &str = r#"<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.3 0 -0.05"/><mass value="4"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.06" iyz="0" izz="0.06"/></inertial></link>
<link name="lower"><inertial><origin xyz="0.1 0 -0.2"/><mass value="2"/>
<inertia ixx="0.03" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.01"/></inertial></link>
<joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
<joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/><origin xyz="0.6 0 0"/><axis xyz="0 1 0"/></joint>
</robot>"#;

    /// What a late signal is along the motion as recorded, it is on time along the motion as it was then.
    #[test]
    fn a_signal_that_is_late_is_on_time_beside_a_motion_that_is_as_late() {
        let tree = urdf::parse(ARM, Path::new("arm.urdf")).unwrap();
        // Laws with parameters of others stand behind the delay.
        let ids = [
            "coulomb_friction",
            "viscous_friction",
            "time_delay",
            "presliding_hysteresis",
            "thermal_drift",
        ];
        let effects: Vec<_> = ids.iter().map(|id| find(id).unwrap()).collect();
        let model = Model::new(ModelSettings {
            effects: vec![effects; 2],
            ..ModelSettings::bodies(tree, Signal::Torque)
        })
        .unwrap();
        let mut values = model.generic_values();
        let delays = [0.004, 0.0113];
        for (joint, delay) in model.joints().iter().zip(delays) {
            values[joint.delay.unwrap()] = delay;
        }
        let positions = |rate: f64| {
            (0..400)
                .map(|k| (0.01 * rate * f64::from(k)).sin())
                .collect()
        };
        let positions: Vec<Vec<f64>> = [3.0, 4.0].map(positions).to_vec();
        let recording = Recording::of_samples("made", positions.clone(), positions);
        let preparation = Preparation {
            rate: Some(100.0),
            ..Preparation::default()
        };
        let experiment = prepare(recording, &preparation).unwrap();
        let recorded = Prepared::new("made".to_string(), Split::Train, false, experiment);
        let signal = |model: &Model, recording: &Prepared, channel: usize| {
            let mut evaluator = Evaluator::along(model, &values, &[], recording.rows());
            evaluator
                .evaluate_whole(recording.whole())
                .value(channel)
                .to_vec()
        };
        for (channel, delay) in delays.into_iter().enumerate() {
            let mut on_time = model.clone();
            on_time.predict_only(channel);
            on_time.predict_on_time();
            let late = signal(&model, &recorded, channel);
            assert_eq!(signal(&on_time, &recorded.late_by(delay), channel), late);
            assert_ne!(signal(&on_time, &recorded, channel), late);
        }
    }
}
