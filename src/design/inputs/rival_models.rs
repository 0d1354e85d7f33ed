//! The rival models of a problem file: its robot with the effects and values that each rival states.

use crate::chain::effect::EFFECTS;
use crate::chain::parameter::Role;
use crate::design::criterion::model_discrimination::{Rival, Rivals};
use crate::design::error::{DesignError, Unsuitable};
use crate::design::information::torque_laws::SMOOTHING;
use crate::design::inputs::prepared::Prepared;
use crate::problem_file::choices::Criterion;
use crate::problem_file::design::Rival as Stated;
use crate::problem_file::{Named, ProblemFile};
use crate::setup::coupling_entry;

/// The rivals where the criterion is to tell them apart; a single one stands against the problem file's model.
///
/// # Errors
/// No rival; faults of a rival's effects, values or earlier fit.
pub fn of<'a>(
    problem: &ProblemFile,
    prepared: &'a Prepared,
) -> Result<Option<Rivals<'a>>, DesignError> {
    if problem.design.criterion.value != Criterion::Discriminate {
        return Ok(None);
    }
    let stated = &problem.design.rival;
    let mut models = Vec::new();
    if stated.len() < 2 {
        models.push(rival(problem.name.value.clone(), problem)?);
    }
    for one in stated {
        models.push(rival(
            one.name.value.clone(),
            &altered(problem, one, &prepared.robot.order),
        )?);
    }
    if models.len() < 2 {
        let place = &problem.design.criterion.place;
        return Err(DesignError::unsuitable(place, Unsuitable::NoRivals));
    }
    Ok(Some(Rivals {
        models,
        loads: &prepared.loads,
        noise: &prepared.noise,
    }))
}

/// The problem file with what a rival replaces; `order` are the joints as the file has them.
fn altered(problem: &ProblemFile, rival: &Stated, order: &[String]) -> ProblemFile {
    let mut own = problem.clone();
    if let Some(effects) = &rival.effects {
        own.drive.effects.clone_from(&effects.value);
        own.drive.effects_of.clear();
    }
    for of_joint in &rival.effects_of {
        own.drive.effects_of.retain(|e| e.name != of_joint.name);
        own.drive.effects_of.push(of_joint.clone());
    }
    if rival.effects.is_some() || !rival.effects_of.is_empty() {
        let mut ids: Vec<String> = own.drive.effects.iter().map(|e| e.value.clone()).collect();
        let of_joints = own.drive.effects_of.iter().flat_map(|of| &of.value.value);
        ids.extend(of_joints.map(|e| e.value.clone()));
        let listed = |id: &str| ids.iter().any(|known| known == id);
        // What is said of effects that the rival does not have says nothing of it.
        let applies = |name: &str| {
            let mut segments = name.split('.');
            segments.all(|s| listed(s) || EFFECTS.iter().all(|e| e.id != s))
        };
        own.drive.values.retain(|v| applies(&v.name));
        own.design.values.retain(|v| applies(&v.name));
        own.fit.prior.values.retain(|v| applies(&v.name));
        own.fit.bounds.retain(|v| applies(&v.name));
    }
    if rival.parameters.is_some() {
        own.robot.parameters.clone_from(&rival.parameters);
    }
    for entry in &rival.values {
        coupling_entry::declare(&mut own, order, entry);
    }
    own.design.values.extend(rival.values.iter().map(|v| Named {
        name: v.name.clone(),
        value: v.value.clone(),
    }));
    own
}

/// A model with its values; where no fit states them, effects act with typical sizes.
fn rival(name: String, problem: &ProblemFile) -> Result<Rival, DesignError> {
    let prepared = Prepared::read(problem)?;
    let (model, mut values) = (prepared.model, prepared.values);
    if problem.robot.parameters.is_none() {
        for (value, parameter) in values.iter_mut().zip(model.parameters()) {
            let of_effect = matches!(parameter.role, Role::Effect { .. });
            if of_effect && parameter.is_free() && *value == 0.0 {
                *value = parameter.scale;
            }
        }
    }
    for (joint, limits) in model.joints().iter().zip(&prepared.limits) {
        if let Some(width) = joint.width {
            values[width] = values[width].max(SMOOTHING * limits.velocity);
        }
    }
    let mut unknowns = prepared.base.kept();
    let all = model.parameters().iter().enumerate();
    unknowns.extend(
        all.filter(|(_, p)| p.is_nonlinear_unknown())
            .map(|(k, _)| k),
    );
    let rows = prepared.prior.rows().select_columns(&unknowns);
    Ok(Rival {
        name,
        prior: rows.tr_mul(&rows),
        values,
        unknowns,
        model,
    })
}
