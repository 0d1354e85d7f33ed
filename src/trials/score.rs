//! The score of a trial: whether the findings are what was concealed.

use crate::chain::effect::knowledge::JointTerm;
use crate::chain::effect::term_name;
use crate::chain::model::Model;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::task::DiagnoseRun;
use crate::outcome::diagnose::{Diagnosis, Unattested, Verdict};
use crate::outcome::finding::Finding;
use crate::outcome::trials::{Found, Hidden, Inseparable, Nameless, Trial};
use crate::trials::naming::names;
use crate::trials::outside_law::OutsideLaw;
use crate::trials::plan::Plan;
use crate::trials::reference_fits::{ReferenceFits, Sizes};
use crate::trials::{bodies, calibration};
use nalgebra::DVector;
use std::iter;

/// A trial without an answer.
pub fn failed(plan: &Plan, why: String) -> Trial {
    Trial {
        concealed: hidden(plan, &Sizes::default()),
        failure: Some(why),
        ..head(plan)
    }
}

fn head(plan: &Plan) -> Trial {
    Trial {
        seed: plan.number,
        robot: plan.robot.kind.to_string(),
        motion: plan.motion.name().to_string(),
        noise: plan.noise.name().to_string(),
        noise_correlation: plan.correlation,
        ..Trial::default()
    }
}

/// Judges a diagnosis by what was concealed.
pub fn judge(
    plan: &Plan,
    run: &DiagnoseRun,
    informed: Option<&ReferenceFits>,
    sizes: &Sizes,
) -> Trial {
    let concealed = hidden(plan, sizes);
    let found: Vec<Found> = run.diagnosis.findings.iter().map(found).collect();
    let first = found.first();
    let is = |finding: &Found| concealed.iter().find(|hidden| names(finding, hidden));
    Trial {
        right_effect: first.is_some_and(|finding| is(finding).is_some()),
        right_joints: first.is_some_and(|finding| {
            concealed
                .iter()
                .any(|hidden| finding.joints == hidden.joints)
        }),
        all_found: !concealed.is_empty()
            && concealed
                .iter()
                .all(|hidden| found.iter().any(|f| names(f, hidden))),
        verdict: Verdict::or_none(run.diagnosis.verdict).to_string(),
        error_ratio: error_ratio(run),
        friction_error: informed.and_then(|informed| friction_error(plan, run, informed)),
        body_error: informed.and_then(|informed| body_error(plan, run, informed)),
        stated: calibration::stated(&run.diagnosis.findings, &concealed),
        concealed,
        found,
        ..head(plan)
    }
}

/// What a diagnosis has in the place of what has no name, but for its forecast.
pub fn nameless(plan: &Plan, diagnosis: &Diagnosis) -> Nameless {
    let findings = &diagnosis.findings;
    let robot = &plan.robot;
    let joint = plan.law.as_ref().map(|law| robot.name(law.joint));
    let is_on = |finding: &&Finding| joint.is_none_or(|joint| finding.joints == [joint]);
    let formula = findings
        .iter()
        .filter(is_on)
        .find_map(|f| f.formula.as_ref());
    let unnamed = findings.iter().filter(is_on).find(|f| f.has_no_name());
    Nameless {
        law: plan.law.as_ref().map(|law| law.torque(robot)),
        variables: plan
            .law
            .iter()
            .flat_map(OutsideLaw::variables)
            .map(|x| x.name(robot))
            .collect(),
        formula: formula.map(|formula| formula.expression.clone()),
        formula_variables: formula.map_or_else(Vec::new, |formula| formula.variables.clone()),
        smooth_share: unnamed.map_or(0.0, |f| f.explained_share),
        unexplained: most_unexplained(&diagnosis.unattested).filter(|_| findings.is_empty()),
        forecast: None,
    }
}

/// The joint of which the largest share of the signal is left, of those of which that is known.
pub(super) fn most_unexplained(unattested: &[Unattested]) -> Option<String> {
    let known = unattested.iter().filter(|left| left.of_signal.is_finite());
    let most = known.max_by(|a, b| a.of_signal.total_cmp(&b.of_signal))?;
    Some(most.joint.clone())
}

fn found(finding: &Finding) -> Found {
    let rivals = finding.rivals.iter().filter(|rival| !rival.separable);
    Found {
        effect: finding.effect.clone(),
        joints: finding.joints.clone(),
        explained_share: finding.explained_share,
        inseparable: rivals
            .map(|rival| Inseparable {
                effect: rival.effect.clone(),
                joints: rival.joints.clone(),
                times_longer: rival.times_longer,
                told_apart: None,
            })
            .collect(),
    }
}

/// What was concealed, with its size.
fn hidden(plan: &Plan, sizes: &Sizes) -> Vec<Hidden> {
    let name = |j: &usize| plan.robot.name(*j).to_string();
    let sizes_of_effects = sizes.effects.iter().copied().chain(iter::repeat(f64::NAN));
    let of_vocabulary = plan
        .concealed
        .iter()
        .zip(sizes_of_effects)
        .map(|(c, size)| Hidden {
            effect: c.hypothesis.effect.id.to_string(),
            effect_over_noise: size,
            joints: c.joints().iter().map(name).collect(),
        });
    let outside = plan.outside.iter().map(|outside| Hidden {
        effect: outside.law.name().to_string(),
        joints: vec![name(&outside.at.joint)],
        effect_over_noise: sizes.outside.unwrap_or(f64::NAN),
    });
    let drawn = plan.law.iter().map(|law| Hidden {
        effect: law.name().to_string(),
        joints: vec![name(&law.joint)],
        effect_over_noise: sizes.outside.unwrap_or(f64::NAN),
    });
    of_vocabulary.chain(outside).chain(drawn).collect()
}

/// Held-out error after over before, of the joint with the largest misfit.
fn error_ratio(run: &DiagnoseRun) -> Option<f64> {
    let before = &run.diagnosis.baseline.joints;
    let pairs = before.iter().zip(&run.diagnosis.outcome.joints);
    let errors = pairs.filter_map(|(b, a)| {
        let (old, new) = (b.rmse_validation?, a.rmse_validation?);
        Some((b.lack_of_fit?, new / old))
    });
    errors
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, ratio)| ratio)
}

/// RMS relative error of Coulomb and viscous friction: declared model, model found, model that knew the truth.
fn friction_error(plan: &Plan, run: &DiagnoseRun, informed: &ReferenceFits) -> Option<[f64; 3]> {
    let truth: Vec<(String, f64)> = (0..plan.robot.tree.len())
        .flat_map(|j| {
            let name = plan.robot.name(j);
            let [dry, viscous] = plan.robot.friction[j];
            [
                (format!("{name}.{}", term_name(JointTerm::DryFriction)), dry),
                (
                    format!("{name}.{}", term_name(JointTerm::ViscousFriction)),
                    viscous,
                ),
            ]
        })
        .collect();
    let error = |value: &dyn Fn(&str) -> Option<f64>| {
        let squares = truth
            .iter()
            .map(|(name, true_value)| value(name).map(|x| (x / true_value - 1.0).powi(2)));
        let squares: Option<Vec<f64>> = squares.collect();
        squares.map(|s| (s.iter().sum::<f64>() / s.len() as f64).sqrt())
    };
    let of_fit = |fit: &ModelFit| {
        let value = |name: &str| fit.model.position(name).map(|k| fit.values[k]);
        error(&value)
    };
    let of_run = |name: &str| {
        let mut all = values(run);
        all.find(|(own, _)| *own == name).map(|(_, x)| x)
    };
    Some([
        of_fit(&informed.declared)?,
        error(&of_run)?,
        of_fit(&informed.known)?,
    ])
}

/// Error of what the bodies ask for: declared model, model found, model that knew the truth.
fn body_error(plan: &Plan, run: &DiagnoseRun, informed: &ReferenceFits) -> Option<[f64; 3]> {
    let of = |model: &Model, values: &DVector<f64>| bodies::error(plan, model, values, &run.data);
    let of_fit = |fit: &ModelFit| of(&fit.model, &fit.values);
    let found = of(&run.model, &run.values)?;
    Some([of_fit(&informed.declared)?, found, of_fit(&informed.known)?])
}

/// The parameters that a diagnosis came to, by name.
fn values(run: &DiagnoseRun) -> impl Iterator<Item = (&str, f64)> {
    let all = run.diagnosis.outcome.parameters.iter();
    all.filter_map(|p| Some((p.name.as_str(), p.value?)))
}
