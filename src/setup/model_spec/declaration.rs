//! What a problem file declares of a model.

use crate::chain::effect::current_polynomial::COEFFICIENTS;
use crate::chain::effect::{self, Catalogue, Effect};
use crate::chain::model::{self, ModelSettings, Payload, Signal};
use crate::fault::Place;
use crate::mechanism::loops::Mechanism;
use crate::problem_file::choices::{Inertials, PositionSide};
use crate::problem_file::drive::CurrentLaw;
use crate::problem_file::robot::PayloadPlace;
use crate::problem_file::{Located, ProblemFile};
use crate::robot::description::Dependent;
use crate::setup::error::{Mismatch, SetupError, unknown};
use crate::setup::known::Constraints;
use crate::setup::model_spec::{DeclaredLoad, ModelSpec, add, on};
use crate::setup::platform::PlatformSpec;
use crate::setup::prior::PriorSpec;
use crate::setup::purpose::Purpose;
use crate::setup::robot::Robot;
use crate::setup::sharing::{self, Alike};
use crate::setup::signal::signal;
use crate::setup::{controllers, declared, laws};
use nalgebra::{DMatrix, SymmetricEigen};

impl ModelSpec {
    /// What a problem file declares.
    ///
    /// # Errors
    /// Names that the robot does not have, lists of another length than its joints, values that are missing.
    pub fn of(problem: &ProblemFile, robot: &Robot) -> Result<Self, SetupError> {
        Declaration::of(problem, robot, Purpose::Estimation).spec_with_prior()
    }

    /// The same, and nothing is known of parameters before.
    ///
    /// # Errors
    /// As [`ModelSpec::of`].
    pub fn without_prior(problem: &ProblemFile, robot: &Robot) -> Result<Self, SetupError> {
        Declaration::of(problem, robot, Purpose::Estimation).spec()
    }

    /// For motions that are to show torque constants: those that are not given are one, since a model wants some.
    ///
    /// # Errors
    /// As [`ModelSpec::of`].
    pub fn of_unknown_constants(problem: &ProblemFile, robot: &Robot) -> Result<Self, SetupError> {
        Declaration::of(problem, robot, Purpose::TorqueConstants).spec_with_prior()
    }

    /// What a simulation records: bodies and gains are known, and nothing is shared, bounded or known by name.
    ///
    /// # Errors
    /// As [`ModelSpec::of`].
    pub fn of_simulation(problem: &ProblemFile, robot: &Robot) -> Result<Self, SetupError> {
        Declaration::of(problem, robot, Purpose::Simulation).spec()
    }

    /// What the controller of a simulated robot commands: torques of the joints, which no channel mixes.
    ///
    /// # Errors
    /// As [`ModelSpec::of`].
    pub fn of_command(problem: &ProblemFile, robot: &Robot) -> Result<Self, SetupError> {
        let declaration = Declaration {
            signal: Signal::Torque,
            ..Declaration::of(problem, robot, Purpose::Simulation)
        };
        let mut spec = declaration.spec()?;
        for effects in &mut spec.settings.effects {
            effects.retain(|listed| listed.id != effect::CROSSTALK.id);
        }
        Ok(spec)
    }

    /// The same with other effects on all joints that have a motor, as comparisons want it.
    pub fn compared(&self, listed: &[Located<String>]) -> Self {
        let without = without_motor(self.mechanism.as_ref(), &self.dependents);
        let joints = self.settings.tree.len();
        self.with_effects(effects_of_motors(self.catalogue(), listed, joints, without))
    }
}

/// What a problem file says of a robot, and what for it is read.
#[derive(Clone, Copy)]
struct Declaration<'a> {
    problem: &'a ProblemFile,
    robot: &'a Robot,
    purpose: Purpose,
    signal: Signal,
}

impl<'a> Declaration<'a> {
    fn of(problem: &'a ProblemFile, robot: &'a Robot, purpose: Purpose) -> Self {
        Self {
            problem,
            robot,
            purpose,
            signal: signal(problem, purpose),
        }
    }

    fn spec_with_prior(&self) -> Result<ModelSpec, SetupError> {
        Ok(ModelSpec {
            prior: PriorSpec::of(self.problem, self.robot)?,
            ..self.spec()?
        })
    }

    fn spec(&self) -> Result<ModelSpec, SetupError> {
        let (problem, robot) = (self.problem, self.robot);
        let catalogue = laws::catalogue(problem)?;
        let effects = self.effects_of_joints(&catalogue)?;
        let is_truth = self.purpose == Purpose::Simulation;
        let known = is_truth || problem.robot.inertials.value == Inertials::Known;
        if known {
            possible_bodies(robot)?;
        }
        let recordings = problem.recordings.as_ref();
        let period = recordings.and_then(|table| table.period.as_ref());
        let side = recordings.map(|table| table.position_side.value);
        // The truth may be a robot that refuses what the declared model takes for common.
        let alike = match is_truth {
            true => Vec::new(),
            false => Alike::of(problem, robot)?,
        };
        let settings = ModelSettings {
            tree: robot.tree.clone(),
            signal: self.signal,
            inertials: if known {
                model::Inertials::Known
            } else {
                model::Inertials::Estimate
            },
            controllers: controllers::of_joints(problem, robot, self.signal, self.purpose)?,
            torque_constant: self.torque_constant()?,
            torque_constant_std: robot.per_joint(&problem.drive.torque_constant_std)?,
            current_polynomial: self.current_polynomial()?,
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
        Ok(ModelSpec {
            settings,
            payload: payload(problem, robot)?,
            dependents: robot.dependents.clone(),
            platform: PlatformSpec::of(problem, robot)?,
            mechanism: robot.mechanism.clone(),
            position_of_joints: side.is_some_and(|side| side != PositionSide::Motor),
            alike,
            file_values: declared::file_values(problem, robot, self.signal),
            constraints: match is_truth {
                true => Constraints::default(),
                false => Constraints::of(problem),
            },
            prior: PriorSpec::default(),
            place: problem_place(problem),
        })
    }

    fn effects_of_joints(
        &self,
        catalogue: &Catalogue,
    ) -> Result<Vec<Vec<&'static Effect>>, SetupError> {
        let (problem, robot) = (self.problem, self.robot);
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
            for effect in declared::effects(problem, robot, self.signal, k) {
                add(&mut effects[k], effect);
            }
        }
        Ok(effects)
    }

    fn torque_constant(&self) -> Result<Option<Vec<f64>>, SetupError> {
        let (problem, robot) = (self.problem, self.robot);
        if self.signal != Signal::Current {
            return Ok(None);
        }
        match &problem.drive.current_law {
            Some(CurrentLaw::Constant(values)) => robot.per_joint(&Some(values.clone())),
            Some(CurrentLaw::Polynomial(_)) => Ok(None),
            None if self.purpose == Purpose::TorqueConstants => {
                Ok(Some(vec![1.0; robot.tree.len()]))
            }
            None => {
                let place = match &problem.recordings {
                    Some(recordings) => recordings.signal.place.clone(),
                    None => Place::file(&problem.path).key("drive"),
                };
                Err(SetupError::mismatch(&place, Mismatch::NeedsTorqueConstant))
            }
        }
    }

    fn current_polynomial(&self) -> Result<Option<Vec<[f64; COEFFICIENTS]>>, SetupError> {
        let (problem, robot) = (self.problem, self.robot);
        let Some(CurrentLaw::Polynomial(listed)) = &problem.drive.current_law else {
            return Ok(None);
        };
        if self.signal != Signal::Current {
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
