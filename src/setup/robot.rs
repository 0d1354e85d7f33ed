//! The robot of a problem file: its tree, the order of per-joint arrays, the joints that stand still.

use crate::fault::Place;
use crate::mechanism::loops::Mechanism;
use crate::problem_file::choices::Mechanism as Known;
use crate::problem_file::robot::{RobotSource, RobotTable};
use crate::problem_file::{Located, Named, PerJoint, ProblemFile};
use crate::robot::description::{Dependent, Description};
use crate::robot::tree::Tree;
use crate::robot::{mdh, mjcf, urdf};
use crate::setup::error::{Mismatch, SetupError, unknown};
use crate::setup::loops;
use std::path::{Path, PathBuf};

/// A robot as a problem file uses it.
#[derive(Debug, Clone)]
pub struct Robot {
    /// The joints that move, with what is fixed to their links.
    pub tree: Tree,
    /// The robot's file; the problem file of a built-in mechanism.
    pub file: PathBuf,
    /// What the robot's file says beside the tree.
    pub description: Description,
    /// Joint names in the order of the problem file's arrays.
    pub order: Vec<String>,
    /// Position in the tree of each joint of `order`.
    pub position: Vec<usize>,
    /// Position at which a joint is locked, in the order of the tree.
    pub locked: Vec<Option<f64>>,
    /// Motor turns per joint turn, in the order of the tree.
    pub ratio: Option<Vec<f64>>,
    /// The loops of a mechanism; joints without a motor are none of `order`, and locked but for its motion.
    pub mechanism: Option<Mechanism>,
    /// Joints that follow others which move: none of `order`, and locked but for their leaders' motion.
    pub dependents: Vec<Dependent>,
}

/// Reads the robot of a problem file, which may have loops.
pub fn open(problem: &ProblemFile) -> Result<Robot, SetupError> {
    let table = &problem.robot;
    let Source {
        description,
        mechanism: known,
    } = source(problem)?;
    let mut tree = description.tree.clone();
    if let Some(gravity) = &table.gravity {
        tree = tree.with_gravity(gravity.value);
    }
    let all: Vec<String> = tree.joints().iter().map(|j| j.name.clone()).collect();
    let mechanism = match known {
        None => loops::of_tree(table, &tree, &all)?,
        known => known,
    };
    let passive = mechanism.as_ref().map_or(&[][..], |m| m.passive());
    let mut locked = locked(table, &all, passive)?;
    let dependents = follow(table, &description, &mut locked);
    if let (true, Some(entry)) = (locked.iter().all(Option::is_some), table.locked.first()) {
        let place = &entry.value.place;
        return Err(SetupError::mismatch(place, Mismatch::AllLocked));
    }
    let follows = |k: &usize| dependents.iter().any(|d| d.joint == *k);
    let names: Vec<String> = (0..all.len())
        .filter(|k| !passive.contains(k) && !follows(k))
        .map(|k| all[k].clone())
        .collect();
    let order = match &table.joints {
        None => names.clone(),
        Some(listed) => checked_order(listed, &names, &table.locked)?,
    };
    let position = order
        .iter()
        .filter_map(|name| all.iter().position(|n| n == name))
        .collect();
    if let (Some(_), Some(first)) = (&mechanism, dependents.first()) {
        let what = format!(
            "`{}` follows another joint, and closed loops want every joint with or without a motor of its own; \
             lock it with its leader, or leave both out",
            all[first.joint]
        );
        let place = Place::file(&description.files[0]);
        return Err(SetupError::mismatch(&place, Mismatch::Mechanism { what }));
    }
    let mut robot = Robot {
        tree,
        file: description.files[0].clone(),
        description,
        dependents,
        order,
        position,
        locked,
        ratio: None,
        mechanism,
    };
    robot.ratio = robot.per_joint(&problem.drive.ratio)?;
    Ok(robot)
}

/// Where the kinematics comes from, read.
struct Source {
    description: Description,
    /// The mechanism where the tool knows it.
    mechanism: Option<Mechanism>,
}

fn source(problem: &ProblemFile) -> Result<Source, SetupError> {
    let alone = |description| Source {
        description,
        mechanism: None,
    };
    Ok(match &problem.robot.source {
        RobotSource::Urdf(path) => alone(urdf::describe(&path.resolved)?),
        RobotSource::Mjcf(path) => alone(mjcf::read(&path.resolved)?),
        RobotSource::Mdh(path) => {
            let tree = mdh::read(&path.resolved)?;
            alone(Description::of_tree(tree, path.resolved.clone()))
        }
        RobotSource::Mechanism { mechanism, table } => {
            let known = match mechanism.value {
                Known::H4 => loops::h4(table)?,
            };
            Source {
                description: Description::of_tree(known.tree().clone(), problem.path.clone()),
                mechanism: Some(known),
            }
        }
    })
}

/// The joints that follow others which move. A locked joint holds what follows it and what it follows, unless the problem
/// file says where they stand; so does the robot file where it holds a joint.
fn follow(
    table: &RobotTable,
    description: &Description,
    locked: &mut [Option<f64>],
) -> Vec<Dependent> {
    let joints = description.tree.joints();
    let stated = |joint: usize| {
        let mut entries = table.locked.iter();
        entries.any(|entry| entry.name == joints[joint].name)
    };
    for held in &description.held {
        locked[held.joint].get_or_insert(held.position);
    }
    for dependent in &description.dependents {
        if let Some(position) = locked[dependent.joint] {
            let leader = (position - dependent.offset) / dependent.multiplier;
            locked[dependent.leader].get_or_insert(leader);
        }
    }
    let mut moving = Vec::new();
    for dependent in &description.dependents {
        match locked[dependent.leader] {
            Some(_) if stated(dependent.joint) => {}
            Some(at) => {
                locked[dependent.joint] = Some(dependent.multiplier * at + dependent.offset);
            }
            None => {
                locked[dependent.joint] = Some(dependent.offset);
                moving.push(*dependent);
            }
        }
    }
    moving
}

/// Where joints stand still; those without a motor count as locked.
fn locked(
    table: &RobotTable,
    all: &[String],
    passive: &[usize],
) -> Result<Vec<Option<f64>>, SetupError> {
    let mut locked = vec![None; all.len()];
    passive.iter().for_each(|&k| locked[k] = Some(0.0));
    for entry in &table.locked {
        let found = (0..all.len()).find(|k| all[*k] == entry.name && !passive.contains(k));
        let Some(k) = found else {
            return Err(unknown(&entry.value.place, &entry.name, all));
        };
        locked[k] = Some(entry.value.value);
    }
    Ok(locked)
}

fn checked_order(
    listed: &Located<Vec<Located<String>>>,
    names: &[String],
    locked: &[Named<f64>],
) -> Result<Vec<String>, SetupError> {
    let mut order: Vec<String> = Vec::new();
    for name in &listed.value {
        if !names.contains(&name.value) {
            return Err(unknown(&name.place, &name.value, names));
        }
        if order.contains(&name.value) {
            return Err(SetupError::mismatch(
                &name.place,
                Mismatch::JointTwice {
                    found: name.value.clone(),
                },
            ));
        }
        order.push(name.value.clone());
    }
    let missing: Vec<String> = names
        .iter()
        .filter(|n| !order.contains(n) && locked.iter().all(|entry| entry.name != **n))
        .cloned()
        .collect();
    if missing.is_empty() {
        Ok(order)
    } else {
        Err(SetupError::mismatch(
            &listed.place,
            Mismatch::JointMissing { missing },
        ))
    }
}

impl Robot {
    /// A per-joint array of the problem file in the order of the tree.
    pub fn per_joint(
        &self,
        values: &Option<Located<PerJoint>>,
    ) -> Result<Option<Vec<f64>>, SetupError> {
        let Some(values) = values else {
            return Ok(None);
        };
        let listed = values.expand(&self.order)?;
        Ok(Some(self.to_tree(&listed)))
    }

    /// Reorders a list from the problem file's order to the tree's. Joints without a motor have no entry in
    /// the list; the first one stands for theirs, which nothing reads.
    pub fn to_tree<T: Clone>(&self, listed: &[T]) -> Vec<T> {
        let mut out: Vec<T> = match listed.first() {
            Some(first) => vec![first.clone(); self.tree.len()],
            None => Vec::new(),
        };
        for (&k, value) in self.position.iter().zip(listed) {
            out[k] = value.clone();
        }
        out
    }

    /// Names of all links and frames.
    pub fn frame_names(&self) -> Vec<String> {
        let links = self.tree.joints().iter().map(|j| j.link.clone());
        let frames = self.tree.frames().iter().map(|f| f.name.clone());
        links.chain(frames).collect()
    }

    /// The file, as shown to users.
    pub fn path(&self) -> &Path {
        &self.file
    }
}
