//! Integration of the state of a user-defined law along a motion, `ż = f(z, v)`.
//!
//! Between samples v is linear. A step has a few parts; over each, with v at its middle, the equation linearised in z is solved
//! exactly (Hochbruck and Ostermann 2010, exponential Rosenbrock-Euler),
//!
//! ```text
//! z⁺ = z + h φ(h f_z) f,   φ(x) = (eˣ − 1)/x
//! ```
//!
//! which is exact where f is linear in z, as of bristles, and stable however stiff they are. The same recursion is
//! differentiated for the sensitivities.

use crate::chain::effect::expression::{Expression, StateLaw, Variable};
use crate::chain::effect::formula::derivative::derivative;
use crate::chain::effect::formula::tape::{LANES, States, Tape};
use crate::chain::effect::law::Samples;

/// `|x|` below which φ is its series: the next term is 1/24 of its cube.
const SERIES: f64 = 1e-4;

/// The state after a part of a step.
pub fn advance(rate: &Expression, state: usize) -> Expression {
    let z = Expression::from(Variable::State(state));
    let h = || Expression::from(Variable::Duration);
    let slope = derivative(rate, &z);
    if slope == Expression::Number(0.0) {
        return z + h() * rate.clone();
    }
    let x = h() * slope;
    let series = Expression::from(1.0) + x.clone() * 0.5 + x.clone().squared() / 6.0;
    let closed = (x.clone().exponential() - 1.0) / x.clone();
    let phi = x.magnitude().if_less(SERIES, series, closed);
    z + h() * phi * rate.clone()
}

/// The recursion of one state, compiled.
#[derive(Debug)]
pub struct March {
    /// Parameters that the state depends on.
    parameters: Vec<usize>,
    parts: usize,
    /// First value, and its slopes by the parameters.
    start: Tape,
    /// Next value, its slope by the state, its slopes by the parameters.
    step: Tape,
}

/// A state along a motion.
#[derive(Debug)]
pub struct StateTrajectory {
    pub state: Vec<f64>,
    /// Of the parameters that it depends on.
    pub slopes: Vec<Slopes>,
}

/// Derivatives of a state by a parameter along a motion.
#[derive(Debug)]
pub struct Slopes {
    pub parameter: usize,
    pub series: Vec<f64>,
}

impl March {
    pub fn compile(law: &StateLaw, state: usize, count: usize) -> Self {
        let is_in = |k: &usize| {
            let is = |part: &Expression| *part == Expression::parameter(*k);
            law.start.any(&is) || law.advance.any(&is)
        };
        let parameters: Vec<usize> = (0..count).filter(is_in).collect();
        let slopes = |of: &Expression| -> Vec<Expression> {
            let by = parameters.iter().map(|k| Expression::parameter(*k));
            by.map(|by| derivative(of, &by)).collect()
        };
        let by_state = derivative(&law.advance, &Variable::State(state).into());
        let mut start = vec![law.start.clone()];
        start.extend(slopes(&law.start));
        let mut step = vec![law.advance.clone(), by_state];
        step.extend(slopes(&law.advance));
        Self {
            parts: law.parts,
            start: Tape::compile(&start, States::Known),
            step: Tape::compile(&step, States::Marched),
            parameters,
        }
    }

    /// The state along a motion; `None` where the times of the samples are not known.
    pub fn along(&self, samples: Samples<'_>, values: &[f64]) -> Option<StateTrajectory> {
        let (v, t) = (samples.velocity, samples.time);
        if v.len() < 2 || t.len() < v.len() {
            return None;
        }
        let mut walk = StateStep::begin(self, v[0], values);
        let usual = t[1] - t[0];
        if samples.cyclic {
            let steps = (0..v.len()).map(|k| Step {
                from: v[k],
                to: v[(k + 1) % v.len()],
                duration: usual,
            });
            walk.take(steps, |_, _| {});
        }
        let mut trajectory = StateTrajectory {
            state: vec![walk.state; v.len()],
            slopes: Vec::new(),
        };
        let mut by: Vec<Vec<f64>> = walk.by.iter().map(|x| vec![*x; v.len()]).collect();
        let steps = (1..v.len()).map(|k| Step {
            from: v[k - 1],
            to: v[k],
            duration: t[k] - t[k - 1],
        });
        let mut at = 1;
        walk.take(steps, |state, slopes| {
            trajectory.state[at] = state;
            for (series, slope) in by.iter_mut().zip(slopes) {
                series[at] = *slope;
            }
            at += 1;
        });
        for (&parameter, series) in self.parameters.iter().zip(by) {
            trajectory.slopes.push(Slopes { parameter, series });
        }
        Some(trajectory)
    }

    /// The state after so many seconds at one velocity.
    pub fn after(&self, velocity: f64, seconds: f64, values: &[f64]) -> f64 {
        /// Parts in which the time goes by, for laws that are not linear in z.
        const STEPS: usize = 256;
        let mut walk = StateStep::begin(self, velocity, values);
        let step = Step {
            from: velocity,
            to: velocity,
            duration: seconds / STEPS as f64,
        };
        walk.take(std::iter::repeat_n(step, STEPS), |_, _| {});
        walk.state
    }
}

/// From one sample to the next.
#[derive(Debug, Clone, Copy)]
struct Step {
    from: f64,
    to: f64,
    duration: f64,
}

/// A state on its way.
struct StateStep<'m> {
    march: &'m March,
    run: crate::chain::effect::formula::tape::Run<'m>,
    state: f64,
    by: Vec<f64>,
}

impl<'m> StateStep<'m> {
    fn begin(march: &'m March, velocity: f64, values: &[f64]) -> Self {
        let mut start = march.start.run(values);
        for place in 0..march.start.inputs().len() {
            start.input(place).fill(velocity);
        }
        start.samples();
        let slopes = 0..march.parameters.len();
        Self {
            state: start.output(0)[0],
            by: slopes.map(|k| start.output(1 + k)[0]).collect(),
            run: march.step.run(values),
            march,
        }
    }

    /// Takes steps, and shows the state and its slopes after each.
    fn take(&mut self, steps: impl Iterator<Item = Step>, mut show: impl FnMut(f64, &[f64])) {
        let parts = self.march.parts;
        let mut steps = steps.peekable();
        let mut together: Vec<Step> = Vec::with_capacity(LANES / parts);
        while steps.peek().is_some() {
            together.clear();
            together.extend(steps.by_ref().take(LANES / parts));
            self.prepare(&together);
            for taken in 0..together.len() {
                for lane in taken * parts..(taken + 1) * parts {
                    self.run.state(lane, self.state);
                    self.state = self.run.output(0)[lane];
                    let by_state = self.run.output(1)[lane];
                    for (k, slope) in self.by.iter_mut().enumerate() {
                        *slope = by_state * *slope + self.run.output(2 + k)[lane];
                    }
                }
                show(self.state, &self.by);
            }
        }
    }

    /// Gives velocities and durations of all parts of some steps.
    fn prepare(&mut self, steps: &[Step]) {
        let parts = self.march.parts;
        for (place, variable) in self.march.step.inputs().iter().enumerate() {
            let register = self.run.input(place);
            for (lane, slot) in register.iter_mut().enumerate() {
                let Some(step) = steps.get(lane / parts) else {
                    break;
                };
                let share = ((lane % parts) as f64 + 0.5) / parts as f64;
                match variable {
                    Variable::Velocity => *slot = step.from + share * (step.to - step.from),
                    Variable::Duration => *slot = step.duration / parts as f64,
                    _ => {}
                }
            }
        }
        self.run.samples();
    }
}
