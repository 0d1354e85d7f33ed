//! The robot as source code: inverse dynamics, from motion to the signal of the motors, and the law of the drives
//! forwards, from signal and motion of the joints to the torques that move the links.
//!
//! Bodies are one straight line of arithmetic. What the drives remember stands in one array of numbers, all zero at the
//! start: time, whether a step was made, bristles, lags of links with the two values before, signals on their way. With
//! lag both directions solve the same equations, those of the backward difference of second order, for its value at the
//! end of the step.

mod bodies;
mod driving;
mod lag;
mod layout;
mod motors;
mod names;
mod plugin;
mod writer;

use crate::chain::effect::CROSSTALK;
use crate::chain::words::short;
use crate::export::code::layout::{Layout, SHORTEST_STEP};
use crate::export::code::names::identifier;
pub use crate::export::code::plugin::{Plugin, plugin};
use crate::export::code::writer::Writer;
use crate::export::drive::Drives;
use crate::export::error::ExportError;
use crate::export::identified::Identified;
use crate::export::language::Language;
use crate::export::values::Values;
use crate::export::{Export, File, term};
use crate::outcome::machine::{Machine, MachineController};

/// The code of a machine in a language; C has a header beside it.
///
/// # Errors
/// Effects or parameters that the result does not hold.
pub fn write(robot: Identified<'_>, language: Language) -> Result<Export, ExportError> {
    let Identified {
        name,
        machine,
        catalogue,
    } = robot;
    let prefix = identifier(name);
    let drives = Drives::of(machine, catalogue, Values::Numbers)?;
    let layout = Layout::of(&drives);
    let writer = Writer {
        machine,
        language,
        prefix: &prefix,
        drives: &drives,
        layout: &layout,
    };
    let mut files = vec![File {
        name: format!("{prefix}.{}", language.extension()),
        text: writer.source(name),
    }];
    if language == Language::C {
        files.push(File {
            name: format!("{prefix}.h"),
            text: writer.header(name),
        });
    }
    let mut notes = notes(machine, &drives);
    notes.extend(controllers(machine));
    Ok(Export { files, notes })
}

/// What the signals of position controllers are, which programs of drives are given and give as torques.
fn controllers(machine: &Machine) -> impl Iterator<Item = String> {
    machine.joints.iter().filter_map(|joint| {
        let MachineController { kp, kd } = joint.controller?;
        let late = match term::delay(joint) {
            0.0 => String::new(),
            delay => format!("; commands act {delay} s after they are given"),
        };
        Some(format!(
            "{}: its signal is here the torque of its position controller, {kp}·(command − position) + {kd}·(commanded speed − \
             speed) + feed-forward{late}",
            joint.name
        ))
    })
}

/// What a user of the code has to know of the drives.
fn notes(machine: &Machine, drives: &Drives) -> Vec<String> {
    let mut notes = Vec::new();
    for (joint, drive) in machine.joints.iter().zip(&drives.drives) {
        let name = &joint.name;
        if drive.delay > 0.0 {
            notes.push(format!(
                "{name}: the recorded signal was {} s late: what inverse_step returns is read that much later, and \
                 drive_step takes the signal as it acts at the motor, not as it was recorded",
                short(drive.delay)
            ));
        }
        if joint.effects.iter().any(|effect| effect.id == CROSSTALK.id) {
            notes.push(format!(
                "{name}: the recorded signal has shares of other joints' in it, and so have the signals that inverse_step \
                 gives and drive_step takes; what a controller commands has none"
            ));
        }
        if drive.delay < 0.0 {
            notes.push(format!(
                "{name}: the signal acts {} s after it is given: drive_step holds it back, in steps of {SHORTEST_STEP} s \
                 and more of one length; inverse_step returns what is to be given that much earlier",
                short(-drive.delay)
            ));
        }
    }
    notes
}
