//! Which of several fitted models predicts best, and whether the recordings can tell.
//!
//! Two models A and B differ by `d_t = e_A,t² − e_B,t²` in every row (Diebold and Mariano 1995). Errors are
//! coloured, by filters and by what the models miss, so that the mean of n rows has the variance
//! `σ²_d / (n (1 − Σ a_k)²)` of an autoregression with coefficients a_k and innovations σ²_d fitted to d. The
//! same variance gives the intervals of the errors themselves.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::model::Model;
use crate::estimate::figures::Predictions;
use crate::outcome::contest::{Contest, ErrorFigure, ModelErrors};
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
pub struct Entrant<'a> {
    pub name: &'a str,
    pub predictions: &'a Predictions,
}

/// Rows of one recording that count.
type Segments = Vec<Vec<f64>>;

/// The contests on every active channel, then on all of them together.
pub fn contests(model: &Model, data: &Dataset, entrants: &[Entrant<'_>]) -> Vec<Contest> {
    let held_out = data.of(Split::Validation).next().is_some();
    let judged = if held_out {
        Split::Validation
    } else {
        Split::Train
    };
    let channels = model.channels().iter().enumerate();
    let active: Vec<usize> = channels.filter(|(_, c)| c.active).map(|(k, _)| k).collect();
    let mut contests = Vec::new();
    let mut pooled: Vec<[Segments; 2]> = vec![Default::default(); entrants.len()];
    for &channel in &active {
        let of = |split| -> Vec<Segments> {
            let errors = entrants.iter().map(|e| errors(data, split, (e, channel)));
            errors.collect()
        };
        let sets = [of(Split::Train), of(Split::Validation)];
        for (sum, split) in [0, 1].into_iter().zip(&sets) {
            let unit = 1.0 / root_mean_square(&split[0]).max(f64::MIN_POSITIVE);
            for (to, from) in pooled.iter_mut().zip(split) {
                add_scaled(&mut to[sum], from, unit);
            }
        }
        let squared = sets.map(|set| set.iter().map(|e| map(e, |x| x * x)).collect::<Vec<_>>());
        let describe = &model.channels()[channel];
        let mut contest = judge(entrants, &squared, judged);
        for (k, errors) in contest.models.iter_mut().enumerate() {
            let absolute = |split| {
                let errors = self::errors(data, split, (&entrants[k], channel));
                mean(&map(&errors, f64::abs))
            };
            errors.mae_train = absolute(Split::Train);
            errors.mae_validation = held_out.then(|| absolute(Split::Validation));
        }
        contest.joint = Some(describe.name.clone());
        contest.unit = describe.unit.to_string();
        contests.push(contest);
    }
    let count = active.len().max(1) as f64;
    let [train, validation] = [0, 1].map(|split| {
        let of = |p: &[Segments; 2]| map(&p[split], |x| x / count);
        pooled.iter().map(of).collect::<Vec<_>>()
    });
    if active.len() > 1 {
        contests.push(judge(entrants, &[train, validation], judged));
    }
    contests
}

/// Predicted minus recorded in the rows that count.
fn errors(data: &Dataset, split: Split, (entrant, channel): (&Entrant<'_>, usize)) -> Segments {
    let of = |(k, recording): (usize, &Prepared)| {
        let predicted = &entrant.predictions[k][channel];
        let recorded = recording.signal(channel);
        let rows = (0..recording.rows()).filter(|&row| recording.counts(row));
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

/// Adds the squares of errors in a unit, row by row.
fn add_scaled(sum: &mut Segments, errors: &Segments, unit: f64) {
    if sum.is_empty() {
        *sum = map(errors, |_| 0.0);
    }
    for (to, from) in sum.iter_mut().flatten().zip(errors.iter().flatten()) {
        *to += (from * unit).powi(2);
    }
}

/// Mean of a coloured series of positive numbers and its 95 % interval, even in the logarithm, as sums of
/// squares are skew.
fn mean(segments: &Segments) -> ErrorFigure {
    let (value, deviation) = mean_and_deviation(segments);
    let reach = (Distribution::Normal.two_sided(0.95) * deviation / value).exp();
    ErrorFigure {
        value,
        ci95: reach.is_finite().then(|| [value / reach, value * reach]),
    }
}

fn mean_and_deviation(segments: &Segments) -> (f64, f64) {
    let count: usize = segments.iter().map(Vec::len).sum();
    let n = count as f64;
    let value = segments.iter().flatten().sum::<f64>() / n;
    let centred = map(segments, |x| x - value);
    let parts: Vec<&[f64]> = centred.iter().map(Vec::as_slice).collect();
    let order = MAX_ORDER.min(count / 10);
    let deviation = Autoregression::fit(&parts, order, OrderCriterion::Bic)
        .map_or(f64::INFINITY, |a| (a.long_run_variance() / n).sqrt());
    (value, deviation)
}

fn root(mean: ErrorFigure) -> ErrorFigure {
    ErrorFigure {
        value: mean.value.sqrt(),
        ci95: mean.ci95.map(|ends| ends.map(f64::sqrt)),
    }
}

/// Ranks models by their squared errors, of training and of validation; absolute errors are left at zero.
fn judge(entrants: &[Entrant<'_>], squared: &[Vec<Segments>; 2], judged: Split) -> Contest {
    let [train, validation] = squared;
    let none = ErrorFigure {
        value: f64::NAN,
        ci95: None,
    };
    let held_out = judged == Split::Validation;
    let of = |(k, entrant): (usize, &Entrant<'_>)| ModelErrors {
        name: entrant.name.to_string(),
        rmse_train: root(mean(&train[k])),
        rmse_validation: held_out.then(|| root(mean(&validation[k]))),
        mae_train: none,
        mae_validation: None,
    };
    let series = if held_out { validation } else { train };
    let (best, sentence) = winner(entrants, series);
    Contest {
        joint: None,
        unit: String::new(),
        models: entrants.iter().enumerate().map(of).collect(),
        best,
        sentence,
    }
}

/// The model that beats every other, and why there is none.
fn winner(entrants: &[Entrant<'_>], squared: &[Segments]) -> (Option<String>, String) {
    let means: Vec<f64> = squared.iter().map(|s| mean_and_deviation(s).0).collect();
    let order = |a: &usize, b: &usize| means[*a].total_cmp(&means[*b]);
    let Some(least) = (0..entrants.len()).min_by(order) else {
        return (None, String::new());
    };
    let name = entrants[least].name;
    let pairs = entrants.len().saturating_sub(1).max(1) as f64;
    let threshold = Distribution::Normal.upper_quantile(SIGNIFICANCE / pairs);
    let level = |other: &usize| {
        let other = *other;
        let pairs = squared[other].iter().zip(&squared[least]);
        let rows = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| a - b).collect();
        let (difference, deviation) = mean_and_deviation(&pairs.map(rows).collect());
        let share = 1.0 - (means[least] / means[other]).sqrt();
        // Models that predict the same bits differ by nothing.
        !(difference > threshold * deviation && share > NEGLIGIBLE)
    };
    let others = (0..entrants.len()).filter(|k| *k != least);
    let level: Vec<&str> = others.filter(level).map(|k| entrants[k].name).collect();
    if level.is_empty() {
        return (Some(name.to_string()), format!("{name} predicts best"));
    }
    let sentence = format!(
        "cannot tell {name} from {}: their errors differ by less than {} % or by chance",
        level.join(", "),
        100.0 * NEGLIGIBLE
    );
    (None, sentence)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::random::generator;
    use rand_distr::{Distribution as _, StandardNormal};

    const ROWS: usize = 2000;

    /// Errors of several models: common coloured noise, and a bias of each.
    fn series(seed: u64, (rows, biases): (usize, &[f64])) -> Vec<Segments> {
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
            vec![rows.map(|row| error(row).powi(2)).collect()]
        };
        biases.iter().map(of).collect()
    }

    fn best(seed: u64, biases: &[f64]) -> Option<String> {
        let none = Predictions::new();
        let names = ["a", "b", "c"];
        let entrants: Vec<Entrant<'_>> = names[..biases.len()]
            .iter()
            .map(|name| Entrant {
                name,
                predictions: &none,
            })
            .collect();
        winner(&entrants, &series(seed, (ROWS, biases))).0
    }

    #[test]
    fn recovers_the_known_best_of_three() {
        for seed in 0..20 {
            let found = best(seed, &[3.0, 0.0, 2.5]);
            assert_eq!(found.as_deref(), Some("b"), "seed {seed}");
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
            let ends = mean(&series(5000 + seed, (LONG, &[0.0]))[0]).ci95.unwrap();
            (ends[0]..=ends[1]).contains(&truth)
        };
        let held = (0..SEEDS).filter(inside).count() as f64;
        let n = SEEDS as f64;
        let least = n * 0.95 - 3.0 * (n * 0.95 * 0.05_f64).sqrt();
        assert!(held >= least, "{held} of {SEEDS}");
    }
}
