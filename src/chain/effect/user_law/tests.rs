//! Laws of one's own: slopes against differences, states against an independent integration, what is linear, what is refused.

use super::{ActsOn, LawFault, LawText, ParameterText, Part, SearchText, StateText, effect};
use crate::chain::effect::{
    Contribution, Dependence, Effect, Law, Linearity, Memory, Samples, Surroundings, Transmitted,
};

fn parameter(name: &str, unit: &str, typical: f64) -> ParameterText {
    ParameterText {
        name: name.into(),
        unit: (!unit.is_empty()).then(|| unit.into()),
        meaning: "of a test".into(),
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        typical,
        search: SearchText::Typical,
    }
}

fn law(acts_on: ActsOn, torque: &str, parameters: &[ParameterText]) -> LawText {
    LawText {
        id: "of_a_test".into(),
        sentence: "A law of a test.".into(),
        source: String::new(),
        acts_on,
        torque: torque.into(),
        states: Vec::new(),
        parameters: parameters.to_vec(),
        refines: Vec::new(),
    }
}

fn with_states(mut law: LawText, rates: &[&str]) -> LawText {
    law.states = rates
        .iter()
        .map(|rate| StateText {
            rate: (*rate).into(),
            start: None,
        })
        .collect();
    law
}

/// A motion that turns round, with everything that laws may depend on.
struct Motion {
    position: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    sign: Vec<f64>,
    time: Vec<f64>,
    load: Vec<f64>,
}

const SAMPLES: usize = 150;
const STEP: f64 = 0.01;

impl Motion {
    fn new() -> Self {
        let time: Vec<f64> = (0..SAMPLES).map(|k| STEP * k as f64).collect();
        let of = |f: fn(f64) -> f64| time.iter().map(|t| f(*t)).collect::<Vec<f64>>();
        let velocity = of(|t| 0.8 * (5.0 * t + 0.2).cos());
        Self {
            position: of(|t| 0.16 * (5.0 * t + 0.2).sin()),
            acceleration: of(|t| -4.0 * (5.0 * t + 0.2).sin()),
            sign: velocity.iter().map(|v| v / (v.abs() + 0.05)).collect(),
            load: of(|t| 3.0 * (3.0 * t + 0.1).sin()),
            velocity,
            time,
        }
    }

    fn samples(&self) -> Samples<'_> {
        Samples {
            position: &self.position,
            velocity: &self.velocity,
            acceleration: &self.acceleration,
            sign: &self.sign,
            time: &self.time,
            cyclic: false,
            surroundings: Surroundings {
                torque_constant: Some(2.0),
                ..Surroundings::default()
            },
        }
    }
}

/// Torque and slopes by parameters, then by the load, the sign, the position and the velocity.
struct Evaluated {
    torque: Vec<f64>,
    slopes: Vec<Vec<f64>>,
}

fn evaluate(effect: &Effect, motion: &Motion, parameters: &[f64]) -> Evaluated {
    let zeros = || vec![0.0; SAMPLES];
    let mut by_parameter = vec![zeros(); parameters.len()];
    let (mut torque, mut by_load, mut by_sign) = (zeros(), zeros(), zeros());
    let (mut by_position, mut by_velocity) = (zeros(), zeros());
    match effect.law {
        Law::Motor(law) | Law::Joint(law) => law.add(
            motion.samples(),
            parameters,
            &mut Contribution {
                torque: &mut torque,
                by_parameter: &mut by_parameter,
                by_sign: &mut by_sign,
                by_position: &mut by_position,
                by_velocity: &mut by_velocity,
            },
        ),
        Law::Transmission(law) | Law::Signal(law) => law.add(
            motion.samples(),
            &motion.load,
            parameters,
            &mut Transmitted {
                torque: &mut torque,
                by_load: &mut by_load,
                by_parameter: &mut by_parameter,
                by_sign: &mut by_sign,
                rounding: 0.0,
            },
        ),
        _ => unreachable!(),
    }
    by_parameter.extend([by_load, by_sign, by_position, by_velocity]);
    Evaluated {
        torque,
        slopes: by_parameter,
    }
}

fn texts() -> Vec<(LawText, Vec<f64>)> {
    let p = parameter;
    vec![
        (
            law(
                ActsOn::Motor,
                "a*tau*sin(n*q + phi)",
                &[p("a", "1", 0.1), p("n", "", 8.0), p("phi", "rad", 0.3)],
            ),
            vec![0.1, 8.0, 0.3],
        ),
        (
            law(
                ActsOn::Joint,
                "k*(q - q0)^3 + d*v*abs(q) + F*sign(v)",
                &[
                    p("k", "", 3.0),
                    p("q0", "rad", 0.02),
                    p("d", "", 0.4),
                    p("F", "N·m", 0.5),
                ],
            ),
            vec![3.0, 0.02, 0.4, 0.5],
        ),
        (
            law(
                ActsOn::Gain,
                "1 - b*i^2 - c*abs(i*v)",
                &[p("b", "1/A^2", 0.01), p("c", "", 0.02)],
            ),
            vec![0.01, 0.02],
        ),
        (
            law(
                ActsOn::Signal,
                "d*tanh(i/w) + e*acc",
                &[p("d", "N·m", 0.7), p("w", "A", 0.3), p("e", "kg·m^2", 0.1)],
            ),
            vec![0.7, 0.3, 0.1],
        ),
        (
            with_states(
                law(
                    ActsOn::Motor,
                    "k1*z1 + k2*z2 + c*v",
                    &[
                        p("k1", "", 30.0),
                        p("k2", "", 10.0),
                        p("c", "", 0.2),
                        p("d1", "", 0.01),
                        p("d2", "", 0.05),
                    ],
                ),
                &["v - abs(v)*z1/d1", "v - abs(v)*z2^3/d2^3"],
            ),
            vec![30.0, 10.0, 0.2, 0.01, 0.05],
        ),
    ]
}

#[test]
fn matches_differences_in_parameters_load_sign_and_motion() {
    for (text, values) in texts() {
        let effect = effect(&text).unwrap();
        let motion = Motion::new();
        let here = evaluate(effect, &motion, &values);
        let count = values.len();
        let remembers = !text.states.is_empty();
        let at_joint = text.acts_on == ActsOn::Joint;
        for direction in 0..count + 4 {
            let is_motion = direction >= count + 2;
            if is_motion && !at_joint || remembers && direction >= count {
                continue;
            }
            let at = |h: f64| {
                let (mut moved, mut values) = (Motion::new(), values.clone());
                let series = match direction.checked_sub(count) {
                    None => {
                        values[direction] += h;
                        None
                    }
                    Some(0) => Some(&mut moved.load),
                    Some(1) => Some(&mut moved.sign),
                    Some(2) => Some(&mut moved.position),
                    Some(_) => Some(&mut moved.velocity),
                };
                if let Some(series) = series {
                    series.iter_mut().for_each(|x| *x += h);
                }
                evaluate(effect, &moved, &values).torque
            };
            let h = 1e-6;
            for (k, (high, low)) in at(h).iter().zip(at(-h)).enumerate() {
                let (exact, difference) = (here.slopes[direction][k], (high - low) / (2.0 * h));
                let error = (exact - difference).abs();
                assert!(
                    error <= 1e-7 * exact.abs().max(1.0),
                    "{} direction {direction} sample {k}: {exact} {difference}",
                    text.torque
                );
            }
        }
    }
}

#[test]
fn matches_a_fourth_order_integration_of_the_state() {
    let (text, values) = texts().pop().unwrap();
    let motion = Motion::new();
    let found = evaluate(effect(&text).unwrap(), &motion, &values).torque;
    // Runge and Kutta's method in a hundred steps from sample to sample, v linear between them.
    let rate = |z: [f64; 2], v: f64| {
        let [d1, d2] = [values[3], values[4]];
        [v - v.abs() * z[0] / d1, v - v.abs() * (z[1] / d2).powi(3)]
    };
    let mut z = [0.0; 2];
    let mut worst: f64 = 0.0;
    for k in 1..SAMPLES {
        let (from, to) = (motion.velocity[k - 1], motion.velocity[k]);
        let steps = 100;
        let h = STEP / steps as f64;
        for step in 0..steps {
            let v = |share: f64| from + (to - from) * (step as f64 + share) / steps as f64;
            let moved = |by: [f64; 2], h: f64| [z[0] + h * by[0], z[1] + h * by[1]];
            let a = rate(z, v(0.0));
            let b = rate(moved(a, h / 2.0), v(0.5));
            let c = rate(moved(b, h / 2.0), v(0.5));
            let d = rate(moved(c, h), v(1.0));
            for i in 0..2 {
                z[i] += h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
            }
        }
        let expected = values[0] * z[0] + values[1] * z[1] + values[2] * motion.velocity[k];
        worst = worst.max((found[k] - expected).abs());
    }
    // The parts of a step are 2.5 ms, in which the state moves by a fifth of its range: the error of the second order.
    assert!(worst < 4e-3, "{worst}");
}

#[test]
fn parameters_in_which_the_torque_is_affine_are_linear_unknowns() {
    let text = law(
        ActsOn::Motor,
        "a*sin(n*q) + b*cos(n*q) + c*d*v",
        &["a", "b", "n", "c", "d"].map(|name| parameter(name, "", 1.0)),
    );
    let found: Vec<Linearity> = effect(&text)
        .unwrap()
        .parameters
        .iter()
        .map(|p| p.linearity)
        .collect();
    use Linearity::{Linear, Nonlinear};
    assert_eq!(found, [Linear, Linear, Nonlinear, Linear, Nonlinear]);
}

#[test]
fn what_a_law_depends_on_follows_from_its_formula() {
    let of =
        |torque: &str| effect(&law(ActsOn::Motor, torque, &[parameter("a", "", 1.0)])).unwrap();
    assert_eq!(of("a").depends_on, [Dependence::Nothing]);
    assert_eq!(
        of("a*sign(v)*q").depends_on,
        [
            Dependence::Position,
            Dependence::Speed,
            Dependence::Direction
        ]
    );
    let warm = of("a*exp(-a*T)*v");
    assert_eq!(warm.needs.memory, Memory::Time);
    let beside = of("a*v[next]*q[joint1]");
    assert_eq!(beside.needs.others, ["next", "joint1"]);
    assert!(matches!(of("a*tau").law, Law::Transmission(_)));
}

#[test]
fn the_same_text_is_the_same_effect() {
    let text = law(ActsOn::Motor, "a*q^2", &[parameter("a", "", 1.0)]);
    assert!(std::ptr::eq(effect(&text).unwrap(), effect(&text).unwrap()));
}

#[test]
fn proportional_losses_are_told_from_others() {
    let of = |torque: &str| {
        let text = law(ActsOn::Motor, torque, &[parameter("a", "", 0.3)]);
        match effect(&text).unwrap().law {
            Law::Transmission(law) => law.is_proportional(),
            _ => unreachable!(),
        }
    };
    assert!(of("a*abs(tau)*sign(v)") && of("a*max(tau, 0)"));
    assert!(!of("a*tau^2") && !of("a*tanh(a*tau)"));
}

#[test]
fn faults_name_the_part_and_the_remedy() {
    let one = || [parameter("a", "N·m", 1.0)];
    let fault = |text: LawText| effect(&text).unwrap_err();
    let bad = fault(law(ActsOn::Motor, "a*sinn(q)", &one()));
    assert_eq!((bad.part, bad.code()), (Part::Torque, "formula"));
    assert!(
        bad.message().contains("character 3 of \"a*»sinn(q)\""),
        "{}",
        bad.message()
    );
    assert!(
        bad.remedy().contains("did you mean \"sin\""),
        "{}",
        bad.remedy()
    );
    let bad = fault(law(ActsOn::Motor, "a*i", &one()));
    assert!(matches!(
        bad.fault,
        LawFault::NotKnownHere { variable: "i", .. }
    ));
    let bad = fault(law(ActsOn::Joint, "a*tau", &one()));
    assert!(matches!(
        bad.fault,
        LawFault::NotKnownHere {
            variable: "tau",
            ..
        }
    ));
    let bad = fault(law(ActsOn::Motor, "a*v", &one()));
    assert_eq!(bad.code(), "law-unit");
    let bad = fault(law(ActsOn::Motor, "a + b", &[parameter("a", "", 1.0)]));
    assert_eq!(bad.code(), "formula");
    let bad = fault(law(ActsOn::Motor, "q", &one()));
    assert!(matches!(bad.fault, LawFault::Unused { .. }));
    let bad = fault(law(ActsOn::Motor, "v", &[parameter("v", "", 1.0)]));
    assert!(matches!(bad.fault, LawFault::Reserved { .. }));
    let mut outside = one();
    outside[0].lower = 2.0;
    let bad = fault(law(ActsOn::Motor, "a*sin(q)", &outside));
    assert_eq!((bad.part, bad.code()), (Part::Parameter(0), "law-bounds"));
    let bad = fault(with_states(law(ActsOn::Motor, "a*z", &one()), &["v - q*z"]));
    assert_eq!(bad.part, Part::Rate(0));
    let bad = fault(law(
        ActsOn::Motor,
        "a*sin(q)",
        &[parameter("a", "furlong", 1.0)],
    ));
    assert!(matches!(bad.fault, LawFault::UnknownUnit { .. }));
}
