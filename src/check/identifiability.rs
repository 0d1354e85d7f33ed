//! What the training motion determines: rank, condition, and the parameters that it leaves open.
//!
//! `W Y β` over the rows of all training recordings, β the base parameters that structure alone allows, W the
//! inverse residual deviation of each channel, columns scaled to unit norm.

use crate::chain::base_parameters::{BaseParameter, BaseParameters};
use crate::chain::dataset::Dataset;
use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::{GAIN, term_name};
use crate::chain::model::{JointModel, Model};
use crate::chain::parameter::{Parameter, Role};
use crate::check::context::CheckContext;
use crate::check::regression::{Comparison, Sampled, columns, known_part};
use crate::check::report::finding;
use crate::fault::{Description, Place};
use crate::linalg::triangular::{ColumnScaling, Triangular};
use crate::outcome::check::{Mistake, Severity};
use crate::recording::split::Split;
use nalgebra::{DMatrix, DVector};

/// Condition number above which errors of the model reach some parameter a hundredfold.
/// Source: Gautier and Khalil (1992), who ask for less than 100.
const WORST_CONDITION: f64 = 100.0;

/// Share of a column that must be its own for the motion to determine it: what is less is rounding and noise
/// of the motion.
const INDEPENDENT: f64 = 1e-6;

/// Relative standard deviation above which a friction parameter is a guess.
const GUESS: f64 = 0.3;

/// Names listed in a message.
const LISTED: usize = 6;

pub(super) fn check(context: &CheckContext<'_>, model: &Model, data: &Dataset) -> Vec<Mistake> {
    let no_prior = DMatrix::zeros(0, model.parameters().len());
    let structural = BaseParameters::structural(model, &data.loads(), &no_prior);
    let mut findings = of_structure(context, model, &structural);
    let kept = structural.kept();
    if kept.is_empty() || data.of(Split::Train).next().is_none() {
        return findings;
    }
    let factor = factor_of(model, data, &kept);
    let motion = factor.select(&(0..kept.len()).collect::<Vec<_>>());
    let split = scaled(&motion).independent_columns(INDEPENDENT);
    let names = |positions: &[usize]| named(model, positions.iter().map(|&k| kept[k]));
    let place = || Place::file(&context.problem.path).key("recordings.train");
    if !split.dependent.is_empty() {
        findings.push(finding(
            Severity::Warning,
            place(),
            Description::new(
                "rank-deficient",
                format!(
                    "the motion determines {} of {} base parameters; not {}",
                    split.kept.len(),
                    kept.len(),
                    names(&split.dependent)
                ),
                "move the joints of these parameters more, in several poses and directions; without that they are \
                 reported as undetermined",
            ),
        ));
    }
    let open = Open::of(&factor, &split.kept);
    let condition = motion
        .select(&split.kept)
        .condition_number(ColumnScaling::UnitNorm);
    if condition > WORST_CONDITION {
        let worst = open
            .as_ref()
            .map(|open| names(&open.worst()))
            .unwrap_or_default();
        findings.push(finding(
            Severity::Warning,
            place(),
            Description::new(
                "ill-conditioned",
                format!(
                    "the condition number of the motion is {condition:.0} (columns scaled); hardest to determine: \
                     {worst}"
                ),
                "excite with a motion from `exid design`, or add recordings in other poses",
            ),
        ));
    }
    if let Some(open) = open {
        findings.extend(guesses(context, model, &kept, &open));
    }
    findings
}

/// The triangular factor of the weighted columns and torques of all training recordings.
fn factor_of(model: &Model, data: &Dataset, kept: &[usize]) -> Triangular {
    let mut factor = Triangular::new(kept.len() + 1);
    for recording in data.of(Split::Train) {
        let sampled = Sampled::new(recording, 0);
        let zeros = vec![0.0; sampled.len()];
        let known = known_part(model, &sampled);
        let comparison = Comparison::new(model, recording);
        for (c, columns) in columns(model, &sampled, kept).into_iter().enumerate() {
            let channel = &model.channels()[c];
            if !channel.active {
                continue;
            }
            let constant = channel
                .joint
                .map_or(1.0, |j| model.joints()[j].torque_constant);
            let weight = constant / comparison.residual(c).max(f64::MIN_POSITIVE);
            let of = |p: &usize| {
                columns
                    .iter()
                    .find(|(q, _)| q == p)
                    .map(|(_, series)| series)
            };
            let signal = &recording.experiment.signal[c];
            let rest = sampled
                .rows
                .iter()
                .zip(&known[c])
                .map(|(&k, known)| signal[k] - known);
            let rest: Vec<f64> = rest.collect();
            let mut series: Vec<Vec<f64>> = kept
                .iter()
                .map(|p| of(p).unwrap_or(&zeros).clone())
                .collect();
            series.push(rest);
            series.iter_mut().flatten().for_each(|x| *x *= weight);
            let slices: Vec<&[f64]> = series.iter().map(Vec::as_slice).collect();
            factor.absorb_columns(&slices);
        }
    }
    factor
}

/// The factor with columns of unit norm; columns that are zero stay zero.
fn scaled(factor: &Triangular) -> Triangular {
    let mut matrix = factor.matrix();
    for mut column in matrix.column_iter_mut() {
        let norm = column.norm();
        if norm > 0.0 {
            column /= norm;
        }
    }
    Triangular::of(&matrix)
}

/// Estimates of the parameters that the motion determines, with standard deviations.
struct Open {
    /// Positions among the kept parameters.
    positions: Vec<usize>,
    values: DVector<f64>,
    deviations: DVector<f64>,
}

impl Open {
    fn of(factor: &Triangular, positions: &[usize]) -> Option<Self> {
        let mut columns = positions.to_vec();
        columns.push(factor.columns() - 1);
        let system = factor.select(&columns).system()?;
        let triangular = Triangular::of(&system.matrix);
        let covariance = triangular.covariance()?;
        Some(Self {
            positions: positions.to_vec(),
            values: system.matrix.solve_upper_triangular(&system.right)?,
            deviations: covariance.diagonal().map(f64::sqrt),
        })
    }

    /// The three parameters with the largest relative standard deviation.
    fn worst(&self) -> Vec<usize> {
        let relative = |k: usize| self.deviations[k] / self.values[k].abs();
        let mut order: Vec<usize> = (0..self.positions.len()).collect();
        order.sort_by(|&a, &b| relative(b).total_cmp(&relative(a)));
        order
            .into_iter()
            .take(3)
            .map(|k| self.positions[k])
            .collect()
    }
}

/// Friction that the recordings leave open.
fn guesses(context: &CheckContext<'_>, model: &Model, kept: &[usize], open: &Open) -> Vec<Mistake> {
    let mut findings = Vec::new();
    for (k, &position) in open.positions.iter().enumerate() {
        let parameter = &model.parameters()[kept[position]];
        let relative = open.deviations[k] / open.values[k].abs();
        if is_friction(model, parameter) && relative > GUESS {
            findings.push(finding(
                Severity::Note,
                Place::file(&context.problem.path).key(&parameter.name),
                Description::new(
                    "poorly-determined",
                    format!(
                        "the recordings give {:.4} with a standard deviation of {:.4} {}",
                        open.values[k], open.deviations[k], parameter.unit
                    ),
                    "move this joint slowly and fast, in both directions",
                ),
            ));
        }
    }
    findings
}

fn is_friction(model: &Model, parameter: &Parameter) -> bool {
    let Role::Effect { joint, effect, .. } = parameter.role else {
        return false;
    };
    let (effect, _) = model.joints()[joint].effects[effect];
    matches!(
        effect.knowledge.term,
        Some(JointTerm::DryFriction | JointTerm::ViscousFriction)
    )
}

/// Parameters that no motion determines although the problem file asks for them.
fn of_structure(
    context: &CheckContext<'_>,
    model: &Model,
    structural: &BaseParameters,
) -> Vec<Mistake> {
    let place = |name: &str| Place::file(&context.problem.path).key(name);
    let mut findings = Vec::new();
    for name in asked_for(context, model) {
        let Some(parameter) = model.position(&name) else {
            continue;
        };
        if !model.parameters()[parameter].is_linear_unknown() || structural.determines(parameter) {
            continue;
        }
        let holds = |b: &BaseParameter| {
            b.parameter == parameter || b.others.iter().any(|(p, _)| *p == parameter)
        };
        let how = match structural.base.iter().position(holds) {
            Some(index) => {
                let base = &structural.base[index];
                let others = base.others.iter().map(|(p, _)| *p);
                let together = std::iter::once(base.parameter).chain(others);
                let together = together.filter(|p| *p != parameter);
                format!("it enters only together with {}", named(model, together))
            }
            None => "it has no effect on the signal".to_string(),
        };
        findings.push(finding(
            Severity::Note,
            place(&name),
            Description::new(
                "not-identifiable",
                format!("no motion determines this parameter by itself: {how}"),
                "give one of them under drive.values, or read the combination from base_parameters",
            ),
        ));
    }
    findings.extend(gains(context, model));
    findings
}

/// Parameters of rotors and those that the fit has priors for.
fn asked_for(context: &CheckContext<'_>, model: &Model) -> Vec<String> {
    let rotor = term_name(JointTerm::RotorInertia);
    let rotors = model
        .parameters()
        .iter()
        .filter(|p| p.name.ends_with(&rotor));
    let mut names: Vec<String> = rotors.map(|p| p.name.clone()).collect();
    for bound in &context.problem.fit.bounds {
        if !names.contains(&bound.name) {
            names.push(bound.name.clone());
        }
    }
    names
}

/// A free gain needs something that is known in N·m, of itself or of another parameter.
fn gains(context: &CheckContext<'_>, model: &Model) -> Vec<Mistake> {
    let mut parameters = model.parameters().iter();
    let mut expected = context.problem.fit.prior.values.iter();
    let anchored = parameters.any(|p| !p.is_free() && p.value != 0.0)
        || expected.any(|entry| entry.value.value.value != 0.0);
    let free = |joint: &&JointModel| {
        joint
            .gain
            .is_some_and(|gain| model.parameters()[gain].is_free())
    };
    let joints = model.joints().iter().filter(free);
    let report = |joint: &JointModel| {
        finding(
            Severity::Warning,
            Place::file(&context.problem.path).key(format!("{}.{}.{}", joint.name, GAIN.id, GAIN.parameters[0].name)),
            Description::new(
                "not-identifiable",
                "the gain and all inertial and friction parameters are free: only their ratio enters the signal"
                    .to_string(),
                "use inertials = \"known\", give known values under drive.values, or add a recording with a known \
                 load",
            ),
        )
    };
    if anchored {
        Vec::new()
    } else {
        joints.map(report).collect()
    }
}

fn named(model: &Model, parameters: impl Iterator<Item = usize>) -> String {
    let all: Vec<&str> = parameters
        .map(|p| model.parameters()[p].name.as_str())
        .collect();
    match all.len().checked_sub(LISTED) {
        Some(more) if more > 0 => format!("{} and {more} more", all[..LISTED].join(", ")),
        _ => all.join(", "),
    }
}
