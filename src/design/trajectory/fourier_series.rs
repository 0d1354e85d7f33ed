//! Finite Fourier series of the joints with a common fundamental ω = 2π / period:
//!
//! ```text
//! q(t) = q0 + Σ_l a_l/(lω) sin(lωt) − b_l/(lω) cos(lωt),   l = 1 .. H
//! q̇(t) = Σ_l a_l cos(lωt) + b_l sin(lωt)
//! ```
//!
//! with amplitudes a, b of velocities (Swevers et al. 1997, eq. 15; the same motion as `q0 + Σ a' sin + b' cos`
//! with `a' = a/(lω)`, `b' = −b/(lω)`). Everything is linear in the 1 + 2H coefficients of a joint.

use std::f64::consts::TAU;

/// Derivatives of position that a basis gives: position, velocity, acceleration, jerk.
pub const ORDERS: usize = 4;

/// The series of one joint, without its coefficients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Series {
    /// Terms, each with a sine and a cosine.
    pub harmonics: usize,
    /// s.
    pub period: f64,
}

impl Series {
    /// Coefficients of one joint: q0, a_1 .. a_H, b_1 .. b_H.
    pub fn width(&self) -> usize {
        1 + 2 * self.harmonics
    }

    /// The derivative of an order of every coefficient's function at time t, s.
    pub fn functions(&self, order: usize, t: f64) -> Vec<f64> {
        let (h, omega) = (self.harmonics, TAU / self.period);
        // The phase within the period: sine and cosine of large arguments lose digits.
        let phase = TAU * (t / self.period).rem_euclid(1.0);
        let mut out = vec![0.0; self.width()];
        if order == 0 {
            out[0] = 1.0;
        }
        for l in 1..=h {
            let (sine, cosine) = (l as f64 * phase).sin_cos();
            let w = l as f64 * omega;
            let (of_a, of_b) = match order {
                0 => (sine / w, -cosine / w),
                1 => (cosine, sine),
                2 => (-w * sine, w * cosine),
                _ => (-w * w * cosine, -w * w * sine),
            };
            out[l] = of_a;
            out[h + l] = of_b;
        }
        out
    }

    /// The factor that bounds a series between `samples` even instants of a period by its values there:
    /// a trigonometric polynomial of degree H is at most 1/cos(πH/samples) times its largest sample
    /// (Ehlich and Zeller 1964).
    ///
    /// # Panics
    /// With 2H instants or fewer there is no bound.
    pub fn between_samples(&self, samples: usize) -> f64 {
        assert!(samples > 2 * self.harmonics);
        1.0 / (0.5 * TAU * self.harmonics as f64 / samples as f64).cos()
    }
}

/// The functions of all coefficients at even instants of one period.
#[derive(Debug, Clone)]
pub struct Basis {
    /// Period and number of harmonics.
    pub series: Series,
    /// Instants, from 0 on, even over the period.
    pub samples: usize,
    /// `[order][coefficient][sample]`.
    functions: [Vec<Vec<f64>>; ORDERS],
}

impl Basis {
    /// Computes sines and cosines of all harmonics at the instants, with three derivatives.
    pub fn new(series: Series, samples: usize) -> Self {
        let step = series.period / samples as f64;
        let functions = std::array::from_fn(|order| {
            let mut columns = vec![Vec::with_capacity(samples); series.width()];
            for k in 0..samples {
                let row = series.functions(order, k as f64 * step);
                columns.iter_mut().zip(row).for_each(|(c, v)| c.push(v));
            }
            columns
        });
        Self {
            series,
            samples,
            functions,
        }
    }

    /// Seconds between instants.
    pub fn step(&self) -> f64 {
        self.series.period / self.samples as f64
    }

    /// A derivative of position at the instants for the coefficients of one joint.
    pub fn evaluate(&self, order: usize, coefficients: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (column, c) in self.functions[order].iter().zip(coefficients) {
            for (to, f) in out.iter_mut().zip(column) {
                *to += c * f;
            }
        }
    }

    /// Adds `Σ_k slope_k ∂(derivative at k)/∂coefficient`.
    pub fn pull(&self, order: usize, slope: &[f64], gradient: &mut [f64]) {
        for (column, to) in self.functions[order].iter().zip(gradient) {
            *to += column.iter().zip(slope).map(|(f, s)| f * s).sum::<f64>();
        }
    }

    /// The derivative of an order of the function of one coefficient, at every instant.
    pub fn function(&self, order: usize, coefficient: usize) -> &[f64] {
        &self.functions[order][coefficient]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_each_order_is_the_derivative_of_the_one_before() {
        let series = Series {
            harmonics: 3,
            period: 7.0,
        };
        let (t, h) = (1.3, 1e-5);
        for order in 1..ORDERS {
            let (before, after) = (
                series.functions(order - 1, t - h),
                series.functions(order - 1, t + h),
            );
            for (k, exact) in series.functions(order, t).into_iter().enumerate() {
                let difference = (after[k] - before[k]) / (2.0 * h);
                // Third derivative times h²/6, and rounding: (3ω)³ h² < 1e-8, 1e-16 · 20 / h < 1e-9.
                assert!((difference - exact).abs() < 1e-8, "order {order}, {k}");
            }
        }
    }

    #[test]
    fn invariant_no_series_exceeds_its_bound_between_samples() {
        let series = Series {
            harmonics: 4,
            period: 2.0,
        };
        let (coarse, fine) = (Basis::new(series, 24), Basis::new(series, 24 * 64));
        for seed in 0..20 {
            let mut rng = crate::robot::random::generator(seed);
            let c: Vec<f64> = (0..series.width())
                .map(|_| crate::robot::random::symmetric(&mut rng, 1.0))
                .collect();
            let peak = |basis: &Basis| {
                let mut out = vec![0.0; basis.samples];
                basis.evaluate(1, &c, &mut out);
                out.iter().fold(0.0_f64, |m, v| m.max(v.abs()))
            };
            assert!(peak(&fine) <= peak(&coarse) * series.between_samples(24));
        }
    }
}
