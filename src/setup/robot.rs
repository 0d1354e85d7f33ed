//! The robot of a problem file: its tree, the order of per-joint arrays, the joints that stand still.

use crate::mechanism::loops::Mechanism;
use crate::problem_file::choices::Mechanism as Known;
use crate::problem_file::robot::{RobotSource, RobotTable};
use crate::problem_file::{Located, PerJoint, ProblemFile};
use crate::robot::tree::Tree;
use crate::robot::{mdh, urdf};
use crate::setup::error::{Mismatch, SetupError};
use crate::setup::loops;
use std::path::{Path, PathBuf};

/// A robot as a problem file uses it.
#[derive(Debug, Clone)]
pub struct Robot {
    pub tree: Tree,
    pub file: PathBuf,
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
}

/// Reads the robot of a problem file, a tree without loops.
pub fn open(problem: &ProblemFile) -> Result<Robot, SetupError> {
    let robot = open_any(problem)?;
    if robot.mechanism.is_none() {
        return Ok(robot);
    }
    let table = &problem.robot;
    let closed = table.closed.first().map(|closed| &closed.frames.place);
    let place = match &table.source {
        RobotSource::Mechanism { mechanism, .. } => mechanism.place.clone(),
        _ => closed.cloned().unwrap_or_default(),
    };
    Err(SetupError::mismatch(
        &place,
        Mismatch::NotYet {
            what: "a mechanism with closed loops".to_string(),
            instead: "mechanisms can be fitted: `exid fit`".to_string(),
        },
    ))
}

/// Reads the robot of a problem file, which may have loops.
pub fn open_any(problem: &ProblemFile) -> Result<Robot, SetupError> {
    let table = &problem.robot;
    let (tree, file, known) = source(problem)?;
    let tree = tree.with_gravity(table.gravity.value);
    let all: Vec<String> = tree.joints().iter().map(|j| j.name.clone()).collect();
    let mechanism = match known {
        None => loops::of_tree(table, &tree, &all)?,
        known => known,
    };
    let passive = mechanism.as_ref().map_or(&[][..], |m| m.passive());
    let names: Vec<String> = (0..all.len())
        .filter(|k| !passive.contains(k))
        .map(|k| all[k].clone())
        .collect();
    let order = match &table.joints {
        None => names.clone(),
        Some(listed) => checked_order(listed, &names)?,
    };
    let position = order
        .iter()
        .filter_map(|name| all.iter().position(|n| n == name))
        .collect();
    let locked = locked(table, &all, passive)?;
    let mut robot = Robot {
        tree,
        file,
        order,
        position,
        locked,
        ratio: None,
        mechanism,
    };
    robot.ratio = robot.per_joint(&problem.drive.ratio)?;
    Ok(robot)
}

/// The tree of the robot's file, and the mechanism where the tool knows it.
fn source(problem: &ProblemFile) -> Result<(Tree, PathBuf, Option<Mechanism>), SetupError> {
    Ok(match &problem.robot.source {
        RobotSource::Urdf(path) => (urdf::read(&path.resolved)?, path.resolved.clone(), None),
        RobotSource::Mdh(path) => (mdh::read(&path.resolved)?, path.resolved.clone(), None),
        RobotSource::Mechanism { mechanism, table } => {
            let known = match mechanism.value {
                Known::H4 => loops::h4(table)?,
            };
            (known.tree().clone(), problem.path.clone(), Some(known))
        }
    })
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
    match (locked.iter().all(Option::is_some), table.locked.first()) {
        (true, Some(entry)) => {
            let place = &entry.value.place;
            Err(SetupError::mismatch(place, Mismatch::AllLocked))
        }
        _ => Ok(locked),
    }
}

pub(crate) fn unknown(place: &crate::fault::Place, found: &str, known: &[String]) -> SetupError {
    SetupError::mismatch(
        place,
        Mismatch::UnknownJoint {
            found: found.to_string(),
            known: known.to_vec(),
        },
    )
}

fn checked_order(
    listed: &Located<Vec<Located<String>>>,
    names: &[String],
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
        .filter(|n| !order.contains(n))
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
