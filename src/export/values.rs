//! What stands in formulas for the numbers of a robot: the numbers themselves, or entries of an array `p` that a program
//! reads them into before it begins.

use crate::chain::effect::expression::Expression;
use std::cell::RefCell;

/// A number that a program reads.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// As results name it, the joint in front.
    pub key: String,
    /// Name of the joint.
    pub joint: String,
    /// In its SI unit.
    pub value: f64,
    /// Least value with which the formulas mean something.
    pub lower: f64,
    /// The greatest.
    pub upper: f64,
}

impl Setting {
    /// A number of a joint that may have any value.
    pub fn of(joint: &str, name: &str, value: f64) -> Self {
        Self {
            key: format!("{joint}.{name}"),
            joint: joint.to_string(),
            value,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
        }
    }
}

/// An entry of the array.
#[derive(Debug, Clone)]
enum Entry {
    Read(Setting),
    /// Follows from entries that are read.
    Derived,
}

/// What stands for numbers.
#[derive(Debug)]
pub enum Values {
    /// They do.
    Numbers,
    /// Entries of the array `p`.
    Array(Array),
}

/// The array `p` while formulas are written.
#[derive(Debug, Default)]
pub struct Array {
    entries: RefCell<Vec<Entry>>,
}

/// A number that is read, and its place in the array.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedSetting {
    /// The number.
    pub setting: Setting,
    /// From 0.
    pub place: usize,
}

impl Values {
    /// What stands for a number; one place for all that have its key.
    pub fn stand_for(&self, setting: Setting) -> Expression {
        match self {
            Self::Numbers => Expression::Number(setting.value),
            Self::Array(array) => entry(array.place_of(setting)),
        }
    }

    /// Entries of the array.
    pub fn count(&self) -> usize {
        match self {
            Self::Numbers => 0,
            Self::Array(array) => array.entries.borrow().len(),
        }
    }

    /// What is read into the array.
    pub fn settings(&self) -> Vec<PlacedSetting> {
        let Self::Array(array) = self else {
            return Vec::new();
        };
        let entries = array.entries.borrow();
        let read = entries.iter().enumerate();
        let read = read.filter_map(|(place, entry)| match entry {
            Entry::Read(setting) => Some(PlacedSetting {
                setting: setting.clone(),
                place,
            }),
            Entry::Derived => None,
        });
        read.collect()
    }
}

impl Array {
    fn place_of(&self, setting: Setting) -> usize {
        let mut entries = self.entries.borrow_mut();
        let known = |entry: &Entry| matches!(entry, Entry::Read(other) if other.key == setting.key);
        match entries.iter().position(known) {
            Some(place) => place,
            None => {
                entries.push(Entry::Read(setting));
                entries.len() - 1
            }
        }
    }

    /// A new entry that the program derives from others.
    pub fn derived(&self) -> Expression {
        let mut entries = self.entries.borrow_mut();
        entries.push(Entry::Derived);
        entry(entries.len() - 1)
    }
}

fn entry(place: usize) -> Expression {
    Expression::name(format!("p[{place}]"))
}

/// a + b, without what adds nothing.
pub fn sum(a: Expression, b: Expression) -> Expression {
    match (&a, &b) {
        (Expression::Number(x), Expression::Number(y)) => Expression::Number(x + y),
        (Expression::Number(0.0), _) => b,
        (_, Expression::Number(0.0)) => a,
        _ => a + b,
    }
}

/// a · b, without factors of one, and zero where one of them is.
pub fn product(a: Expression, b: Expression) -> Expression {
    match (&a, &b) {
        (Expression::Number(x), Expression::Number(y)) => Expression::Number(x * y),
        (Expression::Number(1.0), _) => b,
        (_, Expression::Number(1.0)) => a,
        (Expression::Number(0.0), _) | (_, Expression::Number(0.0)) => Expression::Number(0.0),
        _ => a * b,
    }
}

/// Sum of products, without the terms that are zero.
pub fn combination<'f>(
    factors: impl IntoIterator<Item = &'f Expression>,
    of: impl Fn(usize) -> Expression,
) -> Expression {
    let terms = factors.into_iter().enumerate();
    let terms = terms.map(|(k, factor)| product(of(k), factor.clone()));
    terms.fold(Expression::Number(0.0), sum)
}
