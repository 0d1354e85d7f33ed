//! The identified robot in the formats of others: URDF, MJCF, TOML, and code of its dynamics.
//!
//! Each format takes what it has a place for; what it has none for stands in a side file or in the notes,
//! never silently left out.

mod code;
mod drive;
pub mod error;
mod file;
mod identified;
mod language;
mod loop_constraints;
mod mjcf;
mod mujoco;
mod program;
mod regroup;
mod side_file;
mod symbol;
pub mod table;
mod tape;
mod term;
mod urdf;
mod urdf_edit;
mod values;
mod xml;

use crate::chain::effect::{Law, Power, TILT, find};
use crate::export::error::ExportError;
pub use crate::export::file::{Export, File};
use crate::export::identified::Identified;
use crate::export::language::Language;
use crate::outcome::machine::Machine;
use crate::outcome::{Outcome, Part};
use crate::setup::laws;

/// Formats of `--to`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// URDF with the identified inertias, friction and damping.
    Urdf,
    /// MJCF with armature, damping and frictionloss.
    Mjcf,
    /// The bodies as MJCF, and the drives in full as the C source of an actuator plugin.
    Mujoco,
    /// A table of all numbers.
    Toml,
    /// Source code of inverse dynamics in Rust.
    Rust,
    /// Source code of inverse dynamics in C.
    C,
    /// Source code of inverse dynamics in Python.
    NumPy,
}

/// Writes the robot of a result in a format.
///
/// # Errors
/// Where the result identified no robot, or the robot's own file does not read any more.
pub fn export(outcome: &Outcome, format: Format) -> Result<Export, ExportError> {
    let identified = outcome.machine().ok_or_else(|| ExportError::NoRobot {
        name: outcome.name.clone(),
        verb: outcome.part.verb(),
    })?;
    let is_of_trees = !matches!(format, Format::Urdf | Format::Mjcf | Format::Toml);
    if is_of_trees && !identified.loops.is_empty() {
        return Err(ExportError::ClosedLoops {
            name: outcome.name.clone(),
        });
    }
    // MuJoCo does not load bodies that are not possible.
    let nearest = match format {
        Format::Mjcf | Format::Mujoco => outcome.possible_machine(),
        _ => None,
    };
    let machine = nearest.unwrap_or(identified);
    // Results of earlier versions did not keep the angles of a tilted base with their robots.
    let angle = format!("{}.{}", TILT.id, TILT.parameters[0].name);
    let tilted = outcome.estimate.parameters.iter().find(|p| p.name == angle);
    if let (Some(tilt), None) = (tilted, &machine.tilt) {
        return Err(ExportError::Incomplete {
            joint: "the base".to_string(),
            parameter: tilt.name.clone(),
        });
    }
    let name = outcome.name.as_str();
    let catalogue = laws::kept(&outcome.run.problem).map_err(ExportError::Laws)?;
    let robot = Identified {
        name,
        machine,
        catalogue: &catalogue,
    };
    let mut export = match format {
        Format::Urdf => urdf::write(machine, name)?,
        Format::Mjcf => mjcf::write(machine, name),
        Format::Mujoco => mujoco::write(robot)?,
        Format::Toml => table::write(machine, name, &outcome.estimate.parameters)?,
        Format::Rust => code::write(robot, Language::Rust)?,
        Format::C => code::write(robot, Language::C)?,
        Format::NumPy => code::write(robot, Language::NumPy)?,
    };
    export.notes.extend(nearest.map(|_| NEAREST.to_string()));
    if !machine.loops.is_empty() && format != Format::Mjcf {
        export.notes.push(CUT.to_string());
    }
    export.notes.extend(caveats(machine));
    export.notes.extend(beyond_physics(robot));
    export.notes.extend(nameless(outcome));
    Ok(export)
}

const NEAREST: &str = "no set of real bodies has the fitted base parameters: the robot is the possible one that is nearest by the \
                       covariance of the fit, friction moved along with its bodies";

const CUT: &str =
    "the file has the tree that the loops were cut to: what reads it has to close them again";

/// What a diagnosis found and has no law for.
fn nameless(outcome: &Outcome) -> Option<String> {
    let Part::Diagnose(diagnosis) = &outcome.part else {
        return None;
    };
    let found = diagnosis.findings.iter().filter(|f| f.has_no_name());
    let joints: Vec<String> = found.flat_map(|f| f.joints.clone()).collect();
    (!joints.is_empty()).then(|| {
        format!(
            "{}: what the recordings show beyond the laws of the vocabulary has no name and is not in the export",
            joints.join(", ")
        )
    })
}

/// What was estimated without the limits of physics and lies beyond them.
fn beyond_physics(robot: Identified<'_>) -> Vec<String> {
    let mut notes = Vec::new();
    for joint in &robot.machine.joints {
        for effect in &joint.effects {
            let Some(known) = robot.catalogue.find(&effect.id) else {
                continue;
            };
            let drives = match known.law {
                Law::Motor(law) | Law::Joint(law) if law.power() == Power::Dissipates => {
                    ", it drives where it should brake, and simulated motions may grow"
                }
                _ => "",
            };
            let beyond = known.parameters.iter().filter_map(|info| {
                let value = joint.value(&effect.id, info.name)?;
                let words = info.beyond_physics(value)?;
                Some(format!(
                    "{}: {}.{} = {words}{drives}; estimator = \"feasible\" keeps such limits",
                    joint.name, effect.id, info.name
                ))
            });
            notes.extend(beyond);
        }
    }
    notes
}

/// What holds of the model in every format.
fn caveats(machine: &Machine) -> Vec<String> {
    let mut notes = Vec::new();
    if machine.feasible == Some(false) {
        notes.push(
            "no set of real bodies has these base parameters: torques are right, but simulators may refuse \
             the bodies or become unstable with them; fit with estimator = \"feasible\" for bodies"
                .to_string(),
        );
    }
    for joint in &machine.joints {
        if let Some(position) = joint.locked {
            notes.push(format!(
                "{} stood still at {position} in every recording: the model holds at that position only",
                joint.name
            ));
        }
        let is_zero = |id: &str| find(id).is_some_and(|e| matches!(e.law, Law::Encoder));
        let zero = joint.effects.iter().find(|effect| is_zero(&effect.id));
        let offset = zero.and_then(|effect| effect.parameters.first());
        if let Some(offset) = offset.map(|p| p.value).filter(|offset| *offset != 0.0) {
            notes.push(format!(
                "positions of {} are where it stands: its encoder shows {offset} less",
                joint.name
            ));
        }
        if let Some(leader) = &joint.follows {
            notes.push(format!(
                "{} has no motor and follows {}: q = {}·q_leader + {}; where there is a value for its own motor, it is zero",
                joint.name, machine.joints[leader.joint].name, leader.multiplier, leader.offset
            ));
        }
    }
    match machine.signal.as_str() {
        "base_wrench" => notes.push(
            "the signal was the base wrench, which says nothing of friction, rotors and drives"
                .to_string(),
        ),
        "link_torque" => notes.push(
            "the signal was of joint torque sensors: rotors are not in it, and friction is what acts \
             behind the sensors"
                .to_string(),
        ),
        _ => {}
    }
    notes
}
