//! The model of a problem file: effects, known values, bounds, the load.

use crate::chain::effect::{self, Effect, Law};
use crate::chain::error::ModelError;
use crate::chain::model::{self, Model, ModelSettings, Payload};
use crate::fault::Place;
use crate::problem_file::choices::{Inertials, Signal};
use crate::problem_file::drive::CurrentLaw;
use crate::problem_file::robot::PayloadPlace;
use crate::problem_file::{Located, Named, ProblemFile};
use crate::robot::inertia::Inertia;
use crate::setup::error::{Mismatch, SetupError};
use crate::setup::names::{self, BodyQuantity, Reference};
use crate::setup::robot::{Robot, unknown};
use nalgebra::{DMatrix, SymmetricEigen};

/// Builds the model of a problem file.
pub fn build(problem: &ProblemFile, robot: &Robot) -> Result<Model, SetupError> {
    let effects = effects_of_joints(problem, robot, &problem.drive.effects)?;
    build_with(problem, robot, effects)
}

/// Builds the model with other effects on all joints, as comparisons want it.
pub fn build_compared(
    problem: &ProblemFile,
    robot: &Robot,
    listed: &[Located<String>],
) -> Result<Model, SetupError> {
    let effects = vec![to_effects(listed); robot.tree.len()];
    build_with(problem, robot, effects)
}

fn build_with(
    problem: &ProblemFile,
    robot: &Robot,
    effects: Vec<Vec<&'static Effect>>,
) -> Result<Model, SetupError> {
    let known = problem.robot.inertials.value == Inertials::Known;
    if known {
        possible_bodies(robot)?;
    }
    let carried = effects
        .iter()
        .rposition(|list| list.iter().any(|e| matches!(e.law, Law::Body)));
    let settings = ModelSettings {
        tree: robot.tree.clone(),
        signal: signal(problem)?,
        inertials: if known {
            model::Inertials::Known
        } else {
            model::Inertials::Estimate
        },
        torque_constant: torque_constant(problem, robot)?,
        rotor_inertia: robot.per_joint(&problem.drive.rotor_inertia)?,
        coupling: coupling(problem, robot)?,
        offset: Some(offsets(problem, robot)?),
        payload: payload(problem, robot, carried)?,
        locked: robot.locked.iter().map(Option::is_some).collect(),
        effects,
    };
    let mut model = Model::new(settings).map_err(|e| at(&problem_place(problem), e))?;
    zero_parameters(&mut model, problem)?;
    fix_all(&mut model, &problem.drive.values)?;
    bound_all(&mut model, problem)?;
    Ok(model)
}

fn problem_place(problem: &ProblemFile) -> Place {
    match &problem.drive.coupling {
        Some(coupling) => coupling.place.clone(),
        None => Place::file(&problem.path),
    }
}

/// A fault of the model as one of the problem file.
fn at(place: &Place, error: ModelError) -> SetupError {
    let kind = match error {
        ModelError::UnknownParameter { name, nearest } => Mismatch::UnknownParameter {
            found: name,
            nearest,
        },
        ModelError::NeedsMass { name } => Mismatch::NeedsMass { found: name },
        ModelError::OutOfBounds {
            value,
            lower,
            upper,
            ..
        } => Mismatch::OutOfBounds {
            found: value,
            lower,
            upper,
        },
        ModelError::SingularCoupling => Mismatch::SingularCoupling,
    };
    SetupError::mismatch(place, kind)
}

fn to_effects(listed: &[Located<String>]) -> Vec<&'static Effect> {
    listed
        .iter()
        .filter_map(|id| effect::find(&id.value))
        .collect()
}

fn effects_of_joints(
    problem: &ProblemFile,
    robot: &Robot,
    listed: &[Located<String>],
) -> Result<Vec<Vec<&'static Effect>>, SetupError> {
    let mut effects = vec![to_effects(listed); robot.tree.len()];
    for entry in &problem.drive.effects_of {
        let Some(k) = robot.tree.joint_index(&entry.name) else {
            return Err(unknown(&entry.value.place, &entry.name, &robot.order));
        };
        effects[k] = to_effects(&entry.value);
    }
    Ok(effects)
}

fn signal(problem: &ProblemFile) -> Result<model::Signal, SetupError> {
    let Some(recordings) = &problem.recordings else {
        return Ok(match problem.drive.current_law {
            Some(_) => model::Signal::Current,
            None => model::Signal::Torque,
        });
    };
    Ok(match recordings.signal.value {
        Signal::Current => model::Signal::Current,
        Signal::Torque | Signal::MotorTorque => model::Signal::Torque,
        Signal::LinkTorque => model::Signal::LinkTorque,
        Signal::BaseWrench => model::Signal::BaseWrench,
        Signal::Both => model::Signal::Both,
    })
}

fn torque_constant(problem: &ProblemFile, robot: &Robot) -> Result<Option<Vec<f64>>, SetupError> {
    if signal(problem)? != model::Signal::Current {
        return Ok(None);
    }
    match &problem.drive.current_law {
        Some(CurrentLaw::Constant(values)) => robot.per_joint(&Some(values.clone())),
        Some(CurrentLaw::Polynomial(values)) => Err(SetupError::mismatch(
            &values.place,
            Mismatch::NotYet {
                what: "a current polynomial".to_string(),
                instead: "give `drive.torque_constant`".to_string(),
            },
        )),
        None => {
            let place = match &problem.recordings {
                Some(recordings) => recordings.signal.place.clone(),
                None => Place::file(&problem.path).key("drive"),
            };
            Err(SetupError::mismatch(&place, Mismatch::NeedsTorqueConstant))
        }
    }
}

fn coupling(problem: &ProblemFile, robot: &Robot) -> Result<Option<DMatrix<f64>>, SetupError> {
    let Some(coupling) = &problem.drive.coupling else {
        return Ok(None);
    };
    let n = robot.tree.len();
    if coupling.value.len() != n {
        return Err(SetupError::mismatch(
            &coupling.place,
            Mismatch::CouplingSize {
                found: coupling.value.len(),
                expected: n,
            },
        ));
    }
    let mut matrix = DMatrix::zeros(n, n);
    for (i, row) in coupling.value.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            matrix[(robot.position[i], robot.position[j])] = *value;
        }
    }
    for (k, locked) in robot.locked.iter().enumerate() {
        let moved = (0..n).any(|j| j != k && matrix[(k, j)] != 0.0);
        if locked.is_some() && moved {
            let joint = robot.tree.joints()[k].name.clone();
            return Err(SetupError::mismatch(
                &coupling.place,
                Mismatch::LockedCoupled { joint },
            ));
        }
    }
    Ok(Some(matrix))
}

/// Offsets of `q = V m + offset`; a locked joint's motor stands at zero, so its offset is its position.
fn offsets(problem: &ProblemFile, robot: &Robot) -> Result<Vec<f64>, SetupError> {
    let mut offsets = robot
        .per_joint(&problem.drive.offset)?
        .unwrap_or_else(|| vec![0.0; robot.tree.len()]);
    for (offset, locked) in offsets.iter_mut().zip(&robot.locked) {
        if let Some(position) = locked {
            *offset = *position;
        }
    }
    Ok(offsets)
}

fn payload(
    problem: &ProblemFile,
    robot: &Robot,
    carried: Option<usize>,
) -> Result<Option<Payload>, SetupError> {
    let last = robot.tree.len() - 1;
    let on = |link| Payload {
        link,
        frame: nalgebra::Isometry3::identity(),
    };
    let Some(place) = &problem.robot.payload else {
        return Ok(carried.map(on));
    };
    match &place.value {
        PayloadPlace::Last => Ok(Some(on(last))),
        PayloadPlace::Named(name) => match robot.tree.frame(name) {
            Some((Some(link), frame)) => Ok(Some(Payload { link, frame })),
            _ => Err(SetupError::mismatch(
                &place.place,
                Mismatch::UnknownFrame {
                    found: name.clone(),
                    known: robot.frame_names(),
                },
            )),
        },
    }
}

/// Known bodies must be bodies: every pseudo-inertia positive semidefinite.
fn possible_bodies(robot: &Robot) -> Result<(), SetupError> {
    /// Share of the largest eigenvalue that decimal numbers in a robot file may miss zero by.
    const ROUNDING: f64 = 1e-6;
    for joint in robot.tree.joints() {
        let eigenvalues = SymmetricEigen::new(joint.inertia.pseudo_inertia()).eigenvalues;
        let (least, largest) = (eigenvalues.min(), eigenvalues.amax());
        if least < -ROUNDING * largest {
            return Err(SetupError::mismatch(
                &Place::file(&robot.file).key(&joint.link),
                Mismatch::Impossible {
                    link: joint.link.clone(),
                    eigenvalue: least,
                },
            ));
        }
    }
    Ok(())
}

/// Parameters that are zero by construction. A product of inertia about the centre of mass is zero about
/// the origin too only where one of its axes has no first moment; elsewhere it says nothing linear.
fn zero_parameters(model: &mut Model, problem: &ProblemFile) -> Result<(), SetupError> {
    let listed: Vec<(Reference, &Place)> = problem
        .robot
        .zero
        .iter()
        .map(|name| Ok((resolve(model, &name.value, &name.place)?, &name.place)))
        .collect::<Result<_, SetupError>>()?;
    let has_zero_centre = |first: usize, axis: usize| {
        let wanted = Reference::Body(first, BodyQuantity::Centre(axis));
        listed.iter().any(|(reference, _)| *reference == wanted)
    };
    for (reference, place) in &listed {
        let raw = match *reference {
            Reference::Parameter(parameter) => Some(parameter),
            Reference::Body(first, BodyQuantity::Mass) => Some(first),
            Reference::Body(first, BodyQuantity::Centre(axis)) => Some(first + 1 + axis),
            Reference::Body(first, BodyQuantity::Inertia(a, b)) => {
                let free = a != b && (has_zero_centre(first, a) || has_zero_centre(first, b));
                free.then(|| first + raw_inertia(a, b))
            }
        };
        if let Some(raw) = raw {
            model.fix(raw, 0.0).map_err(|e| at(place, e))?;
        }
    }
    Ok(())
}

/// Position of an inertia entry among the ten raw parameters.
fn raw_inertia(a: usize, b: usize) -> usize {
    const POSITIONS: [[usize; 3]; 3] = [[4, 5, 7], [5, 6, 8], [7, 8, 9]];
    POSITIONS[a][b]
}

pub(crate) fn resolve(model: &Model, name: &str, place: &Place) -> Result<Reference, SetupError> {
    names::resolve(model, name).ok_or_else(|| {
        SetupError::mismatch(
            place,
            Mismatch::UnknownParameter {
                found: name.to_string(),
                nearest: names::nearest(model, name),
            },
        )
    })
}

/// Makes given values known; quantities of one body are taken together.
pub fn fix_all(model: &mut Model, given: &[Named<f64>]) -> Result<(), SetupError> {
    let mut bodies: Vec<(usize, Vec<(BodyQuantity, f64)>)> = Vec::new();
    for entry in given {
        let (value, place) = (entry.value.value, &entry.value.place);
        match resolve(model, &entry.name, place)? {
            Reference::Parameter(p) => model.fix(p, value).map_err(|e| at(place, e))?,
            Reference::Body(first, quantity) => {
                match bodies.iter_mut().find(|(f, _)| *f == first) {
                    Some((_, list)) => list.push((quantity, value)),
                    None => bodies.push((first, vec![(quantity, value)])),
                }
            }
        }
    }
    for (first, quantities) in bodies {
        fix_body(model, first, &quantities).map_err(|name| {
            let place = given.iter().find(|e| e.name.ends_with(&name));
            let place = place.map_or_else(Place::default, |e| e.value.place.clone());
            SetupError::mismatch(&place, Mismatch::NeedsMass { found: name })
        })?;
    }
    Ok(())
}

/// Fixes the raw parameters that the given quantities determine; the error is the quantity that needs more.
fn fix_body(model: &mut Model, first: usize, given: &[(BodyQuantity, f64)]) -> Result<(), String> {
    let current = Inertia(std::array::from_fn(|k| model.parameters()[first + k].value));
    let body = names::with_quantities(&current, given);
    let known = |model: &Model, k: usize| !model.parameters()[first + k].is_free();
    let has = |quantity: BodyQuantity| given.iter().any(|(q, _)| *q == quantity);
    let mass = has(BodyQuantity::Mass) || known(model, 0);
    let centre = |axis: usize, model: &Model| {
        mass && (has(BodyQuantity::Centre(axis)) || known(model, 1 + axis))
    };
    for &(quantity, _) in given {
        let (raw, determined, name) = match quantity {
            BodyQuantity::Mass => (0, true, "mass".to_string()),
            BodyQuantity::Centre(axis) => {
                (1 + axis, mass, format!("com_{}", ["x", "y", "z"][axis]))
            }
            BodyQuantity::Inertia(a, b) => {
                let axes: Vec<usize> = if a == b {
                    (0..3).filter(|&k| k != a).collect()
                } else {
                    vec![a, b]
                };
                let letters = ["x", "y", "z"];
                (
                    raw_inertia(a, b),
                    axes.into_iter().all(|axis| centre(axis, model)),
                    format!("inertia_{}{}", letters[a], letters[b]),
                )
            }
        };
        if !determined {
            return Err(name);
        }
        // Raw inertial parameters have no bounds to lie outside of.
        model.fix(first + raw, body.0[raw]).map_err(|_| name)?;
    }
    Ok(())
}

fn bound_all(model: &mut Model, problem: &ProblemFile) -> Result<(), SetupError> {
    for entry in &problem.fit.bounds {
        let place = &entry.value.place;
        let parameter = match resolve(model, &entry.name, place)? {
            Reference::Parameter(parameter) => parameter,
            Reference::Body(first, BodyQuantity::Mass) => first,
            Reference::Body(..) => {
                return Err(SetupError::mismatch(
                    place,
                    Mismatch::NotYet {
                        what: format!("a bound on `{}`", entry.name),
                        instead: "bound masses and parameters of effects".to_string(),
                    },
                ));
            }
        };
        let interval = &entry.value.value;
        let current = &model.parameters()[parameter];
        let (lower, upper) = (
            interval.lower.max(current.lower),
            interval.upper.min(current.upper),
        );
        if lower > upper {
            return Err(SetupError::mismatch(
                place,
                Mismatch::OutOfBounds {
                    found: interval.upper,
                    lower: current.lower,
                    upper: current.upper,
                },
            ));
        }
        model.bound(parameter, lower, upper);
    }
    Ok(())
}
