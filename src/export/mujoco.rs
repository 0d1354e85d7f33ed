//! MuJoCo, complete: the bodies with what MJCF has laws for as `model.xml`, and the drives as the C source of an actuator
//! plugin, `exid.drive`, whose numbers stand in the configuration of the plugin in `model.xml`.

use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::{Catalogue, Law, TRANSITION, of_term};
use crate::chain::words::short;
use crate::export::code::Plugin;
use crate::export::drive::Drives;
use crate::export::error::ExportError;
use crate::export::identified::Identified;
use crate::export::mjcf::{self, Actuation, Native};
use crate::export::values::Values;
use crate::export::{Export, File, code, term};
use crate::outcome::machine::{Machine, MachineJoint};

/// The glue between the drives and the simulator.
const PLUGIN: &str = include_str!("exid_drive.c");

/// Change of a speed over which slopes of torques are measured, rad/s (m/s).
const SPEED_CHANGE: f64 = 1e-7;

/// The model and the plugin.
///
/// # Errors
/// Effects or parameters that the result does not hold.
pub fn write(robot: Identified<'_>) -> Result<Export, ExportError> {
    let Identified {
        machine, catalogue, ..
    } = robot;
    let drives = Drives::of(machine, catalogue, Values::Numbers)?;
    let lagging = drives.lagging();
    let mut driven = machine.clone();
    let mut natives = Vec::new();
    for (j, joint) in driven.joints.iter_mut().enumerate() {
        let straight = machine.coupling.is_none() && !lagging.contains(&j);
        let drive = &drives.drives[j];
        let lossless = drive.losses.is_empty() && drive.signal.is_empty();
        natives.push(take(joint, catalogue, straight && lossless));
    }
    let Plugin { source, settings } = code::plugin(
        Identified {
            machine: &driven,
            ..robot
        },
        PLUGIN,
        SPEED_CHANGE,
    )?;
    let text = mjcf::document(&driven, &natives, Actuation::Plugin(&settings));
    let mut notes = vec![
        format!(
            "compile exid_drive.c as its first lines say, and load the library before the model: \
             mujoco.mj_loadPluginLibrary(\"./libexid_drive.so\"); ctrl holds {}",
            mjcf::held_by_ctrl(machine)
        ),
        "numbers of drives that MJCF has no place for are the config of the plugin in model.xml, by the names that results \
         give them: with others, compile nothing again; robots with other joints or effects in one program need plugins of \
         other names"
            .to_string(),
        "the drives act with the velocity at the end of a step of the Euler or implicitfast integrators; with RK4 they are \
         those of the end of the step at every stage"
            .to_string(),
        "shapes and meshes are not written".to_string(),
    ];
    if machine
        .joints
        .iter()
        .any(|joint| joint.controller.is_some())
        && !lagging.is_empty()
    {
        notes.push(
            "position controllers see the links here, not the motors in front of elastic gears"
                .to_string(),
        );
    }
    notes.extend(mjcf::massless(machine));
    if machine.payload.is_some() {
        notes.push("the load is part of the link that carries it".to_string());
    }
    if !lagging.is_empty() || drives.remember() {
        notes.push(
            "elastic gears and play begin with the twist that bears the first signals at rest, bristles without any"
                .to_string(),
        );
    }
    notes.extend(recorded_late(machine));
    Ok(Export {
        files: vec![
            File {
                name: "model.xml".to_string(),
                text,
            },
            File {
                name: "exid_drive.c".to_string(),
                text: source,
            },
        ],
        notes,
    })
}

/// Motors whose signals were recorded later than they acted.
fn recorded_late(machine: &Machine) -> impl Iterator<Item = String> {
    machine.joints.iter().filter_map(|joint| {
        let late = -term::delay(joint);
        (late > 0.0).then(|| {
            format!(
                "{}: the recorded signal was {} s late; ctrl is the signal as it acts at the motor",
                joint.name,
                short(late)
            )
        })
    })
}

/// Takes from a joint what MuJoCo has the same law for: springs at the joint, and where motor and joint are one also
/// rotors, damping and dry friction without a transition.
fn take(joint: &mut MachineJoint, catalogue: &Catalogue, one: bool) -> Native {
    let size = |term| term::size(joint, term);
    let is_lent = |id: &str| {
        let effects = joint.effects.iter();
        let mut effects = effects.filter_map(|e| catalogue.find(&e.id));
        effects.any(|e| e.needs.borrows.iter().any(|(lender, _)| *lender == id))
    };
    let mut native = Native::default();
    let mut taken: Vec<&str> = Vec::new();
    let mut take = |term| taken.push(of_term(term).id);
    if let (Some(stiffness), Some(rest)) = (size(JointTerm::Spring), term::rest(joint))
        && stiffness >= 0.0
        && joint.locked.is_none()
    {
        (native.stiffness, native.rest) = (stiffness, rest);
        take(JointTerm::Spring);
    }
    if let (true, Some(inertia)) = (one, size(JointTerm::RotorInertia))
        && inertia >= 0.0
    {
        native.armature = inertia;
        take(JointTerm::RotorInertia);
    }
    if let (true, Some(damping), false) = (
        one,
        size(JointTerm::ViscousFriction),
        is_lent(of_term(JointTerm::ViscousFriction).id),
    ) && damping >= 0.0
    {
        native.damping = damping;
        take(JointTerm::ViscousFriction);
    }
    let signed = |id: &str| {
        catalogue.find(id).is_some_and(|e| {
            matches!(e.law, Law::Motor(_)) && e.knowledge.term != Some(JointTerm::DryFriction)
        })
    };
    let alone = !joint.effects.iter().any(|e| signed(&e.id));
    if let (true, true, Some(friction), Some(0.0)) = (
        one,
        alone,
        size(JointTerm::DryFriction),
        joint.value(TRANSITION.effect.id, TRANSITION.name()),
    ) {
        native.friction = friction;
        take(JointTerm::DryFriction);
    }
    joint.effects.retain(|e| !taken.contains(&e.id.as_str()));
    native
}
