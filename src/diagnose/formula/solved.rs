//! Least-squares sizes of the terms of a formula, and its score by the variance that it explains beyond a model.
//!
//! ```text
//! x = −(C⊥ᵀC⊥)⁻¹ C⊥ᵀ r,   gain = −rᵀC⊥ x,   score = N ln(1 − gain/‖r‖²) + p ln N + 2 Σ ln M
//! ```
//!
//! with the residual r, the columns C⊥ of the terms without what the model's own parameters can take, N rows, p parameters, and
//! the number M of terms that each was chosen from.

use crate::diagnose::candidates::score_test::Linearised;
use crate::diagnose::fit::linear_model::dot;
use crate::diagnose::formula::grammar::Grammar;
use crate::diagnose::formula::rows::FittedRows;
use crate::diagnose::formula::term::Term;
use crate::linalg::normal_equations::{INDEPENDENT, NormalSolution};
use nalgebra::{DMatrix, DVector};

/// A series in the channel, and what the model's own parameters can take of it.
#[derive(Debug, Clone)]
pub struct Column {
    pub series: Vec<f64>,
    pub taken: DVector<f64>,
}

impl Column {
    /// Product of two columns without what the model can take.
    pub fn dot(&self, other: &Self) -> f64 {
        dot(&self.series, &other.series) - self.taken.dot(&other.taken)
    }

    /// Whether it has something that the model cannot take.
    pub fn is_new(&self) -> bool {
        self.dot(self) > INDEPENDENT.sqrt() * dot(&self.series, &self.series)
    }

    /// Takes a multiple of another away.
    pub fn less(&mut self, factor: f64, other: &Self) {
        let pairs = self.series.iter_mut().zip(&other.series);
        pairs.for_each(|(a, b)| *a -= factor * b);
        self.taken.axpy(-factor, &other.taken, 1.0);
    }

    pub fn scaled(mut self, by: f64) -> Self {
        self.series.iter_mut().for_each(|x| *x *= by);
        self.taken *= by;
        self
    }
}

/// A sum of terms.
#[derive(Debug, Clone)]
pub struct Solved {
    pub terms: Vec<Term>,
    /// Sizes of the columns of each term.
    pub sizes: Vec<Vec<f64>>,
    /// The less the better.
    pub score: f64,
}

impl Solved {
    /// The same terms, whatever their parameters.
    pub fn is_like(&self, other: &Self) -> bool {
        let has = |term: &Term| other.terms.iter().any(|t| t.is_like(term));
        self.terms.len() == other.terms.len() && self.terms.iter().all(has)
    }
}

/// The misfit of a channel, and what formulas may take of it.
pub struct Misfit<'a> {
    pub linearised: &'a Linearised<'a>,
    pub channel: usize,
    pub rows: &'a FittedRows,
    pub grammar: &'a Grammar,
}

impl Misfit<'_> {
    pub fn residual(&self) -> &[f64] {
        self.linearised.residual_of(self.channel)
    }

    /// Sum of the squares of the residual.
    pub fn total(&self) -> f64 {
        dot(self.residual(), self.residual())
    }

    pub fn columns(&self, term: &Term) -> Vec<Column> {
        let all = term.columns(self.rows).into_iter();
        all.map(|series| Column {
            taken: self.linearised.taken_of(self.channel, &series),
            series,
        })
        .collect()
    }

    pub fn solve(&self, terms: Vec<Term>) -> Solved {
        let columns: Vec<Vec<Column>> = terms.iter().map(|term| self.columns(term)).collect();
        let columns: Vec<&[Column]> = columns.iter().map(Vec::as_slice).collect();
        self.solve_of(terms, &columns)
    }

    /// The same of terms whose columns are known.
    pub fn solve_of(&self, terms: Vec<Term>, columns: &[&[Column]]) -> Solved {
        let all: Vec<&Column> = columns.iter().copied().flatten().collect();
        let is_new: Vec<bool> = all.iter().map(|column| column.is_new()).collect();
        let count = all.len();
        // What the model has already takes nothing.
        let normal = DMatrix::from_fn(count, count, |i, j| match is_new[i] && is_new[j] {
            true => all[i].dot(all[j]),
            false => f64::from(u8::from(i == j)),
        });
        let right = DVector::from_fn(count, |i, _| match is_new[i] {
            true => dot(self.residual(), &all[i].series),
            false => 0.0,
        });
        let solution = NormalSolution::of(&normal, &right);
        let mut next = solution.x.iter().map(|x| -x);
        let sizes = columns
            .iter()
            .map(|own| next.by_ref().take(own.len()).collect());
        Solved {
            sizes: sizes.collect(),
            score: self.score(&terms, solution.gain),
            terms,
        }
    }

    fn score(&self, terms: &[Term], gain: f64) -> f64 {
        let rows = self.rows.count() as f64;
        let total = self.total();
        let left = (total - gain)
            .max(f64::EPSILON * total)
            .max(f64::MIN_POSITIVE);
        let parameters: usize = terms.iter().map(Term::parameters).sum();
        let chosen: f64 = terms.iter().map(|term| self.grammar.charge(term)).sum();
        rows * (left / total.max(f64::MIN_POSITIVE)).ln() + parameters as f64 * rows.ln() + chosen
    }
}
