//! Exact derivatives of formulas, by the rules of calculus.
//!
//! Where a formula has a corner (`abs`, `min`, `max`, a comparison) the derivative is that of the side on which a sample lies,
//! and 0 for `abs` at 0.

use super::simplify::{
    binary, choice, difference, is_zero, negative, power, product, quotient, sum,
};
use crate::chain::effect::expression::{Expression, Function, Operator};

/// ∂formula/∂`by`, a parameter or a variable.
pub fn derivative(of: &Expression, by: &Expression) -> Expression {
    if of == by {
        return Expression::Number(1.0);
    }
    match of {
        Expression::Number(_)
        | Expression::Parameter(_)
        | Expression::Variable(_)
        | Expression::Name(_) => Expression::Number(0.0),
        Expression::Negative(inner) => negative(derivative(inner, by)),
        Expression::Binary(operator, pair) => of_pair(*operator, pair, by),
        Expression::Call(function, of) => match of.as_slice() {
            [a] => of_call(*function, a, by),
            [a, b] => of_call_of_two(*function, [a, b], by),
            _ => Expression::Number(0.0),
        },
        Expression::Less(four) => {
            let [a, b, then, otherwise] = four.as_ref();
            choice(
                [a.clone(), b.clone()],
                derivative(then, by),
                derivative(otherwise, by),
            )
        }
    }
}

fn of_pair(operator: Operator, [a, b]: &[Expression; 2], by: &Expression) -> Expression {
    let (da, db) = (derivative(a, by), derivative(b, by));
    match operator {
        Operator::Sum | Operator::Difference => binary(operator, da, db),
        Operator::Product => sum(product(da, b.clone()), product(a.clone(), db)),
        Operator::Quotient => {
            // (a/b)′ = (a′ − (a/b)·b′)/b: the quotient itself stands in the formula already.
            let whole = quotient(a.clone(), b.clone());
            quotient(difference(da, product(whole, db)), b.clone())
        }
    }
}

fn of_call(function: Function, a: &Expression, by: &Expression) -> Expression {
    let da = derivative(a, by);
    if is_zero(&da) {
        return da;
    }
    let whole = || a.clone().call(function);
    let outer = match function {
        Function::Sine => a.clone().call(Function::Cosine),
        Function::Cosine => negative(a.clone().call(Function::Sine)),
        Function::Exponential => whole(),
        Function::Logarithm => return quotient(da, a.clone()),
        Function::HyperbolicTangent => {
            difference(Expression::Number(1.0), product(whole(), whole()))
        }
        Function::Magnitude => a.clone().call(Function::Signum),
        Function::SquareRoot => return quotient(product(Expression::Number(0.5), da), whole()),
        Function::Signum | Function::Power | Function::Smaller | Function::Larger => {
            return Expression::Number(0.0);
        }
    };
    product(outer, da)
}

fn of_call_of_two(function: Function, [a, b]: [&Expression; 2], by: &Expression) -> Expression {
    let (da, db) = (derivative(a, by), derivative(b, by));
    let pair = || [a.clone(), b.clone()];
    match function {
        Function::Smaller => choice(pair(), da, db),
        Function::Larger => choice(pair(), db, da),
        Function::Power => {
            let lower = power(a.clone(), difference(b.clone(), Expression::Number(1.0)));
            let by_base = product(product(b.clone(), lower), da);
            if is_zero(&db) {
                return by_base;
            }
            // a^b·ln a goes to 0 with a for every b > 0.
            let growth = product(
                power(a.clone(), b.clone()),
                a.clone().call(Function::Logarithm),
            );
            let growth = Expression::Number(0.0).if_less(a.clone(), growth, 0.0);
            sum(by_base, product(growth, db))
        }
        _ => Expression::Number(0.0),
    }
}
