//! The few facts that both the page and the terminal open with.

pub(super) use crate::chain::words::count;
use crate::outcome::check::{Mistake, Severity};
use crate::outcome::estimate::Solver;
use crate::outcome::fit::Fit;
use crate::outcome::joint::JointFigures;
use crate::outcome::parameter::{Parameter, Source};
use crate::outcome::provenance::date;
use crate::outcome::trials::{Calibration, Group, Share, Trials};
use crate::report::number;
use std::time::{Duration, UNIX_EPOCH};

/// The rates of trials: what is counted, and how many of how many.
pub(super) fn trial_rates(trials: &Trials) -> Vec<(&'static str, Share)> {
    let rates = &trials.rates;
    let controls = Share {
        of: trials.false_findings.controls,
        are: trials.false_findings.with_finding,
    };
    let mut all = vec![
        ("one effect: the first finding is right", rates.first_right),
        ("one effect: it bears the very name", rates.first_named),
        ("one effect: the joints are right", rates.joints_right),
        ("two effects: both are found", rates.both_found),
        ("several effects: each is found", rates.each_found),
        ("findings with a wrong name", rates.wrong_names),
        (
            "said to be inseparable, told apart by longer recordings",
            rates.told_apart,
        ),
        (
            "said to be so in longer recordings too, told apart by them",
            rates.wrongly_inseparable,
        ),
        ("outside the vocabulary, yet named", rates.outside_named),
        ("controls with a finding", controls),
        (
            "friction back within 1.5 of the informed fit",
            rates.friction_back,
        ),
        (
            "bodies back within 1.5 of the informed fit",
            rates.bodies_back,
        ),
    ];
    if let Some(outside) = &rates.outside {
        all.extend([
            ("outside: the joint is found", outside.located),
            (
                "outside: the joint is found, or said to be unexplained",
                outside.located_or_unexplained,
            ),
            (
                "outside, two variables: a smooth correction takes half of it",
                outside.smooth_takes_half,
            ),
            ("outside: a formula is proposed", outside.proposed),
            (
                "outside: a formula forecasts a larger motion twice as well",
                outside.forecasts,
            ),
            (
                "formulas with the variables of the law",
                outside.variables_right,
            ),
            (
                "nothing, or forecast smoothly, yet a formula that errs no less",
                outside.needless,
            ),
        ]);
    }
    all
}

/// What is told of the trials of one kind of motion or noise.
pub(super) const GROUP_HEADERS: [&str; 7] = [
    "",
    "trials",
    "no answer",
    "first finding right",
    "findings with a wrong name",
    "controls with a finding",
    "at most (95 %)",
];

/// The figures of a kind of trials under [`GROUP_HEADERS`].
pub(super) fn group_row(group: &Group) -> [String; 7] {
    let share = |s: Share| match s.of {
        0 => String::new(),
        _ => format!("{} of {} ({})", s.are, s.of, number::percent(s.value())),
    };
    let controls = &group.false_findings;
    let bound = match controls.controls {
        0 => String::new(),
        _ => number::percent(controls.upper95),
    };
    [
        group.kind.clone(),
        group.trials.to_string(),
        group.without_answer.to_string(),
        share(group.rates.first_right),
        share(group.rates.wrong_names),
        share(Share {
            of: controls.controls,
            are: controls.with_finding,
        }),
        bound,
    ]
}

/// What is told of the claims that are stated with a probability of one tenth.
pub(super) const CALIBRATION_HEADERS: [&str; 6] = [
    "motion",
    "stated from",
    "claims",
    "mean stated",
    "right",
    "95 % interval",
];

/// The figures of a tenth under [`CALIBRATION_HEADERS`].
pub(super) fn calibration_row(row: &Calibration) -> [String; 6] {
    let [low, high] = row.ci95.map(number::percent);
    [
        row.motion.clone().unwrap_or_else(|| "all".to_string()),
        number::percent(row.from),
        row.claims.to_string(),
        number::percent(row.stated),
        number::percent(row.right as f64 / row.claims as f64),
        format!("{low} to {high}"),
    ]
}

/// What trials came to, in a sentence.
pub(super) fn trials_sentence(trials: &Trials) -> String {
    let rates = &trials.rates;
    let share = |s: Share| match s.of {
        0 => "none tried".to_string(),
        _ => format!("{} ({} of {})", number::percent(s.value()), s.are, s.of),
    };
    let controls = &trials.false_findings;
    let controls = match controls.controls {
        0 => "there were no controls".to_string(),
        _ => format!(
            "of the controls {} of {} have a finding, at most {} with 95 % confidence",
            controls.with_finding,
            controls.controls,
            number::percent(controls.upper95)
        ),
    };
    format!(
        "{}: where one effect leaves at least {} times the noise, the first finding is right in {}; {controls}.",
        count(trials.trials.len(), "trial"),
        rates.least_size,
        share(rates.first_right),
    )
}

/// Every source, in the order in which counts are told.
const SOURCES: [Source; 5] = [
    Source::Data,
    Source::Prior,
    Source::Bound,
    Source::Known,
    Source::Undetermined,
];

/// How many parameters each source gives: `36 from data, 2 on a bound, 14 undetermined`.
pub(super) fn parameter_counts(parameters: &[Parameter]) -> String {
    let counts: Vec<String> = SOURCES
        .into_iter()
        .filter_map(|source| {
            let count = parameters.iter().filter(|p| p.source == source).count();
            let words = match source {
                Source::Data => "from data",
                Source::Prior => "from the prior",
                Source::Bound => "on a bound",
                Source::Known => "known",
                Source::Undetermined => "undetermined",
            };
            (count > 0).then(|| format!("{count} {words}"))
        })
        .collect();
    counts.join(", ")
}

/// Least and greatest of a figure over the joints that have it.
pub(super) fn range(
    joints: &[JointFigures],
    figure: impl Fn(&JointFigures) -> Option<f64>,
) -> Option<(f64, f64)> {
    joints
        .iter()
        .filter_map(figure)
        .filter(|value| value.is_finite())
        .fold(None, |range, value| match range {
            None => Some((value, value)),
            Some((low, high)) => Some((value.min(low), value.max(high))),
        })
}

/// A range in words: `2.10 % to 6.25 %`, or one number where both ends read the same.
pub(super) fn in_words((low, high): (f64, f64), format: impl Fn(f64) -> String) -> String {
    let (low, high) = (format(low), format(high));
    if low == high {
        low
    } else {
        format!("{low} to {high}")
    }
}

/// How the solver ended, in words.
pub(super) fn solver_sentence(solver: &Solver) -> String {
    let ended = if solver.converged {
        "converged"
    } else {
        "did not converge"
    };
    let iterations = count(solver.iterations as usize, "iteration");
    format!(
        "{} {ended} ({}) after {iterations}",
        solver.name,
        solver.stop.replace('_', " ")
    )
}

/// How the search for a motion ended, in words: one that was cut off may have come to a motion that keeps its limits.
pub(super) fn design_sentence(solver: &Solver) -> String {
    match is_cut_off(solver) {
        true => format!(
            "{}: feasible; stopped at the {} after {}",
            solver.name,
            solver.stop.replace('_', " "),
            count(solver.iterations as usize, "iteration")
        ),
        false => solver_sentence(solver),
    }
}

/// Whether a search ended at a limit of its own before it came to a solution.
pub(super) fn is_cut_off(solver: &Solver) -> bool {
    !solver.converged && ["iteration_limit", "time_limit"].contains(&solver.stop.as_str())
}

/// Number of findings of each severity: `2 errors, 1 warning`.
pub(super) fn finding_counts(findings: &[Mistake]) -> String {
    let counts: Vec<String> = [Severity::Error, Severity::Warning, Severity::Note]
        .into_iter()
        .filter_map(|severity| {
            let number = findings.iter().filter(|f| f.severity == severity).count();
            (number > 0).then(|| count(number, severity.as_str()))
        })
        .collect();
    if counts.is_empty() {
        "nothing found".to_string()
    } else {
        counts.join(", ")
    }
}

/// Where a finding lies: file, line and channel as far as known.
pub(super) fn finding_place(finding: &Mistake) -> String {
    let mut place = finding.file.clone().unwrap_or_default();
    if let (Some(line), false) = (finding.line, place.is_empty()) {
        place.push_str(&format!(":{line}"));
    }
    match &finding.channel {
        Some(channel) if place.is_empty() => channel.clone(),
        Some(channel) => format!("{place}: {channel}"),
        None => place,
    }
}

/// The command with these arguments as a shell takes it.
pub(super) fn command(arguments: &[String]) -> String {
    let words: Vec<String> = arguments.iter().map(|word| shell_word(word)).collect();
    format!("exid {}", words.join(" "))
}

/// A word that a POSIX shell takes as it stands, quoted where needed.
fn shell_word(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-/+=:@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_string()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// `18 of 19`: independent combinations of unknown parameters.
pub(super) fn rank_in_words(fit: &Fit) -> String {
    match fit.unknowns {
        0 => fit.rank.to_string(),
        unknowns => format!("{} of {unknowns}", fit.rank),
    }
}

/// Seconds since 1970 from which on a time is taken for a date: 1980.
const FIRST_DATE: f64 = 3.2e8;

/// A time of a manifest: a date where it looks like one, else the number.
pub(super) fn moment(time: f64) -> String {
    if !(FIRST_DATE..1e11).contains(&time) {
        return format!("{time}");
    }
    let text = date(UNIX_EPOCH + Duration::from_secs(time as u64));
    text.trim_end_matches("T00:00:00Z").to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_that_was_cut_off_is_not_said_to_have_converged() {
        let solver = |stop: &str, converged| Solver {
            name: "search".to_string(),
            stop: stop.to_string(),
            converged,
            iterations: 16,
            evaluations: 20,
            cost: 1.0,
        };
        let sentence = |stop, converged| design_sentence(&solver(stop, converged));
        assert_eq!(
            sentence("iteration_limit", false),
            "search: feasible; stopped at the iteration limit after 16 iterations"
        );
        assert_eq!(
            sentence("cost_tolerance", true),
            "search converged (cost tolerance) after 16 iterations"
        );
        assert_eq!(
            sentence("infeasible", false),
            "search did not converge (infeasible) after 16 iterations"
        );
    }

    #[test]
    fn quotes_what_a_shell_would_split() {
        assert_eq!(shell_word("a/b-1.toml"), "a/b-1.toml");
        assert_eq!(shell_word("my arm's.toml"), r"'my arm'\''s.toml'");
    }
}
