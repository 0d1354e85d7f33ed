//! The weight of the prior on the bodies: given, by cross-validation on blocks of the training recordings, or by the discrepancy
//! principle, so that the residual is as large as the noise.

use crate::chain::dataset::Dataset;
use crate::estimate::derived::goodness_of_fit::noise_rms;
use crate::estimate::error::EstimateError;
use crate::estimate::feasible::solve::{self, Compressed, Setting, compressed};
use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::residual::compress::{Request, factor};
use crate::estimate::residual::weights::RowFactors;
use crate::linalg::triangular::Triangular;
use crate::outcome::feasibility::HeldOut;
use crate::problem::solution::Control;
use crate::problem_file::fit::RegularisationWeight;
use nalgebra::DVector;

/// Blocks of rows, each held out in turn.
const BLOCKS: usize = 5;

/// Weights that are tried, powers of ten.
const POWERS: std::ops::RangeInclusive<i32> = -4..=6;

/// Halvings of the interval of the weight that the noise decides.
const HALVINGS: usize = 12;

/// A weight and why.
#[derive(Debug, Clone)]
pub struct ChosenWeight {
    pub weight: f64,
    pub by: &'static str,
    pub path: Vec<HeldOut>,
}

/// Base unknowns at which a problem is linearised.
#[derive(Clone, Copy)]
pub struct FitPoint<'a> {
    pub problem: &'a FitProblem<'a>,
    pub at: &'a DVector<f64>,
}

/// The weight of the prior of a setting, for weights and a linearisation at base unknowns.
pub fn choose(
    setting: Setting<'_>,
    point: FitPoint<'_>,
    choice: RegularisationWeight,
    data: &Dataset,
    control: &Control<'_>,
) -> Result<ChosenWeight, EstimateError> {
    match choice {
        RegularisationWeight::Number(weight) => Ok(ChosenWeight {
            weight,
            by: "number",
            path: Vec::new(),
        }),
        RegularisationWeight::HeldOut => held_out(setting, point, control),
        RegularisationWeight::Noise => by_noise(setting, point, data, control),
    }
}

fn with(setting: Setting<'_>, weight: f64) -> Setting<'_> {
    Setting {
        prior: setting.prior.map(|(prior, _)| (prior, weight)),
        ..setting
    }
}

fn held_out(
    setting: Setting<'_>,
    FitPoint { problem, at }: FitPoint<'_>,
    control: &Control<'_>,
) -> Result<ChosenWeight, EstimateError> {
    let blocks = blocks(problem, at);
    let mut path = Vec::new();
    for power in POWERS {
        let weight = 10f64.powi(power);
        let mut error = 0.0;
        for (held, block) in blocks.iter().enumerate() {
            let mut rest = Triangular::new(block.columns());
            for (_, other) in blocks.iter().enumerate().filter(|(k, _)| *k != held) {
                rest.merge(other);
            }
            let residual = system(&rest, at);
            let found = solve::estimate(with(setting, weight), &residual, control)?;
            error += 2.0 * system(block, at).cost(&(&setting.standard.to_base * found.x));
        }
        path.push(HeldOut {
            strength: weight,
            error,
        });
    }
    let best = path.iter().min_by(|a, b| a.error.total_cmp(&b.error));
    Ok(ChosenWeight {
        weight: best.map_or(1.0, |b| b.strength),
        by: "held_out",
        path,
    })
}

/// Factors of consecutive blocks of the rows of every recording, linearised at base unknowns.
fn blocks(problem: &FitProblem<'_>, at: &DVector<f64>) -> Vec<Triangular> {
    let values = problem.parameters(at);
    let columns = problem.unknowns.positions();
    (0..BLOCKS)
        .map(|block| {
            let of = |(k, recording): (usize, &&crate::chain::dataset::Prepared)| {
                let rows = recording.rows();
                let channels = 0..problem.model.channels().len();
                let one = |channel: usize| {
                    let own = problem.factors.as_ref().map(|f| &f[k][channel]);
                    let inside = |row: usize| row * BLOCKS / rows == block;
                    let factor = |row: usize| own.map_or(1.0, |f| f[row]);
                    (0..rows)
                        .map(|row| if inside(row) { factor(row) } else { 0.0 })
                        .collect()
                };
                channels.map(one).collect()
            };
            let factors: RowFactors = problem.recordings.iter().enumerate().map(of).collect();
            let request = Request {
                model: problem.model,
                values: &values,
                columns: &columns,
                weights: problem.weights(),
                factors: Some(&factors),
                bodies: &[],
            };
            factor(&request, problem.recordings)
        })
        .collect()
}

/// The least squares problem over base unknowns of a factor linearised at some of them.
fn system(factor: &Triangular, at: &DVector<f64>) -> Compressed {
    let whole = factor.matrix();
    let count = at.len();
    let matrix = whole.columns(0, count).into_owned();
    let residual = whole.column(count).into_owned();
    Compressed {
        offset: residual - &matrix * at,
        matrix,
    }
}

/// The largest weight at which the residual of no channel exceeds the noise by more than least squares
/// makes it, found between the ends of the path by halving.
fn by_noise(
    setting: Setting<'_>,
    FitPoint { problem, at }: FitPoint<'_>,
    data: &Dataset,
    control: &Control<'_>,
) -> Result<ChosenWeight, EstimateError> {
    let noise = noise_rms(problem.model, &problem.parameters(at), data)
        .ok_or(EstimateError::NoNoiseLevel)?;
    let residual = compressed(problem, at)?;
    let excess = |x: &DVector<f64>| {
        let base = &setting.standard.to_base * x;
        let series = problem.counted_residuals(&base);
        let mut largest: f64 = 0.0;
        for (c, level) in noise.iter().enumerate() {
            let all = series
                .iter()
                .flat_map(|r| r[c].iter().filter(|e| **e != 0.0));
            let (sum, count) = all.fold((0.0, 0.0), |(s, n), e| (s + e * e, n + 1.0));
            if count > 0.0 && *level > 0.0 {
                largest = largest.max(sum / count / (level * level));
            }
        }
        largest
    };
    let (mut low, mut high) = (f64::from(*POWERS.start()), f64::from(*POWERS.end()));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let tried = with(setting, 10f64.powf(middle));
        let found = solve::estimate(tried, &residual, control)?;
        if excess(&found.x) <= 1.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(ChosenWeight {
        weight: 10f64.powf(low),
        by: "noise",
        path: Vec::new(),
    })
}
