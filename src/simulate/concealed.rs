//! Effects that only the truth has: values of parameters that the declared model does not know add their effect to the
//! joint that they name.

use crate::chain::assemble::has_others;
use crate::chain::effect::{self, Dependence, Effect, Law};
use crate::chain::model::Model;
use crate::chain::parameter::Role;
use crate::problem_file::Named;
use crate::robot::inertia::PER_LINK;
use crate::setup::coupling_entry;
use crate::setup::known::resolve;
use crate::setup::model_spec::ModelSpec;
use crate::setup::names::Reference;
use crate::setup::robot::Robot;
use crate::setup::truth_spec::TruthSpec;
use crate::simulate::error::{SimulateError, SimulateErrorKind};

/// The models with every effect that acts, and its values under the names of its model.
pub(super) struct Acting {
    pub commanded: ModelSpec,
    pub recorded: ModelSpec,
    pub values: Vec<Named<f64>>,
    /// Values of laws between torque and recorded signal, which the commanded torque does not have.
    pub currents: Vec<Named<f64>>,
    /// Names of the parameters of effects that are not declared.
    pub concealed: Vec<String>,
}

/// An effect of a joint.
#[derive(Clone, Copy)]
struct Owner {
    joint: usize,
    effect: &'static Effect,
}

/// Adds the effects of the values that are given to what is declared.
///
/// # Errors
/// A name that no effect and no body has; a second load; a locked joint that is coupled.
pub(super) fn add(spec: &TruthSpec, robot: &Robot) -> Result<Acting, SimulateError> {
    let mut acting = Acting {
        commanded: spec.commanded.clone(),
        recorded: spec.recorded.clone(),
        values: spec.given.clone(),
        currents: Vec::new(),
        concealed: Vec::new(),
    };
    let known = spec.commanded.build()?.model;
    for index in 0..acting.values.len() {
        acting.name_load(index, robot)?;
        acting.name_coupling(index, robot)?;
    }
    acting.take_currents(robot)?;
    let everything = with_all_effects(&acting.commanded, robot)?;
    for entry in acting.values.clone() {
        let reference = resolve(&everything, &entry.name, &entry.value.place)?;
        let Some(owner) = owner(&everything, reference) else {
            continue;
        };
        let name = match reference {
            Reference::Parameter(p) => &everything.parameters()[p].name,
            Reference::Body(..) => &entry.name,
        };
        let is_load = owner.effect.id == effect::LOAD.id;
        let declared = match is_load {
            true => known.payload().is_some(),
            false => known.position(name).is_some(),
        };
        if !declared {
            acting.concealed.push(name.clone());
        }
        let carried = is_load && (declared || has(&acting.recorded, owner.effect));
        if !carried {
            acting.list(owner);
        }
    }
    Ok(acting)
}

impl Acting {
    /// Sets values of laws between torque and recorded signal, and gains of controllers, apart and lists their effects.
    fn take_currents(&mut self, robot: &Robot) -> Result<(), SimulateError> {
        let sensed = with_all_effects(&self.recorded, robot)?;
        for entry in std::mem::take(&mut self.values) {
            let found = sensed.position(&entry.name);
            let is_gain = |p: usize| matches!(sensed.parameters()[p].role, Role::Controller { .. });
            if found.is_some_and(is_gain) {
                self.currents.push(entry);
                continue;
            }
            let own = found.and_then(|p| owner(&sensed, Reference::Parameter(p)));
            match own {
                Some(owner) if is_of_current(owner.effect) => {
                    self.list(owner);
                    self.concealed.push(entry.name.clone());
                    self.currents.push(entry);
                }
                _ => self.values.push(entry),
            }
        }
        Ok(())
    }

    /// `<joint>.<load>.mass` is `payload.mass`, with the load on that joint's link.
    fn name_load(&mut self, index: usize, robot: &Robot) -> Result<(), SimulateError> {
        let entry = &self.values[index];
        let effect = effect::LOAD;
        let mut joints = robot.tree.joints().iter().enumerate();
        let found = joints.find_map(|(joint, own)| {
            let quantity = entry
                .name
                .strip_prefix(&format!("{}.{}.", own.name, effect.id))?;
            Some((joint, format!("payload.{quantity}")))
        });
        let Some((joint, name)) = found else {
            return Ok(());
        };
        if self.recorded.has_load() {
            let kind = SimulateErrorKind::TwoLoads {
                found: entry.name.clone(),
            };
            return Err(SimulateError::new(&entry.value.place, kind));
        }
        self.values[index].name = name;
        self.list(Owner { joint, effect });
        Ok(())
    }

    /// `<joint>.<coupling>.<other>` is an entry of V, which may be one that is not declared.
    fn name_coupling(&mut self, index: usize, robot: &Robot) -> Result<(), SimulateError> {
        let entry = &self.values[index].value;
        let named = coupling_entry::named(&self.values[index].name, &robot.order);
        let Some(named) = named.map(|of_file| of_file.map(|k| robot.position[k])) else {
            return Ok(());
        };
        for spec in [&mut self.commanded, &mut self.recorded] {
            spec.couple(named, entry.value, &entry.place)?;
        }
        self.list(Owner {
            joint: named[0],
            effect: effect::COUPLING,
        });
        Ok(())
    }

    /// Lists an effect for its joint. No channel mixes the torque that is commanded.
    fn list(&mut self, Owner { joint, effect }: Owner) {
        self.recorded.add_effect(joint, effect);
        if effect.id != effect::CROSSTALK.id {
            self.commanded.add_effect(joint, effect);
        }
    }
}

/// Whether an effect lies between torque and recorded signal.
fn is_of_current(effect: &Effect) -> bool {
    match effect.law {
        Law::Current | Law::Crosstalk => true,
        Law::Signal(_) => effect.depends_on.contains(&Dependence::Current),
        _ => false,
    }
}

/// Whether any joint has an effect.
fn has(spec: &ModelSpec, effect: &Effect) -> bool {
    let mut all = spec.effects().iter().flatten();
    all.any(|listed| listed.id == effect.id)
}

/// The model with every effect of the vocabulary on every joint: it knows every name there is.
fn with_all_effects(spec: &ModelSpec, robot: &Robot) -> Result<Model, SimulateError> {
    let possible = |joint: usize| {
        let all = spec.catalogue().effects().iter().copied();
        let possible = all.filter(|e| {
            let moves_loops = robot.mechanism.is_some() && e.law.moves_joints();
            has_others(&robot.tree, joint, e) && !moves_loops
        });
        possible.collect()
    };
    let effects = (0..robot.tree.len()).map(possible).collect();
    Ok(spec.with_effects(effects).build()?.model)
}

/// The effect that a name belongs to, and its joint; `None` for quantities of links.
fn owner(model: &Model, reference: Reference) -> Option<Owner> {
    let load = Owner {
        joint: model.tree().len() - 1,
        effect: effect::LOAD,
    };
    match reference {
        Reference::Body(first, _) if first < PER_LINK * model.tree().len() => None,
        Reference::Body(..) => Some(load),
        Reference::Parameter(p) => match model.parameters()[p].role {
            Role::Inertial { .. } | Role::Tare { .. } | Role::Controller { .. } => None,
            Role::Payload { .. } => Some(load),
            Role::Effect { joint, effect, .. } => Some(Owner {
                joint,
                effect: model.joints()[joint].effects[effect].0,
            }),
            Role::Coupling { row, .. } => Some(Owner {
                joint: row,
                effect: effect::COUPLING,
            }),
            Role::Crosstalk(heard) => Some(Owner {
                joint: heard.channel,
                effect: effect::CROSSTALK,
            }),
            Role::Tilt { .. } => Some(Owner {
                joint: 0,
                effect: effect::TILT,
            }),
        },
    }
}
