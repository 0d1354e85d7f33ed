//! The location of the misfit of a joint: the covariates over which its residual is not zero on average.
//!
//! The mean residual in bins of a variable, of equally many fitted rows each, forecasts the residual of rows that
//! were not fitted; the share of energy that it takes from them is what the variable explains.

use crate::diagnose::fit::channel_series::ChannelSeries;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::covariates::{Covariate, Covariates};
use crate::outcome::diagnose::{CurvePoint, Located};
use crate::recording::split::Split;
use crate::stats::encompassing::{Known, ResidualPair, ResidualRows};

/// Bins of a variable, for either direction.
const BINS: usize = 16;

/// Variables that explain less of the residual's energy say little about where it lies.
const LEAST_SHARE: f64 = 0.05;

/// Variables that are named for one joint.
const MOST_VARIABLES: usize = 4;

/// Share of what a variable explains that the range named for it holds.
const BULK: f64 = 0.6;

/// Covariates over which the residuals of a model lie, the largest share of each joint first.
pub fn locate(context: &Context<'_>, fit: &ModelFit, significance: f64) -> Vec<Located> {
    let (train, held_out) = (
        context.recordings(Split::Train),
        context.recordings(Split::Validation),
    );
    let model = &fit.model;
    let fitted = ChannelSeries::of(model, &fit.values, &[], &train);
    let tested = ChannelSeries::of(model, &fit.values, &[], &held_out);
    let mut located = Vec::new();
    for (c, channel) in model.channels().iter().enumerate() {
        if !channel.active {
            continue;
        }
        let of_train = Covariates::of(model, c, &fitted.loads, &train);
        let of_held_out = Covariates::of(model, c, &tested.loads, &held_out);
        let (Some(of_train), Some(of_held_out)) = (of_train, of_held_out) else {
            continue;
        };
        let count = of_train.variables.len();
        let mut found: Vec<Located> = (0..count)
            .filter_map(|k| {
                let seen = Seen {
                    variable: &of_train.variables[k],
                    direction: &of_train.direction,
                    residual: &fit.train[c],
                };
                let unseen = Seen {
                    variable: &of_held_out.variables[k],
                    direction: &of_held_out.direction,
                    residual: &fit.validation[c],
                };
                let level = significance / count as f64;
                one(
                    &channel.name,
                    &seen,
                    &unseen,
                    level,
                    context.residual_rows(),
                )
            })
            .collect();
        found.sort_by(|a, b| b.share.total_cmp(&a.share));
        found.truncate(MOST_VARIABLES);
        located.extend(found);
    }
    located
}

/// A variable with the residual over the same rows.
struct Seen<'a> {
    variable: &'a Covariate,
    direction: &'a [f64],
    residual: &'a [f64],
}

fn one(
    joint: &str,
    train: &Seen<'_>,
    held_out: &Seen<'_>,
    level: f64,
    rows: ResidualRows,
) -> Option<Located> {
    let edges = edges(&train.variable.values);
    let curve = Curve::of(train, &edges);
    let forecast: Vec<f64> = (0..held_out.residual.len())
        .map(|k| held_out.residual[k] - curve.at(held_out, k, &edges))
        .collect();
    let energy = |e: &[f64]| e.iter().map(|x| x * x).sum::<f64>();
    let share = 1.0 - energy(&forecast) / energy(held_out.residual);
    let pair = ResidualPair {
        poorer: &[held_out.residual.to_vec()],
        richer: &[forecast],
    };
    let evidence = pair.encompassing(Known::default(), rows);
    if share < LEAST_SHARE || evidence.p_value > level {
        return None;
    }
    let [first, last] = curve.bulk();
    let (low, high) = (edges[first], edges[last + 1]);
    let variable = train.variable;
    let sentence = format!(
        "{joint}: {} explains {:.0} % of what the declared model leaves, most of it between {low:.3} and {high:.3} {}",
        words(&variable.name),
        100.0 * share,
        variable.unit
    );
    Some(Located {
        joint: joint.to_string(),
        variable: variable.name.clone(),
        unit: variable.unit.to_string(),
        low,
        high,
        share,
        sentence,
        curve: curve.points(&edges),
    })
}

fn words(variable: &str) -> &str {
    match variable {
        "time" => "the time within the recording",
        "reversal" => "the distance since the last reversal",
        "load" => "the transmitted load",
        other => other,
    }
}

/// Bounds of bins that hold equally many values.
fn edges(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1);
    (0..=BINS)
        .map(|b| sorted.get(b * last / BINS).copied().unwrap_or(0.0))
        .collect()
}

fn bin(edges: &[f64], value: f64) -> usize {
    let above = edges[1..BINS].iter().filter(|edge| value >= **edge).count();
    above.min(BINS - 1)
}

/// Of the residual in one bin.
#[derive(Debug, Clone, Copy, Default)]
struct BinSums {
    sum: f64,
    squares: f64,
    rows: f64,
}

/// Sums of the residual in the bins of both directions, `[direction][bin]`.
struct Curve {
    sums: [[BinSums; BINS]; 2],
}

impl Curve {
    fn of(seen: &Seen<'_>, edges: &[f64]) -> Self {
        let mut sums = [[BinSums::default(); BINS]; 2];
        for (k, e) in seen.residual.iter().enumerate() {
            let place = &mut sums[side(seen, k)][bin(edges, seen.variable.values[k])];
            place.sum += e;
            place.squares += e * e;
            place.rows += 1.0;
        }
        Self { sums }
    }

    fn mean(&self, side: usize, bin: usize) -> f64 {
        let BinSums { sum, rows, .. } = self.sums[side][bin];
        if rows > 0.0 { sum / rows } else { 0.0 }
    }

    fn at(&self, seen: &Seen<'_>, k: usize, edges: &[f64]) -> f64 {
        self.mean(side(seen, k), bin(edges, seen.variable.values[k]))
    }

    /// The first and the last bin of the shortest run with the bulk of what the means explain.
    fn bulk(&self) -> [usize; 2] {
        let energy = |b: usize| -> f64 {
            let of = |side: usize| self.sums[side][b].rows * self.mean(side, b).powi(2);
            of(0) + of(1)
        };
        let total: f64 = (0..BINS).map(energy).sum();
        for length in 1..BINS {
            let best = (0..=BINS - length)
                .map(|first| (first, (first..first + length).map(energy).sum::<f64>()))
                .max_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((first, _)) = best.filter(|(_, sum)| *sum >= BULK * total) {
                return [first, first + length - 1];
            }
        }
        [0, BINS - 1]
    }

    /// Recorded minus predicted over the middles of the bins, both directions together.
    fn points(&self, edges: &[f64]) -> Vec<CurvePoint> {
        let of = |b: usize| {
            let [back, forth] = [0, 1].map(|side| self.sums[side][b]);
            // Without regard to direction a friction would cancel: it is turned along the motion.
            let (sum, squares) = (back.sum - forth.sum, back.squares + forth.squares);
            let rows = f64::max(back.rows + forth.rows, 1.0);
            CurvePoint {
                at: 0.5 * (edges[b] + edges[b + 1]),
                mean: sum / rows,
                std_error: (squares / rows).sqrt() / rows.sqrt(),
            }
        };
        (0..BINS).map(of).collect()
    }
}

fn side(seen: &Seen<'_>, k: usize) -> usize {
    match seen.variable.by_direction {
        true if seen.direction[k] < 0.0 => 0,
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Predicted minus recorded is 2 on the average of four rows forth, and −1.5 of two back.
    #[test]
    fn points_are_means_along_the_motion() {
        let mut sums = [[BinSums::default(); BINS]; 2];
        let of = |sum: f64, squares: f64, rows: f64| BinSums { sum, squares, rows };
        sums[1][0] = of(8.0, 20.0, 4.0);
        sums[0][0] = of(-3.0, 5.0, 2.0);
        sums[1][1] = of(8.0, 20.0, 4.0);
        let edges: Vec<f64> = (0..=BINS).map(|b| b as f64).collect();
        let points = Curve { sums }.points(&edges);
        assert_eq!((points[0].at, points[1].at), (0.5, 1.5));
        assert!((points[0].mean + 11.0 / 6.0).abs() < 1e-15);
        assert!((points[0].std_error - 5.0 / 6.0).abs() < 1e-15);
        assert!((points[1].mean + 2.0).abs() < 1e-15);
        assert!((points[1].std_error - 5.0_f64.sqrt() / 2.0).abs() < 1e-15);
        assert_eq!((points[2].mean, points[2].std_error), (0.0, 0.0));
    }
}
