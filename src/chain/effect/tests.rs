//! Every torque law of the table, whatever it is: derivatives, power, linearity, documentation.

use crate::chain::effect::fitted_effect::{Estimated, FittedEffect};
use crate::chain::effect::knowledge::{JointTerm, Sizes, Trial};
use crate::chain::effect::sign::sign;
use crate::chain::effect::site::Site;
use crate::chain::effect::{
    Contribution, EFFECTS, Effect, Law, Linearity, ParameterInfo, Power, Samples, Surroundings,
    TorqueLaw, find, of_term,
};
use crate::chain::signal::Signal;
use crate::robot::random::{generator, symmetric};
use rand_chacha::ChaCha8Rng;

const SAMPLES: usize = 64;

struct Motion {
    position: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    sign: Vec<f64>,
    time: Vec<f64>,
}

/// s between samples.
const STEP: f64 = 0.02;

impl Motion {
    /// Two sines of random amplitude and phase.
    fn random(rng: &mut ChaCha8Rng) -> Self {
        let time: Vec<f64> = (0..SAMPLES).map(|k| STEP * k as f64).collect();
        let waves = [3.0, 11.0].map(|w| (w, symmetric(rng, 1.5) / w, symmetric(rng, 3.0)));
        let sum = |f: &dyn Fn(f64, f64, f64) -> f64| -> Vec<f64> {
            let at = |t: &f64| waves.iter().map(|&(w, a, p)| f(w, a, w * t + p)).sum();
            time.iter().map(at).collect()
        };
        let velocity = sum(&|w, a, x| a * w * x.cos());
        Self {
            position: sum(&|_, a, x| a * x.sin()),
            acceleration: sum(&|w, a, x| -a * w * w * x.sin()),
            sign: velocity.iter().map(|v| sign(*v, 0.01)).collect(),
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
            surroundings: Surroundings::default(),
        }
    }
}

struct Evaluated {
    torque: Vec<f64>,
    by_parameter: Vec<Vec<f64>>,
    by_sign: Vec<f64>,
    by_position: Vec<f64>,
    by_velocity: Vec<f64>,
}

fn evaluate(law: &dyn TorqueLaw, samples: Samples<'_>, parameters: &[f64]) -> Evaluated {
    let mut out = Evaluated {
        torque: vec![0.0; SAMPLES],
        by_parameter: vec![vec![0.0; SAMPLES]; parameters.len()],
        by_sign: vec![0.0; SAMPLES],
        by_position: vec![0.0; SAMPLES],
        by_velocity: vec![0.0; SAMPLES],
    };
    let mut contribution = Contribution {
        torque: &mut out.torque,
        by_parameter: &mut out.by_parameter,
        by_sign: &mut out.by_sign,
        by_position: &mut out.by_position,
        by_velocity: &mut out.by_velocity,
    };
    law.add(samples, parameters, &mut contribution);
    out
}

fn laws() -> impl Iterator<Item = (&'static Effect, &'static dyn TorqueLaw)> {
    EFFECTS.iter().filter_map(|effect| match effect.law {
        Law::Motor(law) | Law::Joint(law) => Some((*effect, law)),
        _ => None,
    })
}

/// Parameters of an effect, borrowed ones behind its own.
fn infos(effect: &Effect) -> Vec<ParameterInfo> {
    let lent = |(lender, name): &(&str, &str)| {
        let lender = find(lender).unwrap();
        *lender.parameters.iter().find(|p| p.name == *name).unwrap()
    };
    let borrowed = effect.needs.borrows.iter().map(lent);
    effect.parameters.iter().copied().chain(borrowed).collect()
}

fn random_parameters(effect: &Effect, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let draw = |info: ParameterInfo| {
        let value = info.typical * (1.0 + symmetric(rng, 0.9));
        value.clamp(info.lower, info.upper)
    };
    infos(effect).into_iter().map(draw).collect()
}

#[test]
fn matches_differences_in_every_parameter_and_in_sign() {
    let mut rng = generator(11);
    for (effect, law) in laws() {
        let motion = Motion::random(&mut rng);
        let parameters = random_parameters(effect, &mut rng);
        let here = evaluate(law, motion.samples(), &parameters);
        let difference = |high: &Evaluated, low: &Evaluated, k: usize, h: f64| {
            (high.torque[k] - low.torque[k]) / (2.0 * h)
        };
        for (index, info) in infos(effect).into_iter().enumerate() {
            let h = 1e-6 * info.typical;
            let at = |step: f64| {
                let mut moved = parameters.clone();
                moved[index] += step;
                evaluate(law, motion.samples(), &moved)
            };
            let (high, low) = (at(h), at(-h));
            for k in 0..SAMPLES {
                let expected = difference(&high, &low, k, h);
                let error = (here.by_parameter[index][k] - expected).abs();
                assert!(
                    error <= 1e-6 * expected.abs().max(1.0),
                    "{} {}",
                    effect.id,
                    info.name
                );
            }
        }
        let h = 1e-6;
        let at = |step: f64| {
            let sign: Vec<f64> = motion.sign.iter().map(|s| s + step).collect();
            let samples = Samples {
                sign: &sign,
                ..motion.samples()
            };
            evaluate(law, samples, &parameters)
        };
        let (high, low) = (at(h), at(-h));
        for k in 0..SAMPLES {
            let expected = difference(&high, &low, k, h);
            assert!(
                (here.by_sign[k] - expected).abs() <= 1e-6 * expected.abs().max(1.0),
                "{}",
                effect.id
            );
        }
    }
}

/// A search may begin where a law has no size.
#[test]
fn laws_without_a_size_are_finite() {
    let motion = Motion::random(&mut generator(14));
    for (effect, law) in laws() {
        let infos = infos(effect).into_iter();
        let nothing = infos.map(|info| if info.lower <= 0.0 { 0.0 } else { info.typical });
        let here = evaluate(law, motion.samples(), &nothing.collect::<Vec<f64>>());
        let finite = |series: &Vec<f64>| series.iter().all(|x| x.is_finite());
        assert!(
            finite(&here.torque) && here.by_parameter.iter().all(finite),
            "{}",
            effect.id
        );
    }
}

#[test]
fn invariant_laws_that_claim_to_dissipate_never_give_power() {
    let mut rng = generator(12);
    for (effect, law) in laws().filter(|(_, law)| law.power() == Power::Dissipates) {
        for _ in 0..20 {
            let motion = Motion::random(&mut rng);
            let out = evaluate(law, motion.samples(), &random_parameters(effect, &mut rng));
            for (torque, speed) in out.torque.iter().zip(&motion.velocity) {
                assert!(torque * speed >= 0.0, "{} gives power", effect.id);
            }
        }
    }
}

#[test]
fn invariant_linear_parameters_superpose() {
    let mut rng = generator(13);
    for (effect, law) in laws() {
        let motion = Motion::random(&mut rng);
        let base = random_parameters(effect, &mut rng);
        for (index, info) in effect.parameters.iter().enumerate() {
            if info.linearity == Linearity::Nonlinear {
                continue;
            }
            let at = |value: f64| {
                let mut moved = base.clone();
                moved[index] = value;
                evaluate(law, motion.samples(), &moved).torque
            };
            let (zero, one, three) = (at(0.0), at(1.0), at(3.0));
            for k in 0..SAMPLES {
                let expected = zero[k] + 3.0 * (one[k] - zero[k]);
                assert!(
                    (three[k] - expected).abs() < 1e-12 * (1.0 + three[k].abs()),
                    "{}",
                    effect.id
                );
            }
        }
    }
}

#[test]
fn every_effect_is_documented_and_named_once() {
    for (k, effect) in EFFECTS.iter().enumerate() {
        assert!(EFFECTS[..k].iter().all(|other| other.id != effect.id));
        assert!(effect.sentence.ends_with('.'), "{}", effect.id);
        assert!(
            !effect.equation.is_empty() && !effect.source.is_empty(),
            "{}",
            effect.id
        );
        assert!(
            !effect.depends_on.is_empty() && !effect.parameters.is_empty(),
            "{}",
            effect.id
        );
        for info in effect.parameters {
            assert!(
                info.lower <= info.typical && info.typical <= info.upper,
                "{}",
                effect.id
            );
            assert!(!info.meaning.is_empty(), "{} {}", effect.id, info.name);
        }
    }
}

#[test]
fn every_usual_term_of_a_joint_is_one_effect() {
    let terms = [
        JointTerm::DryFriction,
        JointTerm::ViscousFriction,
        JointTerm::Offset,
        JointTerm::RotorInertia,
        JointTerm::Spring,
    ];
    for term in terms {
        let of = EFFECTS.iter().filter(|e| e.knowledge.term == Some(term));
        let ids: Vec<&str> = of.map(|effect| effect.id).collect();
        assert_eq!(ids, [of_term(term).id], "{term:?}");
    }
}

/// What is known of an effect speaks of its own parameters; a load is known by the quantities of a body.
#[test]
fn sizes_and_values_of_trials_are_parameters_of_their_effects() {
    let site = Site {
        share: 0.1,
        usual_torque: 20.0,
        dry_friction: 2.0,
        fastest: 1.5,
        middle: 0.2,
        half_range: 1.0,
        inertia: 0.8,
        link_mass: 3.0,
        torque_constant: 10.0,
        duration: 20.0,
    };
    for effect in EFFECTS.iter().filter(|e| !matches!(e.law, Law::Body)) {
        let has = |name: &str| effect.parameters.iter().any(|p| p.name == name);
        if let Sizes::Of { names, .. } = effect.knowledge.sizes {
            assert!(names.iter().all(|name| has(name)), "{}", effect.id);
        }
        if let Trial::Drawn(sized) = effect.knowledge.trial {
            for drawn in sized(&site, &mut generator(1)) {
                let info = effect.parameters.iter().find(|p| p.name == drawn.parameter);
                let info = info.unwrap_or_else(|| panic!("{}: {drawn:?}", effect.id));
                let bounds = info.lower..=info.upper;
                assert!(bounds.contains(&drawn.value), "{}: {drawn:?}", effect.id);
            }
        }
    }
}

/// Of several sizes at least one is told from none, and a sentence speaks of that one.
#[test]
fn no_sentence_has_a_size_that_may_be_zero_where_another_is_told_from_it() {
    let mut tried = 0;
    for effect in EFFECTS {
        let Some(sentence) = effect.knowledge.finding else {
            continue;
        };
        let Sizes::Of { names, .. } = effect.knowledge.sizes else {
            continue;
        };
        for certain in names.iter().filter(|_| names.len() > 1) {
            let estimated = |name: &&'static str| Estimated {
                name,
                unit: "",
                value: Some(0.5),
                ci95: Some(match name == certain {
                    true => [0.4, 0.6],
                    false => [-7.0, 8.0],
                }),
            };
            let said = sentence(&FittedEffect {
                who: "j1".into(),
                moved: String::new(),
                by: Vec::new(),
                signal: Signal::Torque,
                parameters: names.iter().map(estimated).collect(),
            });
            assert!(said.contains("(95 %: "), "{said}");
            assert_eq!(said.matches("(95 %: ").count(), 1, "{said}");
            assert!(
                !said.contains("to 8.00)") && !said.contains("to 458)"),
                "{said}"
            );
            tried += 1;
        }
    }
    assert_eq!(tried, 6);
}

fn said(id: &str, signal: Signal, parameters: Vec<Estimated<'_>>) -> String {
    let found = FittedEffect {
        who: "j1".into(),
        moved: String::new(),
        by: Vec::new(),
        signal,
        parameters,
    };
    find(id).unwrap().knowledge.finding.unwrap()(&found)
}

/// A sign is a word: late and early, heavier and lighter.
#[test]
fn sentences_have_no_negative_delays_and_loads() {
    let estimated = |name: &'static str, value: f64| Estimated {
        name,
        unit: "",
        value: Some(value),
        ci95: Some([1.1 * value, 0.9 * value]),
    };
    let late = |delay: f64| {
        said(
            "time_delay",
            Signal::Torque,
            vec![estimated("delay", delay)],
        )
    };
    assert!(late(0.02).contains("is late by 20.0 ms (95 %: 18.0 to 22.0)"));
    assert!(late(-0.02).contains("is early by 20.0 ms (95 %: 18.0 to 22.0)"));
    let of_all = |delays: [f64; 2]| {
        let own = delays.map(|delay| estimated("delay", delay));
        said("time_delay", Signal::Torque, own.to_vec())
    };
    assert!(of_all([0.004, 0.018]).contains("is late by 4.00 to 18.0 ms;"));
    assert!(of_all([-0.004, -0.018]).contains("is early by 4.00 to 18.0 ms;"));
    assert!(of_all([0.004, -0.018]).contains("is late here and early there by -18.0 to 4.00 ms;"));
    let load = |mass: f64| {
        said(
            "unmodelled_payload",
            Signal::Torque,
            vec![estimated("mass", mass)],
        )
    };
    assert!(load(2.0).starts_with("A load of 2.00 (95 %"));
    assert!(load(-2.0).contains("lighter by 2.00 kg (95 %: 1.80 to 2.20)"));
}

#[test]
fn a_torque_sensor_has_no_torque_constant() {
    // The polynomial of a current is of currents alone.
    for effect in EFFECTS.iter().filter(|e| !matches!(e.law, Law::Current)) {
        let Some(sentence) = effect.knowledge.finding else {
            continue;
        };
        let own = effect.parameters.iter().map(|p| Estimated {
            name: p.name,
            unit: "",
            value: Some(p.typical),
            ci95: None,
        });
        let found = |signal| FittedEffect {
            who: "j1".into(),
            moved: "j1".into(),
            by: vec!["j2".into()],
            signal,
            parameters: own.clone().collect(),
        };
        for signal in [Signal::Torque, Signal::LinkTorque] {
            let said = sentence(&found(signal));
            assert!(!said.contains("torque constant"), "{}: {said}", effect.id);
        }
    }
}
