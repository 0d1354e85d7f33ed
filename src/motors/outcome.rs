//! The constants as parameters with intervals, and the stages speed by speed.

use crate::chain::effect;
use crate::chain::effect::knowledge::JointTerm;
use nalgebra::{DMatrix, DVector};

use crate::motors::compare::{Constant, equality};
use crate::motors::constants::{AtSpeed, SecondStage, Term, load_dependence};
use crate::motors::joint_fit::{JointFit, Source as Basis};
use crate::motors::simplex::nelder_mead;
use crate::outcome::estimate::{Covariance, Estimate, Solver};
use crate::outcome::fit::{BaseParameter, Fit};
use crate::outcome::motors::{MotorJoint, MotorLoad, MotorSpeed, Motors, SameType};
use crate::outcome::parameter::{Parameter, Source};
use crate::problem_file::Located;
use crate::stats::distribution::Distribution;

/// Two-sided 95 % of the normal distribution, in standard deviations.
fn half_width() -> f64 {
    Distribution::Normal.two_sided(0.95)
}

/// Parameters, base parameters and stages of all joints, of which some have motors of one type.
pub(super) fn build(alike: &[Vec<Located<String>>], joints: &[JointFit]) -> (Estimate, Fit) {
    let mut fit = Fit::default();
    let (mut parameters, mut blocks) = (Vec::new(), Vec::new());
    for joint in joints {
        let constants = Constants::of(joint);
        parameters.extend(constants.parameters(joint));
        fit.base_parameters.extend(base_parameters(joint));
        fit.rank += constants.rank;
        blocks.extend(constants.block);
    }
    fit.condition_number = f64::NAN;
    fit.motors = Some(Motors {
        joints: joints.iter().map(stages).collect(),
        same_type: same_type(alike, joints),
    });
    fit.notes = notes(joints);
    let evaluations = joints.iter().map(|j| j.stage.speeds.len() as u64).sum();
    let estimate = Estimate {
        parameters,
        joints: Vec::new(),
        covariance: covariance(blocks),
        solver: Some(Solver {
            name: "two-stage linear least squares at constant speed".into(),
            stop: "direct".into(),
            converged: true,
            iterations: 1,
            evaluations,
            cost: joints.iter().map(|j| j.stage.variance).sum(),
        }),
    };
    (estimate, fit)
}

/// Constants of one joint with the covariance of those that have one.
struct Constants {
    /// k_ct and the friction coefficients, in the order of their terms.
    values: DVector<f64>,
    deviations: DVector<f64>,
    rank: usize,
    block: Option<(Vec<String>, DMatrix<f64>)>,
}

fn constant_name(joint: &JointFit) -> String {
    format!("{}.torque_constant.k_ct", joint.name)
}

fn term_name(joint: &JointFit, term: Term) -> String {
    let term = match term {
        Term::Coulomb => JointTerm::DryFriction,
        Term::Viscous => JointTerm::ViscousFriction,
        Term::Offset => JointTerm::Offset,
    };
    format!("{}.{}", joint.name, effect::term_name(term))
}

fn term_unit(joint: &JointFit, term: Term) -> String {
    match term {
        Term::Viscous => format!("{}·s/{}", joint.torque_unit, joint.position_unit),
        Term::Coulomb | Term::Offset => joint.torque_unit.to_string(),
    }
}

impl Constants {
    fn of(joint: &JointFit) -> Self {
        let rank =
            joint.stage.inverse.iter().len() + joint.friction.as_ref().map_or(0, |f| f.terms.len());
        let empty = Self {
            values: DVector::zeros(0),
            deviations: DVector::zeros(0),
            rank,
            block: None,
        };
        let Some((k, sigma)) = joint.constant.constant() else {
            return empty;
        };
        let Some(SecondStage {
            terms,
            coefficients,
            covariance,
        }) = &joint.friction
        else {
            let values = DVector::from_element(1, k);
            let deviations = DVector::from_element(1, sigma);
            return Self {
                values,
                deviations,
                ..empty
            };
        };
        // k = 1/a and F = β/a.
        let n = terms.len() + 1;
        let mut jacobian = DMatrix::zeros(n, n);
        jacobian[(0, 0)] = -k * k;
        let mut values = DVector::from_element(n, k);
        for t in 1..n {
            values[t] = coefficients[t - 1] * k;
            jacobian[(t, 0)] = -coefficients[t - 1] * k * k;
            jacobian[(t, t)] = k;
        }
        let covariance = &jacobian * covariance * jacobian.transpose();
        let deviations = covariance.diagonal().map(f64::sqrt);
        let first = usize::from(!matches!(joint.constant, Basis::Data(_)));
        let mut names = vec![constant_name(joint)];
        names.extend(terms.iter().map(|&term| term_name(joint, term)));
        let size = n - first;
        let block = covariance.view((first, first), (size, size)).into_owned();
        Self {
            values,
            deviations,
            rank,
            block: Some((names.split_off(first), block)),
        }
    }

    fn parameters(&self, joint: &JointFit) -> Vec<Parameter> {
        let name = constant_name(joint);
        let unit = format!("{}/A", joint.torque_unit);
        let constant = match joint.constant {
            Basis::Data(_) => self.estimated(0, name, unit, Source::Data),
            Basis::Given(value) => Parameter::known(name, unit, value),
            Basis::SameType(_) | Basis::Undetermined => Parameter::undetermined(name, unit),
        };
        let meaning = match advice(joint) {
            Some(advice) => format!("torque per current at the joint side; {advice}"),
            None => "torque per current at the joint side".to_string(),
        };
        let mut parameters = vec![constant.described(meaning)];
        let terms = match &joint.friction {
            Some(friction) => friction.terms.clone(),
            None => vec![Term::Coulomb, Term::Viscous],
        };
        for (t, term) in terms.into_iter().enumerate() {
            let (name, unit) = (term_name(joint, term), term_unit(joint, term));
            let source = match joint.constant {
                Basis::SameType(_) => Source::Prior,
                _ => Source::Data,
            };
            parameters.push(match self.values.len() > t + 1 {
                true => self.estimated(t + 1, name, unit, source),
                false => Parameter::undetermined(name, unit),
            });
        }
        parameters
    }

    fn estimated(&self, at: usize, name: String, unit: String, source: Source) -> Parameter {
        let (value, deviation) = (self.values[at], self.deviations[at]);
        Parameter {
            value: Some(value),
            std_dev: Some(deviation),
            ci95: Some([
                value - half_width() * deviation,
                value + half_width() * deviation,
            ]),
            source,
            ..Parameter::undetermined(name, unit)
        }
    }
}

fn covariance(blocks: Vec<(Vec<String>, DMatrix<f64>)>) -> Covariance {
    let total = blocks.iter().map(|(names, _)| names.len()).sum();
    let mut matrix = vec![vec![0.0; total]; total];
    let mut parameters = Vec::with_capacity(total);
    for (names, block) in blocks {
        let first = parameters.len();
        for (r, row) in block.row_iter().enumerate() {
            for (c, value) in row.iter().enumerate() {
                matrix[first + r][first + c] = *value;
            }
        }
        parameters.extend(names);
    }
    Covariance { parameters, matrix }
}

/// What is determined where a constant by itself is not.
fn base_parameters(joint: &JointFit) -> Vec<BaseParameter> {
    let make = |expression, unit, value: f64, deviation: f64| BaseParameter {
        expression,
        unit,
        value: Some(value),
        std_dev: Some(deviation),
        ci95: Some([
            value - half_width() * deviation,
            value + half_width() * deviation,
        ]),
    };
    match (&joint.friction, joint.constant.constant()) {
        (Some(friction), None) => {
            let terms = friction.terms.iter().enumerate();
            let ratio = terms.map(|(t, &term)| {
                let name = format!("{} / {}", term_name(joint, term), constant_name(joint));
                let unit = match term {
                    Term::Viscous => format!("A·s/{}", joint.position_unit),
                    Term::Coulomb | Term::Offset => "A".to_string(),
                };
                let deviation = friction.covariance[(t + 1, t + 1)].sqrt();
                make(name, unit, friction.coefficients[t], deviation)
            });
            ratio.collect()
        }
        (None, Some(constant)) if !joint.stage.speeds.is_empty() => {
            let (speed, value, deviation) = total_friction(joint, constant);
            let (coulomb, viscous) = (
                term_name(joint, Term::Coulomb),
                term_name(joint, Term::Viscous),
            );
            let expression = format!("{coulomb} + {speed:.4}*{viscous}");
            vec![make(
                expression,
                joint.torque_unit.to_string(),
                value,
                deviation,
            )]
        }
        _ => Vec::new(),
    }
}

/// Mean speed, friction torque against the motion at it, and its standard deviation.
fn total_friction(joint: &JointFit, (k, sigma): Constant) -> (f64, f64, f64) {
    let speeds = &joint.stage.speeds;
    let share = 1.0 / speeds.len() as f64;
    let mean = |of: &dyn Fn(&AtSpeed) -> f64| speeds.iter().map(of).sum::<f64>() * share;
    let current = mean(&|at| at.speed.signum() * at.sums.current);
    let load = mean(&|at| at.speed.signum() * at.sums.torque);
    let noise = share * mean(&|at| joint.stage.variance / at.sums.count);
    let variance = k * k * noise + (current * sigma).powi(2);
    (
        mean(&|at| at.speed.abs()),
        k * current - load,
        variance.sqrt(),
    )
}

/// Both stages of a joint, the simplex beside the linear solution.
fn stages(joint: &JointFit) -> MotorJoint {
    let constant = joint.constant.constant();
    let speed = |at: &AtSpeed| {
        let determined = at.inverse_variance.is_finite() && at.inverse > 0.0;
        let k = determined.then(|| 1.0 / at.inverse);
        let deviation = determined.then(|| at.inverse_variance.sqrt() / at.inverse.powi(2));
        let simplex = k.and_then(|k| nelder_mead(&at.sums, start(k)));
        MotorSpeed {
            speed: at.speed,
            samples: at.sums.count as usize,
            torque_constant: k,
            torque_constant_std_dev: deviation,
            torque_constant_simplex: simplex.map(|found| found[0]),
            friction: constant.map(|(k, _)| k * at.sums.current - at.sums.torque),
            friction_simplex: simplex.map(|found| found[1]),
            of_parts: at.of_parts.clone(),
        }
    };
    let load = load_dependence(&joint.parts, joint.stage.variance);
    MotorJoint {
        joint: joint.name.clone(),
        parts: joint.parts.len(),
        speeds: joint.stage.speeds.iter().map(speed).collect(),
        load_dependence: load.map(|found| MotorLoad {
            mu: found.mu,
            mu_std_dev: found.std_dev,
            torque_constant: found.torque_constant,
            torque_constant_std_dev: found.torque_constant_std_dev,
        }),
        advice: advice(joint),
    }
}

/// Start of the simplex: the power of ten below the constant, so that it has a way to go.
fn start(constant: f64) -> f64 {
    10f64.powf(constant.log10().floor())
}

/// Why the torque constant is not determined, and what to do.
fn advice(joint: &JointFit) -> Option<String> {
    let fix = "give it under [fit.constant_velocity.torque_constant], or list the joint with joints of \
               the same motor under fit.constant_velocity.same_type";
    let why = match joint.constant {
        Basis::Data(_) | Basis::Given(_) => return None,
        _ if joint.parts.is_empty() => {
            return Some(format!(
                "no recording moves {} steadily: record it",
                joint.name
            ));
        }
        _ if joint.vertical => {
            format!("its axis is parallel to gravity, so no mass loads it: {fix}")
        }
        _ => format!(
            "gravity does not load it enough in these motions: {fix}, or record it with a known mass off \
             its axis (recordings.loaded, robot.payload, and payload.mass and payload.com_* under \
             [drive.values])"
        ),
    };
    Some(match joint.constant {
        Basis::SameType((k, sigma)) => format!(
            "{why}; friction rests on {k:.4} ± {sigma:.4} {}/A, from joints of the same motor",
            joint.torque_unit
        ),
        _ => why,
    })
}

fn same_type(alike: &[Vec<Located<String>>], joints: &[JointFit]) -> Vec<SameType> {
    let groups = alike.iter();
    let compare = |names: Vec<&JointFit>| {
        let constants: Vec<Constant> = names.iter().filter_map(|j| j.constant.constant()).collect();
        let test = equality(&constants)?;
        Some(SameType {
            joints: names.iter().map(|joint| joint.name.clone()).collect(),
            mean: test.mean,
            chi_squared: test.chi_squared,
            p_value: test.p_value,
        })
    };
    let determined = groups.map(|group| {
        let members = joints.iter().filter(|joint| {
            matches!(joint.constant, Basis::Data(_))
                && group.iter().any(|name| name.value == joint.name)
        });
        members.collect()
    });
    determined.filter_map(compare).collect()
}

/// The friction grows with the load where mu is this many of its standard deviations.
const SIGNIFICANT: f64 = 4.0;

fn notes(joints: &[JointFit]) -> Vec<String> {
    let mut notes = vec![
        "Figures are of steady parts only: one joint at constant speed, all others at rest."
            .to_string(),
    ];
    for joint in joints {
        let name = &joint.name;
        notes.extend(
            advice(joint).map(|advice| format!("k_ct of {name} is undetermined: {advice}.")),
        );
        let single = joint.friction.is_none() && !joint.stage.speeds.is_empty();
        if single {
            notes.push(format!(
                "{name} moves at one speed: Coulomb and viscous friction enter by their sum only; record \
                 further speeds."
            ));
        }
        let load = load_dependence(&joint.parts, joint.stage.variance);
        if let Some(found) = load
            && found.mu.abs() > SIGNIFICANT * found.std_dev
        {
            notes.push(format!(
                "Friction of {name} grows with the load: {:.4} ± {:.4} per unit of torque, with k_ct = {:.4} \
                 ± {:.4} {}/A.",
                found.mu,
                found.std_dev,
                found.torque_constant,
                found.torque_constant_std_dev,
                joint.torque_unit
            ));
        }
    }
    notes
}
