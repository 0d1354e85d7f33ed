//! What a problem file says of a robot that is simulated.

use crate::fault::Place;
use crate::problem_file::{Located, Named, ProblemFile};
use crate::robot::inertia::{Inertia, QUANTITIES};
use crate::robot::tree::Tree;
use crate::setup::earlier_fit::EarlierFit;
use crate::setup::error::SetupError;
use crate::setup::model_spec::ModelSpec;
use crate::setup::robot::Robot;
use crate::setup::sharing::Alike;

/// What is true of a robot that is simulated, without the form of a file.
#[derive(Debug, Clone)]
pub struct TruthSpec {
    /// What its controller commands: torques of the joints.
    pub commanded: ModelSpec,
    /// What is recorded of it.
    pub recorded: ModelSpec,
    /// Joints with motors of one type: what one of them has, the others have too where nothing else is given.
    pub alike: Vec<Alike>,
    /// Values that an earlier fit has found.
    pub earlier: EarlierValues,
    /// Parameters of the declared model that are known; of two values of one the later counts.
    pub known: Vec<Named<f64>>,
    /// Parameters of any effect: those of effects that the declared model has not got are concealed from it.
    pub given: Vec<Named<f64>>,
    /// Where what is missing is to be given.
    pub place: Place,
}

impl TruthSpec {
    /// What a problem file says.
    ///
    /// # Errors
    /// As [`ModelSpec::of`]; an earlier result that cannot be read, or is none of a fit.
    pub fn of(problem: &ProblemFile, robot: &Robot) -> Result<Self, SetupError> {
        let earlier = match &problem.robot.parameters {
            Some(path) => EarlierValues::of(&EarlierFit::read(path)?),
            None => EarlierValues::default(),
        };
        let robot = Robot {
            tree: earlier.with_links(&robot.tree),
            ..robot.clone()
        };
        let zeros = problem.robot.zero.iter().map(|name| Named {
            name: name.value.clone(),
            value: Located {
                value: 0.0,
                place: name.place.clone(),
            },
        });
        Ok(Self {
            commanded: ModelSpec::of_command(problem, &robot)?,
            recorded: ModelSpec::of_simulation(problem, &robot)?,
            alike: Alike::of(problem, &robot)?,
            known: zeros.chain(problem.drive.values.iter().cloned()).collect(),
            given: problem.simulate.values.clone(),
            place: Place::file(&problem.path),
            earlier,
        })
    }
}

/// Values of an earlier fit.
#[derive(Debug, Clone, Default)]
pub struct EarlierValues {
    /// Raw parameters of bodies, a member of the class that exists.
    bodies: Vec<(String, f64)>,
    /// Parameters of effects.
    effects: Vec<(String, f64)>,
}

impl EarlierValues {
    fn of(earlier: &EarlierFit) -> Self {
        let realized = earlier.fit.realization.iter();
        let estimated = earlier.estimate.parameters.iter();
        let estimated = estimated
            .filter_map(|p| Some((p.names(), p.value?)))
            .flat_map(|(names, value)| names.into_iter().map(move |name| (name, value)));
        Self {
            bodies: realized.map(|r| (r.name.clone(), r.value)).collect(),
            effects: estimated.collect(),
        }
    }

    /// The robot with the links of the earlier fit.
    fn with_links(&self, tree: &Tree) -> Tree {
        let mut inertias: Vec<Inertia> = tree.joints().iter().map(|j| j.inertia).collect();
        for (joint, inertia) in tree.joints().iter().zip(&mut inertias) {
            for (k, quantity) in QUANTITIES.iter().enumerate() {
                let name = format!("{}.{quantity}", joint.link);
                if let Some((_, value)) = self.bodies.iter().find(|(n, _)| *n == name) {
                    inertia.0[k] = *value;
                }
            }
        }
        tree.clone().with_inertias(&inertias)
    }

    /// Every value by the name of its parameter.
    pub fn all(&self) -> impl Iterator<Item = (&str, f64)> {
        let all = self.bodies.iter().chain(&self.effects);
        all.map(|(name, value)| (name.as_str(), *value))
    }
}
