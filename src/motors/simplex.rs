//! The first stage at one speed by the simplex of Nelder and Mead, over k_ct and the friction torque:
//! `min Σ (i − (g + τ_f) / k_ct)²`. It has the same least as the linear solution, and shows that.

use argmin::core::{CostFunction, Error, Executor, State};
use argmin::solver::neldermead::NelderMead;

use crate::motors::constants::Sums;

/// Steps of the simplex; a few hundred reach rounding.
const MOST_STEPS: u64 = 2000;

/// Standard deviation of the cost over the simplex at which it ends, A².
const TOLERANCE: f64 = 1e-16;

struct Misfit<'a>(&'a Sums);

impl CostFunction for Misfit<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    /// Mean squared error, from sums about the means, which do not cancel.
    fn cost(&self, x: &Vec<f64>) -> Result<f64, Error> {
        let sums = self.0;
        let a = 1.0 / x[0];
        let mean = sums.current - a * (sums.torque + x[1]);
        let spread =
            sums.current_current - 2.0 * a * sums.torque_current + a * a * sums.torque_torque;
        Ok(mean * mean + spread / sums.count)
    }
}

/// k_ct, N·m/A, and friction torque, N·m, from a start with this torque constant; None if the simplex fails.
pub fn nelder_mead(sums: &Sums, start: f64) -> Option<[f64; 2]> {
    let friction = start * sums.current - sums.torque;
    let step = 0.2 * start;
    let corners = vec![
        vec![start, friction],
        vec![start + step, friction],
        vec![start, friction + step],
    ];
    let solver = NelderMead::new(corners).with_sd_tolerance(TOLERANCE).ok()?;
    let executor = Executor::new(Misfit(sums), solver);
    let result = executor
        .configure(|state| state.max_iters(MOST_STEPS))
        .run()
        .ok()?;
    match result.state().get_best_param()?[..] {
        [constant, friction] => Some([constant, friction]),
        _ => None,
    }
}
