//! A model of a robot with its drives: every parameter by name, known or free.

use crate::chain::effect::{Effect, Law, Linearity};
use crate::chain::error::ModelError;
use crate::chain::parameter::{Parameter, Role, State};
use crate::robot::inertia::{Inertia, PER_LINK, QUANTITIES, UNITS};
use crate::robot::regressor::Rows;
use crate::robot::tree::{Joint, JointKind, Tree};
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
}

impl Signal {
    /// Rows of the rigid-body regressor that the signal needs.
    pub fn rows(self) -> Rows {
        match self {
            Self::Current | Self::Torque | Self::LinkTorque => Rows::Torque,
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
const WRENCH: [(&str, &str); 6] = [
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
    /// N·m/A at joint scale; `None` where the signal is a torque.
    pub torque_constant: Option<Vec<f64>>,
    /// Known rotor inertias, kg·m² at joint scale.
    pub rotor_inertia: Option<Vec<f64>>,
    /// V of `q = V m + offset`; `None` is the identity.
    pub coupling: Option<DMatrix<f64>>,
    pub offset: Option<Vec<f64>>,
    pub effects: Vec<Vec<&'static Effect>>,
    pub payload: Option<Payload>,
    /// Joints that stand still.
    pub locked: Vec<bool>,
}

/// A joint with its drive.
#[derive(Debug, Clone)]
pub struct JointModel {
    pub name: String,
    pub kind: JointKind,
    pub torque_constant: f64,
    pub locked: bool,
    /// Effects and the position of their first parameter in the model's list.
    pub effects: Vec<(&'static Effect, usize)>,
    /// Position of the transition speed w of Coulomb friction, if the joint has it.
    pub width: Option<usize>,
    /// Position of the gain, if the joint has one.
    pub gain: Option<usize>,
}

/// A robot with its drives and all parameters.
#[derive(Debug, Clone)]
pub struct Model {
    tree: Tree,
    signal: Signal,
    channels: Vec<Channel>,
    joints: Vec<JointModel>,
    coupling: DMatrix<f64>,
    offset: DVector<f64>,
    payload: Option<(Payload, usize)>,
    parameters: Vec<Parameter>,
}

impl Model {
    pub fn new(settings: ModelSettings) -> Result<Self, ModelError> {
        let n = settings.tree.len();
        let mut parameters = inertial_parameters(&settings);
        let coupling = settings
            .coupling
            .clone()
            .unwrap_or_else(|| DMatrix::identity(n, n));
        if coupling.clone().try_inverse().is_none() {
            return Err(ModelError::SingularCoupling);
        }
        let joints = (0..n)
            .map(|j| joint_model(&settings, j, &mut parameters))
            .collect();
        coupling_parameters(&settings, &coupling, &mut parameters);
        let payload = settings.payload.map(|payload| {
            let first = parameters.len();
            let entries = QUANTITIES.iter().zip(UNITS).enumerate();
            parameters.extend(entries.map(|(quantity, (entry, unit))| {
                inertial(format!("payload.{entry}"), unit, Role::Payload { quantity })
            }));
            (payload, first)
        });
        Ok(Self {
            channels: channels(&settings),
            signal: settings.signal,
            joints,
            coupling,
            offset: DVector::from_vec(settings.offset.unwrap_or_else(|| vec![0.0; n])),
            payload,
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

    pub fn joints(&self) -> &[JointModel] {
        &self.joints
    }

    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// The load and the position of its first parameter.
    pub fn payload(&self) -> Option<(Payload, usize)> {
        self.payload
    }

    pub fn offset(&self) -> &DVector<f64> {
        &self.offset
    }

    /// Values of all parameters: known ones, and those that estimates start from.
    pub fn values(&self) -> DVector<f64> {
        DVector::from_iterator(
            self.parameters.len(),
            self.parameters.iter().map(|p| p.value),
        )
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
        parameter.value = value.clamp(parameter.lower, parameter.upper);
    }

    /// Narrows the bounds of a parameter.
    pub fn bound(&mut self, index: usize, lower: f64, upper: f64) {
        let parameter = &mut self.parameters[index];
        (parameter.lower, parameter.upper) = (lower, upper);
        parameter.bounded = true;
        parameter.value = parameter.value.clamp(lower, upper);
    }

    /// V at the given parameter values.
    pub fn coupling(&self, values: &DVector<f64>) -> DMatrix<f64> {
        let mut coupling = self.coupling.clone();
        for (value, parameter) in values.iter().zip(&self.parameters) {
            if let Role::Coupling { row, column } = parameter.role {
                coupling[(row, column)] = *value;
            }
        }
        coupling
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

fn inertial(name: String, unit: &str, role: Role) -> Parameter {
    Parameter {
        name,
        unit: unit.to_string(),
        role,
        state: State::Free,
        value: 0.0,
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        bounded: false,
        scale: 1.0,
        linearity: Linearity::Linear,
    }
}

fn inertial_parameters(settings: &ModelSettings) -> Vec<Parameter> {
    let mut parameters = Vec::new();
    for (link, joint) in settings.tree.joints().iter().enumerate() {
        for quantity in 0..PER_LINK {
            let mut parameter = inertial(
                format!("{}.{}", joint.link, QUANTITIES[quantity]),
                UNITS[quantity],
                Role::Inertial { link, quantity },
            );
            if settings.inertials == Inertials::Known {
                parameter.value = joint.inertia.0[quantity];
                parameter.state = State::Known;
            }
            parameters.push(parameter);
        }
    }
    parameters
}

fn joint_model(settings: &ModelSettings, j: usize, parameters: &mut Vec<Parameter>) -> JointModel {
    let joint = &settings.tree.joints()[j];
    let mut model = JointModel {
        name: joint.name.clone(),
        kind: joint.kind,
        torque_constant: settings.torque_constant.as_ref().map_or(1.0, |k| k[j]),
        locked: settings.locked[j],
        effects: Vec::new(),
        width: None,
        gain: None,
    };
    let known_rotor = settings.rotor_inertia.as_ref().map(|inertia| inertia[j]);
    let mut effects = settings.effects[j].clone();
    let rotor = &crate::chain::effect::rotor_inertia::EFFECT;
    if known_rotor.is_some() && effects.iter().all(|e| e.id != rotor.id) {
        effects.push(rotor);
    }
    for effect in effects {
        // V has entries and the load has bodies: their parameters are not per joint.
        if matches!(effect.law, Law::Coupling | Law::Body) {
            continue;
        }
        if settings.signal == Signal::LinkTorque && effect.id == rotor.id {
            continue;
        }
        let first = parameters.len();
        let place = (j, model.effects.len());
        parameters.extend(effect_parameters(joint, effect, place));
        match effect.id {
            "coulomb_friction" => {
                model.width = Some(first + crate::chain::effect::coulomb_friction::WIDTH);
            }
            "drive_gain" => model.gain = Some(first),
            _ => {}
        }
        if let (Some(inertia), true) = (known_rotor, effect.id == rotor.id) {
            parameters[first].value = inertia;
            let listed = settings.effects[j].iter().any(|e| e.id == rotor.id);
            if !listed {
                parameters[first].state = State::Known;
            }
        }
        model.effects.push((effect, first));
    }
    model
}

/// The parameters of an effect; `place` is the joint and the position among its effects.
fn effect_parameters(
    joint: &Joint,
    effect: &'static Effect,
    place: (usize, usize),
) -> impl Iterator<Item = Parameter> {
    let (name, kind) = (joint.name.clone(), joint.kind);
    effect
        .parameters
        .iter()
        .enumerate()
        .map(move |(index, info)| Parameter {
            name: format!("{name}.{}.{}", effect.id, info.name),
            unit: info.unit.of(kind).to_string(),
            role: Role::Effect {
                joint: place.0,
                effect: place.1,
                parameter: index,
            },
            state: State::Free,
            value: match info.linearity {
                Linearity::Linear => 0.0,
                Linearity::Nonlinear => info.typical,
            },
            lower: info.lower,
            upper: info.upper,
            bounded: false,
            scale: info.typical,
            linearity: info.linearity,
        })
}

fn coupling_parameters(
    settings: &ModelSettings,
    coupling: &DMatrix<f64>,
    parameters: &mut Vec<Parameter>,
) {
    let effect = &crate::chain::effect::kinematic_coupling::EFFECT;
    let info = &effect.parameters[0];
    let joints = settings.tree.joints();
    for row in 0..joints.len() {
        if settings.effects[row].iter().all(|e| e.id != effect.id) {
            continue;
        }
        let declared: Vec<usize> = (0..joints.len())
            .filter(|&column| column != row && coupling[(row, column)] != 0.0)
            .collect();
        let columns = match (declared.is_empty(), row.checked_sub(1)) {
            (true, Some(before)) => vec![before],
            _ => declared,
        };
        for column in columns {
            parameters.push(Parameter {
                name: format!("{}.{}.{}", joints[row].name, effect.id, joints[column].name),
                unit: info.unit.of(joints[row].kind).to_string(),
                role: Role::Coupling { row, column },
                state: State::Free,
                value: coupling[(row, column)],
                lower: info.lower,
                upper: info.upper,
                bounded: false,
                scale: info.typical,
                linearity: info.linearity,
            });
        }
    }
}

fn channels(settings: &ModelSettings) -> Vec<Channel> {
    let of_joints = settings.tree.joints().iter().enumerate().map(|(j, joint)| {
        let unit = match settings.signal {
            Signal::Current => "A",
            _ => joint.kind.effort_unit(),
        };
        Channel {
            name: joint.name.clone(),
            unit,
            joint: Some(j),
            active: !settings.locked[j],
        }
    });
    let of_base = WRENCH.iter().map(|&(name, unit)| Channel {
        name: name.to_string(),
        unit,
        joint: None,
        active: true,
    });
    match settings.signal {
        Signal::BaseWrench => of_base.collect(),
        Signal::Both => of_joints.chain(of_base).collect(),
        _ => of_joints.collect(),
    }
}
