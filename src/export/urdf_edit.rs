//! Editing a URDF: the text of the file stays, inertials and losses are replaced in it.

use crate::chain::effect::knowledge::JointTerm;
use crate::export::error::ExportError;
use crate::export::term;
use crate::fault::Place;
use crate::outcome::machine::{Machine, MachineJoint};
use crate::robot::error::{RobotError, RobotErrorKind};
use crate::robot::inertia::Inertia;
use crate::robot::urdf::inertial;
use roxmltree::{Document, Node};
use std::ops::Range;
use std::path::Path;

/// The robot file with the bodies and the friction of the machine.
///
/// # Errors
/// Where the text is not XML.
pub fn dress(machine: &Machine, text: &str) -> Result<String, ExportError> {
    let document = Document::parse(text).map_err(|e| not_xml(machine, &e))?;
    let root = document.root_element();
    let mut edits: Vec<(Range<usize>, String)> = Vec::new();
    for node in root.children().filter(|n| n.has_tag_name("link")) {
        edits.extend(link(machine, node, text));
    }
    for node in root.children().filter(|n| n.has_tag_name("joint")) {
        let moving = machine.joints.iter();
        let joint = moving
            .into_iter()
            .find(|j| node.attribute("name") == Some(&j.name));
        edits.extend(joint.map(|joint| losses(joint, node, text)));
    }
    Ok(apply(text, edits))
}

fn not_xml(machine: &Machine, error: &roxmltree::Error) -> ExportError {
    let file = machine.description.as_ref().map_or("", |d| &d.file);
    let reason = error.to_string();
    let place = Place::file(Path::new(file));
    ExportError::from(RobotError::new(place, RobotErrorKind::NotXml { reason }))
}

/// A moving link gets its body; a link that is fixed to one has given its own away.
fn link(machine: &Machine, node: Node<'_, '_>, text: &str) -> Option<(Range<usize>, String)> {
    let name = node.attribute("name")?;
    let old = node.children().find(|n| n.has_tag_name("inertial"));
    let moving = machine.joints.iter().find(|joint| joint.link == name);
    if let Some(joint) = moving {
        let body = inertial(&Inertia(joint.body));
        return Some(match old {
            Some(old) => (old.range(), body),
            None => inside(node, text, &body),
        });
    }
    let frame = machine.frames.iter().find(|frame| frame.name == name)?;
    match (frame.joint, old) {
        (Some(_), Some(old)) => Some((old.range(), String::new())),
        _ => None,
    }
}

fn losses(joint: &MachineJoint, node: Node<'_, '_>, text: &str) -> (Range<usize>, String) {
    let element = dynamics(joint);
    match node.children().find(|n| n.has_tag_name("dynamics")) {
        Some(old) => (old.range(), element),
        None => inside(node, text, &element),
    }
}

/// The edit that puts an element first into a node, which may have been written without content.
fn inside(node: Node<'_, '_>, text: &str, element: &str) -> (Range<usize>, String) {
    let Range { start, end } = node.range();
    if let Some(first) = node.first_child() {
        let at = first.range().start;
        return (at..at, format!("\n    {element}"));
    }
    let tag = node.tag_name().name();
    let written = &text[start..end];
    match written.strip_suffix("/>") {
        Some(opening) => {
            let filled = format!("{opening}>\n    {element}\n  </{tag}>");
            (start..end, filled)
        }
        None => {
            let closing = written.rfind("</").map_or(end, |offset| start + offset);
            (closing..closing, format!("\n    {element}\n  "))
        }
    }
}

/// Edits do not overlap: each belongs to another element.
fn apply(text: &str, mut edits: Vec<(Range<usize>, String)>) -> String {
    edits.sort_by_key(|(range, _)| range.start);
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    for (range, replacement) in edits {
        out.push_str(&text[at..range.start]);
        out.push_str(&replacement);
        at = range.end;
    }
    out.push_str(&text[at..]);
    out
}

/// The element of the losses of a joint.
pub(super) fn dynamics(joint: &MachineJoint) -> String {
    let size = |term| term::size(joint, term).unwrap_or(0.0);
    format!(
        "<dynamics damping=\"{:?}\" friction=\"{:?}\"/>",
        size(JointTerm::ViscousFriction),
        size(JointTerm::DryFriction)
    )
}
