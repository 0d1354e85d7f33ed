//! Constraints on single parameters from a problem file: zero, known, bounded.

use crate::chain::model::Model;
use crate::fault::Place;
use crate::problem_file::choices::Estimator;
use crate::problem_file::fit::Interval;
use crate::problem_file::{Located, Named, ProblemFile};
use crate::robot::inertia::Inertia;
use crate::setup::error::{Mismatch, SetupError, at};
use crate::setup::names::{self, BodyQuantity, Reference};

/// What a problem file says of single parameters.
#[derive(Debug, Clone, Default)]
pub(super) struct Constraints {
    /// Zero by construction.
    zero: Vec<Located<String>>,
    /// Known.
    values: Vec<Named<f64>>,
    bounds: Vec<Named<Interval>>,
    total_mass: Option<Located<Interval>>,
    /// The estimator keeps constraints on bodies.
    keeps_bodies: bool,
}

impl Constraints {
    pub(super) fn of(problem: &ProblemFile) -> Self {
        Self {
            zero: problem.robot.zero.clone(),
            values: problem.drive.values.clone(),
            bounds: problem.fit.bounds.clone(),
            total_mass: problem.fit.total_mass.clone(),
            keeps_bodies: matches!(
                problem.fit.estimator.value,
                Estimator::Feasible | Estimator::FeasibleMaximumLikelihood
            ),
        }
    }

    /// Gives a model's parameters their values and bounds.
    pub(super) fn apply(&self, model: &mut Model) -> Result<(), SetupError> {
        zero_parameters(model, &self.zero)?;
        fix_all(model, &self.values)?;
        self.bound_all(model)
    }

    /// Narrows the bounds of parameters.
    fn bound_all(&self, model: &mut Model) -> Result<(), SetupError> {
        if let (Some(total), false) = (&self.total_mass, self.keeps_bodies) {
            return Err(not_kept("total_mass", &total.place));
        }
        for entry in &self.bounds {
            let place = &entry.value.place;
            let reference = resolve(model, &entry.name, place)?;
            // A limit of mass and first moment together.
            if self.keeps_bodies && matches!(reference, Reference::Body(_, BodyQuantity::Centre(_)))
            {
                continue;
            }
            if !self.keeps_bodies && matches!(reference, Reference::Body(..)) {
                return Err(not_kept(&entry.name, place));
            }
            narrow(model, entry)?;
        }
        Ok(())
    }
}

/// Parameters that are zero by construction. A product of inertia about the centre of mass is zero about
/// the origin too only where one of its axes has no first moment; elsewhere it says nothing linear.
fn zero_parameters(model: &mut Model, zero: &[Located<String>]) -> Result<(), SetupError> {
    let listed: Vec<(Reference, &Place)> = zero
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
fn fix_all(model: &mut Model, given: &[Named<f64>]) -> Result<(), SetupError> {
    let mut bodies: Vec<(usize, Vec<(BodyQuantity, f64)>)> = Vec::new();
    for entry in given {
        let (value, place) = (entry.value.value, &entry.value.place);
        match resolve(model, &entry.name, place)? {
            Reference::Parameter(p) => {
                one_value(model, p, value, place)?;
                model.fix(p, value).map_err(|e| at(place, e))?;
            }
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

/// Joints that share a parameter have one value of it.
fn one_value(model: &Model, parameter: usize, value: f64, place: &Place) -> Result<(), SetupError> {
    let all = model.sharing(model.estimated_as(parameter));
    let known = &model.parameters()[all[0]];
    if all.len() == 1 || known.is_free() || known.value == value {
        return Ok(());
    }
    let names: Vec<&str> = all
        .iter()
        .map(|p| model.parameters()[*p].name.as_str())
        .collect();
    Err(SetupError::mismatch(
        place,
        Mismatch::NotShared {
            what: format!(
                "{} are shared, and have two values: {} and {value}",
                names.join(", "),
                known.value
            ),
            instead: "give one value, or take the effect out of drive.shared".to_string(),
        },
    ))
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

/// The one parameter of the model that a name stands for: of an effect, or a mass. `request` and `instead`
/// say what is asked of it and what can be asked, where it is a centre of mass or an inertia: those are no
/// parameters, because torques are linear in first moments and in inertias about the link's origin.
pub(crate) fn single(
    model: &Model,
    name: &str,
    place: &Place,
    request: &str,
    instead: &str,
) -> Result<usize, SetupError> {
    match resolve(model, name, place)? {
        Reference::Parameter(parameter) => Ok(parameter),
        Reference::Body(first, BodyQuantity::Mass) => Ok(first),
        Reference::Body(..) => Err(SetupError::mismatch(
            place,
            Mismatch::NotYet {
                what: format!("{request} on `{name}`"),
                instead: instead.to_string(),
            },
        )),
    }
}

/// A bound on bodies, of which the estimator knows sums alone.
fn not_kept(name: &str, place: &Place) -> SetupError {
    SetupError::mismatch(
        place,
        Mismatch::NotYet {
            what: format!("a bound on `{name}` with this estimator, which determines base parameters"),
            instead: "`estimator = \"feasible\"` and `\"feasible_maximum_likelihood\"` keep bounds on bodies".to_string(),
        },
    )
}

/// Narrows the bounds of one parameter.
fn narrow(model: &mut Model, entry: &Named<Interval>) -> Result<(), SetupError> {
    let place = &entry.value.place;
    let instead = "bound masses and parameters of effects, and centres of mass with \
                   `estimator = \"feasible\"`";
    let parameter = single(model, &entry.name, place, "a bound", instead)?;
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
    Ok(())
}
