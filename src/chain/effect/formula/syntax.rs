//! The parser of formulas: numbers, parameters, variables of the motion, functions, comparisons.
//!
//! ```text
//! comparison  sum [("<" | ">" | "<=" | ">=") sum]      1 where it holds, 0 where not
//! sum         product (("+" | "-") product)*
//! product     sign (("*" | "·" | "/") sign)*
//! sign        ("-" | "+") sign | power
//! power       atom ["^" sign]
//! atom        number | name | name "[" joint "]" | name "(" comparison ("," comparison)* ")" | "(" comparison ")"
//! ```

use super::fault::{DEEPEST, FormulaError, FormulaFault};
use super::simplify;
use super::words::{FUNCTIONS, PI, STATE, VARIABLES};
use crate::chain::effect::expression::{Expression, Function, Operator, Variable};
use crate::fault::nearest;
use std::ops::Range;

/// What the names of a formula mean.
#[derive(Debug)]
pub struct Names<'a> {
    /// Names of the law's parameters, in its order.
    pub parameters: &'a [String],
    /// How many states the law has: z, or z1, z2, ...
    pub states: usize,
    /// Joints that q[...] and v[...] name, in the order in which they come.
    pub others: Vec<String>,
    /// Whether `sign(v)` is the smoothed sign with the joint's w, or the plain one, as in the rate of a state.
    pub sign: Sign,
}

/// What `sign(v)` means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sign {
    /// `v/(|v| + w)`.
    Smoothed,
    /// sgn v, 0 at 0.
    Plain,
}

/// Reads a formula.
///
/// # Errors
/// What is wrong with it, and the characters where.
pub fn read(text: &str, names: &mut Names<'_>) -> Result<Expression, FormulaError> {
    let mut reader = Reader {
        text: text.chars().collect(),
        at: 0,
        depth: 0,
        names,
    };
    reader.skip();
    if reader.at == reader.text.len() {
        return Err(reader.error(0..0, FormulaFault::Empty));
    }
    let formula = reader.comparison()?;
    match reader.peek() {
        None => Ok(formula),
        Some(_) => Err(reader.expected("an operator")),
    }
}

struct Reader<'r, 'n> {
    text: Vec<char>,
    at: usize,
    depth: usize,
    names: &'r mut Names<'n>,
}

type Read = Result<Expression, FormulaError>;

impl Reader<'_, '_> {
    fn error(&self, at: Range<usize>, fault: FormulaFault) -> FormulaError {
        FormulaError { at, fault }
    }

    fn expected(&self, expected: &'static str) -> FormulaError {
        let found = match self.peek() {
            Some(c) => format!("\"{c}\""),
            None => "the end".into(),
        };
        let fault = FormulaFault::Expected { found, expected };
        self.error(self.at..self.at + 1, fault)
    }

    fn peek(&self) -> Option<char> {
        self.text.get(self.at).copied()
    }

    fn skip(&mut self) {
        while self.peek().is_some_and(char::is_whitespace) {
            self.at += 1;
        }
    }

    /// Takes one of these characters and what is blank behind it.
    fn take(&mut self, any: &[char]) -> Option<char> {
        let found = self.peek().filter(|c| any.contains(c))?;
        self.at += 1;
        self.skip();
        Some(found)
    }

    fn comparison(&mut self) -> Read {
        let left = self.sum()?;
        let Some(sign) = self.take(&['<', '>']) else {
            return Ok(left);
        };
        let or_equal = self.take(&['=']).is_some();
        let right = self.sum()?;
        let (a, b) = match (sign, or_equal) {
            ('<', false) | ('>', true) => (left, right),
            _ => (right, left),
        };
        // a ≤ b is the contrary of b < a.
        Ok(match or_equal {
            false => a.if_less(b, 1.0, 0.0),
            true => a.if_less(b, 0.0, 1.0),
        })
    }

    fn sum(&mut self) -> Read {
        let mut sum = self.product()?;
        while let Some(sign) = self.take(&['+', '-', '−']) {
            let next = self.product()?;
            let operator = match sign {
                '+' => Operator::Sum,
                _ => Operator::Difference,
            };
            sum = simplify::binary(operator, sum, next);
        }
        Ok(sum)
    }

    fn product(&mut self) -> Read {
        let mut product = self.signed()?;
        while let Some(sign) = self.take(&['*', '·', '/']) {
            let next = self.signed()?;
            let operator = match sign {
                '/' => Operator::Quotient,
                _ => Operator::Product,
            };
            product = simplify::binary(operator, product, next);
        }
        Ok(product)
    }

    fn signed(&mut self) -> Read {
        self.enter(self.at)?;
        let read = match self.take(&['+', '-', '−']) {
            Some('+') => self.signed(),
            Some(_) => self.signed().map(simplify::negative),
            None => self.power(),
        };
        self.depth -= 1;
        read
    }

    fn power(&mut self) -> Read {
        let base = self.atom()?;
        match self.take(&['^']) {
            Some(_) => Ok(simplify::power(base, self.signed()?)),
            None => Ok(base),
        }
    }

    fn enter(&mut self, at: usize) -> Result<(), FormulaError> {
        self.depth += 1;
        match self.depth > DEEPEST {
            true => Err(self.error(at..at + 1, FormulaFault::TooDeep)),
            false => Ok(()),
        }
    }

    fn atom(&mut self) -> Read {
        match self.peek() {
            Some('(') => {
                let open = self.at;
                self.take(&['(']);
                let inner = self.comparison()?;
                self.close(open, ')')?;
                Ok(inner)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => self.name(),
            _ => Err(self.expected("a number, a name or a bracket")),
        }
    }

    fn close(&mut self, open: usize, bracket: char) -> Result<(), FormulaError> {
        match self.take(&[bracket]) {
            Some(_) => Ok(()),
            None if self.peek().is_none() => {
                Err(self.error(open..open + 1, FormulaFault::Unclosed))
            }
            None => Err(self.expected("an operator, a comma or the closing bracket")),
        }
    }

    fn number(&mut self) -> Read {
        let start = self.at;
        let mut before = ' ';
        while let Some(c) = self.peek() {
            let exponent_sign = matches!(before, 'e' | 'E') && matches!(c, '+' | '-');
            if !(c.is_ascii_digit() || matches!(c, '.' | 'e' | 'E') || exponent_sign) {
                break;
            }
            before = c;
            self.at += 1;
        }
        let found: String = self.text[start..self.at].iter().collect();
        match found.parse::<f64>() {
            Ok(value) if value.is_finite() => {
                self.skip();
                Ok(Expression::Number(value))
            }
            _ => Err(self.error(start..self.at, FormulaFault::NotANumber { found })),
        }
    }

    fn word(&mut self) -> String {
        let start = self.at;
        while self.peek().is_some_and(|c| c.is_alphanumeric() || c == '_') {
            self.at += 1;
        }
        let word = self.text[start..self.at].iter().collect();
        self.skip();
        word
    }

    fn name(&mut self) -> Read {
        let start = self.at;
        let word = self.word();
        let end = start + word.chars().count();
        match self.peek() {
            Some('(') => self.call(&word, start..end),
            Some('[') => self.of_another_joint(&word, start..end),
            _ => self.plain(&word, start..end),
        }
    }

    fn plain(&self, word: &str, at: Range<usize>) -> Read {
        if let Some(position) = self.names.parameters.iter().position(|name| name == word) {
            return Ok(Expression::parameter(position));
        }
        if word == PI {
            return Ok(Expression::Number(std::f64::consts::PI));
        }
        if let Some((_, variable)) = VARIABLES.iter().find(|(name, _)| *name == word) {
            return Ok((*variable).into());
        }
        if let Some(state) = self.state(word) {
            return Ok(Variable::State(state).into());
        }
        let known = self.names.parameters.iter().map(String::as_str);
        let known = known.chain(VARIABLES.iter().map(|(name, _)| *name));
        Err(self.error(
            at,
            FormulaFault::UnknownName {
                found: word.into(),
                nearest: nearest(word, known),
            },
        ))
    }

    /// z, or z1, z2, ... of several.
    fn state(&self, word: &str) -> Option<usize> {
        let index = word.strip_prefix(STATE)?;
        let state = match index {
            "" if self.names.states == 1 => 0,
            _ => index.parse::<usize>().ok()?.checked_sub(1)?,
        };
        (state < self.names.states).then_some(state)
    }

    fn of_another_joint(&mut self, word: &str, at: Range<usize>) -> Read {
        let open = self.at;
        self.take(&['[']);
        let joint: String = self.text[self.at..]
            .iter()
            .take_while(|c| **c != ']')
            .collect();
        self.at += joint.chars().count();
        self.close(open, ']')?;
        let joint = joint.trim().trim_matches(['"', '\'']).to_string();
        let known = self.names.others.iter().position(|other| *other == joint);
        let index = known.unwrap_or_else(|| {
            self.names.others.push(joint);
            self.names.others.len() - 1
        });
        match word {
            "q" => Ok(Variable::OtherPosition(index).into()),
            "v" => Ok(Variable::OtherVelocity(index).into()),
            _ => Err(self.error(at, FormulaFault::OtherJoint { found: word.into() })),
        }
    }

    fn call(&mut self, word: &str, at: Range<usize>) -> Read {
        let Some((_, expected)) = FUNCTIONS.iter().find(|(name, _)| *name == word) else {
            let known = FUNCTIONS.iter().map(|(name, _)| *name);
            let fault = FormulaFault::UnknownFunction {
                found: word.into(),
                nearest: nearest(word, known),
            };
            return Err(self.error(at, fault));
        };
        let open = self.at;
        self.take(&['(']);
        let mut arguments = vec![self.comparison()?];
        while self.take(&[',']).is_some() {
            arguments.push(self.comparison()?);
        }
        self.close(open, ')')?;
        if arguments.len() != *expected {
            let fault = FormulaFault::Arguments {
                function: word.into(),
                found: arguments.len(),
                expected: *expected,
            };
            return Err(self.error(at.start..self.at, fault));
        }
        Ok(self.applied(word, arguments))
    }

    fn applied(&self, word: &str, mut arguments: Vec<Expression>) -> Expression {
        let last = arguments.pop().unwrap_or(Expression::Number(0.0));
        match word {
            "exp" => last.call(Function::Exponential),
            "log" => last.call(Function::Logarithm),
            "tanh" => last.call(Function::HyperbolicTangent),
            "sin" => last.call(Function::Sine),
            "cos" => last.call(Function::Cosine),
            "sqrt" => last.call(Function::SquareRoot),
            "abs" => last.call(Function::Magnitude),
            "sign" => match (&last, self.names.sign) {
                (Expression::Variable(Variable::Velocity), Sign::Smoothed) => Variable::Sign.into(),
                _ => last.call(Function::Signum),
            },
            "step" => smooth_step(last),
            "min" => arguments.swap_remove(0).call_with(Function::Smaller, last),
            "max" => arguments.swap_remove(0).call_with(Function::Larger, last),
            _ => {
                let then = arguments.pop().unwrap_or(Expression::Number(0.0));
                let condition = arguments.pop().unwrap_or(Expression::Number(0.0));
                Expression::Number(0.5).if_less(condition, then, last)
            }
        }
    }
}

/// 0 below 0, `3x² − 2x³` up to 1, 1 beyond: value and slope are continuous.
fn smooth_step(x: Expression) -> Expression {
    let rise = x.clone().squared() * (Expression::from(3.0) - x.clone() * 2.0);
    let below_one = x.clone().if_less(1.0, rise, 1.0);
    Expression::Number(0.0).if_less(x, below_one, 0.0)
}
