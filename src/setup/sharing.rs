//! `[[drive.shared]]`: joints with motors of one type, as parameters that they have in common.

use crate::chain::effect::{Catalogue, Effect, Law};
use crate::chain::model::Model;
use crate::chain::sharing::Sharing;
use crate::problem_file::drive::SharedTable;
use crate::problem_file::{Located, ProblemFile};
use crate::setup::error::{Mismatch, SetupError, unknown};
use crate::setup::laws;
use crate::setup::robot::Robot;

/// Joints with motors of one type, as one table `[[drive.shared]]` names them.
#[derive(Debug, Clone)]
pub struct Alike {
    /// Positions in the tree.
    joints: Vec<usize>,
    /// Effects whose parameters the joints have in common; those that could be are proposed where there is none.
    effects: Vec<&'static Effect>,
    /// What every joint has for itself.
    separate: Vec<OwnParameter>,
    /// The effects that may be shared.
    open: Vec<&'static Effect>,
}

/// A parameter of an effect that every joint has for itself.
#[derive(Debug, Clone)]
struct OwnParameter {
    effect: String,
    name: String,
}

impl Alike {
    /// The tables of a problem file.
    ///
    /// # Errors
    /// Joints that the robot does not have, or that both turn and slide; effects without parameters of single joints;
    /// parameters that the effects do not have; an effect of a joint that is shared twice.
    pub fn of(problem: &ProblemFile, robot: &Robot) -> Result<Vec<Self>, SetupError> {
        let catalogue = laws::catalogue(problem)?;
        let mut all: Vec<Self> = Vec::new();
        for table in &problem.drive.shared {
            let mut alike = Self {
                joints: joints(table, robot)?,
                effects: Vec::new(),
                separate: separate(table, &catalogue)?,
                open: catalogue
                    .effects()
                    .iter()
                    .copied()
                    .filter(|effect| is_of_joints(effect))
                    .collect(),
            };
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
                let twice = |other: &Self| {
                    let has = other.effects.iter().any(|e| e.id == effect.id);
                    has && other.joints.iter().any(|j| alike.joints.contains(j))
                };
                if all.iter().chain([&alike]).any(twice) {
                    return Err(refused(
                        id,
                        format!("`{}` of one of these joints is shared twice", effect.id),
                        "put the joints into one table of drive.shared",
                    ));
                }
                alike.effects.push(effect);
            }
            all.push(alike);
        }
        Ok(all)
    }

    /// An effect that joints have in common.
    fn sharing(&self, effect: &'static Effect, joints: Vec<usize>) -> Sharing {
        let own = self.separate.iter().filter(|own| own.effect == effect.id);
        Sharing {
            effect,
            joints,
            separate: own.map(|own| own.name.clone()).collect(),
        }
    }
}

/// What is declared to be shared, among joints that have the effects.
pub fn declared(alike: &[Alike], effects: &[Vec<&'static Effect>]) -> Vec<Sharing> {
    let of = |alike: &Alike| -> Vec<Sharing> {
        let each = alike.effects.iter().map(|&effect| {
            let has = |j: &usize| effects[*j].iter().any(|e| e.id == effect.id);
            alike.sharing(effect, alike.joints.iter().copied().filter(has).collect())
        });
        each.collect()
    };
    let mut all: Vec<Sharing> = alike.iter().flat_map(of).collect();
    all.retain(|sharing| sharing.joints.len() > 1);
    all
}

/// What may be shared and a model does not share: the effects that several joints of a table have, of a table without
/// effects any, else those of its list.
pub(super) fn proposed(alike: &[Alike], model: &Model) -> Vec<Sharing> {
    let mut all = Vec::new();
    for alike in alike {
        let listed = |effect: &Effect| {
            alike.effects.is_empty() || alike.effects.iter().any(|e| e.id == effect.id)
        };
        let shared = |effect: &Effect| {
            let mut known = model.shared().iter();
            known.any(|s| {
                s.effect.id == effect.id && s.joints.iter().all(|j| alike.joints.contains(j))
            })
        };
        let open = alike.open.iter().copied();
        for effect in open.filter(|e| listed(e) && !shared(e)) {
            let sharing = alike.sharing(effect, alike.joints.clone());
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
    all
}

/// Whether an effect has parameters of single joints in the model's list.
fn is_of_joints(effect: &Effect) -> bool {
    !effect.law.is_of_pairs()
        && !matches!(effect.law, Law::Body | Law::Tilt)
        && !effect.parameters.is_empty()
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
fn separate(table: &SharedTable, catalogue: &Catalogue) -> Result<Vec<OwnParameter>, SetupError> {
    let of = |name: &Located<String>| {
        let parts = name.value.split_once('.');
        let exists = parts.filter(|(id, parameter)| {
            let effect = catalogue.find(id);
            effect.is_some_and(|e| e.parameters.iter().any(|info| info.name == *parameter))
        });
        let (effect, parameter) = exists.ok_or_else(|| {
            refused(
                name,
                format!("there is no parameter `{}` of an effect", name.value),
                "write <effect>.<parameter>; `exid effects` lists them",
            )
        })?;
        Ok(OwnParameter {
            effect: effect.to_string(),
            name: parameter.to_string(),
        })
    };
    table.separate.iter().map(of).collect()
}

fn refused(at: &Located<String>, what: String, instead: &str) -> SetupError {
    let instead = instead.to_string();
    SetupError::mismatch(&at.place, Mismatch::NotShared { what, instead })
}
