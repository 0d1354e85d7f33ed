//! Laws as symbolic expressions, from which code in other languages is written.
//!
//! An effect states its law once as an [`Expression`] in the variables of the motion and its own parameters; whoever
//! writes source code puts names or numbers in their places.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// What a law depends on beside its parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variable {
    /// m of the motor at joint scale, or q for a law at the joint.
    Position,
    /// Its rate, rad/s (m/s).
    Velocity,
    /// The rate of that, rad/s² (m/s²).
    Acceleration,
    /// `ṁ/(|ṁ| + w)`.
    Sign,
    /// s from the start of the recording.
    Time,
    /// τ_M, what the gear transmits.
    Load,
    /// The current, A; its size in the polynomial from current to torque.
    Current,
    /// °C.
    Temperature,
    /// s, after which the motion repeats.
    Period,
    /// Position and velocity of another joint's motor, by its place among those that the law names.
    OtherPosition(usize),
    /// The velocity of such a joint, rad/s (m/s).
    OtherVelocity(usize),
    /// A state of a law with memory, by its place among the law's own.
    State(usize),
    /// s over which the state goes on.
    Duration,
    /// Lag δ of the link behind the motor, and its rate.
    Lag,
    /// Rate of the lag, rad/s (m/s).
    LagRate,
}

/// A function of one or two arguments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    /// sin x, x in rad.
    Sine,
    /// cos x, x in rad.
    Cosine,
    /// eˣ.
    Exponential,
    /// Natural logarithm.
    Logarithm,
    /// tanh x.
    HyperbolicTangent,
    /// |x|.
    Magnitude,
    /// √x.
    SquareRoot,
    /// `sgn x`, 0 at 0.
    Signum,
    /// xʸ of x and y.
    Power,
    /// The lesser of two.
    Smaller,
    /// The greater of two.
    Larger,
}

/// An arithmetic operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operator {
    /// a + b.
    Sum,
    /// a − b.
    Difference,
    /// a · b.
    Product,
    /// a / b.
    Quotient,
}

/// A formula.
#[derive(Debug, Clone, PartialEq)]
pub enum Expression {
    /// A constant.
    Number(f64),
    /// A parameter of the effect by its position, borrowed ones behind its own.
    Parameter(usize),
    /// Something of the motion or its surroundings.
    Variable(Variable),
    /// A name of the program that the formula is written into.
    Name(String),
    /// −a.
    Negative(Box<Expression>),
    /// An operation on two formulas, in their order.
    Binary(Operator, Box<[Expression; 2]>),
    /// A function of one or two formulas.
    Call(Function, Vec<Expression>),
    /// The third where the first is less than the second, else the fourth.
    Less(Box<[Expression; 4]>),
}

/// How a state of a law with memory goes on from one sample to the next.
#[derive(Debug, Clone, PartialEq)]
pub struct StateLaw {
    /// The state at the first sample, from its velocity.
    pub start: Expression,
    /// The state after a part of a step, from the one before, the velocity in the middle of the part and its duration.
    pub advance: Expression,
    /// Parts of a step, along which the velocity changes evenly.
    pub parts: usize,
}

impl Expression {
    /// The parameter at a position of the effect's own list.
    pub fn parameter(position: usize) -> Self {
        Self::Parameter(position)
    }

    /// A name that means something in the program that the formula is written into.
    pub fn name(name: impl Into<String>) -> Self {
        Self::Name(name.into())
    }

    /// A function of this formula.
    pub fn call(self, function: Function) -> Self {
        Self::Call(function, vec![self])
    }

    /// A function of this formula and a second one.
    pub fn call_with(self, function: Function, second: impl Into<Self>) -> Self {
        Self::Call(function, vec![self, second.into()])
    }

    /// The formula times itself.
    pub fn squared(self) -> Self {
        self.clone() * self
    }

    /// e to the power of the formula.
    pub fn exponential(self) -> Self {
        self.call(Function::Exponential)
    }

    /// The formula without its sign.
    pub fn magnitude(self) -> Self {
        self.call(Function::Magnitude)
    }

    /// `if self < bound { then } else { otherwise }`.
    pub fn if_less(
        self,
        bound: impl Into<Self>,
        then: impl Into<Self>,
        otherwise: impl Into<Self>,
    ) -> Self {
        Self::Less(Box::new([
            self,
            bound.into(),
            then.into(),
            otherwise.into(),
        ]))
    }

    /// Whether any part of the formula is so.
    pub fn any(&self, is: &dyn Fn(&Self) -> bool) -> bool {
        is(self)
            || match self {
                Self::Number(_) | Self::Parameter(_) | Self::Variable(_) | Self::Name(_) => false,
                Self::Negative(of) => of.any(is),
                Self::Binary(_, pair) => pair.iter().any(|of| of.any(is)),
                Self::Call(_, of) => of.iter().any(|of| of.any(is)),
                Self::Less(four) => four.iter().any(|of| of.any(is)),
            }
    }

    /// Whether the formula has a variable in it.
    pub fn depends_on(&self, variable: Variable) -> bool {
        self.any(&|part| *part == Self::Variable(variable))
    }

    /// The formula with other expressions in the places of some.
    pub fn replaced(&self, by: &dyn Fn(&Self) -> Option<Self>) -> Self {
        if let Some(other) = by(self) {
            return other;
        }
        let inner = |of: &Self| of.replaced(by);
        match self {
            Self::Number(_) | Self::Parameter(_) | Self::Variable(_) | Self::Name(_) => {
                self.clone()
            }
            Self::Negative(of) => Self::Negative(Box::new(inner(of))),
            Self::Binary(operator, pair) => {
                Self::Binary(*operator, Box::new([inner(&pair[0]), inner(&pair[1])]))
            }
            Self::Call(function, of) => Self::Call(*function, of.iter().map(inner).collect()),
            Self::Less(four) => Self::Less(Box::new([0, 1, 2, 3].map(|k| inner(&four[k])))),
        }
    }
}

impl From<f64> for Expression {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<Variable> for Expression {
    fn from(variable: Variable) -> Self {
        Self::Variable(variable)
    }
}

fn binary(operator: Operator, a: Expression, b: impl Into<Expression>) -> Expression {
    Expression::Binary(operator, Box::new([a, b.into()]))
}

impl<T: Into<Expression>> Add<T> for Expression {
    type Output = Self;
    fn add(self, other: T) -> Self {
        binary(Operator::Sum, self, other)
    }
}

impl<T: Into<Expression>> Sub<T> for Expression {
    type Output = Self;
    fn sub(self, other: T) -> Self {
        binary(Operator::Difference, self, other)
    }
}

impl<T: Into<Expression>> Mul<T> for Expression {
    type Output = Self;
    fn mul(self, other: T) -> Self {
        binary(Operator::Product, self, other)
    }
}

impl<T: Into<Expression>> Div<T> for Expression {
    type Output = Self;
    fn div(self, other: T) -> Self {
        binary(Operator::Quotient, self, other)
    }
}

impl Neg for Expression {
    type Output = Self;
    fn neg(self) -> Self {
        Self::Negative(Box::new(self))
    }
}

/// `1/(1 + e^(−x))`, without overflow.
pub fn logistic(x: Expression) -> Expression {
    (x * 0.5).call(Function::HyperbolicTangent) * 0.5 + 0.5
}
