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
mod writer;

use crate::export::code::layout::{Layout, SHORTEST_STEP};
use crate::export::code::names::{identifier, in_comment};
use crate::export::code::writer::Writer;
use crate::export::drive::Drives;
use crate::export::error::ExportError;
use crate::export::identified::Identified;
use crate::export::language::Language;
use crate::export::{Export, File, term};
use crate::outcome::machine::{Machine, MachineController, MachineJoint};
use crate::outcome::provenance::VERSION;

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
    let drives = Drives::of(machine, catalogue)?;
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
pub fn notes(machine: &Machine, drives: &Drives) -> Vec<String> {
    let mut notes = Vec::new();
    for (joint, drive) in machine.joints.iter().zip(&drives.drives) {
        let name = &joint.name;
        if drive.delay > 0.0 {
            notes.push(format!(
                "{name}: the recorded signal was {} s late: what inverse_step returns is read that much later, and \
                 drive_step takes the signal as it acts at the motor, not as it was recorded",
                drive.delay
            ));
        }
        if drive.delay < 0.0 {
            notes.push(format!(
                "{name}: the signal acts {} s after it is given: drive_step holds it back, in steps of {SHORTEST_STEP} s \
                 and more of one length; inverse_step returns what is to be given that much earlier",
                -drive.delay
            ));
        }
    }
    notes
}

/// What position controllers make of commands, in C; other motors are given their signals.
fn signals(machine: &Machine, drives: &Drives) -> String {
    let head = "/* Signals of the motors from ctrl, where the joints are. */\nstatic void exid_signals(const double *ctrl, const double \
                *q, const double *v, double *signal) {\n";
    if machine
        .joints
        .iter()
        .all(|joint| joint.controller.is_none())
    {
        return format!(
            "{head}    (void)q, (void)v;\n    for (int j = 0; j < EXID_JOINTS; j++) signal[j] = ctrl[j];\n}}\n"
        );
    }
    let mut text = head.to_string();
    for (j, joint) in machine.joints.iter().enumerate() {
        let MachineController { kp, kd } = joint.controller.unwrap_or_default();
        let row = drives.inverse.row(j);
        let terms = row.iter().enumerate().filter(|(_, share)| **share != 0.0);
        let terms = terms.map(|(i, share)| {
            format!("{share:?} * ({kp:?} * (ctrl[{i}] - q[{i}]) - {kd:?} * v[{i}])")
        });
        let terms: Vec<String> = terms.collect();
        text.push_str(&format!("    signal[{j}] = {};\n", terms.join(" + ")));
    }
    text + "}\n"
}

/// The source of a plugin: the drives in C, and `glue` that calls them, with its change of speed for slopes.
///
/// # Errors
/// Effects or parameters that the result does not hold.
pub fn plugin(robot: Identified<'_>, glue: &str, change: f64) -> Result<String, ExportError> {
    let Identified {
        name,
        machine,
        catalogue,
    } = robot;
    let drives = Drives::of(machine, catalogue)?;
    let layout = Layout::of(&drives);
    let writer = Writer {
        machine,
        language: Language::C,
        prefix: "exid",
        drives: &drives,
        layout: &layout,
    };
    let is_late = |joint: &MachineJoint| joint.controller.is_some() && term::delay(joint) > 0.0;
    let held_back = match machine.joints.iter().any(is_late) {
        true => "#define EXID_HELD_BACK 1\n",
        false => "",
    };
    let mut parts = vec![format!(
        "/* Drives of {}, written by exid {VERSION}, as an actuator plugin of MuJoCo. Compile and load it:\n\n   \
         MJ=$(python -c \"import mujoco, os; print(os.path.dirname(mujoco.__file__))\")\n   \
         cc -O2 -shared -fPIC -I$MJ/include exid_drive.c -o libexid_drive.so -L$MJ \
         -l:$(basename $MJ/libmujoco.so.?*) -lm\n   \
         python -c \"import mujoco; mujoco.mj_loadPluginLibrary('./libexid_drive.so')\" */\n\n\
         #include <math.h>\n#include <mujoco/mujoco.h>\n\n#define EXID_JOINTS {}\n#define EXID_STATES {}\n\
         #define EXID_SPEED_CHANGE {change:?}\n{held_back}\n{}",
        in_comment(name),
        writer.joints(),
        layout.size,
        Language::C.helpers()
    )];
    if !writer.members().is_empty() {
        parts.push(writer.drive_miss());
    }
    parts.push(writer.drive_step());
    parts.push(signals(machine, &drives));
    parts.push(glue.to_string());
    Ok(parts.join("\n"))
}
