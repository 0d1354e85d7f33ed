//! Predicts the signal and its derivatives with respect to parameters.
//!
//! Each stage of the chain transforms a value and the columns of its derivatives alike, so that a sum,
//! a product with Vᵀ or a division is written once for both. A column that a channel cannot depend on
//! is absent and costs nothing.
//!
//! Laws without memory are evaluated block by block; a law that has to know the whole motion
//! (bristles, elasticity, play, delay) needs the whole recording at once, [`Evaluator::along`].

mod block;
mod bodies;
mod contact_march;
mod coupling;
mod crosstalk;
mod delay;
mod earlier_motion;
mod known_bodies;
mod lag;
mod loops;
mod march;
mod motor;
mod platform;
mod recorded_joints;
mod rigid;
mod segment;

pub use block::Block;
pub use earlier_motion::EarlierMotion;
pub use known_bodies::KnownBodies;

use crate::chain::crosstalk::Heard;
use crate::chain::effect::tilt::tilted;
use crate::chain::effect::{Law, Memory};
pub use crate::chain::evaluate::segment::{BLOCK, Segment};
use crate::chain::model::{JointModel, Model, Signal};
use crate::chain::parameter::Role;
use crate::robot::batch::{RegressorBatch, Trajectory};
use crate::robot::derivative_batch::DerivativeBatch;
use crate::robot::inertia::PER_LINK;
use crate::robot::tree::Tree;
use nalgebra::{DMatrix, DVector, SMatrix};
use std::borrow::Cow;
use std::ops::Range;
use std::rc::Rc;

/// Evaluates a model over blocks or along recordings; one per thread.
#[derive(Debug)]
pub struct Evaluator<'m> {
    model: &'m Model,
    /// Column of each parameter, if it has one.
    column: Vec<Option<usize>>,
    values: DVector<f64>,
    /// The robot with gravity as the tilt of its base leaves it.
    tree: Cow<'m, Tree>,
    coupling: Option<DMatrix<f64>>,
    transfer: Option<SMatrix<f64, PER_LINK, PER_LINK>>,
    /// Inertial parameters of the links without and with the load.
    bodies: [Rc<[f64]>; 2],
    /// Made when first needed: most evaluations need neither.
    regressor: Option<RegressorBatch>,
    derivatives: Option<DerivativeBatch>,
    /// Whether the samples are the whole of a motion.
    along: bool,
    /// Channels that are asked for; the others are left unfinished.
    wanted: Vec<bool>,
    /// Whose channels hear whom, with the positions of their shares.
    heard: Vec<(Heard, usize)>,
    joint_motion: [Vec<Vec<f64>>; 3],
    /// ∂τ_j/∂q_j and ∂τ_j/∂q̇_j of laws at the joints; empty without such laws.
    stiffness: Vec<Vec<f64>>,
    damping: Vec<Vec<f64>>,
    rigid: Block,
    block: Block,
    scratch: Scratch,
}

#[derive(Debug)]
struct Scratch {
    sign: Vec<f64>,
    by_sign: Vec<f64>,
    by_load: Vec<f64>,
    by_position: Vec<f64>,
    by_velocity: Vec<f64>,
    by_parameter: Vec<Vec<f64>>,
    /// Values of the parameters of one law, borrowed ones behind its own.
    parameters: Vec<f64>,
}

/// For how many samples there is room, and whether they follow one another along a recording.
struct Room {
    samples: usize,
    along: bool,
}

impl<'m> Evaluator<'m> {
    /// An evaluator of `model` at parameter `values`, with derivatives with respect to `columns`
    /// (positions of parameters), over blocks of states. Laws that need the whole motion do not
    /// act: [`Evaluator::along`] has them.
    pub fn new(model: &'m Model, values: &DVector<f64>, columns: &[usize]) -> Self {
        let room = Room {
            samples: BLOCK,
            along: false,
        };
        Self::with_room(model, values, columns, room)
    }

    /// An evaluator over whole recordings of at most `samples` samples.
    pub fn along(
        model: &'m Model,
        values: &DVector<f64>,
        columns: &[usize],
        samples: usize,
    ) -> Self {
        let room = Room {
            samples,
            along: true,
        };
        Self::with_room(model, values, columns, room)
    }

    fn with_room(model: &'m Model, values: &DVector<f64>, columns: &[usize], room: Room) -> Self {
        let Room {
            samples: room,
            along,
        } = room;
        let (n, channels) = (model.tree().len(), model.channels().len());
        let rows = model.signal().rows();
        let mut column = vec![None; model.parameters().len()];
        for (k, &parameter) in columns.iter().enumerate() {
            column[parameter] = Some(k);
        }
        // The column of a shared parameter is the sum over all joints that have it.
        for parameter in 0..column.len() {
            column[parameter] = column[model.estimated_as(parameter)];
        }
        let mut values = values.clone();
        model.spread(&mut values);
        let values = &values;
        let tree = match model.tilt() {
            None => Cow::Borrowed(model.tree()),
            Some(at) => {
                let gravity = tilted(&model.tree().gravity(), [values[at], values[at + 1]]);
                Cow::Owned(model.tree().clone().with_gravity(gravity.into()))
            }
        };
        let has_joint_laws = model.joints().iter().any(|joint| {
            joint
                .effects
                .iter()
                .any(|(e, _)| matches!(e.law, Law::Joint(_)))
        });
        let motion = || vec![vec![0.0; room]; n];
        Self {
            model,
            column,
            values: values.clone(),
            coupling: (!model.is_uncoupled()).then(|| model.coupling(values)),
            transfer: model.payload().map(|(payload, _)| payload.transfer()),
            bodies: [false, true].map(|loaded| bodies(model, values, loaded).into()),
            regressor: None,
            derivatives: None,
            along,
            wanted: model.channels().iter().map(|c| c.active).collect(),
            heard: model.heard().collect(),
            joint_motion: [motion(), motion(), motion()],
            stiffness: if has_joint_laws { motion() } else { Vec::new() },
            damping: if has_joint_laws { motion() } else { Vec::new() },
            rigid: Block::new(rows.count(n), columns.len(), room),
            block: Block::new(channels, columns.len(), room),
            scratch: Scratch {
                sign: vec![0.0; room],
                by_sign: vec![0.0; room],
                by_load: vec![0.0; room],
                by_position: vec![0.0; room],
                by_velocity: vec![0.0; room],
                by_parameter: vec![vec![0.0; room]; PER_LINK],
                parameters: Vec::with_capacity(PER_LINK),
            },
            tree,
        }
    }

    /// The signal of the samples of `range` (at most [`BLOCK`]) and its derivatives.
    pub fn evaluate(&mut self, segment: Segment<'_>, range: Range<usize>) -> &Block {
        self.states(segment, range);
        &self.block
    }

    /// The signal along a whole recording and its derivatives.
    pub fn evaluate_whole(&mut self, segment: Segment<'_>) -> &Block {
        let range = 0..segment.motors.len();
        let delayed = self
            .model
            .joints()
            .iter()
            .any(|joint| joint.delay.is_some());
        if delayed && self.along && !segment.time.is_empty() {
            self.delayed(segment);
        } else {
            self.states(segment, range);
        }
        &self.block
    }

    fn states(&mut self, segment: Segment<'_>, range: Range<usize>) {
        match self.transfer_of_recorded() {
            None => self.states_of_motors(segment, range.clone()),
            Some(transfer) => {
                let [q, dq, ddq] = Self::motors(&transfer, segment.motors, range.clone());
                let temperature: Vec<Vec<f64>> = (0..segment.temperature.len())
                    .map(|j| segment.temperatures(j, range.clone()).to_vec())
                    .collect();
                let moved = Segment {
                    temperature: &temperature,
                    motors: Trajectory {
                        q: &q,
                        dq: &dq,
                        ddq: &ddq,
                    },
                    time: segment.times(range.clone()),
                    commands: segment.commands.map(|all| all.later(range.start)),
                    ..segment
                };
                self.states_of_motors(moved, 0..range.len());
            }
        }
        self.entry_columns(segment, range);
        self.block.settle();
    }

    fn states_of_motors(&mut self, segment: Segment<'_>, range: Range<usize>) {
        let samples = range.len();
        self.block.clear(samples);
        self.rigid.clear(samples);
        let known = segment.bodies.filter(|known| self.are_known(known));
        let settled = known.and_then(|known| known.joints.as_ref());
        let lag = match settled {
            Some(joints) => {
                self.take_joints(joints, range.clone());
                None
            }
            None => {
                if known.is_none() || self.is_motion_asked_for() {
                    self.move_joints(segment.motors, range.clone());
                }
                self.lag_of_links(segment, samples)
            }
        };
        let moved = Segment {
            bodies: known.filter(|_| lag.is_none()),
            ..segment
        };
        self.rigid_body(moved, range.clone());
        self.push_links(segment.forces, range.clone());
        self.tilt_columns(segment.loaded, samples);
        self.joint_laws(segment, range.clone());
        self.add_motion_columns(segment, range.clone());
        if let Some(lag) = lag {
            self.lag_columns(&lag, samples);
        }
        self.spin_rotors(segment.motors, range.clone());
        self.close_loops(samples);
        self.carry_to_motors();
        if let Some(known) = moved.bodies {
            self.take_columns(known, range.clone());
        }
        self.add_tare();
        self.coupling_torque_columns(samples);
        for j in 0..self.model.joints().len() {
            if self.channel_of(j).is_some() && self.is_needed(j) {
                self.motor_sign(j, segment.motors, range.clone());
                self.transmission(j, segment, range.clone());
                self.motor_laws(j, segment, range.clone());
                self.signal_laws(j, segment, range.clone());
                self.width_column(j, segment.motors, range.clone());
                self.carry_to_signal(j, segment, range.clone());
            }
        }
        self.hear_others(samples);
    }

    /// Whether something beside the bodies asks where the joints are.
    fn is_motion_asked_for(&self) -> bool {
        let model = self.model;
        model.tilt().is_some()
            || model.mechanism().is_some()
            || model.joints().iter().any(JointModel::has_lag)
            || self.wrench_row().is_some()
            || !self.stiffness.is_empty()
            || !self.motion_columns().is_empty()
    }

    /// Joint torques come first among the channels, if they are measured at all.
    fn channel_of(&self, joint: usize) -> Option<usize> {
        self.model.channels().get(joint)?.joint
    }

    /// Rows of joint torques among those of the rigid body.
    fn torque_rows(&self) -> usize {
        match self.model.signal() {
            Signal::BaseWrench => 0,
            _ => self.model.joints().len(),
        }
    }

    fn trajectory(&self) -> Trajectory<'_> {
        let [q, dq, ddq] = &self.joint_motion;
        Trajectory { q, dq, ddq }
    }

    /// Entries of V that have a column: (column, row of V, column of V).
    fn coupling_entries(&self) -> Vec<(usize, usize, usize)> {
        let parameters = self.model.parameters().iter().enumerate();
        parameters
            .filter_map(|(p, parameter)| match parameter.role {
                Role::Coupling { row, column } => Some((self.column[p]?, row, column)),
                _ => None,
            })
            .collect()
    }

    /// Whether an effect acts on the samples at hand.
    fn acts(&self, memory: Memory) -> bool {
        self.along || memory != Memory::WholeMotion
    }
}

/// Inertial parameters of all links, the load added to its link where it is carried.
pub fn bodies(model: &Model, values: &DVector<f64>, loaded: bool) -> Vec<f64> {
    let count = PER_LINK * model.tree().len();
    let mut bodies = values.as_slice()[..count].to_vec();
    if let (Some((payload, first)), true) = (model.payload(), loaded) {
        let load = SMatrix::<f64, PER_LINK, 1>::from_fn(|k, _| values[first + k]);
        let seen = payload.transfer() * load;
        for k in 0..PER_LINK {
            bodies[PER_LINK * payload.link + k] += seen[k];
        }
    }
    bodies
}
