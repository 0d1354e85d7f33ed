//! A plan of constant velocities: joint after joint moves to and fro at speeds from slow to fast, while the others stand still.
//! Friction and drive constants are read off the parts at constant speed.
//!
//! ```text
//! speed of a stroke:  v (1 − cos(πt/T))/2 while it starts, v, and the same backwards;   T = πv / (2 q̈)
//! ```
//!
//! with half of the acceleration limit for q̈. Speeds grow geometrically up to the largest for which the range of
//! positions leaves room for a constant part.

use std::f64::consts::PI;

use crate::design::trajectory::motion::{MOTION, Motion};
use crate::robot::tree::Tree;
use crate::setup::limits::JointLimits;
use crate::stats::range::within;

/// Share of the acceleration and jerk limits, of the velocity limit, and of the range of positions that is used.
const ACCELERATION_SHARE: f64 = 0.5;
const VELOCITY_SHARE: f64 = 0.95;
const RANGE_SHARE: f64 = 0.9;

/// Slowest speed as a share of the fastest.
const SLOWEST: f64 = 0.02;

/// Duration of the part at constant speed, s: at least and at most.
const LEAST_CONSTANT: f64 = 0.4;
const MOST_CONSTANT: f64 = 3.0;

/// Halvings that find the fastest speed.
const HALVINGS: usize = 60;

/// One stroke from standstill to standstill.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stroke {
    joint: usize,
    from: f64,
    /// Signed, rad/s or m/s.
    velocity: f64,
    /// s of each blend, and of the constant part.
    blend: f64,
    constant: f64,
}

impl Stroke {
    fn duration(&self) -> f64 {
        2.0 * self.blend + self.constant
    }

    fn length(&self) -> f64 {
        self.velocity * (self.blend + self.constant)
    }

    /// Position, velocity, acceleration.
    fn at(&self, t: f64) -> [f64; MOTION] {
        let (v, blend) = (self.velocity, self.blend);
        let rising = |t: f64| {
            let phase = PI * t / blend;
            [
                0.5 * v * (t - blend / PI * phase.sin()),
                0.5 * v * (1.0 - phase.cos()),
                0.5 * v * PI / blend * phase.sin(),
            ]
        };
        let end = self.from + self.length();
        if t < blend {
            let [s, ds, dds] = rising(t);
            [self.from + s, ds, dds]
        } else if t < blend + self.constant {
            [self.from + v * (t - 0.5 * blend), v, 0.0]
        } else {
            let [s, ds, dds] = rising((self.duration() - t).max(0.0));
            [end - s, ds, -dds]
        }
    }
}

/// The strokes of all moving joints.
#[derive(Debug, Clone, PartialEq)]
pub struct ConstantVelocityPlan {
    /// Where the joints stand.
    pub rest: Vec<f64>,
    strokes: Vec<Stroke>,
}

/// Duration of a blend to a speed.
fn blend(speed: f64, limits: &JointLimits) -> f64 {
    let of_acceleration = PI * speed / (2.0 * ACCELERATION_SHARE * limits.acceleration);
    let of_jerk = limits.jerk.map_or(0.0, |jerk| {
        PI * (speed / (2.0 * ACCELERATION_SHARE * jerk)).sqrt()
    });
    of_acceleration.max(of_jerk)
}

/// The largest speed that leaves a constant part on a way of this length.
fn fastest(length: f64, limits: &JointLimits) -> f64 {
    let fits = |speed: f64| speed * (blend(speed, limits) + LEAST_CONSTANT) <= length;
    let most = VELOCITY_SHARE * limits.velocity;
    if fits(most) {
        return most;
    }
    let (mut low, mut high) = (0.0, most);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if fits(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// What a plan of constant velocities is made for.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The robot.
    pub tree: &'a Tree,
    /// The joints that are moved, one after the other.
    pub moving: &'a [usize],
    /// Of every joint.
    pub limits: &'a [JointLimits],
    /// Where the joints stand.
    pub rest: &'a [f64],
    /// Number of speeds of each joint.
    pub speeds: usize,
    /// Share of the ranges of positions that is used.
    pub share: f64,
}

impl ConstantVelocityPlan {
    /// Strokes at every speed of every moving joint about where it stands. The error is a joint without room.
    pub fn new(request: Request<'_>) -> Result<Self, String> {
        let Request {
            tree,
            moving,
            limits,
            rest,
            speeds,
            share,
        } = request;
        let mut strokes = Vec::new();
        for &j in moving {
            let bounds = &limits[j];
            let room = (bounds.upper - rest[j]).min(rest[j] - bounds.lower);
            let length = 2.0 * RANGE_SHARE * share * room;
            let top = fastest(length, bounds);
            if top.is_nan() || top <= 0.0 {
                return Err(tree.joints()[j].name.clone());
            }
            for k in 0..speeds {
                let exponent = 1.0 - k as f64 / (speeds.max(2) - 1) as f64;
                let speed = top * SLOWEST.powf(exponent);
                let blend = blend(speed, bounds);
                let constant = within(length / speed - blend, [0.0, MOST_CONSTANT]);
                let way = speed * (blend + constant);
                // Half a stroke out, whole strokes to and fro, half a stroke home.
                let half = Stroke {
                    joint: j,
                    from: rest[j],
                    velocity: speed,
                    blend,
                    constant: constant_of(0.5 * way, speed, blend),
                };
                let half = shortened(half, 0.5 * way);
                let whole = |from: f64, velocity: f64| Stroke {
                    joint: j,
                    from,
                    velocity,
                    blend,
                    constant,
                };
                let (low, high) = (rest[j] - 0.5 * way, rest[j] + 0.5 * way);
                strokes.push(half);
                strokes.push(whole(high, -speed));
                strokes.push(whole(low, speed));
                strokes.push(Stroke {
                    from: high,
                    velocity: -half.velocity,
                    ..half
                });
            }
        }
        Ok(Self {
            rest: rest.to_vec(),
            strokes,
        })
    }

    /// s.
    pub fn duration(&self) -> f64 {
        self.strokes.iter().map(Stroke::duration).sum()
    }

    /// The plan at instants `step` seconds apart, standstill at both ends.
    pub fn motion(&self, step: f64) -> Motion {
        let count = (self.duration() / step).ceil() as usize + 1;
        let mut values: [Vec<Vec<f64>>; MOTION] =
            std::array::from_fn(|_| vec![vec![0.0; count]; self.rest.len()]);
        for (series, rest) in values[0].iter_mut().zip(&self.rest) {
            series.fill(*rest);
        }
        let mut began = 0.0;
        let mut strokes = self.strokes.iter().peekable();
        for k in 0..count {
            let t = k as f64 * step;
            while let Some(stroke) = strokes.peek() {
                if t < began + stroke.duration() {
                    break;
                }
                began += stroke.duration();
                strokes.next();
            }
            if let Some(stroke) = strokes.peek() {
                let state = stroke.at(t - began);
                for (order, value) in state.into_iter().enumerate() {
                    values[order][stroke.joint][k] = value;
                }
            }
        }
        Motion::of_values(values)
    }
}

/// Duration at constant speed on a way; zero where the blends alone are longer.
fn constant_of(way: f64, speed: f64, blend: f64) -> f64 {
    (way / speed - blend).max(0.0)
}

/// A stroke whose blends alone would be too long goes at the speed that fits its way.
fn shortened(stroke: Stroke, way: f64) -> Stroke {
    match stroke.constant > 0.0 {
        true => stroke,
        // The blend keeps its duration, so acceleration and jerk fall with the speed.
        false => Stroke {
            velocity: way / stroke.blend,
            ..stroke
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::random::{generator, tree};

    fn limits() -> JointLimits {
        JointLimits {
            lower: -1.2,
            upper: 0.8,
            velocity: 2.0,
            acceleration: 6.0,
            jerk: Some(80.0),
            torque: None,
        }
    }

    fn plan() -> ConstantVelocityPlan {
        let tree = tree(&mut generator(1), 3);
        let bounds = vec![limits(); 3];
        let request = Request {
            tree: &tree,
            moving: &[0, 2],
            limits: &bounds,
            rest: &[0.1, 0.4, -0.3],
            speeds: 6,
            share: 1.0,
        };
        ConstantVelocityPlan::new(request).unwrap()
    }

    #[test]
    fn invariant_strokes_keep_the_limits_and_come_home() {
        let (plan, bounds, step) = (plan(), limits(), 1e-3);
        let motion = plan.motion(step);
        for j in [0, 2] {
            let [q, dq, ddq] = [0, 1, 2].map(|order| &motion.values[order][j]);
            let peak = |series: &[f64]| series.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            assert!(q.iter().all(|q| (bounds.lower..=bounds.upper).contains(q)));
            assert!(peak(dq) <= bounds.velocity && peak(ddq) <= bounds.acceleration);
            // Accelerations are continuous, so their differences are jerks.
            let jerk = ddq.windows(2).map(|p| ((p[1] - p[0]) / step).abs());
            assert!(jerk.fold(0.0, f64::max) <= 80.0);
            assert!((q[q.len() - 1] - plan.rest[j]).abs() < 1e-9 && dq[dq.len() - 1].abs() < 1e-9);
        }
        assert!(motion.values[0][1].iter().all(|q| *q == 0.4));
    }

    #[test]
    fn invariant_velocity_and_acceleration_are_derivatives_of_position() {
        let step = 1e-4;
        let motion = plan().motion(step);
        for j in [0, 2] {
            for order in 1..MOTION {
                let (whole, slope) = (&motion.values[order - 1][j], &motion.values[order][j]);
                for k in 1..slope.len() - 1 {
                    let difference = (whole[k + 1] - whole[k - 1]) / (2.0 * step);
                    // Where strokes meet a third derivative jumps: by at most 160 rad/s³ · step.
                    assert!(
                        (difference - slope[k]).abs() < 160.0 * step,
                        "{j} {order} {k}"
                    );
                }
            }
        }
    }
}
