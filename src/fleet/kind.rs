//! What a change of a parameter means to the people who look after the robot.

use crate::chain::effect::{
    asymmetric_friction, base_tilt, coulomb_friction, drive_gain, encoder_offset, joint_elasticity,
    joint_spring, load_dependent_friction, presliding_hysteresis, rotor_inertia, sigmoid_friction,
    stribeck_friction, time_delay, torque_offset, transmission_efficiency, viscous_friction,
    viscous_nonlinearity,
};

/// The kind of a change, and the joint that it belongs to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Kind {
    pub words: String,
    pub joint: Option<String>,
}

/// Words for one direction and the other.
struct Words {
    up: &'static str,
    down: &'static str,
}

const FRICTION: Words = Words {
    up: "friction up",
    down: "friction down",
};

/// Words by effect.
const EFFECTS: &[(&str, Words)] = &[
    (coulomb_friction::EFFECT.id, FRICTION),
    (viscous_friction::EFFECT.id, FRICTION),
    (stribeck_friction::EFFECT.id, FRICTION),
    (viscous_nonlinearity::EFFECT.id, FRICTION),
    (sigmoid_friction::EFFECT.id, FRICTION),
    (presliding_hysteresis::EFFECT.id, FRICTION),
    (
        asymmetric_friction::EFFECT.id,
        Words {
            up: "friction by direction",
            down: "friction by direction",
        },
    ),
    (
        transmission_efficiency::EFFECT.id,
        Words {
            up: "efficiency up",
            down: "efficiency down",
        },
    ),
    (
        load_dependent_friction::EFFECT.id,
        Words {
            up: "efficiency down",
            down: "efficiency up",
        },
    ),
    (
        time_delay::EFFECT.id,
        Words {
            up: "delay up",
            down: "delay down",
        },
    ),
    (
        torque_offset::EFFECT.id,
        Words {
            up: "torque offset",
            down: "torque offset",
        },
    ),
    (
        drive_gain::EFFECT.id,
        Words {
            up: "torque constant up",
            down: "torque constant down",
        },
    ),
    (
        rotor_inertia::EFFECT.id,
        Words {
            up: "rotor inertia up",
            down: "rotor inertia down",
        },
    ),
    (
        joint_elasticity::EFFECT.id,
        Words {
            up: "stiffness of the gear",
            down: "stiffness of the gear",
        },
    ),
    (
        joint_spring::EFFECT.id,
        Words {
            up: "spring or balancer",
            down: "spring or balancer",
        },
    ),
    (
        encoder_offset::EFFECT.id,
        Words {
            up: "encoder offset",
            down: "encoder offset",
        },
    ),
    (
        base_tilt::EFFECT.id,
        Words {
            up: "base tilted",
            down: "base tilted",
        },
    ),
];

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
        [effect, _] if EFFECTS.iter().any(|(id, _)| *id == effect) => {
            (of_effect(effect, change), None)
        }
        [_, _] => ("other link", None),
        _ => ("combination of parameters", None),
    };
    Kind {
        words: words.to_string(),
        joint,
    }
}

fn of_effect(effect: &str, change: f64) -> &'static str {
    let found = EFFECTS.iter().find(|(id, _)| *id == effect);
    found.map_or("physics of the drive", |(_, words)| match change > 0.0 {
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
