//! A straight line of operations, each written once, and the part of it that given results need.

use std::collections::HashMap;

/// An operation on earlier ones, named by their positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Operation {
    /// Bits of the number.
    Constant(u64),
    Input(usize),
    Sine(u32),
    Cosine(u32),
    Negative(u32),
    Sum(u32, u32),
    Difference(u32, u32),
    Product(u32, u32),
}

impl Operation {
    /// Positions of the operands.
    pub fn operands(self) -> impl Iterator<Item = usize> {
        let pair = match self {
            Self::Constant(_) | Self::Input(_) => [None, None],
            Self::Sine(a) | Self::Cosine(a) | Self::Negative(a) => [Some(a), None],
            Self::Sum(a, b) | Self::Difference(a, b) | Self::Product(a, b) => [Some(a), Some(b)],
        };
        pair.into_iter().flatten().map(|position| position as usize)
    }
}

/// Operations in the order in which they can be done.
#[derive(Debug, Clone, Default)]
pub struct Tape {
    operations: Vec<Operation>,
    positions: HashMap<Operation, u32>,
}

impl Tape {
    /// The position of an operation, a new one unless it stands there already.
    pub fn push(&mut self, operation: Operation) -> u32 {
        let next = self.operations.len() as u32;
        *self.positions.entry(operation).or_insert_with(|| {
            self.operations.push(operation);
            next
        })
    }

    pub fn operation(&self, position: usize) -> Operation {
        self.operations[position]
    }

    /// Positions of the operations that the results rest on, in order.
    pub fn needed(&self, results: &[usize]) -> Vec<usize> {
        let mut needed = vec![false; self.operations.len()];
        for &result in results {
            needed[result] = true;
        }
        for position in (0..self.operations.len()).rev() {
            if needed[position] {
                for operand in self.operations[position].operands() {
                    needed[operand] = true;
                }
            }
        }
        (0..needed.len()).filter(|&k| needed[k]).collect()
    }
}
