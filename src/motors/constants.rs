//! The two stages, each linear. At speed v:  i = a·g + b_v,  a = 1/k_ct,  b_v = τ_f(v)/k_ct;  over the speeds:
//! b_v = βc·sign(v) + βv·v (+ β0).  g = G(q) + C(q, q̇)q̇, N·m.

use nalgebra::{DMatrix, DVector};

use crate::stats::autoregression::{Autoregression, OrderCriterion};

/// The samples of one steady part.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// rad/s (m/s).
    pub speed: f64,
    /// Torque that gravity and the motion ask for, N·m (N), sample by sample.
    pub torque: Vec<f64>,
    /// A.
    pub current: Vec<f64>,
}

/// Sums of a set of samples about their means.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sums {
    /// Samples.
    pub count: f64,
    /// Mean torque, N·m (N).
    pub torque: f64,
    /// Mean current, A.
    pub current: f64,
    /// Σ of squared torques about their mean.
    pub torque_torque: f64,
    /// Σ of products of torque and current about their means.
    pub torque_current: f64,
    /// Σ of squared currents about their mean.
    pub current_current: f64,
}

impl Sums {
    fn of(parts: &[&Part]) -> Self {
        let samples = || {
            let each = parts.iter();
            each.flat_map(|p| p.torque.iter().copied().zip(p.current.iter().copied()))
        };
        let count = samples().count() as f64;
        let torque = samples().map(|s| s.0).sum::<f64>() / count;
        let current = samples().map(|s| s.1).sum::<f64>() / count;
        let mut sums = Self {
            count,
            torque,
            current,
            ..Self::default()
        };
        for (g, i) in samples() {
            let (g, i) = (g - torque, i - current);
            sums.torque_torque += g * g;
            sums.torque_current += g * i;
            sums.current_current += i * i;
        }
        sums
    }
}

/// What the first stage gives at one speed.
#[derive(Debug, Clone, PartialEq)]
pub struct AtSpeed {
    /// Mean over its parts, rad/s (m/s).
    pub speed: f64,
    /// Of its samples.
    pub sums: Sums,
    /// a = 1/k_ct, A/(N·m), with its variance; infinite where the load does not vary.
    pub inverse: f64,
    /// Variance of a; infinite where the load does not vary.
    pub inverse_variance: f64,
    /// k_ct of each part by itself, N·m/A, where it is determined.
    pub of_parts: Vec<f64>,
}

/// Speeds closer than this, as a share, are one speed.
const SAME_SPEED: f64 = 0.05;

/// The inverse torque constant counts as determined from this many of its standard deviations on:
/// k_ct is then known to a quarter.
const LEAST_DETERMINED: f64 = 4.0;

/// Least variation of the load as a share of its size: below it is rounding.
const LEAST_VARIATION: f64 = 1e-9;

/// Most coefficients of the autoregression that tells how far residuals are correlated.
const MOST_CORRELATED: usize = 30;

/// a = 1/k_ct, A per N·m (N), with its variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InverseConstant {
    /// a.
    pub value: f64,
    /// Its variance.
    pub variance: f64,
}

/// The first stage for one joint.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstStage {
    /// By speed, ascending.
    pub speeds: Vec<AtSpeed>,
    /// Long-run variance of the current about the fit, A²: that of a mean of n samples times n.
    pub variance: f64,
    /// Its variance has the scatter over the speeds in it; None where undetermined.
    pub inverse: Option<InverseConstant>,
}

/// Fits every speed by itself and draws the mean over the speeds, weighted by their variances.
pub fn first_stage(parts: &[Part]) -> FirstStage {
    let groups = by_speed(parts);
    let mut speeds: Vec<AtSpeed> = groups.iter().map(|group| at_speed(group)).collect();
    let variance = long_run_variance(&groups, &speeds);
    for at in &mut speeds {
        at.inverse_variance = match varies(&at.sums) {
            true => variance / at.sums.torque_torque,
            false => f64::INFINITY,
        };
    }
    for (at, group) in speeds.iter_mut().zip(&groups) {
        at.of_parts = of_parts(group, variance);
    }
    let inverse = weighted_mean(&speeds);
    FirstStage {
        speeds,
        variance,
        inverse,
    }
}

fn by_speed(parts: &[Part]) -> Vec<Vec<&Part>> {
    let mut sorted: Vec<&Part> = parts.iter().collect();
    sorted.sort_by(|a, b| a.speed.total_cmp(&b.speed));
    let mut groups: Vec<Vec<&Part>> = Vec::new();
    for part in sorted {
        match groups.last_mut() {
            Some(group) if same_speed(group[0].speed, part.speed) => group.push(part),
            _ => groups.push(vec![part]),
        }
    }
    groups
}

fn same_speed(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_SPEED * a.abs().max(b.abs())
}

fn varies(sums: &Sums) -> bool {
    let deviation = (sums.torque_torque / sums.count).sqrt();
    deviation > LEAST_VARIATION * (1.0 + sums.torque.abs())
}

fn at_speed(group: &[&Part]) -> AtSpeed {
    let sums = Sums::of(group);
    let speed = group.iter().map(|p| p.speed).sum::<f64>() / group.len() as f64;
    let inverse = match varies(&sums) {
        true => sums.torque_current / sums.torque_torque,
        false => 0.0,
    };
    AtSpeed {
        speed,
        sums,
        inverse,
        inverse_variance: f64::INFINITY,
        of_parts: Vec::new(),
    }
}

fn of_parts(group: &[&Part], variance: f64) -> Vec<f64> {
    let sums = group.iter().map(|part| Sums::of(&[part]));
    let fits = sums.filter(varies).filter_map(|sums| {
        let inverse = sums.torque_current / sums.torque_torque;
        let deviation = (variance / sums.torque_torque).sqrt();
        (inverse > LEAST_DETERMINED * deviation).then(|| 1.0 / inverse)
    });
    fits.collect()
}

/// From the residuals of every part: ripple and slow drift make neighbours alike.
fn long_run_variance(groups: &[Vec<&Part>], speeds: &[AtSpeed]) -> f64 {
    let mut residuals: Vec<Vec<f64>> = Vec::new();
    for (group, at) in groups.iter().zip(speeds) {
        for part in group {
            let offset = at.sums.current - at.inverse * at.sums.torque;
            let samples = part.torque.iter().zip(&part.current);
            residuals.push(samples.map(|(g, i)| i - at.inverse * g - offset).collect());
        }
    }
    let slices: Vec<&[f64]> = residuals.iter().map(Vec::as_slice).collect();
    let count: usize = residuals.iter().map(Vec::len).sum();
    let freedom = count.saturating_sub(2 * speeds.len()).max(1) as f64;
    let fitted = Autoregression::fit(&slices, MOST_CORRELATED, OrderCriterion::Bic);
    let variance = fitted.map_or(0.0, |model| model.long_run_variance().max(model.variance()));
    variance * count as f64 / freedom
}

/// The mean of the speeds and its variance, which grows with their scatter (Birge 1932).
fn weighted_mean(speeds: &[AtSpeed]) -> Option<InverseConstant> {
    let known = || speeds.iter().filter(|at| at.inverse_variance.is_finite());
    let weight: f64 = known().map(|at| 1.0 / at.inverse_variance).sum();
    if weight <= 0.0 {
        return None;
    }
    let value = known()
        .map(|at| at.inverse / at.inverse_variance)
        .sum::<f64>()
        / weight;
    let scatter: f64 = known()
        .map(|at| (at.inverse - value).powi(2) / at.inverse_variance)
        .sum();
    let freedom = known().count().saturating_sub(1).max(1) as f64;
    let variance = (scatter / freedom).max(1.0) / weight;
    (value > LEAST_DETERMINED * variance.sqrt()).then_some(InverseConstant { value, variance })
}

/// How the load changes the friction: i = a·(g + mu·|g|·sign(v)) + b_v over all speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadDependence {
    /// Friction torque per torque, without unit.
    pub mu: f64,
    /// Standard deviation of mu, without unit.
    pub std_dev: f64,
    /// k_ct with this term in the model, N·m/A.
    pub torque_constant: f64,
    /// N·m/A.
    pub torque_constant_std_dev: f64,
}

/// None where the load does not vary enough to tell.
pub fn load_dependence(parts: &[Part], variance: f64) -> Option<LoadDependence> {
    // Within a speed b_v falls out with the means: normal equations of the two that are left.
    let (mut normal, mut right) = (DMatrix::<f64>::zeros(2, 2), DVector::<f64>::zeros(2));
    for group in by_speed(parts) {
        let samples: Vec<[f64; 3]> = group
            .iter()
            .flat_map(|p| {
                let pairs = p.torque.iter().zip(&p.current);
                pairs.map(|(g, i)| [*g, g.abs() * p.speed.signum(), *i])
            })
            .collect();
        let count = samples.len() as f64;
        let mean: [f64; 3] =
            std::array::from_fn(|c| samples.iter().map(|s| s[c]).sum::<f64>() / count);
        for sample in &samples {
            let x: [f64; 3] = std::array::from_fn(|c| sample[c] - mean[c]);
            for r in 0..2 {
                right[r] += x[r] * x[2];
                for c in 0..2 {
                    normal[(r, c)] += x[r] * x[c];
                }
            }
        }
    }
    let scale = normal[(0, 0)] * normal[(1, 1)];
    if scale <= 0.0 || normal.determinant() <= LEAST_VARIATION * scale {
        return None;
    }
    let covariance = normal.try_inverse()? * variance;
    let solution = &covariance * right / variance;
    let (a, m) = (solution[0], solution[1]);
    if a <= LEAST_DETERMINED * covariance[(0, 0)].sqrt() {
        return None;
    }
    let jacobian = DVector::from_vec(vec![-m / (a * a), 1.0 / a]);
    let mu_variance = (jacobian.transpose() * &covariance * &jacobian)[0];
    Some(LoadDependence {
        mu: m / a,
        std_dev: mu_variance.sqrt(),
        torque_constant: 1.0 / a,
        torque_constant_std_dev: covariance[(0, 0)].sqrt() / (a * a),
    })
}

/// Terms of the friction law over the speeds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Term {
    /// sign(v)
    Coulomb,
    /// v
    Viscous,
    /// 1
    Offset,
}

impl Term {
    fn value(self, speed: f64) -> f64 {
        match self {
            Self::Coulomb => speed.signum(),
            Self::Viscous => speed,
            Self::Offset => 1.0,
        }
    }
}

/// The second stage: friction as currents, β = friction coefficients / k_ct.
#[derive(Debug, Clone, PartialEq)]
pub struct SecondStage {
    /// The terms of the friction law, in order.
    pub terms: Vec<Term>,
    /// β, A per unit of each term.
    pub coefficients: DVector<f64>,
    /// Of a and the coefficients together, in this order.
    pub covariance: DMatrix<f64>,
}

impl SecondStage {
    /// Friction as a current at a speed, A.
    pub fn current(&self, speed: f64) -> f64 {
        let terms = self.terms.iter().zip(self.coefficients.iter());
        terms.map(|(term, beta)| beta * term.value(speed)).sum()
    }
}

/// Fits the friction law. None where the speeds do not tell its terms
/// apart, as a single speed cannot.
pub fn second_stage(
    stage: &FirstStage,
    terms: &[Term],
    inverse: InverseConstant,
) -> Option<SecondStage> {
    let InverseConstant {
        value: inverse,
        variance: inverse_variance,
    } = inverse;
    let (rows, columns) = (stage.speeds.len(), terms.len());
    if rows < columns || columns == 0 {
        return None;
    }
    let design = DMatrix::from_fn(rows, columns, |r, c| terms[c].value(stage.speeds[r].speed));
    if !tells_apart(&design) {
        return None;
    }
    let weight = |r: usize| stage.speeds[r].sums.count / stage.variance.max(f64::MIN_POSITIVE);
    let weighted = DMatrix::from_fn(rows, columns, |r, c| design[(r, c)] * weight(r));
    let inner = (design.transpose() * &weighted).try_inverse()?;
    let project = &inner * weighted.transpose();
    let load = DVector::from_fn(rows, |r, _| stage.speeds[r].sums.torque);
    let current = DVector::from_fn(rows, |r, _| stage.speeds[r].sums.current);
    let friction = current - &load * inverse;
    let coefficients = &project * &friction;
    let residual = &friction - &design * &coefficients;
    let scatter: f64 = (0..rows).map(|r| residual[r].powi(2) * weight(r)).sum();
    let freedom = rows - columns;
    let birge = if freedom == 0 {
        1.0
    } else {
        (scatter / freedom as f64).max(1.0)
    };
    // An error of a turns the mean loads into friction.
    let sensitivity = -(&project * load);
    let own = inner * birge + &sensitivity * sensitivity.transpose() * inverse_variance;
    let mut covariance = DMatrix::zeros(columns + 1, columns + 1);
    covariance[(0, 0)] = inverse_variance;
    for r in 0..columns {
        covariance[(r + 1, 0)] = sensitivity[r] * inverse_variance;
        covariance[(0, r + 1)] = covariance[(r + 1, 0)];
        for c in 0..columns {
            covariance[(r + 1, c + 1)] = own[(r, c)];
        }
    }
    Some(SecondStage {
        terms: terms.to_vec(),
        coefficients,
        covariance,
    })
}

/// Whether the columns differ by more than the spread within one speed.
fn tells_apart(design: &DMatrix<f64>) -> bool {
    let mut scaled = design.clone();
    for mut column in scaled.column_iter_mut() {
        let norm = column.norm();
        if norm > 0.0 {
            column /= norm;
        }
    }
    scaled.singular_values().min() > SAME_SPEED
}
