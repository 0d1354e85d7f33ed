//! Beam search for formulas: terms one after the other, several formulas at a time, then their parts exchanged.

use crate::diagnose::formula::factor::{Factor, Shape};
use crate::diagnose::formula::solved::{Column, Misfit, Solved};
use crate::diagnose::formula::term::Term;
use crate::linalg::lanes::inner_product::dot;
use crate::linalg::normal_equations::INDEPENDENT;
use rayon::prelude::*;

/// Terms of a formula at most.
const MOST_TERMS: usize = 3;

/// Formulas that are kept for each number of terms.
const KEPT: usize = 5;

/// Terms of which the likelihood is looked at beside a formula, those that take most of the weighted residuals.
const CLOSER: usize = 40;

/// Of these, the ones whose parameters are refined.
const REFINED: usize = 10;

/// Formulas of each number of terms that a search gives.
const GIVEN: usize = 2;

/// Rounds in which parts of a formula are exchanged.
const ROUNDS: usize = 4;

/// Halvings by golden section of the interval in which a parameter lies, and rounds over all parameters.
const SECTIONS: usize = 12;
const SWEEPS: usize = 2;

/// A term of the grammar with its columns.
struct Candidate {
    term: Term,
    columns: Vec<Column>,
}

/// The foremost formulas of a misfit, the best score first; those that score no better than nothing are left out.
pub fn formulas(misfit: &Misfit<'_>, is_interrupted: &(dyn Fn() -> bool + Sync)) -> Vec<Solved> {
    let terms = misfit.grammar.terms.par_iter();
    let candidates: Vec<Candidate> = terms
        .map(|term| Candidate {
            term: term.clone(),
            columns: misfit.columns(term),
        })
        .collect();
    let mut level = vec![misfit.solve(Vec::new())];
    let mut given: Vec<Solved> = Vec::new();
    for _ in 0..MOST_TERMS {
        if is_interrupted() {
            break;
        }
        let grown: Vec<Solved> = level
            .par_iter()
            .flat_map_iter(|known| grown(misfit, &candidates, known))
            .collect();
        let refined = distinct(grown, KEPT).into_par_iter();
        let changed: Vec<Solved> = refined.map(|one| exchanged(misfit, one)).collect();
        let next = distinct(changed, KEPT);
        let best = |of: &[Solved]| of.iter().map(|s| s.score).fold(f64::INFINITY, f64::min);
        let better = best(&next) < best(&level);
        given.extend(next.iter().take(GIVEN).cloned());
        level = next;
        if !better {
            break;
        }
    }
    given.retain(|one| one.score < 0.0);
    distinct(given, GIVEN * MOST_TERMS)
}

/// A formula with one term more, each of those that score best among those that take most.
fn grown(misfit: &Misfit<'_>, candidates: &[Candidate], known: &Solved) -> Vec<Solved> {
    let basis = basis(misfit, known);
    let residual = misfit.residual();
    let shares: Vec<f64> = basis.iter().map(|e| dot(residual, &e.series)).collect();
    let mut gains: Vec<(f64, &Candidate)> = candidates
        .iter()
        .map(|candidate| (gain(candidate, residual, &basis, &shares), candidate))
        .collect();
    gains.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut foremost: Vec<&Candidate> = Vec::new();
    for (_, candidate) in gains {
        let is_new = |other: &&Candidate| !other.term.is_like(&candidate.term);
        if foremost.len() < CLOSER && foremost.iter().all(is_new) {
            foremost.push(candidate);
        }
    }
    let parts = Parts::of(misfit, known);
    let with = |candidate: &&Candidate| parts.and(candidate);
    let closer = distinct(foremost.iter().map(with).collect(), REFINED).into_iter();
    closer.map(|one| refined(misfit, one)).collect()
}

/// Orthonormal columns of a formula.
fn basis(misfit: &Misfit<'_>, known: &Solved) -> Vec<Column> {
    let mut basis: Vec<Column> = Vec::new();
    for column in known.terms.iter().flat_map(|term| misfit.columns(term)) {
        if let Some(unit) = unit_of(column, &basis) {
            basis.push(unit);
        }
    }
    basis
}

/// What a column has apart from a basis, with a norm of one; `None` where that is rounding.
fn unit_of(mut column: Column, basis: &[Column]) -> Option<Column> {
    let whole = dot(&column.series, &column.series);
    for unit in basis {
        let share = column.dot(unit);
        column.less(share, unit);
    }
    let norm = column.dot(&column);
    (norm > INDEPENDENT.sqrt() * whole).then(|| column.scaled(1.0 / norm.sqrt()))
}

/// Products of a column with itself and with the residual, without its shares of a basis.
struct Apart {
    shares: Vec<f64>,
    square: f64,
    right: f64,
}

impl Apart {
    /// `None` of a column that the model and the basis have already; `left` are the products of the residual with the basis.
    fn of(column: &Column, residual: &[f64], basis: &[Column], left: &[f64]) -> Option<Self> {
        let shares: Vec<f64> = basis.iter().map(|unit| column.dot(unit)).collect();
        let square = column.dot(column) - dot(&shares, &shares);
        let is_new = square > INDEPENDENT.sqrt() * dot(&column.series, &column.series);
        is_new.then(|| Self {
            right: dot(residual, &column.series) - dot(&shares, left),
            square,
            shares,
        })
    }
}

/// Sum of squares that a term takes beside a formula.
fn gain(candidate: &Candidate, residual: &[f64], basis: &[Column], left: &[f64]) -> f64 {
    let columns = &candidate.columns;
    let apart = columns.iter().map(|c| Apart::of(c, residual, basis, left));
    let Some(apart) = apart.collect::<Option<Vec<Apart>>>() else {
        return 0.0;
    };
    match &apart[..] {
        [one] => one.right * one.right / one.square,
        [a, b] => {
            let product = columns[0].dot(&columns[1]) - dot(&a.shares, &b.shares);
            let determinant = a.square * b.square - product * product;
            if determinant <= INDEPENDENT.sqrt() * a.square * b.square {
                return 0.0;
            }
            let squares = b.square * a.right * a.right + a.square * b.right * b.right;
            (squares - 2.0 * product * a.right * b.right) / determinant
        }
        _ => 0.0,
    }
}

/// The best formulas of different factors, the best first.
fn distinct(mut all: Vec<Solved>, most: usize) -> Vec<Solved> {
    all.sort_by(|a, b| a.score.total_cmp(&b.score));
    let mut kept: Vec<Solved> = Vec::new();
    for one in all {
        if kept.len() < most && kept.iter().all(|known| !known.is_like(&one)) {
            kept.push(one);
        }
    }
    kept
}

/// The formula with the parameters of its factors where it takes most.
fn refined(misfit: &Misfit<'_>, mut best: Solved) -> Solved {
    for _ in 0..SWEEPS {
        for t in 0..best.terms.len() {
            for f in 0..best.terms[t].factors.len() {
                let factor = best.terms[t].factors[f];
                if factor.shape.has_inner() {
                    let range = misfit.grammar.around(&factor);
                    best = sectioned(misfit, best, [t, f], range, Factor::with_inner);
                }
                if factor.has_centre() {
                    let range = misfit.grammar.around_centre(&factor);
                    best = sectioned(misfit, best, [t, f], range, Factor::about);
                }
            }
        }
    }
    best
}

/// One parameter by golden section about where it is (Kiefer 1953).
fn sectioned(
    misfit: &Misfit<'_>,
    best: Solved,
    [t, f]: [usize; 2],
    [mut low, mut high]: [f64; 2],
    set: fn(Factor, f64) -> Factor,
) -> Solved {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let factor = best.terms[t].factors[f];
    let parts = Parts::of(misfit, &best);
    let at = |value: f64| {
        let mut term = best.terms[t].clone();
        term.factors[f] = set(factor, value);
        (value, parts.with(t, term))
    };
    let mut left = at(high - GOLDEN * (high - low));
    let mut right = at(low + GOLDEN * (high - low));
    for _ in 0..SECTIONS {
        if left.1.score < right.1.score {
            high = right.0;
            right = left;
            left = at(high - GOLDEN * (high - low));
        } else {
            low = left.0;
            left = right;
            right = at(low + GOLDEN * (high - low));
        }
    }
    let found = if left.1.score < right.1.score {
        left.1
    } else {
        right.1
    };
    match found.score < best.score {
        true => found,
        false => best,
    }
}

/// The terms of a formula with their columns.
struct Parts<'a> {
    misfit: &'a Misfit<'a>,
    terms: &'a [Term],
    columns: Vec<Vec<Column>>,
}

impl<'a> Parts<'a> {
    fn of(misfit: &'a Misfit<'_>, formula: &'a Solved) -> Self {
        let columns = formula.terms.iter().map(|term| misfit.columns(term));
        Self {
            misfit,
            terms: &formula.terms,
            columns: columns.collect(),
        }
    }

    /// The formula with another term in the place of the t-th.
    fn with(&self, t: usize, term: Term) -> Solved {
        let own = self.misfit.columns(&term);
        let mut terms = self.terms.to_vec();
        terms[t] = term;
        let mut columns: Vec<&[Column]> = self.columns.iter().map(Vec::as_slice).collect();
        columns[t] = &own;
        self.misfit.solve_of(terms, &columns)
    }

    /// The formula with a term more.
    fn and(&self, candidate: &Candidate) -> Solved {
        let mut terms = self.terms.to_vec();
        terms.push(candidate.term.clone());
        let mut columns: Vec<&[Column]> = self.columns.iter().map(Vec::as_slice).collect();
        columns.push(&candidate.columns);
        self.misfit.solve_of(terms, &columns)
    }

    /// The formula without its t-th term.
    fn without(&self, t: usize) -> Solved {
        let mut terms = self.terms.to_vec();
        terms.remove(t);
        let mut columns: Vec<&[Column]> = self.columns.iter().map(Vec::as_slice).collect();
        columns.remove(t);
        self.misfit.solve_of(terms, &columns)
    }
}

/// The formula after its parts were exchanged for as long as that lowers its score.
fn exchanged(misfit: &Misfit<'_>, mut best: Solved) -> Solved {
    for _ in 0..ROUNDS {
        let tried = neighbours(misfit, &best).into_iter();
        let next = tried.min_by(|a, b| a.score.total_cmp(&b.score));
        match next.filter(|next| next.score < best.score) {
            Some(next) => best = refined(misfit, next),
            None => break,
        }
    }
    best
}

/// Formulas with one part less, one part more or one part exchanged.
fn neighbours(misfit: &Misfit<'_>, of: &Solved) -> Vec<Solved> {
    let parts = Parts::of(misfit, of);
    let mut all = Vec::new();
    for (t, term) in of.terms.iter().enumerate() {
        if of.terms.len() > 1 {
            all.push(parts.without(t));
        }
        let others: Vec<&Term> = (0..of.terms.len())
            .filter(|k| *k != t)
            .map(|k| &of.terms[k])
            .collect();
        let changed = changed(misfit, term).into_iter();
        let new = changed.filter(|term| others.iter().all(|other| !other.is_like(term)));
        all.extend(new.map(|term| parts.with(t, term)));
    }
    all
}

/// A term with one factor less, one more, or one exchanged; waves with a phase of nothing or of a quarter.
fn changed(misfit: &Misfit<'_>, term: &Term) -> Vec<Term> {
    let waves = |factor: &Factor| factor.shape == Shape::Wave;
    // Orders are many, and what repeats is found by its own scan.
    let single: Vec<&Factor> = misfit
        .grammar
        .factors
        .iter()
        .filter(|f| !waves(f))
        .collect();
    let mut all = Vec::new();
    for (f, factor) in term.factors.iter().enumerate() {
        let mut with = |other: Factor| {
            let mut factors = term.factors.clone();
            factors[f] = other;
            all.push(Term::of(factors));
        };
        if waves(factor) {
            with(Factor::plain(factor.quantity, Shape::Sine).with_inner(factor.inner));
            with(Factor::plain(factor.quantity, Shape::Cosine).with_inner(factor.inner));
        } else {
            let same = single
                .iter()
                .filter(|other| other.quantity == factor.quantity);
            same.filter(|other| **other != factor)
                .for_each(|other| with(**other));
            // As wide, and at the same place.
            let of_widths = Shape::OF_WIDTHS.iter().filter(|_| factor.shape.has_width());
            let others = of_widths.filter(|shape| **shape != factor.shape);
            others.for_each(|&shape| with(Factor { shape, ..*factor }));
        }
        let mut fewer = term.factors.clone();
        fewer.remove(f);
        all.push(Term::of(fewer));
    }
    for factor in single {
        let mut factors = term.factors.clone();
        factors.push(*factor);
        all.push(Term::of(factors));
    }
    all.retain(Term::is_sound);
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::fit::linear_model::LinearModel;
    use crate::diagnose::formula::grammar::Grammar;
    use crate::diagnose::formula::rows::FittedRows;
    use crate::diagnose::residuals::quantity::Quantity;
    use crate::robot::random::{generator, symmetric};
    use nalgebra::{DMatrix, DVector};

    /// What two columns take of a residual beside a column that is there, and beside what the model takes of either, against
    /// least squares over all of them at once.
    #[test]
    fn gains_are_those_of_least_squares() {
        const ROWS: usize = 12;
        let series = |k: usize| -> Vec<f64> {
            let of = |row: usize| (0.7 * (k + 1) as f64 * row as f64 + k as f64).sin();
            (0..ROWS).map(of).collect()
        };
        // The model has one column of norm one, and takes all of it.
        let own = DVector::from_vec(series(0)).normalize();
        let column = |k: usize| Column {
            by_model: DVector::zeros(1),
            taken: DVector::from_element(1, own.dot(&DVector::from_vec(series(k)))),
            series: series(k),
        };
        let candidate = |columns: &[usize]| Candidate {
            term: Term::of(vec![Factor::plain(Quantity::Position, Shape::Wave)]),
            columns: columns.iter().map(|&k| column(k)).collect(),
        };
        let left_by = |columns: &[usize]| -> DVector<f64> {
            let mut all = vec![own.clone()];
            all.extend(columns.iter().map(|&k| DVector::from_vec(series(k))));
            let matrix = DMatrix::from_columns(&all);
            let whole = DVector::from_vec(series(5));
            let solved = matrix.clone().svd(true, true).solve(&whole, 1e-12).unwrap();
            whole - matrix * solved
        };
        let residual = left_by(&[]);
        let basis = vec![unit_of(column(1), &[]).unwrap()];
        let shares: Vec<f64> = basis
            .iter()
            .map(|unit| dot(residual.as_slice(), &unit.series))
            .collect();
        let taken =
            |columns: &[usize]| left_by(&[1]).norm_squared() - left_by(columns).norm_squared();
        for (columns, expected) in [(&[2][..], taken(&[1, 2])), (&[2, 3], taken(&[1, 2, 3]))] {
            let found = gain(&candidate(columns), residual.as_slice(), &basis, &shares);
            assert!((found - expected).abs() < 1e-10, "{found} {expected}");
        }
        assert_eq!(
            gain(&candidate(&[1]), residual.as_slice(), &basis, &shares),
            0.0
        );
        let twice = candidate(&[2, 2]);
        assert_eq!(gain(&twice, residual.as_slice(), &basis, &shares), 0.0);
    }

    /// The best formula of a series that nothing else takes a part of.
    fn best_of(series: Vec<f64>, rows: &FittedRows, grammar: &Grammar) -> Solved {
        let linear = LinearModel::of_columns(vec![Vec::new()], vec![series], DMatrix::zeros(0, 0));
        let misfit = Misfit::of(&linear, 0, rows, grammar);
        formulas(&misfit, &|| false).swap_remove(0)
    }

    /// A law of two variables with little noise, of which one has a shape with a parameter: shape and parameter are found.
    #[test]
    fn shapes_of_speeds_are_found_with_their_parameters() {
        const ROWS: usize = 600;
        let rows = FittedRows::drawn(ROWS);
        let few = [Quantity::Position, Quantity::OtherVelocity(1)];
        let [q, v] = few.map(|quantity| rows.series(quantity));
        let grammar = Grammar::of(&rows, Some(&few));
        let mut rng = generator(19);
        let noise: Vec<f64> = (0..ROWS).map(|_| symmetric(&mut rng, 0.02)).collect();
        let found = |law: &dyn Fn(f64) -> f64| {
            let series = (0..ROWS).map(|k| q[k] * law(v[k]) + noise[k]);
            let best = best_of(series.collect(), &rows, &grammar);
            assert_eq!(best.terms.len(), 1, "{best:?}");
            let factors = best.terms[0].factors.iter();
            let of_speed = factors.filter(|factor| factor.quantity == few[1]);
            let factors: Vec<(Shape, f64)> = of_speed.map(|f| (f.shape, f.inner)).collect();
            factors[0]
        };
        let is = |found: (Shape, f64), shape: Shape, inner: f64| {
            assert_eq!(found.0, shape);
            assert!((found.1 / inner - 1.0).abs() < 0.05, "{found:?} {inner}");
        };
        let zone = |v: f64| (v - 0.2).max(0.0) + (v + 0.2).min(0.0);
        is(found(&zone), Shape::DeadZone, 0.2);
        let slopes = |v: f64| (v - 0.15).max(0.0) - 0.4 * (v - 0.15).min(0.0);
        is(found(&slopes), Shape::Slopes, 0.15);
        is(found(&|v| (13.0 * v + 0.7).sin()), Shape::Wave, 13.0);
        let resonance = |v: f64| 1.0 / (1.0 + (v / 0.15).powi(2));
        is(found(&resonance), Shape::Resonance, 0.15);
        is(found(&|v| v / 0.15 * resonance(v)), Shape::Breakdown, 0.15);
    }

    /// Waves of speeds and loads, with another variable, are found among terms of all variables.
    #[test]
    fn waves_of_speeds_are_found_among_all_variables() {
        const ROWS: usize = 600;
        let rows = FittedRows::drawn(ROWS);
        let grammar = Grammar::of(&rows, None);
        let mut rng = generator(23);
        let noise: Vec<f64> = (0..ROWS).map(|_| symmetric(&mut rng, 0.02)).collect();
        let waves = [
            Quantity::Velocity,
            Quantity::Load,
            Quantity::OtherVelocity(1),
        ];
        for of in waves {
            let (q, x) = (rows.series(Quantity::Position), rows.series(of));
            let order = 10.0 * std::f64::consts::PI / rows.extent(of).range();
            let series = (0..ROWS).map(|k| q[k] * (order * x[k] + 0.7).sin() + noise[k]);
            let best = best_of(series.collect(), &rows, &grammar);
            assert_eq!(best.variables().len(), 2, "{best:?}");
            let factors = best.terms.iter().flat_map(|term| &term.factors);
            let mut waves = factors.filter(|factor| factor.quantity == of);
            let wave = waves.next().unwrap();
            assert!(wave.shape.is_periodic() && (wave.inner / order - 1.0).abs() < 0.02);
        }
    }

    /// A peak takes the shape of another at the place and of the width that were found.
    #[test]
    fn shapes_of_one_width_are_exchanged_where_they_are() {
        let rows = FittedRows::drawn(400);
        let grammar = Grammar::of(&rows, Some(&[Quantity::Position]));
        let linear = LinearModel::of_columns(
            vec![Vec::new()],
            vec![rows.series(Quantity::Velocity).to_vec()],
            DMatrix::zeros(0, 0),
        );
        let misfit = Misfit::of(&linear, 0, &rows, &grammar);
        let plain = |shape: Shape| Factor::plain(Quantity::Position, shape).with_inner(0.123);
        let bump = Term::of(vec![plain(Shape::Bump).about(0.789)]);
        let others = changed(&misfit, &bump);
        for shape in [Shape::Saturation, Shape::Resonance, Shape::Breakdown] {
            assert!(others.contains(&Term::of(vec![plain(shape).about(0.789)])));
        }
    }

    #[test]
    fn the_best_formulas_differ_in_their_factors() {
        let solved = |shape: Shape, score: f64| Solved {
            terms: vec![Term::of(vec![Factor::plain(Quantity::Velocity, shape)])],
            sizes: vec![vec![1.0]],
            score,
        };
        let all = vec![
            solved(Shape::Power(1), -3.0),
            solved(Shape::Power(2), -5.0),
            solved(Shape::Power(2), -4.0),
            solved(Shape::Magnitude, -1.0),
        ];
        let scores = |most: usize| -> Vec<f64> {
            let kept = distinct(all.clone(), most).into_iter();
            kept.map(|one| one.score).collect()
        };
        assert_eq!(scores(9), [-5.0, -3.0, -1.0]);
        assert_eq!(scores(2), [-5.0, -3.0]);
    }
}
