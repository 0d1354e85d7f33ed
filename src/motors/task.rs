//! The task behind `exid fit` with the estimator `constant_velocity`: recordings to steady parts, parts to
//! constants.

use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::of_term;
use crate::chain::model::Model;
use crate::fault::Place;
use crate::motors::compare::{Constant, of_same_type};
use crate::motors::constants::{Part, Term, first_stage, second_stage};
use crate::motors::error::MotorsError;
use crate::motors::figures::{self, Predicted};
use crate::motors::joint_fit::{JointFit, Source, Steady};
use crate::motors::outcome;
use crate::motors::segments::{Segment, Steadiness, steady};
use crate::outcome::estimate::Estimate;
use crate::outcome::fit::Fit;
use crate::problem_file::choices::{Inertials, PositionSide, Signal};
use crate::problem_file::fit::ConstantVelocityTable;
use crate::problem_file::{ProblemFile, RecordingsTable};
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::samples::Recording;
use crate::recording::split::Split;
use crate::robot::newton_euler::NewtonEuler;
use crate::setup;
use crate::setup::error::{Mismatch, SetupError};
use crate::setup::model_spec::ModelSpec;
use crate::setup::recording_file::ReadRecording;
use crate::setup::recordings::read_all;
use crate::setup::robot::Robot;

/// What the fit gives.
#[derive(Debug)]
pub struct MotorRun {
    /// Torque constants and friction, with errors.
    pub estimate: Estimate,
    /// The stages and what else the verb adds to a result.
    pub fit: Fit,
    /// Names of the joints, in the order of the columns of `predictions`.
    pub joints: Vec<String>,
    /// Recorded and predicted currents, recording by recording.
    pub predictions: Vec<Predicted>,
}

/// Runs the fit of a problem file.
///
/// # Errors
/// Faults of the file and of those that it names; settings of another estimator; as [`MotorsTask::run`].
pub fn run(problem: &ProblemFile) -> Result<MotorRun, MotorsError> {
    let recordings = problem.recordings().map_err(SetupError::from)?;
    check_settings(problem, recordings)?;
    let robot = setup::robot::open(problem)?;
    require_tree(problem, &robot)?;
    check_names(problem, &robot)?;
    let task = MotorsTask {
        robot: &robot,
        declared: &ModelSpec::of_unknown_constants(problem, &robot)?,
        recordings,
        settings: &problem.fit.constant_velocity,
        place: Place::file(&problem.path),
    };
    task.run()
}

/// A robot whose bodies are known, and recordings of its joints at constant speed.
#[derive(Debug, Clone)]
pub struct MotorsTask<'a> {
    /// The robot that the recordings are of.
    pub robot: &'a Robot,
    /// What its model is made of.
    pub declared: &'a ModelSpec,
    /// Those that are fitted and those that are held out.
    pub recordings: &'a RecordingsTable,
    /// What is steady, constants that are known, joints with motors of one type.
    pub settings: &'a ConstantVelocityTable,
    /// Where a load that is not known is to be given.
    pub place: Place,
}

impl MotorsTask<'_> {
    /// Fits the motor constants of every joint that moves.
    ///
    /// # Errors
    /// Recordings that cannot be read, or in which nothing moves at constant speed; a load that is not known.
    pub fn run(&self) -> Result<MotorRun, MotorsError> {
        // Bodies of an earlier fit become those of the model; priors of torque constants have a table of their own.
        let model = self.declared.build()?.model;
        let rule = Steadiness {
            least_speed: self.settings.least_speed.value,
            ..Steadiness::default()
        };
        let mut recordings = Vec::new();
        for ReadRecording { named, recording } in read_all(self.recordings, self.robot)? {
            let parameters = self.link_parameters(&model, named.loaded)?;
            let mut steady =
                steady_parts(&recording, self.recordings, self.robot, &parameters, &rule)?;
            steady.name = named.path.written.clone();
            steady.split = named.split;
            recordings.push(steady);
        }
        let joints = self.fit_joints(&recordings);
        let figures = figures::joints(&joints, &recordings);
        let predictions = figures::predictions(&joints, &recordings);
        let (mut estimate, fit) = outcome::build(&self.settings.same_type, &joints);
        estimate.joints = figures;
        Ok(MotorRun {
            estimate,
            fit,
            joints: joints.into_iter().map(|joint| joint.name).collect(),
            predictions,
        })
    }

    /// Inertial parameters of the links, with the known load where it hangs on the robot.
    fn link_parameters(&self, model: &Model, loaded: bool) -> Result<Vec<f64>, MotorsError> {
        let bodies = 10 * model.tree().len();
        let mut parameters = model.values().rows(0, bodies).as_slice().to_vec();
        let (true, Some((payload, first))) = (loaded, model.payload()) else {
            return Ok(parameters);
        };
        // The inertia about its centre of mass has no effect at constant speed.
        if model.parameters()[first..first + 4]
            .iter()
            .any(|p| p.is_free())
        {
            let place = self.place.clone().key("robot.payload");
            return Err(MotorsError::Setting {
                place: place.to_string(),
                message:
                    "the load is not known, and torque constants follow from known masses only"
                        .into(),
                remedy: "give payload.mass, payload.com_x, payload.com_y and payload.com_z under \
                         [drive.values]"
                    .into(),
            });
        }
        let body =
            nalgebra::SVector::<f64, 10>::from_fn(|k, _| match model.parameters()[first + k] {
                ref parameter if parameter.is_free() => 0.0,
                ref parameter => parameter.value,
            });
        let carried = payload.transfer() * body;
        for (k, value) in carried.iter().enumerate() {
            parameters[10 * payload.link + k] += value;
        }
        Ok(parameters)
    }

    fn fit_joints(&self, recordings: &[Steady]) -> Vec<JointFit> {
        let robot = self.robot;
        let moving = (0..robot.tree.len()).filter(|&k| robot.locked[k].is_none());
        let mut joints: Vec<JointFit> = moving.map(|joint| self.first(joint, recordings)).collect();
        let known: Vec<(String, Source)> = joints
            .iter()
            .map(|joint| (joint.name.clone(), joint.constant))
            .collect();
        for joint in &mut joints {
            if joint.constant == Source::Undetermined
                && let Some(constant) = of_same_type(&self.others(&joint.name, &known))
            {
                joint.constant = Source::SameType(constant);
            }
            joint.friction = second_stage(
                &joint.stage,
                &self.terms(joint.index),
                joint.constant.inverse(),
            );
        }
        joints
    }

    fn first(&self, index: usize, recordings: &[Steady]) -> JointFit {
        let joint = &self.robot.tree.joints()[index];
        let trained = recordings.iter().filter(|r| r.split == Split::Train);
        let parts: Vec<Part> = trained
            .flat_map(|r| r.segments.iter().zip(&r.parts))
            .filter(|(segment, _)| segment.joint == index)
            .map(|(_, part)| part.clone())
            .collect();
        let stage = first_stage(&parts);
        let given = &self.settings.torque_constant;
        let constant = match given.iter().find(|entry| entry.name == joint.name) {
            Some(entry) => Source::Given(entry.value.value),
            None => stage.inverse.map_or(Source::Undetermined, |inverse| {
                let (a, sigma) = (inverse.value, inverse.variance.sqrt());
                Source::Data((1.0 / a, sigma / (a * a)))
            }),
        };
        JointFit {
            index,
            name: joint.name.clone(),
            torque_unit: joint.kind.effort_unit(),
            position_unit: joint.kind.position_unit(),
            parts,
            stage,
            constant,
            friction: None,
            vertical: is_vertical(self.robot, index),
        }
    }

    /// Terms of the friction law of a joint: those of the paper, and an offset where it has one.
    fn terms(&self, joint: usize) -> Vec<Term> {
        let mut terms = vec![Term::Coulomb, Term::Viscous];
        let offset = of_term(JointTerm::Offset);
        if self.declared.effects()[joint]
            .iter()
            .any(|e| e.id == offset.id)
        {
            terms.push(Term::Offset);
        }
        terms
    }

    /// Constants that the data give for the other joints of a joint's type.
    fn others(&self, name: &str, known: &[(String, Source)]) -> Vec<Constant> {
        let groups = &self.settings.same_type;
        let group = groups
            .iter()
            .find(|group| group.iter().any(|joint| joint.value == name));
        let Some(group) = group else {
            return Vec::new();
        };
        let listed = known
            .iter()
            .filter(|(joint, _)| joint != name && group.iter().any(|other| other.value == *joint));
        listed
            .filter_map(|(_, source)| match source {
                Source::Data(constant) => Some(*constant),
                _ => None,
            })
            .collect()
    }
}

/// The balance of a joint at constant speed is that of a tree.
fn require_tree(problem: &ProblemFile, robot: &Robot) -> Result<(), MotorsError> {
    if robot.mechanism.is_none() {
        return Ok(());
    }
    let kind = Mismatch::NotYet {
        what: "a fit of motor constants at constant speed of a mechanism with closed loops".into(),
        instead: "fit it by maximum likelihood or least squares".into(),
    };
    Err(SetupError::mismatch(&problem.fit.estimator.place, kind).into())
}

fn check_settings(problem: &ProblemFile, table: &RecordingsTable) -> Result<(), MotorsError> {
    let fault = |place: &Place, message: &str, remedy: &str| {
        Err(MotorsError::Setting {
            place: place.to_string(),
            message: message.into(),
            remedy: remedy.into(),
        })
    };
    if table.signal.value != Signal::Current {
        let message = "motor constants at constant speed come from motor currents";
        return fault(&table.signal.place, message, "set signal = \"current\"");
    }
    if table.position_side.value != PositionSide::Joint {
        let message = "the fit at constant speed wants positions of the joints";
        return fault(
            &table.position_side.place,
            message,
            "set position_side = \"joint\"",
        );
    }
    if problem.robot.inertials.value != Inertials::Known {
        let message = "torque constants follow from known masses only";
        let remedy = "set inertials = \"known\" under [robot]";
        return fault(&problem.robot.inertials.place, message, remedy);
    }
    Ok(())
}

/// Every joint that the settings name has to exist.
fn check_names(problem: &ProblemFile, robot: &Robot) -> Result<(), MotorsError> {
    let settings = &problem.fit.constant_velocity;
    let given = settings
        .torque_constant
        .iter()
        .map(|e| (&e.name, &e.value.place));
    let listed = settings
        .same_type
        .iter()
        .flatten()
        .map(|e| (&e.value, &e.place));
    for (name, place) in given.chain(listed) {
        if robot.tree.joint_index(name).is_none() {
            return Err(setup::error::unknown(place, name, &robot.order).into());
        }
    }
    Ok(())
}

fn steady_parts(
    recording: &Recording,
    table: &RecordingsTable,
    robot: &Robot,
    parameters: &[f64],
    rule: &Steadiness,
) -> Result<Steady, MotorsError> {
    let time = times(recording, table)?;
    let tree = &robot.tree;
    let moving: Vec<usize> = (0..tree.len())
        .filter(|&k| robot.locked[k].is_none())
        .collect();
    let segments = steady(&time, &recording.position, rule);
    let mut dynamics = NewtonEuler::new(tree);
    let mut q: Vec<f64> = robot.locked.iter().map(|l| l.unwrap_or(0.0)).collect();
    let (rest, mut torque) = (vec![0.0; tree.len()], vec![0.0; tree.len()]);
    let mut parts = Vec::new();
    for segment in &segments {
        let mut dq = rest.clone();
        dq[moving[segment.joint]] = segment.speed;
        let mut part = Part {
            speed: segment.speed,
            torque: Vec::new(),
            current: Vec::new(),
        };
        for k in segment.samples.clone() {
            for (j, &joint) in moving.iter().enumerate() {
                q[joint] = recording.position[j][k];
            }
            dynamics.torque(tree, parameters, [&q, &dq, &rest], &mut torque);
            part.torque.push(torque[moving[segment.joint]]);
            part.current.push(recording.signal[segment.joint][k]);
        }
        parts.push(part);
    }
    if segments.is_empty() {
        return Err(MotorsError::NothingSteady {
            file: recording.file.display().to_string(),
            least_speed: rule.least_speed,
        });
    }
    let in_tree = |mut segment: Segment| {
        segment.joint = moving[segment.joint];
        segment
    };
    Ok(Steady {
        name: String::new(),
        split: Split::Train,
        time,
        segments: segments.into_iter().map(in_tree).collect(),
        parts,
    })
}

/// Time of every sample, s, increasing.
fn times(recording: &Recording, table: &RecordingsTable) -> Result<Vec<f64>, MotorsError> {
    let place = Place::file(&recording.file);
    let fault = |place, kind| SetupError::from(RecordingError { place, kind }).into();
    let samples = recording.position.first().map_or(0, Vec::len);
    let time = match (&recording.time, &table.rate) {
        (Some(time), _) => time.clone(),
        (None, Some(rate)) => (0..samples).map(|k| k as f64 / rate.value).collect(),
        (None, None) => return Err(fault(place, RecordingErrorKind::NoTimeBase)),
    };
    match (1..time.len()).find(|&k| time[k] <= time[k - 1]) {
        None => Ok(time),
        Some(k) => {
            let (before, found) = (time[k - 1], time[k]);
            let kind = RecordingErrorKind::TimeNotIncreasing { before, found };
            Err(fault(place.line(recording.line(k)), kind))
        }
    }
}

/// Whether the axis is parallel to gravity: such a joint is the first one, or one after joints that
/// stand at zero.
fn is_vertical(robot: &Robot, index: usize) -> bool {
    let tree = &robot.tree;
    let joint = &tree.joints()[index];
    if joint.parent.is_some() {
        return false;
    }
    let at_zero = tree.forward_kinematics(&vec![0.0; tree.len()]);
    let axis = at_zero[index].rotation * joint.axis;
    axis.cross(&tree.gravity()).norm() <= 1e-6 * tree.gravity().norm()
}
