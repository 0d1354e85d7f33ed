//! Forward dynamics under a computed-torque controller that follows the trajectory.
//!
//! ```text
//! u = chain_nominal(m_d, ṁ_d, m̈_d + 2ω (ṁ_d − ṁ) + ω² (m_d − m))
//! ```
//!
//! The controller sees the true state and knows the declared effects only; it commands at its ticks and
//! the torque is held between them. At a tick the torque jumps, and the acceleration recorded there is
//! the mean of its two limits: the recorded signal is then the mean of the torques commanded before and
//! after, which is the torque of a drive averaged over the tick, and free of half a tick of delay.

use crate::chain::model::Model;
use crate::fault::Place;
use crate::problem::solution::Control;
use crate::simulate::error::{SimulateError, SimulateErrorKind};
use crate::simulate::path::{Instants, Motion, Path};
use crate::simulate::plant::{Linearised, NoAcceleration, Plant, State, Step};
use crate::simulate::truth::DEFAULT_WIDTH;

/// Lowest rate of the controller, Hz: that of usual position loops.
pub const CONTROL_RATE: f64 = 1000.0;

/// Bandwidth of the controller, rad/s: critically damped, 16 Hz, as stiff position loops have it.
const BANDWIDTH: f64 = 100.0;

/// Local error of a speed over one step, as a share of the narrowest w. A reversal passes the band of
/// speeds in which friction turns over within fractions of a millisecond; steps that err by a twentieth
/// of its width resolve the passage, and the smooth motion between reversals takes one step per tick.
const SHARE_OF_WIDTH: f64 = 0.05;

/// Halvings of a tick. A narrower passage is a jump within one step of a quarter of a microsecond, which
/// an L-stable method survives without oscillation.
const MOST_HALVINGS: u32 = 12;

/// Distance from the trajectory that no controller comes back from, rad or m.
const LOST: f64 = 3.0;

/// Ticks of the trajectory that are looked up at once, and between looks at the interrupt.
const CHUNK: usize = 512;

/// How long and how often.
#[derive(Debug, Clone, Copy)]
pub struct Schedule {
    /// Hz of the recording.
    pub rate: f64,
    /// Samples of the recording.
    pub samples: usize,
    /// s before the recording.
    pub warmup: f64,
}

impl Schedule {
    /// Ticks of the controller per sample.
    fn ticks_per_sample(&self) -> usize {
        (CONTROL_RATE / self.rate).ceil().max(1.0) as usize
    }
}

/// What is controlled, and by what.
#[derive(Debug, Clone, Copy)]
pub struct Loop<'a> {
    pub plant: &'a Model,
    pub nominal: &'a Model,
    /// Of the motors at joint scale.
    pub path: &'a Path,
    pub loaded: bool,
    pub place: &'a Place,
}

impl Loop<'_> {
    /// The motion of the motors at the samples of the recording.
    ///
    /// # Errors
    /// A singular mass matrix, friction that jumps at standstill, a motion that diverges, an interrupt.
    pub fn run(&self, schedule: Schedule, control: &Control<'_>) -> Result<Motion, SimulateError> {
        let every = schedule.ticks_per_sample();
        let rate = schedule.rate * every as f64;
        let tolerance = self.tolerance()?;
        let before = (schedule.warmup * rate).round() as usize;
        let ticks = before + (schedule.samples.max(1) - 1) * every + 1;
        let n = self.plant.joints().len();
        let mut motion: Motion = std::array::from_fn(|_| vec![Vec::new(); n]);
        let mut runner = Runner::new(self, [1.0 / rate, tolerance])?;
        for start in (0..ticks).step_by(CHUNK) {
            if control.is_interrupted() {
                return Err(self.fault(SimulateErrorKind::Interrupted));
            }
            let count = CHUNK.min(ticks - start);
            let desired = self.path.sample(Instants {
                start: start as f64 / rate,
                rate,
                count,
            });
            for tick in start..start + count {
                let at = |order: usize| -> Vec<f64> {
                    desired[order]
                        .iter()
                        .map(|joint| joint[tick - start])
                        .collect()
                };
                let goal = [at(0), at(1), at(2)];
                if tick == 0 {
                    runner.state = State {
                        position: goal[0].clone(),
                        velocity: goal[1].clone(),
                    };
                }
                let time = tick as f64 / rate;
                let acceleration = runner.tick(&goal).map_err(|e| self.stopped(e, time))?;
                self.check(&runner, &goal[0], time)?;
                if tick >= before && (tick - before).is_multiple_of(every) {
                    runner.record(&acceleration, &mut motion);
                }
                runner.advance().map_err(|e| self.stopped(e, time))?;
            }
        }
        Ok(motion)
    }

    fn fault(&self, kind: SimulateErrorKind) -> SimulateError {
        SimulateError::new(self.place, kind)
    }

    fn name(&self, joint: usize) -> String {
        self.plant.joints()[joint].name.clone()
    }

    fn stopped(&self, error: NoAcceleration, time: f64) -> SimulateError {
        self.fault(match error {
            NoAcceleration::SingularMass { joint, pivot } => SimulateErrorKind::SingularMass {
                joint: self.name(joint),
                pivot,
            },
            NoAcceleration::Open(error) => SimulateErrorKind::OpenLoops {
                time,
                reason: error.to_string(),
            },
        })
    }

    fn check(&self, runner: &Runner, goal: &[f64], time: f64) -> Result<(), SimulateError> {
        let distance = |j: usize| (runner.state.position[j] - goal[j]).abs();
        // Also found where the position is not a number.
        let lost = (0..goal.len()).find(|&j| {
            let near = distance(j) <= LOST;
            !near
        });
        match lost {
            None => Ok(()),
            Some(j) => Err(self.fault(SimulateErrorKind::Diverged {
                joint: self.name(j),
                time,
            })),
        }
    }

    /// Largest local error of a speed, rad/s or m/s: 5 % of the narrowest w.
    fn tolerance(&self) -> Result<f64, SimulateError> {
        let mut narrowest = DEFAULT_WIDTH;
        for joint in self.plant.joints().iter().filter(|joint| !joint.locked) {
            let Some(width) = joint.width else { continue };
            let width = self.plant.parameters()[width].value;
            if width == 0.0 {
                let joint = joint.name.clone();
                return Err(self.fault(SimulateErrorKind::SharpFriction { joint }));
            }
            narrowest = narrowest.min(width);
        }
        Ok(SHARE_OF_WIDTH * narrowest)
    }
}

/// The loop while it runs.
struct Runner<'m> {
    plant: Plant<'m>,
    nominal: Plant<'m>,
    state: State,
    chain: Option<Linearised>,
    command: Vec<f64>,
    /// Command of the tick before.
    held: Option<Vec<f64>>,
    /// Between two ticks, s.
    interval: f64,
    tolerance: f64,
}

impl<'m> Runner<'m> {
    fn new(of: &Loop<'m>, [interval, tolerance]: [f64; 2]) -> Result<Self, SimulateError> {
        let plant = Plant::new(of.plant, of.loaded);
        let nominal = Plant::new(of.nominal, of.loaded);
        let (Some(plant), Some(nominal)) = (plant, nominal) else {
            let joints = of.plant.joints().len();
            let kind = SimulateErrorKind::TooManyJoints { found: joints };
            return Err(of.fault(kind));
        };
        let n = of.plant.joints().len();
        Ok(Self {
            command: vec![0.0; plant.moving().len()],
            plant,
            nominal,
            state: State {
                position: vec![0.0; n],
                velocity: vec![0.0; n],
            },
            chain: None,
            held: None,
            interval,
            tolerance,
        })
    }

    /// Commands the torque of a tick; returns the mean of the accelerations before and after it.
    fn tick(&mut self, [q, dq, ddq]: &[Vec<f64>; 3]) -> Result<Vec<f64>, NoAcceleration> {
        let mut wanted = ddq.clone();
        for &j in self.plant.moving() {
            let (lag, slip) = (
                q[j] - self.state.position[j],
                dq[j] - self.state.velocity[j],
            );
            wanted[j] += 2.0 * BANDWIDTH * slip + BANDWIDTH * BANDWIDTH * lag;
        }
        let mut command = vec![0.0; self.command.len()];
        self.nominal.torque([q, dq, &wanted], &mut command)?;
        let before = self
            .held
            .replace(command.clone())
            .unwrap_or(command.clone());
        self.command = command;
        let chain = self.plant.linearise(&self.state)?;
        let mean: Vec<f64> = before
            .iter()
            .zip(&self.command)
            .map(|(a, b)| 0.5 * (a + b))
            .collect();
        let acceleration = self.plant.acceleration(&chain, &mean)?;
        self.chain = Some(chain);
        Ok(acceleration)
    }

    /// Integrates to the next tick. Steps are the interval halved as often as the error wants it.
    fn advance(&mut self) -> Result<(), NoAcceleration> {
        let (mut halvings, mut done) = (0, 0);
        let whole = 1_u32 << MOST_HALVINGS;
        while done < whole {
            let chain = match self.chain.take() {
                Some(chain) => chain,
                None => self.plant.linearise(&self.state)?,
            };
            let share = whole >> halvings;
            let h = self.interval * f64::from(share) / f64::from(whole);
            let Step { state: next, error } =
                self.plant.step(&self.state, &chain, &self.command, h)?;
            if error > self.tolerance && halvings < MOST_HALVINGS {
                halvings += 1;
                self.chain = Some(chain);
                continue;
            }
            self.state = next;
            done += share;
            // A step of twice the length has four times the error, and must end on a tick.
            let fits = halvings > 0 && done.is_multiple_of(2 * share);
            if fits && 4.0 * error <= self.tolerance {
                halvings -= 1;
            }
        }
        Ok(())
    }

    fn record(&self, acceleration: &[f64], motion: &mut Motion) {
        let mut all = vec![0.0; self.state.position.len()];
        for (value, &j) in acceleration.iter().zip(self.plant.moving()) {
            all[j] = *value;
        }
        let now = [&self.state.position, &self.state.velocity, &all];
        for (series, values) in motion.iter_mut().zip(now) {
            for (joint, value) in series.iter_mut().zip(values) {
                joint.push(*value);
            }
        }
    }
}
