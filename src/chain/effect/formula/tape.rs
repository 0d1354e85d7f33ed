//! The compiler of formulas to a list of instructions over lanes of samples.
//!
//! What several formulas share, a law and its derivatives above all, is worked out once. Instructions that no variable enters
//! are run once for all samples, those of the motion for [`LANES`] samples at a time, and those of a state, which has to be
//! known before the next, one sample after the other.

use crate::chain::effect::expression::{Expression, Function, Operator, Variable};
use crate::chain::effect::law::signum;
use std::cell::RefCell;
use std::collections::HashMap;

/// Samples at a time: a register is a few vectors wide, and fifty of them stay in the first-level cache.
pub const LANES: usize = 32;

/// A value of [`LANES`] samples.
pub type Register = [f64; LANES];

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Instruction {
    /// Bits of a number.
    Number(u64),
    Parameter(usize),
    /// An input by its place.
    Input(usize),
    Negative(usize),
    Sum(usize, usize),
    Difference(usize, usize),
    Product(usize, usize),
    Quotient(usize, usize),
    Call(Unary, usize),
    Power(usize, usize),
    Smaller(usize, usize),
    Larger(usize, usize),
    /// The third where the first is less than the second, else the fourth.
    Less(usize, usize, usize, usize),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Unary {
    Sine,
    Cosine,
    Exponential,
    Logarithm,
    HyperbolicTangent,
    Magnitude,
    SquareRoot,
    Signum,
}

/// How often an instruction is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Pace {
    Once,
    PerSamples,
    PerState,
}

/// How states are given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum States {
    /// As series, like other variables.
    Known,
    /// One after the other: what depends on them is run sample by sample.
    Marched,
}

/// Compiled formulas.
#[derive(Debug)]
pub struct Tape {
    /// Those that are run once, then those of samples, then those of states.
    instructions: Vec<Instruction>,
    once: usize,
    per_samples: usize,
    inputs: Vec<Variable>,
    /// Registers of the inputs.
    input_at: Vec<usize>,
    outputs: Vec<usize>,
}

impl Tape {
    /// Compiles formulas, whose values are the outputs in this order.
    pub fn compile(formulas: &[Expression], states: States) -> Self {
        let mut compiler = Compiler {
            states,
            ..Compiler::default()
        };
        let outputs: Vec<usize> = formulas.iter().map(|f| compiler.add(f)).collect();
        compiler.ordered(&outputs)
    }

    /// The variables that the formulas have in them.
    pub fn inputs(&self) -> &[Variable] {
        &self.inputs
    }

    /// Registers for values of the parameters.
    pub fn run(&self, parameters: &[f64]) -> Run<'_> {
        let spare = SPARE.with_borrow_mut(Vec::pop);
        let mut registers = spare.unwrap_or_default();
        registers.resize(self.instructions.len(), [0.0; LANES]);
        let mut run = Run {
            tape: self,
            registers,
        };
        for at in 0..self.once {
            run.work_out(at, Some(parameters));
        }
        run
    }
}

thread_local! {
    /// Registers of runs that are over, one set for each that was under way at once.
    static SPARE: RefCell<Vec<Vec<Register>>> = const { RefCell::new(Vec::new()) };
}

/// A tape with values of its parameters.
#[derive(Debug)]
pub struct Run<'t> {
    tape: &'t Tape,
    registers: Vec<Register>,
}

impl Drop for Run<'_> {
    fn drop(&mut self) {
        let registers = std::mem::take(&mut self.registers);
        SPARE.with_borrow_mut(|spare| spare.push(registers));
    }
}

impl Run<'_> {
    /// The register of an input, by its place among [`Tape::inputs`].
    pub fn input(&mut self, place: usize) -> &mut Register {
        &mut self.registers[self.tape.input_at[place]]
    }

    /// Works out everything that the samples at hand say.
    pub fn samples(&mut self) {
        for at in self.tape.once..self.tape.per_samples {
            self.work_out(at, None);
        }
    }

    /// Works out what depends on a state, of one sample.
    pub fn state(&mut self, lane: usize, state: f64) {
        for (place, variable) in self.tape.inputs.iter().enumerate() {
            if matches!(variable, Variable::State(_)) {
                self.registers[self.tape.input_at[place]][lane] = state;
            }
        }
        for at in self.tape.per_samples..self.tape.instructions.len() {
            self.registers[at][lane] = self.of_lane(self.tape.instructions[at], at, lane);
        }
    }

    /// The values of a formula.
    pub fn output(&self, formula: usize) -> &Register {
        &self.registers[self.tape.outputs[formula]]
    }

    fn of_lane(&self, instruction: Instruction, at: usize, lane: usize) -> f64 {
        use Instruction as I;
        let r = |k: usize| self.registers[k][lane];
        match instruction {
            I::Number(_) | I::Parameter(_) | I::Input(_) => r(at),
            I::Negative(a) => -r(a),
            I::Sum(a, b) => r(a) + r(b),
            I::Difference(a, b) => r(a) - r(b),
            I::Product(a, b) => r(a) * r(b),
            I::Quotient(a, b) => r(a) / r(b),
            I::Call(function, a) => call(function, r(a)),
            I::Power(a, b) => r(a).powf(r(b)),
            I::Smaller(a, b) => smaller(r(a), r(b)),
            I::Larger(a, b) => larger(r(a), r(b)),
            I::Less(a, b, then, otherwise) => r(if r(a) < r(b) { then } else { otherwise }),
        }
    }

    fn work_out(&mut self, at: usize, parameters: Option<&[f64]>) {
        use Instruction as I;
        let (before, rest) = self.registers.split_at_mut(at);
        let Some(out) = rest.first_mut() else { return };
        let r = |k: usize| &before[k];
        match self.tape.instructions[at] {
            I::Number(bits) => out.fill(f64::from_bits(bits)),
            I::Parameter(k) => {
                let value = parameters.and_then(|all| all.get(k));
                out.fill(value.copied().unwrap_or(f64::NAN));
            }
            I::Input(_) => {}
            I::Negative(a) => one(out, r(a), |a| -a),
            I::Sum(a, b) => two(out, r(a), r(b), |a, b| a + b),
            I::Difference(a, b) => two(out, r(a), r(b), |a, b| a - b),
            I::Product(a, b) => two(out, r(a), r(b), |a, b| a * b),
            I::Quotient(a, b) => two(out, r(a), r(b), |a, b| a / b),
            I::Call(Unary::Magnitude, a) => one(out, r(a), f64::abs),
            I::Call(Unary::SquareRoot, a) => one(out, r(a), f64::sqrt),
            I::Call(Unary::Signum, a) => one(out, r(a), signum),
            I::Call(function, a) => one(out, r(a), |a| call(function, a)),
            I::Power(a, b) => two(out, r(a), r(b), f64::powf),
            I::Smaller(a, b) => two(out, r(a), r(b), smaller),
            I::Larger(a, b) => two(out, r(a), r(b), larger),
            I::Less(a, b, then, otherwise) => {
                for (lane, out) in out.iter_mut().enumerate() {
                    let is_less = r(a)[lane] < r(b)[lane];
                    *out = r(if is_less { then } else { otherwise })[lane];
                }
            }
        }
    }
}

/// The first where it is the smaller one: as the derivative takes sides.
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

fn larger(a: f64, b: f64) -> f64 {
    if a < b { b } else { a }
}

fn call(function: Unary, a: f64) -> f64 {
    match function {
        Unary::Sine => a.sin(),
        Unary::Cosine => a.cos(),
        Unary::Exponential => a.exp(),
        Unary::Logarithm => a.ln(),
        Unary::HyperbolicTangent => a.tanh(),
        Unary::Magnitude => a.abs(),
        Unary::SquareRoot => a.sqrt(),
        Unary::Signum => signum(a),
    }
}

#[inline(always)]
fn one(out: &mut Register, a: &Register, f: impl Fn(f64) -> f64) {
    out.iter_mut().zip(a).for_each(|(out, a)| *out = f(*a));
}

#[inline(always)]
fn two(out: &mut Register, a: &Register, b: &Register, f: impl Fn(f64, f64) -> f64) {
    let pairs = a.iter().zip(b);
    out.iter_mut()
        .zip(pairs)
        .for_each(|(out, (a, b))| *out = f(*a, *b));
}

#[derive(Debug)]
struct Compiler {
    instructions: Vec<Instruction>,
    paces: Vec<Pace>,
    known: HashMap<Instruction, usize>,
    inputs: Vec<Variable>,
    states: States,
}

impl Default for Compiler {
    fn default() -> Self {
        Self {
            instructions: Vec::new(),
            paces: Vec::new(),
            known: HashMap::new(),
            inputs: Vec::new(),
            states: States::Known,
        }
    }
}

impl Compiler {
    fn add(&mut self, formula: &Expression) -> usize {
        use Instruction as I;
        let instruction = match formula {
            Expression::Number(value) => I::Number(value.to_bits()),
            Expression::Parameter(position) => I::Parameter(*position),
            Expression::Variable(variable) => I::Input(self.input(*variable)),
            // A name is of a program that is written, never of one that is run.
            Expression::Name(_) => I::Number(f64::NAN.to_bits()),
            Expression::Negative(of) => I::Negative(self.add(of)),
            Expression::Binary(operator, pair) => {
                let [a, b] = [0, 1].map(|k| self.add(&pair[k]));
                match operator {
                    Operator::Sum => I::Sum(a.min(b), a.max(b)),
                    Operator::Difference => I::Difference(a, b),
                    Operator::Product => I::Product(a.min(b), a.max(b)),
                    Operator::Quotient => I::Quotient(a, b),
                }
            }
            Expression::Call(function, of) => {
                let of: Vec<usize> = of.iter().map(|e| self.add(e)).collect();
                called(*function, &of)
            }
            Expression::Less(four) => {
                let [a, b, then, otherwise] = [0, 1, 2, 3].map(|k| self.add(&four[k]));
                I::Less(a, b, then, otherwise)
            }
        };
        if let Some(at) = self.known.get(&instruction) {
            return *at;
        }
        let at = self.instructions.len();
        self.paces.push(self.pace(instruction));
        self.instructions.push(instruction);
        self.known.insert(instruction, at);
        at
    }

    fn input(&mut self, variable: Variable) -> usize {
        let known = self.inputs.iter().position(|other| *other == variable);
        known.unwrap_or_else(|| {
            self.inputs.push(variable);
            self.inputs.len() - 1
        })
    }

    fn pace(&self, instruction: Instruction) -> Pace {
        if let Instruction::Input(k) = instruction {
            let is_state = matches!(self.inputs[k], Variable::State(_));
            return match is_state && self.states == States::Marched {
                true => Pace::PerState,
                false => Pace::PerSamples,
            };
        }
        let of = operands(instruction).into_iter().flatten();
        of.map(|k| self.paces[k]).max().unwrap_or(Pace::Once)
    }

    /// The tape, instructions in the order of their paces: operands are never slower than what is made of them.
    fn ordered(self, outputs: &[usize]) -> Tape {
        let mut order: Vec<usize> = (0..self.instructions.len()).collect();
        order.sort_by_key(|&at| self.paces[at]);
        let mut place = vec![0; order.len()];
        for (to, &from) in order.iter().enumerate() {
            place[from] = to;
        }
        let instructions: Vec<Instruction> = order
            .iter()
            .map(|&at| moved(self.instructions[at], &place))
            .collect();
        let count = |pace: Pace| self.paces.iter().filter(|p| **p <= pace).count();
        let mut input_at = vec![0; self.inputs.len()];
        for (at, instruction) in instructions.iter().enumerate() {
            if let Instruction::Input(k) = instruction {
                input_at[*k] = at;
            }
        }
        Tape {
            once: count(Pace::Once),
            per_samples: count(Pace::PerSamples),
            instructions,
            inputs: self.inputs,
            input_at,
            outputs: outputs.iter().map(|&at| place[at]).collect(),
        }
    }
}

fn called(function: Function, of: &[usize]) -> Instruction {
    use Instruction as I;
    let unary = match (function, of) {
        (Function::Power, [a, b]) => return I::Power(*a, *b),
        (Function::Smaller, [a, b]) => return I::Smaller(*a, *b),
        (Function::Larger, [a, b]) => return I::Larger(*a, *b),
        (Function::Sine, _) => Unary::Sine,
        (Function::Cosine, _) => Unary::Cosine,
        (Function::Exponential, _) => Unary::Exponential,
        (Function::Logarithm, _) => Unary::Logarithm,
        (Function::HyperbolicTangent, _) => Unary::HyperbolicTangent,
        (Function::Magnitude, _) => Unary::Magnitude,
        (Function::SquareRoot, _) => Unary::SquareRoot,
        (Function::Signum | Function::Power | Function::Smaller | Function::Larger, _) => {
            Unary::Signum
        }
    };
    I::Call(unary, of[0])
}

fn operands(of: Instruction) -> [Option<usize>; 4] {
    use Instruction as I;
    match of {
        I::Number(_) | I::Parameter(_) | I::Input(_) => [None; 4],
        I::Negative(a) | I::Call(_, a) => [Some(a), None, None, None],
        I::Sum(a, b)
        | I::Difference(a, b)
        | I::Product(a, b)
        | I::Quotient(a, b)
        | I::Power(a, b)
        | I::Smaller(a, b)
        | I::Larger(a, b) => [Some(a), Some(b), None, None],
        I::Less(a, b, c, d) => [a, b, c, d].map(Some),
    }
}

fn moved(of: Instruction, place: &[usize]) -> Instruction {
    use Instruction as I;
    match of {
        I::Number(_) | I::Parameter(_) | I::Input(_) => of,
        I::Negative(a) => I::Negative(place[a]),
        I::Call(function, a) => I::Call(function, place[a]),
        I::Sum(a, b) => I::Sum(place[a], place[b]),
        I::Difference(a, b) => I::Difference(place[a], place[b]),
        I::Product(a, b) => I::Product(place[a], place[b]),
        I::Quotient(a, b) => I::Quotient(place[a], place[b]),
        I::Power(a, b) => I::Power(place[a], place[b]),
        I::Smaller(a, b) => I::Smaller(place[a], place[b]),
        I::Larger(a, b) => I::Larger(place[a], place[b]),
        I::Less(a, b, c, d) => I::Less(place[a], place[b], place[c], place[d]),
    }
}
