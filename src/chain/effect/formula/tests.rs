//! Formulas: what they are, their derivatives against differences, and what is wrong with those that are none.

use super::derivative::derivative;
use super::dimension::{Dimension, Known, Quantities};
use super::fault::{FormulaError, FormulaFault};
use super::syntax::{Names, Sign, read};
use super::tape::{LANES, States, Tape};
use crate::chain::effect::expression::{Expression, Variable};
use crate::robot::random::{generator, symmetric};
use crate::robot::tree::JointKind;

fn parsed(text: &str, parameters: &[&str]) -> Result<Expression, FormulaError> {
    let parameters: Vec<String> = parameters.iter().map(|p| p.to_string()).collect();
    let mut names = Names {
        parameters: &parameters,
        states: 1,
        others: Vec::new(),
        sign: Sign::Smoothed,
    };
    read(text, &mut names)
}

/// The formula's value at one sample.
fn value(formula: &Expression, parameters: &[f64], at: impl Fn(Variable) -> f64) -> f64 {
    let tape = Tape::compile(std::slice::from_ref(formula), States::Known);
    let mut run = tape.run(parameters);
    for (place, variable) in tape.inputs().iter().enumerate() {
        run.input(place).fill(at(*variable));
    }
    run.samples();
    let out = run.output(0);
    assert!(out.iter().all(|x| x.to_bits() == out[0].to_bits()));
    out[LANES - 1]
}

#[test]
fn matches_arithmetic_worked_out_by_hand() {
    for (text, expected) in [
        ("1 + 2*3", 7.0),
        ("-2^2", -4.0),
        ("2^-1", 0.5),
        ("2^3^2", 512.0),
        ("(1 + 2)*3 - 4/2", 7.0),
        ("1e-3*2", 2e-3),
        ("max(1, 2) + min(1, 2)", 3.0),
        ("if(q < 1, 5, 7)", 5.0),
        ("if(q >= 1, 5, 7)", 7.0),
        ("(q < 1)*4", 4.0),
        ("step(0.5)", 0.5),
        ("step(2) + step(-1)", 1.0),
        ("sin(pi/2) + cos(0)", 2.0),
        ("sqrt(4)·exp(0) + log(1) + tanh(0)", 2.0),
        ("abs(-3) + sign(-3)", 2.0),
    ] {
        let found = value(&parsed(text, &[]).unwrap(), &[], |_| 0.5);
        assert!((found - expected).abs() < 1e-15, "{text}: {found}");
    }
}

/// Every function of the language in a formula that is smooth about the samples.
const FORMULAS: &[&str] = &[
    "a*tau*sin(n*q + c)",
    "a*exp(-(v/n)^2)*sign(v)",
    "a*tanh(v/n) + c*abs(v)^n*sign(v)",
    "(a + c*log(1 + n*abs(v)))*sign(v)",
    "a*step(q/n)*q^3 - sqrt(a^2 + q^2)/(1 + n*v^2)",
    "max(a*q, c*v)*min(n, q) + if(q < c, a*q^2, n*q)",
    "(a - q)^n*cos(q*v)",
];

#[test]
fn matches_differences_in_every_parameter_and_variable() {
    let mut rng = generator(5);
    let variables = [
        Variable::Position,
        Variable::Velocity,
        Variable::Load,
        Variable::Sign,
    ];
    for text in FORMULAS {
        let formula = parsed(text, &["a", "n", "c"]).unwrap();
        for _ in 0..20 {
            let parameters = [0.8, 1.7, 0.3].map(|x: f64| x * (1.0 + symmetric(&mut rng, 0.2)));
            let motion = [0.4, -0.6, 2.0, -0.9].map(|x: f64| x * (1.0 + symmetric(&mut rng, 0.2)));
            let at = |motion: &[f64; 4], which: Variable| {
                let place = variables.iter().position(|v| *v == which);
                place.map_or(0.0, |k| motion[k])
            };
            let check = |by: &Expression, move_by: &dyn Fn(f64) -> f64| {
                let exact = value(&derivative(&formula, by), &parameters, |v| at(&motion, v));
                let h = 1e-6;
                let difference = (move_by(h) - move_by(-h)) / (2.0 * h);
                let scale = exact.abs().max(1.0);
                assert!(
                    (exact - difference).abs() < 1e-8 * scale,
                    "{text} by {by:?}"
                );
            };
            for k in 0..3 {
                check(&Expression::parameter(k), &|h| {
                    let mut moved = parameters;
                    moved[k] += h;
                    value(&formula, &moved, |v| at(&motion, v))
                });
            }
            for (k, variable) in variables.iter().enumerate() {
                check(&(*variable).into(), &|h| {
                    let mut moved = motion;
                    moved[k] += h;
                    value(&formula, &parameters, |v| at(&moved, v))
                });
            }
        }
    }
}

#[test]
fn a_power_has_a_finite_slope_in_its_exponent_at_zero() {
    let formula = parsed("abs(v)^n", &["n"]).unwrap();
    let slope = derivative(&formula, &Expression::parameter(0));
    assert_eq!(value(&slope, &[1.5], |_| 0.0), 0.0);
}

#[test]
fn faults_say_where_they_are() {
    let fault = |text: &str| parsed(text, &["a", "phase"]).unwrap_err();
    assert_eq!(fault("").fault, FormulaFault::Empty);
    let open = fault("a*sin(q + 1");
    assert_eq!((open.at, open.fault), (5..6, FormulaFault::Unclosed));
    let name = fault("a*sin(q + phas)");
    assert_eq!(name.at, 10..14);
    assert_eq!(
        name.fault,
        FormulaFault::UnknownName {
            found: "phas".into(),
            nearest: Some("phase".into())
        }
    );
    assert_eq!(fault("a*sinn(q)").at, 2..6);
    assert!(matches!(
        fault("min(q)").fault,
        FormulaFault::Arguments { expected: 2, .. }
    ));
    assert!(matches!(fault("a q").fault, FormulaFault::Expected { .. }));
    assert!(matches!(
        fault("tau[x]").fault,
        FormulaFault::OtherJoint { .. }
    ));
    assert!(matches!(
        fault("1.2.3").fault,
        FormulaFault::NotANumber { .. }
    ));
    assert_eq!(fault(&"(".repeat(1000)).fault, FormulaFault::TooDeep);
}

#[test]
fn dimensions_that_do_not_go_together_are_found() {
    let unit = |text: &str| Known::Dimension(Dimension::of_unit(text).unwrap());
    let quantities = Quantities {
        kind: JointKind::Revolute,
        parameters: &[
            unit("N·m·s/rad"),
            unit("N*m"),
            unit("kg·m²"),
            Known::Unknown,
        ],
    };
    let of = |text: &str| quantities.of(&parsed(text, &["Fv", "Fc", "J", "x"]).unwrap());
    for text in [
        "Fv*v",
        "Fv*v + Fc*sign(v) + J*acc",
        "Fc*exp(-(v/x)^2)",
        "x*sin(8*q)",
        "Fc*(T - 25)*x",
    ] {
        let found = of(text).unwrap();
        let fits = found == unit("N·m") || found == Known::Unknown;
        assert!(fits, "{text}: {found:?}");
    }
    for text in ["Fv*v + J", "Fc*sin(t)", "if(q < t, Fc, Fc)", "Fc + v"] {
        assert!(of(text).is_err(), "{text}");
    }
    assert_eq!(Dimension::of_unit("furlong"), None);
    assert_eq!(
        Dimension::of_unit("s/(rad*A)"),
        Dimension::of_unit("s·A^-1")
    );
}
