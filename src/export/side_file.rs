//! The parts of a model that a robot description has no place for, as a problem file of this program: drives with their values,
//! gravity, coupling, load. `exid simulate` and `exid fit` read it as it is.

use crate::export::File;
use crate::export::error::ExportError;
use crate::outcome::machine::{Machine, MachineController, MachineLoad};
use crate::robot::inertia::Inertia;
use serde::Serialize;
use std::collections::BTreeMap;

#[derive(Serialize)]
struct Document<'a> {
    name: &'a str,
    robot: Robot<'a>,
    drive: Drive<'a>,
    controller: Option<Controller>,
}

#[derive(Serialize)]
struct Controller {
    kp: Vec<f64>,
    kd: Vec<f64>,
}

#[derive(Serialize)]
struct Robot<'a> {
    urdf: &'a str,
    gravity: [f64; 3],
    inertials: &'static str,
    payload: Option<&'a str>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    locked: BTreeMap<&'a str, f64>,
}

#[derive(Serialize)]
struct Drive<'a> {
    torque_constant: Option<Vec<f64>>,
    offset: Option<Vec<f64>>,
    coupling: Option<Vec<Vec<f64>>>,
    effects_of: BTreeMap<&'a str, Vec<&'a str>>,
    values: BTreeMap<String, f64>,
}

/// The problem file beside the robot description `urdf`.
///
/// # Errors
/// Where the document cannot be encoded.
pub fn write(machine: &Machine, name: &str, urdf: &str) -> Result<File, ExportError> {
    let file = format!("{name}.problem.toml");
    let joints = &machine.joints;
    let locked = joints
        .iter()
        .filter_map(|j| Some((j.name.as_str(), j.locked?)));
    // Joints that follow others have no place in the arrays: the robot file says how they move.
    let motors: Vec<usize> = (0..joints.len())
        .filter(|&k| joints[k].follows.is_none())
        .collect();
    let with_motors = || motors.iter().map(|&k| &joints[k]);
    let shifted = with_motors().any(|j| j.locked.is_none() && j.offset != 0.0);
    let coupling = machine.coupling.as_ref().map(|rows| {
        let row = |&k: &usize| motors.iter().map(|&c| rows[k][c]).collect::<Vec<f64>>();
        motors.iter().map(row).collect::<Vec<_>>()
    });
    let is_identity = |rows: &Vec<Vec<f64>>| {
        let entries = rows.iter().enumerate();
        let mut entries = entries.flat_map(|(i, row)| row.iter().enumerate().map(move |e| (i, e)));
        entries.all(|(i, (j, v))| *v == f64::from(u8::from(i == j)))
    };
    let effects = with_motors().map(|joint| {
        let ids = joint.effects.iter().map(|e| e.id.as_str());
        (joint.name.as_str(), ids.collect())
    });
    let controllers: Option<Vec<MachineController>> = with_motors().map(|j| j.controller).collect();
    let document = Document {
        name,
        robot: Robot {
            urdf,
            gravity: machine.gravity,
            inertials: "known",
            payload: machine.payload.as_ref().map(|load| load.frame.as_str()),
            locked: locked.collect(),
        },
        drive: Drive {
            torque_constant: with_motors().map(|j| j.torque_constant).collect(),
            offset: shifted.then(|| with_motors().map(|j| j.offset).collect()),
            coupling: coupling.filter(|rows| !is_identity(rows)),
            effects_of: effects.collect(),
            values: values(machine),
        },
        controller: controllers.map(|all| Controller {
            kp: all.iter().map(|of| of.kp).collect(),
            kd: all.iter().map(|of| of.kd).collect(),
        }),
    };
    let text = toml::to_string(&document).map_err(|e| ExportError::not_encodable(&file, e))?;
    let text = format!(
        "# What {urdf} has no place for. `exid simulate` and `exid fit` read this file.\n{text}"
    );
    Ok(File { name: file, text })
}

fn values(machine: &Machine) -> BTreeMap<String, f64> {
    let mut values = BTreeMap::new();
    for joint in &machine.joints {
        for effect in &joint.effects {
            for parameter in &effect.parameters {
                let name = format!("{}.{}.{}", joint.name, effect.id, parameter.name);
                values.insert(name, parameter.value);
            }
        }
    }
    if let Some(load) = &machine.payload {
        values.extend(of_load(load));
    }
    values
}

/// Mass, centre of mass and inertia about it; a load of no mass has nothing to say.
fn of_load(load: &MachineLoad) -> Vec<(String, f64)> {
    let Some(body) = Inertia(load.body).central() else {
        return Vec::new();
    };
    let mut values = vec![("payload.mass".to_string(), body.mass)];
    let letters = ["x", "y", "z"];
    for (k, letter) in letters.iter().enumerate() {
        values.push((format!("payload.com_{letter}"), body.centre[k]));
        for (l, other) in letters.iter().enumerate().skip(k) {
            let name = format!("payload.inertia_{letter}{other}");
            values.push((name, body.tensor[(k, l)]));
        }
    }
    values
}
