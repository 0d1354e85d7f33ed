//! Coloured noise as an autoregression: y_t = Σ a_k y_(t-k) + e_t, e_t white with variance sigma².
//!
//! Fitted by Burg's method, which keeps the model stable, over several segments together; the order by AIC
//! or BIC. Sources: Burg (1975), Levinson (1947), Durbin (1960); Brockwell and Davis (1991), chapter 5.

/// A stable autoregression of a series with mean zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Autoregression {
    /// a_1, a_2, ...; empty for white noise.
    pub coefficients: Vec<f64>,
    /// sigma², in the unit of the series squared.
    pub innovation_variance: f64,
}

/// What an additional coefficient has to pay for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OrderCriterion {
    /// Akaike: n log sigma² + 2 order; predicts best.
    Aic,
    /// Schwarz: n log sigma² + order log n; finds the true order in the limit.
    Bic,
}

/// An innovation variance below this share of the variance of the series is rounding.
const LEAST_SHARE: f64 = 1e-28;

/// Most coefficients of a residual: `10 log₁₀ N` of usual recordings (Schwert 1989 names orders of this size).
pub const MOST_COEFFICIENTS: usize = 32;

/// Samples after which nothing is remembered: ten seconds at usual rates.
const LONGEST_MEMORY: usize = 2000;

/// Samples per coefficient at least.
const SAMPLES_PER_COEFFICIENT: usize = 20;

/// Largest order that so many samples of a residual determine.
pub fn largest_order(samples: usize) -> usize {
    MOST_COEFFICIENTS.min(samples / SAMPLES_PER_COEFFICIENT)
}

impl Autoregression {
    /// White noise of a variance.
    pub fn white(variance: f64) -> Self {
        Self {
            coefficients: Vec::new(),
            innovation_variance: variance,
        }
    }

    /// Burg's estimate over segments that do not touch, up to an order; `None` without a finite sample.
    pub fn fit(segments: &[&[f64]], max_order: usize, criterion: OrderCriterion) -> Option<Self> {
        let count: usize = segments.iter().map(|s| s.len()).sum();
        let power: f64 = segments.iter().flat_map(|s| s.iter()).map(|v| v * v).sum();
        if count == 0 || !power.is_finite() {
            return None;
        }
        let n = count as f64;
        let price = match criterion {
            OrderCriterion::Aic => 2.0,
            OrderCriterion::Bic => n.ln(),
        };
        let mut current = Self::white(power / n);
        let (mut best, mut best_score) = (current.clone(), n * (power / n).ln());
        let mut errors: Vec<Errors> = segments.iter().map(|s| Errors::new(s)).collect();
        for order in 1..=max_order {
            let Some(reflection) = common_reflection(&errors) else {
                break;
            };
            current.step_up(reflection);
            if current.innovation_variance <= LEAST_SHARE * power / n {
                break;
            }
            errors.iter_mut().for_each(|e| e.advance(reflection));
            let score = n * current.innovation_variance.ln() + price * order as f64;
            if score < best_score {
                (best, best_score) = (current.clone(), score);
            }
        }
        Some(best)
    }

    /// The model of these autocovariances r_0, r_1, ... with the order, below r.len(), by the criterion of Schwarz for so
    /// many samples; a lower one where they stop being those of a stationary series. `None` without r_0 > 0.
    pub fn of_autocovariance(covariance: &[f64], samples: usize) -> Option<Self> {
        let n = samples as f64;
        let score =
            |m: &Self| n * m.innovation_variance.ln() + m.coefficients.len() as f64 * n.ln();
        let models = Self::of_rising_order(covariance);
        models.min_by(|a, b| score(a).total_cmp(&score(b)))
    }

    /// The model of order r.len() - 1 with these autocovariances r_0, r_1, ... (Levinson and Durbin).
    ///
    /// `None` if they are not those of a stationary series with r_0 > 0.
    pub fn from_autocovariance(covariance: &[f64]) -> Option<Self> {
        let highest = Self::of_rising_order(covariance).last()?;
        (highest.coefficients.len() + 1 == covariance.len()).then_some(highest)
    }

    /// The models of order 0, 1, ... with these autocovariances r_0, r_1, ..., as long as they are those of a stationary series.
    fn of_rising_order(covariance: &[f64]) -> impl Iterator<Item = Self> {
        let first = covariance.first().copied();
        let first = first.filter(|variance| *variance > 0.0 && variance.is_finite());
        std::iter::successors(first.map(Self::white), |model| {
            let order = model.coefficients.len();
            let next = covariance.get(order + 1)?;
            let past = covariance[1..=order].iter().rev();
            let predicted: f64 = model
                .coefficients
                .iter()
                .zip(past)
                .map(|(a, r)| a * r)
                .sum();
            let reflection = (next - predicted) / model.innovation_variance;
            let mut higher = model.clone();
            higher.step_up(reflection);
            (reflection.abs() < 1.0).then_some(higher)
        })
    }

    /// The model with one more coefficient, given its partial autocorrelation.
    fn step_up(&mut self, reflection: f64) {
        let reversed: Vec<f64> = self.coefficients.iter().rev().copied().collect();
        for (a, b) in self.coefficients.iter_mut().zip(reversed) {
            *a -= reflection * b;
        }
        self.coefficients.push(reflection);
        self.innovation_variance *= 1.0 - reflection * reflection;
    }

    /// The best predictor that uses one sample less.
    fn step_down(&self) -> Self {
        let mut lower = self.clone();
        if let Some(reflection) = lower.coefficients.pop() {
            let scale = 1.0 - reflection * reflection;
            let own = lower.coefficients.clone();
            for (a, b) in lower.coefficients.iter_mut().zip(own.iter().rev()) {
                *a = (*a + reflection * b) / scale;
            }
            lower.innovation_variance /= scale;
        }
        lower
    }

    /// Variance of the series, in the unit of the series squared.
    pub fn variance(&self) -> f64 {
        let mut model = self.clone();
        while !model.coefficients.is_empty() {
            model = model.step_down();
        }
        model.innovation_variance
    }

    /// Variance of the mean of n samples times n, for large n: sigma² / (1 - Σ a_k)².
    pub fn long_run_variance(&self) -> f64 {
        let gain = 1.0 - self.coefficients.iter().sum::<f64>();
        self.innovation_variance / (gain * gain)
    }

    /// The series as white noise of variance one, exact from the first sample on: the first samples are
    /// predicted from the fewer samples before them. Linear, so it may be applied to each column of a regressor.
    pub fn whiten(&self, series: &[f64]) -> Vec<f64> {
        let order = self.coefficients.len();
        let mut predictors = vec![self.clone()];
        for _ in 0..order {
            let lower = predictors[predictors.len() - 1].step_down();
            predictors.push(lower);
        }
        (0..series.len())
            .map(|t| {
                let predictor = &predictors[order - order.min(t)];
                let past = series[..t].iter().rev();
                let predicted: f64 = predictor
                    .coefficients
                    .iter()
                    .zip(past)
                    .map(|(a, y)| a * y)
                    .sum();
                (series[t] - predicted) / predictor.innovation_variance.sqrt()
            })
            .collect()
    }

    /// `e_t = y_t − Σ a_k y_(t−k)` for all samples that have as many before them as there are coefficients.
    pub fn innovations(&self, series: &[f64]) -> Vec<f64> {
        let order = self.coefficients.len();
        let of = |past: &[f64]| {
            let terms = self.coefficients.iter().zip(past[..order].iter().rev());
            past[order] - terms.map(|(a, y)| a * y).sum::<f64>()
        };
        series.windows(order + 1).map(of).collect()
    }

    /// The adjoint of [`Self::innovations`]: weights of samples that give the same sum as weights of their innovations,
    /// `Σ w_t e_t = Σ (Aᵀw)_t y_t`.
    pub fn adjoint(&self, weights: &[f64]) -> Vec<f64> {
        let order = self.coefficients.len();
        let mut samples = vec![
            0.0;
            if weights.is_empty() {
                0
            } else {
                weights.len() + order
            }
        ];
        for (k, w) in weights.iter().enumerate() {
            samples[k + order] += w;
            for (lag, a) in self.coefficients.iter().enumerate() {
                samples[k + order - 1 - lag] -= a * w;
            }
        }
        samples
    }

    /// The series that innovations cause from rest: y = e / A(z), in the unit of the innovations.
    pub fn shape(&self, innovations: &[f64]) -> Vec<f64> {
        let mut series: Vec<f64> = Vec::with_capacity(innovations.len());
        for innovation in innovations {
            let past = series.iter().rev();
            let predicted: f64 = self.coefficients.iter().zip(past).map(|(a, y)| a * y).sum();
            series.push(innovation + predicted);
        }
        series
    }

    /// Variance of `ln Var(Σ w_t e_t)` with the innovations e by this model, over errors of its coefficients, which were estimated from
    /// so many samples.
    ///
    /// `∂Var/∂a_i = 2σ² Σ_t w_t y_(t+i)`, y the weights coloured backward in time; the coefficients have the covariance σ² R⁻¹/n with the
    /// autocovariance matrix R (Brockwell and Davis 1991, theorem 8.1.1), and `σ² R⁻¹ = L Lᵀ − M Mᵀ` with triangular matrices of the
    /// coefficients (Siddiqui 1958).
    pub fn variance_of_log_variance(&self, weights: &[f64], samples: usize) -> f64 {
        let squares: f64 = weights.iter().map(|w| w * w).sum();
        let order = self.coefficients.len();
        if order == 0 || squares <= 0.0 {
            return 0.0;
        }
        let reversed: Vec<f64> = weights.iter().rev().copied().collect();
        let mut coloured = self.shape(&reversed);
        coloured.reverse();
        let slope = |lag: usize| {
            let later = coloured.iter().skip(lag);
            2.0 * weights.iter().zip(later).map(|(w, y)| w * y).sum::<f64>() / squares
        };
        let slopes: Vec<f64> = (1..=order).map(slope).collect();
        // ‖Tᵀ slopes‖² of the lower triangular Toeplitz matrix T with this first column.
        let squared = |column: &[f64]| -> f64 {
            let of = |k: usize| {
                let below = slopes[k..].iter().zip(column);
                below.map(|(s, t)| s * t).sum::<f64>().powi(2)
            };
            (0..order).map(of).sum()
        };
        let negative = |a: &f64| -a;
        let mut forward = vec![1.0];
        forward.extend(self.coefficients[..order - 1].iter().map(negative));
        let backward: Vec<f64> = self.coefficients.iter().rev().map(negative).collect();
        (squared(&forward) - squared(&backward)).max(0.0) / samples as f64
    }

    /// Samples beyond which one tells less than a share of the variance of another: `ρ_k² < share` for all lags k from there on.
    pub fn memory(&self, share: f64) -> usize {
        let response = self.impulse_response(LONGEST_MEMORY);
        let square: f64 = response.iter().map(|h| h * h).sum();
        let correlation = |lag: usize| {
            let later = response[lag..].iter();
            later.zip(&response).map(|(a, b)| a * b).sum::<f64>() / square
        };
        let remembered = (1..LONGEST_MEMORY).rfind(|&lag| correlation(lag).powi(2) >= share);
        remembered.unwrap_or(0)
    }

    /// Response to a unit innovation, the first `length` samples.
    pub fn impulse_response(&self, length: usize) -> Vec<f64> {
        let mut impulse = vec![0.0; length];
        if let Some(first) = impulse.first_mut() {
            *first = 1.0;
        }
        self.shape(&impulse)
    }
}

/// Forward and backward prediction errors of one segment.
struct Errors {
    forward: Vec<f64>,
    backward: Vec<f64>,
}

impl Errors {
    fn new(segment: &[f64]) -> Self {
        Self {
            forward: segment.get(1..).unwrap_or_default().to_vec(),
            backward: segment[..segment.len().saturating_sub(1)].to_vec(),
        }
    }

    /// The errors of the next order, one pair fewer.
    fn advance(&mut self, reflection: f64) {
        for (f, b) in self.forward.iter_mut().zip(&mut self.backward) {
            (*f, *b) = (*f - reflection * *b, *b - reflection * *f);
        }
        if !self.forward.is_empty() {
            self.forward.remove(0);
            self.backward.pop();
        }
    }
}

/// Burg's partial autocorrelation 2 Σ f b / Σ (f² + b²); `None` when nothing is left to explain.
fn common_reflection(errors: &[Errors]) -> Option<f64> {
    let pairs = || {
        errors
            .iter()
            .flat_map(|e| e.forward.iter().zip(&e.backward))
    };
    let power: f64 = pairs().map(|(f, b)| f * f + b * b).sum();
    let cross: f64 = pairs().map(|(f, b)| f * b).sum();
    (power > 0.0).then(|| 2.0 * cross / power)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::ljung_box::ljung_box;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution as _, StandardNormal};

    fn noise(count: usize, seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..count)
            .map(|_| StandardNormal.sample(&mut rng))
            .collect()
    }

    #[test]
    fn weights_of_samples_give_the_sum_of_weighted_innovations() {
        let model = Autoregression {
            coefficients: vec![0.7, -0.2],
            innovation_variance: 1.0,
        };
        let series = [1.0, -0.5, 2.0, 0.3, 0.9];
        let weights = [0.4, -1.0, 0.25];
        let of = |w: &[f64], y: &[f64]| w.iter().zip(y).map(|(w, y)| w * y).sum::<f64>();
        let direct = of(&weights, &model.innovations(&series));
        assert!((direct - of(&model.adjoint(&weights), &series)).abs() < 1e-12);
    }

    #[test]
    fn recovers_known_coefficients_within_their_standard_error() {
        let truth = Autoregression {
            coefficients: vec![1.2, -0.5],
            innovation_variance: 1.0,
        };
        let count = 20_000;
        let series = truth.shape(&noise(count, 1));
        let halves = [&series[..count / 2], &series[count / 2..]];
        let found = Autoregression::fit(&halves, 10, OrderCriterion::Bic).unwrap();
        assert_eq!(found.coefficients.len(), 2);
        // Standard error of a_2 of an AR(2): sqrt((1 - a_2²) / n).
        let error = ((1.0 - 0.25) / count as f64).sqrt();
        for (a, b) in found.coefficients.iter().zip(&truth.coefficients) {
            assert!((a - b).abs() <= 4.0 * error, "{a} {b}");
        }
        assert!((found.innovation_variance - 1.0).abs() <= 4.0 * (2.0 / count as f64).sqrt());
        let white = found.whiten(&series);
        assert!(ljung_box(&series, 20, 0).unwrap().p_value < 1e-12);
        assert!(ljung_box(&white, 20, 2).unwrap().p_value > 1e-3);
    }

    #[test]
    fn twenty_samples_determine_a_coefficient() {
        let orders = [19, 20, 39, 40, 639, 640, 100_000].map(largest_order);
        assert_eq!(orders, [0, 1, 1, 2, 31, 32, 32]);
    }

    #[test]
    fn white_noise_has_order_zero() {
        let series = noise(5000, 2);
        let found = Autoregression::fit(&[&series], 10, OrderCriterion::Bic).unwrap();
        assert!(found.coefficients.is_empty());
        assert!(Autoregression::fit(&[], 3, OrderCriterion::Aic).is_none());
        assert!(Autoregression::fit(&[&[0.0; 9]], 3, OrderCriterion::Aic).is_some());
    }

    #[test]
    fn matches_closed_form_of_first_order() {
        // AR(1): r_k = a^k / (1 - a²), impulse response a^k, long-run variance 1 / (1 - a)².
        let a: f64 = 0.8;
        let covariance: Vec<f64> = (0..4).map(|k| a.powi(k) / (1.0 - a * a)).collect();
        let found = Autoregression::from_autocovariance(&covariance).unwrap();
        let expected = [a, 0.0, 0.0];
        assert!(
            found
                .coefficients
                .iter()
                .zip(expected)
                .all(|(f, e)| (f - e).abs() <= 1e-15)
        );
        assert!((found.innovation_variance - 1.0).abs() <= 1e-15);
        assert!((found.variance() - covariance[0]).abs() <= 1e-14);
        assert!((found.long_run_variance() - 25.0).abs() <= 1e-12);
        let response = found.impulse_response(3);
        assert!(
            response
                .iter()
                .zip([1.0, a, a * a])
                .all(|(f, e)| (f - e).abs() <= 1e-15)
        );
        assert!(Autoregression::from_autocovariance(&[1.0, 2.0]).is_none());
        assert!(Autoregression::from_autocovariance(&[0.0, 0.0]).is_none());
        // In whatever unit.
        let small: Vec<f64> = covariance.iter().map(|r| 1e-9 * r).collect();
        let found = Autoregression::from_autocovariance(&small).unwrap();
        assert!((found.coefficients[0] - a).abs() <= 1e-15);
        assert!((1e9 * found.innovation_variance - 1.0).abs() <= 1e-14);
    }

    /// AR(1): `ρ_k² = a^{2k}` falls below a share at `k = ln(share)/(2 ln a)`; white noise is forgotten at once.
    #[test]
    fn matches_closed_form_of_memory() {
        let covariance: Vec<f64> = (0..2).map(|k| 0.8_f64.powi(k)).collect();
        let first_order = Autoregression::from_autocovariance(&covariance).unwrap();
        for share in [0.5_f64, 0.1, 0.01, 1e-4] {
            let lag = share.ln() / (2.0 * 0.8_f64.ln());
            assert_eq!(first_order.memory(share), lag.floor() as usize);
        }
        assert_eq!(Autoregression::white(2.0).memory(0.01), 0);
    }

    #[test]
    fn invariant_whitening_is_the_inverse_root_of_the_covariance() {
        // The whitening matrix W of n samples satisfies W C Wᵀ = I for the covariance C of the model.
        let model = Autoregression {
            coefficients: vec![0.9, -0.4, 0.2],
            innovation_variance: 0.3,
        };
        let n = 8;
        let response = model.impulse_response(400);
        let covariance = |k: usize| -> f64 {
            let products = response[k..].iter().zip(&response).map(|(a, b)| a * b);
            model.innovation_variance * products.sum::<f64>()
        };
        let c = nalgebra::DMatrix::from_fn(n, n, |i, j| covariance(i.abs_diff(j)));
        let mut w = nalgebra::DMatrix::zeros(n, n);
        for j in 0..n {
            let mut unit = vec![0.0; n];
            unit[j] = 1.0;
            w.column_mut(j).copy_from_slice(&model.whiten(&unit));
        }
        let identity = &w * c * w.transpose();
        assert!((identity - nalgebra::DMatrix::identity(n, n)).amax() <= 1e-12);
    }
}
