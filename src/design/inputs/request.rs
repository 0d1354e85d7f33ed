//! What a motion is designed for: models with their values, settings, and limits of the joints.

use crate::chain::effect::EFFECTS;
use crate::fault::Place;
use crate::problem_file::choices::{Criterion, DesignKind};
use crate::problem_file::design::Rival;
use crate::problem_file::{DesignTable, Located, Named, ProblemFile, RecordingsTable};
use crate::setup::coupling_entry;
use crate::setup::error::SetupError;
use crate::setup::limits::{self, JointLimits};
use crate::setup::model_spec::ModelSpec;
use crate::setup::robot::Robot;

/// Rate of the trajectories' files where none is stated, Hz.
const DEFAULT_RATE: f64 = 200.0;

/// What a motion is designed for.
#[derive(Debug, Clone)]
pub struct DesignRequest<'a> {
    /// The robot that moves.
    pub robot: &'a Robot,
    /// The model whose parameters the motion is to determine.
    pub model: ValuedModel,
    /// Models that it is to tell apart, where that is its criterion.
    pub rivals: Vec<RivalModel>,
    /// Criterion, series, constraints and search.
    pub settings: &'a DesignTable,
    /// The recordings that will be made.
    pub recordings: Option<&'a RecordingsTable>,
    /// Of every joint, in the order of the tree.
    pub limits: Vec<JointLimits>,
    /// Of the trajectories' files, Hz.
    pub rate: f64,
    /// Where what no design can meet is to be mended.
    pub place: Place,
}

/// A model and the values that it predicts torques with.
#[derive(Debug, Clone)]
pub struct ValuedModel {
    /// What the model is made of.
    pub declared: ModelSpec,
    /// Values of single parameters, in the place of those of the robot file or of an earlier fit.
    pub values: Vec<Named<f64>>,
    /// An earlier fit gives the values of all parameters.
    pub is_fitted: bool,
}

/// One of the models that a motion is to tell apart.
#[derive(Debug, Clone)]
pub struct RivalModel {
    /// In the result.
    pub name: String,
    /// The model.
    pub model: ValuedModel,
}

impl<'a> DesignRequest<'a> {
    /// What a problem file asks for. A single rival stands against the file's own model.
    ///
    /// # Errors
    /// Faults of the model, of a rival's effects, values or earlier fit, and of the limits.
    pub fn of(problem: &'a ProblemFile, robot: &'a Robot) -> Result<Self, SetupError> {
        let model = ValuedModel::of(problem, robot)?;
        let stated = match problem.design.criterion.value {
            Criterion::Discriminate => problem.design.rival.as_slice(),
            _ => &[],
        };
        let mut rivals = Vec::new();
        if stated.len() == 1 {
            rivals.push(RivalModel {
                name: problem.name.value.clone(),
                model: model.clone(),
            });
        }
        for rival in stated {
            rivals.push(RivalModel {
                name: rival.name.value.clone(),
                model: ValuedModel::of(&altered(problem, rival, &robot.order), robot)?,
            });
        }
        let recorded = problem.recordings.as_ref().and_then(|r| r.rate.as_ref());
        let rate = recorded.or(problem.simulate.rate.as_ref());
        Ok(Self {
            robot,
            model,
            rivals,
            settings: &problem.design,
            recordings: problem.recordings.as_ref(),
            limits: limits::of_joints(problem, robot)?,
            rate: rate.map_or(DEFAULT_RATE, |r| r.value),
            place: Place::file(&problem.path),
        })
    }
}

impl ValuedModel {
    fn of(problem: &ProblemFile, robot: &Robot) -> Result<Self, SetupError> {
        // What a plan of constant velocities is for is not known before.
        let declared = match problem.design.kind.value {
            DesignKind::ConstantVelocity => ModelSpec::of_unknown_constants(problem, robot)?,
            DesignKind::Fourier => ModelSpec::of(problem, robot)?,
        };
        Ok(Self {
            declared,
            values: problem.design.values.clone(),
            is_fitted: problem.robot.parameters.is_some(),
        })
    }
}

/// The problem file with what a rival replaces; `order` are the joints as the file has them.
fn altered(problem: &ProblemFile, rival: &Rival, order: &[String]) -> ProblemFile {
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
        couple(&mut own, order, entry);
    }
    own.design.values.extend(rival.values.iter().map(|v| Named {
        name: v.name.clone(),
        value: v.value.clone(),
    }));
    own
}

/// Declares the entry of V that a value names, if it names one.
fn couple(problem: &mut ProblemFile, order: &[String], entry: &Named<f64>) {
    let Some([row, column]) = coupling_entry::named(&entry.name, order) else {
        return;
    };
    let unit = |i: usize| (0..order.len()).map(move |j| f64::from(u8::from(i == j)));
    let coupling = problem.drive.coupling.get_or_insert_with(|| Located {
        value: (0..order.len()).map(|i| unit(i).collect()).collect(),
        place: entry.value.place.clone(),
    });
    let slot = coupling
        .value
        .get_mut(row)
        .and_then(|row| row.get_mut(column));
    if let Some(slot) = slot {
        *slot = entry.value.value;
    }
}
