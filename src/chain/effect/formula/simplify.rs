//! Algebraic simplification: sums, products and quotients without what changes nothing: `0·x`, `1·x`, `x + 0`, constants folded.

use crate::chain::effect::expression::{Expression, Function, Operator};

fn number(of: &Expression) -> Option<f64> {
    match of {
        Expression::Number(value) => Some(*value),
        _ => None,
    }
}

pub fn is_zero(of: &Expression) -> bool {
    number(of) == Some(0.0)
}

pub fn sum(a: Expression, b: Expression) -> Expression {
    match (number(&a), number(&b)) {
        (Some(x), Some(y)) => Expression::Number(x + y),
        (Some(0.0), _) => b,
        (_, Some(0.0)) => a,
        _ => a + b,
    }
}

pub fn difference(a: Expression, b: Expression) -> Expression {
    match (number(&a), number(&b)) {
        (Some(x), Some(y)) => Expression::Number(x - y),
        (Some(0.0), _) => negative(b),
        (_, Some(0.0)) => a,
        _ => a - b,
    }
}

pub fn product(a: Expression, b: Expression) -> Expression {
    match (number(&a), number(&b)) {
        (Some(x), Some(y)) => Expression::Number(x * y),
        (Some(0.0), _) | (_, Some(0.0)) => Expression::Number(0.0),
        (Some(1.0), _) => b,
        (_, Some(1.0)) => a,
        (Some(-1.0), _) => negative(b),
        (_, Some(-1.0)) => negative(a),
        _ => a * b,
    }
}

pub fn quotient(a: Expression, b: Expression) -> Expression {
    match (number(&a), number(&b)) {
        (Some(x), Some(y)) if y != 0.0 => Expression::Number(x / y),
        (Some(0.0), _) => Expression::Number(0.0),
        (_, Some(1.0)) => a,
        _ => a / b,
    }
}

pub fn negative(of: Expression) -> Expression {
    match of {
        Expression::Number(value) => Expression::Number(-value),
        Expression::Negative(inner) => *inner,
        other => -other,
    }
}

/// `base^exponent`: whole exponents up to four are products, which are as exact and need no logarithm.
pub fn power(base: Expression, exponent: Expression) -> Expression {
    match number(&exponent) {
        Some(0.0) => Expression::Number(1.0),
        Some(1.0) => base,
        Some(2.0) => product(base.clone(), base),
        Some(3.0) => product(product(base.clone(), base.clone()), base),
        Some(4.0) => {
            let square = product(base.clone(), base);
            product(square.clone(), square)
        }
        Some(-1.0) => quotient(Expression::Number(1.0), base),
        _ => base.call_with(Function::Power, exponent),
    }
}

/// `a operator b`, simplified.
pub fn binary(operator: Operator, a: Expression, b: Expression) -> Expression {
    match operator {
        Operator::Sum => sum(a, b),
        Operator::Difference => difference(a, b),
        Operator::Product => product(a, b),
        Operator::Quotient => quotient(a, b),
    }
}

/// `if a < b { then } else { otherwise }`, one of them where they are the same.
pub fn choice(condition: [Expression; 2], then: Expression, otherwise: Expression) -> Expression {
    let [a, b] = condition;
    if then == otherwise {
        then
    } else {
        a.if_less(b, then, otherwise)
    }
}
