//! `[fit]`: the estimator, what is known before the data, and fits to compare with.

use crate::problem_file::choices::{Estimator, FeasibleBy, LoadFrom, Motion, PriorKind};
use crate::problem_file::context::Context;
use crate::problem_file::document::{Node, NodeValue, Table};
use crate::problem_file::error::{KeyFault, NumberFault, ProblemFileError, ValueFault};
use crate::problem_file::key::{Form, Key, Length, REQUIRED, Range, words};
use crate::problem_file::located::{Located, Named};
use crate::problem_file::reader::Reader;
use crate::problem_file::values;

/// Keys of `[fit]`.
#[rustfmt::skip]
pub(crate) const KEYS: &[Key] = &[
    Key { name: "estimator", form: Form::Words(words::<Estimator>), unit: "", default: "\"maximum_likelihood\"", example: "\"wls\"", meaning: "How parameters follow from recordings: ordinary, weighted or robust least squares, maximum likelihood, these over bodies that can exist, or motor constants from constant speed" },
    Key { name: "feasible_by", form: Form::Words(words::<FeasibleBy>), unit: "", default: "\"cones\"", example: "\"log_cholesky\"", meaning: "How a feasible estimate keeps bodies possible" },
    Key { name: "load", form: Form::Words(words::<LoadFrom>), unit: "", default: "\"together\"", example: "\"difference\"", meaning: "How the load follows from recordings with it and without it: one estimate of all, or the difference of two fits of the link that carries it" },
    Key { name: "motion", form: Form::Words(words::<Motion>), unit: "", default: "\"exact\"", example: "\"noisy\"", meaning: "Whether joint angles are noisy, so that the motion is estimated beside the parameters; for maximum_likelihood" },
    Key { name: "prior", form: Form::Table(PRIOR_KEYS), unit: "", default: "none", example: "", meaning: "What is known before the data" },
    Key { name: "bounds", form: Form::Named(INTERVAL), unit: "each parameter's own", default: "none", example: "{ \"link3.mass\" = [0.5, 6.0], total_mass = [900, inf] }", meaning: "Lower and upper bound of parameters by name, and of total_mass, the sum of all masses in kg" },
    Key { name: "compare", form: Form::List(&Form::Table(COMPARE_KEYS), Length::Any), unit: "", default: "none", example: "", meaning: "The same fit with other effects, side by side in the result" },
    Key { name: "constant_velocity", form: Form::Table(CONSTANT_VELOCITY_KEYS), unit: "", default: "the keys' own defaults", example: "", meaning: "For the estimator constant_velocity" },
];

const INTERVAL: &Form = &Form::List(&Form::Number(Range::Any), Length::Exactly(2));

/// Keys of `[fit.prior]`.
#[rustfmt::skip]
pub(crate) const PRIOR_KEYS: &[Key] = &[
    Key { name: "kind", form: Form::Words(words::<PriorKind>), unit: "", default: "no prior on the inertials", example: "\"entropic\"", meaning: "Distance from the robot file's bodies that a feasible estimate penalises, or the absolute values of all linear parameters (\"lasso\")" },
    Key { name: "strength", form: Form::Either(&[Form::Words(strengths), Form::Number(Range::Positive)]), unit: "", default: "\"held_out\"", example: "0.5", meaning: "How far the prior is trusted: by held-out error, by the noise, or a factor of the distance" },
    Key { name: "values", form: Form::Named(&Form::Table(PRIOR_VALUE_KEYS)), unit: "", default: "none", example: "", meaning: "Single parameters by name, for any estimator" },
];

/// Keys of an entry of `[fit.prior.values]`.
#[rustfmt::skip]
pub(crate) const PRIOR_VALUE_KEYS: &[Key] = &[
    Key { name: "value", form: Form::Number(Range::Finite), unit: "the parameter's own", default: REQUIRED, example: "120.0", meaning: "Value expected" },
    Key { name: "std_dev", form: Form::Number(Range::Positive), unit: "the parameter's own", default: REQUIRED, example: "5.0", meaning: "How far to trust it: its standard deviation" },
];

/// Keys of `[fit.constant_velocity]`.
#[rustfmt::skip]
pub(crate) const CONSTANT_VELOCITY_KEYS: &[Key] = &[
    Key { name: "least_speed", form: Form::Number(Range::Positive), unit: "rad/s (m/s)", default: "0.02", example: "0.05", meaning: "A slower joint stands" },
    Key { name: "torque_constant", form: Form::Named(&Form::Number(Range::Positive)), unit: "N·m/A", default: "none", example: "{ joint1 = 13.0 }", meaning: "Torque constants at the joint side that are known" },
    Key { name: "same_type", form: Form::List(&Form::List(&Form::Text, Length::Any), Length::Any), unit: "", default: "none", example: "[[\"joint1\", \"joint2\"]]", meaning: "Lists of joints with motors of one type" },
];

/// Keys of `[[fit.compare]]`.
#[rustfmt::skip]
pub(crate) const COMPARE_KEYS: &[Key] = &[
    Key { name: "name", form: Form::Text, unit: "", default: REQUIRED, example: "\"Stribeck\"", meaning: "Name of the comparison" },
    Key { name: "effects", form: Form::List(&Form::Effect, Length::Distinct), unit: "", default: REQUIRED, example: "[\"coulomb_friction\", \"viscous_friction\"]", meaning: "What replaces drive.effects" },
];

/// Name of the bound on the sum of all masses in `[fit.bounds]`.
const TOTAL_MASS: &str = "total_mass";

/// The table `[fit]`.
#[derive(Debug, Clone)]
pub struct FitTable {
    /// Default: [`Estimator::MaximumLikelihood`].
    pub estimator: Located<Estimator>,
    /// How bodies are kept possible, for the feasible estimators. Default: [`FeasibleBy::Cones`].
    pub feasible_by: Located<FeasibleBy>,
    /// How the load follows from recordings with it and without it. Default: [`LoadFrom::Together`].
    pub load: Located<LoadFrom>,
    /// Whether joint angles are noisy, for `maximum_likelihood`. Default: [`Motion::Exact`].
    pub motion: Located<Motion>,
    /// Priors of bodies and of single parameters.
    pub prior: PriorTable,
    /// By parameter name, in the parameter's unit. Default: none.
    pub bounds: Vec<Named<Interval>>,
    /// Bounds on the sum of all masses, kg. Default: none.
    pub total_mass: Option<Located<Interval>>,
    /// The same fit with other effects. Default: none.
    pub compare: Vec<Comparison>,
    /// For the estimator `constant_velocity`.
    pub constant_velocity: ConstantVelocityTable,
}

/// The table `[fit.constant_velocity]`, for the estimator `constant_velocity`.
#[derive(Debug, Clone)]
pub struct ConstantVelocityTable {
    /// A slower joint stands, rad/s (m/s), positive. Default: 0.02.
    pub least_speed: Located<f64>,
    /// Torque constants that are known, by joint, N·m/A at the joint side, positive. Default: none.
    pub torque_constant: Vec<Named<f64>>,
    /// Lists of joints with motors of one type. Default: none.
    pub same_type: Vec<Vec<Located<String>>>,
}

/// Slowest motion by default, rad/s: above the noise of a resting encoder, below any useful speed.
const LEAST_SPEED: f64 = 0.02;

/// The table `[fit.prior]`.
#[derive(Debug, Clone)]
pub struct PriorTable {
    /// Default: none, no prior on the inertials of the links.
    pub kind: Option<Located<PriorKind>>,
    /// Default: [`RegularisationWeight::HeldOut`].
    pub strength: Located<RegularisationWeight>,
    /// Single parameters. Default: none.
    pub values: Vec<Named<PriorValue>>,
}

/// How far a prior on the inertials is trusted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RegularisationWeight {
    /// The strength with the least held-out error.
    HeldOut,
    /// The strength at which the residual is as large as the noise.
    Noise,
    /// This factor of the prior's distance, positive.
    Number(f64),
}

/// What is known of a parameter before the data, in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PriorValue {
    /// The value expected.
    pub value: f64,
    /// Standard deviation, positive.
    pub std_dev: f64,
}

/// lower <= x <= upper; a side may be infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Minus infinity where there is no limit.
    pub lower: f64,
    /// Infinity where there is no limit.
    pub upper: f64,
}

/// One table `[[fit.compare]]`.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// Name in the result.
    pub name: Located<String>,
    /// What replaces `drive.effects`.
    pub effects: Located<Vec<Located<String>>>,
}

impl FitTable {
    /// Whether motors are fitted one by one at constant speed, without a model of the robot.
    pub fn is_of_motors(&self) -> bool {
        self.estimator.value == Estimator::ConstantVelocity
    }

    pub(super) fn from_node(node: &Node, context: &Context) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, KEYS)?;
        let mut bounds = reader.named("bounds", interval)?;
        let total_mass = bounds
            .iter()
            .position(|bound| bound.name == TOTAL_MASS)
            .map(|index| bounds.remove(index).value);
        let compare = reader.tables("compare")?;
        let compare: Vec<Comparison> = compare
            .iter()
            .map(|table| Comparison::from_node(table, context))
            .collect::<Result<_, _>>()?;
        values::check_no_duplicates(compare.iter().map(|comparison| &comparison.name))?;
        let estimator = reader.or("estimator", Estimator::MaximumLikelihood, values::choice)?;
        let motion = reader.or("motion", Motion::Exact, values::choice)?;
        if motion.value == Motion::Noisy && estimator.value != Estimator::MaximumLikelihood {
            return Err(ProblemFileError::new(
                &motion.place,
                KeyFault::Conflict {
                    found: "a noisy motion, which only maximum_likelihood estimates".into(),
                    remedy: "set estimator = \"maximum_likelihood\", or leave motion out".into(),
                },
            ));
        }
        let feasible_by = reader.or("feasible_by", FeasibleBy::Cones, values::choice)?;
        let prior = PriorTable::from_node(&reader.table("prior"))?;
        check_feasible(&estimator, &feasible_by, &prior)?;
        Ok(Self {
            estimator,
            feasible_by,
            load: reader.or("load", LoadFrom::Together, values::choice)?,
            motion,
            prior,
            bounds,
            total_mass,
            compare,
            constant_velocity: ConstantVelocityTable::from_node(
                &reader.table("constant_velocity"),
            )?,
        })
    }
}

/// What only the feasible estimators do is refused with the others, and a chart does not go with a kind of prior.
fn check_feasible(
    estimator: &Located<Estimator>,
    by: &Located<FeasibleBy>,
    prior: &PriorTable,
) -> Result<(), ProblemFileError> {
    let feasible = matches!(
        estimator.value,
        Estimator::Feasible | Estimator::FeasibleMaximumLikelihood
    );
    let refuse = |place, found: &str, remedy: &str| {
        let (found, remedy) = (found.into(), remedy.into());
        Err(ProblemFileError::new(
            place,
            KeyFault::Conflict { found, remedy },
        ))
    };
    match (&prior.kind, by.value) {
        (Some(kind), _) if !feasible => refuse(
            &kind.place,
            "a kind of prior, which only the feasible estimators take",
            "set estimator = \"feasible\" or \"feasible_maximum_likelihood\", or leave the kind out",
        ),
        (_, FeasibleBy::LogCholesky) if !feasible => refuse(
            &by.place,
            "feasible_by with an estimator that does not keep bodies possible",
            "set estimator = \"feasible\" or \"feasible_maximum_likelihood\", or leave feasible_by out",
        ),
        (Some(kind), FeasibleBy::LogCholesky) => refuse(
            &kind.place,
            "a kind of prior with feasible_by = \"log_cholesky\"",
            "leave feasible_by out: the cones take priors",
        ),
        _ => Ok(()),
    }
}

impl ConstantVelocityTable {
    fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, CONSTANT_VELOCITY_KEYS)?;
        let groups = reader.list("same_type", |node| {
            let groups = values::items(node, "a list of lists of joints")?;
            groups.iter().map(joint_names).collect()
        })?;
        Ok(Self {
            least_speed: reader.or("least_speed", LEAST_SPEED, values::positive)?,
            torque_constant: reader.named("torque_constant", values::positive)?,
            same_type: groups,
        })
    }
}

fn joint_names(node: &Node) -> Result<Vec<Located<String>>, ProblemFileError> {
    let names = values::items(node, "a list of joints")?.iter();
    names
        .map(|node| {
            Ok(Located {
                value: values::text(node)?,
                place: node.place.clone(),
            })
        })
        .collect()
}

impl PriorTable {
    fn from_node(node: &Node) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, PRIOR_KEYS)?;
        let kind = reader.optional("kind", values::choice)?;
        if kind.is_none() && reader.node("strength").is_some() {
            return Err(reader.missing(
                "kind",
                "a strength belongs to a kind: add kind = \"entropic\", \"euclidean\", \"pullback\" or \"lasso\"",
            ));
        }
        Ok(Self {
            kind,
            strength: reader.or("strength", RegularisationWeight::HeldOut, strength)?,
            values: reader.named("values", prior_value)?,
        })
    }
}

impl Comparison {
    fn from_node(node: &Node, context: &Context) -> Result<Self, ProblemFileError> {
        let reader = Reader::open(node, COMPARE_KEYS)?;
        Ok(Self {
            name: reader.required("name", "name the comparison", values::text)?,
            effects: reader.required("effects", "list the effects of the comparison", |n| {
                values::effects(n, context)
            })?,
        })
    }
}

const STRENGTHS: &[(&str, RegularisationWeight)] = &[
    ("held_out", RegularisationWeight::HeldOut),
    ("noise", RegularisationWeight::Noise),
];

fn strengths() -> Vec<&'static str> {
    STRENGTHS.iter().map(|(word, _)| *word).collect()
}

fn strength(node: &Node) -> Result<RegularisationWeight, ProblemFileError> {
    match &node.value {
        NodeValue::Text(word) => STRENGTHS
            .iter()
            .find(|(known, _)| known == word)
            .map(|(_, strength)| *strength)
            .ok_or_else(|| {
                ProblemFileError::new(
                    &node.place,
                    ValueFault::UnknownWord {
                        noun: "strength of the prior",
                        code: "unknown-strength",
                        found: word.clone(),
                        known: strengths().into_iter().map(str::to_owned).collect(),
                    },
                )
            }),
        NodeValue::Integer(_) | NodeValue::Number(_) => {
            values::positive(node).map(RegularisationWeight::Number)
        }
        _ => Err(values::wrong_type(
            node,
            "\"held_out\", \"noise\" or a number",
        )),
    }
}

fn prior_value(node: &Node) -> Result<PriorValue, ProblemFileError> {
    // Without either key this is the table that TOML makes of a name with dots and no quotes.
    let described = |table: &Table| {
        PRIOR_VALUE_KEYS
            .iter()
            .any(|key| table.get(key.name).is_some())
    };
    if !matches!(&node.value, NodeValue::Table(table) if described(table)) {
        return Err(values::wrong_type(
            node,
            "a table such as { value = 120.0, std_dev = 5.0 }",
        ));
    }
    let reader = Reader::open(node, PRIOR_VALUE_KEYS)?;
    let value = reader.required("value", "state the value expected", values::finite)?;
    let std_dev = reader.required("std_dev", "state how far to trust it", values::positive)?;
    Ok(PriorValue {
        value: value.value,
        std_dev: std_dev.value,
    })
}

fn interval(node: &Node) -> Result<Interval, ProblemFileError> {
    let [lower, upper] = values::array(node, "two numbers, lower and upper", values::not_nan)?;
    if lower > upper {
        return Err(ProblemFileError::new(
            &node.place,
            NumberFault::LowerAboveUpper { lower, upper },
        ));
    }
    Ok(Interval { lower, upper })
}
