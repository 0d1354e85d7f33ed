//! MJCF: bodies, armature, damping and frictionloss; frames as sites.

use crate::export::xml::{escaped, triple};
use crate::export::{Export, File};
use crate::outcome::machine::{Machine, MachineJoint, Motion, Pose};
use crate::robot::inertia::{CentralInertia, Inertia};
use nalgebra::{UnitQuaternion, Vector3};
use std::fmt::Write;

/// Laws that MuJoCo has attributes for: effect, its parameters in the model.
const KEPT: &[(&str, &[&str])] = &[
    ("rotor_inertia", &["Jm"]),
    ("viscous_friction", &["Fv"]),
    ("coulomb_friction", &["Fc"]),
];

/// The robot as MJCF, the load on its link where there is one.
pub fn write(machine: &Machine, name: &str) -> Export {
    let gravity = Vector3::from(machine.gravity);
    let mut text = format!(
        "<mujoco model=\"{}\">\n  <compiler angle=\"radian\" inertiafromgeom=\"false\" boundmass=\"0\" \
         boundinertia=\"0\"/>\n  <option gravity=\"{}\"/>\n  <worldbody>\n",
        escaped(&machine.name),
        triple(&gravity)
    );
    sites(machine, None, "    ", &mut text);
    bodies(machine, None, "    ", &mut text);
    text.push_str("  </worldbody>\n");
    couplings(machine, &mut text);
    text.push_str("</mujoco>\n");
    Export {
        files: vec![File {
            name: format!("{name}.xml"),
            text,
        }],
        notes: lost(machine),
    }
}

/// Joints that follow others.
fn couplings(machine: &Machine, text: &mut String) {
    let following = machine.joints.iter();
    let following = following.filter_map(|joint| Some((joint, joint.follows.as_ref()?)));
    let lines: Vec<String> = following
        .map(|(joint, leader)| {
            format!(
                "    <joint joint1=\"{}\" joint2=\"{}\" polycoef=\"{:?} {:?} 0 0 0\"/>\n",
                escaped(&joint.name),
                escaped(&machine.joints[leader.joint].name),
                leader.offset,
                leader.multiplier
            )
        })
        .collect();
    if !lines.is_empty() {
        text.push_str(&format!("  <equality>\n{}  </equality>\n", lines.concat()));
    }
}

fn bodies(machine: &Machine, parent: Option<usize>, indent: &str, text: &mut String) {
    let children = machine.joints.iter().enumerate();
    for (k, joint) in children.filter(|(_, joint)| joint.parent == parent) {
        let inner = format!("{indent}  ");
        // A text takes whatever is written to it.
        let _ = writeln!(
            text,
            "{indent}<body name=\"{}\" {}>",
            escaped(&joint.link),
            place(&joint.pose)
        );
        let load = machine.payload.as_ref().filter(|load| load.joint == k);
        let body = match load {
            Some(load) => Inertia(joint.body).plus(&load.on_link()),
            None => Inertia(joint.body),
        };
        let _ = writeln!(text, "{inner}{}", inertial(&body));
        let _ = writeln!(text, "{inner}{}", moving(joint));
        sites(machine, Some(k), &inner, text);
        bodies(machine, Some(k), &inner, text);
        let _ = writeln!(text, "{indent}</body>");
    }
}

fn sites(machine: &Machine, carrier: Option<usize>, indent: &str, text: &mut String) {
    for frame in machine.frames.iter().filter(|f| f.joint == carrier) {
        let (name, place) = (escaped(&frame.name), place(&frame.pose));
        let _ = writeln!(text, "{indent}<site name=\"{name}\" {place}/>");
    }
}

fn place(pose: &Pose) -> String {
    let turn = UnitQuaternion::from_rotation_matrix(&pose.rotation());
    format!(
        "pos=\"{}\" quat=\"{:?} {:?} {:?} {:?}\"",
        triple(&pose.translation()),
        turn.w,
        turn.i,
        turn.j,
        turn.k
    )
}

fn inertial(body: &Inertia) -> String {
    let central = body.central().unwrap_or(CentralInertia {
        mass: 0.0,
        centre: Vector3::zeros(),
        tensor: body.tensor(),
    });
    let entry = |r: usize, c: usize| central.tensor[(r, c)];
    format!(
        "<inertial pos=\"{}\" mass=\"{:?}\" fullinertia=\"{:?} {:?} {:?} {:?} {:?} {:?}\"/>",
        triple(&central.centre),
        central.mass,
        entry(0, 0),
        entry(1, 1),
        entry(2, 2),
        entry(0, 1),
        entry(0, 2),
        entry(1, 2)
    )
}

fn moving(joint: &MachineJoint) -> String {
    let kind = match joint.motion {
        Motion::Revolute => "hinge",
        Motion::Prismatic => "slide",
    };
    let range = match (joint.lower, joint.upper) {
        (Some(lower), Some(upper)) if lower < upper => {
            format!(" limited=\"true\" range=\"{lower:?} {upper:?}\"")
        }
        _ => " limited=\"false\"".to_string(),
    };
    let value = |effect, parameter| joint.value(effect, parameter).unwrap_or(0.0);
    format!(
        "<joint name=\"{}\" type=\"{kind}\" axis=\"{}\"{range} armature=\"{:?}\" damping=\"{:?}\" \
         frictionloss=\"{:?}\"/>",
        escaped(&joint.name),
        triple(&Vector3::from(joint.axis)),
        value("rotor_inertia", "Jm"),
        value("viscous_friction", "Fv"),
        value("coulomb_friction", "Fc")
    )
}

/// What MJCF has no place for.
fn lost(machine: &Machine) -> Vec<String> {
    let mut notes = Vec::new();
    for joint in &machine.joints {
        let mut names: Vec<String> = Vec::new();
        for effect in &joint.effects {
            let kept = KEPT.iter().find(|(id, _)| *id == effect.id);
            let kept = kept.map_or(&[][..], |(_, parameters)| parameters);
            let other = effect.parameters.iter().filter(|p| p.value != 0.0);
            let other = other.filter(|p| !kept.contains(&p.name.as_str()));
            names.extend(other.map(|p| format!("{}.{} = {}", effect.id, p.name, p.value)));
        }
        names.extend(
            joint
                .torque_constant
                .map(|k| format!("torque constant {k} N·m/A")),
        );
        if !names.is_empty() {
            notes.push(format!("{}: lost: {}", joint.name, names.join(", ")));
        }
    }
    if machine.coupling.is_some() {
        notes.push(
            "lost: the coupling of motors; armature, damping and frictionloss act on joints here, on motors \
             in the model"
                .to_string(),
        );
    }
    if machine.payload.is_some() {
        notes.push("the load is part of the link that carries it".to_string());
    }
    notes.push("shapes and meshes are not written".to_string());
    notes
}
