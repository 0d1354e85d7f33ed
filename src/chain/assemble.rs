//! Assembly of a model's list of parameters: of links, effects, coupling, tilt and load.

use crate::chain::channel::{Channel, WRENCH};
use crate::chain::crosstalk::Heard;
use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::{
    CROSSTALK, CURRENT_LAW, Dependence, Effect, Law, Linearity, NEXT, PREVIOUS, ParameterInfo,
    of_term,
};
use crate::chain::error::ModelError;
use crate::chain::joint_model::JointModel;
use crate::chain::parameter::{Parameter, Role, State};
use crate::chain::settings::{Inertials, ModelSettings, Signal};
use crate::robot::inertia::{PER_LINK, QUANTITIES, UNITS};
use crate::robot::tree::{Joint, JointKind, Tree};
use nalgebra::DMatrix;

pub(super) fn unbounded(name: String, unit: &str, role: Role) -> Parameter {
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

pub(super) fn inertial_parameters(settings: &ModelSettings) -> Vec<Parameter> {
    let mut parameters = Vec::new();
    for (link, joint) in settings.tree.joints().iter().enumerate() {
        for quantity in 0..PER_LINK {
            let mut parameter = unbounded(
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

pub(super) fn joint_model(
    settings: &ModelSettings,
    j: usize,
    parameters: &mut Vec<Parameter>,
) -> Result<JointModel, ModelError> {
    let joint = &settings.tree.joints()[j];
    let mut model = JointModel {
        name: joint.name.clone(),
        kind: joint.kind,
        torque_constant: torque_constant(settings, j),
        torque_constant_std: settings
            .torque_constant_std
            .as_ref()
            .map_or(0.0, |std| std[j]),
        locked: settings.locked[j],
        effects: Vec::new(),
        borrowed: Vec::new(),
        others: Vec::new(),
        replaced: Vec::new(),
        width: None,
        gain: None,
        polynomial: None,
        controller: None,
        delay: None,
        elasticity: None,
        play: None,
        encoder: None,
        rounding: 0.0,
    };
    for effect in effects_with_known_values(settings, j) {
        if !has_own_parameters(effect, settings.signal) {
            continue;
        }
        let first = parameters.len();
        parameters.extend(effect_parameters(joint, effect, j, model.effects.len()));
        remember(&mut model, effect, first);
        known_values(settings, j, effect, &mut parameters[first..]);
        model.effects.push((effect, first));
        model.others.push(others(settings, j, effect)?);
    }
    lend(&mut model, parameters)?;
    let behind = model
        .effects
        .iter()
        .filter(|(effect, _)| lies_behind(&model, effect));
    for &(effect, first) in behind {
        for parameter in &mut parameters[first..first + effect.parameters.len()] {
            parameter.linearity = Linearity::Nonlinear;
        }
    }
    Ok(model)
}

/// Whether an effect is friction of a link that lags its motor: its size decides where the link sticks, and where motor and
/// link move as one it is the same torque as friction of the motor.
fn lies_behind(joint: &JointModel, effect: &Effect) -> bool {
    let moves = [Dependence::Speed, Dependence::Direction];
    let of_speed = effect.depends_on.iter().any(|on| moves.contains(on));
    joint.has_lag() && of_speed && matches!(effect.law, Law::Joint(_))
}

/// Gives joints that move their controllers.
pub(super) fn controlled(
    settings: &ModelSettings,
    mut joints: Vec<JointModel>,
    parameters: &mut Vec<Parameter>,
) -> Vec<JointModel> {
    let controllers = settings.controllers.iter().flatten();
    for (j, controller) in controllers.enumerate() {
        if settings.locked[j] {
            continue;
        }
        joints[j].controller = Some(parameters.len());
        parameters.extend(controller.parameters(&settings.tree.joints()[j], j));
    }
    joints
}

fn torque_constant(settings: &ModelSettings, j: usize) -> f64 {
    match (&settings.current_polynomial, &settings.torque_constant) {
        (Some(polynomial), _) => polynomial[j][1],
        (None, Some(constant)) => constant[j],
        (None, None) => 1.0,
    }
}

/// Whether a robot has the joints that an effect of one joint knows of.
pub fn has_others(tree: &Tree, joint: usize, effect: &Effect) -> bool {
    let mut others = effect.needs.others.iter();
    others.all(|name| other(tree, joint, name).is_some())
}

fn other(tree: &Tree, joint: usize, name: &str) -> Option<usize> {
    match name {
        NEXT => (joint + 1 < tree.len()).then_some(joint + 1),
        PREVIOUS => joint.checked_sub(1),
        name => tree.joint_index(name),
    }
}

/// The joints whose motion an effect of a joint knows.
fn others(
    settings: &ModelSettings,
    joint: usize,
    effect: &'static Effect,
) -> Result<Vec<usize>, ModelError> {
    let of = |name: &&'static str| {
        other(&settings.tree, joint, name).ok_or_else(|| ModelError::NeedsJoint {
            joint: settings.tree.joints()[joint].name.clone(),
            effect: effect.id,
            needs: name,
        })
    };
    effect.needs.others.iter().map(of).collect()
}

/// The listed effects, and those that act because their values are declared.
fn effects_with_known_values(settings: &ModelSettings, j: usize) -> Vec<&'static Effect> {
    let mut effects = settings.effects[j].clone();
    let mut declare = |effect: &'static Effect| {
        if effects.iter().all(|e| e.id != effect.id) {
            effects.push(effect);
        }
    };
    if settings.rotor_inertia.is_some() {
        declare(of_term(JointTerm::RotorInertia));
    }
    if settings.current_polynomial.is_some() {
        declare(CURRENT_LAW);
    }
    effects
}

/// V has entries, channels hear others, the load has bodies and the base has angles, which are not per joint; behind the gear
/// neither rotors nor losses of the gear nor laws of the current are seen.
fn has_own_parameters(effect: &Effect, signal: Signal) -> bool {
    match effect.law {
        Law::Coupling | Law::Crosstalk | Law::Body | Law::Tilt => false,
        Law::Current => signal == Signal::Current,
        Law::Transmission(_) => signal != Signal::LinkTorque,
        Law::Signal(_) => {
            signal == Signal::Current || !effect.depends_on.contains(&Dependence::Current)
        }
        _ => {
            !(signal == Signal::LinkTorque
                && effect.knowledge.term == Some(JointTerm::RotorInertia))
        }
    }
}

/// Positions of the parameters that the chain looks up.
fn remember(model: &mut JointModel, effect: &Effect, first: usize) {
    if let Some(transition) = effect.knowledge.transition {
        model.width = Some(first + transition.speed);
    }
    let slot = match effect.law {
        Law::Gain => &mut model.gain,
        Law::Current => &mut model.polynomial,
        Law::Delay => &mut model.delay,
        Law::Spring => &mut model.elasticity,
        Law::Play => &mut model.play,
        Law::Encoder => &mut model.encoder,
        _ => return,
    };
    *slot = Some(first);
}

/// Declared values: known, or where the effect is listed as well, where the estimate starts.
fn known_values(settings: &ModelSettings, j: usize, effect: &Effect, parameters: &mut [Parameter]) {
    let declared: Vec<f64> = match (effect.law, &settings.rotor_inertia) {
        (Law::Current, _) => match &settings.current_polynomial {
            Some(polynomial) => polynomial[j].to_vec(),
            None => {
                let straight = [0.0, torque_constant(settings, j), 0.0, 0.0];
                for (parameter, value) in parameters.iter_mut().zip(straight) {
                    parameter.value = value;
                }
                return;
            }
        },
        (_, Some(inertia)) if effect.knowledge.term == Some(JointTerm::RotorInertia) => {
            vec![inertia[j]]
        }
        _ => return,
    };
    let listed = settings.effects[j].iter().any(|e| e.id == effect.id);
    for (parameter, value) in parameters.iter_mut().zip(declared) {
        parameter.value = value;
        if !listed {
            parameter.state = State::Known;
        }
    }
}

/// Finds the parameters that effects borrow and the effects whose place is taken.
fn lend(model: &mut JointModel, parameters: &mut [Parameter]) -> Result<(), ModelError> {
    let effects = model.effects.clone();
    for (effect, _) in &effects {
        let taken = |other: &(&'static Effect, usize)| {
            effects
                .iter()
                .any(|(e, _)| e.needs.replaces == Some(other.0.id))
        };
        model.replaced = effects.iter().map(taken).collect();
        let mut borrowed = Vec::new();
        for (lender, name) in effect.needs.borrows {
            let found = effects.iter().find(|(e, _)| e.id == *lender);
            let Some((lender, first)) = found else {
                return Err(ModelError::NeedsEffect {
                    joint: model.name.clone(),
                    effect: effect.id,
                    needs: lender,
                });
            };
            let index = lender.parameters.iter().position(|p| p.name == *name);
            let position = first + index.unwrap_or(0);
            if effect.needs.replaces == Some(lender.id) {
                // Inside the other law it is no longer a factor of its own.
                parameters[position].linearity = Linearity::Nonlinear;
            }
            borrowed.push(position);
        }
        model.borrowed.push(borrowed);
    }
    Ok(())
}

/// The angles of the base, where any joint lists its tilt.
pub(super) fn tilt_parameters(
    settings: &ModelSettings,
    parameters: &mut Vec<Parameter>,
) -> Option<usize> {
    let mut listed = settings.effects.iter().flatten();
    let effect = listed.find(|effect| matches!(effect.law, Law::Tilt))?;
    let first = parameters.len();
    for (angle, info) in effect.parameters.iter().enumerate() {
        let name = format!("{}.{}", effect.id, info.name);
        parameters.push(beyond_joints(
            name,
            info.unit.of(JointKind::Revolute),
            Role::Tilt { angle },
            info,
        ));
    }
    Some(first)
}

/// Size of a change of a parameter that matters: the typical value's, and one unit where that is zero, such as of a phase.
fn size(info: &ParameterInfo) -> f64 {
    match info.typical {
        0.0 => 1.0,
        typical => typical.abs(),
    }
}

/// The parameters of an effect of joint j, `place` among its effects.
fn effect_parameters(
    joint: &Joint,
    effect: &'static Effect,
    j: usize,
    place: usize,
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
                joint: j,
                effect: place,
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
            scale: size(info),
            linearity: info.linearity,
        })
}

pub(super) fn coupling_parameters(
    settings: &ModelSettings,
    coupling: &DMatrix<f64>,
    parameters: &mut Vec<Parameter>,
) {
    let joints = settings.tree.joints();
    for row in 0..joints.len() {
        let mut listed = settings.effects[row].iter();
        let Some(effect) = listed.find(|effect| matches!(effect.law, Law::Coupling)) else {
            continue;
        };
        let info = &effect.parameters[0];
        let declared: Vec<usize> = (0..joints.len())
            .filter(|&column| column != row && coupling[(row, column)] != 0.0)
            .collect();
        let columns = match (declared.is_empty(), row.checked_sub(1)) {
            (true, Some(before)) => vec![before],
            _ => declared,
        };
        for column in columns {
            let name = format!("{}.{}.{}", joints[row].name, effect.id, joints[column].name);
            let role = Role::Coupling { row, column };
            let unit = info.unit.of(joints[row].kind);
            parameters.push(Parameter {
                value: coupling[(row, column)],
                ..beyond_joints(name, unit, role, info)
            });
        }
    }
}

/// A free parameter of an effect that no joint has by itself; a fit may take it out of its limits.
fn beyond_joints(name: String, unit: &str, role: Role, info: &ParameterInfo) -> Parameter {
    Parameter {
        lower: info.lower,
        upper: info.upper,
        scale: info.typical,
        linearity: info.linearity,
        ..unbounded(name, unit, role)
    }
}

/// Whose channels hear whom: every pair of a joint that lists the effect, and the stated ones.
fn heard(settings: &ModelSettings) -> Vec<Heard> {
    let n = settings.tree.len();
    let of_motors = settings.signal.has_channels_of_motors();
    let lists = |j: usize| {
        let mut effects = settings.effects[j].iter();
        effects.any(|effect| matches!(effect.law, Law::Crosstalk))
    };
    let pairs = (0..n).flat_map(|channel| (0..n).map(move |source| Heard { channel, source }));
    pairs
        .filter(|pair| {
            let Heard { channel, source } = *pair;
            let move_both = !settings.locked[channel] && !settings.locked[source];
            let is_named = lists(channel) || settings.crosstalk.contains(pair);
            of_motors && move_both && channel != source && is_named
        })
        .collect()
}

pub(super) fn crosstalk_parameters(settings: &ModelSettings, parameters: &mut Vec<Parameter>) {
    let joints = settings.tree.joints();
    let info = &CROSSTALK.parameters[0];
    for pair in heard(settings) {
        let [channel, source] = [pair.channel, pair.source].map(|j| &joints[j]);
        let name = format!("{}.{}.{}", channel.name, CROSSTALK.id, source.name);
        let unit = share_unit(settings.signal, channel.kind, source.kind);
        parameters.push(beyond_joints(name, unit, Role::Crosstalk(pair), info));
    }
}

/// Unit of a share of one channel's signal in another's: torques and forces are different quantities, currents are not.
fn share_unit(signal: Signal, channel: JointKind, source: JointKind) -> &'static str {
    match (channel, source) {
        _ if signal == Signal::Current => "1",
        (JointKind::Revolute, JointKind::Prismatic) => "m",
        (JointKind::Prismatic, JointKind::Revolute) => "1/m",
        _ => "1",
    }
}

pub(super) fn channels(settings: &ModelSettings) -> Vec<Channel> {
    let of_joints = settings.tree.joints().iter().enumerate().map(|(j, joint)| {
        let unit = match settings.signal {
            Signal::Current => "A",
            Signal::PositionCommand => joint.kind.position_unit(),
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
