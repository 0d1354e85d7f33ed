//! The models of a result, as they were when it was made.

use crate::chain::model::Model;
use crate::outcome::fit::FittedModel;
use crate::outcome::rollout::Before;
use crate::outcome::{Outcome, Part};
use crate::problem_file::ProblemFile;
use crate::problem_file::choices::Inertials;
use crate::problem_file::robot::RobotSource;
use crate::rollout::error::RolloutError;
use crate::setup::error::SetupError;
use crate::setup::laws;
use crate::setup::model_spec::{Addition, ModelSpec};
use crate::setup::robot::Robot;
use crate::simulate::truth;
use nalgebra::DVector;

/// A model with a value of every parameter.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The structure: bodies, drives and effects.
    pub model: Model,
    /// Values of all its parameters, in SI units.
    pub values: DVector<f64>,
}

impl Candidate {
    /// Whether another is the same model with the same values: what a model has is known by its parameters.
    pub fn is(&self, other: &Self) -> bool {
        let names = [self, other].map(|of| of.model.parameters().iter().map(|p| &p.name));
        let [own, others] = names;
        self.values == other.values && own.eq(others)
    }
}

/// The models of a result.
#[derive(Debug, Clone)]
pub struct Candidates {
    /// The model that the final one is compared with, and what it is; none of a result without one.
    pub before: Option<(Before, Candidate)>,
    /// As the result has it, with all findings.
    pub after: Candidate,
}

impl Candidates {
    /// Those of a result of `fit` or `diagnose`: after is the model that was found. Before is the one that the files
    /// declare, if they give all of its values; else, of a diagnosis, the declared model with its parameters fitted.
    ///
    /// # Errors
    /// Where the result holds no model, or not all of one.
    pub fn of(
        outcome: &Outcome,
        problem: &ProblemFile,
        robot: &Robot,
    ) -> Result<Self, RolloutError> {
        let (fitted, baseline) = match &outcome.part {
            Part::Fit(_) if problem.fit.is_of_motors() => {
                return Err(RolloutError::ConstantVelocity);
            }
            Part::Fit(fit) => (fit.model.as_ref(), None),
            Part::Diagnose(diagnosis) => {
                let fit = diagnosis.fit.as_ref();
                (
                    fit.and_then(|f| f.model.as_ref()),
                    diagnosis.baseline.model.as_ref(),
                )
            }
            part => return Err(RolloutError::NoRobot { verb: part.verb() }),
        };
        let Some(fitted) = fitted else {
            return Err(RolloutError::Incomplete {
                verb: outcome.part.verb(),
                problem: problem.path.display().to_string(),
            });
        };
        let declared = declared(problem, robot, baseline.is_some());
        let before = match (declared, baseline) {
            (Some(declared), _) => Some((Before::DeclaredValues, declared)),
            (None, Some(baseline)) => {
                Some((Before::DeclaredFitted, rebuilt(baseline, problem, robot)?))
            }
            (None, None) => None,
        };
        let after = rebuilt(fitted, problem, robot)?;
        Ok(Self { before, after })
    }
}

/// The model that a result holds in full.
fn rebuilt(
    fitted: &FittedModel,
    problem: &ProblemFile,
    robot: &Robot,
) -> Result<Candidate, SetupError> {
    let index = |name: &String| robot.tree.joint_index(name);
    let catalogue = laws::catalogue(problem)?;
    let mut addition = Addition::default();
    for added in &fitted.added {
        for joint in added.joints.iter().filter_map(index) {
            if let Some(effect) = catalogue.find(&added.effect) {
                addition.add(effect, joint, added.other.as_ref().and_then(index));
            }
        }
    }
    // Every joint has its value: a diagnosis may have found other ones on joints that the problem takes for alike.
    let model = ModelSpec::without_prior(problem, robot)?
        .separated()
        .build_with(&addition)?
        .model;
    let mut values = model.values();
    for value in &fitted.values {
        if let Some(position) = model.position(&value.name) {
            values[position] = value.value;
        }
    }
    Ok(Candidate { model, values })
}

/// The model at the values of its files, where these give all of them. Where there is another model to compare with, bodies
/// count as declared only where nothing about them was estimated, or where they are those of a simulator.
fn declared(problem: &ProblemFile, robot: &Robot, has_baseline: bool) -> Option<Candidate> {
    let of_simulator = matches!(problem.robot.source, RobotSource::Mjcf(_));
    let known = problem.robot.inertials.value == Inertials::Known;
    let has_bodies = robot.tree.joints().iter().any(|j| j.inertia.mass() > 0.0);
    if !has_bodies || (has_baseline && !of_simulator && !known) {
        return None;
    }
    let mut problem = problem.clone();
    // The truth of a simulation is not what the model declares.
    problem.simulate.values.clear();
    let model = truth::build(&problem, robot).ok()?.recorded;
    Some(Candidate {
        values: model.values(),
        model,
    })
}
