//! The robot of a problem file: its tree, the order of per-joint arrays, the joints that stand still.

use crate::problem_file::robot::RobotSource;
use crate::problem_file::{Located, PerJoint, ProblemFile};
use crate::robot::tree::Tree;
use crate::robot::{mdh, urdf};
use crate::setup::error::{Mismatch, SetupError};
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
}

/// Reads the robot of a problem file.
pub fn open(problem: &ProblemFile) -> Result<Robot, SetupError> {
    let table = &problem.robot;
    let (tree, file) = match &table.source {
        RobotSource::Urdf(path) => (urdf::read(&path.resolved)?, path.resolved.clone()),
        RobotSource::Mdh(path) => (mdh::read(&path.resolved)?, path.resolved.clone()),
        RobotSource::Mechanism { mechanism, .. } => {
            return Err(SetupError::mismatch(
                &mechanism.place,
                Mismatch::NotYet {
                    what: "a parallel mechanism".to_string(),
                    instead: "give a serial robot by `urdf` or `mdh`".to_string(),
                },
            ));
        }
    };
    let tree = tree.with_gravity(table.gravity.value);
    let names: Vec<String> = tree.joints().iter().map(|j| j.name.clone()).collect();
    let order = match &table.joints {
        None => names.clone(),
        Some(listed) => checked_order(listed, &names)?,
    };
    let position = order
        .iter()
        .filter_map(|name| names.iter().position(|n| n == name))
        .collect();
    let mut locked = vec![None; names.len()];
    for entry in &table.locked {
        let Some(k) = names.iter().position(|n| *n == entry.name) else {
            return Err(unknown(&entry.value.place, &entry.name, &names));
        };
        locked[k] = Some(entry.value.value);
    }
    if let (true, Some(entry)) = (locked.iter().all(Option::is_some), table.locked.first()) {
        return Err(SetupError::mismatch(
            &entry.value.place,
            Mismatch::AllLocked,
        ));
    }
    let mut robot = Robot {
        tree,
        file,
        order,
        position,
        locked,
        ratio: None,
    };
    robot.ratio = robot.per_joint(&problem.drive.ratio)?;
    Ok(robot)
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

    /// Reorders a list from the problem file's order to the tree's.
    pub fn to_tree<T: Clone>(&self, listed: &[T]) -> Vec<T> {
        let mut out: Vec<(usize, T)> = self
            .position
            .iter()
            .copied()
            .zip(listed.iter().cloned())
            .collect();
        out.sort_by_key(|(k, _)| *k);
        out.into_iter().map(|(_, value)| value).collect()
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
