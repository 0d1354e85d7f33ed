//! What a finding means, in a sentence that a plant engineer understands.

use crate::chain::model::{Model, Signal};
use crate::diagnose::fit::hypothesis::{Hypothesis, joint_names};
use crate::outcome::parameter::Parameter;

/// What was wrong with the declared model, of a finding of a model with its parameters.
pub fn sentence(hypothesis: &Hypothesis, model: &Model, parameters: &[Parameter]) -> String {
    let who = list(&joint_names(model, &hypothesis.named_joints()));
    let found = Found { parameters };
    let with = |text: &str, name: &str, lacking: &str| match found.quantity(name) {
        Some(size) => format!("{who} {text} {size}; {lacking}"),
        None => format!("{who}: {lacking}"),
    };
    match hypothesis.effect.id {
        "transmission_efficiency" => {
            // What lies beyond a lossless gearbox is the interval's, not the gearbox's.
            let loss = found.scaled("R", "%", |r| 100.0 * (1.0 - r).max(0.0));
            let loss = loss.unwrap_or_else(|| "part".to_string());
            format!(
                "{who} loses {loss} of the torque that it transmits; the model had a lossless gearbox"
            )
        }
        "load_dependent_friction" => {
            let share = found.scaled("mu", "%", |mu| 100.0 * mu.max(0.0));
            let share = share.map_or_else(String::new, |share| format!(", by {share} of it"));
            format!(
                "Friction of {who} grows with the load that it carries{share}; the model's friction did not know the load"
            )
        }
        "stribeck_friction" => with(
            "sticks at low speed: near standstill its friction is higher by",
            "Fs",
            "the model had the same dry friction at every speed",
        ),
        "presliding_hysteresis" => with(
            "does not break loose at once: before it slides, its friction acts like a spring of",
            "sigma0",
            "the model switched friction with the sign of the speed",
        ),
        "torque_offset" => with(
            "needs more torque in one direction than in the other, half the difference being",
            "offset",
            SAME_TORQUE,
        ),
        "asymmetric_friction" => match found.quantity("dFc") {
            Some(_) => with(
                "needs more torque in one direction than in the other, half the difference being",
                "dFc",
                SAME_TORQUE,
            ),
            None => with(
                "has friction that depends on the direction of motion; with speed the difference grows by",
                "dFv",
                "the model had the same in both directions",
            ),
        },
        "sigmoid_friction" => format!(
            "Friction of {who} switches smoothly, and off standstill, like a sigmoid of speed; the model's switched with the direction"
        ),
        "viscous_nonlinearity" => format!(
            "Friction of {who} is not proportional to speed; the model's viscous friction was"
        ),
        "torque_ripple" => match found.value("order") {
            Some(order) => with(
                &format!(
                    "has a torque that repeats {} times along its turn, of amplitude",
                    short(order)
                ),
                "amplitude",
                "the model had a smooth drive",
            ),
            None => with(
                "has a torque that repeats along its turn, of amplitude",
                "amplitude",
                "the model had a smooth drive",
            ),
        },
        "kinematic_coupling" => coupling(hypothesis, model, &found),
        "joint_elasticity" => with(
            "is not rigid between motor and link, its stiffness being",
            "K",
            "the model had a rigid gearbox",
        ),
        "backlash" => with(
            "has play between motor and link of",
            "gap",
            "the model had none",
        ),
        "joint_spring" => with(
            "is pulled by a spring of",
            "k",
            "the model had none: look for a gravity compensator, a hose or a cable",
        ),
        "unmodelled_payload" => load(&who, &found),
        "base_tilt" => tilt(&found),
        "time_delay" => {
            let delay = found.scaled("delay", "ms", |s| 1e3 * s);
            let delay = delay.map_or_else(String::new, |delay| format!(" by {delay}"));
            if model.signal() == Signal::PositionCommand {
                return format!(
                    "The command acts on {who} late{delay}; the model took it to act at once"
                );
            }
            format!(
                "The torque signal of {who} is late{delay}; the model took motion and signal for simultaneous (this may be a mistake of the recording)"
            )
        }
        "thermal_drift" => match (found.quantity("gain"), found.quantity("time_constant")) {
            (Some(gain), Some(time)) => format!(
                "Friction of {who} changes while the recording runs, by {gain} with a time constant of {time}: the joint warms up; the model's friction was constant"
            ),
            _ => format!(
                "Friction of {who} changes while the recording runs: the joint warms up; the model's friction was constant"
            ),
        },
        "external_contact" => {
            let when = match (found.value("from"), found.value("to")) {
                (Some(from), Some(to)) => format!(" from {} s to {} s", short(from), short(to)),
                _ => String::new(),
            };
            with(
                &format!("was pushed by something during the recording{when}, with"),
                "torque",
                "the model moved freely",
            )
        }
        "position_dependent_friction" => with(
            "has a spot in its range where friction differs by",
            "dF",
            "the model's friction was the same everywhere",
        ),
        "torque_current_nonlinearity" => format!(
            "The torque of {who} is not proportional to its current; the model had one torque constant"
        ),
        "drive_gain" => gain(&who, model.signal(), &found),
        "rotor_inertia" => with(
            "has a rotor and gear whose inertia at the joint is",
            "Jm",
            "the model had none",
        ),
        "coulomb_friction" => with("has dry friction of", "Fc", "the model had none"),
        "viscous_friction" => with(
            "has friction that grows with speed, by",
            "Fv",
            "the model had none",
        ),
        _ => format!(
            "{who}: {}",
            hypothesis.effect.sentence.trim_end_matches('.')
        ),
    }
}

const SAME_TORQUE: &str =
    "the model was the same in both (a constant offset of the signal is the same torque)";

/// The parameters that a finding has brought, by the last part of their names.
struct Found<'a> {
    parameters: &'a [Parameter],
}

impl Found<'_> {
    fn of(&self, name: &str) -> Option<&Parameter> {
        let named = |p: &&Parameter| p.name.rsplit('.').next() == Some(name);
        self.parameters.iter().find(named)
    }

    fn value(&self, name: &str) -> Option<f64> {
        self.of(name)?.value
    }

    /// `12.3 N·m (95 %: 11.9 to 12.7)`.
    fn quantity(&self, name: &str) -> Option<String> {
        self.scaled(name, &self.of(name)?.unit, |x| x)
    }

    /// The same in another unit.
    fn scaled(&self, name: &str, unit: &str, of: impl Fn(f64) -> f64) -> Option<String> {
        let parameter = self.of(name)?;
        let value = of(parameter.value?);
        let size = format!("{} {unit}", short(value));
        Some(match parameter.ci95 {
            Some(ends) => {
                let [one, other] = ends.map(of);
                let (low, high) = (one.min(other), one.max(other));
                format!(
                    "{} (95 %: {} to {})",
                    size.trim_end(),
                    short(low),
                    short(high)
                )
            }
            None => size.trim_end().to_string(),
        })
    }
}

fn coupling(hypothesis: &Hypothesis, model: &Model, found: &Found<'_>) -> String {
    let lacking = "the model took every motor for one joint's";
    let moved = joint_names(model, &hypothesis.joints);
    let motor = joint_names(model, hypothesis.other.as_slice());
    let by = motor.first().and_then(|motor| found.quantity(motor));
    let by = by.map_or_else(String::new, |by| format!(", by {by} of its own motion"));
    format!(
        "The motor of {} moves {} too{by}; {lacking}",
        list(&motor),
        list(&moved)
    )
}

fn load(who: &str, found: &Found<'_>) -> String {
    let what = match found.quantity("mass") {
        Some(mass) => format!("A load of {mass}"),
        None => "Something".to_string(),
    };
    let centre = ["com_x", "com_y", "com_z"].map(|name| found.value(name));
    let place = match centre {
        [Some(x), Some(y), Some(z)] => {
            format!(
                ", its centre of mass at ({}, {}, {}) m",
                short(x),
                short(y),
                short(z)
            )
        }
        _ => String::new(),
    };
    format!("{what} hangs on the link that {who} moves{place}; the model did not carry it")
}

fn tilt(found: &Found<'_>) -> String {
    let angle = |name: &str| {
        let degrees = found.scaled(name, "°", f64::to_degrees)?;
        Some(format!("{name} {degrees}"))
    };
    let angles: Vec<String> = ["roll", "pitch"].into_iter().filter_map(angle).collect();
    let by = match angles.is_empty() {
        true => String::new(),
        false => format!(", {}", list(&angles)),
    };
    format!(
        "The base does not stand as the model says{by}: gravity comes from elsewhere (this may be a mistake of the mounting in the problem file)"
    )
}

/// A torque sensor has no torque constant.
fn gain(who: &str, signal: Signal, found: &Found<'_>) -> String {
    let factor = found.quantity("gain");
    if signal == Signal::PositionCommand {
        let factor = factor.map_or_else(|| "not one times".to_string(), |f| format!("{f} times"));
        return format!("The gains of the controller of {who} are {factor} the declared ones");
    }
    let is_current = signal == Signal::Current;
    match (is_current, factor) {
        (true, Some(factor)) => {
            format!("The torque constant of {who} is {factor} times the declared one")
        }
        (true, None) => format!("The torque constant of {who} is not the declared one"),
        (false, Some(factor)) => format!("The torque of {who} is {factor} times the recorded one"),
        (false, None) => format!("The torque of {who} is not the recorded one"),
    }
}

/// How much a finding helps.
pub fn improvement(before: f64, after: f64, unit: &str) -> String {
    format!(
        "the error on recordings that were not fitted falls from {} to {} {unit}",
        short(before),
        short(after)
    )
}

/// What is left of a joint and is not known to be noise.
pub fn unattested(joint: &str, residual: f64, unit: &str, of_signal: f64) -> String {
    format!(
        "{joint}: the error on recordings that were not fitted is {} {unit}, {:.0} % of the signal, and nothing in them \
         says that this is noise",
        short(residual),
        100.0 * of_signal
    )
}

/// `joint1`, `joint1 and joint2`, `joint1, joint2 and joint3`.
pub fn list(names: &[String]) -> String {
    match names {
        [] => "the robot".to_string(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Sizes below this, in any unit of a finding, are rounding and nothing else.
const ROUNDING: f64 = 1e-12;

/// Decimal exponents outside of which a number is written with its exponent.
const PLAIN_EXPONENTS: std::ops::Range<i32> = -6..7;

/// Three significant digits: `0.0123`, `-18.9`, `2.50e7`; `0` for what is rounding.
pub fn short(value: f64) -> String {
    if value.abs() < ROUNDING || !value.is_finite() {
        return format!("{}", if value.is_finite() { 0.0 } else { value });
    }
    let exponent = value.abs().log10().floor() as i32;
    if !PLAIN_EXPONENTS.contains(&exponent) {
        return format!("{value:.2e}");
    }
    let digits = (2 - exponent).max(0) as usize;
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_sentences_have_three_digits_and_no_endless_zeros() {
        for (value, text) in [
            (0.0, "0"),
            (6e-120, "0"),
            (-6e-120, "0"),
            (0.0123, "0.0123"),
            (-18.91, "-18.9"),
            (1234.5, "1234"),
            (3.0e-8, "3.00e-8"),
            (2.5e7, "2.50e7"),
        ] {
            assert_eq!(short(value), text);
        }
    }

    /// An interval that reaches beyond a lossless gearbox reaches no negative loss.
    #[test]
    fn a_loss_is_never_negative() {
        let efficiency = Parameter {
            ci95: Some([0.97, 1.01]),
            ..Parameter::known("a3.transmission_efficiency.R", "", 0.99)
        };
        let found = Found {
            parameters: &[efficiency],
        };
        let loss = found.scaled("R", "%", |r| 100.0 * (1.0 - r).max(0.0));
        assert_eq!(loss.unwrap(), "1.00 % (95 %: 0 to 3.00)");
    }
}
