//! What the model of a robot is made of: effects, known values, bounds, the load, what is known before a fit.

use crate::chain::crosstalk::Heard;
use crate::chain::effect::current_polynomial::COEFFICIENTS;
use crate::chain::effect::{self, Catalogue, Effect, Law};
use crate::chain::model::{self, Model, ModelSettings, Payload};
use crate::chain::parameter::Role;
use crate::chain::prior::Prior;
use crate::chain::sharing::Sharing;
use crate::fault::Place;
use crate::mechanism::loops::Mechanism;
use crate::problem_file::choices::{Inertials, PositionSide};
use crate::problem_file::drive::CurrentLaw;
use crate::problem_file::robot::PayloadPlace;
use crate::problem_file::{Located, PerJoint, ProblemFile};
use crate::robot::description::Dependent;
use crate::setup::declared::FileValue;
use crate::setup::error::{Mismatch, SetupError, at, unknown};
use crate::setup::known::Constraints;
use crate::setup::platform::PlatformSpec;
use crate::setup::prior::PriorSpec;
use crate::setup::robot::Robot;
use crate::setup::sharing::Alike;
use crate::setup::signal::signal;
use crate::setup::{controllers, declared, laws, sharing};
use nalgebra::{DMatrix, SymmetricEigen};

/// What the model of a robot is made of, without the form of a file: models with further physics are built from it without
/// reading a table again.
#[derive(Debug, Clone)]
pub struct ModelSpec {
    /// Tree, signal, drives, and the effects of every joint.
    settings: ModelSettings,
    payload: Option<DeclaredLoad>,
    /// Joints that follow others.
    dependents: Vec<Dependent>,
    platform: PlatformSpec,
    mechanism: Option<Mechanism>,
    /// Positions are recorded on the joints, not on the motors.
    position_of_joints: bool,
    /// Joints with motors of one type.
    alike: Vec<Alike>,
    /// What the robot file says of the drives.
    file_values: Vec<FileValue>,
    constraints: Constraints,
    prior: PriorSpec,
    /// Where what cannot be built is to be mended.
    place: Place,
}

/// A load that the robot is said to carry.
#[derive(Debug, Clone)]
struct DeclaredLoad {
    /// Where it hangs.
    payload: Payload,
    /// The frame that it is given in, where that is not its link's.
    frame: Option<String>,
}

/// Physics beside what is declared.
#[derive(Debug, Clone, Default)]
pub struct Addition {
    /// (joint, effect): the effect is put behind those of the joint.
    pub effects: Vec<(usize, &'static Effect)>,
    /// Entries (row, column) of V that become free.
    pub coupling: Vec<(usize, usize)>,
    /// Channels that hear others.
    pub crosstalk: Vec<Heard>,
    /// Effects whose parameters joints have in common, beside those that are declared.
    pub shared: Vec<Sharing>,
}

impl Addition {
    /// Adds an effect to a joint, or to an ordered pair of joints.
    pub fn add(&mut self, effect: &'static Effect, joint: usize, other: Option<usize>) {
        match (effect.law, other) {
            (Law::Crosstalk, Some(source)) => self.crosstalk.push(Heard {
                channel: joint,
                source,
            }),
            (_, Some(other)) => self.coupling.push((joint, other)),
            (_, None) => self.effects.push((joint, effect)),
        }
    }
}

/// A model with what is known of its parameters before a fit.
#[derive(Debug, Clone)]
pub struct ModelWithPrior {
    /// The model.
    pub model: Model,
    /// Of its parameters.
    pub prior: Prior,
}

impl ModelSpec {
    /// What a problem file declares.
    ///
    /// # Errors
    /// Names that the robot does not have, lists of another length than its joints, values that are missing.
    pub fn of(problem: &ProblemFile, robot: &Robot) -> Result<Self, SetupError> {
        Ok(Self {
            prior: PriorSpec::of(problem, robot)?,
            ..Self::without_prior(problem, robot)?
        })
    }

    /// The same, and nothing is known of parameters before: as simulations want it.
    ///
    /// # Errors
    /// As [`ModelSpec::of`].
    pub fn without_prior(problem: &ProblemFile, robot: &Robot) -> Result<Self, SetupError> {
        let catalogue = laws::catalogue(problem)?;
        let effects = effects_of_joints(problem, robot, &catalogue)?;
        let known = problem.robot.inertials.value == Inertials::Known;
        if known {
            possible_bodies(robot)?;
        }
        let recordings = problem.recordings.as_ref();
        let period = recordings.and_then(|table| table.period.as_ref());
        let side = recordings.map(|table| table.position_side.value);
        let alike = Alike::of(problem, robot)?;
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
            coupling: coupling(problem, robot)?,
            offset: Some(offsets(problem, robot)?),
            payload: None,
            locked: robot.locked.iter().map(Option::is_some).collect(),
            catalogue,
            period: period.map(|period| period.value),
            crosstalk: Vec::new(),
            shared: sharing::declared(&alike, &effects),
            effects,
        };
        Ok(Self {
            settings,
            payload: payload(problem, robot)?,
            dependents: robot.dependents.clone(),
            platform: PlatformSpec::of(problem, robot)?,
            mechanism: robot.mechanism.clone(),
            position_of_joints: side.is_some_and(|side| side != PositionSide::Motor),
            alike,
            file_values: declared::file_values(problem, robot),
            constraints: Constraints::of(problem),
            prior: PriorSpec::default(),
            place: problem_place(problem),
        })
    }

    /// The same with other effects on all joints that have a motor, as comparisons want it.
    pub fn compared(&self, listed: &[Located<String>]) -> Self {
        let mut other = self.clone();
        let settings = &mut other.settings;
        let without = without_motor(self.mechanism.as_ref(), &self.dependents);
        let joints = settings.tree.len();
        settings.effects = effects_of_motors(&settings.catalogue, listed, joints, without);
        settings.shared = sharing::declared(&self.alike, &settings.effects);
        other
    }

    /// The same in which every joint has its own parameters.
    pub fn separated(&self) -> Self {
        let mut separated = self.clone();
        separated.settings.shared.clear();
        separated.alike.clear();
        separated
    }

    /// What joints with motors of one type may have in common beside what a model shares.
    pub fn proposed_sharing(&self, model: &Model) -> Vec<Sharing> {
        sharing::proposed(&self.alike, model)
    }

    /// Whether joints are said to have motors of one type.
    pub fn has_motors_of_one_type(&self) -> bool {
        !self.alike.is_empty()
    }

    /// What the robot file says of the drives.
    pub fn file_values(&self) -> &[FileValue] {
        &self.file_values
    }

    /// The frame that a declared load is given in, where it has one of its own.
    pub fn load_frame(&self) -> Option<&str> {
        self.payload.as_ref()?.frame.as_deref()
    }

    /// The model, and what is known of its parameters before a fit.
    ///
    /// # Errors
    /// Effects that do not go together, values outside of their bounds, names that no parameter has.
    pub fn build(&self) -> Result<ModelWithPrior, SetupError> {
        self.build_with(&Addition::default())
    }

    /// The same with further physics.
    ///
    /// # Errors
    /// As [`ModelSpec::build`].
    pub fn build_with(&self, addition: &Addition) -> Result<ModelWithPrior, SetupError> {
        let mut model = self.chain(addition)?;
        if let Some(mechanism) = &self.mechanism {
            self.may_close(&model)?;
            model.close(mechanism.clone());
        }
        self.keep_declared_entries(&mut model, &addition.coupling)?;
        declared::apply(&self.file_values, &mut model);
        self.constraints.apply(&mut model)?;
        let prior = self.prior.build(&mut model)?;
        Ok(ModelWithPrior { model, prior })
    }

    /// The chain from motors to signals, its parameters free.
    fn chain(&self, addition: &Addition) -> Result<Model, SetupError> {
        let mut settings = self.settings.clone();
        // What is added shares nothing unless that is asked for: a hypothesis about one joint has its own parameters.
        settings.shared.extend(addition.shared.iter().cloned());
        settings.crosstalk.extend_from_slice(&addition.crosstalk);
        let freed = addition.coupling.as_slice();
        let of_coupling = freed.iter().map(|&(row, _)| (row, effect::COUPLING));
        for (joint, effect) in addition.effects.iter().copied().chain(of_coupling) {
            let effects = &mut settings.effects[joint];
            if effects.iter().all(|e| e.id != effect.id) {
                effects.push(effect);
            }
        }
        let carries = |list: &Vec<&Effect>| list.iter().any(|e| matches!(e.law, Law::Body));
        let carried = settings.effects.iter().rposition(carries);
        settings.payload = self
            .payload
            .as_ref()
            .map(|load| load.payload)
            .or(carried.map(on));
        let n = settings.tree.len();
        settings.coupling = with_entries(settings.coupling, freed, n);
        let mut model = Model::new(settings).map_err(|e| at(&self.place, e))?;
        model.follow(&self.dependents);
        self.platform.apply(&mut model);
        if self.position_of_joints {
            let declared = self.settings.coupling.clone();
            let reference = declared.unwrap_or_else(|| DMatrix::identity(n, n));
            model.record_joints(model.with_followers(reference));
        }
        Ok(model)
    }

    /// Loops stay closed only where nothing moves their joints beside the motors.
    fn may_close(&self, model: &Model) -> Result<(), SetupError> {
        let mut effects = model.joints().iter().flat_map(|joint| &joint.effects);
        let Some((effect, _)) = effects.find(|(effect, _)| effect.law.moves_joints()) else {
            return Ok(());
        };
        let what = format!(
            "joints that close loops have no `{}`: the loops would move with it",
            effect.id
        );
        Err(SetupError::mismatch(
            &self.place,
            Mismatch::Mechanism { what },
        ))
    }

    /// Entries of V that are given stay known where only others of their row become free.
    fn keep_declared_entries(
        &self,
        model: &mut Model,
        freed: &[(usize, usize)],
    ) -> Result<(), SetupError> {
        if freed.is_empty() {
            return Ok(());
        }
        let id = effect::COUPLING.id;
        for index in 0..model.parameters().len() {
            let parameter = &model.parameters()[index];
            let Role::Coupling { row, column } = parameter.role else {
                continue;
            };
            let estimated = self.settings.effects[row].iter().any(|e| e.id == id);
            if !estimated && !freed.contains(&(row, column)) {
                let value = parameter.value;
                model.fix(index, value).map_err(|e| at(&self.place, e))?;
            }
        }
        Ok(())
    }
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

/// Joints without a motor: those that loops move, and those that follow others.
fn without_motor<'a>(
    mechanism: Option<&'a Mechanism>,
    dependents: &'a [Dependent],
) -> impl Iterator<Item = usize> + 'a {
    let passive = mechanism.into_iter().flat_map(|m| m.passive()).copied();
    passive.chain(dependents.iter().map(|d| d.joint))
}

/// The listed effects for every joint that has a motor.
fn effects_of_motors(
    catalogue: &Catalogue,
    listed: &[Located<String>],
    joints: usize,
    without: impl Iterator<Item = usize>,
) -> Vec<Vec<&'static Effect>> {
    let mut effects = vec![to_effects(catalogue, listed); joints];
    without.for_each(|joint| effects[joint].clear());
    effects
}

fn effects_of_joints(
    problem: &ProblemFile,
    robot: &Robot,
    catalogue: &Catalogue,
) -> Result<Vec<Vec<&'static Effect>>, SetupError> {
    let without = without_motor(robot.mechanism.as_ref(), &robot.dependents);
    let (listed, joints) = (&problem.drive.effects, robot.tree.len());
    let mut effects = effects_of_motors(catalogue, listed, joints, without);
    for entry in &problem.drive.effects_of {
        let Some(k) = robot.tree.joint_index(&entry.name) else {
            return Err(unknown(&entry.value.place, &entry.name, &robot.order));
        };
        effects[k] = to_effects(catalogue, &entry.value);
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

/// A load in the frame of a link.
fn on(link: usize) -> Payload {
    Payload {
        link,
        frame: nalgebra::Isometry3::identity(),
    }
}

/// The load that a problem file declares.
fn payload(problem: &ProblemFile, robot: &Robot) -> Result<Option<DeclaredLoad>, SetupError> {
    let Some(place) = &problem.robot.payload else {
        return Ok(None);
    };
    match &place.value {
        PayloadPlace::Last => Ok(Some(DeclaredLoad {
            payload: on(robot.tree.len() - 1),
            frame: None,
        })),
        PayloadPlace::Named(name) => match robot.tree.frame(name) {
            Some((Some(link), frame)) => Ok(Some(DeclaredLoad {
                payload: Payload { link, frame },
                frame: Some(name.clone()),
            })),
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
