//! Least-squares sizes of the terms of a formula, and its score by the likelihood of what it leaves.
//!
//! ```text
//! x = (C⊥ᵀC⊥)⁻¹ C⊥ᵀ r,   δ = (JᵀJ)⁻¹ JᵀC x,   r' = r − C x + J δ
//! score = Σ_c N_c ln(‖r'_c‖²/‖r_c‖²) + p ln N + 2 Σ ln M
//! ```
//!
//! with the residual r and the derivatives J of every channel c, the columns C of the terms in one of them, C⊥ without what the model's
//! own parameters can take, N_c rows, N of the formula's channel, p parameters, and the number M of terms that each was chosen from.
//! What a law has bent of the parameters is wrong in every channel, and comes right with it.

use crate::diagnose::fit::linear_model::{LinearModel, OwnProducts};
use crate::diagnose::formula::grammar::Grammar;
use crate::diagnose::formula::rows::FittedRows;
use crate::diagnose::formula::term::Term;
use crate::diagnose::residuals::quantity::Quantity;
use crate::linalg::lanes::inner_product::dot;
use crate::linalg::normal_equations::{INDEPENDENT, NormalSolution};
use nalgebra::{DMatrix, DVector};

/// A series in the channel, and what the model's own parameters can take of it.
#[derive(Debug, Clone)]
pub struct Column {
    pub series: Vec<f64>,
    /// Jᵀ c over the channel.
    pub by_model: DVector<f64>,
    /// R⁻ᵀ Jᵀ c.
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
        self.by_model.axpy(-factor, &other.by_model, 1.0);
        self.taken.axpy(-factor, &other.taken, 1.0);
    }

    pub fn scaled(mut self, by: f64) -> Self {
        self.series.iter_mut().for_each(|x| *x *= by);
        self.by_model *= by;
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
    /// What its terms are functions of, each once.
    pub fn variables(&self) -> Vec<Quantity> {
        let factors = self.terms.iter().flat_map(|term| &term.factors);
        let mut variables = Vec::new();
        for factor in factors {
            if !variables.contains(&factor.quantity) {
                variables.push(factor.quantity);
            }
        }
        variables
    }

    /// The same terms, whatever their parameters.
    pub fn is_like(&self, other: &Self) -> bool {
        let has = |term: &Term| other.terms.iter().any(|t| t.is_like(term));
        self.terms.len() == other.terms.len() && self.terms.iter().all(has)
    }
}

/// The misfit of a channel, and what formulas may take of it.
pub struct Misfit<'a> {
    linear: &'a LinearModel,
    channel: usize,
    rows: &'a FittedRows,
    pub grammar: &'a Grammar,
    /// Of all rows of each channel.
    products: Vec<OwnProducts>,
}

impl<'a> Misfit<'a> {
    /// Of a channel along the rows of a linearised model.
    pub fn of(
        linear: &'a LinearModel,
        channel: usize,
        rows: &'a FittedRows,
        grammar: &'a Grammar,
    ) -> Self {
        let lengths = linear.residual.iter().map(Vec::len).enumerate();
        Self {
            products: lengths
                .map(|(c, rows)| OwnProducts::of(linear, c, 0..rows))
                .collect(),
            linear,
            channel,
            rows,
            grammar,
        }
    }

    pub fn residual(&self) -> &[f64] {
        &self.linear.residual[self.channel]
    }

    pub fn columns(&self, term: &Term) -> Vec<Column> {
        let all = term.columns(self.rows).into_iter();
        all.map(|series| {
            let by_model = self.linear.against_columns(self.channel, &series);
            Column {
                taken: self.linear.project_one(&by_model),
                by_model,
                series,
            }
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
            score: self.score(&terms, &all, &solution.x),
            terms,
        }
    }

    fn score(&self, terms: &[Term], columns: &[&Column], sizes: &DVector<f64>) -> f64 {
        let mut factors = terms.iter().flat_map(|term| &term.factors);
        if !factors.all(|factor| self.grammar.is_inside(factor)) {
            return f64::INFINITY;
        }
        let parameters: usize = terms.iter().map(Term::parameters).sum();
        let charged = parameters as f64 * (self.rows.count() as f64).ln();
        let chosen: f64 = terms.iter().map(|term| self.grammar.charge(term)).sum();
        self.likelihood(columns, sizes) + charged + chosen
    }

    /// Minus twice the logarithm of the likelihood of what is left, over that of the residual.
    fn likelihood(&self, columns: &[&Column], sizes: &DVector<f64>) -> f64 {
        let mut series = vec![0.0; self.rows.count()];
        let unknowns = self.products[self.channel].right.len();
        let (mut by_model, mut taken) = (DVector::zeros(unknowns), DVector::zeros(unknowns));
        for (column, &size) in columns.iter().zip(sizes) {
            let rows = series.iter_mut().zip(&column.series);
            rows.for_each(|(sum, x)| *sum += size * x);
            by_model.axpy(size, &column.by_model, 1.0);
            taken.axpy(size, &column.taken, 1.0);
        }
        let step = self.linear.step_of(&taken);
        let of_channel = |(c, own): (usize, &OwnProducts)| {
            let moved = 2.0 * step.dot(&own.right) + step.dot(&(&own.square * &step));
            let less = match c == self.channel {
                true => {
                    2.0 * dot(self.residual(), &series) - dot(&series, &series)
                        + 2.0 * step.dot(&by_model)
                }
                false => 0.0,
            };
            let least = (f64::EPSILON * own.residual).max(f64::MIN_POSITIVE);
            let left = (own.residual + moved - less).max(least);
            let rows = self.linear.residual[c].len() as f64;
            rows * (left / own.residual.max(f64::MIN_POSITIVE)).ln()
        };
        self.products.iter().enumerate().map(of_channel).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::formula::factor::{Factor, Shape};
    use crate::diagnose::residuals::quantity::Quantity;
    use crate::robot::random::{generator, symmetric};

    /// A law that has bent what two channels have in common: the likelihood is that of what least squares over both leaves of each.
    #[test]
    fn matches_independent_implementation_by_dense_least_squares() {
        const ROWS: usize = 60;
        let rows = FittedRows::drawn(ROWS);
        let mut rng = generator(11);
        let mut drawn = || -> Vec<f64> { (0..ROWS).map(|_| symmetric(&mut rng, 1.0)).collect() };
        let columns: Vec<Vec<Vec<f64>>> = (0..2).map(|_| vec![drawn(), drawn()]).collect();
        let law = |row: usize| rows.series(Quantity::Position)[row].powi(2);
        let mut residual = [drawn(), drawn()];
        for row in 0..ROWS {
            residual[0][row] = 0.1 * residual[0][row] + law(row);
        }
        let system = |with: bool| {
            DMatrix::from_fn(2 * ROWS, 2 + usize::from(with), |row, k| match k {
                2 if row < ROWS => law(row),
                2 => 0.0,
                k => columns[row / ROWS][k][row % ROWS],
            })
        };
        let left = |system: &DMatrix<f64>, right: &DVector<f64>| {
            let solved = system.clone().svd(true, true).solve(right, 1e-12).unwrap();
            right - system * solved
        };
        // As a fit leaves it.
        let fitted = left(&system(false), &DVector::from_vec(residual.concat()));
        let of_channel = |all: &DVector<f64>, c: usize| all.rows(c * ROWS, ROWS).clone_owned();
        let linear = LinearModel::of_columns(
            columns
                .iter()
                .map(|of| of.iter().cloned().map(Some).collect())
                .collect(),
            [0, 1]
                .map(|c| of_channel(&fitted, c).as_slice().to_vec())
                .to_vec(),
            DMatrix::zeros(0, 2),
        );
        let grammar = Grammar::of(&rows, Some(&[Quantity::Position]));
        let misfit = Misfit::of(&linear, 0, &rows, &grammar);
        let square = Term::of(vec![Factor::plain(Quantity::Position, Shape::Power(2))]);
        let found = misfit.solve(vec![square.clone()]);
        let after = left(&system(true), &fitted);
        let of = |c: usize| {
            let [before, after] = [&fitted, &after].map(|all| of_channel(all, c).norm_squared());
            ROWS as f64 * (after / before).ln()
        };
        let charged = (ROWS as f64).ln() + grammar.charge(&square);
        let expected = of(0) + of(1) + charged;
        assert!(
            (found.score - expected).abs() < 1e-8,
            "{} {expected}",
            found.score
        );
        // The other channel is half of it.
        assert!(of(1) < -10.0);
    }
}
