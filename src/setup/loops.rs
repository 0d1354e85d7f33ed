//! Mechanisms of a problem file, and the motion of their joints without a motor.

use crate::fault::Place;
use crate::mechanism::condition::{Anchor, Condition};
use crate::mechanism::error::MechanismError;
use crate::mechanism::h4::H4;
use crate::mechanism::loops::Mechanism;
use crate::problem_file::Located;
use crate::problem_file::choices::ClosedJoint;
use crate::problem_file::robot::{ClosedTable, H4_KEYS, RobotTable};
use crate::robot::tree::Tree;
use crate::setup::error::{Mismatch, SetupError, faulty, unknown};
use nalgebra::Vector3;

/// The H4 of the table `[robot.h4]`.
///
/// # Errors
/// A length that is missing, unknown or none.
pub fn h4(table: &Located<toml::Value>) -> Result<Mechanism, SetupError> {
    let entries = table.value.as_table();
    let lengths: Vec<&str> = H4_KEYS.iter().map(|key| key.name).collect();
    let known = |key: &str| lengths.contains(&key);
    let mut keys = entries.into_iter().flatten().map(|(key, _)| key);
    if let Some(key) = keys.find(|key| !known(key)) {
        let text = format!(
            "`{key}` is no length of an H4; its lengths are {}",
            lengths.join(", ")
        );
        return Err(faulty(&table.place, text));
    }
    let length = |key: &str| {
        let value = entries.and_then(|entries| entries.get(key));
        let number = value.and_then(|v| v.as_float().or(v.as_integer().map(|whole| whole as f64)));
        number.ok_or_else(|| faulty(&table.place, format!("`{key}` wants a number of metres")))
    };
    let robot = H4 {
        lever: length("lever")?,
        rod: length("rod")?,
        half_bar: length("half_bar")?,
        half_width: length("half_width")?,
        radius: length("radius")?,
    };
    robot.mechanism().map_err(|error| at(&table.place, &error))
}

fn at(place: &Place, error: &MechanismError) -> SetupError {
    faulty(place, error.to_string())
}

/// The loops that a problem file closes in the tree of a robot file; `None` where it closes none.
///
/// # Errors
/// Unknown joints and frames; closed joints that do not hold the passive ones, or that cannot be closed near the
/// positions given.
pub fn of_tree(
    table: &RobotTable,
    tree: &Tree,
    names: &[String],
) -> Result<Option<Mechanism>, SetupError> {
    let Some(first) = table.closed.first() else {
        return match table.passive.first() {
            None => Ok(None),
            Some(joint) => Err(faulty(
                &joint.value.place,
                "joints without a motor need closed joints that hold them: list them as [[robot.closed]]"
                    .to_string(),
            )),
        };
    };
    let limits = tree.joints().iter().map(|joint| &joint.limits);
    let mut home: Vec<f64> = limits
        .map(|limits| match (limits.lower, limits.upper) {
            (Some(lower), Some(upper)) => 0.5 * (lower + upper),
            _ => 0.0,
        })
        .collect();
    let mut passive = Vec::with_capacity(table.passive.len());
    for joint in &table.passive {
        let Some(k) = tree.joint_index(&joint.name) else {
            return Err(unknown(&joint.value.place, &joint.name, names));
        };
        home[k] = joint.value.value;
        passive.push(k);
    }
    let conditions = table.closed.iter().map(|closed| condition(closed, tree));
    let conditions = conditions.collect::<Result<Vec<_>, _>>()?;
    Mechanism::new(tree.clone(), &passive, conditions, home)
        .map(Some)
        .map_err(|error| at(&first.frames.place, &error))
}

fn condition(closed: &ClosedTable, tree: &Tree) -> Result<Condition, SetupError> {
    let axis = Vector3::from(closed.axis.value);
    if axis.norm() == 0.0 {
        return Err(faulty(
            &closed.axis.place,
            "an axis has a direction".to_string(),
        ));
    }
    let mut ends = Vec::with_capacity(2);
    let mut axes = Vec::with_capacity(2);
    for name in &closed.frames.value {
        let Some((link, frame)) = tree.frame(name) else {
            let links = tree.joints().iter().map(|j| j.link.clone());
            let known = links.chain(tree.frames().iter().map(|f| f.name.clone()));
            let kind = Mismatch::UnknownFrame {
                found: name.clone(),
                known: known.collect(),
            };
            return Err(SetupError::mismatch(&closed.frames.place, kind));
        };
        ends.push(Anchor {
            link,
            point: frame.translation.vector,
        });
        axes.push(frame.rotation * axis.normalize());
    }
    let ends = [ends[0], ends[1]];
    Ok(match (closed.joint.value, &closed.length) {
        (ClosedJoint::Rod, Some(length)) => Condition::Rod {
            ends,
            length: length.value,
        },
        (ClosedJoint::Hinge, _) => Condition::Hinge {
            ends,
            axes: [axes[0], axes[1]],
        },
        _ => Condition::Ball { ends },
    })
}
