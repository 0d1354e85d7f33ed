//! The model of a problem file: effects, known values, bounds, the load.

use crate::chain::effect::current_polynomial::COEFFICIENTS;
use crate::chain::effect::{self, Catalogue, Effect, Law};
use crate::chain::model::{self, Model, ModelSettings, Payload};
use crate::chain::parameter::Role;
use crate::chain::sharing::Sharing;
use crate::fault::Place;
use crate::problem_file::choices::{Inertials, PositionSide};
use crate::problem_file::drive::CurrentLaw;
use crate::problem_file::robot::PayloadPlace;
use crate::problem_file::{Located, PerJoint, ProblemFile};
use crate::setup::error::{Mismatch, SetupError, at, unknown};
use crate::setup::known::{bound_all, fix_all, zero_parameters};
use crate::setup::robot::Robot;
use crate::setup::signal::signal;
use crate::setup::{controllers, declared, laws, sharing};
use nalgebra::{DMatrix, SymmetricEigen};

/// Builds the model of a problem file.
pub fn build(problem: &ProblemFile, robot: &Robot) -> Result<Model, SetupError> {
    let effects = effects_of_joints(problem, robot, &problem.drive.effects)?;
    build_with(problem, robot, effects, &Addition::default())
}

/// Physics beside what a problem file declares.
#[derive(Debug, Clone, Default)]
pub struct Addition {
    /// (joint, effect): the effect is put behind those of the joint.
    pub effects: Vec<(usize, &'static Effect)>,
    /// Entries (row, column) of V that become free.
    pub coupling: Vec<(usize, usize)>,
    /// Effects whose parameters joints have in common, beside those that the problem file declares.
    pub shared: Vec<Sharing>,
}

/// Builds the model of a problem file with further physics.
pub fn build_with_addition(
    problem: &ProblemFile,
    robot: &Robot,
    addition: &Addition,
) -> Result<Model, SetupError> {
    let effects = effects_of_joints(problem, robot, &problem.drive.effects)?;
    build_with(problem, robot, effects, addition)
}

/// Builds the model with other effects on all joints, as comparisons want it.
pub fn build_compared(
    problem: &ProblemFile,
    robot: &Robot,
    listed: &[Located<String>],
) -> Result<Model, SetupError> {
    let effects = effects_of_motors(&laws::catalogue(problem)?, robot, listed);
    build_with(problem, robot, effects, &Addition::default())
}

fn build_with(
    problem: &ProblemFile,
    robot: &Robot,
    mut effects: Vec<Vec<&'static Effect>>,
    addition: &Addition,
) -> Result<Model, SetupError> {
    // What is added shares nothing unless that is asked for: a hypothesis about one joint has its own parameters.
    let mut shared = sharing::declared(problem, robot, &effects)?;
    shared.extend(addition.shared.iter().cloned());
    let freed = addition.coupling.as_slice();
    let of_coupling = freed.iter().map(|&(row, _)| (row, effect::COUPLING));
    for (joint, effect) in addition.effects.iter().copied().chain(of_coupling) {
        if effects[joint].iter().all(|e| e.id != effect.id) {
            effects[joint].push(effect);
        }
    }
    let known = problem.robot.inertials.value == Inertials::Known;
    if known {
        possible_bodies(robot)?;
    }
    let carried = effects
        .iter()
        .rposition(|list| list.iter().any(|e| matches!(e.law, Law::Body)));
    let declared = coupling(problem, robot)?;
    let settings = ModelSettings {
        tree: robot.tree.clone(),
        signal: signal(problem)?,
        inertials: if known {
            model::Inertials::Known
        } else {
            model::Inertials::Estimate
        },
        controllers: controllers::of_joints(problem, robot)?,
        torque_constant: torque_constant(problem, robot)?,
        torque_constant_std: robot.per_joint(&problem.drive.torque_constant_std)?,
        current_polynomial: current_polynomial(problem, robot)?,
        rotor_inertia: robot.per_joint(&problem.drive.rotor_inertia)?,
        coupling: with_entries(declared.clone(), freed, robot.tree.len()),
        offset: Some(offsets(problem, robot)?),
        payload: payload(problem, robot, carried)?,
        locked: robot.locked.iter().map(Option::is_some).collect(),
        catalogue: laws::catalogue(problem)?,
        period: problem
            .recordings
            .as_ref()
            .and_then(|table| table.period.as_ref())
            .map(|period| period.value),
        shared,
        effects,
    };
    let mut model = Model::new(settings).map_err(|e| at(&problem_place(problem), e))?;
    model.follow(&robot.dependents);
    crate::setup::platform::apply(problem, robot, &mut model)?;
    let side = problem
        .recordings
        .as_ref()
        .map(|table| table.position_side.value);
    if side.is_some_and(|side| side != PositionSide::Motor) {
        let n = robot.tree.len();
        let reference = declared.unwrap_or_else(|| DMatrix::identity(n, n));
        model.record_joints(model.with_followers(reference));
    }
    if let Some(mechanism) = &robot.mechanism {
        let mut effects = model.joints().iter().flat_map(|joint| &joint.effects);
        if let Some((effect, _)) = effects.find(|(effect, _)| effect.law.moves_joints()) {
            let what = format!(
                "joints that close loops have no `{}`: the loops would move with it",
                effect.id
            );
            let place = problem_place(problem);
            return Err(SetupError::mismatch(&place, Mismatch::Mechanism { what }));
        }
        model.close(mechanism.clone());
    }
    keep_declared_entries(&mut model, problem, robot, freed)?;
    declared::apply(problem, robot, &mut model);
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

fn to_effects(catalogue: &Catalogue, listed: &[Located<String>]) -> Vec<&'static Effect> {
    listed
        .iter()
        .filter_map(|id| catalogue.find(&id.value))
        .collect()
}

/// The listed effects for every joint that has a motor.
fn effects_of_motors(
    catalogue: &Catalogue,
    robot: &Robot,
    listed: &[Located<String>],
) -> Vec<Vec<&'static Effect>> {
    let mut effects = vec![to_effects(catalogue, listed); robot.tree.len()];
    let passive = robot.mechanism.iter().flat_map(|m| m.passive()).copied();
    let following = robot.dependents.iter().map(|d| d.joint);
    passive.chain(following).for_each(|k| effects[k].clear());
    effects
}

fn effects_of_joints(
    problem: &ProblemFile,
    robot: &Robot,
    listed: &[Located<String>],
) -> Result<Vec<Vec<&'static Effect>>, SetupError> {
    let catalogue = laws::catalogue(problem)?;
    let mut effects = effects_of_motors(&catalogue, robot, listed);
    for entry in &problem.drive.effects_of {
        let Some(k) = robot.tree.joint_index(&entry.name) else {
            return Err(unknown(&entry.value.place, &entry.name, &robot.order));
        };
        effects[k] = to_effects(&catalogue, &entry.value);
    }
    for k in 0..effects.len() {
        let name = &robot.tree.joints()[k].name;
        // A list for one joint says all of it.
        if problem
            .drive
            .effects_of
            .iter()
            .any(|entry| entry.name == *name)
        {
            continue;
        }
        for effect in declared::effects(problem, robot, k) {
            if effects[k].iter().all(|listed| listed.id != effect.id) {
                effects[k].push(effect);
            }
        }
    }
    Ok(effects)
}

fn torque_constant(problem: &ProblemFile, robot: &Robot) -> Result<Option<Vec<f64>>, SetupError> {
    if signal(problem)? != model::Signal::Current {
        return Ok(None);
    }
    match &problem.drive.current_law {
        Some(CurrentLaw::Constant(values)) => robot.per_joint(&Some(values.clone())),
        Some(CurrentLaw::Polynomial(_)) => Ok(None),
        None => {
            let place = match &problem.recordings {
                Some(recordings) => recordings.signal.place.clone(),
                None => Place::file(&problem.path).key("drive"),
            };
            Err(SetupError::mismatch(&place, Mismatch::NeedsTorqueConstant))
        }
    }
}

fn current_polynomial(
    problem: &ProblemFile,
    robot: &Robot,
) -> Result<Option<Vec<[f64; COEFFICIENTS]>>, SetupError> {
    let Some(CurrentLaw::Polynomial(listed)) = &problem.drive.current_law else {
        return Ok(None);
    };
    if signal(problem)? != model::Signal::Current {
        return Ok(None);
    }
    let (found, expected) = (listed.value.len(), robot.order.len());
    if found != expected {
        let kind = Mismatch::PolynomialCount { found, expected };
        return Err(SetupError::mismatch(&listed.place, kind));
    }
    if let Some((row, c)) = listed.value.iter().enumerate().find(|(_, c)| c[1] <= 0.0) {
        let joint = robot.order[row].clone();
        let kind = Mismatch::FallingPolynomial { joint, slope: c[1] };
        return Err(SetupError::mismatch(&listed.place, kind));
    }
    Ok(Some(robot.to_tree(&listed.value)))
}

fn coupling(problem: &ProblemFile, robot: &Robot) -> Result<Option<DMatrix<f64>>, SetupError> {
    let Some(coupling) = &problem.drive.coupling else {
        return Ok(None);
    };
    let n = robot.tree.len();
    if coupling.value.len() != robot.order.len() {
        return Err(SetupError::mismatch(
            &coupling.place,
            Mismatch::CouplingSize {
                found: coupling.value.len(),
                expected: robot.order.len(),
            },
        ));
    }
    let mut matrix = DMatrix::identity(n, n);
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

/// Start of an entry of V that becomes free: any value other than zero puts it among the parameters.
const ENTRY_START: f64 = 1e-9;

fn with_entries(
    declared: Option<DMatrix<f64>>,
    freed: &[(usize, usize)],
    n: usize,
) -> Option<DMatrix<f64>> {
    if freed.is_empty() {
        return declared;
    }
    let mut matrix = declared.unwrap_or_else(|| DMatrix::identity(n, n));
    for &place in freed {
        if matrix[place] == 0.0 {
            matrix[place] = ENTRY_START;
        }
    }
    Some(matrix)
}

/// Entries of V that the problem file gives stay known where only others of their row become free.
fn keep_declared_entries(
    model: &mut Model,
    problem: &ProblemFile,
    robot: &Robot,
    freed: &[(usize, usize)],
) -> Result<(), SetupError> {
    if freed.is_empty() {
        return Ok(());
    }
    let declared = effects_of_joints(problem, robot, &problem.drive.effects)?;
    let id = effect::COUPLING.id;
    for index in 0..model.parameters().len() {
        let parameter = &model.parameters()[index];
        let Role::Coupling { row, column } = parameter.role else {
            continue;
        };
        let estimated = declared[row].iter().any(|e| e.id == id);
        if !estimated && !freed.contains(&(row, column)) {
            let value = parameter.value;
            let place = problem_place(problem);
            model.fix(index, value).map_err(|e| at(&place, e))?;
        }
    }
    Ok(())
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

/// The problem with torque constants of one where it gives none, for motions that are to show these constants: a
/// model wants some.
pub fn with_unit_constant(problem: &ProblemFile) -> ProblemFile {
    let mut problem = problem.clone();
    if problem.drive.current_law.is_none() {
        let place = Place::file(&problem.path);
        let value = PerJoint::All(1.0);
        problem.drive.current_law = Some(CurrentLaw::Constant(Located { value, place }));
    }
    problem
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
