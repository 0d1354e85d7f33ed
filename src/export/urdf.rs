//! URDF: bodies at their centres of mass with the full tensor, viscous and Coulomb friction as `dynamics`.
//!
//! A result that was made from a URDF keeps that file, shapes and meshes included, with new inertials; bodies
//! of links behind fixed joints are part of the moving link that carries them. Otherwise a file is written
//! from the geometry alone.

use crate::export::error::ExportError;
use crate::export::urdf_edit::{dress, dynamics};
use crate::export::xml::{escaped, triple};
use crate::export::{Export, File, side_file};
use crate::outcome::machine::{Machine, MachineFrame, MachineJoint, Motion, Pose};
use crate::robot::inertia::Inertia;
use crate::robot::urdf::inertial;
use nalgebra::Vector3;
use std::fmt::Write;

/// Limit of what the robot file does not limit: readers insist on the attributes.
const UNLIMITED: f64 = 1e9;

/// The robot as URDF with its side file.
///
/// # Errors
/// Where the robot file in the result does not read any more.
pub fn write(machine: &Machine, name: &str) -> Result<Export, ExportError> {
    let original = machine.description.as_ref();
    let original = original.filter(|file| file.text.contains("<robot"));
    let text = match original {
        Some(original) => dress(machine, &original.text)?,
        None => from_geometry(machine),
    };
    let file = format!("{name}.urdf");
    let side = side_file::write(machine, name, &file)?;
    let mut notes = vec![format!(
        "URDF has damping and friction alone: what a simulator makes of them is its own; every law with its \
         parameters, rotor inertias, torque constants, gravity and the load stand in {}",
        side.name
    )];
    if original.is_some_and(|file| file.text.contains("<mesh")) {
        notes.push("paths of meshes are those of the robot file".to_string());
    }
    Ok(Export {
        files: vec![File { name: file, text }, side],
        notes,
    })
}

fn origin(pose: &Pose) -> String {
    let (roll, pitch, yaw) = pose.rotation().euler_angles();
    format!(
        "<origin xyz=\"{}\" rpy=\"{roll:?} {pitch:?} {yaw:?}\"/>",
        triple(&pose.translation())
    )
}

fn from_geometry(machine: &Machine) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n",
        escaped(&machine.name)
    );
    let link = |name: &str, content: &str| {
        format!("  <link name=\"{}\">{content}</link>\n", escaped(name))
    };
    text.push_str(&link(&machine.base, ""));
    for joint in &machine.joints {
        let body = inertial(&Inertia(joint.body));
        text.push_str(&link(&joint.link, &format!("\n    {body}\n  ")));
    }
    for joint in &machine.joints {
        text.push_str(&moving(machine, joint));
    }
    for frame in &machine.frames {
        text.push_str(&link(&frame.name, ""));
        text.push_str(&fixed(machine, frame));
    }
    text.push_str("</robot>\n");
    text
}

/// Name of the link that a joint carries; the base without one.
fn link_of(machine: &Machine, joint: Option<usize>) -> String {
    escaped(joint.map_or(&machine.base, |k| &machine.joints[k].link))
}

fn moving(machine: &Machine, joint: &MachineJoint) -> String {
    let unlimited = joint.lower.is_none() || joint.upper.is_none();
    let kind = match joint.motion {
        Motion::Revolute if unlimited => "continuous",
        Motion::Revolute => "revolute",
        Motion::Prismatic => "prismatic",
    };
    let mut limit = String::new();
    let needs = kind != "continuous";
    let ends = [
        ("lower", joint.lower, -UNLIMITED),
        ("upper", joint.upper, UNLIMITED),
        ("velocity", joint.velocity, UNLIMITED),
        ("effort", joint.effort, UNLIMITED),
    ];
    for (name, value, unlimited) in ends {
        if let Some(value) = value.or(needs.then_some(unlimited)) {
            // A text takes whatever is written to it.
            let _ = write!(limit, " {name}=\"{value:?}\"");
        }
    }
    if !limit.is_empty() {
        limit = format!("    <limit{limit}/>\n");
    }
    if let Some(leader) = &joint.follows {
        let name = escaped(&machine.joints[leader.joint].name);
        let (multiplier, offset) = (leader.multiplier, leader.offset);
        let _ = writeln!(
            limit,
            "    <mimic joint=\"{name}\" multiplier=\"{multiplier:?}\" offset=\"{offset:?}\"/>"
        );
    }
    format!(
        "  <joint name=\"{}\" type=\"{kind}\">\n    {}\n    <parent link=\"{}\"/>\n    \
         <child link=\"{}\"/>\n    <axis xyz=\"{}\"/>\n{limit}    {}\n  </joint>\n",
        escaped(&joint.name),
        origin(&joint.pose),
        link_of(machine, joint.parent),
        escaped(&joint.link),
        triple(&Vector3::from(joint.axis)),
        dynamics(joint)
    )
}

fn fixed(machine: &Machine, frame: &MachineFrame) -> String {
    format!(
        "  <joint name=\"{}_fixed\" type=\"fixed\">\n    {}\n    <parent link=\"{}\"/>\n    \
         <child link=\"{}\"/>\n  </joint>\n",
        escaped(&frame.name),
        origin(&frame.pose),
        link_of(machine, frame.joint),
        escaped(&frame.name)
    )
}
