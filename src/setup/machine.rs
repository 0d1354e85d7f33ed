//! The identified robot as a record of numbers: geometry of the tree, bodies and drives at parameter values.

use crate::chain::effect::CROSSTALK;
use crate::chain::effect::tilt::tilted;
use crate::chain::model::{Model, Signal};
use crate::mechanism::condition::{Anchor, Condition};
use crate::outcome::machine::{
    Machine, MachineAnchor, MachineController, MachineEffect, MachineFrame, MachineJoint,
    MachineLeader, MachineLoad, MachineLoop, MachineValue, Pose, RobotDescription,
};
use crate::robot::inertia::PER_LINK;
use crate::setup::model_spec::ModelSpec;
use crate::setup::robot::Robot;
use nalgebra::DVector;

/// The robot of a model at parameter `values`; bodies are those of `values`, whether possible or not.
pub fn record(
    declared: &ModelSpec,
    robot: &Robot,
    model: &Model,
    values: &DVector<f64>,
    feasible: Option<bool>,
) -> Machine {
    let tree = model.tree();
    let frames = tree.frames().iter().map(|frame| MachineFrame {
        name: frame.name.clone(),
        joint: frame.joint,
        pose: Pose::of(&frame.placement),
    });
    let joints = (0..tree.len()).map(|j| joint(robot, model, values, j));
    let tilt = model.tilt().map(|at| [values[at], values[at + 1]]);
    let level = tree.gravity();
    let gravity = tilt.map_or(level, |angles| tilted(&level, angles));
    let coupling = model.coupling(values);
    let rows = coupling
        .row_iter()
        .map(|row| row.iter().copied().collect::<Vec<f64>>());
    Machine {
        name: tree.name().to_string(),
        base: tree.base().to_string(),
        gravity: gravity.into(),
        tilt,
        joints: joints.collect(),
        frames: frames.collect(),
        loops: model
            .mechanism()
            .map_or_else(Vec::new, |m| m.conditions().iter().map(closed).collect()),
        home: model.mechanism().map(|m| m.home().to_vec()),
        coupling: (!model.is_uncoupled()).then(|| rows.collect()),
        payload: load(declared, model, values),
        feasible,
        signal: word(model.signal()).to_string(),
        description: description(robot),
    }
}

/// A condition as a record of numbers.
pub(super) fn closed(condition: &Condition) -> MachineLoop {
    let anchors = |ends: &[Anchor; 2]| {
        ends.map(|end| MachineAnchor {
            link: end.link,
            point: end.point.into(),
        })
    };
    match condition {
        Condition::Ball { ends } => MachineLoop::Ball {
            ends: anchors(ends),
        },
        Condition::Hinge { ends, axes } => MachineLoop::Hinge {
            ends: anchors(ends),
            axes: axes.map(Into::into),
        },
        Condition::Rod { ends, length } => MachineLoop::Rod {
            ends: anchors(ends),
            length: *length,
        },
        Condition::Equal { joints } => MachineLoop::Equal { joints: *joints },
    }
}

fn word(signal: Signal) -> &'static str {
    match signal {
        Signal::Current => "current",
        Signal::Torque => "torque",
        Signal::LinkTorque => "link_torque",
        Signal::BaseWrench => "base_wrench",
        Signal::Both => "both",
        Signal::PositionCommand => "position_command",
    }
}

fn joint(robot: &Robot, model: &Model, values: &DVector<f64>, j: usize) -> MachineJoint {
    let (joint, drive) = (&model.tree().joints()[j], &model.joints()[j]);
    let effects = drive.effects.iter().map(|&(effect, first)| MachineEffect {
        id: effect.id.to_string(),
        parameters: effect
            .parameters
            .iter()
            .enumerate()
            .map(|(k, info)| MachineValue {
                name: info.name.to_string(),
                value: values[first + k],
            })
            .collect(),
    });
    let heard: Vec<MachineValue> = model
        .heard()
        .filter(|(pair, _)| pair.channel == j)
        .map(|(pair, at)| MachineValue {
            name: model.joints()[pair.source].name.clone(),
            value: values[at],
        })
        .collect();
    let crosstalk = (!heard.is_empty()).then(|| MachineEffect {
        id: CROSSTALK.id.to_string(),
        parameters: heard,
    });
    let first = PER_LINK * j;
    let behind = robot.dependents.iter().find(|d| d.joint == j);
    let follows = behind.map(|d| MachineLeader {
        joint: d.leader,
        multiplier: d.multiplier,
        offset: d.offset,
    });
    let passive = (model.mechanism()).is_some_and(|m| m.passive().contains(&j));
    MachineJoint {
        name: joint.name.clone(),
        link: joint.link.clone(),
        parent: joint.parent,
        motion: joint.kind.into(),
        axis: joint.axis.into(),
        pose: Pose::from_parts(&joint.rotation, &joint.translation),
        lower: joint.limits.lower,
        upper: joint.limits.upper,
        velocity: joint.limits.velocity,
        effort: joint.limits.effort,
        body: std::array::from_fn(|k| values[first + k]),
        locked: robot.locked[j].filter(|_| follows.is_none() && !passive),
        passive,
        follows,
        torque_constant: (model.signal() == Signal::Current).then_some(drive.torque_constant),
        controller: drive.controller.map(|at| MachineController {
            kp: values[at],
            kd: values[at + 1],
        }),
        offset: model.offset()[j] + model.encoder_offset(j, values),
        effects: effects.chain(crosstalk).collect(),
    }
}

fn load(declared: &ModelSpec, model: &Model, values: &DVector<f64>) -> Option<MachineLoad> {
    let (payload, first) = model.payload()?;
    let link = &model.tree().joints()[payload.link].link;
    Some(MachineLoad {
        joint: payload.link,
        frame: declared.load_frame().unwrap_or(link).to_string(),
        pose: Pose::of(&payload.frame),
        body: std::array::from_fn(|k| values[first + k]),
    })
}

/// The robot file's text; absent where it cannot be read any more.
fn description(robot: &Robot) -> Option<RobotDescription> {
    let text = std::fs::read_to_string(&robot.file).ok()?;
    let file = robot.file.file_name()?.to_string_lossy().into_owned();
    Some(RobotDescription { file, text })
}
