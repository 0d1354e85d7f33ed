//! The rates over many trials.

use crate::outcome::finding::UNNAMED;
use crate::outcome::trials::{
    self, FalseFindings, Found, Group, Hidden, LONGER, OutsideRates, Power, Rates, Share, Trial,
    Trials,
};
use crate::stats::distribution::Distribution;
use crate::trials::calibration;
use crate::trials::naming::names;
use std::collections::BTreeMap;

/// An effect of so many times the noise has to be found.
pub const LEAST_SIZE: f64 = 3.0;

/// A law outside the vocabulary of so many times the noise should have a formula.
const FORMULA_SIZE: f64 = 5.0;

/// A formula is of use if it errs in the larger motion at most so many times as much as the smooth correction.
const OF_USE: f64 = 0.5;

/// Share of what is beyond the noise that a smooth correction should take.
const TAKEN: f64 = 0.5;

/// Variables of which a smooth correction should take a law.
const SMOOTH_VARIABLES: usize = 2;

/// Ranges of sizes over noise, by their lower ends.
const SIZES: [f64; 8] = [0.0, 0.3, 1.0, 2.0, 3.0, 5.0, 10.0, 30.0];

/// What the absence of a finding is called in the table.
const NOTHING: &str = "nothing";

/// Friction and bodies are back if their error is at most so many times that of a fit that knew the truth.
const BACK: f64 = 1.5;

/// Sums up trials.
pub fn tally(trials: Vec<Trial>) -> Trials {
    let every: Vec<&Trial> = trials.iter().collect();
    let all = group("", &every);
    let by_motion = by_kind(&every, |trial| &trial.motion);
    let motions: Vec<String> = by_motion.iter().map(|group| group.kind.clone()).collect();
    let failures = all.without_answer;
    let notes = (failures > 0).then(|| {
        format!("{failures} trials have no answer and count as not found: see `failure` of each.")
    });
    Trials {
        confusion: all.confusion,
        power: all.power,
        false_findings: all.false_findings,
        rates: all.rates,
        by_motion,
        by_noise: by_kind(&every, |trial| &trial.noise),
        calibration: calibration::table(&trials, &motions),
        notes: notes.into_iter().collect(),
        trials,
    }
}

/// The figures of trials of one kind.
fn group(kind: &str, trials: &[&Trial]) -> Group {
    let all = trials.iter().copied();
    let answered: Vec<&Trial> = all.filter(|t| t.failure.is_none()).collect();
    Group {
        kind: kind.to_string(),
        trials: trials.len(),
        without_answer: trials.len() - answered.len(),
        confusion: confusion(&answered),
        power: power(trials),
        false_findings: false_findings(&answered),
        rates: rates(trials),
    }
}

/// The figures of every kind of trials, by its name.
fn by_kind(trials: &[&Trial], kind: impl Fn(&Trial) -> &String) -> Vec<Group> {
    let mut kinds: BTreeMap<&String, Vec<&Trial>> = BTreeMap::new();
    for &trial in trials {
        kinds.entry(kind(trial)).or_default().push(trial);
    }
    let groups = kinds.iter().map(|(kind, own)| group(kind, own));
    groups.collect()
}

/// Size of what a trial conceals: the smaller one of two.
fn size(trial: &Trial) -> f64 {
    let sizes = trial.concealed.iter().map(|h| h.effect_over_noise);
    sizes.fold(f64::INFINITY, f64::min)
}

/// Whether what is concealed is large enough to be found; not known where there is no answer, which counts as not found.
fn is_large(hidden: &Hidden) -> bool {
    hidden.effect_over_noise.is_nan() || hidden.effect_over_noise >= LEAST_SIZE
}

/// Whether a trial counts: all of one or two effects are large enough, some of more.
fn counts(trial: &Trial) -> bool {
    match trial.concealed.len() {
        0..=2 => trial.concealed.iter().all(is_large),
        _ => trial.concealed.iter().any(is_large),
    }
}

/// The name of the one effect of the vocabulary that a trial conceals.
fn single(trial: &Trial) -> Option<&str> {
    match &trial.concealed[..] {
        [one] if !trials::is_outside(&one.effect) => Some(&one.effect),
        _ => None,
    }
}

fn is_outside(trial: &Trial) -> bool {
    let mut concealed = trial.concealed.iter();
    concealed.any(|hidden| trials::is_outside(&hidden.effect))
}

fn confusion(trials: &[&Trial]) -> BTreeMap<String, BTreeMap<String, usize>> {
    let mut table: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for trial in trials {
        let concealed = match &trial.concealed[..] {
            [] => NOTHING,
            [one] if one.effect_over_noise >= LEAST_SIZE => &one.effect,
            _ => continue,
        };
        let found = trial.found.first().map_or(NOTHING, |f| &f.effect);
        let row = table.entry(concealed.to_string()).or_default();
        *row.entry(found.to_string()).or_default() += 1;
    }
    table
}

fn power(trials: &[&Trial]) -> Vec<Power> {
    let mut cells: BTreeMap<(String, usize), Share> = BTreeMap::new();
    for trial in trials {
        let (Some(effect), size) = (single(trial), size(trial)) else {
            continue;
        };
        let Some(range) = SIZES.iter().rposition(|lower| size >= *lower) else {
            continue;
        };
        let cell = cells.entry((effect.to_string(), range)).or_default();
        cell.count(trial.right_effect && trial.right_joints);
    }
    let row = |((effect, range), share): ((String, usize), Share)| Power {
        effect,
        effect_over_noise: SIZES[range],
        right: share.are,
        trials: share.of,
    };
    cells.into_iter().map(row).collect()
}

fn false_findings(trials: &[&Trial]) -> FalseFindings {
    let controls = trials.iter().filter(|t| t.concealed.is_empty());
    let mut share = Share::default();
    controls.for_each(|trial| share.count(!trial.found.is_empty()));
    FalseFindings {
        controls: share.of,
        with_finding: share.are,
        upper95: upper95(share),
    }
}

/// Upper 95 % bound of a rate, one-sided (Clopper and Pearson 1934): the p of which so few cases or fewer have a
/// probability of 5 %.
fn upper95(share: Share) -> f64 {
    if share.are >= share.of {
        return 1.0;
    }
    let (more, rest) = ((share.are + 1) as f64, (share.of - share.are) as f64);
    let quantile = Distribution::FisherF {
        numerator: 2.0 * more,
        denominator: 2.0 * rest,
    }
    .quantile(0.95);
    more * quantile / (rest + more * quantile)
}

fn rates(trials: &[&Trial]) -> Rates {
    let mut rates = Rates {
        least_size: LEAST_SIZE,
        ..Rates::default()
    };
    let (mut errors, mut frictions, mut bodies) = (Vec::new(), Vec::new(), Vec::new());
    for &trial in trials {
        count_each(trial, &mut rates);
    }
    for &trial in trials.iter().filter(|t| counts(t)) {
        count_claims(trial, &mut rates);
        if trial.concealed.is_empty() {
            continue;
        }
        if is_outside(trial) {
            let named = |f: &Found| f.effect != UNNAMED;
            rates.outside_named.count(trial.found.iter().any(named));
            continue;
        }
        for finding in trial.found.iter().filter(|f| f.effect != UNNAMED) {
            let known = trial.concealed.iter().any(|h| names(finding, h));
            rates.wrong_names.count(!known);
        }
        match single(trial) {
            None if trial.concealed.len() == 2 => rates.both_found.count(trial.all_found),
            None => {}
            Some(effect) => {
                rates.first_right.count(trial.right_effect);
                rates.joints_right.count(trial.right_joints);
                let first = trial.found.first();
                rates
                    .first_named
                    .count(first.is_some_and(|f| f.effect == effect));
                errors.extend(trial.error_ratio);
            }
        }
        if let Some([_, found, known]) = trial.friction_error {
            frictions.push(found / known);
            rates.friction_back.count(found <= BACK * known);
        }
        if let Some([_, found, known]) = trial.body_error {
            bodies.push(found / known);
            rates.bodies_back.count(found <= BACK * known);
        }
    }
    rates.outside = outside(trials);
    rates.median_error_ratio = median(errors);
    rates.median_friction_ratio = median(frictions);
    rates.median_body_ratio = median(bodies);
    rates
}

/// Counts the effects of a trial that conceals several.
fn count_each(trial: &Trial, rates: &mut Rates) {
    if trial.concealed.len() < 2 {
        return;
    }
    for hidden in trial.concealed.iter().filter(|hidden| is_large(hidden)) {
        let found = trial.found.iter().any(|finding| names(finding, hidden));
        rates.each_found.count(found);
    }
}

/// Rates over laws that were drawn from the grammar, and their controls; `None` where there are none.
fn outside(trials: &[&Trial]) -> Option<OutsideRates> {
    let mut rates = OutsideRates {
        formula_size: FORMULA_SIZE,
        ..OutsideRates::default()
    };
    let mut ratios = Vec::new();
    let mut counted = trials
        .iter()
        .filter_map(|trial| Some((trial, trial.nameless.as_ref()?)))
        .peekable();
    counted.peek()?;
    for (trial, nameless) in counted {
        let has_formula = nameless.formula.is_some();
        let Some(forecast) = &nameless.forecast else {
            rates.needless.count(has_formula);
            continue;
        };
        if size(trial) >= LEAST_SIZE {
            rates.located.count(trial.right_joints);
            let unexplained = nameless.unexplained.iter();
            let hidden = trial.concealed.iter().flat_map(|hidden| &hidden.joints);
            rates
                .located_or_unexplained
                .count(trial.right_joints || unexplained.eq(hidden));
            if nameless.variables.len() <= SMOOTH_VARIABLES {
                rates
                    .smooth_takes_half
                    .count(nameless.smooth_share >= TAKEN);
            }
        }
        // Less than the noise is left to a formula.
        if forecast.smooth <= 1.0 {
            let errs_no_less = |formula: f64| formula >= forecast.smooth;
            rates
                .needless
                .count(forecast.formula.is_some_and(errs_no_less));
            continue;
        }
        if size(trial) < FORMULA_SIZE {
            continue;
        }
        let ratio = forecast.formula.map(|formula| formula / forecast.smooth);
        rates.proposed.count(has_formula);
        rates
            .forecasts
            .count(ratio.is_some_and(|ratio| ratio <= OF_USE));
        if has_formula {
            let is_in = |a: &[String], b: &[String]| a.iter().all(|x| b.contains(x));
            let [true_ones, found] = [&nameless.variables, &nameless.formula_variables];
            rates
                .variables_right
                .count(is_in(true_ones, found) && is_in(found, true_ones));
        }
        ratios.extend(ratio);
    }
    rates.median_forecast_ratio = median(ratios);
    Some(rates)
}

/// Counts the rivals that a trial said to be inseparable.
fn count_claims(trial: &Trial, rates: &mut Rates) {
    for claim in trial.found.iter().flat_map(|f| &f.inseparable) {
        let Some(told_apart) = claim.told_apart else {
            continue;
        };
        rates.told_apart.count(told_apart);
        if claim.times_longer.is_none_or(|times| times > LONGER as f64) {
            rates.wrongly_inseparable.count(told_apart);
        }
    }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
