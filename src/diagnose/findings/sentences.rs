//! What a finding means, in a sentence that a plant engineer understands.

use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::outcome::parameter::Parameter;

/// What was wrong with the declared model, of a finding with its parameters.
pub fn sentence(hypothesis: &Hypothesis, joints: &[String], parameters: &[Parameter]) -> String {
    let who = list(joints);
    let parameter = |name: &str| {
        let suffix = format!(".{name}");
        let found = parameters.iter().find(|p| p.name.ends_with(&suffix));
        found.and_then(|p| p.value.map(|value| (value, p.unit.clone())))
    };
    let size = |name: &str| parameter(name).map(|(value, unit)| format!("{} {unit}", short(value)));
    let with = |text: &str, name: &str, lacking: &str| match size(name) {
        Some(size) => format!("{who} {text} {size}; {lacking}"),
        None => format!("{who}: {lacking}"),
    };
    match hypothesis.effect.id {
        "transmission_efficiency" => {
            let loss = parameter("R").map_or(f64::NAN, |(r, _)| 100.0 * (1.0 - r));
            format!("{who} loses {loss:.0} % of the torque that it transmits; the model had a lossless gearbox")
        }
        "load_dependent_friction" => {
            let share = parameter("mu").map_or(f64::NAN, |(mu, _)| 100.0 * mu);
            format!("Friction of {who} grows with the load that it carries, by {share:.1} % of it; the model's friction did not know the load")
        }
        "stribeck_friction" => with("sticks at low speed: near standstill its friction is higher by", "Fs", "the model had the same dry friction at every speed"),
        "presliding_hysteresis" => with("does not break loose at once: before it slides, its friction acts like a spring of", "sigma0", "the model switched friction with the sign of the speed"),
        "asymmetric_friction" if size("dFc").is_none() => with("has friction that depends on the direction of motion; with speed the difference grows by", "dFv", "the model had the same in both directions"),
        "asymmetric_friction" | "torque_offset" => with("needs more torque in one direction than in the other, half the difference being", if hypothesis.effect.id == "torque_offset" { "offset" } else { "dFc" }, "the model was the same in both (a constant offset of the signal is the same torque)"),
        "sigmoid_friction" => format!("Friction of {who} switches smoothly, and off standstill, like a sigmoid of speed; the model's switched with the direction"),
        "viscous_nonlinearity" => format!("Friction of {who} is not proportional to speed; the model's viscous friction was"),
        "torque_ripple" => with("has a torque that repeats along its turn, of amplitude", "amplitude", "the model had a smooth drive"),
        "kinematic_coupling" => format!("The motor of one joint moves another too ({who}); the model took every motor for one joint's"),
        "joint_elasticity" => with("is not rigid between motor and link, its stiffness being", "K", "the model had a rigid gearbox"),
        "backlash" => with("has play between motor and link of", "gap", "the model had none"),
        "joint_spring" => with("is pulled by a spring of", "k", "the model had none: look for a gravity compensator, a hose or a cable"),
        "unmodelled_payload" => format!("Something hangs on the link that {who} moves; the model did not carry it"),
        "base_tilt" => "The base does not stand as the model says: gravity comes from elsewhere (this may be a mistake of the mounting in the problem file)".to_string(),
        "time_delay" => {
            let delay = size("delay").map_or(String::new(), |delay| format!(" by {delay}"));
            format!("The torque signal of {who} is late{delay}; the model took motion and signal for simultaneous (this may be a mistake of the recording)")
        }
        "thermal_drift" => format!("Friction of {who} changes while the recording runs: the joint warms up; the model's friction was constant"),
        "external_contact" => with("was pushed by something during the recording, with", "torque", "the model moved freely"),
        "position_dependent_friction" => with("has a spot in its range where friction differs by", "dF", "the model's friction was the same everywhere"),
        "torque_current_nonlinearity" => format!("The torque of {who} is not proportional to its current; the model had one torque constant"),
        "drive_gain" => match parameter("gain") {
            Some((gain, _)) => format!("The torque constant of {who} is {} times the declared one", short(gain)),
            None => format!("The torque constant of {who} is not the declared one"),
        },
        "rotor_inertia" => with("has a rotor and gear whose inertia at the joint is", "Jm", "the model had none"),
        "coulomb_friction" => with("has dry friction of", "Fc", "the model had none"),
        "viscous_friction" => with("has friction that grows with speed, by", "Fv", "the model had none"),
        _ => format!("{who}: {}", hypothesis.effect.sentence.trim_end_matches('.')),
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

/// Three significant digits.
pub fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let digits = (2 - value.abs().log10().floor() as i32).clamp(0, 9) as usize;
    format!("{value:.digits$}")
}
