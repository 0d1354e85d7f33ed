//! The inputs of a design: model, parameter values, base parameters, noise, limits, and the parameters of interest.

use nalgebra::{DMatrix, DVector};

use crate::chain::base_parameters::BaseParameters;
use crate::chain::effect::Dependence;
use crate::chain::model::{Model, Signal};
use crate::chain::parameter::Role;
use crate::chain::prior::Prior;
use crate::design::constraints::collision_shapes;
use crate::design::constraints::workspace::{Place as Point, Rule};
use crate::design::criterion::{self, Criterion};
use crate::design::error::{DesignError, Unsuitable};
use crate::design::inputs::request::{DesignRequest, ValuedModel};
use crate::fault::Place;
use crate::problem_file::choices::{Choice, DesignKind};
use crate::problem_file::design::{DesignParameters, Harmonics};
use crate::problem_file::{DesignTable, Located, PerJoint, RecordingsTable};
use crate::robot::inertia::PER_LINK;
use crate::setup;
use crate::setup::error::{Mismatch, SetupError};
use crate::setup::limits::JointLimits;
use crate::setup::model_spec::ModelWithPrior;
use crate::setup::names::{self, Reference};
use crate::setup::robot::Robot;
use crate::stats::range::within;
use nalgebra::{Point3, Vector3};

/// Designs move joints one by one: those that others follow have to stand still.
fn refuse_leaders(request: &DesignRequest<'_>) -> Result<(), SetupError> {
    let robot = request.robot;
    let Some(dependent) = robot.dependents.first() else {
        return Ok(());
    };
    let name = |k: usize| &robot.tree.joints()[k].name;
    let (joint, leader) = (name(dependent.joint), name(dependent.leader));
    Err(SetupError::mismatch(
        &request.place.clone().key("robot"),
        Mismatch::NotYet {
            what: format!("a design that moves `{leader}`, which `{joint}` follows,"),
            instead: format!("lock it for the motion: robot.locked = {{ {leader} = 0.0 }}"),
        },
    ))
}

/// Everything that does not depend on the motion.
#[derive(Debug)]
pub struct Prepared {
    /// The robot as the problem has it.
    pub robot: Robot,
    /// The model that the motion is for.
    pub model: Model,
    /// What is known before the data.
    pub prior: Prior,
    /// Parameter values that torques are predicted with.
    pub values: DVector<f64>,
    /// The combinations of parameters that its signal depends on.
    pub base: BaseParameters,
    /// Runs without and with the load.
    pub loads: Vec<bool>,
    /// Standard deviation of each channel's signal.
    pub noise: Vec<f64>,
    /// Of each joint, in the order of the tree.
    pub limits: Vec<JointLimits>,
    /// Anything a reader should know, one sentence each.
    pub notes: Vec<String>,
}

impl Prepared {
    /// Values, base parameters and limits of a model that a motion is designed for.
    ///
    /// # Errors
    /// Faults of the model; a signal that designs do not cover.
    pub fn of(request: &DesignRequest<'_>, valued: &ValuedModel) -> Result<Self, DesignError> {
        let robot = request.robot;
        refuse_leaders(request)?;
        let kind = &request.settings.kind;
        if robot.mechanism.is_some() && kind.value == DesignKind::ConstantVelocity {
            let what = "a plan of constant velocities for a mechanism with closed loops";
            let fault = Mismatch::NotYet {
                what: what.to_string(),
                instead: "set design.kind = \"fourier\"".to_string(),
            };
            return Err(SetupError::mismatch(&kind.place, fault).into());
        }
        let ModelWithPrior { model, prior } = valued.declared.build()?;
        if matches!(model.signal(), Signal::BaseWrench | Signal::Both) {
            let place = request.recordings.map(|r| r.signal.place.clone());
            return Err(SetupError::mismatch(
                &place.unwrap_or_default(),
                Mismatch::NotYet {
                    what: "a design for base wrenches".to_string(),
                    instead: "design for torques or currents of the same robot".to_string(),
                },
            )
            .into());
        }
        let loads = loads(request.recordings, &model);
        let base = BaseParameters::structural(&model, &loads, prior.rows());
        let mut notes = Vec::new();
        let values = values(valued, &model, robot, &mut notes)?;
        let noise = noise(&request.settings.noise, robot, &mut notes)?;
        Ok(Self {
            limits: without_torques(request.limits.clone(), &model, &values, &mut notes),
            robot: robot.clone(),
            model,
            prior,
            values,
            base,
            loads,
            noise,
            notes,
        })
    }

    /// # Errors
    /// A model in which everything is known.
    pub fn check_unknowns(&self, place: &Place) -> Result<(), DesignError> {
        if !self.base.base.is_empty() {
            return Ok(());
        }
        let place = place.clone().key("robot.inertials");
        let kind = Unsuitable::NothingToEstimate;
        Err(DesignError::unsuitable(&place, kind))
    }

    /// Names of all joints.
    pub fn names(&self) -> Vec<String> {
        self.model.joints().iter().map(|j| j.name.clone()).collect()
    }

    /// Harmonics of every joint.
    ///
    /// # Errors
    /// A list of the wrong length.
    pub fn harmonics(&self, settings: &DesignTable) -> Result<Vec<usize>, DesignError> {
        let stated = &settings.harmonics;
        let counts = match &stated.value {
            Harmonics::All(count) => PerJoint::All(*count as f64),
            Harmonics::Each(counts) => PerJoint::Each(counts.iter().map(|c| *c as f64).collect()),
        };
        let place = stated.place.clone();
        let counts = Some(Located {
            value: counts,
            place,
        });
        let each = self.robot.per_joint(&counts)?.unwrap_or_default();
        Ok(each.into_iter().map(|count| count as usize).collect())
    }

    /// Where joints stand before and after a motion: as stated, the others in the middle of their ranges.
    ///
    /// # Errors
    /// A list of the wrong length.
    pub fn rest(&self, settings: &DesignTable) -> Result<Vec<f64>, DesignError> {
        let stated = self.robot.per_joint(&settings.rest_position)?;
        let of = |j: usize| match (self.robot.locked[j], &stated) {
            (Some(position), _) => position,
            (None, Some(stated)) => within(stated[j], [self.limits[j].lower, self.limits[j].upper]),
            (None, None) => self.limits[j].middle(),
        };
        Ok((0..self.limits.len()).map(of).collect())
    }

    /// Positions of the columns asked for among the kept parameters; `None` is all of them.
    ///
    /// # Errors
    /// A name that no parameter has, or that the motion cannot determine; a group without members.
    pub fn wanted(&self, settings: &DesignTable) -> Result<Option<Vec<usize>>, DesignError> {
        let asked = &settings.parameters;
        let kept = self.base.kept();
        let role = |k: &usize| self.model.parameters()[kept[*k]].role;
        let of = |test: &dyn Fn(Role) -> bool| -> Vec<usize> {
            (0..kept.len()).filter(|k| test(role(k))).collect()
        };
        let found = match &asked.value {
            DesignParameters::All => return Ok(None),
            DesignParameters::Inertial => of(&|r| matches!(r, Role::Inertial { .. })),
            DesignParameters::Payload => of(&|r| matches!(r, Role::Payload { .. })),
            DesignParameters::Friction => of(&|r| self.is_friction(r)),
            DesignParameters::Listed(listed) => {
                let mut found: Vec<usize> = Vec::new();
                for name in listed {
                    for k in self.columns_of(&name.value, &name.place, &kept)? {
                        if !found.contains(&k) {
                            found.push(k);
                        }
                    }
                }
                found.sort_unstable();
                found
            }
        };
        if found.is_empty() {
            return Err(DesignError::unsuitable(
                &asked.place,
                Unsuitable::EmptyGroup,
            ));
        }
        Ok((found.len() < kept.len()).then_some(found))
    }

    /// Laws that depend on speed or its direction.
    fn is_friction(&self, role: Role) -> bool {
        let Role::Effect { joint, effect, .. } = role else {
            return false;
        };
        let on = self.model.joints()[joint].effects[effect].0.depends_on;
        on.iter()
            .any(|d| matches!(d, Dependence::Speed | Dependence::Direction))
    }

    /// Kept columns that a name stands for: one, or the first ones of a body's quantity.
    fn columns_of(
        &self,
        name: &str,
        place: &Place,
        kept: &[usize],
    ) -> Result<Vec<usize>, DesignError> {
        let reference = names::resolve(&self.model, name).ok_or_else(|| {
            let nearest = names::nearest(&self.model, name);
            let found = name.to_string();
            SetupError::mismatch(place, Mismatch::UnknownParameter { found, nearest })
        })?;
        let raw: Vec<usize> = match reference {
            Reference::Parameter(p) => vec![p],
            // A centre of mass or inertia about it depends on the lower moments as well.
            Reference::Body(first, quantity) => (first..first + raw_count(quantity)).collect(),
        };
        let found: Vec<usize> = raw
            .iter()
            .filter_map(|p| kept.iter().position(|k| k == p))
            .collect();
        if found.is_empty() {
            let kind = Unsuitable::NotDetermined {
                found: name.to_string(),
            };
            return Err(DesignError::unsuitable(place, kind));
        }
        Ok(found)
    }

    /// Information that is there beforehand, over the kept columns.
    pub fn prior_information(&self) -> DMatrix<f64> {
        let rows = self.prior.rows().select_columns(&self.base.kept());
        rows.tr_mul(&rows)
    }

    /// The limits in space.
    ///
    /// # Errors
    /// A link or frame that the robot does not have.
    pub fn rules(&self, settings: &DesignTable) -> Result<Vec<Rule>, DesignError> {
        let table = &settings.workspace;
        let mut rules = Vec::new();
        for halfspace in &table.halfspace {
            let normal = Vector3::from(halfspace.normal.value);
            let length = normal.norm();
            rules.push(Rule::Halfspace {
                label: "half-space".to_string(),
                place: self.point(&halfspace.frame.value, &halfspace.frame.place)?,
                normal: normal / length,
                offset: halfspace.offset.value / length,
            });
        }
        for region in &table.boxes {
            let place = self.point(&region.frame.value, &region.frame.place)?;
            rules.extend(walls(&place, region.lower.value, region.upper.value));
        }
        for speed in &table.speed {
            rules.push(Rule::Speed {
                place: self.point(&speed.frame.value, &speed.frame.place)?,
                limit: speed.limit.value,
            });
        }
        for clearance in &table.clearance {
            let names = clearance.links.value.clone();
            let shape = |name: &String| {
                collision_shapes::of_link(&self.robot, name, &clearance.links.place, &table.shape)
            };
            rules.push(Rule::Clearance {
                shapes: [shape(&names[0])?, shape(&names[1])?],
                names,
                distance: clearance.distance.value,
            });
        }
        Ok(rules)
    }

    fn point(&self, name: &str, place: &Place) -> Result<Point, DesignError> {
        let Some((link, frame)) = self.model.tree().frame(name) else {
            let kind = Mismatch::UnknownFrame {
                found: name.to_string(),
                known: self.robot.frame_names(),
            };
            return Err(SetupError::mismatch(place, kind).into());
        };
        Ok(Point {
            name: name.to_string(),
            link,
            point: Point3::from(frame.translation.vector),
        })
    }
}

/// The finite walls of a box as half-spaces.
fn walls(place: &Point, lower: [f64; 3], upper: [f64; 3]) -> Vec<Rule> {
    let mut rules = Vec::new();
    for axis in 0..3 {
        let name = ["x", "y", "z"][axis];
        for (side, sign, bound) in [("lower", 1.0, lower[axis]), ("upper", -1.0, upper[axis])] {
            if bound.is_finite() {
                let mut normal = Vector3::zeros();
                normal[axis] = sign;
                rules.push(Rule::Halfspace {
                    label: format!("{side} {name} wall of the box"),
                    place: place.clone(),
                    normal,
                    offset: sign * bound,
                });
            }
        }
    }
    rules
}

/// Raw parameters, from the first on, that a quantity depends on.
fn raw_count(quantity: names::BodyQuantity) -> usize {
    match quantity {
        names::BodyQuantity::Mass => 1,
        names::BodyQuantity::Centre(_) => 4,
        names::BodyQuantity::Inertia(..) => PER_LINK,
    }
}

/// Runs without and with the load, as the recordings will be made.
fn loads(recordings: Option<&RecordingsTable>, model: &Model) -> Vec<bool> {
    let without_too = recordings.is_some_and(|r| !r.loaded.is_empty());
    match (model.payload(), without_too) {
        (None, _) => vec![false],
        (Some(_), true) => vec![false, true],
        (Some(_), false) => vec![true],
    }
}

/// The model's values; links that are to be estimated act with those of the robot file meanwhile.
fn values(
    valued: &ValuedModel,
    model: &Model,
    robot: &Robot,
    notes: &mut Vec<String>,
) -> Result<DVector<f64>, DesignError> {
    let mut values = model.values();
    let of_file = robot.tree.parameters();
    if !valued.is_fitted {
        for (value, stated) in values.iter_mut().zip(&of_file) {
            *value = *stated;
        }
    }
    setup::values::replace(model, &mut values, &valued.values)?;
    if let Some((_, first)) = model.payload()
        && values[first] == 0.0
    {
        notes.push(
            "The load has no value, so torque limits are checked without it; give payload.mass and \
             its centre under [design.values]."
                .to_string(),
        );
    }
    Ok(values)
}

/// Torque limits mean nothing where the bodies are massless.
fn without_torques(
    mut limits: Vec<JointLimits>,
    model: &Model,
    values: &DVector<f64>,
    notes: &mut Vec<String>,
) -> Vec<JointLimits> {
    let links = PER_LINK * model.tree().len();
    if values.rows(0, links).amax() == 0.0 {
        if limits.iter().any(|l| l.torque.is_some()) {
            notes.push(
                "The robot file states no masses, so torques were not limited; give inertials, or an \
                 earlier fit under robot.parameters."
                    .to_string(),
            );
        }
        limits.iter_mut().for_each(|l| l.torque = None);
    }
    limits
}

fn noise(
    stated: &Option<Located<PerJoint>>,
    robot: &Robot,
    notes: &mut Vec<String>,
) -> Result<Vec<f64>, DesignError> {
    if let Some(noise) = robot.per_joint(stated)? {
        return Ok(noise);
    }
    notes.push(
        "design.noise is not given: standard deviations are for a noise of one unit in every signal."
            .to_string(),
    );
    Ok(vec![1.0; robot.tree.len()])
}

/// The criterion of the information that is asked for; rivals are judged by themselves, and the
/// information beside them by its determinant.
pub fn criterion(settings: &DesignTable) -> &'static dyn Criterion {
    let asked = settings.criterion.value.word();
    let found = criterion::CRITERIA.iter().find(|c| c.id() == asked);
    found.copied().unwrap_or(&criterion::d_optimal::DOptimal)
}
