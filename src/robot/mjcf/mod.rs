//! Reads MJCF, the robot format of MuJoCo: bodies, joints, inertias, gravity, drives and couplings.
//!
//! A body with the joints 1 to m stands in its parent at
//!
//! ```text
//! T(q) = T_body · J₁(q₁) · … · J_m(q_m)
//! hinge   J = Trans(p) · Rot(a, q − ref) · Trans(−p)
//! slide   J = Trans(a (q − ref))
//! ```
//!
//! with anchor p and axis a in the frame of the body. Links without mass stand between several joints of one body, and a
//! link with its frame at the anchor stands before a body whose anchor is not its origin. Contacts, sensors, cameras and
//! looks are passed over; physics that the tree has no place for is in the notes.
//!
//! Order of the files: `document` puts includes together, `settings` finds attributes through classes, `compiler`
//! has what holds for the whole model, `pose`, `geom`, `mesh` and `inertia` make bodies, `joint` joints,
//! `body` walks the tree, `actuator` and `equality` read what acts on it.

mod actuator;
mod body;
mod compiler;
mod document;
mod equality;
mod geom;
mod inertia;
mod joint;
mod mesh;
mod messages;
mod model;
mod pose;
mod settings;

use crate::robot::assemble::{RawRobot, assemble};
use crate::robot::dependents;
use crate::robot::description::{Description, Held, Note, Weight};
use crate::robot::error::RobotError;
use crate::robot::mjcf::body::Bodies;
use crate::robot::mjcf::compiler::Compiler;
use crate::robot::mjcf::document::Document;
use crate::robot::mjcf::messages::note;
use crate::robot::mjcf::model::{Meshes, Model};
use crate::robot::mjcf::settings::Classes;
use std::path::Path;

/// Reads an MJCF file and the files that it includes.
///
/// # Errors
/// Files that cannot be read or are no MJCF; elements that the tree cannot have; values that are wrong.
pub fn read(path: &Path) -> Result<Description, RobotError> {
    let document = Document::read(path)?;
    let classes = Classes::of(&document)?;
    let compiler = Compiler::of(&document)?;
    let model = Model {
        meshes: Meshes::of(&document, &classes)?,
        document: &document,
        classes: &classes,
        compiler: &compiler,
    };
    let mut bodies = Bodies::walk(&model)?;
    let equalities = equality::of(&model, &bodies)?;
    actuator::apply(&model, &mut bodies)?;
    let root = document.root();
    let raw = RawRobot {
        path,
        name: document
            .attribute(root, "model")
            .unwrap_or("robot")
            .to_string(),
        links: bodies.links,
        joints: bodies.joints,
    };
    let tree = assemble(&raw, |id| document.place(id))?.with_gravity(compiler.gravity);
    let resolved = dependents::resolve(&tree, &bodies.still, &equalities.dependents)?;
    let mut held = resolved.held;
    held.extend(equalities.held.iter().filter_map(|stated| {
        Some(Held {
            joint: tree.joint_index(&stated.joint)?,
            position: stated.position,
        })
    }));
    let drives = tree
        .joints()
        .iter()
        .map(|joint| bodies.drives.get(&joint.name).copied().unwrap_or_default())
        .collect();
    let mut notes = bodies.notes;
    notes.extend(equalities.notes);
    notes.extend(left_out(&document, &compiler)?);
    Ok(Description {
        tree,
        dependents: resolved.dependents,
        held,
        drives,
        notes,
        files: document.files().to_vec(),
    })
}

/// Physics of whole sections that the model lacks.
fn left_out(document: &Document, compiler: &Compiler) -> Result<Vec<Note>, RobotError> {
    let mut notes = Vec::new();
    for tendon in document.within(document.root(), "tendon") {
        let acts = ["stiffness", "damping", "frictionloss", "armature"];
        for &id in document.children(tendon) {
            let found = acts.into_iter().find(|name| {
                let values = document.attribute(id, name).unwrap_or("0");
                values.split_whitespace().any(|v| v.parse() != Ok(0.0))
            });
            if let Some(name) = found {
                let message = format!("the {name} of a tendon is not in the model");
                let remedy = "lay it on the joints that it spans, or leave these joints out";
                notes.push(note(document.place(id), Weight::LeftOut, message, remedy));
            }
        }
    }
    for section in document.within(document.root(), "deformable") {
        let message = "deformable bodies are not in the model".to_string();
        let remedy = "leave them out, or give the links their mass";
        notes.push(note(
            document.place(section),
            Weight::LeftOut,
            message,
            remedy,
        ));
    }
    if let Some(id) = compiler.fluid {
        let message =
            "the forces of the medium (density, viscosity, wind) are not in the model".to_string();
        let remedy = "add viscous_friction to drive.effects where they matter";
        notes.push(note(document.place(id), Weight::LeftOut, message, remedy));
    }
    Ok(notes)
}
