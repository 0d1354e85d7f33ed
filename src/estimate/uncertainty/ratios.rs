//! Parameters that are determined only in ratio to a controller's gain, and what is known of them.
//!
//! Of the signal `s = (τ_mot + kd (ṁ − v_c) − u) / kp` every part of τ_mot that is unknown may scale with kp, and with it a
//! known one of the same shape: kd beside viscous friction, the inertia of a known link beside that of a rotor. Then
//!
//! ```text
//! s(λ kp, λ (θ + c) − c) = s(kp, θ)      only y = (θ + c) / kp is determined
//! y = dθ/dkp along that direction,  c = y kp − θ
//! σ_y² = (σ_θ² − 2 y σ_θ,kp + y² σ_kp²) / kp²
//! ```
//!
//! A gain is open where its column depends on those of the other unknowns, and where the interval of 1/kp, in which the
//! signal is linear, holds zero: kp is then not bounded.

use crate::chain::base_parameters::significant;
use crate::chain::model::{Inertials, Model};
use crate::chain::parameter::Role;
use crate::estimate::fit_problem::problem::FitProblem;
use crate::outcome::fit::BaseParameter;
use crate::stats::distribution::Distribution;
use nalgebra::{DMatrix, DVector};

/// A gain of which nothing tells the size.
#[derive(Debug, Clone)]
pub(crate) struct OpenGain {
    /// Position of the gain in the model.
    gain: usize,
    /// Its value in the estimate.
    value: f64,
    /// Its place among the unknowns, if it has one.
    unknown: Option<usize>,
    /// What scales with it.
    scaled: Vec<Scaled>,
}

/// An unknown that scales with a gain, together with what is known beside it.
#[derive(Debug, Clone, Copy)]
struct Scaled {
    /// Its place among the unknowns.
    unknown: usize,
    /// y, its change by that of the gain where the signal stays.
    ratio: f64,
    /// c.
    known: f64,
}

impl Scaled {
    /// `least` is the size of c below which it is an error and there is none.
    fn of(unknown: usize, ratio: f64, known: f64, least: f64) -> Self {
        Self {
            unknown,
            ratio,
            known: if known.abs() <= least { 0.0 } else { known },
        }
    }

    /// θ + c by the name of θ.
    fn sum(&self, name: &str) -> String {
        let sum = match self.known {
            0.0 => name.to_string(),
            c if c < 0.0 => format!("{name} - {}", significant(-c)),
            c => format!("{name} + {}", significant(c)),
        };
        match sum.contains(' ') {
            true => format!("({sum})"),
            false => sum,
        }
    }
}

/// Share of what a gain makes of the signal that is rounding.
const ROUNDING: f64 = 1e-6;

/// Share of the variance of an unknown that is the gain's, from which on it is its ratio to the gain that is known.
const MOSTLY: f64 = 0.5;

/// The open gains of an estimate with the covariance of its unknowns.
pub(crate) fn find(
    problem: &FitProblem<'_>,
    x: &DVector<f64>,
    covariance: &DMatrix<f64>,
) -> Vec<OpenGain> {
    let model = problem.model;
    let positions = problem.unknowns.positions();
    let values = problem.parameters(x);
    let gains = model.joints().iter().filter_map(|joint| joint.controller);
    let free = gains.filter(|&gain| model.parameters()[gain].is_free());
    let open = |gain: usize| {
        let unknown = positions.iter().position(|&p| p == gain);
        let scaled = match unknown {
            None => dependent(problem, x, gain, values[gain]),
            Some(k) => correlated(x, covariance, k)?,
        };
        Some(OpenGain {
            gain,
            value: values[gain],
            unknown,
            scaled,
        })
    };
    free.filter_map(open).collect()
}

/// Unknowns that change along the direction in which nothing but the gain and they change, and the signal does not.
fn dependent(problem: &FitProblem<'_>, x: &DVector<f64>, gain: usize, value: f64) -> Vec<Scaled> {
    let count = x.len();
    let whole = problem.factor_over(x, &[gain]).matrix();
    let own = whole.view((0, 0), (count, count)).into_owned();
    let column = whole.view((0, count), (count, 1)).into_owned();
    match own.solve_upper_triangular(&column) {
        Some(slopes) => (0..count)
            .filter(|&k| {
                let share = slopes[(k, 0)].abs() * own.column(k).norm();
                share > ROUNDING * column.norm()
            })
            .map(|k| {
                let ratio = -slopes[(k, 0)];
                let whole = ratio * value;
                Scaled::of(k, ratio, whole - x[k], ROUNDING * whole.abs())
            })
            .collect(),
        None => (0..count)
            .map(|k| Scaled::of(k, x[k] / value, 0.0, 0.0))
            .collect(),
    }
}

/// Unknowns that vary with a gain whose inverse may be zero; `None` where it may not.
fn correlated(x: &DVector<f64>, covariance: &DMatrix<f64>, gain: usize) -> Option<Vec<Scaled>> {
    let variance = covariance[(gain, gain)];
    let quantile = Distribution::Normal.two_sided(0.95);
    if x[gain] > quantile * variance.max(0.0).sqrt() {
        return None;
    }
    let share = |k: usize| covariance[(k, gain)].powi(2) / (covariance[(k, k)] * variance);
    Some(
        (0..x.len())
            .filter(|&k| k != gain && share(k) > MOSTLY)
            .map(|k| {
                let ratio = covariance[(k, gain)] / variance;
                // What is left of its variance where the gain is known.
                let own = covariance[(k, k)] - ratio * covariance[(k, gain)];
                let least = quantile * own.max(0.0).sqrt();
                Scaled::of(k, ratio, ratio * x[gain] - x[k], least)
            })
            .collect(),
    )
}

/// The covariance with infinite variance of what is known in ratio to open gains alone.
pub(crate) fn without_scaled(mut covariance: DMatrix<f64>, open: &[OpenGain]) -> DMatrix<f64> {
    for gain in open {
        let scaled = gain.scaled.iter().map(|scaled| scaled.unknown);
        for k in scaled.chain(gain.unknown) {
            covariance[(k, k)] = f64::INFINITY;
        }
    }
    covariance
}

/// Puts ratios to open gains in the place of base parameters that scale with them, `base` being in the order of the
/// unknowns; those of unknowns that are not linear come behind.
pub(crate) fn in_ratio(
    mut base: Vec<BaseParameter>,
    problem: &FitProblem<'_>,
    covariance: &DMatrix<f64>,
    open: &[OpenGain],
) -> Vec<BaseParameter> {
    let positions = problem.unknowns.positions();
    let parameters = problem.model.parameters();
    let quantile = Distribution::Normal.two_sided(0.95);
    let linear = base.len();
    let mut done: Vec<usize> = Vec::new();
    for gain in open {
        for scaled in &gain.scaled {
            let (k, ratio) = (scaled.unknown, scaled.ratio);
            if done.contains(&k) {
                continue;
            }
            done.push(k);
            let own = covariance[(k, k)];
            let variance = gain.unknown.map_or(own, |g| {
                own - 2.0 * ratio * covariance[(k, g)] + ratio * ratio * covariance[(g, g)]
            });
            let std_dev = variance.max(0.0).sqrt() / gain.value;
            let parameter = &parameters[positions[k]];
            let own_name = base.get(k).map_or(&parameter.name, |b| &b.expression);
            let expression = scaled.sum(own_name);
            let entry = BaseParameter {
                expression: format!("{expression} / {}", parameters[gain.gain].name),
                unit: unit(&parameter.unit, &parameters[gain.gain].unit),
                value: Some(ratio),
                std_dev: Some(std_dev),
                ci95: Some([ratio - quantile * std_dev, ratio + quantile * std_dev]),
            };
            match k < linear {
                true => base[k] = entry,
                false => base.push(entry),
            }
        }
    }
    base
}

/// Unit of a ratio to a gain.
fn unit(own: &str, gain: &str) -> String {
    let known = match (own, gain) {
        (a, b) if a == b => "1",
        ("N·m", "N·m/rad") => "rad",
        ("N", "N/m") => "m",
        ("N·m·s/rad", "N·m/rad") | ("N·s/m", "N/m") => "s",
        ("kg·m²", "N·m/rad") | ("kg", "N/m") => "s²",
        _ => return format!("({own})/({gain})"),
    };
    known.to_string()
}

/// What a reader should know of open gains, one sentence for each.
pub(crate) fn notes(model: &Model, open: &[OpenGain], positions: &[usize]) -> Vec<String> {
    let inertial = |p: &usize| model.parameters()[*p].role.is_inertial();
    let bodies = match positions.iter().any(inertial) {
        true => Inertials::Estimate,
        false => Inertials::Known,
    };
    let of = |gain: &OpenGain| {
        let parameters = model.parameters();
        let name = &parameters[gain.gain].name;
        let joint = match parameters[gain.gain].role {
            Role::Controller { joint, .. } => joint,
            _ => 0,
        };
        let remedy = match bodies {
            Inertials::Estimate => "nothing that it carries is known, and all of it scales with the gain".to_string(),
            Inertials::Known => {
                "the torque of its known links is too small beside the rest, or too like that of friction, rotor \
                 inertia and offset in this motion"
                    .to_string()
            }
        };
        let others: Vec<&str> = (model.joints().iter().enumerate())
            .filter(|(j, other)| *j != joint && other.controller.is_some())
            .map(|(_, other)| other.name.as_str())
            .collect();
        let sibling = match others.first() {
            Some(other) => format!(
                ", the gain of a joint with the same motor and controller (is {other} one?)"
            ),
            None => String::new(),
        };
        format!(
            "{name} is not determined: {remedy}. What scales with it is given as a ratio to it. A known mass or \
             payload would determine it, a posture in which gravity acts on the axis of {}{sibling}, or a prior: \
             controller.kp = {{ value, std_dev }}.",
            model.joints()[joint].name,
        )
    };
    open.iter().map(of).collect()
}
