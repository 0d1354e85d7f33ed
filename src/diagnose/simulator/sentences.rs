//! What the comparison of a simulator with the robot means, in sentences.

use crate::diagnose::simulator::side::Side;
use crate::diagnose::simulator::subject::Subject;
use crate::outcome::finding::{Finding, UNNAMED};
use crate::outcome::simulator::{Contrast, Simulator};

/// A number to four digits, without trailing zeros.
fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let decimals = (3 - value.abs().log10().floor() as i32).max(0) as usize;
    match (1e-4..1e6).contains(&value.abs()) {
        true => {
            let text = format!("{value:.decimals$}");
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
                false => text,
            }
        }
        false => format!("{value:.3e}"),
    }
}

/// A value with its standard deviation at two digits.
fn with_deviation(value: f64, std_dev: f64) -> String {
    let exponent = std_dev.log10().floor();
    if !exponent.is_finite() || !(-9.0..4.0).contains(&exponent) {
        return short(value);
    }
    let decimals = (1 - exponent as i32).max(0) as usize;
    format!("{value:.decimals$} ± {std_dev:.decimals$}")
}

/// A parameter by name and in words.
fn called(contrast: &Contrast, robot: &Side<'_>) -> String {
    let mut all = robot.estimate.parameters.iter();
    let own = all.find(|p| p.name == contrast.parameter);
    match own.filter(|p| !p.description.is_empty()) {
        Some(parameter) => format!("{} ({})", contrast.parameter, parameter.description),
        None => contrast.parameter.clone(),
    }
}

fn unit(contrast: &Contrast) -> String {
    match contrast.unit.is_empty() || contrast.unit == "1" {
        true => String::new(),
        false => format!(" {}", contrast.unit),
    }
}

/// Both values, and the interval of the difference.
fn values(contrast: &Contrast) -> String {
    let [low, high] = contrast.ci95.unwrap_or([f64::NAN; 2]);
    format!(
        "{}{unit}; on the robot {}: a difference of {}{unit} (95 %: {} to {})",
        with_deviation(contrast.simulated, contrast.simulated_std_dev),
        with_deviation(contrast.robot, contrast.robot_std_dev),
        short(contrast.difference),
        short(low),
        short(high),
        unit = unit(contrast),
    )
}

pub(super) fn contrast(contrast: &Contrast, robot: &Side<'_>) -> String {
    let name = called(contrast, robot);
    let share = match contrast.share_of_signal.is_finite() {
        true => format!(", {} % of the signal", percent(contrast.share_of_signal)),
        false => String::new(),
    };
    format!("In the simulation {name} is {}{share}.", values(contrast))
}

/// A share to two digits in percent.
fn percent(share: f64) -> String {
    let value = 100.0 * share;
    let decimals = (1 - value.log10().floor() as i32).max(0) as usize;
    format!("{value:.decimals$}")
}

/// What a model leaves of signals beyond their noise, as shares of them by joint.
pub(super) fn left_unexplained(subject: Subject, shares: &[(String, f64)]) -> String {
    let shares: Vec<String> = shares
        .iter()
        .map(|(joint, share)| format!("{} % of {joint}", percent(*share)))
        .collect();
    let of = match subject {
        Subject::Robot => "robot",
        Subject::Simulator => "simulation",
    };
    format!(
        "Of the {of}'s signals its model leaves {} unexplained, beyond their noise: differences that make little more of the \
         signal than that may come of what is not in the model, such as a filter between sensor and file, and intervals do not \
         count it.",
        shares.join(", ")
    )
}

/// Of an effect whose size one of the two has at none.
pub(super) fn alone(subject: Subject, contrast: &Contrast) -> String {
    let (one, other) = match subject {
        Subject::Robot => ("the robot", "the simulation has none of it"),
        Subject::Simulator => ("the simulation", "the robot has none of it"),
    };
    format!(
        "Only {one} has {}: in the simulation it is {}, so that {other} that shows.",
        contrast.parameter,
        values(contrast)
    )
}

pub(super) fn finding_alone(subject: Subject, finding: &Finding) -> String {
    let what = finding.sentence.split(';').next().unwrap_or_default();
    let what = what.trim_end_matches('.');
    match subject {
        Subject::Robot => {
            format!("Only on the robot: {what}; in the simulation nothing of it shows.")
        }
        Subject::Simulator => {
            format!("Only in the simulation: {what}; on the robot nothing of it shows.")
        }
    }
}

pub(super) fn not_told_apart(subject: Subject, finding: &Finding, other: &str) -> String {
    let (here, there) = match subject {
        Subject::Robot => ("robot", "simulation"),
        Subject::Simulator => ("simulation", "robot"),
    };
    let own = match finding.has_no_name() {
        true => "What has no name",
        false => &finding.effect,
    };
    let other = match other == UNNAMED {
        true => "what has no name",
        false => other,
    };
    format!(
        "{} of {} in the {here} and {other} in the {there} are physics that the recordings do not tell apart, and count as \
         neither equal nor different.",
        own,
        finding.joints.join(", ")
    )
}

pub(super) fn summary(simulator: &Simulator) -> String {
    let count = |n: usize, one: &str, many: &str| match n {
        1 => format!("one {one}"),
        n => format!("{n} {many}"),
    };
    format!(
        "Of {} that both show, {} between simulation and robot; {} on the robot alone, {} in the simulation alone.",
        count(simulator.compared, "quantity", "quantities"),
        match simulator.differences.len() {
            0 => "none differs".to_string(),
            1 => "one differs".to_string(),
            n => format!("{n} differ"),
        },
        count(simulator.only_robot.len(), "effect is", "effects are"),
        count(simulator.only_simulator.len(), "effect", "effects"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_they_are_worth() {
        for (value, text) in [
            (0.0, "0"),
            (1.5, "1.5"),
            (-18.914, "-18.91"),
            (1234.56, "1235"),
            (0.000123456, "0.0001235"),
            (2.5e7, "2.500e7"),
            (6e-12, "6.000e-12"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(short(value), text);
        }
        for (value, std_dev, text) in [
            (5.0123, 0.0123, "5.012 ± 0.012"),
            (310.4, 25.0, "310 ± 25"),
            (3.0, 0.0, "3"),
            (3.0, 2.0e5, "3"),
        ] {
            assert_eq!(with_deviation(value, std_dev), text);
        }
    }
}
