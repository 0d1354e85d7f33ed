//! The torque of a motor as a cubic polynomial of its current, and back.

use crate::chain::effect::expression::{Expression, Function, Variable};
use crate::chain::effect::law::signum;
use crate::stats::range::within;

/// Number of coefficients.
pub const COEFFICIENTS: usize = 4;

/// Slope, as a share of c1, below which the polynomial is not followed: beyond it a current says nothing
/// about the torque any more.
pub const LEAST_SLOPE: f64 = 0.1;

/// Newton steps after which the inverse of a cubic has converged from any start on its rising branch.
pub(super) const STEPS: usize = 50;

/// Current of a torque, and its derivatives with respect to the torque and the coefficients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inverse {
    /// i, A.
    pub current: f64,
    /// ∂i/∂τ, A/(N·m).
    pub by_torque: f64,
    /// ∂i/∂c_k, k = 0 to 3.
    pub by_coefficient: [f64; COEFFICIENTS],
}

/// Torque of a current.
pub fn torque(c: [f64; COEFFICIENTS], current: f64) -> f64 {
    let (value, _, _) = rising(c, current.abs());
    signum(current) * value
}

/// Current of a torque.
pub fn current(c: [f64; COEFFICIENTS], torque: f64) -> Inverse {
    let size = torque.abs();
    let nothing = Inverse {
        current: 0.0,
        by_torque: 0.0,
        by_coefficient: [0.0; COEFFICIENTS],
    };
    if size <= c[0] || size == 0.0 {
        return nothing;
    }
    // Bisection steps where Newton would leave the bracket: the branch rises, so it is safe.
    let (mut low, mut high) = (0.0, (size - c[0].min(0.0)) / (LEAST_SLOPE * c[1]));
    if !(high >= low && high.is_finite()) {
        // No current gives a torque that is not a number; what is predicted is none either.
        return Inverse {
            current: f64::NAN,
            ..nothing
        };
    }
    let mut x = within((size - c[0]) / c[1], [low, high]);
    for _ in 0..STEPS {
        let (value, slope, _) = rising(c, x);
        let error = value - size;
        if error > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let newton = x - error / slope;
        let next = if (low..=high).contains(&newton) {
            newton
        } else {
            0.5 * (low + high)
        };
        let done = (next - x).abs() <= 4.0 * f64::EPSILON * next;
        x = next;
        if done {
            break;
        }
    }
    let (_, slope, powers) = rising(c, x);
    let sign = signum(torque);
    Inverse {
        current: sign * x,
        by_torque: 1.0 / slope,
        by_coefficient: powers.map(|p| -sign * p / slope),
    }
}

/// The polynomial for x >= 0 as it is followed, its slope, and its derivatives by the coefficients.
pub(super) fn rising(c: [f64; COEFFICIENTS], x: f64) -> (f64, f64, [f64; COEFFICIENTS]) {
    let slope = |x: f64| c[1] + x * (2.0 * c[2] + 3.0 * c[3] * x);
    let value = |x: f64| c[0] + x * (c[1] + x * (c[2] + x * c[3]));
    let least = LEAST_SLOPE * c[1];
    let end = last_rising(c, least);
    let beyond = (x - end).max(0.0);
    let inside = x - beyond;
    if beyond == 0.0 {
        return (value(x), slope(x), [1.0, x, x * x, x * x * x]);
    }
    // At the end the slope is `least`, so the change of the end itself does not enter.
    let powers = [
        1.0,
        inside + LEAST_SLOPE * beyond,
        inside.powi(2),
        inside.powi(3),
    ];
    (value(inside) + least * beyond, least, powers)
}

/// The first x > 0 at which the slope of the polynomial falls to `least`.
pub(super) fn last_rising(c: [f64; COEFFICIENTS], least: f64) -> f64 {
    // 3 c3 x² + 2 c2 x + c1 − least = 0, with c1 > least.
    let (a, b, d) = (3.0 * c[3], 2.0 * c[2], c[1] - least);
    let discriminant = b * b - 4.0 * a * d;
    if discriminant < 0.0 {
        return f64::INFINITY;
    }
    // Stable form: roots 2d / (−b ± √), the positive ones are candidates.
    let root = discriminant.sqrt();
    [2.0 * d / (-b + root), 2.0 * d / (-b - root)]
        .into_iter()
        .filter(|x| x.is_finite() && *x > 0.0)
        .fold(f64::INFINITY, f64::min)
}

/// The rising branch as a formula of the size of the current.
#[derive(Debug, Clone)]
pub struct Branch {
    /// c0 + c1·x + c2·x² + c3·x³ up to the end, and its tangent from there on, N·m (N).
    pub torque: Expression,
    /// Derivative of that torque by the size of the current, N·m/A.
    pub slope: Expression,
}

/// `rising` for given coefficients, and the current at which the polynomial is left, infinite where it never is, A.
pub fn branch(c: [f64; COEFFICIENTS]) -> (Branch, f64) {
    let end = last_rising(c, LEAST_SLOPE * c[1]);
    let coefficients = c.map(Expression::Number);
    let branch = match end.is_finite() {
        true => branch_up_to(&coefficients, end.into()),
        false => polynomial(&coefficients, &Variable::Current.into()),
    };
    (branch, end)
}

/// `rising` for coefficients and an end, A, that a program reads.
pub fn branch_up_to(c: &[Expression; COEFFICIENTS], end: Expression) -> Branch {
    let current = || Expression::from(Variable::Current);
    let inside = current().call_with(Function::Smaller, end.clone());
    let Branch { torque, slope } = polynomial(c, &inside);
    let beyond = (current() - end).call_with(Function::Larger, 0.0);
    Branch {
        torque: torque + beyond * (c[1].clone() * LEAST_SLOPE),
        slope,
    }
}

fn polynomial(c: &[Expression; COEFFICIENTS], x: &Expression) -> Branch {
    let x = || x.clone();
    let [c0, c1, c2, c3] = [0, 1, 2, 3].map(|k| c[k].clone());
    Branch {
        torque: ((x() * c3.clone() + c2.clone()) * x() + c1.clone()) * x() + c0,
        slope: (x() * (c3 * 3.0) + c2 * 2.0) * x() + c1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SATURATING: [f64; COEFFICIENTS] = [0.2, 12.8, 0.05, -0.019];

    #[test]
    fn invariant_current_of_a_torque_gives_the_torque_back() {
        for k in -400..400 {
            let wanted = f64::from(k) * 0.71;
            let found = current(SATURATING, wanted).current;
            if wanted.abs() <= SATURATING[0] {
                assert_eq!(found, 0.0);
            } else {
                let back = torque(SATURATING, found);
                assert!(
                    (back - wanted).abs() < 1e-11 * wanted.abs().max(1.0),
                    "{wanted}"
                );
            }
        }
    }

    #[test]
    fn matches_differences_in_torque_and_coefficients() {
        let h = 1e-6;
        for wanted in [-300.0, -80.0, -3.0, 0.9, 17.0, 120.0, 500.0] {
            let here = current(SATURATING, wanted);
            let slope = (current(SATURATING, wanted + h).current
                - current(SATURATING, wanted - h).current)
                / (2.0 * h);
            assert!((slope - here.by_torque).abs() < 1e-6 * slope.abs().max(1e-2));
            for k in 0..COEFFICIENTS {
                let step = h * [1.0, 1.0, 1e-2, 1e-3][k];
                let at = |d: f64| {
                    let mut c = SATURATING;
                    c[k] += d;
                    current(c, wanted).current
                };
                let slope = (at(step) - at(-step)) / (2.0 * step);
                let error = (slope - here.by_coefficient[k]).abs();
                assert!(error < 1e-5 * slope.abs().max(1.0), "{wanted} {k} {slope}");
            }
        }
    }
}
