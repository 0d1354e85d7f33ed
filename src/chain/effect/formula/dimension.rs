//! Dimensional analysis of formulas: a sum of a torque and a speed is a slip of the pen.
//!
//! Units are checked as far as they are stated: a parameter without a unit goes with everything. Angles have none.

use crate::chain::effect::expression::{Expression, Function, Operator, Variable};
use crate::robot::tree::JointKind;

/// Powers of m, kg, s, A and K.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dimension([i8; 5]);

/// What is known of a value's dimension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Known {
    /// Its dimension.
    Dimension(Dimension),
    /// A number of the formula, which in a sum has the dimension of the other term.
    Number,
    /// A parameter whose unit nobody has stated, or what is made of one: it goes with everything.
    Unknown,
}

const ONE: Dimension = Dimension([0; 5]);
const METRE: Dimension = Dimension([1, 0, 0, 0, 0]);
const SECOND: Dimension = Dimension([0, 0, 1, 0, 0]);
const NEWTON: Dimension = Dimension([1, 1, -2, 0, 0]);
const NEWTON_METRE: Dimension = Dimension([2, 1, -2, 0, 0]);

/// Symbols of units; longer ones first where one begins another.
const SYMBOLS: &[(&str, Dimension)] = &[
    ("1", ONE),
    ("rad", ONE),
    ("rev", ONE),
    ("kg", Dimension([0, 1, 0, 0, 0])),
    ("N", NEWTON),
    ("Nm", NEWTON_METRE),
    ("J", NEWTON_METRE),
    ("W", Dimension([2, 1, -3, 0, 0])),
    ("V", Dimension([2, 1, -3, -1, 0])),
    ("Hz", Dimension([0, 0, -1, 0, 0])),
    ("m", METRE),
    ("s", SECOND),
    ("A", Dimension([0, 0, 0, 1, 0])),
    ("K", Dimension([0, 0, 0, 0, 1])),
    ("°C", Dimension([0, 0, 0, 0, 1])),
];

impl Dimension {
    fn times(self, other: Self, power: i8) -> Self {
        Self(std::array::from_fn(|k| {
            self.0[k].saturating_add(power.saturating_mul(other.0[k]))
        }))
    }

    fn halved(self) -> Option<Self> {
        let even = self.0.iter().all(|p| p % 2 == 0);
        even.then(|| Self(self.0.map(|p| p / 2)))
    }

    /// The dimension of a unit such as `N·m·s/rad`, `kg*m^2` or `1`; `None` of a symbol that is not known.
    pub fn of_unit(unit: &str) -> Option<Self> {
        let mut dimension = ONE;
        // A stroke divides by the symbol behind it, or by all in a bracket.
        for (k, part) in unit.split('/').enumerate() {
            let divided = k > 0;
            let all = part.trim_start().starts_with('(');
            let symbols = part.split(['·', '*', ' ', '.', '(', ')']);
            let symbols = symbols.map(str::trim).filter(|s| !s.is_empty());
            for (place, text) in symbols.enumerate() {
                let (symbol, power) = with_power(text)?;
                let (_, found) = SYMBOLS.iter().find(|(name, _)| *name == symbol)?;
                let sign = if divided && (place == 0 || all) {
                    -1
                } else {
                    1
                };
                dimension = dimension.times(*found, sign * power);
            }
        }
        Some(dimension)
    }

    /// In words for messages, such as `kg·m²/s²`.
    pub fn words(self) -> String {
        if self == NEWTON_METRE {
            return "N·m".into();
        }
        if self == NEWTON {
            return "N".into();
        }
        let names = ["m", "kg", "s", "A", "K"];
        let powers = names.iter().zip(self.0).filter(|(_, power)| *power != 0);
        let parts: Vec<String> = powers
            .map(|(name, power)| match power {
                1 => (*name).to_string(),
                power => format!("{name}^{power}"),
            })
            .collect();
        match parts.is_empty() {
            true => "1".into(),
            false => parts.join("·"),
        }
    }
}

/// `m²`, `m^2` and `m2` are m to the power 2.
fn with_power(text: &str) -> Option<(&str, i8)> {
    if text == "1" {
        return Some(("1", 1));
    }
    let end = text
        .find(['^', '²', '³', '-', '2', '3'])
        .unwrap_or(text.len());
    let (symbol, power) = text.split_at(end);
    let power = match power.trim_start_matches('^') {
        "" => 1,
        "²" => 2,
        "³" => 3,
        digits => digits.parse().ok()?,
    };
    Some((symbol, power))
}

/// What is known beside the formula itself.
#[derive(Debug)]
pub struct Quantities<'a> {
    /// Whether positions are angles or lengths.
    pub kind: JointKind,
    /// Dimensions of the parameters.
    pub parameters: &'a [Known],
}

/// Two dimensions that do not go together, in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Clash {
    /// Such as `a sum of`.
    pub what: &'static str,
    /// The one, as a product of units.
    pub found: String,
    /// The other, as a product of units.
    pub other: String,
}

impl Quantities<'_> {
    fn position(&self) -> Dimension {
        match self.kind {
            JointKind::Revolute => ONE,
            _ => METRE,
        }
    }

    /// The dimension of a torque.
    pub fn torque(&self) -> Dimension {
        match self.kind {
            JointKind::Revolute => NEWTON_METRE,
            _ => NEWTON,
        }
    }

    fn variable(&self, variable: Variable) -> Known {
        let position = self.position();
        Known::Dimension(match variable {
            Variable::Position => position,
            Variable::Velocity => position.times(SECOND, -1),
            Variable::Acceleration => position.times(SECOND, -2),
            Variable::Sign => ONE,
            Variable::Time | Variable::Period | Variable::Duration => SECOND,
            Variable::Load => self.torque(),
            Variable::Current => Dimension([0, 0, 0, 1, 0]),
            Variable::Temperature => Dimension([0, 0, 0, 0, 1]),
            // The other joint may be of another kind, and a state is what the formula makes of it.
            _ => return Known::Unknown,
        })
    }

    /// The dimension of a formula.
    ///
    /// # Errors
    /// The first two that do not go together.
    pub fn of(&self, formula: &Expression) -> Result<Known, Clash> {
        match formula {
            Expression::Number(_) => Ok(Known::Number),
            Expression::Name(_) => Ok(Known::Unknown),
            Expression::Parameter(k) => {
                Ok(self.parameters.get(*k).copied().unwrap_or(Known::Unknown))
            }
            Expression::Variable(variable) => Ok(self.variable(*variable)),
            Expression::Negative(of) => self.of(of),
            Expression::Binary(operator, pair) => {
                let (a, b) = (self.of(&pair[0])?, self.of(&pair[1])?);
                match operator {
                    Operator::Sum | Operator::Difference => same("a sum of", a, b),
                    Operator::Product => Ok(product(a, b, 1)),
                    Operator::Quotient => Ok(product(a, b, -1)),
                }
            }
            Expression::Call(function, of) => {
                let of: Vec<Known> = of.iter().map(|e| self.of(e)).collect::<Result<_, _>>()?;
                called(*function, &of)
            }
            Expression::Less(four) => {
                let [a, b, then, otherwise] = [0, 1, 2, 3].map(|k| self.of(&four[k]));
                same("a comparison of", a?, b?)?;
                same("a choice between", then?, otherwise?)
            }
        }
    }
}

fn product(a: Known, b: Known, power: i8) -> Known {
    let plain = |known: Known| match known {
        Known::Dimension(dimension) => Some(dimension),
        Known::Number => Some(ONE),
        Known::Unknown => None,
    };
    match (a, b) {
        (Known::Number, Known::Number) => Known::Number,
        _ => match (plain(a), plain(b)) {
            (Some(a), Some(b)) => Known::Dimension(a.times(b, power)),
            _ => Known::Unknown,
        },
    }
}

/// The dimension that both have.
pub fn same(what: &'static str, a: Known, b: Known) -> Result<Known, Clash> {
    match (a, b) {
        (Known::Dimension(x), Known::Dimension(y)) if x != y => Err(Clash {
            what,
            found: x.words(),
            other: y.words(),
        }),
        (Known::Dimension(_), _) | (_, Known::Number) => Ok(a),
        _ => Ok(b),
    }
}

fn called(function: Function, of: &[Known]) -> Result<Known, Clash> {
    let first = of.first().copied().unwrap_or(Known::Unknown);
    match function {
        Function::Magnitude => Ok(first),
        Function::Signum => Ok(Known::Dimension(ONE)),
        Function::SquareRoot => Ok(match first {
            Known::Dimension(dimension) => {
                dimension.halved().map_or(Known::Unknown, Known::Dimension)
            }
            other => other,
        }),
        Function::Smaller | Function::Larger => {
            let second = of.get(1).copied().unwrap_or(Known::Unknown);
            same("the smaller or larger of", first, second)
        }
        Function::Power => Ok(match first {
            Known::Dimension(ONE) | Known::Number => first,
            // The exponent's value is not known here.
            _ => Known::Unknown,
        }),
        Function::Sine
        | Function::Cosine
        | Function::Exponential
        | Function::Logarithm
        | Function::HyperbolicTangent => {
            same(
                "a function of a pure number, given",
                first,
                Known::Dimension(ONE),
            )?;
            Ok(Known::Dimension(ONE))
        }
    }
}
