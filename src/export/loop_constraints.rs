//! Closed loops as constraints of MJCF: `connect` between sites, tendons of one length, joints of one position.

use crate::export::xml::{escaped, triple};
use crate::outcome::machine::{Machine, MachineAnchor, MachineLoop};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use std::fmt::Write;

/// Distance of the second site of a hinge along its axis, m: two points that are one hold an axis as well.
const APART: f64 = 0.1;

/// How stiff MuJoCo holds a loop: within two steps of 2 ms, its shortest, and to a thousandth of what pulls; its own values are for
/// contacts, and give by centimetres under the weight of a platform.
const STIFF: &str = "solref=\"0.004 1\" solimp=\"0.999 0.9999 0.001\"";

/// A site at which a loop is closed.
struct Site {
    link: Option<usize>,
    name: String,
    point: Vector3<f64>,
}

/// Pairs of sites that are one, or that a rod holds apart.
fn pairs(number: usize, closed: &MachineLoop) -> Vec<[Site; 2]> {
    let pair = |index: usize, shift: [Vector3<f64>; 2], ends: &[MachineAnchor; 2]| {
        let site = |k: usize| Site {
            link: ends[k].link,
            name: format!("loop_{}_{}_{}", number + 1, index + 1, ["a", "b"][k]),
            point: Vector3::from(ends[k].point) + shift[k],
        };
        [site(0), site(1)]
    };
    let none = [Vector3::zeros(); 2];
    match closed {
        MachineLoop::Ball { ends } | MachineLoop::Rod { ends, .. } => vec![pair(0, none, ends)],
        MachineLoop::Hinge { ends, axes } => {
            let along = axes.map(|axis| Vector3::from(axis) * APART);
            vec![pair(0, none, ends), pair(1, along, ends)]
        }
        MachineLoop::Equal { .. } => Vec::new(),
    }
}

/// The sites of a link, or of the base.
pub fn sites(machine: &Machine, carrier: Option<usize>, indent: &str, text: &mut String) {
    let loops = machine.loops.iter().enumerate();
    let all = loops
        .flat_map(|(number, closed)| pairs(number, closed))
        .flatten();
    for site in all.filter(|site| site.link == carrier) {
        // A text takes whatever is written to it.
        let _ = writeln!(
            text,
            "{indent}<site name=\"{}\" pos=\"{}\"/>",
            site.name,
            triple(&site.point)
        );
    }
}

/// The elements of `equality`.
pub fn equalities(machine: &Machine) -> String {
    let mut lines = Vec::new();
    for (number, closed) in machine.loops.iter().enumerate() {
        match closed {
            MachineLoop::Equal { joints } => {
                let [a, b] = joints.map(|j| escaped(&machine.joints[j].name));
                lines.push(format!(
                    "<joint joint1=\"{b}\" joint2=\"{a}\" polycoef=\"0 1 0 0 0\" {STIFF}/>"
                ));
            }
            MachineLoop::Rod { ends, length } => {
                // MuJoCo counts from the length at the positions of zero.
                let beyond = length - distance(machine, ends);
                lines.push(format!(
                    "<tendon tendon1=\"rod_{}\" polycoef=\"{beyond:?} 0 0 0 0\" {STIFF}/>",
                    number + 1
                ));
            }
            MachineLoop::Ball { .. } | MachineLoop::Hinge { .. } => {
                let connected = pairs(number, closed).into_iter();
                lines.extend(connected.map(|[a, b]| {
                    format!(
                        "<connect site1=\"{}\" site2=\"{}\" {STIFF}/>",
                        a.name, b.name
                    )
                }));
            }
        }
    }
    let lines = lines.iter().map(|line| format!("    {line}\n"));
    lines.collect()
}

/// The tendons that are rods.
pub fn rods(machine: &Machine) -> String {
    let mut text = String::new();
    for (number, closed) in machine.loops.iter().enumerate() {
        if let (MachineLoop::Rod { .. }, [[a, b]]) = (closed, &pairs(number, closed)[..]) {
            let _ = writeln!(
                text,
                "    <spatial name=\"rod_{}\"><site site=\"{}\"/><site site=\"{}\"/></spatial>",
                number + 1,
                a.name,
                b.name
            );
        }
    }
    if text.is_empty() {
        return text;
    }
    format!("  <tendon>\n{text}  </tendon>\n")
}

/// Distance of two anchors while all positions are zero, m.
fn distance(machine: &Machine, ends: &[MachineAnchor; 2]) -> f64 {
    let [a, b] = [0, 1].map(|k| {
        let mut at = Point3::from(Vector3::from(ends[k].point));
        let mut link = ends[k].link;
        while let Some(joint) = link {
            let pose = &machine.joints[joint].pose;
            let turn = UnitQuaternion::from_rotation_matrix(&pose.rotation());
            at = Isometry3::from_parts(pose.translation().into(), turn) * at;
            link = machine.joints[joint].parent;
        }
        at
    });
    (b - a).norm()
}
