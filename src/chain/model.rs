//! A model of a robot with its drives: every parameter by name, known or free.

use crate::chain::assemble;
pub use crate::chain::channel::Channel;
pub(super) use crate::chain::channel::WRENCH;
use crate::chain::crosstalk::Heard;
use crate::chain::effect::{Catalogue, Effect, Law, Memory};
use crate::chain::error::ModelError;
pub use crate::chain::joint_model::JointModel;
use crate::chain::parameter::{Parameter, Role, State};
use crate::chain::platform::Platform;
pub use crate::chain::settings::{Inertials, ModelSettings, Payload, Signal};
use crate::chain::sharing::{self, Sharing};
use crate::fault::nearest;
use crate::mechanism::loops::Mechanism;
use crate::robot::description::Dependent;
use crate::robot::inertia::{PER_LINK, QUANTITIES, UNITS};
use crate::robot::regressor::Rows;
use crate::robot::tree::Tree;
use crate::stats::range::within;
use nalgebra::{DMatrix, DVector};

/// A robot with its drives and all parameters.
#[derive(Debug, Clone)]
pub struct Model {
    tree: Tree,
    signal: Signal,
    channels: Vec<Channel>,
    joints: Vec<JointModel>,
    shared: Vec<Sharing>,
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
    /// Lays out the parameters: bodies, effects joint by joint, controllers, coupling, crosstalk, tilt of the base, load, in this order.
    ///
    /// # Errors
    /// [`ModelError::SingularCoupling`] and effects that need another effect or joint that is not there.
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
        sharing::tie(&settings.shared, &joints, &mut parameters);
        let joints = assemble::controlled(&settings, joints, &mut parameters);
        assemble::coupling_parameters(&settings, &coupling, &mut parameters);
        assemble::crosstalk_parameters(&settings, &mut parameters);
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
            shared: settings.shared,
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

    /// The moving joints with their links.
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// What is measured.
    pub fn signal(&self) -> Signal {
        self.signal
    }

    /// The measured series, in the order in which predictions have them.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Predicts no other channel than one.
    pub fn predict_only(&mut self, channel: usize) {
        for (c, other) in self.channels.iter_mut().enumerate() {
            other.active &= c == channel;
        }
    }

    /// Predicts signals as of the motion that they follow, for a recording whose motion is as late as they are.
    pub fn predict_on_time(&mut self) {
        for joint in &mut self.joints {
            joint.delay = None;
        }
    }

    /// The joints with their drives, in the order of the tree.
    pub fn joints(&self) -> &[JointModel] {
        &self.joints
    }

    /// Effects whose parameters joints have in common.
    pub fn shared(&self) -> &[Sharing] {
        &self.shared
    }

    /// Position of the parameter that is estimated for one: itself, or the one whose value it shares.
    pub fn estimated_as(&self, parameter: usize) -> usize {
        match self.parameters[parameter].state {
            State::Shared(with) => with,
            State::Free | State::Known => parameter,
        }
    }

    /// Positions of the parameters that are estimated as one, itself first.
    pub fn sharing(&self, parameter: usize) -> Vec<usize> {
        let others = self.parameters.iter().enumerate();
        let others = others.filter(|(_, p)| p.state == State::Shared(parameter));
        std::iter::once(parameter)
            .chain(others.map(|(p, _)| p))
            .collect()
    }

    /// Gives parameters the values of those that they are shared with.
    pub fn spread(&self, values: &mut DVector<f64>) {
        sharing::spread(&self.parameters, values);
    }

    /// The effects that the model may have.
    pub fn catalogue(&self) -> &Catalogue {
        &self.catalogue
    }

    /// s, after which the motion is declared to repeat.
    pub fn period(&self) -> Option<f64> {
        self.period
    }

    /// All of them, known and free; positions in this list are what the rest of the crate calls a parameter's position.
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
        let all = active.flat_map(|joint| {
            let on_time =
                |effect: &Effect| matches!(effect.law, Law::Delay) && joint.delay.is_none();
            let acting = joint.effects.iter().filter(move |(e, _)| !on_time(e));
            acting.map(|(e, _)| e.needs.memory)
        });
        all.fold(Memory::None, |most, next| match (most, next) {
            (Memory::WholeMotion, _) | (_, Memory::WholeMotion) => Memory::WholeMotion,
            (Memory::Time, _) | (_, Memory::Time) => Memory::Time,
            _ => Memory::None,
        })
    }

    /// Whether an effect changes with the time since the recording began.
    pub fn changes_with_time(&self) -> bool {
        let active = self.joints.iter().filter(|joint| !joint.locked);
        let mut effects = active.flat_map(|joint| &joint.effects);
        effects.any(|(effect, _)| effect.needs.memory == Memory::Time)
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

    /// The same model with these switches smoothed, N·m (N) of transmitted torque of each joint.
    pub fn smoothed(mut self, widths: &[f64]) -> Self {
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

    /// V by which the motions of a data set are those of motors: that by which recorded positions of joints became them, or
    /// that at the given values where motors were recorded.
    pub fn coupling_of_motions(&self, values: &DVector<f64>) -> DMatrix<f64> {
        match &self.reference {
            Some(reference) => reference.clone(),
            None => self.coupling(values),
        }
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

    /// Torque of a joint per unit of its signal, at joint scale; of a controller, the part that its error makes.
    pub fn torque_per_signal(&self, joint: usize) -> f64 {
        let joint = &self.joints[joint];
        let gain = joint.controller.map(|kp| self.parameters[kp].value);
        gain.unwrap_or(joint.torque_constant)
    }

    /// Values of all parameters: known ones, and those that estimates start from.
    pub fn values(&self) -> DVector<f64> {
        self.values_of(|parameter| parameter.value)
    }

    fn values_of(&self, of: impl Fn(&Parameter) -> f64) -> DVector<f64> {
        let all = self.parameters.iter().map(of);
        let mut values = DVector::from_iterator(self.parameters.len(), all);
        self.spread(&mut values);
        values
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
        self.values_of(of)
    }

    /// Index of a parameter, if there is one of that name.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|p| p.name == name)
    }

    /// Position of a parameter by name.
    pub fn find(&self, name: &str) -> Result<usize, ModelError> {
        self.position(name)
            .ok_or_else(|| ModelError::UnknownParameter {
                name: name.to_string(),
                nearest: nearest(name, self.parameters.iter().map(|p| p.name.as_str())),
            })
    }

    /// Makes a parameter known, and those that are shared with it. One that estimates may take out of its limits may be
    /// known out of them too: what one fit gives, another takes.
    ///
    /// # Errors
    /// A value outside of limits that estimates keep.
    pub fn fix(&mut self, index: usize, value: f64) -> Result<(), ModelError> {
        let index = self.estimated_as(index);
        let parameter = &mut self.parameters[index];
        let estimable = value.is_finite() && !parameter.keeps_limits();
        if !estimable && !parameter.is_within_limits(value) {
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
        let index = self.estimated_as(index);
        let parameter = &mut self.parameters[index];
        parameter.value = within(value, [parameter.lower, parameter.upper]);
    }

    /// Narrows the bounds of a parameter.
    pub fn bound(&mut self, index: usize, lower: f64, upper: f64) {
        let index = self.estimated_as(index);
        let parameter = &mut self.parameters[index];
        (parameter.lower, parameter.upper) = (lower, upper);
        parameter.bounded = true;
        parameter.value = within(parameter.value, [lower, upper]);
    }

    /// Whether a parameter is free within limits that nobody stated.
    pub fn has_usual_limits(&self, index: usize) -> bool {
        let parameter = &self.parameters[self.estimated_as(index)];
        parameter.is_free() && !parameter.bounded
    }

    /// Lowers the upper limit of a parameter with [usual limits](Self::has_usual_limits).
    pub fn lower_limit(&mut self, index: usize, upper: f64) {
        if self.has_usual_limits(index) {
            let index = self.estimated_as(index);
            let parameter = &mut self.parameters[index];
            parameter.upper = parameter.upper.min(upper);
            parameter.value = within(parameter.value, [parameter.lower, parameter.upper]);
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

    /// Whose channels hear whom, with the position of the share.
    pub fn heard(&self) -> impl Iterator<Item = (Heard, usize)> + '_ {
        let all = self.parameters.iter().enumerate();
        all.filter_map(|(p, parameter)| match parameter.role {
            Role::Crosstalk(heard) => Some((heard, p)),
            _ => None,
        })
    }

    /// `(1 + X)⁻¹`, by which recorded signals of the joints become those of their motors; `None` where no channel hears
    /// another, or where the channels do not tell the signals apart.
    pub fn crosstalk_removal(&self, values: &DVector<f64>) -> Option<DMatrix<f64>> {
        let n = self.joints.len();
        let mut mixing = DMatrix::identity(n, n);
        for (Heard { channel, source }, at) in self.heard() {
            mixing[(channel, source)] = values[at];
        }
        (!mixing.is_identity(0.0)).then(|| mixing.try_inverse())?
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
