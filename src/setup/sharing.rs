//! `[[drive.shared]]`: joints with motors of one type, as parameters that they have in common.

use crate::chain::effect::{Catalogue, Effect, Law};
use crate::chain::model::Model;
use crate::chain::sharing::Sharing;
use crate::problem_file::drive::SharedTable;
use crate::problem_file::{Located, ProblemFile};
use crate::setup::error::{Mismatch, SetupError, unknown};
use crate::setup::laws;
use crate::setup::robot::Robot;

/// What a problem file declares to be shared, among joints that have the effects.
///
/// # Errors
/// Joints that the robot does not have, or that both turn and slide; effects without parameters of single joints; parameters
/// that the effects do not have; an effect of a joint that is shared twice.
pub fn declared(
    problem: &ProblemFile,
    robot: &Robot,
    effects: &[Vec<&'static Effect>],
) -> Result<Vec<Sharing>, SetupError> {
    let catalogue = laws::catalogue(problem)?;
    let mut all: Vec<Sharing> = Vec::new();
    for table in &problem.drive.shared {
        let joints = joints(table, robot)?;
        let separate = separate(table, &catalogue)?;
        for id in &table.effects {
            let Some(effect) = catalogue.find(&id.value) else {
                continue;
            };
            if !is_of_joints(effect) {
                return Err(refused(
                    id,
                    format!("`{}` has no parameters of single joints", effect.id),
                    "leave it out of drive.shared",
                ));
            }
            let twice = |other: &Sharing| {
                other.effect.id == effect.id && other.joints.iter().any(|j| joints.contains(j))
            };
            if all.iter().any(twice) {
                return Err(refused(
                    id,
                    format!("`{}` of one of these joints is shared twice", effect.id),
                    "put the joints into one table of drive.shared",
                ));
            }
            let has = |j: &usize| effects[*j].iter().any(|e| e.id == effect.id);
            all.push(Sharing {
                effect,
                joints: joints.iter().copied().filter(has).collect(),
                separate: names_of(effect, &separate),
            });
        }
    }
    all.retain(|sharing| sharing.joints.len() > 1);
    Ok(all)
}

/// What a problem file lets be shared and a model does not share: the effects that several joints of a table have, of a
/// table without effects any, else those of its list.
pub fn proposed(
    problem: &ProblemFile,
    robot: &Robot,
    model: &Model,
) -> Result<Vec<Sharing>, SetupError> {
    let catalogue = laws::catalogue(problem)?;
    let mut all = Vec::new();
    for table in &problem.drive.shared {
        let joints = joints(table, robot)?;
        let separate = separate(table, &catalogue)?;
        let listed = |effect: &Effect| {
            table.effects.is_empty() || table.effects.iter().any(|id| id.value == effect.id)
        };
        let shared = |effect: &Effect| {
            let mut known = model.shared().iter();
            known.any(|s| s.effect.id == effect.id && s.joints.iter().all(|j| joints.contains(j)))
        };
        let open = catalogue.effects().iter().copied();
        for effect in open.filter(|e| is_of_joints(e) && listed(e) && !shared(e)) {
            let sharing = Sharing {
                effect,
                joints: joints.clone(),
                separate: names_of(effect, &separate),
            };
            let rows = sharing.positions(model.joints());
            let is_free = |p: &usize| model.parameters()[*p].is_free();
            if rows.iter().any(|row| row.iter().all(is_free)) {
                all.push(Sharing {
                    joints: sharing.having(model.joints()),
                    ..sharing
                });
            }
        }
    }
    Ok(all)
}

/// The same problem in which every joint has its own parameters.
pub fn separated(problem: &ProblemFile) -> ProblemFile {
    let mut problem = problem.clone();
    problem.drive.shared.clear();
    problem
}

/// Whether an effect has parameters of single joints in the model's list.
fn is_of_joints(effect: &Effect) -> bool {
    !matches!(effect.law, Law::Coupling | Law::Body | Law::Tilt) && !effect.parameters.is_empty()
}

fn joints(table: &SharedTable, robot: &Robot) -> Result<Vec<usize>, SetupError> {
    let mut joints: Vec<usize> = Vec::new();
    for name in &table.joints.value {
        let Some(joint) = robot.tree.joint_index(&name.value) else {
            return Err(unknown(&name.place, &name.value, &robot.order));
        };
        let kind = |j: usize| robot.tree.joints()[j].kind;
        if joints
            .first()
            .is_some_and(|&first| kind(first) != kind(joint))
        {
            return Err(refused(
                name,
                format!(
                    "joint `{}` and joint `{}`: one turns and the other slides, and their parameters have other units",
                    table.joints.value[0].value, name.value
                ),
                "name joints that all turn, or joints that all slide",
            ));
        }
        joints.push(joint);
    }
    Ok(joints)
}

/// `<effect>.<parameter>` of a table, checked.
fn separate<'a>(
    table: &'a SharedTable,
    catalogue: &Catalogue,
) -> Result<Vec<(&'a str, &'a str)>, SetupError> {
    let of = |name: &'a Located<String>| {
        let parts = name.value.split_once('.');
        let exists = parts.is_some_and(|(id, parameter)| {
            let effect = catalogue.find(id);
            effect.is_some_and(|e| e.parameters.iter().any(|info| info.name == parameter))
        });
        parts.filter(|_| exists).ok_or_else(|| {
            refused(
                name,
                format!("there is no parameter `{}` of an effect", name.value),
                "write <effect>.<parameter>; `exid effects` lists them",
            )
        })
    };
    table.separate.iter().map(of).collect()
}

/// Names of an effect's own parameters among those of a table.
fn names_of(effect: &Effect, separate: &[(&str, &str)]) -> Vec<String> {
    let own = separate.iter().filter(|(id, _)| *id == effect.id);
    own.map(|(_, name)| name.to_string()).collect()
}

fn refused(at: &Located<String>, what: String, instead: &str) -> SetupError {
    let instead = instead.to_string();
    SetupError::mismatch(&at.place, Mismatch::NotShared { what, instead })
}
