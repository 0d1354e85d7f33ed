//! Effects that only the truth has: names in `[simulate.values]` that the declared model does not know
//! add their effect to the joint that they name.

use crate::chain::assemble::has_others;
use crate::chain::effect::{self, Dependence, Effect, Law};
use crate::chain::model::Model;
use crate::chain::parameter::Role;
use crate::problem_file::choices::Signal;
use crate::problem_file::{Located, Named, ProblemFile};
use crate::robot::inertia::PER_LINK;
use crate::setup::coupling_entry;
use crate::setup::known::resolve;
use crate::setup::laws;
use crate::setup::model_spec::ModelSpec;
use crate::setup::names::Reference;
use crate::setup::robot::Robot;
use crate::simulate::error::{SimulateError, SimulateErrorKind};

/// The problem with every effect that acts, and its values under the names of its model.
pub(super) struct Acting {
    pub problem: ProblemFile,
    pub values: Vec<Named<f64>>,
    /// Values of laws between torque and recorded signal, which the commanded torque does not have.
    pub currents: Vec<Named<f64>>,
    /// Names of the parameters of effects that the problem file does not declare.
    pub concealed: Vec<String>,
}

/// Adds the effects that `[simulate.values]` names to a problem.
///
/// # Errors
/// A name that no effect and no body has; a second load.
pub(super) fn add(declared: &ProblemFile, robot: &Robot) -> Result<Acting, SimulateError> {
    let mut acting = Acting {
        problem: declared.clone(),
        values: declared.simulate.values.clone(),
        currents: Vec::new(),
        concealed: Vec::new(),
    };
    let known = ModelSpec::without_prior(&commanded(declared), robot)?
        .build()?
        .model;
    for index in 0..acting.values.len() {
        acting.name_load(index, robot)?;
        acting.name_coupling(index, robot);
    }
    acting.take_currents(robot)?;
    let everything = with_all_effects(&commanded(&acting.problem), robot)?;
    for index in 0..acting.values.len() {
        let entry = acting.values[index].clone();
        let reference = resolve(&everything, &entry.name, &entry.value.place)?;
        if let Some((joint, effect)) = owner(&everything, reference) {
            let name = match reference {
                Reference::Parameter(p) => &everything.parameters()[p].name,
                Reference::Body(..) => &entry.name,
            };
            let is_load = effect == effect::LOAD.id;
            let declared = match is_load {
                true => known.payload().is_some(),
                false => known.position(name).is_some(),
            };
            if !declared {
                acting.concealed.push(name.clone());
            }
            let carried = is_load && (declared || lists(&acting.problem, robot, effect));
            if !carried {
                acting.list(&robot.tree.joints()[joint].name, effect);
            }
        }
    }
    Ok(acting)
}

impl Acting {
    /// Sets values of laws between torque and recorded signal, and gains of controllers, apart and lists their effects.
    fn take_currents(&mut self, robot: &Robot) -> Result<(), SimulateError> {
        let sensed = with_all_effects(&self.problem, robot)?;
        for entry in std::mem::take(&mut self.values) {
            let found = sensed.position(&entry.name);
            let is_gain = |p: usize| matches!(sensed.parameters()[p].role, Role::Controller { .. });
            if found.is_some_and(is_gain) {
                self.currents.push(entry);
                continue;
            }
            let own = found.and_then(|p| owner(&sensed, Reference::Parameter(p)));
            match own {
                Some((joint, effect)) if is_of_current(&sensed, effect) => {
                    self.list(&robot.tree.joints()[joint].name, effect);
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
        let id = effect::LOAD.id;
        let found = robot.tree.joints().iter().find_map(|joint| {
            let quantity = entry.name.strip_prefix(&format!("{}.{id}.", joint.name))?;
            Some((joint.name.clone(), format!("payload.{quantity}")))
        });
        let Some((joint, name)) = found else {
            return Ok(());
        };
        if self.problem.robot.payload.is_some() {
            let kind = SimulateErrorKind::TwoLoads {
                found: entry.name.clone(),
            };
            return Err(SimulateError::new(&entry.value.place, kind));
        }
        self.values[index].name = name;
        self.list(&joint, id);
        Ok(())
    }

    /// `<joint>.<coupling>.<other>` is an entry of V, which may be one that is not declared.
    fn name_coupling(&mut self, index: usize, robot: &Robot) {
        let entry = &self.values[index];
        let joint = coupling_entry::declare(&mut self.problem, &robot.order, entry);
        if let Some(joint) = joint {
            self.list(&joint, effect::COUPLING.id);
        }
    }

    /// Lists an effect for a joint.
    fn list(&mut self, joint: &str, effect: &str) {
        let drive = &mut self.problem.drive;
        let place = drive.effects.first().map(|e| e.place.clone());
        let entry = Located {
            value: effect.to_string(),
            place: place.unwrap_or_default(),
        };
        let own = match drive.effects_of.iter_mut().position(|e| e.name == joint) {
            Some(at) => &mut drive.effects_of[at],
            None => {
                drive.effects_of.push(Named {
                    name: joint.to_string(),
                    value: Located {
                        value: drive.effects.clone(),
                        place: entry.place.clone(),
                    },
                });
                let last = drive.effects_of.len() - 1;
                &mut drive.effects_of[last]
            }
        };
        if own.value.value.iter().all(|e| e.value != effect) {
            own.value.value.push(entry);
        }
    }
}

/// Whether an effect lies between torque and recorded signal.
fn is_of_current(model: &Model, effect: &str) -> bool {
    let found = model.catalogue().find(effect);
    found.is_some_and(|effect| match effect.law {
        Law::Current | Law::Crosstalk => true,
        Law::Signal(_) => effect.depends_on.contains(&Dependence::Current),
        _ => false,
    })
}

/// Whether any joint has an effect.
fn lists(problem: &ProblemFile, robot: &Robot, effect: &str) -> bool {
    robot.order.iter().any(|joint| {
        let own = problem.drive.effects_of.iter().find(|e| e.name == *joint);
        let list = own.map_or(&problem.drive.effects, |e| &e.value.value);
        list.iter().any(|e| e.value == effect)
    })
}

/// The model with every effect of the vocabulary on every joint: it knows every name there is.
fn with_all_effects(problem: &ProblemFile, robot: &Robot) -> Result<Model, SimulateError> {
    let catalogue = laws::catalogue(problem)?;
    let listed = |effect: &&'static Effect| Located {
        value: effect.id.to_string(),
        place: Default::default(),
    };
    let mut all = problem.clone();
    all.drive.effects = catalogue.effects().iter().map(listed).collect();
    all.drive.effects_of.clear();
    for (joint, own) in robot.tree.joints().iter().enumerate() {
        let possible = catalogue.effects().iter();
        let possible = possible.filter(|e| {
            let moves_loops = robot.mechanism.is_some() && e.law.moves_joints();
            has_others(&robot.tree, joint, e) && !moves_loops
        });
        all.drive.effects_of.push(Named {
            name: own.name.clone(),
            value: Located {
                value: possible.map(listed).collect(),
                place: Default::default(),
            },
        });
    }
    Ok(ModelSpec::without_prior(&all, robot)?.build()?.model)
}

/// Joint and effect that a name belongs to; `None` for quantities of links.
fn owner(model: &Model, reference: Reference) -> Option<(usize, &'static str)> {
    let last = model.tree().len() - 1;
    let load = Some((last, effect::LOAD.id));
    match reference {
        Reference::Body(first, _) if first < PER_LINK * model.tree().len() => None,
        Reference::Body(..) => load,
        Reference::Parameter(p) => match model.parameters()[p].role {
            Role::Inertial { .. } | Role::Tare { .. } | Role::Controller { .. } => None,
            Role::Payload { .. } => load,
            Role::Effect { joint, effect, .. } => {
                Some((joint, model.joints()[joint].effects[effect].0.id))
            }
            Role::Coupling { row, .. } => Some((row, effect::COUPLING.id)),
            Role::Crosstalk(heard) => Some((heard.channel, effect::CROSSTALK.id)),
            Role::Tilt { .. } => Some((0, effect::TILT.id)),
        },
    }
}

/// The problem with the commanded torque as its signal, which no channel mixes.
pub(super) fn commanded(problem: &ProblemFile) -> ProblemFile {
    let mut torque = problem.clone();
    torque.drive.current_law = None;
    torque.controller = None;
    let of_joints = torque.drive.effects_of.iter_mut();
    let lists = of_joints.map(|of| &mut of.value.value);
    for list in lists.chain([&mut torque.drive.effects]) {
        list.retain(|listed| listed.value != effect::CROSSTALK.id);
    }
    if let Some(recordings) = &mut torque.recordings {
        recordings.signal.value = Signal::Torque;
    }
    torque
}
