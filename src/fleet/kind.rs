//! What a change of a parameter means to the people who look after the robot.

use crate::chain::effect;
use crate::chain::effect::knowledge::Change;

/// The kind of a change, and the joint that it belongs to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Kind {
    /// What it means, such as `friction up`.
    pub words: String,
    /// Absent where it belongs to no joint.
    pub joint: Option<String>,
}

/// The body of a load, and its mass.
const LOAD: &str = "payload";

/// The kind of a change of a parameter by its name; `change` is positive where it grows.
pub fn of(parameter: &str, change: f64) -> Kind {
    let parts: Vec<&str> = parameter.split('.').collect();
    let (words, joint) = match parts[..] {
        [joint, effect, _] => (of_effect(effect, change), Some(joint.to_string())),
        [LOAD, "mass"] if change > 0.0 => ("load left on", None),
        [LOAD, "mass"] => ("load lost", None),
        [LOAD, _] => ("other load", None),
        [effect, _] if change_of(effect).is_some() => (of_effect(effect, change), None),
        [_, _] => ("other link", None),
        _ => ("combination of parameters", None),
    };
    Kind {
        words: words.to_string(),
        joint,
    }
}

fn change_of(effect: &str) -> Option<Change> {
    effect::find(effect)?.knowledge.change
}

fn of_effect(effect: &str, change: f64) -> &'static str {
    change_of(effect).map_or("physics of the drive", |words| match change > 0.0 {
        true => words.up,
        false => words.down,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_have_words_and_joints() {
        for (parameter, change, words, joint) in [
            ("a3.coulomb_friction.Fc", 1.0, "friction up", Some("a3")),
            (
                "a3.transmission_efficiency.R",
                -0.1,
                "efficiency down",
                Some("a3"),
            ),
            ("payload.mass", 2.0, "load left on", None),
            ("payload.com_x", 0.1, "other load", None),
            ("a1.time_delay.delay", 0.01, "delay up", Some("a1")),
            (
                "a2.encoder_offset.offset",
                -0.01,
                "encoder offset",
                Some("a2"),
            ),
            ("base_tilt.pitch", 0.1, "base tilted", None),
            ("link2.mass", 0.1, "other link", None),
            (
                "link2.mcx + 0.4*link3.m",
                0.1,
                "combination of parameters",
                None,
            ),
        ] {
            let kind = of(parameter, change);
            assert_eq!(
                (kind.words.as_str(), kind.joint.as_deref()),
                (words, joint),
                "{parameter}"
            );
        }
    }
}
