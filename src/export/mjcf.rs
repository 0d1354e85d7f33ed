//! MJCF: bodies, armature, damping, frictionloss, motors and position controllers; frames as sites.

use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::of_term;
use crate::export::loop_constraints;
use crate::export::values::Setting;
use crate::export::xml::{escaped, triple};
use crate::export::{Export, File, term};
use crate::outcome::machine::{Machine, MachineController, MachineJoint, Motion, Pose};
use crate::robot::inertia::{CentralInertia, Inertia};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use std::fmt::Write;

/// Terms that MuJoCo has attributes for.
const KEPT: [JointTerm; 4] = [
    JointTerm::RotorInertia,
    JointTerm::ViscousFriction,
    JointTerm::DryFriction,
    JointTerm::Spring,
];

/// kg and kg·m² of a link without mass.
const LEAST_BODY: [f64; 2] = [1e-6, 1e-9];

/// Armature of a joint in a loop that nothing of its own resists, as a share of the least of the motors': what it adds to the
/// motion is less than its parameters are known, and MuJoCo holds loops the softer the less resists them.
const LOOPED: f64 = 1e-3;

/// Shortest step of the simulator, s, that a delay is kept for.
const LEAST_STEP: f64 = 1e-4;

/// What of a drive stands in the joint.
#[derive(Debug, Clone, Copy, Default)]
pub struct Native {
    pub armature: f64,
    pub damping: f64,
    pub friction: f64,
    pub stiffness: f64,
    /// Position without torque of the spring.
    pub rest: f64,
}

/// What drives the joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Actuation<'a> {
    /// MuJoCo's own: position controllers, and motors whose gears are the torque per signal.
    Own,
    /// The plugin `exid.drive` with its numbers, one actuator per joint.
    Plugin(&'a [Setting]),
}

/// The robot as MJCF, the load on its link where there is one.
pub fn write(machine: &Machine, name: &str) -> Export {
    let natives = natives(machine);
    Export {
        files: vec![File {
            name: format!("{name}.xml"),
            text: document(machine, &natives, Actuation::Own),
        }],
        notes: lost(machine),
    }
}

/// What of each drive stands in its joint, with the armature of joints in loops that nothing of their own resists.
fn natives(machine: &Machine) -> Vec<Native> {
    let mut natives: Vec<Native> = machine.joints.iter().map(of_joint).collect();
    let rotors = natives.iter().map(|native| native.armature);
    let least = rotors.filter(|armature| *armature > 0.0).reduce(f64::min);
    let bare = bare(machine);
    let bare = natives.iter_mut().zip(bare).filter(|(_, bare)| *bare);
    bare.for_each(|(native, _)| native.armature = LOOPED * least.unwrap_or(0.0));
    natives
}

/// Which joints in loops have neither a rotor nor carry a mass.
fn bare(machine: &Machine) -> Vec<bool> {
    let joints = &machine.joints;
    let mut carries: Vec<bool> = joints
        .iter()
        .map(|j| !is_massless(&Inertia(j.body)))
        .collect();
    for (k, joint) in joints.iter().enumerate().rev() {
        if let (true, Some(parent)) = (carries[k], joint.parent) {
            carries[parent] = true;
        }
    }
    let rotor = |joint| of_joint(joint).armature > 0.0;
    let is_looped = !machine.loops.is_empty();
    let each = joints.iter().zip(carries);
    each.map(|(joint, carries)| is_looped && !carries && !rotor(joint))
        .collect()
}

fn of_joint(joint: &MachineJoint) -> Native {
    let size = |term| term::size(joint, term).unwrap_or(0.0);
    Native {
        armature: size(JointTerm::RotorInertia),
        damping: size(JointTerm::ViscousFriction),
        friction: size(JointTerm::DryFriction),
        stiffness: size(JointTerm::Spring),
        rest: term::rest(joint).unwrap_or(0.0),
    }
}

/// The text of the model.
pub fn document(machine: &Machine, natives: &[Native], actuation: Actuation<'_>) -> String {
    let gravity = Vector3::from(machine.gravity);
    let mut text = format!(
        "<mujoco model=\"{}\">\n  <compiler angle=\"radian\" inertiafromgeom=\"false\" boundmass=\"0\" \
         boundinertia=\"0\"/>\n  <option gravity=\"{}\"/>\n  <worldbody>\n",
        escaped(&machine.name),
        triple(&gravity)
    );
    if let Actuation::Plugin(settings) = actuation {
        let extension = extension(settings) + "  <worldbody>\n";
        text = text.replace("  <worldbody>\n", &extension);
    }
    sites(machine, None, "    ", &mut text);
    loop_constraints::sites(machine, None, "    ", &mut text);
    bodies(machine, natives, None, "    ", &mut text);
    text.push_str("  </worldbody>\n");
    let equalities = [couplings(machine), loop_constraints::equalities(machine)].concat();
    if !equalities.is_empty() {
        text.push_str(&format!("  <equality>\n{equalities}  </equality>\n"));
    }
    text.push_str(&loop_constraints::rods(machine));
    let actuators: String = match actuation {
        Actuation::Own if machine.coupling.is_some() => String::new(),
        Actuation::Own => machine.joints.iter().filter_map(own_actuator).collect(),
        Actuation::Plugin(_) => machine.joints.iter().map(plugin_actuator).collect(),
    };
    if !actuators.is_empty() {
        text.push_str(&format!("  <actuator>\n{actuators}  </actuator>\n"));
    }
    if let Some(home) = &machine.home {
        let positions: Vec<String> = home.iter().map(|q| format!("{q:?}")).collect();
        text.push_str(&format!(
            "  <keyframe>\n    <key name=\"home\" qpos=\"{}\"/>\n  </keyframe>\n",
            positions.join(" ")
        ));
    }
    text.push_str("</mujoco>\n");
    text
}

/// The instance of the plugin that drives all joints.
fn extension(settings: &[Setting]) -> String {
    let of = |Setting { key, value, .. }: &Setting| {
        let key = escaped(key);
        // The shortest decimal that reads back to the same number.
        format!("        <config key=\"{key}\" value=\"{value:?}\"/>\n")
    };
    let configuration: String = settings.iter().map(of).collect();
    format!(
        "  <extension>\n    <plugin plugin=\"exid.drive\">\n      <instance name=\"drives\">\n{configuration}      \
         </instance>\n    </plugin>\n  </extension>\n"
    )
}

/// The position controller of a joint with a motor, or its motor with the torque of a signal of one.
fn own_actuator(joint: &MachineJoint) -> Option<String> {
    if joint.follows.is_some() || joint.passive || joint.locked.is_some() {
        return None;
    }
    let name = escaped(&joint.name);
    let gain = term::torque_gain(joint);
    let late = held_back(joint);
    Some(match joint.controller {
        Some(MachineController { kp, kd }) => format!(
            "    <position name=\"{name}\" joint=\"{name}\" kp=\"{:?}\" kv=\"{:?}\"{late}/>\n",
            gain * kp,
            gain * kd
        ),
        None => format!(
            "    <motor name=\"{name}\" joint=\"{name}\" gear=\"{:?}\"{late}/>\n",
            gain * joint.torque_constant.unwrap_or(1.0)
        ),
    })
}

fn plugin_actuator(joint: &MachineJoint) -> String {
    let name = escaped(&joint.name);
    let late = held_back(joint);
    format!(
        "    <plugin name=\"{name}\" joint=\"{name}\" plugin=\"exid.drive\" instance=\"drives\"{late}/>\n"
    )
}

/// The delay of what is given to an actuator, and the number of steps that are kept for it.
fn held_back(joint: &MachineJoint) -> String {
    let delay = term::delay(joint);
    if delay <= 0.0 {
        return String::new();
    }
    let kept = (delay / LEAST_STEP).ceil() as usize + 1;
    format!(" delay=\"{delay:?}\" nsample=\"{kept}\"")
}

/// What stands for links without mass, which MuJoCo does not load.
pub fn massless(machine: &Machine) -> Option<String> {
    let joints = machine.joints.iter();
    let names = joints.filter(|joint| is_massless(&Inertia(joint.body)));
    let names: Vec<&str> = names.map(|joint| joint.link.as_str()).collect();
    let [mass, moment] = LEAST_BODY;
    (!names.is_empty()).then(|| {
        format!(
            "{}: without mass, and with {mass:e} kg and {moment:e} kg·m² here, as MuJoCo loads no other",
            names.join(", ")
        )
    })
}

/// What the controls of the simulator are.
pub fn held_by_ctrl(machine: &Machine) -> &'static str {
    match machine.joints.iter().any(|j| j.controller.is_some()) {
        true => {
            "the commanded positions; commanded speeds and torques that are fed forward have no place"
        }
        false => "the signals of the motors",
    }
}

/// Joints that follow others.
fn couplings(machine: &Machine) -> String {
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
    lines.concat()
}

fn bodies(
    machine: &Machine,
    natives: &[Native],
    parent: Option<usize>,
    indent: &str,
    text: &mut String,
) {
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
        let _ = writeln!(text, "{inner}{}", moving(joint, &natives[k]));
        sites(machine, Some(k), &inner, text);
        loop_constraints::sites(machine, Some(k), &inner, text);
        bodies(machine, natives, Some(k), &inner, text);
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

/// Whether MuJoCo refuses a link for having nothing that resists.
fn is_massless(body: &Inertia) -> bool {
    body.mass() == 0.0 && body.tensor() == Matrix3::zeros()
}

fn inertial(body: &Inertia) -> String {
    if is_massless(body) {
        let [mass, moment] = LEAST_BODY;
        return format!(
            "<inertial pos=\"0 0 0\" mass=\"{mass:?}\" diaginertia=\"{moment:?} {moment:?} {moment:?}\"/>"
        );
    }
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

fn moving(joint: &MachineJoint, native: &Native) -> String {
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
    let spring = match native.stiffness {
        0.0 => String::new(),
        stiffness => format!(
            " stiffness=\"{stiffness:?}\" springref=\"{:?}\"",
            native.rest
        ),
    };
    format!(
        "<joint name=\"{}\" type=\"{kind}\" axis=\"{}\"{range} armature=\"{:?}\" damping=\"{:?}\" \
         frictionloss=\"{:?}\"{spring}/>",
        escaped(&joint.name),
        triple(&Vector3::from(joint.axis)),
        native.armature,
        native.damping,
        native.friction
    )
}

/// What MJCF has no place for.
fn lost(machine: &Machine) -> Vec<String> {
    let mut notes = Vec::new();
    for joint in &machine.joints {
        let mut names: Vec<String> = Vec::new();
        for effect in &joint.effects {
            let kept = KEPT.iter().find(|term| of_term(**term).id == effect.id);
            let kept = kept.map_or(&[][..], |term| term::written(*term));
            let has_place =
                term::is_drive_gain(effect) || (term::is_delay(effect) && term::delay(joint) > 0.0);
            if has_place && machine.coupling.is_none() {
                continue;
            }
            let other = effect.parameters.iter().filter(|p| p.value != 0.0);
            let other = other.filter(|p| !kept.iter().any(|known| known.name == p.name));
            names.extend(other.map(|p| format!("{}.{} = {}", effect.id, p.name, p.value)));
        }
        if machine.coupling.is_some() {
            let constant = joint.torque_constant;
            names.extend(constant.map(|k| format!("torque constant {k} N·m/A")));
            let controller = joint.controller.iter();
            names.extend(controller.map(|of| format!("controller kp = {}, kd = {}", of.kp, of.kd)));
        }
        if !names.is_empty() {
            notes.push(format!("{}: lost: {}", joint.name, names.join(", ")));
        }
    }
    if machine.coupling.is_some() {
        notes.push(
            "lost: the coupling of motors, and with it the actuators; armature, damping and frictionloss act on joints here, on \
             motors in the model"
                .to_string(),
        );
    }
    if machine.coupling.is_none() {
        notes.push(format!("ctrl holds {}", held_by_ctrl(machine)));
    }
    notes.extend(massless(machine));
    if machine.home.is_some() {
        notes.push("the loops are closed at the keyframe `home`: start there, or at positions that close them".to_string());
    }
    let bare: Vec<&str> = (machine.joints.iter().zip(bare(machine)))
        .filter(|(_, bare)| *bare)
        .map(|(joint, _)| joint.name.as_str())
        .collect();
    if !bare.is_empty() {
        notes.push(format!(
            "{}: with {LOOPED} of the least rotor's armature, as nothing else resists them and MuJoCo lets loops give then",
            bare.join(", ")
        ));
    }
    if machine.payload.is_some() {
        notes.push("the load is part of the link that carries it".to_string());
    }
    notes.push("shapes and meshes are not written".to_string());
    notes
}
