//! A model of a robot with its drives: every parameter by name, known or free.

use crate::chain::assemble;
use crate::chain::controller::Controller;
use crate::chain::effect::{
    Catalogue, Effect, Law, Memory, ParameterInfo, coulomb_friction, torque_current_nonlinearity,
    viscous_friction,
};
use crate::chain::error::ModelError;
use crate::chain::parameter::{Parameter, Role, State};
use crate::chain::platform::Platform;
use crate::mechanism::loops::Mechanism;
use crate::robot::description::Dependent;
use crate::robot::inertia::{Inertia, PER_LINK, QUANTITIES, UNITS};
use crate::robot::regressor::Rows;
use crate::robot::tree::{JointKind, Tree};
use crate::stats::range::within;
use nalgebra::{DMatrix, DVector, Isometry3, SMatrix};

/// What the signal is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    /// Motor currents, A.
    Current,
    /// Motor torques at joint scale, N·m or N.
    Torque,
    /// Torques of sensors behind the gears: rotors are not in them.
    LinkTorque,
    /// Force and moment of the base on the first link, N and N·m.
    BaseWrench,
    /// Motor torques, then base wrench.
    Both,
    /// Errors of position controllers, command minus position, rad or m.
    PositionCommand,
}

impl Signal {
    /// Rows of the rigid-body regressor that the signal needs.
    pub fn rows(self) -> Rows {
        match self {
            Self::Current | Self::Torque | Self::LinkTorque | Self::PositionCommand => Rows::Torque,
            Self::BaseWrench => Rows::Base,
            Self::Both => Rows::Both,
        }
    }
}

/// One measured series.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Name of the joint, or of the component of the wrench.
    pub name: String,
    pub unit: &'static str,
    /// Joint of a torque or current; `None` for a component of the wrench.
    pub joint: Option<usize>,
    /// Locked joints and their motors are not predicted.
    pub active: bool,
}

/// Names and units of the components of a wrench.
pub(super) const WRENCH: [(&str, &str); 6] = [
    ("fx", "N"),
    ("fy", "N"),
    ("fz", "N"),
    ("mx", "N·m"),
    ("my", "N·m"),
    ("mz", "N·m"),
];

/// A load on a link, in a frame that is fixed to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Payload {
    pub link: usize,
    /// Placement of the load's frame in the link's frame.
    pub frame: Isometry3<f64>,
}

impl Payload {
    /// T with `π_link = T π_payload` (10 x 10): the load's parameters seen from the link's frame.
    pub fn transfer(&self) -> SMatrix<f64, PER_LINK, PER_LINK> {
        let rotation = self.frame.rotation.to_rotation_matrix();
        let mut transfer = SMatrix::<f64, PER_LINK, PER_LINK>::zeros();
        for k in 0..PER_LINK {
            let mut unit = Inertia::default();
            unit.0[k] = 1.0;
            let seen = unit.seen_from(&rotation, &self.frame.translation.vector);
            transfer.set_column(k, &SMatrix::<f64, PER_LINK, 1>::from(seen.0));
        }
        transfer
    }
}

/// Whether the links' inertial parameters are known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Inertials {
    Estimate,
    Known,
}

/// What a model is built from; arrays have one entry per joint.
#[derive(Debug, Clone)]
pub struct ModelSettings {
    pub tree: Tree,
    pub signal: Signal,
    pub inertials: Inertials,
    /// Position controllers, where the signal is their error.
    pub controllers: Option<Vec<Controller>>,
    /// N·m/A at joint scale; `None` where the signal is a torque.
    pub torque_constant: Option<Vec<f64>>,
    /// Relative standard deviations of the torque constants.
    pub torque_constant_std: Option<Vec<f64>>,
    /// c0 to c3 of the torque in powers of the current, instead of the torque constant.
    pub current_polynomial: Option<Vec<[f64; torque_current_nonlinearity::COEFFICIENTS]>>,
    /// Known rotor inertias, kg·m² at joint scale.
    pub rotor_inertia: Option<Vec<f64>>,
    /// V of `q = V m + offset`; `None` is the identity.
    pub coupling: Option<DMatrix<f64>>,
    pub offset: Option<Vec<f64>>,
    pub effects: Vec<Vec<&'static Effect>>,
    /// The effects that it may have.
    pub catalogue: Catalogue,
    /// s, after which the motion is declared to repeat.
    pub period: Option<f64>,
    pub payload: Option<Payload>,
    /// Joints that stand still.
    pub locked: Vec<bool>,
}

impl ModelSettings {
    /// Bodies that are estimated and nothing else: no drive, no effect, no load, every joint free to move.
    pub fn bodies(tree: Tree, signal: Signal) -> Self {
        let n = tree.len();
        Self {
            tree,
            signal,
            inertials: Inertials::Estimate,
            controllers: None,
            torque_constant: None,
            torque_constant_std: None,
            current_polynomial: None,
            rotor_inertia: None,
            coupling: None,
            offset: None,
            effects: vec![Vec::new(); n],
            catalogue: Catalogue::known(),
            period: None,
            payload: None,
            locked: vec![false; n],
        }
    }
}

/// A joint with its drive.
#[derive(Debug, Clone)]
pub struct JointModel {
    pub name: String,
    pub kind: JointKind,
    pub torque_constant: f64,
    /// Relative; 0 where the constant is certain.
    pub torque_constant_std: f64,
    pub locked: bool,
    /// Effects and the position of their first parameter in the model's list.
    pub effects: Vec<(&'static Effect, usize)>,
    /// Positions of the parameters that each effect borrows from others.
    pub borrowed: Vec<Vec<usize>>,
    /// Joints whose motion each effect knows beside its own.
    pub others: Vec<Vec<usize>>,
    /// Whether another effect takes the place of each effect's torque.
    pub replaced: Vec<bool>,
    /// Position of the transition speed w of Coulomb friction, if the joint has it.
    pub width: Option<usize>,
    /// Position of the gain, if the joint has one.
    pub gain: Option<usize>,
    /// Position of c0 of the current's polynomial, if the joint has one.
    pub polynomial: Option<usize>,
    /// Position of the proportional gain of the controller (the derivative gain is behind it), if the joint has one.
    pub controller: Option<usize>,
    /// Position of the delay, if the joint has one.
    pub delay: Option<usize>,
    /// Position of the stiffness (the damping is behind it), if the joint is elastic.
    pub elasticity: Option<usize>,
    /// Position of the play, if the joint has one.
    pub backlash: Option<usize>,
    /// Position of the offset of the encoder, if the joint has one.
    pub encoder: Option<usize>,
    /// N·m (N) of transmitted torque about zero within which the switch of losses is rounded off; 0: not at all.
    pub rounding: f64,
}

impl JointModel {
    /// Whether the link lags behind the motor.
    pub fn has_lag(&self) -> bool {
        self.elasticity.is_some() || self.backlash.is_some()
    }

    /// What is known of the parameters of one of its effects, with their positions in the model's list; none of an effect
    /// that it does not have.
    pub fn parameters_of(&self, id: &str) -> impl Iterator<Item = (&'static ParameterInfo, usize)> {
        let found = self.effects.iter().find(|(effect, _)| effect.id == id);
        let own =
            |&(effect, first): &(&'static Effect, usize)| effect.parameters.iter().zip(first..);
        found.map(own).into_iter().flatten()
    }
}

/// A robot with its drives and all parameters.
#[derive(Debug, Clone)]
pub struct Model {
    tree: Tree,
    signal: Signal,
    channels: Vec<Channel>,
    joints: Vec<JointModel>,
    catalogue: Catalogue,
    period: Option<f64>,
    coupling: DMatrix<f64>,
    offset: DVector<f64>,
    payload: Option<(Payload, usize)>,
    /// Position of the roll of the base (the pitch is behind it), if it is in the model.
    tilt: Option<usize>,
    platform: Platform,
    tare: Option<usize>,
    /// V by which recorded positions of joints became those of motors.
    reference: Option<DMatrix<f64>>,
    mechanism: Option<Mechanism>,
    dependents: Vec<Dependent>,
    parameters: Vec<Parameter>,
}

impl Model {
    pub fn new(settings: ModelSettings) -> Result<Self, ModelError> {
        let n = settings.tree.len();
        let mut parameters = assemble::inertial_parameters(&settings);
        let coupling = settings
            .coupling
            .clone()
            .unwrap_or_else(|| DMatrix::identity(n, n));
        if coupling.clone().try_inverse().is_none() {
            return Err(ModelError::SingularCoupling);
        }
        let joints = (0..n)
            .map(|j| assemble::joint_model(&settings, j, &mut parameters))
            .collect::<Result<Vec<_>, _>>()?;
        let joints = assemble::controlled(&settings, joints, &mut parameters);
        assemble::coupling_parameters(&settings, &coupling, &mut parameters);
        let tilt = assemble::tilt_parameters(&settings, &mut parameters);
        let payload = settings.payload.map(|payload| {
            let first = parameters.len();
            let entries = QUANTITIES.iter().zip(UNITS).enumerate();
            parameters.extend(entries.map(|(quantity, (entry, unit))| {
                let role = Role::Payload { quantity };
                assemble::unbounded(format!("payload.{entry}"), unit, role)
            }));
            (payload, first)
        });
        Ok(Self {
            channels: assemble::channels(&settings),
            signal: settings.signal,
            joints,
            catalogue: settings.catalogue,
            period: settings.period,
            coupling,
            offset: DVector::from_vec(settings.offset.unwrap_or_else(|| vec![0.0; n])),
            payload,
            tilt,
            platform: Platform::default(),
            tare: None,
            reference: None,
            mechanism: None,
            dependents: Vec::new(),
            parameters,
            tree: settings.tree,
        })
    }

    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    pub fn signal(&self) -> Signal {
        self.signal
    }

    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Predicts no other channel than one.
    pub fn predict_only(&mut self, channel: usize) {
        for (c, other) in self.channels.iter_mut().enumerate() {
            other.active &= c == channel;
        }
    }

    pub fn joints(&self) -> &[JointModel] {
        &self.joints
    }

    /// The effects that the model may have.
    pub fn catalogue(&self) -> &Catalogue {
        &self.catalogue
    }

    /// s, after which the motion is declared to repeat.
    pub fn period(&self) -> Option<f64> {
        self.period
    }

    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// The load and the position of its first parameter.
    pub fn payload(&self) -> Option<(Payload, usize)> {
        self.payload
    }

    /// Position of the roll of the base; the pitch is behind it.
    pub fn tilt(&self) -> Option<usize> {
        self.tilt
    }

    /// What the effects of the model have to know of the past: the most of any.
    pub fn memory(&self) -> Memory {
        let active = self.joints.iter().filter(|joint| !joint.locked);
        let all = active.flat_map(|joint| joint.effects.iter().map(|(e, _)| e.needs.memory));
        all.fold(Memory::None, |most, next| match (most, next) {
            (Memory::Course, _) | (_, Memory::Course) => Memory::Course,
            (Memory::Time, _) | (_, Memory::Time) => Memory::Time,
            _ => Memory::None,
        })
    }

    /// Whether the signal is affine in all linear parameters together while the others are fixed.
    pub fn is_affine(&self) -> bool {
        let mut effects = self.joints.iter().flat_map(|joint| &joint.effects);
        effects.all(|(effect, _)| effect.law.keeps_affine())
    }

    /// Whether the slope of some loss jumps where the transmitted torque changes sign.
    pub fn has_switches(&self) -> bool {
        let active = self.joints.iter().filter(|joint| !joint.locked);
        let mut effects = active.flat_map(|joint| &joint.effects);
        effects.any(|(effect, _)| matches!(effect.law, Law::Transmission(_)))
    }

    /// The same model with these switches rounded off, N·m (N) of transmitted torque of each joint.
    pub fn rounded(mut self, widths: &[f64]) -> Self {
        for (joint, width) in self.joints.iter_mut().zip(widths) {
            joint.rounding = *width;
        }
        self
    }

    /// What the base wrench is read by.
    pub fn platform(&self) -> &Platform {
        &self.platform
    }

    /// Puts the robot on a platform.
    pub fn stand_on(&mut self, platform: Platform) {
        self.platform = platform;
    }

    /// Position of the parameter that is an entry of V.
    pub fn coupling_position(&self, row: usize, column: usize) -> Option<usize> {
        let here = Role::Coupling { row, column };
        self.parameters.iter().position(|p| p.role == here)
    }

    /// V by which recorded positions of joints became those of motors; `None` where motors were recorded.
    pub fn reference(&self) -> Option<&DMatrix<f64>> {
        self.reference.as_ref()
    }

    /// States that positions of joints were recorded and became `m = V⁻¹ (q − offset)` by this V: whatever V an
    /// estimate tries, the joints stay where they were recorded.
    pub fn record_joints(&mut self, reference: DMatrix<f64>) {
        self.reference = Some(reference);
    }

    /// Position of the first of the six parameters of the tare, if it is in the model.
    pub fn tare(&self) -> Option<usize> {
        self.tare
    }

    /// Adds what the platform reads without the robot: six unknowns, where the signal has a base wrench.
    pub fn add_tare(&mut self) {
        if self.signal.rows() == Rows::Torque || self.tare.is_some() {
            return;
        }
        self.tare = Some(self.parameters.len());
        let components = WRENCH.iter().enumerate();
        self.parameters
            .extend(components.map(|(component, &(name, unit))| {
                assemble::unbounded(format!("platform.{name}"), unit, Role::Tare { component })
            }));
    }

    /// The loops that the joints close, if there are any.
    pub fn mechanism(&self) -> Option<&Mechanism> {
        self.mechanism.as_ref()
    }

    /// Closes the loops of a mechanism with the model's joints. Links that weigh nothing become known.
    pub fn close(&mut self, mechanism: Mechanism) {
        for (first, link) in (0..).step_by(PER_LINK).zip(0..self.tree.len()) {
            if mechanism.is_massless(link) {
                for parameter in &mut self.parameters[first..first + PER_LINK] {
                    parameter.value = 0.0;
                    parameter.state = State::Known;
                }
            }
        }
        self.mechanism = Some(mechanism);
    }

    /// Lets joints without a motor of their own follow others: their rows of V are those of their leaders times the
    /// multiplier, so that `Vᵀ` brings their torques to the motors of the leaders.
    pub fn follow(&mut self, dependents: &[Dependent]) {
        self.dependents = dependents.to_vec();
        follow_leaders(&mut self.coupling, dependents);
    }

    /// A V of joints with motors, with the rows of those that follow others.
    pub fn with_followers(&self, mut coupling: DMatrix<f64>) -> DMatrix<f64> {
        follow_leaders(&mut coupling, &self.dependents);
        coupling
    }

    /// The joints that move with one, itself first, each with its speed per speed of that one.
    pub fn moved_with(&self, joint: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let behind = self.dependents.iter().filter(move |d| d.leader == joint);
        std::iter::once((joint, 1.0)).chain(behind.map(|d| (d.joint, d.multiplier)))
    }

    /// What is declared of `q = V m + offset`.
    pub fn offset(&self) -> &DVector<f64> {
        &self.offset
    }

    /// Where a joint stands beyond `V m + offset` at the given parameter values: the offset of its encoder, and of its leader's
    /// where it follows one.
    pub fn encoder_offset(&self, joint: usize, values: &DVector<f64>) -> f64 {
        let own = |j: usize| self.joints[j].encoder.map_or(0.0, |at| values[at]);
        let followed = self.dependents.iter().find(|d| d.joint == joint);
        followed.map_or(own(joint), |d| d.multiplier * own(d.leader))
    }

    /// Whether what bodies do along a motion of the motors changes with a parameter that is none of theirs: it moves the
    /// joints, or turns gravity.
    pub fn moves_bodies(&self, parameter: usize) -> bool {
        match self.parameters[parameter].role {
            Role::Coupling { .. } | Role::Tilt { .. } => true,
            Role::Effect { joint, .. } => self.joints[joint].encoder == Some(parameter),
            _ => false,
        }
    }

    /// Values of all parameters: known ones, and those that estimates start from.
    pub fn values(&self) -> DVector<f64> {
        DVector::from_iterator(
            self.parameters.len(),
            self.parameters.iter().map(|p| p.value),
        )
    }

    /// Values at which no torque vanishes: known ones, and for linear unknowns that start from zero those of
    /// the robot file, of a usual body, or typical ones. Where losses or currents depend on torque, what the
    /// signal depends on shows only there.
    pub fn generic_values(&self) -> DVector<f64> {
        /// 2 kg, centre of mass 0.1 m off the axis.
        const BODY: [f64; PER_LINK] = [2.0, 0.2, -0.15, 0.25, 0.06, 0.01, 0.07, -0.02, 0.015, 0.05];
        let of = |parameter: &Parameter| {
            if !parameter.is_linear_unknown() || parameter.value != 0.0 {
                return parameter.value;
            }
            match parameter.role {
                Role::Inertial { link, quantity } => {
                    let declared = self.tree.joints()[link].inertia;
                    match declared.mass() > 0.0 {
                        true => declared.0[quantity],
                        false => BODY[quantity],
                    }
                }
                Role::Payload { quantity } => BODY[quantity],
                _ => parameter.scale,
            }
        };
        DVector::from_iterator(self.parameters.len(), self.parameters.iter().map(of))
    }

    /// Position of a parameter by name.
    pub fn find(&self, name: &str) -> Result<usize, ModelError> {
        let found = self.parameters.iter().position(|p| p.name == name);
        found.ok_or_else(|| ModelError::UnknownParameter {
            name: name.to_string(),
            nearest: self.nearest(name),
        })
    }

    fn nearest(&self, name: &str) -> Option<String> {
        let similarity = |p: &&Parameter| (1e6 * strsim::jaro_winkler(&p.name, name)) as u64;
        self.parameters
            .iter()
            .max_by_key(similarity)
            .map(|p| p.name.clone())
    }

    /// Makes a parameter known.
    pub fn fix(&mut self, index: usize, value: f64) -> Result<(), ModelError> {
        let parameter = &mut self.parameters[index];
        if !(parameter.lower..=parameter.upper).contains(&value) {
            return Err(ModelError::OutOfBounds {
                name: parameter.name.clone(),
                value,
                lower: parameter.lower,
                upper: parameter.upper,
            });
        }
        parameter.value = value;
        parameter.state = State::Known;
        Ok(())
    }

    /// Sets the value from which an estimate of a free parameter starts.
    pub fn start(&mut self, index: usize, value: f64) {
        let parameter = &mut self.parameters[index];
        parameter.value = within(value, [parameter.lower, parameter.upper]);
    }

    /// Narrows the bounds of a parameter.
    pub fn bound(&mut self, index: usize, lower: f64, upper: f64) {
        let parameter = &mut self.parameters[index];
        (parameter.lower, parameter.upper) = (lower, upper);
        parameter.bounded = true;
        parameter.value = within(parameter.value, [lower, upper]);
    }

    /// Narrows the transitions of Coulomb friction to what motions show whose joints move at most so fast, rad/s or m/s at
    /// joint scale: a friction that has not come to [`coulomb_friction::SEEN`] of Fc anywhere is none of constant size, and its
    /// Fc would be extrapolated. A joint without viscous friction keeps its limits, for there a wide transition stands for it.
    /// Limits and values that were stated stay.
    pub fn limit_transitions(&mut self, fastest: &[f64]) {
        let widths = self.joints.iter().zip(fastest);
        let widths: Vec<(usize, f64)> = widths
            .filter(|(joint, _)| {
                joint
                    .parameters_of(viscous_friction::EFFECT.id)
                    .next()
                    .is_some()
            })
            .filter_map(|(joint, fastest)| Some((joint.width?, coulomb_friction::widest(*fastest))))
            .collect();
        for (index, widest) in widths {
            let parameter = &mut self.parameters[index];
            if parameter.is_free() && !parameter.bounded {
                parameter.upper = parameter.upper.min(widest);
                parameter.value = within(parameter.value, [parameter.lower, parameter.upper]);
            }
        }
    }

    /// V at the given parameter values.
    pub fn coupling(&self, values: &DVector<f64>) -> DMatrix<f64> {
        let mut coupling = self.coupling.clone();
        for (value, parameter) in values.iter().zip(&self.parameters) {
            if let Role::Coupling { row, column } = parameter.role {
                coupling[(row, column)] = *value;
            }
        }
        self.with_followers(coupling)
    }

    /// True where V is the identity whatever the parameters are.
    pub fn is_uncoupled(&self) -> bool {
        let n = self.joints.len();
        self.coupling == DMatrix::identity(n, n)
            && !self
                .parameters
                .iter()
                .any(|p| matches!(p.role, Role::Coupling { .. }))
    }
}

/// Rows of V of joints that follow others; their own motors stand still.
fn follow_leaders(coupling: &mut DMatrix<f64>, dependents: &[Dependent]) {
    for dependent in dependents {
        let row = coupling.row(dependent.leader) * dependent.multiplier;
        coupling.set_row(dependent.joint, &row);
        coupling[(dependent.joint, dependent.joint)] = 1.0;
    }
}
