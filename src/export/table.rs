//! Parameters as TOML: bodies, drives and load as engineers and robot controllers ask for them, with their intervals.
//!
//! The load stands in the fields of a controller's tool data: mass, centre of mass in the flange's frame,
//! inertia about the centre of mass, and its principal moments and axes.

use crate::export::error::ExportError;
use crate::export::{Export, File};
use crate::outcome::machine::{
    Machine, MachineController, MachineFrame, MachineJoint, MachineLoad, Motion, Pose,
};
use crate::outcome::parameter::Parameter;
use crate::outcome::provenance::VERSION;
use crate::robot::inertia::{CentralInertia, Inertia, PER_LINK};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The whole model. Every number is in SI units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// Name of the robot.
    pub name: String,
    /// Version of exid that wrote it.
    pub version: String,
    /// Every body can exist; absent where it was not examined.
    pub physically_feasible: Option<bool>,
    /// m/s², in the base frame.
    pub gravity: [f64; 3],
    /// Name of the base link.
    pub base: String,
    /// V of `q = V m + offset`.
    pub coupling: Option<Vec<Vec<f64>>>,
    /// Absent without a load.
    pub load: Option<Load>,
    /// Joints in the order of the tree, parents first.
    pub joint: Vec<Joint>,
    /// Frames that are fixed to a link or to the base.
    pub frame: Vec<MachineFrame>,
    /// Parameters that the recordings determine or that were known: `[value, lower, upper]`, the ends of the
    /// 95 % interval, or `[value]` where it was known.
    pub parameters: BTreeMap<String, Vec<f64>>,
}

/// A body: mass (kg), centre of mass (m), inertia about the centre of mass (kg·m²) in the frame's axes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// kg.
    pub mass: f64,
    /// In the frame, m.
    pub centre_of_mass: [f64; 3],
    /// xx, xy, xz, yy, yz, zz
    pub inertia: [f64; 6],
}

/// A load in the fields of a controller's tool data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// The frame of the fields below.
    pub frame: String,
    /// The joint whose link carries it.
    pub joint: String,
    /// Mass, centre of mass and inertia in that frame.
    #[serde(flatten)]
    pub body: Body,
    /// kg·m², about the centre of mass, the smallest first.
    pub principal_moments: [f64; 3],
    /// Unit vectors of the principal axes in the frame, in the order of the moments; right-handed.
    pub principal_axes: [[f64; 3]; 3],
    /// The frame in the frame of the joint's link.
    pub pose: Pose,
}

/// A joint, its link's body, and its drive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Name of the joint.
    pub name: String,
    /// Name of the link that it carries.
    pub link: String,
    /// The joint that carries the parent link; absent for the base.
    pub parent: Option<String>,
    /// Whether it turns or slides.
    pub motion: Motion,
    /// Unit vector in the link's frame.
    pub axis: [f64; 3],
    /// Least position, rad (m); absent where the robot file states none.
    pub lower: Option<f64>,
    /// Greatest position, rad (m).
    pub upper: Option<f64>,
    /// Greatest speed, rad/s (m/s).
    pub velocity: Option<f64>,
    /// Greatest torque, N·m (N).
    pub effort: Option<f64>,
    /// Position at which it stood still in every recording, rad (m); absent of a joint that moved.
    pub locked: Option<f64>,
    /// N·m/A (N/A) at joint scale; absent where the signal is a torque.
    pub torque_constant: Option<f64>,
    /// Gains of the position controller; absent without one.
    pub controller: Option<MachineController>,
    /// Constant of `q = V m + offset`, rad (m).
    pub offset: f64,
    /// The link's frame in its parent's at position 0.
    pub pose: Pose,
    /// The link with all that is fixed to it.
    pub body: Body,
    /// Effects of the drive and their parameters.
    pub drive: BTreeMap<String, BTreeMap<String, f64>>,
}

/// The model of a machine, with the estimates that it rests on.
///
/// # Errors
/// Where the document cannot be encoded.
pub fn write(
    machine: &Machine,
    name: &str,
    parameters: &[Parameter],
) -> Result<Export, ExportError> {
    let file = format!("{name}.model.toml");
    let table = Table::new(machine, name, parameters);
    let text = toml::to_string(&table).map_err(|e| ExportError::not_encodable(&file, e))?;
    Ok(Export {
        files: vec![File { name: file, text }],
        notes: Vec::new(),
    })
}

impl Table {
    fn new(machine: &Machine, name: &str, parameters: &[Parameter]) -> Self {
        let valued = parameters.iter().filter_map(|p| {
            let value = p.value?;
            let interval = p
                .ci95
                .map_or(vec![value], |[lower, upper]| vec![value, lower, upper]);
            Some((p.name.clone(), interval))
        });
        Self {
            name: name.to_string(),
            version: VERSION.to_string(),
            physically_feasible: machine.feasible,
            gravity: machine.gravity,
            base: machine.base.clone(),
            coupling: machine.coupling.clone(),
            load: machine
                .payload
                .as_ref()
                .map(|load| Load::new(machine, load)),
            joint: machine
                .joints
                .iter()
                .map(|j| Joint::new(machine, j))
                .collect(),
            frame: machine.frames.clone(),
            parameters: valued.collect(),
        }
    }
}

impl Body {
    /// A body whose mass is zero keeps its tensor, about the origin.
    fn of(body: &[f64; PER_LINK]) -> Self {
        let body = Inertia(*body);
        let central = body.central().unwrap_or(CentralInertia {
            mass: 0.0,
            centre: Vector3::zeros(),
            tensor: body.tensor(),
        });
        let entry = |r: usize, c: usize| central.tensor[(r, c)];
        Self {
            mass: central.mass,
            centre_of_mass: central.centre.into(),
            inertia: [
                entry(0, 0),
                entry(0, 1),
                entry(0, 2),
                entry(1, 1),
                entry(1, 2),
                entry(2, 2),
            ],
        }
    }

    fn tensor(&self) -> Matrix3<f64> {
        let [xx, xy, xz, yy, yz, zz] = self.inertia;
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    /// The ten parameters about the origin of the frame.
    pub fn about_origin(&self) -> Inertia {
        Inertia::from_central(&CentralInertia {
            mass: self.mass,
            centre: Vector3::from(self.centre_of_mass),
            tensor: self.tensor(),
        })
    }
}

impl Load {
    fn new(machine: &Machine, load: &MachineLoad) -> Self {
        let body = Body::of(&load.body);
        let eigen = SymmetricEigen::new(body.tensor());
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let axis = |k: usize| eigen.eigenvectors.column(order[k]).into_owned();
        let (first, second) = (axis(0), axis(1));
        let third = first.cross(&second);
        Self {
            frame: load.frame.clone(),
            joint: machine.joints[load.joint].name.clone(),
            body,
            principal_moments: order.map(|k| eigen.eigenvalues[k]),
            principal_axes: [first.into(), second.into(), third.into()],
            pose: load.pose,
        }
    }
}

impl Joint {
    fn new(machine: &Machine, joint: &MachineJoint) -> Self {
        let drive = joint.effects.iter().map(|effect| {
            let values = effect.parameters.iter().map(|p| (p.name.clone(), p.value));
            (effect.id.clone(), values.collect())
        });
        Self {
            name: joint.name.clone(),
            link: joint.link.clone(),
            parent: joint.parent.map(|k| machine.joints[k].name.clone()),
            motion: joint.motion,
            axis: joint.axis,
            lower: joint.lower,
            upper: joint.upper,
            velocity: joint.velocity,
            effort: joint.effort,
            locked: joint.locked,
            torque_constant: joint.torque_constant,
            controller: joint.controller,
            offset: joint.offset,
            pose: joint.pose,
            body: Body::of(&joint.body),
            drive: drive.collect(),
        }
    }
}
