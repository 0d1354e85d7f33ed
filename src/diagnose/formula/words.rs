//! Formulas as text: the torque of a law, and with numbers as people read them.

use crate::chain::words::short;
use crate::diagnose::formula::factor::{Factor, Shape};
use crate::diagnose::formula::named::{Named, NamedTerm};
use crate::diagnose::residuals::quantity::Quantity;

/// The torque of a law, with the names of its parameters.
pub fn torque(terms: &[NamedTerm], joints: &[String]) -> String {
    let name = |named: &Named| named.name.clone();
    let parts = terms.iter().map(|term| Part {
        is_negative: term.is_negative,
        factors: product(term, &name, joints),
    });
    sum(parts, "*")
}

/// With numbers: `0.41·tau·sin(8·q)`.
pub fn expression(terms: &[NamedTerm], joints: &[String]) -> String {
    let parts = terms.iter().map(|term| {
        let mut factors = product(term, &|named| short(named.value), joints);
        let size = term.size.value;
        factors[0] = short(size.abs());
        Part {
            is_negative: term.is_negative != (size < 0.0),
            factors,
        }
    });
    sum(parts, "·")
}

/// A term as it is written.
struct Part {
    is_negative: bool,
    factors: Vec<String>,
}

/// Terms with their signs; factors stand apart by `times`.
fn sum(parts: impl Iterator<Item = Part>, times: &str) -> String {
    let mut text = String::new();
    for part in parts {
        text.push_str(match (text.is_empty(), part.is_negative) {
            (true, false) => "",
            (true, true) => "-",
            (false, false) => " + ",
            (false, true) => " - ",
        });
        text.push_str(&part.factors.join(times).replace('*', times));
    }
    text
}

/// Size and factors; `of` is what stands for a parameter.
fn product(term: &NamedTerm, of: &dyn Fn(&Named) -> String, joints: &[String]) -> Vec<String> {
    let second = term.second.as_ref().map(of).unwrap_or_default();
    let factors = term.term.factors.iter().enumerate();
    let factors = factors.map(|(f, factor)| {
        let own = Own {
            inner: term.inner[f].as_ref().map(of).unwrap_or_default(),
            centre: term.centre[f].as_ref().map(of),
            second: &second,
        };
        written(factor, &own, joints)
    });
    std::iter::once(of(&term.size)).chain(factors).collect()
}

/// A variable as formulas of laws name it.
pub fn variable(quantity: Quantity, joints: &[String]) -> String {
    match quantity {
        Quantity::Position => "q".to_string(),
        Quantity::Velocity => "v".to_string(),
        Quantity::Acceleration => "acc".to_string(),
        Quantity::Load => "tau".to_string(),
        Quantity::OtherPosition(k) => format!("q[{}]", joints[k]),
        Quantity::OtherVelocity(k) => format!("v[{}]", joints[k]),
    }
}

/// What stands for the parameters of a factor.
struct Own<'a> {
    inner: String,
    centre: Option<String>,
    second: &'a str,
}

fn written(factor: &Factor, own: &Own<'_>, joints: &[String]) -> String {
    let Own {
        inner,
        centre,
        second,
    } = own;
    let x = variable(factor.quantity, joints);
    let from_centre = match centre {
        Some(centre) => format!("({})", less(&x, centre)),
        None => x.clone(),
    };
    let raised = |base: String, power: u8| match power {
        1 => base,
        power => format!("{base}^{power}"),
    };
    match factor.shape {
        Shape::Power(power) => raised(x, power),
        Shape::Magnitude => format!("abs({x})"),
        Shape::SignedSquare => format!("{x}*abs({x})"),
        Shape::Direction => format!("sign({x})"),
        Shape::Decay => format!("exp(-abs({x})/{inner})"),
        Shape::Shifted => format!("({})", less(&x, inner)),
        Shape::Above(power) => raised(format!("max({}, 0)", less(&x, inner)), power),
        Shape::Below(power) => raised(format!("min({}, 0)", less(&x, inner)), power),
        Shape::Slopes => {
            let from_knee = less(&x, inner);
            format!(
                "(max({from_knee}, 0){})",
                more(&format!("{second}*min({from_knee}, 0)"))
            )
        }
        Shape::DeadZone => {
            let (above, below) = (less(&from_centre, inner), more(inner));
            format!("(max({above}, 0) + min({from_centre}{below}, 0))")
        }
        Shape::Saturation => format!("tanh({from_centre}/{inner})"),
        Shape::Bump => format!("exp(-({from_centre}/{inner})^2)"),
        Shape::Resonance => format!("1/(1 + ({from_centre}/{inner})^2)"),
        Shape::Breakdown => format!("{from_centre}/{inner}/(1 + ({from_centre}/{inner})^2)"),
        Shape::Exponential => format!("exp({inner}*{x})"),
        Shape::Wave => format!("sin({inner}*{x}{})", more(second)),
        Shape::Sine => format!("sin({inner}*{x})"),
        Shape::Cosine => format!("cos({inner}*{x})"),
    }
}

/// `x - a`, or `x + 0.3` of a negative number.
fn less(x: &str, a: &str) -> String {
    match a.strip_prefix('-') {
        Some(positive) => format!("{x} + {positive}"),
        None => format!("{x} - {a}"),
    }
}

/// ` + a`, or ` - 0.3` of a negative number.
fn more(a: &str) -> String {
    match a.strip_prefix('-') {
        Some(positive) => format!(" - {positive}"),
        None => format!(" + {a}"),
    }
}
