//! A trajectory at even instants, with ramps from and to standstill, as CSV and as the message of a robot's trajectory
//! controller.

use std::io::{self, Write};

use nalgebra::DVector;

use crate::design::trajectory::fourier_series::Basis;
use crate::design::trajectory::motion::{Joints, MOTION, Motion};
use crate::setup::limits::JointLimits;

/// Prefixes of the columns.
const PREFIXES: [&str; MOTION] = ["q", "dq", "ddq"];

/// A motion at even instants from t = 0 on.
#[derive(Debug, Clone)]
pub struct Sampled {
    /// Names of all joints.
    pub joints: Vec<String>,
    /// s.
    pub step: f64,
    /// `[order][joint][sample]`.
    pub values: [Vec<Vec<f64>>; MOTION],
}

/// Longest ramp, and its first trial, s.
const LONGEST_RAMP: f64 = 30.0;
const FIRST_RAMP: f64 = 0.5;

/// Factor by which a ramp is lengthened until it keeps the limits.
const LENGTHEN: f64 = 1.15;

/// Intervals of a ramp at whose ends it is checked.
const INSTANTS: usize = 200;

/// A ramp ends in a state that may lie on a limit: rounding beyond it is no violation.
const ROUNDING: f64 = 1.0 + 1e-6;

impl Sampled {
    /// One period of a trajectory at about this rate: as many even instants as come nearest.
    pub fn period(joints: &Joints, x: &DVector<f64>, rate: f64, names: &[String]) -> Self {
        let count = (joints.series.period * rate).round().max(2.0) as usize;
        let basis = Basis::new(joints.series, count);
        Self {
            joints: names.to_vec(),
            step: basis.step(),
            values: Motion::of(joints, &basis, x).values,
        }
    }

    /// Rows.
    pub fn len(&self) -> usize {
        self.values[0].first().map_or(0, Vec::len)
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A motion that is sampled already.
    pub fn given(motion: Motion, step: f64, names: &[String]) -> Self {
        Self {
            joints: names.to_vec(),
            step,
            values: motion.values,
        }
    }

    /// The period between ramps: from standstill at `rest` to its start, and from its start back. Ramps are
    /// lengthened until they keep the limits of the joints and `holds` is true of their motion.
    pub fn with_ramps(
        &self,
        rest: &[f64],
        limits: &[JointLimits],
        holds: impl Fn(&Motion) -> bool,
    ) -> Self {
        let start: Vec<[f64; MOTION]> = (0..self.joints.len())
            .map(|j| std::array::from_fn(|order| self.values[order][j][0]))
            .collect();
        let mut duration = FIRST_RAMP;
        // The way out is a ramp in of the motion that runs backwards in time: its velocity has the other sign.
        let quintics = |duration: f64, sign: f64| -> Vec<[f64; 6]> {
            let ends = start.iter().zip(rest);
            ends.map(|([q, dq, ddq], rest)| quintic(*rest, [*q, sign * dq, *ddq], duration))
                .collect()
        };
        let stands = |duration: f64| {
            [1.0, -1.0].into_iter().all(|sign| {
                let ramps = quintics(duration, sign);
                keeps(&ramps, duration, limits) && holds(&motion_of(&ramps, duration))
            })
        };
        while duration < LONGEST_RAMP && !stands(duration) {
            duration *= LENGTHEN;
        }
        let count = (duration / self.step).ceil() as usize;
        let duration = count as f64 * self.step;
        let (way_in, way_out) = (quintics(duration, 1.0), quintics(duration, -1.0));
        let n = self.joints.len();
        let values = std::array::from_fn(|order| {
            (0..n)
                .map(|j| {
                    let at = |k: usize| evaluate(&way_in[j], k as f64 * self.step)[order];
                    // The start of a period is its end.
                    let sign = if order == 1 { -1.0 } else { 1.0 };
                    let back = |k: usize| {
                        sign * evaluate(&way_out[j], duration - k as f64 * self.step)[order]
                    };
                    let mut series: Vec<f64> = (0..count).map(at).collect();
                    series.extend_from_slice(&self.values[order][j]);
                    series.extend((0..=count).map(back));
                    series
                })
                .collect()
        });
        Self {
            joints: self.joints.clone(),
            step: self.step,
            values,
        }
    }

    /// The same with the joints without a motor moved by the others.
    pub fn closed(self, joints: &Joints) -> Self {
        let mut motion = Motion::of_values(self.values);
        joints.close(&mut motion);
        Self {
            values: motion.values,
            ..self
        }
    }

    /// Comma-separated text: t, then q_, dq_ and ddq_ of all joints.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_csv(&self, out: &mut impl Write) -> io::Result<()> {
        write!(out, "t")?;
        for prefix in PREFIXES {
            for joint in &self.joints {
                write!(out, ",{prefix}_{joint}")?;
            }
        }
        writeln!(out)?;
        for k in 0..self.len() {
            write!(out, "{}", k as f64 * self.step)?;
            for series in self.values.iter().flatten() {
                write!(out, ",{}", series[k])?;
            }
            writeln!(out)?;
        }
        Ok(())
    }

    /// A ROS `trajectory_msgs/JointTrajectory` as YAML.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_yaml(&self, out: &mut impl Write) -> io::Result<()> {
        let quoted: Vec<String> = self.joints.iter().map(|j| format!("{j:?}")).collect();
        writeln!(out, "joint_names: [{}]", quoted.join(", "))?;
        writeln!(out, "points:")?;
        for k in 0..self.len() {
            for (order, key) in ["positions", "velocities", "accelerations"]
                .iter()
                .enumerate()
            {
                let values: Vec<String> = self.values[order]
                    .iter()
                    .map(|series| format!("{:?}", series[k]))
                    .collect();
                let lead = if order == 0 { "- " } else { "  " };
                writeln!(out, "{lead}{key}: [{}]", values.join(", "))?;
            }
            let nanoseconds = (1e9 * k as f64 * self.step).round() as u64;
            writeln!(
                out,
                "  time_from_start: {{sec: {}, nanosec: {}}}",
                nanoseconds / 1_000_000_000,
                nanoseconds % 1_000_000_000
            )?;
        }
        Ok(())
    }
}

/// Coefficients c of `Σ c_k t^k` from standstill at `rest` to a state after `duration`.
fn quintic(rest: f64, [q, dq, ddq]: [f64; MOTION], duration: f64) -> [f64; 6] {
    let t = duration;
    let (a, b, c) = (q - rest, dq * t, ddq * t * t);
    let scaled = [
        rest,
        0.0,
        0.0,
        10.0 * a - 4.0 * b + 0.5 * c,
        -15.0 * a + 7.0 * b - c,
        6.0 * a - 3.0 * b + 0.5 * c,
    ];
    std::array::from_fn(|k| scaled[k] / t.powi(k as i32))
}

/// A ramp at even instants.
fn motion_of(quintics: &[[f64; 6]], duration: f64) -> Motion {
    let of = |order: usize, c: &[f64; 6]| -> Vec<f64> {
        let t = |k: usize| duration * k as f64 / INSTANTS as f64;
        (0..=INSTANTS).map(|k| evaluate(c, t(k))[order]).collect()
    };
    Motion::of_values(std::array::from_fn(|order| {
        quintics.iter().map(|c| of(order, c)).collect()
    }))
}

/// Value, first and second derivative.
fn evaluate(c: &[f64; 6], t: f64) -> [f64; MOTION] {
    let mut at = [0.0; MOTION];
    for k in (0..6).rev() {
        at[0] = at[0] * t + c[k];
    }
    for k in (1..6).rev() {
        at[1] = at[1] * t + k as f64 * c[k];
    }
    for k in (2..6).rev() {
        at[2] = at[2] * t + (k * (k - 1)) as f64 * c[k];
    }
    at
}

/// Whether ramps keep the limits of position, velocity, acceleration and jerk.
fn keeps(quintics: &[[f64; 6]], duration: f64, limits: &[JointLimits]) -> bool {
    quintics.iter().zip(limits).all(|(c, limits)| {
        // Standing joints have nothing to keep.
        let moves = c[1..].iter().any(|c| *c != 0.0);
        !moves
            || (0..=INSTANTS).all(|k| {
                let t = duration * k as f64 / INSTANTS as f64;
                let [q, dq, ddq] = evaluate(c, t);
                let jerk = 6.0 * c[3] + 24.0 * c[4] * t + 60.0 * c[5] * t * t;
                limits.jerk.is_none_or(|most| jerk.abs() <= ROUNDING * most)
                    && (limits.lower..=limits.upper).contains(&q)
                    && dq.abs() <= ROUNDING * limits.velocity
                    && ddq.abs() <= ROUNDING * limits.acceleration
            })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_a_ramp_joins_standstill_and_the_state_with_velocity_and_acceleration() {
        let end = [0.7, -0.3, 1.1];
        let c = quintic(0.2, end, 1.7);
        let (first, last) = (evaluate(&c, 0.0), evaluate(&c, 1.7));
        assert_eq!(first, [0.2, 0.0, 0.0]);
        for order in 0..MOTION {
            // Six terms of order ten, each rounded.
            assert!((last[order] - end[order]).abs() < 1e-13);
        }
    }
}
