//! Constant rows `lower <= A x <= upper`, thousands of them, that a solver keeps at every iterate.
//!
//! A row touches one run of consecutive variables, and many rows share their numbers: the values of the
//! same functions of time for every joint. So the numbers stand once in a table, and a row is an offset
//! into it, a first variable and bounds.

use nalgebra::DVector;

/// One row: `Σ_k table[offset + k] · x[first + k]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearRow {
    /// Position of the row's numbers in the table.
    pub offset: usize,
    /// First variable.
    pub first: usize,
    /// Number of variables.
    pub width: usize,
    /// Minus infinity where there is none.
    pub lower: f64,
    /// Infinity where there is none.
    pub upper: f64,
}

impl LinearRow {
    /// Whether the row is an equation.
    pub fn is_equation(&self) -> bool {
        self.lower == self.upper
    }

    /// A difference that matters: the width of the row's interval, or one for an equation or an open one.
    pub fn scale(&self) -> f64 {
        let range = self.upper - self.lower;
        if range > 0.0 && range.is_finite() {
            range
        } else {
            1.0
        }
    }

    /// How far a value lies inside both bounds; negative outside.
    pub fn slack(&self, value: f64) -> f64 {
        (value - self.lower).min(self.upper - value)
    }
}

/// The set `lower <= A x <= upper`. Rows beside each other belong to instants beside each other.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LinearRows {
    /// The numbers of A that rows share; each row points at a run of them.
    pub table: Vec<f64>,
    /// The rows of A with their bounds.
    pub rows: Vec<LinearRow>,
    /// A point well inside, if one is known: what leaves the set is drawn back towards it.
    pub inside: Option<DVector<f64>>,
}

impl LinearRows {
    /// The numbers of a row.
    pub fn numbers(&self, row: usize) -> &[f64] {
        let LinearRow { offset, width, .. } = self.rows[row];
        &self.table[offset..offset + width]
    }

    /// A x.
    pub fn values(&self, x: &DVector<f64>) -> Vec<f64> {
        let x = x.as_slice();
        let value = |row: &LinearRow| -> f64 {
            let numbers = &self.table[row.offset..row.offset + row.width];
            let own = &x[row.first..row.first + row.width];
            numbers.iter().zip(own).map(|(a, b)| a * b).sum()
        };
        self.rows.iter().map(value).collect()
    }

    /// Largest violation as a share of the row's scale; zero inside.
    pub fn violation(&self, x: &DVector<f64>) -> f64 {
        let values = self.values(x);
        let each = self.rows.iter().zip(values);
        each.map(|(row, value)| -row.slack(value) / row.scale())
            .fold(0.0, f64::max)
    }

    /// The point x + d where it is inside; else drawn back towards the point inside, or as far as the step
    /// stays inside.
    pub fn admissible(&self, x: &DVector<f64>, d: &DVector<f64>) -> DVector<f64> {
        let target = x + d;
        let Some(inside) = &self.inside else {
            return x + d * self.longest_step(x, d);
        };
        let from = &target - inside;
        let longest_step = self.longest_step(inside, &from);
        if longest_step < 1.0 {
            inside + from * longest_step
        } else {
            target
        }
    }

    /// The largest step length α in [0, 1] with `x + α d` inside, for an x that is inside; equations are
    /// not looked at.
    pub fn longest_step(&self, x: &DVector<f64>, d: &DVector<f64>) -> f64 {
        let (at, along) = (self.values(x), self.values(d));
        let mut longest_step = 1.0_f64;
        for ((row, value), slope) in self.rows.iter().zip(at).zip(along) {
            if row.is_equation() || slope == 0.0 {
                continue;
            }
            let bound = if slope > 0.0 { row.upper } else { row.lower };
            longest_step = longest_step.min(((bound - value) / slope).max(0.0));
        }
        longest_step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reach_of_a_step_ends_on_the_first_bound_that_it_meets() {
        let row = |first, lower, upper| LinearRow {
            offset: 0,
            first,
            width: 2,
            lower,
            upper,
        };
        let rows = LinearRows {
            table: vec![1.0, 2.0],
            rows: vec![row(0, -1.0, 4.0), row(1, f64::NEG_INFINITY, 9.0)],
            inside: None,
        };
        let x = DVector::from_vec(vec![1.0, 0.0, 1.0]);
        let d = DVector::from_vec(vec![2.0, 2.0, 2.0]);
        assert_eq!(rows.values(&x), vec![1.0, 2.0]);
        assert_eq!(rows.longest_step(&x, &d), 0.5);
        assert_eq!(rows.admissible(&x, &d), &x + &d * 0.5);
        assert_eq!(rows.violation(&(&x + &d)), 3.0 / 5.0);
    }
}
