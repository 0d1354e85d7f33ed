//! Two results side by side: parameters against the uncertainty of their difference, errors by joint, findings.
//!
//! ```text
//! d = b − a,   Var d = Σ_a + Σ_b          of independent data
//! z_k = d_k / sqrt(Var d_kk),             one parameter; p-values corrected by Holm's method for all that are compared
//! T = dᵀ (Σ_a + Σ_b)⁻¹ d ~ χ²(rank)       all parameters together
//! ```
//! Sources: Holm (1979); for T the Wald test.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use crate::outcome::estimate::Covariance;
use crate::outcome::finding::Finding;
use crate::outcome::fit::Fit;
use crate::outcome::joint::JointFigures;
use crate::outcome::{Outcome, Part};
use crate::stats::distribution::Distribution;

/// Chance of calling anything different where nothing is, over all parameters.
pub const LEVEL: f64 = 0.05;

/// Directions of the difference in which the variance is below this share of the largest, each parameter in units of its own
/// standard deviation, are numerical noise.
const LEAST_VARIANCE: f64 = 1e-10;

/// What two results say of the same.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Compared {
    /// Recordings and earlier results that both are made of, which makes their errors alike: variances of differences are then
    /// not the sums that are used.
    pub shared: Vec<String>,
    /// In both; by how much they differ, the most first, then those without a test in the order of the first result.
    pub parameters: Vec<ComparedParameter>,
    /// All parameters that are in both covariances; absent where there is none.
    pub together: Option<Together>,
    /// Errors of the joints that are in both.
    pub joints: Vec<ComparedJoint>,
    /// Findings of either.
    pub findings: Vec<ComparedFinding>,
    /// Names of parameters and combinations that the second does not have.
    pub only_first: Vec<String>,
    /// Names of those that the first does not have.
    pub only_second: Vec<String>,
    /// Chance of calling anything different where nothing is.
    pub level: f64,
}

/// A parameter, or a combination that the data determine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparedParameter {
    /// Name of the parameter, or the combination as an expression.
    pub name: String,
    /// SI unit of values, deviations and difference.
    pub unit: String,
    /// What the first result says.
    pub first: Valued,
    /// What the second says.
    pub second: Valued,
    /// Second minus first.
    pub difference: Option<f64>,
    /// The difference in standard deviations of it; absent where neither has one.
    pub deviations: Option<f64>,
    /// Corrected for the number of parameters.
    pub p_value: Option<f64>,
    /// The p-value is below the level.
    pub differs: bool,
}

/// A value with its standard deviation, as far as there are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Valued {
    /// Absent where the data do not determine it.
    pub value: Option<f64>,
    /// Absent of a value that is known or not determined.
    pub std_dev: Option<f64>,
}

/// The test of all parameters together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Together {
    /// T, the squared difference in the metric of its covariance.
    pub chi_squared: f64,
    /// Independent parameters.
    pub freedom: usize,
    /// Probability of such a T, or a larger one, where nothing differs.
    pub p_value: f64,
}

/// Errors of a joint in both.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparedJoint {
    /// Name of the joint, or of the channel of a wrench.
    pub joint: String,
    /// Of the first, then of the second.
    pub unit: [String; 2],
    /// Of the fitted recordings, of the first, then of the second.
    pub rmse_train: [f64; 2],
    /// Of recordings that were not fitted; absent where there are none.
    pub rmse_validation: [Option<f64>; 2],
}

/// A finding and in which result it is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparedFinding {
    /// Identifier of the effect.
    pub effect: String,
    /// Joints at which it was found.
    pub joints: Vec<String>,
    /// Probability in the first; absent where it has no such finding.
    pub first: Option<f64>,
    /// Probability in the second; absent where it has no such finding.
    pub second: Option<f64>,
}

/// Compares two results.
pub fn compare(first: &Outcome, second: &Outcome) -> Compared {
    let (a, b) = (quantities(first), quantities(second));
    let only = |these: &[Quantity], others: &[Quantity]| -> Vec<String> {
        let alone = these
            .iter()
            .filter(|q| others.iter().all(|o| o.name != q.name));
        alone.map(|q| q.name.clone()).collect()
    };
    let pairs = a.iter().filter_map(|x| {
        let y = b.iter().find(|y| y.name == x.name)?;
        Some(pair(x, y))
    });
    let mut parameters: Vec<ComparedParameter> = pairs.collect();
    correct(&mut parameters);
    let size = |p: &ComparedParameter| p.deviations.map_or(f64::NEG_INFINITY, f64::abs);
    parameters.sort_by(|x, y| size(y).total_cmp(&size(x)));
    Compared {
        shared: shared(first, second),
        together: together(first, second),
        parameters,
        joints: joints(&first.estimate.joints, &second.estimate.joints),
        findings: findings(of_diagnosis(first), of_diagnosis(second)),
        only_first: only(&a, &b),
        only_second: only(&b, &a),
        level: LEVEL,
    }
}

/// What a result has a value of.
struct Quantity {
    name: String,
    unit: String,
    valued: Valued,
}

/// Parameters, then the combinations that are none of them.
fn quantities(outcome: &Outcome) -> Vec<Quantity> {
    let parameters = &outcome.estimate.parameters;
    // A result may have for every joint what joints of the other have in common.
    let named = parameters
        .iter()
        .flat_map(|p| p.names().into_iter().map(move |name| (name, p)));
    let of_parameters = named.map(|(name, p)| Quantity {
        name,
        unit: p.unit.clone(),
        valued: Valued {
            value: p.value,
            std_dev: p.std_dev,
        },
    });
    let base = of_fit(outcome).map_or(&[][..], |fit| &fit.base_parameters);
    let is_own = |expression: &str| parameters.iter().any(|p| p.name == expression);
    let of_base = base.iter().filter(|b| !is_own(&b.expression));
    let of_base = of_base.map(|b| Quantity {
        name: b.expression.clone(),
        unit: b.unit.clone(),
        valued: Valued {
            value: b.value,
            std_dev: b.std_dev,
        },
    });
    of_parameters.chain(of_base).collect()
}

fn of_fit(outcome: &Outcome) -> Option<&Fit> {
    match &outcome.part {
        Part::Fit(fit) => Some(fit),
        Part::Diagnose(diagnosis) => diagnosis.fit.as_ref(),
        _ => None,
    }
}

fn of_diagnosis(outcome: &Outcome) -> &[Finding] {
    match &outcome.part {
        Part::Diagnose(diagnosis) => &diagnosis.findings,
        _ => &[],
    }
}

fn pair(a: &Quantity, b: &Quantity) -> ComparedParameter {
    let difference = a.valued.value.zip(b.valued.value).map(|(a, b)| b - a);
    // What is known has no uncertainty of its own.
    let variance = |v: Valued| v.std_dev.map_or(0.0, |s| s * s);
    let deviation = (variance(a.valued) + variance(b.valued)).sqrt();
    let deviations = difference
        .filter(|_| deviation > 0.0)
        .map(|d| d / deviation);
    ComparedParameter {
        name: a.name.clone(),
        unit: a.unit.clone(),
        first: a.valued,
        second: b.valued,
        difference,
        deviations,
        p_value: deviations.map(|z| 2.0 * Distribution::Normal.upper_tail(z.abs())),
        differs: false,
    }
}

/// Holm's correction: the k-th smallest of m p-values times m − k + 1, none smaller than the one before it.
fn correct(parameters: &mut [ComparedParameter]) {
    let mut tested: Vec<&mut ComparedParameter> = parameters
        .iter_mut()
        .filter(|p| p.p_value.is_some())
        .collect();
    let p = |parameter: &ComparedParameter| parameter.p_value.unwrap_or(1.0);
    tested.sort_by(|x, y| p(x).total_cmp(&p(y)));
    let count = tested.len();
    let mut least = 0.0_f64;
    for (k, parameter) in tested.into_iter().enumerate() {
        least = least.max((p(parameter) * (count - k) as f64).min(1.0));
        parameter.p_value = Some(least);
        parameter.differs = least < LEVEL;
    }
}

fn together(first: &Outcome, second: &Outcome) -> Option<Together> {
    let (a, b) = (&first.estimate, &second.estimate);
    let value = |outcome: &Outcome, name: &str| {
        let mut all = outcome.estimate.parameters.iter();
        all.find(|p| p.name == name).and_then(|p| p.value)
    };
    let index =
        |covariance: &Covariance, name: &str| covariance.parameters.iter().position(|p| p == name);
    let mut places = Vec::new();
    let mut difference = Vec::new();
    for (i, name) in a.covariance.parameters.iter().enumerate() {
        let values = value(first, name).zip(value(second, name));
        if let (Some(j), Some((x, y))) = (index(&b.covariance, name), values) {
            places.push((i, j));
            difference.push(y - x);
        }
    }
    let sum = DMatrix::from_fn(places.len(), places.len(), |r, c| {
        let ((i, j), (k, l)) = (places[r], places[c]);
        a.covariance.matrix[i][k] + b.covariance.matrix[j][l]
    });
    wald(&DVector::from_vec(difference), &sum)
}

/// dᵀ V⁻¹ d over the directions in which V is more than numerical noise.
fn wald(difference: &DVector<f64>, variance: &DMatrix<f64>) -> Option<Together> {
    let scale = variance.diagonal().map(f64::sqrt);
    if difference.is_empty() || !scale.iter().all(|s| s.is_finite() && *s > 0.0) {
        return None;
    }
    let scaled = DMatrix::from_fn(scale.len(), scale.len(), |r, c| {
        variance[(r, c)] / (scale[r] * scale[c])
    });
    if !scaled.iter().all(|x| x.is_finite()) {
        return None;
    }
    let eigen = scaled.symmetric_eigen();
    let along = eigen.eigenvectors.transpose() * difference.component_div(&scale);
    let largest = eigen.eigenvalues.max();
    let (mut chi_squared, mut freedom) = (0.0, 0);
    for (x, lambda) in along.iter().zip(&eigen.eigenvalues) {
        if *lambda > LEAST_VARIANCE * largest {
            chi_squared += x * x / lambda;
            freedom += 1;
        }
    }
    let distribution = Distribution::ChiSquared {
        freedom: freedom as f64,
    };
    Some(Together {
        chi_squared,
        freedom,
        p_value: distribution.upper_tail(chi_squared),
    })
}

fn joints(first: &[JointFigures], second: &[JointFigures]) -> Vec<ComparedJoint> {
    let pairs = first.iter().filter_map(|a| {
        let b = second.iter().find(|b| b.joint == a.joint)?;
        Some(ComparedJoint {
            joint: a.joint.clone(),
            unit: [a.unit.clone(), b.unit.clone()],
            rmse_train: [a.rmse_train, b.rmse_train],
            rmse_validation: [a.rmse_validation, b.rmse_validation],
        })
    });
    pairs.collect()
}

/// A finding is the same where its effect and its joints are.
fn findings(first: &[Finding], second: &[Finding]) -> Vec<ComparedFinding> {
    let probability = |findings: &[Finding], one: &Finding| {
        let mut same = findings
            .iter()
            .filter(|f| f.effect == one.effect && f.joints == one.joints);
        same.next().map(|f| f.probability)
    };
    let only_second = second.iter().filter(|f| probability(first, f).is_none());
    let all = first.iter().chain(only_second);
    all.map(|finding| ComparedFinding {
        effect: finding.effect.clone(),
        joints: finding.joints.clone(),
        first: probability(first, finding),
        second: probability(second, finding),
    })
    .collect()
}

/// Inputs of the same content but for the problem and the robot.
fn shared(first: &Outcome, second: &Outcome) -> Vec<String> {
    let is_description = |path: &str| {
        let ends = [".urdf", ".xml", ".toml", ".xacro"];
        ends.iter().any(|end| path.to_lowercase().ends_with(end))
    };
    let data = first
        .run
        .inputs
        .iter()
        .filter(|input| !is_description(&input.path));
    let both = data.filter(|a| second.run.inputs.iter().any(|b| b.sha256 == a.sha256));
    both.map(|input| input.path.clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::parameter::{Parameter, Source};
    use crate::outcome::tests::fit_outcome;

    fn outcome(values: &[(&str, f64, f64)], matrix: Vec<Vec<f64>>) -> Outcome {
        let mut outcome = fit_outcome();
        outcome.run.inputs.clear();
        outcome.part = Part::Fit(Fit::default());
        outcome.estimate.parameters = values
            .iter()
            .map(|&(name, value, std_dev)| Parameter {
                value: Some(value),
                std_dev: Some(std_dev),
                source: Source::Data,
                ..Parameter::undetermined(name, "kg")
            })
            .collect();
        outcome.estimate.covariance = Covariance {
            parameters: values.iter().map(|v| v.0.to_owned()).collect(),
            matrix,
        };
        outcome
    }

    /// Values of SciPy 1.17: `2*norm.sf(z)` times 3, 2 and 1, `d @ solve(V, d)`, `chi2.sf(T, 3)`.
    #[test]
    fn matches_independent_tests() {
        let diagonal = |s: [f64; 3]| {
            (0..3)
                .map(|i| {
                    (0..3)
                        .map(|j| if i == j { s[i] * s[i] } else { 0.0 })
                        .collect()
                })
                .collect()
        };
        let mut first: Vec<Vec<f64>> = diagonal([0.3, 0.4, 1.0]);
        (first[0][1], first[1][0]) = (0.06, 0.06);
        let a = outcome(
            &[("m", 10.0, 0.3), ("Fc", 2.0, 0.4), ("Fv", 5.0, 1.0)],
            first,
        );
        let b = outcome(
            &[("m", 11.5, 0.4), ("Fc", 3.0, 0.3), ("Fv", 5.5, 1.0)],
            diagonal([0.4, 0.3, 1.0]),
        );
        let found = compare(&a, &b);
        let names: Vec<&str> = found.parameters.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["m", "Fc", "Fv"]);
        let expected = [(3.0, HOLM[0]), (2.0, HOLM[1]), (0.5 / 2f64.sqrt(), HOLM[2])];
        for (p, (z, corrected)) in found.parameters.iter().zip(expected) {
            assert!((p.deviations.unwrap() - z).abs() < 1e-12, "{}", p.name);
            assert!(
                (p.p_value.unwrap() / corrected - 1.0).abs() < 1e-9,
                "{}",
                p.name
            );
            assert_eq!(p.differs, p.name == "m");
        }
        let together = found.together.unwrap();
        assert_eq!(together.freedom, 3);
        assert!((together.chi_squared / CHI_SQUARED - 1.0).abs() < 1e-12);
        assert!((together.p_value / TOGETHER - 1.0).abs() < 1e-9);
    }

    const HOLM: [f64; 3] = [0.00809938818978056, 0.09100052779271678, 0.7236736098317631];
    const CHI_SQUARED: f64 = 10.863539898132426;
    const TOGETHER: f64 = 0.012487122303372934;

    #[test]
    fn what_is_in_one_alone_and_what_is_shared_is_said() {
        let a = fit_outcome();
        let mut b = fit_outcome();
        b.estimate.parameters[2].name = "link2.mass".to_owned();
        let found = compare(&a, &b);
        assert_eq!(found.only_first, ["link1.mass"]);
        assert_eq!(found.only_second, ["link2.mass"]);
        assert_eq!(found.shared, ["train.csv"]);
        assert!(found.parameters.iter().all(|p| !p.differs));
        // What is known in both has a difference and no test.
        let known = found
            .parameters
            .iter()
            .find(|p| p.name == "joint1.coulomb_friction.w")
            .unwrap();
        assert_eq!((known.difference, known.deviations), (Some(0.0), None));
    }
}
