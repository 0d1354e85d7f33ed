//! Piecewise linear functions of one covariate, and bilinear ones of two, as sums of hat functions over knots at quantiles.
//!
//! ```text
//! f(x) = Σ_k a_k h_k(x),   f(x) + g(x) d,   f(x, y) = Σ_jk a_jk h_j(x) h_k(y)
//! ```
//!
//! with the direction d = ±1 of the motion where the covariate is looked at by direction; B-splines of the first degree and their
//! products, with a penalty on second differences along either axis (Eilers and Marx 2003).

use crate::diagnose::residuals::covariates::Covariates;
use crate::diagnose::residuals::quantity::Quantity;
use crate::stats::range::within;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Knots of a function of one variable.
const KNOTS: usize = 12;

/// Knots of either variable of a function of two.
const KNOTS_OF_TWO: usize = 8;

/// The covariates that a smooth function has, by number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arguments {
    /// Of one, for either direction where that is looked at by direction.
    One(usize),
    /// Of two together.
    Two([usize; 2]),
}

/// Hat functions of a smooth function.
#[derive(Debug, Clone)]
pub struct Hats {
    /// What they are functions of.
    pub of: Arguments,
    knots: Vec<Vec<f64>>,
    by_direction: bool,
}

/// Hat functions along rows, of which few are not zero at any.
#[derive(Debug, Clone)]
pub struct HatRows {
    /// Number of hat functions.
    pub width: usize,
    per_row: usize,
    number: Vec<usize>,
    value: Vec<f64>,
}

/// A hat function and its value.
type Entry = (usize, f64);

impl Hats {
    /// Over the values of covariates.
    pub fn of(arguments: Arguments, covariates: &Covariates) -> Self {
        let values = |k: usize| covariates.variables[k].values.as_slice();
        let (knots, by_direction) = match arguments {
            Arguments::One(k) => (
                vec![knots(values(k), KNOTS)],
                covariates.variables[k].by_direction,
            ),
            Arguments::Two(both) => {
                let of = both.map(|k| knots(values(k), KNOTS_OF_TWO));
                (of.to_vec(), false)
            }
        };
        Self {
            of: arguments,
            knots,
            by_direction,
        }
    }

    /// What it is a function of, in words.
    pub fn name(&self, covariates: &Covariates) -> String {
        let name = |k: usize| covariates.variables[k].name.as_str();
        match self.of {
            Arguments::One(k) => name(k).to_string(),
            Arguments::Two([a, b]) => format!("{} with {}", name(a), name(b)),
        }
    }

    /// Variables of the motion that it has, with the speed of the joint where either direction is looked at.
    pub fn made_of(&self, covariates: &Covariates) -> Vec<Quantity> {
        let numbers = match self.of {
            Arguments::One(k) => vec![k],
            Arguments::Two(both) => both.to_vec(),
        };
        let made_of = |k: usize| covariates.variables[k].made_of.iter().copied();
        let mut all: Vec<Quantity> = numbers.into_iter().flat_map(made_of).collect();
        if self.by_direction && !all.is_empty() {
            all.push(Quantity::Velocity);
        }
        all
    }

    /// Whether no variable is of another joint.
    pub fn is_own(&self, covariates: &Covariates) -> bool {
        let is_own = |k: usize| covariates.variables[k].other.is_none();
        match self.of {
            Arguments::One(k) => is_own(k),
            Arguments::Two(both) => both.into_iter().all(is_own),
        }
    }

    fn width(&self) -> usize {
        let product: usize = self.knots.iter().map(Vec::len).product();
        product * (1 + usize::from(self.by_direction))
    }

    /// At all rows; outside the knots the outermost hats are 1.
    pub fn along(&self, covariates: &Covariates) -> HatRows {
        let rows = covariates.direction.len();
        let per_row = match self.of {
            Arguments::One(_) if !self.by_direction => 2,
            _ => 4,
        };
        let mut along = HatRows {
            width: self.width(),
            per_row,
            number: Vec::with_capacity(rows * per_row),
            value: Vec::with_capacity(rows * per_row),
        };
        let mut add = |number: usize, value: f64| {
            along.number.push(number);
            along.value.push(value);
        };
        for row in 0..rows {
            match self.of {
                Arguments::One(k) => {
                    let hats = hats(&self.knots[0], covariates.variables[k].values[row]);
                    for (at, value) in hats {
                        add(at, value);
                        if self.by_direction {
                            add(self.knots[0].len() + at, value * covariates.direction[row]);
                        }
                    }
                }
                Arguments::Two(both) => {
                    let of = |axis: usize| {
                        let values = &covariates.variables[both[axis]].values;
                        hats(&self.knots[axis], values[row])
                    };
                    let second = of(1);
                    for (i, a) in of(0) {
                        for (j, b) in second {
                            add(i * self.knots[1].len() + j, a * b);
                        }
                    }
                }
            }
        }
        along
    }

    /// Sum of the squares of second differences along either axis, as a quadratic form of the factors of hats.
    pub fn roughness(&self) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(self.width(), self.width());
        let mut add = |at: [usize; 3]| {
            const DIFFERENCES: [f64; 3] = [1.0, -2.0, 1.0];
            for (i, a) in at.iter().zip(DIFFERENCES) {
                for (j, b) in at.iter().zip(DIFFERENCES) {
                    sum[(*i, *j)] += a * b;
                }
            }
        };
        let first = self.knots[0].len();
        let second = match self.of {
            // Either direction has a function of its own, the second behind the first.
            Arguments::One(_) => 1 + usize::from(self.by_direction),
            Arguments::Two(_) => self.knots[1].len(),
        };
        let (along, across) = match self.of {
            Arguments::One(_) => (1, first),
            Arguments::Two(_) => (second, 1),
        };
        for i in 0..first {
            for j in 0..second {
                let at = i * along + j * across;
                if i + 2 < first {
                    add([at, at + along, at + 2 * along]);
                }
                if matches!(self.of, Arguments::Two(_)) && j + 2 < second {
                    add([at, at + across, at + 2 * across]);
                }
            }
        }
        sum
    }
}

impl HatRows {
    fn row(&self, row: usize) -> impl Iterator<Item = Entry> + '_ {
        let place = row * self.per_row..(row + 1) * self.per_row;
        let numbers = self.number[place.clone()].iter().copied();
        numbers.zip(self.value[place].iter().copied())
    }

    /// Sums over some rows of the products of all hats with those of another function.
    pub fn cross(&self, other: &Self, rows: Range<usize>) -> DMatrix<f64> {
        let mut sums = DMatrix::zeros(self.width, other.width);
        for row in rows {
            for (i, a) in self.row(row) {
                for (j, b) in other.row(row) {
                    sums[(i, j)] += a * b;
                }
            }
        }
        sums
    }

    /// Sums over some rows of the products of all hats with a series.
    pub fn against(&self, series: &[f64], rows: Range<usize>) -> DVector<f64> {
        let mut sums = DVector::zeros(self.width);
        for row in rows {
            for (i, a) in self.row(row) {
                sums[i] += a * series[row];
            }
        }
        sums
    }

    /// The same with several series, those that are none being zero.
    pub fn against_columns(
        &self,
        columns: &[Option<Vec<f64>>],
        rows: Range<usize>,
    ) -> DMatrix<f64> {
        let mut sums = DMatrix::zeros(self.width, columns.len());
        for (k, column) in columns.iter().enumerate() {
            if let Some(column) = column {
                sums.set_column(k, &self.against(column, rows.clone()));
            }
        }
        sums
    }

    /// Adds the function with some factors of its hats to a series.
    pub fn add(&self, factors: &[f64], series: &mut [f64]) {
        for (row, x) in series.iter_mut().enumerate() {
            *x += self.row(row).map(|(i, a)| a * factors[i]).sum::<f64>();
        }
    }
}

fn knots(values: &[f64], count: usize) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1);
    let mut knots: Vec<f64> = (0..count)
        .map(|k| sorted.get(k * last / (count - 1)).copied().unwrap_or(0.0))
        .collect();
    knots.dedup();
    knots
}

/// The hats that are not zero at x: those of the knots about it.
fn hats(knots: &[f64], x: f64) -> [Entry; 2] {
    let last = knots.len() - 1;
    let x = within(x, [knots[0], knots[last]]);
    let above = knots.partition_point(|knot| *knot <= x).min(last);
    let below = above.saturating_sub(1);
    let share = match above > below {
        true => (x - knots[below]) / (knots[above] - knots[below]),
        false => 0.0,
    };
    [(below, 1.0 - share), (above, share)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::residuals::covariates::Covariate;

    /// Hats over knots add up to one everywhere, and their combination with the knots is the identity between these.
    #[test]
    fn invariant_hats_interpolate_between_knots() {
        let values = [3.0, 0.0, 1.0, 7.0, 1.0, 0.5, 2.0, 4.0, 5.0, 6.0, 1.0, 1.0];
        let knots = knots(&values, KNOTS);
        assert_eq!(knots, [0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        for x in [-3.0, 0.0, 0.2, 0.5, 1.7, 6.99, 7.0, 12.0] {
            let hats = hats(&knots, x);
            assert!((hats.iter().map(|(_, a)| a).sum::<f64>() - 1.0).abs() < 1e-14);
            let value: f64 = hats.iter().map(|(k, a)| a * knots[*k]).sum();
            assert!((value - within(x, [0.0, 7.0])).abs() < 1e-14, "{x}");
            assert!(hats.iter().all(|(_, a)| (0.0..=1.0).contains(a)), "{x}");
        }
        assert_eq!(super::hats(&[2.0], 5.0), [(0, 1.0), (0, 0.0)]);
    }

    /// x and y over a grid.
    fn grid() -> Covariates {
        const SIDE: usize = 36;
        let variable = |name: &str, of: &dyn Fn(usize) -> usize| Covariate {
            name: name.to_string(),
            unit: "",
            values: (0..SIDE * SIDE).map(|k| of(k) as f64).collect(),
            by_direction: name == "x",
            other: None,
            made_of: Vec::new(),
            is_state: true,
        };
        Covariates {
            variables: vec![variable("x", &|k| k / SIDE), variable("y", &|k| k % SIDE)],
            direction: (0..SIDE * SIDE)
                .map(|k| if k % 3 == 0 { 1.0 } else { -1.0 })
                .collect(),
        }
    }

    /// A bilinear function of two variables has its values at the knots as factors, and no roughness.
    #[test]
    fn bilinear_functions_are_hats_without_roughness() {
        let covariates = grid();
        let hats = Hats::of(Arguments::Two([0, 1]), &covariates);
        let of = |x: f64, y: f64| 2.0 - 0.3 * x + (0.1 * x + 0.7) * y;
        let at_knots = hats.knots[0].iter().flat_map(|x| {
            let second = hats.knots[1].iter();
            second.map(move |y| of(*x, *y))
        });
        let factors: Vec<f64> = at_knots.collect();
        let rows = hats.along(&covariates);
        let mut series = vec![0.0; covariates.direction.len()];
        rows.add(&factors, &mut series);
        let [x, y] = [0, 1].map(|k| &covariates.variables[k].values);
        for (k, found) in series.iter().enumerate() {
            assert!((found - of(x[k], y[k])).abs() < 1e-12);
        }
        let factors = DVector::from_vec(factors);
        // Knots are equally far apart here.
        assert!((hats.roughness() * &factors).amax() < 1e-12);
        let bent = factors.map(|f| f * f);
        assert!(bent.dot(&(hats.roughness() * &bent)) > 1.0);
        assert_eq!(hats.name(&covariates), "x with y");
    }

    /// Products of hats and series, against all rows written out.
    #[test]
    fn products_are_sums_over_rows() {
        let covariates = grid();
        let dense = |hats: &Hats| -> DMatrix<f64> {
            let rows = hats.along(&covariates);
            let mut all = DMatrix::zeros(covariates.direction.len(), rows.width);
            for i in 0..rows.width {
                let mut factors = vec![0.0; rows.width];
                factors[i] = 1.0;
                let mut series = vec![0.0; all.nrows()];
                rows.add(&factors, &mut series);
                all.set_column(i, &DVector::from_vec(series));
            }
            all
        };
        let one = Hats::of(Arguments::One(0), &covariates);
        let two = Hats::of(Arguments::Two([1, 0]), &covariates);
        let (a, b) = (one.along(&covariates), two.along(&covariates));
        assert_eq!((a.width, b.width), (2 * KNOTS, KNOTS_OF_TWO * KNOTS_OF_TWO));
        let expected = dense(&one).tr_mul(&dense(&two));
        assert!((a.cross(&b, 0..1296) - &expected).amax() < 1e-10);
        let series: Vec<f64> = (0..1296).map(|k| (0.3 * f64::from(k)).sin()).collect();
        let expected = dense(&two).tr_mul(&DVector::from_vec(series.clone()));
        assert!((b.against(&series, 0..1296) - expected).amax() < 1e-10);
    }
}
