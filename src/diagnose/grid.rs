//! Points of the nonlinear parameters from which a hypothesis is examined.

use crate::chain::dataset::Prepared;
use crate::chain::effect::{Effect, Linearity, Search};
use crate::chain::model::Model;
use crate::chain::parameter::Role;
use std::f64::consts::{PI, TAU};

/// What a joint did in recordings, as far as searches depend on it.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    pub least: f64,
    pub greatest: f64,
    pub fastest: f64,
    /// s.
    pub duration: f64,
    /// rad/s or m/s over the rate: the longest way between two rows.
    pub longest_step: f64,
}

impl Motion {
    pub fn of(recordings: &[&Prepared], joint: usize) -> Self {
        let mut motion = Self {
            least: f64::INFINITY,
            greatest: f64::NEG_INFINITY,
            fastest: 0.0,
            duration: 0.0,
            longest_step: 0.0,
        };
        for recording in recordings {
            let trajectory = recording.segment().motors;
            for q in &trajectory.q[joint] {
                motion.least = motion.least.min(*q);
                motion.greatest = motion.greatest.max(*q);
            }
            for v in &trajectory.dq[joint] {
                motion.fastest = motion.fastest.max(v.abs());
            }
            let rate = recording.experiment.rate_hz / recording.stride as f64;
            motion.longest_step = motion.longest_step.max(motion.fastest / rate);
            motion.duration = motion.duration.max(recording.rows() as f64 / rate);
        }
        motion
    }
}

/// A linear parameter at this share of its typical value lets the derivatives with respect to the nonlinear
/// ones behind it be seen, and changes nothing else.
const GLIMPSE: f64 = 1e-3;

/// Cycles over the range of positions between one order and the next: half of what tells two apart.
const CYCLES: f64 = 0.5;

/// Where parameters of a hypothesis may lie, joint by joint alike.
#[derive(Debug, Clone)]
pub struct Grid {
    kinds: Vec<Kind>,
    /// Of each own parameter, the kind.
    of: Vec<usize>,
}

/// The parameters of one name.
#[derive(Debug, Clone)]
struct Kind {
    parameter: Option<usize>,
    linear: Option<f64>,
    values: Vec<f64>,
    scanned: bool,
}

impl Grid {
    /// The grid of the `own` parameters of an effect, with the motion of its joint.
    pub fn new(model: &Model, own: &[usize], (effect, motion): (&Effect, &Motion)) -> Self {
        let mut kinds: Vec<Kind> = Vec::new();
        let mut of = Vec::new();
        for &p in own {
            let parameter = &model.parameters()[p];
            let number = match parameter.role {
                Role::Effect { parameter, .. } => Some(parameter),
                _ => None,
            };
            let known = kinds
                .iter()
                .position(|k| number.is_some() && k.parameter == number);
            of.push(known.unwrap_or(kinds.len()));
            if known.is_some() {
                continue;
            }
            let search = number
                .and_then(|k| effect.parameters.get(k))
                .map_or(Search::Typical, |info| info.search);
            let linear = parameter.linearity == Linearity::Linear;
            kinds.push(Kind {
                parameter: number,
                linear: linear.then_some(GLIMPSE * parameter.scale),
                values: match linear {
                    true => vec![0.0],
                    false => {
                        motion.values(search, (parameter.value, parameter.lower, parameter.upper))
                    }
                },
                scanned: search == Search::Cycles,
            });
        }
        Self { kinds, of }
    }

    /// Points of what is scanned alone, with everything else at its first value; empty where nothing is.
    pub fn scan(&self) -> Vec<Vec<f64>> {
        if self.kinds.iter().all(|kind| !kind.scanned) {
            return Vec::new();
        }
        let choices = self
            .kinds
            .iter()
            .map(|kind| match (kind.scanned, kind.linear) {
                (true, _) => kind.values.clone(),
                (false, Some(glimpse)) => vec![glimpse],
                (false, None) => vec![kind.values[0]],
            });
        self.points(choices.collect())
    }

    /// All points; what was scanned stays where `scanned` has it.
    pub fn all(&self, scanned: Option<&[f64]>) -> Vec<Vec<f64>> {
        let choices = self.kinds.iter().enumerate().map(|(k, kind)| {
            let at = self.of.iter().position(|of| *of == k);
            match (scanned, kind.scanned, at) {
                (Some(point), true, Some(at)) => vec![point[at]],
                _ => kind.values.clone(),
            }
        });
        self.points(choices.collect())
    }

    /// Every combination of the choices, one value per own parameter.
    fn points(&self, choices: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let mut points = vec![Vec::new()];
        for values in &choices {
            let longer = |point: Vec<f64>| {
                values.iter().map(move |x| {
                    let mut longer = point.clone();
                    longer.push(*x);
                    longer
                })
            };
            points = points.into_iter().flat_map(longer).collect();
        }
        let spread = |point: Vec<f64>| self.of.iter().map(|&kind| point[kind]).collect();
        points.into_iter().map(spread).collect()
    }
}

impl Motion {
    /// Values to try of a parameter that starts at `value` and stays between limits.
    fn values(&self, search: Search, (value, lower, upper): (f64, f64, f64)) -> Vec<f64> {
        let range = self.greatest - self.least;
        let shares = |shares: &[f64], of: f64, from: f64| -> Vec<f64> {
            shares.iter().map(|share| from + share * of).collect()
        };
        let mut values = match search {
            Search::Typical => vec![value],
            Search::Values(values) => values.to_vec(),
            Search::Position(of) => shares(of, range, self.least),
            Search::Range(of) => shares(of, range, 0.0),
            Search::Speed(of) => shares(of, self.fastest, 0.0),
            Search::Duration(of) => shares(of, self.duration, 0.0),
            Search::Cycles => {
                let step = TAU * CYCLES / range;
                let most = PI / self.longest_step;
                let count = ((most / step) as usize).min(MOST_ORDERS);
                (2..=count).map(|k| k as f64 * step).collect()
            }
        };
        values.retain(|x| x.is_finite() && (lower..=upper).contains(x));
        if values.is_empty() {
            values.push(value);
        }
        values
    }
}

/// Orders that are scanned at most.
const MOST_ORDERS: usize = 600;
