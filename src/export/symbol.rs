//! Symbolic arithmetic: the recursions of the robot run on [`Symbol`]s, and the
//! tape of this thread keeps every operation once.
//!
//! Constants fold, products with 0 and 1 vanish, and an operation on the same operands is the same symbol,
//! so that what is left is what this one robot needs.

use crate::export::tape::{Operation, Tape};
use crate::linalg::lanes::scalar::Scalar;
use std::cell::RefCell;
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

thread_local! {
    static TAPE: RefCell<Tape> = RefCell::new(Tape::default());
}

/// The result of an operation on the tape of this thread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Symbol(u32);

/// Writes down what `computation` does with symbols; gives its results and the tape.
pub fn record<T>(computation: impl FnOnce() -> T) -> (T, Tape) {
    TAPE.take();
    let results = computation();
    (results, TAPE.take())
}

impl Symbol {
    /// The input with this number.
    pub fn input(number: usize) -> Self {
        push(Operation::Input(number))
    }

    /// Position on the tape.
    pub fn position(self) -> usize {
        self.0 as usize
    }

    fn operation(self) -> Operation {
        TAPE.with_borrow(|tape| tape.operation(self.position()))
    }

    fn value(self) -> Option<f64> {
        match self.operation() {
            Operation::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// The symbol of which this one is the negative.
    fn negated(self) -> Option<Self> {
        match self.operation() {
            Operation::Negative(of) => Some(Self(of)),
            _ => None,
        }
    }
}

fn push(operation: Operation) -> Symbol {
    Symbol(TAPE.with_borrow_mut(|tape| tape.push(operation)))
}

impl Scalar for Symbol {
    fn constant(value: f64) -> Self {
        // One zero: the negative one would be another symbol.
        push(Operation::Constant((value + 0.0).to_bits()))
    }

    fn mul_add(self, factor: Self, addend: Self) -> Self {
        self * factor + addend
    }

    fn sin_cos(self) -> (Self, Self) {
        (
            push(Operation::Sine(self.0)),
            push(Operation::Cosine(self.0)),
        )
    }
}

impl Add for Symbol {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        match (self.value(), other.value()) {
            (Some(a), Some(b)) => return Self::constant(a + b),
            (Some(0.0), _) => return other,
            (_, Some(0.0)) => return self,
            _ => {}
        }
        if let Some(b) = other.negated() {
            return self - b;
        }
        if let Some(a) = self.negated() {
            return other - a;
        }
        push(Operation::Sum(self.0.min(other.0), self.0.max(other.0)))
    }
}

impl Sub for Symbol {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        match (self.value(), other.value()) {
            (Some(a), Some(b)) => return Self::constant(a - b),
            (Some(0.0), _) => return -other,
            (_, Some(0.0)) => return self,
            _ if self == other => return Self::constant(0.0),
            _ => {}
        }
        match other.negated() {
            Some(b) => self + b,
            None => push(Operation::Difference(self.0, other.0)),
        }
    }
}

impl Mul for Symbol {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        match (self.value(), other.value()) {
            (Some(a), Some(b)) => return Self::constant(a * b),
            (Some(0.0), _) | (_, Some(0.0)) => return Self::constant(0.0),
            (Some(1.0), _) => return other,
            (_, Some(1.0)) => return self,
            (Some(-1.0), _) => return -other,
            (_, Some(-1.0)) => return -self,
            _ => {}
        }
        match (self.negated(), other.negated()) {
            (Some(a), Some(b)) => a * b,
            (Some(a), None) => -(a * other),
            (None, Some(b)) => -(self * b),
            (None, None) => push(Operation::Product(self.0.min(other.0), self.0.max(other.0))),
        }
    }
}

impl Neg for Symbol {
    type Output = Self;
    fn neg(self) -> Self {
        if let Some(value) = self.value() {
            return Self::constant(-value);
        }
        match self.negated() {
            Some(of) => of,
            None => push(Operation::Negative(self.0)),
        }
    }
}

impl AddAssign for Symbol {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
