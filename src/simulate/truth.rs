//! The true models of a simulation, of which every parameter is known.
//!
//! Values come, later ones before earlier ones, from the robot file, an earlier result under
//! `robot.parameters`, `robot.zero`, `drive` and `[simulate.values]`.

use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::{self, Linearity};
use crate::chain::model::{JointModel, Model};
use crate::chain::parameter::{self, Role};
use crate::fault::Place;
use crate::outcome::parameter::Parameter;
use crate::problem_file::{Located, Named, ProblemFile};
use crate::robot::inertia::{Inertia, PER_LINK};
use crate::setup::error::{Mismatch, SetupError};
use crate::setup::known::resolve;
use crate::setup::model_spec::ModelSpec;
use crate::setup::names::{BodyQuantity, Reference, with_quantities};
use crate::setup::robot::Robot;
use crate::setup::truth_spec::{EarlierValues, TruthSpec};
use crate::setup::{declared, sharing};
use crate::simulate::concealed;
use crate::simulate::error::{SimulateError, SimulateErrorKind};

/// Transition speed w of Coulomb friction where none is given, rad/s (m/s): reversals of usual
/// excitations pass it within a few milliseconds.
pub const DEFAULT_WIDTH: f64 = 0.004;

/// What is simulated.
#[derive(Debug, Clone)]
pub struct Truth {
    /// Everything that acts. Its signal is the torque that the controller commands, joint scale.
    pub plant: Model,
    /// The same with the signal that is recorded.
    pub recorded: Model,
    /// What the controller knows: the declared effects, at their true values, and no concealed ones.
    pub nominal: Model,
    /// The truth by the names under which results report it.
    pub parameters: Vec<Parameter>,
    /// The load is not declared, so that every recording carries it.
    pub hidden_load: bool,
    /// Anything a reader should know, one sentence each.
    pub notes: Vec<String>,
}

/// Builds the truth of a problem file.
///
/// # Errors
/// As [`of`]; those of robot and model.
pub fn build(problem: &ProblemFile, robot: &Robot) -> Result<Truth, SimulateError> {
    of(&TruthSpec::of(problem, robot)?, robot)
}

/// Builds a truth from what is said of it.
///
/// # Errors
/// Names that do not exist; a listed effect without a value; values beyond their limits.
pub fn of(spec: &TruthSpec, robot: &Robot) -> Result<Truth, SimulateError> {
    let acting = concealed::add(spec, robot)?;
    let mut plant = acting.commanded.build()?.model;
    let mut assigned = initially_assigned(&plant, &acting.commanded);
    for declared in declared::values(acting.commanded.file_values(), &plant) {
        assigned[declared.parameter] = true;
    }
    assign_earlier(&spec.earlier, &mut plant, &mut assigned);
    let mut recorded = acting.recorded.build()?.model;
    // What lies between torque and signal, or what channels hear of one another, is none of the torque that is commanded.
    let is_beyond = |v: &Named<f64>| {
        let known_to = |model: &Model| resolve(model, &v.name, &v.value.place).is_ok();
        !known_to(&plant) && known_to(&recorded)
    };
    let (beyond, known): (Vec<_>, Vec<_>) = spec.known.iter().cloned().partition(is_beyond);
    let given: Vec<Named<f64>> = known.into_iter().chain(acting.values.clone()).collect();
    refuse_beyond_limits(&plant, &acting.values)?;
    assign(&mut plant, &given, &mut assigned)?;
    share(spec, &mut plant, &mut assigned)?;
    let place = spec.place.clone().key("simulate.values");
    let mut notes = complete(&mut plant, &assigned, &place)?;
    if !acting.concealed.is_empty() {
        notes.push(format!(
            "the truth has what the declared model lacks: {}",
            acting.concealed.join(", ")
        ));
    }
    let mut nominal = spec.commanded.build()?.model;
    copy_values(&plant, &mut recorded)?;
    copy_values(&plant, &mut nominal)?;
    let mut parameters = named(&plant);
    let shares: Vec<usize> = recorded.heard().map(|(_, at)| at).collect();
    for share in shares {
        fix(&mut recorded, share, 0.0, &place)?;
    }
    for entry in beyond.iter().chain(&acting.currents) {
        if let Reference::Parameter(p) = resolve(&recorded, &entry.name, &entry.value.place)? {
            fix(&mut recorded, p, entry.value.value, &entry.value.place)?;
            let known = &recorded.parameters()[p];
            parameters.push(Parameter::known(&known.name, &known.unit, known.value));
        }
    }
    has_gains(&recorded, &place)?;
    Ok(Truth {
        parameters,
        hidden_load: !spec.recorded.has_load(),
        plant,
        recorded,
        nominal,
        notes,
    })
}

/// Controllers have values of all their gains.
fn has_gains(recorded: &Model, place: &Place) -> Result<(), SimulateError> {
    for joint in recorded.joints().iter().filter(|joint| !joint.locked) {
        let gains = joint.controller.map_or(0..0, |kp| kp..kp + 2);
        let unknown = gains
            .map(|p| &recorded.parameters()[p])
            .filter(|p| p.is_free());
        let missing: Vec<String> = unknown.map(|p| p.name.clone()).collect();
        if !missing.is_empty() {
            let effect = format!("{}.controller", joint.name);
            let kind = SimulateErrorKind::NoValue { effect, missing };
            return Err(SimulateError::new(place, kind));
        }
    }
    Ok(())
}

/// Effects and load of an earlier fit; values of parameters that this model does not have are passed over.
fn assign_earlier(earlier: &EarlierValues, model: &mut Model, assigned: &mut [bool]) {
    for (name, value) in earlier.all() {
        let Some(p) = model.position(name) else {
            continue;
        };
        let inertial = matches!(model.parameters()[p].role, Role::Inertial { .. });
        if !inertial && model.fix(p, value).is_ok() {
            assigned[p] = true;
        }
    }
}

/// Parameters that have a value without anyone giving one by name.
fn initially_assigned(model: &Model, spec: &ModelSpec) -> Vec<bool> {
    let has = |parameter: &parameter::Parameter| match parameter.role {
        Role::Inertial { .. } | Role::Tare { .. } | Role::Crosstalk(_) => true,
        Role::Payload { .. } => false,
        Role::Coupling { .. } => spec.has_coupling(),
        Role::Tilt { .. } => false,
        Role::Controller { .. } => !parameter.is_free(),
        Role::Effect { joint, effect, .. } => {
            spec.has_rotor_inertias()
                && model.joints()[joint].effects[effect].0.knowledge.term
                    == Some(JointTerm::RotorInertia)
        }
    };
    model.parameters().iter().map(has).collect()
}

/// First raw parameter of a body, what is given of it, and the entry that names it first.
type GivenBody<'a> = (usize, Vec<(BodyQuantity, f64)>, &'a Named<f64>);

/// Gives parameters their values; a body keeps about its centre of mass what is not given.
fn assign(
    model: &mut Model,
    given: &[Named<f64>],
    assigned: &mut [bool],
) -> Result<(), SimulateError> {
    let mut bodies: Vec<GivenBody> = Vec::new();
    for entry in given {
        let (value, place) = (entry.value.value, &entry.value.place);
        match resolve(model, &entry.name, place)? {
            Reference::Parameter(p) => {
                fix(model, p, value, place)?;
                assigned[p] = true;
            }
            Reference::Body(first, quantity) => {
                match bodies.iter_mut().find(|(f, _, _)| *f == first) {
                    Some((_, list, _)) => list.push((quantity, value)),
                    None => bodies.push((first, vec![(quantity, value)], entry)),
                }
            }
        }
    }
    for (first, quantities, entry) in bodies {
        let place = &entry.value.place;
        let current = Inertia(std::array::from_fn(|k| model.parameters()[first + k].value));
        let body = with_quantities(&current, &quantities);
        if body.mass() == 0.0 && quantities.iter().any(|&(_, value)| value != 0.0) {
            let (body, _) = entry.name.rsplit_once('.').unwrap_or((&entry.name, ""));
            let kind = SimulateErrorKind::NeedsMass {
                body: body.to_string(),
            };
            return Err(SimulateError::new(place, kind));
        }
        for k in 0..PER_LINK {
            fix(model, first + k, body.0[k], place)?;
            assigned[first + k] = true;
        }
    }
    Ok(())
}

/// What one of the joints that share a parameter has, the others have too where nothing else is given of them.
fn share(spec: &TruthSpec, plant: &mut Model, assigned: &mut [bool]) -> Result<(), SimulateError> {
    let effects = |joint: &JointModel| joint.effects.iter().map(|(effect, _)| *effect).collect();
    let effects: Vec<_> = plant.joints().iter().map(effects).collect();
    let place = spec.place.clone().key("drive.shared");
    for sharing in sharing::declared(&spec.alike, &effects) {
        for row in sharing.positions(plant.joints()) {
            let Some(given) = row.iter().copied().find(|p| assigned[*p]) else {
                continue;
            };
            let value = plant.parameters()[given].value;
            for other in row
                .into_iter()
                .filter(|p| !assigned[*p])
                .collect::<Vec<_>>()
            {
                fix(plant, other, value, &place)?;
                assigned[other] = true;
            }
        }
    }
    Ok(())
}

fn fix(model: &mut Model, p: usize, value: f64, place: &Place) -> Result<(), SimulateError> {
    let fixed = model.fix(p, value);
    fixed.map_err(|_| beyond_limits(&model.parameters()[p], value, place))
}

/// A truth that is made up keeps limits that estimates may leave.
fn refuse_beyond_limits(model: &Model, given: &[Named<f64>]) -> Result<(), SimulateError> {
    for Named { name, value } in given {
        let Located { value, place } = value;
        if let Reference::Parameter(p) = resolve(model, name, place)?
            && !model.parameters()[p].is_within_limits(*value)
        {
            return Err(beyond_limits(&model.parameters()[p], *value, place));
        }
    }
    Ok(())
}

fn beyond_limits(parameter: &parameter::Parameter, found: f64, place: &Place) -> SimulateError {
    let kind = Mismatch::OutOfBounds {
        found,
        lower: parameter.lower,
        upper: parameter.upper,
    };
    SetupError::mismatch(place, kind).into()
}

/// Defaults of nonlinear parameters; the notes say which.
///
/// # Errors
/// A linear parameter, or all parameters of an effect, without a value; a load without a mass.
fn complete(
    model: &mut Model,
    assigned: &[bool],
    place: &Place,
) -> Result<Vec<String>, SimulateError> {
    let mut notes = Vec::new();
    for joint in model.joints().to_vec() {
        if joint.locked {
            continue;
        }
        for (effect, first) in joint.effects {
            let own = first..first + effect.parameters.len();
            let untouched = own.clone().all(|p| !assigned[p]);
            let needed = |p: usize| {
                let linear = model.parameters()[p].linearity == Linearity::Linear;
                !assigned[p] && (linear || (untouched && own.len() == 1))
            };
            let missing: Vec<String> = own
                .clone()
                .filter(|&p| needed(p))
                .map(|p| model.parameters()[p].name.clone())
                .collect();
            if !missing.is_empty() {
                let effect = format!("{}.{}", joint.name, effect.id);
                let kind = SimulateErrorKind::NoValue { effect, missing };
                return Err(SimulateError::new(place, kind));
            }
            for p in own.filter(|&p| !assigned[p]) {
                let is_width = effect.knowledge.transition.is_some();
                let value = if is_width {
                    DEFAULT_WIDTH
                } else {
                    model.parameters()[p].scale
                };
                fix(model, p, value, place)?;
                let parameter = &model.parameters()[p];
                notes.push(format!("{} is {value} by default", parameter.name));
            }
        }
    }
    let bare_load = model.payload().is_some_and(|(_, first)| !assigned[first]);
    if bare_load {
        let kind = SimulateErrorKind::NoValue {
            effect: "payload".to_string(),
            missing: vec!["payload.mass".to_string()],
        };
        return Err(SimulateError::new(place, kind));
    }
    without_coupling_value(model, assigned, place)?;
    Ok(notes)
}

fn without_coupling_value(
    model: &Model,
    assigned: &[bool],
    place: &Place,
) -> Result<(), SimulateError> {
    let parameters = model.parameters().iter().zip(assigned);
    let lacking = parameters
        .filter(|(p, has)| !**has && matches!(p.role, Role::Coupling { .. }))
        .find(|(p, _)| match p.role {
            Role::Coupling { row, .. } => !model.joints()[row].locked,
            _ => false,
        });
    match lacking {
        None => Ok(()),
        Some((parameter, _)) => Err(SimulateError::new(
            place,
            SimulateErrorKind::NoValue {
                effect: effect::COUPLING.id.to_string(),
                missing: vec![parameter.name.clone()],
            },
        )),
    }
}

/// Gives a model the values of another for the parameters that both have.
fn copy_values(from: &Model, to: &mut Model) -> Result<(), SimulateError> {
    for p in 0..to.parameters().len() {
        if let Some(source) = from.position(&to.parameters()[p].name) {
            fix(to, p, from.parameters()[source].value, &Place::default())?;
        }
    }
    Ok(())
}

/// Units and names of a body's quantities, and where they stand in the central tensor.
const TENSOR: [(&str, usize, usize); 6] = [
    ("inertia_xx", 0, 0),
    ("inertia_xy", 0, 1),
    ("inertia_xz", 0, 2),
    ("inertia_yy", 1, 1),
    ("inertia_yz", 1, 2),
    ("inertia_zz", 2, 2),
];

/// Every value by its reported name.
fn named(model: &Model) -> Vec<Parameter> {
    let links = model.tree().joints().iter().enumerate();
    let mut bodies: Vec<(String, usize)> = links
        .map(|(link, joint)| (joint.link.clone(), PER_LINK * link))
        .collect();
    if let Some((_, first)) = model.payload() {
        bodies.push(("payload".to_string(), first));
    }
    let mut out = Vec::new();
    for (name, first) in bodies {
        let raw = Inertia(std::array::from_fn(|k| model.parameters()[first + k].value));
        out.push(Parameter::known(format!("{name}.mass"), "kg", raw.mass()));
        // A body without mass has no centre to report.
        let Some(body) = raw.central() else { continue };
        for (axis, value) in ["x", "y", "z"].iter().zip(body.centre.iter()) {
            out.push(Parameter::known(format!("{name}.com_{axis}"), "m", *value));
        }
        for (quantity, a, b) in TENSOR {
            let name = format!("{name}.{quantity}");
            out.push(Parameter::known(name, "kg·m²", body.tensor[(a, b)]));
        }
    }
    let effects = model.parameters().iter().filter(|p| match p.role {
        Role::Effect { joint, .. } => !model.joints()[joint].locked,
        Role::Coupling { row, .. } => !model.joints()[row].locked,
        Role::Tilt { .. } | Role::Controller { .. } => true,
        _ => false,
    });
    out.extend(effects.map(|p| Parameter::known(&p.name, &p.unit, p.value)));
    out
}
