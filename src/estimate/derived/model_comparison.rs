//! Comparison of the predictions of several fitted models, and whether the recordings can tell them apart.
//!
//! Errors e_A and e_B of two models have equal squares on the average exactly if λ = ½ in the regression
//! `e_B = −λ (e_A − e_B) + u` (the test of forecast encompassing of Harvey, Leybourne and Newbold 1998). What the
//! models predict differently is known, and only u is chance, so that the mean of `e_A² − e_B²` has the deviation of
//! that of `2 (e_A − e_B) u`. Errors are coloured, by filters and by what the models miss: the mean of n rows has the
//! variance `σ²_d / (n (1 − Σ a_k)²)` of an autoregression with coefficients a_k and innovations σ²_d. The same
//! variance gives the intervals of the errors themselves.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::model::Model;
use crate::estimate::derived::goodness_of_fit::Predictions;
use crate::outcome::model_comparison::{ErrorFigure, ModelComparison, ModelErrors};
use crate::recording::split::Split;
use crate::stats::autoregression::{Autoregression, OrderCriterion};
use crate::stats::distribution::Distribution;

/// Chance that some model is called best where all are equal.
const SIGNIFICANCE: f64 = 0.05;

/// A root mean square error smaller by less than this share is no better, however certain.
const NEGLIGIBLE: f64 = 0.01;

/// Longest memory of an error, rows.
const MAX_ORDER: usize = 40;

/// A fitted model by its name and what it predicts.
pub struct ComparedModel<'a> {
    /// Its name in the comparison.
    pub name: &'a str,
    /// What it predicts, over the rows that all models predict.
    pub predictions: &'a Predictions,
}

/// Rows of one recording that count.
type Segments = Vec<Vec<f64>>;

/// Errors of one model on some channels, in a unit of each.
type Errors = Vec<Segments>;

/// The comparisons on every active channel, then on all of them together.
pub fn comparisons(
    model: &Model,
    data: &Dataset,
    models: &[ComparedModel<'_>],
) -> Vec<ModelComparison> {
    let held_out = data.of(Split::Validation).next().is_some();
    let channels = model.channels().iter().enumerate();
    let active: Vec<usize> = channels.filter(|(_, c)| c.active).map(|(k, _)| k).collect();
    let of = |split, channel| -> Vec<Segments> {
        let errors = models.iter().map(|e| errors(data, split, e, channel));
        errors.collect()
    };
    let mut comparisons = Vec::new();
    let mut pooled: [Vec<Errors>; 2] = std::array::from_fn(|_| vec![Errors::new(); models.len()]);
    for &channel in &active {
        let sets = [Split::Train, Split::Validation].map(|split| of(split, channel));
        for (all, own) in pooled.iter_mut().zip(&sets) {
            let unit = 1.0 / root_mean_square(&own[0]).max(f64::MIN_POSITIVE);
            let unit = unit / (active.len() as f64).sqrt();
            for (to, from) in all.iter_mut().zip(own) {
                to.push(map(from, |e| e * unit));
            }
        }
        let described = &model.channels()[channel];
        let single = sets
            .clone()
            .map(|set| set.into_iter().map(|e| vec![e]).collect());
        let mut comparison = judge(models, &single, held_out);
        for (k, errors) in comparison.models.iter_mut().enumerate() {
            errors.mae_train = mean(&map(&sets[0][k], f64::abs));
            errors.mae_validation = held_out.then(|| mean(&map(&sets[1][k], f64::abs)));
        }
        comparison.joint = Some(described.name.clone());
        comparison.unit = described.unit.to_string();
        comparisons.push(comparison);
    }
    if active.len() > 1 {
        comparisons.push(judge(models, &pooled, held_out));
    }
    comparisons
}

/// Predicted minus recorded in the rows that count.
fn errors(data: &Dataset, split: Split, model: &ComparedModel<'_>, channel: usize) -> Segments {
    let of = |(k, recording): (usize, &Prepared)| {
        let predicted = &model.predictions[k][channel];
        let recorded = recording.signal(channel);
        let rows = recording.counting();
        rows.map(|row| predicted[row] - recorded[row]).collect()
    };
    let recordings = data.recordings.iter().enumerate();
    recordings
        .filter(|(_, r)| r.split == split)
        .map(of)
        .collect()
}

fn map(segments: &Segments, f: impl Fn(f64) -> f64) -> Segments {
    let of = |segment: &Vec<f64>| segment.iter().map(|x| f(*x)).collect();
    segments.iter().map(of).collect()
}

fn root_mean_square(segments: &Segments) -> f64 {
    mean(&map(segments, |x| x * x)).value.sqrt()
}

/// Sum over channels of what is made of the errors of two models, row by row.
fn rows(a: &Errors, b: &Errors, of: impl Fn(f64, f64) -> f64) -> Segments {
    let mut sum = a.first().map(|s| map(s, |_| 0.0)).unwrap_or_default();
    for (a, b) in a.iter().zip(b) {
        let pairs = a.iter().flatten().zip(b.iter().flatten());
        for (to, (a, b)) in sum.iter_mut().flatten().zip(pairs) {
            *to += of(*a, *b);
        }
    }
    sum
}

fn total(segments: &Segments) -> f64 {
    segments.iter().flatten().sum()
}

/// Mean of a coloured series of positive numbers and its 95 % interval, even in the logarithm, as sums of
/// squares are skew.
fn mean(segments: &Segments) -> ErrorFigure {
    let Mean { value, deviation } = Mean::of(segments);
    let factor = (Distribution::Normal.two_sided(0.95) * deviation / value).exp();
    ErrorFigure {
        value,
        ci95: factor.is_finite().then(|| [value / factor, value * factor]),
    }
}

/// The mean of a coloured series, and its standard deviation.
struct Mean {
    value: f64,
    deviation: f64,
}

impl Mean {
    fn of(segments: &Segments) -> Self {
        let count: usize = segments.iter().map(Vec::len).sum();
        let n = count as f64;
        let value = segments.iter().flatten().sum::<f64>() / n;
        let centred = map(segments, |x| x - value);
        let parts: Vec<&[f64]> = centred.iter().map(Vec::as_slice).collect();
        let order = MAX_ORDER.min(count / 10);
        let deviation = Autoregression::fit(&parts, order, OrderCriterion::Bic)
            .map_or(f64::INFINITY, |a| (a.long_run_variance() / n).sqrt());
        Self { value, deviation }
    }
}

fn root(mean: ErrorFigure) -> ErrorFigure {
    ErrorFigure {
        value: mean.value.sqrt(),
        ci95: mean.ci95.map(|ends| ends.map(f64::sqrt)),
    }
}

/// Ranks models by their errors of training and of validation; absolute errors are left at zero.
fn judge(
    models: &[ComparedModel<'_>],
    errors: &[Vec<Errors>; 2],
    held_out: bool,
) -> ModelComparison {
    let [train, validation] = errors;
    let none = ErrorFigure {
        value: f64::NAN,
        ci95: None,
    };
    let square = |e: &Errors| root(mean(&rows(e, e, |a, _| a * a)));
    let of = |(k, model): (usize, &ComparedModel<'_>)| ModelErrors {
        name: model.name.to_string(),
        rmse_train: square(&train[k]),
        rmse_validation: held_out.then(|| square(&validation[k])),
        mae_train: none,
        mae_validation: None,
    };
    let verdict = winner(models, if held_out { validation } else { train });
    ModelComparison {
        joint: None,
        unit: String::new(),
        models: models.iter().enumerate().map(of).collect(),
        best: verdict.best,
        level: verdict.level,
        sentence: verdict.sentence,
    }
}

/// What errors say of models.
#[derive(Default)]
struct Verdict {
    best: Option<String>,
    level: Vec<String>,
    sentence: String,
}

/// The model that beats every other, and why there is none.
fn winner(models: &[ComparedModel<'_>], errors: &[Errors]) -> Verdict {
    let square = |e: &Errors| total(&rows(e, e, |a, _| a * a));
    let squares: Vec<f64> = errors.iter().map(square).collect();
    let order = |a: &usize, b: &usize| squares[*a].total_cmp(&squares[*b]);
    let Some(least) = (0..models.len()).min_by(order) else {
        return Verdict::default();
    };
    let name = models[least].name;
    // Any of the models may be the best by chance.
    let threshold = Distribution::Normal.upper_quantile(SIGNIFICANCE / models.len() as f64);
    let is_level = |other: &usize| {
        let excess = excess(&errors[*other], &errors[least]);
        let share = 1.0 - (squares[least] / squares[*other]).sqrt();
        // Models that predict the same bits differ by nothing.
        !(excess.value > threshold * excess.deviation && share > NEGLIGIBLE)
    };
    let others = (0..models.len()).filter(|k| *k != least);
    let level: Vec<&str> = others.filter(is_level).map(|k| models[k].name).collect();
    if level.is_empty() {
        return Verdict {
            best: Some(name.to_string()),
            level: Vec::new(),
            sentence: format!("{name} predicts best"),
        };
    }
    let sentence = format!(
        "cannot tell {name} from {}: their errors differ by less than {} % or by chance",
        level.join(", "),
        100.0 * NEGLIGIBLE
    );
    let all = std::iter::once(name).chain(level);
    Verdict {
        best: None,
        level: all.map(str::to_string).collect(),
        sentence,
    }
}

/// Mean of `e_A² − e_B²` and its deviation, that of `2 (e_A − e_B) u`, u = e_B + λ (e_A − e_B).
fn excess(a: &Errors, b: &Errors) -> Mean {
    let squares = total(&rows(a, b, |a, b| (a - b).powi(2)));
    if squares == 0.0 {
        return Mean {
            value: 0.0,
            deviation: 0.0,
        };
    }
    let share = -total(&rows(a, b, |a, b| (a - b) * b)) / squares;
    let chance = rows(a, b, |a, b| 2.0 * (a - b) * (b + share * (a - b)));
    Mean {
        value: Mean::of(&rows(a, b, |a, b| a * a - b * b)).value,
        deviation: Mean::of(&chance).deviation,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::random::generator;
    use rand_distr::{Distribution as _, StandardNormal};

    const ROWS: usize = 2000;

    /// Errors of several models: common coloured noise, and a bias of each.
    fn series(seed: u64, (rows, biases): (usize, &[f64])) -> Vec<Errors> {
        let mut rng = generator(seed);
        let mut noise = vec![0.0; rows];
        for k in 1..rows {
            let draw: f64 = StandardNormal.sample(&mut rng);
            noise[k] = 0.9 * noise[k - 1] + draw;
        }
        let of = |bias: &f64| {
            let own: Vec<f64> = (0..rows).map(|_| StandardNormal.sample(&mut rng)).collect();
            let rows = noise.iter().zip(own).enumerate();
            let error =
                |(k, (e, own)): (usize, (&f64, f64))| e + 0.1 * own + bias * (0.1 * k as f64).sin();
            vec![vec![rows.map(error).collect()]]
        };
        biases.iter().map(of).collect()
    }

    fn best(seed: u64, biases: &[f64]) -> Option<String> {
        let none = Predictions::new();
        let names = ["a", "b", "c"];
        let models: Vec<ComparedModel<'_>> = names[..biases.len()]
            .iter()
            .map(|name| ComparedModel {
                name,
                predictions: &none,
            })
            .collect();
        winner(&models, &series(seed, (ROWS, biases))).best
    }

    #[test]
    fn recovers_the_known_best_of_three() {
        for seed in 0..20 {
            let found = best(seed, &[3.0, 0.0, 2.5]);
            assert_eq!(found.as_deref(), Some("b"), "seed {seed}");
        }
    }

    /// A bias that swings as slowly as the recording lasts leaves few independent squares, but its model is
    /// known to be worse.
    #[test]
    fn a_gross_and_slow_error_is_no_chance() {
        let none = Predictions::new();
        let models = ["right", "gross"].map(|name| ComparedModel {
            name,
            predictions: &none,
        });
        for seed in 0..20 {
            let mut errors = series(seed, (ROWS, &[0.0, 0.0]));
            let swing = |(k, e): (usize, &mut f64)| *e += 30.0 * (0.003 * k as f64).sin();
            errors[1][0][0].iter_mut().enumerate().for_each(swing);
            let verdict = winner(&models, &errors);
            assert_eq!(verdict.best.as_deref(), Some("right"), "seed {seed}");
        }
    }

    #[test]
    fn calls_equal_models_equal_as_often_as_it_says() {
        const SEEDS: u64 = 200;
        let called = (0..SEEDS)
            .filter(|s| best(1000 + s, &[1.0, 1.0, 1.0]).is_some())
            .count();
        // Binomial, three standard deviations above the stated chance.
        let n = SEEDS as f64;
        let most = n * SIGNIFICANCE + 3.0 * (n * SIGNIFICANCE * (1.0 - SIGNIFICANCE)).sqrt();
        assert!((called as f64) <= most, "{called} of {SEEDS}");
    }

    #[test]
    fn intervals_of_the_mean_square_hold_its_truth_as_often_as_they_say() {
        const SEEDS: u64 = 100;
        // Five hundred times the memory of a square: the interval holds for long recordings.
        const LONG: usize = 10_000;
        // Stationary variance of the noise and of its own part.
        let truth = 1.0 / (1.0 - 0.81) + 0.01;
        let inside = |seed: &u64| {
            let errors = &series(5000 + seed, (LONG, &[0.0]))[0];
            let ends = mean(&rows(errors, errors, |a, _| a * a)).ci95.unwrap();
            (ends[0]..=ends[1]).contains(&truth)
        };
        let held = (0..SEEDS).filter(inside).count() as f64;
        let n = SEEDS as f64;
        let least = n * 0.95 - 3.0 * (n * 0.95 * 0.05_f64).sqrt();
        assert!(held >= least, "{held} of {SEEDS}");
    }
}
