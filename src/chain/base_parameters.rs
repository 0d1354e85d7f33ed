//! Base parameters: the combinations of linear parameters that the signal depends on.
//!
//! The linear unknowns are scanned in the project's order (links from the first on, Pinocchio's entries;
//! then rotor inertias; then friction and the rest) over generic states, and each column that is
//! independent of those kept before is kept: `Y_dependent = Y_kept C`, so that the signal sees only
//! `β = π_kept + C π_dependent` (Gautier 1990, numerical QR; here without pivoting, which would make the
//! basis depend on rounding). States come from a fixed seed, so the basis is the same on every machine.

use crate::chain::controller::Commands;
use crate::chain::effect::knowledge::JointTerm;
use crate::chain::evaluate::{BLOCK, Evaluator, Segment};
use crate::chain::model::Model;
use crate::chain::parameter::Role;
use crate::linalg::triangular::Triangular;
use crate::robot::batch::Trajectory;
use crate::robot::random::{generator, symmetric};
use nalgebra::DMatrix;
use rand_chacha::ChaCha8Rng;

/// A column counts as independent when the part that the columns kept before do not explain exceeds
/// this share of it. Rounding leaves 1e-14; the smallest lengths of real robots, 1e-4 of the largest,
/// leave 1e-8 where they enter squared.
const INDEPENDENT: f64 = 1e-9;

/// Shares of the largest column below which a column is rounding: a parameter without effect.
pub const NEGLIGIBLE: f64 = 1e-12;

/// Coefficients of combinations below this are rounding.
const COEFFICIENT_ROUNDING: f64 = 1e-9;

/// Ranges of the generic states, rad, rad/s, rad/s² (and metres).
const RANGES: [f64; 3] = [3.0, 2.0, 8.0];

/// One base parameter: the kept parameter and what it stands for.
#[derive(Debug, Clone, PartialEq)]
pub struct BaseParameter {
    /// Position of the kept parameter in the model.
    pub parameter: usize,
    /// (position, coefficient) of the dependent parameters that enter with it.
    pub others: Vec<(usize, f64)>,
}

/// The base parameters of a model.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BaseParameters {
    /// The independent ones, in the order of the scan; each stands for the dependent ones behind it.
    pub base: Vec<BaseParameter>,
    /// Linear unknowns that have no effect on the signal at all.
    pub without_effect: Vec<usize>,
}

impl BaseParameters {
    /// Scans the linear unknowns of a model over generic states.
    ///
    /// `loads` says with which loads the recordings are made: without it, with it, or both. `prior` has
    /// further rows over all parameters, combinations that are known from elsewhere.
    pub fn structural(model: &Model, loads: &[bool], prior: &DMatrix<f64>) -> Self {
        let unknowns = scan_order(model);
        let mut factor = generic_factor(model, &unknowns, loads);
        factor.absorb(prior.select_columns(&unknowns).as_slice());
        Self::scan(&factor, &unknowns)
    }

    /// Scans the columns of a triangular factor; `unknowns` are the parameters of its columns.
    pub fn scan(factor: &Triangular, unknowns: &[usize]) -> Self {
        Self::scan_above(factor, unknowns, NEGLIGIBLE)
    }

    /// The same where a column below another share of the largest one has no effect.
    pub fn scan_above(factor: &Triangular, unknowns: &[usize], negligible: f64) -> Self {
        let norms = factor.column_norms();
        let largest = norms.iter().copied().fold(0.0, f64::max);
        let (effective, without): (Vec<usize>, Vec<usize>) =
            (0..unknowns.len()).partition(|&k| norms[k] > negligible * largest);
        // Columns of one size: the tolerance is a share of each.
        let scaled = DMatrix::from_fn(factor.columns(), effective.len(), |i, k| {
            factor.entry(i, effective[k]) / norms[effective[k]]
        });
        let split = Triangular::of(&scaled).independent_columns(INDEPENDENT);
        let base = split
            .kept
            .iter()
            .enumerate()
            .map(|(row, &kept)| {
                let kept = effective[kept];
                let others = split.dependent.iter().enumerate().filter_map(|(k, &d)| {
                    let d = effective[d];
                    let coefficient = split.coefficients[(row, k)] * norms[d] / norms[kept];
                    (coefficient.abs() > COEFFICIENT_ROUNDING).then_some((unknowns[d], coefficient))
                });
                BaseParameter {
                    parameter: unknowns[kept],
                    others: others.collect(),
                }
            })
            .collect();
        Self {
            base,
            without_effect: without.iter().map(|&k| unknowns[k]).collect(),
        }
    }

    /// Positions of the kept parameters.
    pub fn kept(&self) -> Vec<usize> {
        self.base.iter().map(|b| b.parameter).collect()
    }

    /// Whether the data determine a parameter by itself.
    pub fn determines(&self, parameter: usize) -> bool {
        self.base
            .iter()
            .any(|b| b.parameter == parameter && b.others.is_empty())
    }

    /// `link1.Izz + 0.07·link3.mcz − ...`
    pub fn expression(&self, model: &Model, index: usize) -> String {
        let base = &self.base[index];
        let name = |p: usize| model.parameters()[p].name.as_str();
        let mut text = name(base.parameter).to_string();
        for &(parameter, coefficient) in &base.others {
            let sign = if coefficient < 0.0 { '-' } else { '+' };
            let size = significant(coefficient.abs());
            let factor = if size == "1" {
                String::new()
            } else {
                format!("{size}*")
            };
            text.push_str(&format!(" {sign} {factor}{}", name(parameter)));
        }
        text
    }
}

/// Seven significant digits without trailing zeros: enough to compute with, stable to read.
pub(crate) fn significant(x: f64) -> String {
    let digits = (6 - x.log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        text
    }
}

/// The tare of a platform and the links first, then rotor inertias, then everything else, each in the model's order.
pub fn scan_order(model: &Model) -> Vec<usize> {
    let rank = |p: &usize| match model.parameters()[*p].role {
        // A weight that no motion changes is the platform's as well: it goes into the tare.
        Role::Tare { .. } => 0,
        Role::Inertial { .. } => 1,
        Role::Payload { .. } => 2,
        Role::Effect { joint, effect, .. } => {
            let (effect, _) = model.joints()[joint].effects[effect];
            match effect.knowledge.term {
                Some(JointTerm::RotorInertia) => 3,
                _ => 4,
            }
        }
        Role::Coupling { .. } | Role::Crosstalk(_) | Role::Tilt { .. } => 5,
        Role::Controller { .. } => 6,
    };
    let mut unknowns: Vec<usize> = (0..model.parameters().len())
        .filter(|&p| model.parameters()[p].is_linear_unknown())
        .collect();
    unknowns.sort_by_key(rank);
    unknowns
}

/// Random states of the joints, `[derivative][joint][sample]`.
fn states(model: &Model, rng: &mut ChaCha8Rng) -> [Vec<Vec<f64>>; 3] {
    let n = model.tree().len();
    if let Some(mechanism) = model.mechanism() {
        let mut motion = [(); 3].map(|()| vec![vec![0.0; BLOCK]; n]);
        for sample in 0..BLOCK {
            let state = mechanism.draw(rng, [RANGES[1], RANGES[2]]);
            for (series, values) in motion.iter_mut().zip(state) {
                series
                    .iter_mut()
                    .zip(values)
                    .for_each(|(s, x)| s[sample] = x);
            }
        }
        return motion;
    }
    let mut motion = RANGES.map(|range| {
        let mut series = || {
            (0..BLOCK)
                .map(|_| symmetric(rng, range))
                .collect::<Vec<f64>>()
        };
        (0..n).map(|_| series()).collect::<Vec<_>>()
    });
    for (j, joint) in model.joints().iter().enumerate() {
        if joint.locked {
            // Locked joints stand at their offset: motor position zero, at rest.
            for series in &mut motion {
                series[j].fill(0.0);
            }
        }
    }
    motion
}

/// Random commands of controllers, where there are any: recordings without them merge what only they tell apart.
fn commands(model: &Model, rng: &mut ChaCha8Rng) -> Option<Commands> {
    let is_controlled = model
        .joints()
        .iter()
        .any(|joint| joint.controller.is_some());
    is_controlled.then(|| {
        let mut series = |range| -> Vec<Vec<f64>> {
            let samples = |_| (0..BLOCK).map(|_| symmetric(rng, range)).collect();
            model.joints().iter().map(samples).collect()
        };
        Commands {
            velocity: series(RANGES[1]),
            feed_forward: Vec::new(),
        }
    })
}

fn generic_factor(model: &Model, unknowns: &[usize], loads: &[bool]) -> Triangular {
    let mut rng = generator(0);
    let blocks = 1 + 3 * unknowns.len() / BLOCK;
    let mut factor = Triangular::new(unknowns.len());
    let mut evaluator = Evaluator::new(model, &model.generic_values(), unknowns);
    let zeros = vec![0.0; BLOCK];
    for _ in 0..blocks {
        let motion = states(model, &mut rng);
        let [q, dq, ddq] = &motion;
        let commands = commands(model, &mut rng);
        for &loaded in loads {
            let segment = Segment {
                commands: commands.as_ref().map(|all| all.from_sample(0)),
                ..Segment::states(Trajectory { q, dq, ddq }, loaded)
            };
            let block = evaluator.evaluate(segment, 0..BLOCK);
            for (c, channel) in model.channels().iter().enumerate() {
                if channel.active {
                    let columns: Vec<&[f64]> = (0..unknowns.len())
                        .map(|k| block.derivative(c, k).unwrap_or(&zeros))
                        .collect();
                    factor.absorb_columns(&columns);
                }
            }
        }
    }
    factor
}
