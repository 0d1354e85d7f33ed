//! Bounds lower <= x <= upper: projection, and which of them hold a solution.

use nalgebra::DVector;

use crate::problem::form::{Form, Variable};

/// The side on which a variable is bounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// x >= lower.
    Lower,
    /// x <= upper.
    Upper,
}

/// A variable that a solution holds at one of its bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct ActiveBound {
    /// Its name in the form of the problem.
    pub variable: String,
    /// SI unit of the variable.
    pub unit: String,
    /// The bound, in the unit.
    pub value: f64,
    /// Which of its bounds holds it.
    pub side: Side,
}

impl std::fmt::Display for ActiveBound {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let side = match self.side {
            Side::Lower => "lower",
            Side::Upper => "upper",
        };
        write!(
            f,
            "{} is at its {side} bound {} {}",
            self.variable, self.value, self.unit
        )
    }
}

/// The nearest point within the bounds, entry by entry.
pub fn project(form: &Form, x: &DVector<f64>) -> DVector<f64> {
    DVector::from_iterator(
        x.len(),
        form.variables
            .iter()
            .zip(x.iter())
            .map(|(v, x)| x.max(v.lower).min(v.upper)),
    )
}

/// The bound on which a value lies exactly; a projection puts it there.
pub fn side_of(variable: &Variable, value: f64) -> Option<Side> {
    if value <= variable.lower {
        Some(Side::Lower)
    } else if value >= variable.upper {
        Some(Side::Upper)
    } else {
        None
    }
}

/// Whether the bound stops descent: the value lies on it and -gradient points outwards.
pub fn is_held(variable: &Variable, value: f64, gradient: f64) -> bool {
    match side_of(variable, value) {
        Some(_) if variable.lower == variable.upper => true,
        Some(Side::Lower) => gradient >= 0.0,
        Some(Side::Upper) => gradient <= 0.0,
        None => false,
    }
}

/// The variables that lie on a bound, in the order of the form.
pub fn active(form: &Form, x: &DVector<f64>) -> Vec<ActiveBound> {
    let of = |variable: &Variable, value: f64| {
        side_of(variable, value).map(|side| ActiveBound {
            variable: variable.name.clone(),
            unit: variable.unit.clone(),
            value: match side {
                Side::Lower => variable.lower,
                Side::Upper => variable.upper,
            },
            side,
        })
    };
    form.variables
        .iter()
        .zip(x.iter())
        .filter_map(|(v, x)| of(v, *x))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::examples;

    #[test]
    fn reports_the_bound_that_a_projection_reaches_with_name_and_unit() {
        let mut form = examples::rosenbrock().form;
        form.variables[0] = Variable::free("Fc", "N·m").within(0.0, 2.0);
        let x = project(&form, &DVector::from_vec(vec![-3.0, 7.0]));
        assert_eq!(x.as_slice(), [0.0, 7.0]);
        let active = active(&form, &x);
        assert_eq!(active.len(), 1);
        assert_eq!(active[0].to_string(), "Fc is at its lower bound 0 N·m");
    }

    #[test]
    fn a_bound_holds_only_against_descent_that_leaves() {
        let variable = Variable::free("a", "").within(0.0, 1.0);
        assert!(is_held(&variable, 0.0, 1.0));
        assert!(!is_held(&variable, 0.0, -1.0));
        assert!(is_held(&variable, 1.0, -1.0));
        assert!(!is_held(&variable, 0.5, 1.0));
    }
}
