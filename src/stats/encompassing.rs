//! Whether a richer model forecasts the residual of a poorer one on recordings that were not fitted.
//!
//! `e = b (e − e_h) + ε`: b = 0 if the poorer model says all that the richer says, 1 if the richer is right
//! (forecast encompassing: Chong and Hendry 1986; Harvey, Leybourne and Newbold 1998, section 2). The variance of b
//! is that of sums over blocks, longer than residuals remember, of the residual ε times the regressor, which
//! holds for any autocorrelation within a block (Newey and West 1987); its degrees of freedom are at most the effective number
//! of blocks in which the two models differ, less one (Satterthwaite 1946).
//!
//! With d the difference of the models, `b = Σ z e / Σ z d`: by least squares z = d, and any other z that follows from d alone
//! serves as instrument (Reiersøl 1945). Where a law strikes in few rows, such as the impacts of play, all that d says is in one
//! block, and nothing shows how that could vary; z is d clipped at the size at which, in noise that is alike in all rows, the
//! richer model is to be expected to be told best from the poorer.
//!
//! Both residuals are taken as innovations of one autoregression per channel, that of the richer model's residual: noise
//! that remembers is then nearly white, the variance rests on many short blocks and not on a few long ones, and what
//! distinguishes the models counts where there is little noise (prewhitening: Andrews and Monahan 1992). The autoregression is
//! an estimate: what models differ by slowly rests on the few times that red noise forgets, and the error of its coefficients takes
//! degrees of freedom, ν = 2/Var(ln V) of the variance V (Satterthwaite 1946).
//!
//! The poorer model's parameters are estimates: an error δθ of covariance C moves its residual by J δθ, alike in all blocks
//! where held-out motions go beyond the fitted ones, and adds `gᵀC g`, g = Jᵀz, to the variance of `Σ z e` (West 1996,
//! theorem 4.1). The difference d of the models is nearly independent of it where the poorer model is right, and
//! efficiently fitted (Hausman 1978).
//!
//! Where the noise of a row is known, the variance is at least `τ Σ σ² z²` with the correlation time τ of the residual,
//! as of noise of that size, and only what blocks show beyond it has their few degrees of freedom.
//!
//! The slope is `b ~ 1 + s t_ν` if the richer model is right, `b ~ s t_ν` if the poorer is. With 1/s the distance and ν the
//! degrees of freedom the ratio of their likelihoods is
//!
//! ```text
//! ln Λ = ln f_ν((b − 1)/s) − ln f_ν(b/s),    ln f_ν(x) = −(ν + 1)/2 ln(1 + x²/ν) + const
//! ```

mod blocks;

use crate::stats::autoregression::{Autoregression, largest_order};
use crate::stats::deviation::deviation;
use crate::stats::distribution::Distribution;
use crate::stats::encompassing::blocks::{Concentration, Sums};
use crate::stats::estimation_error::EstimationError;

/// The test of one model against another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Encompassing {
    /// b.
    pub slope: f64,
    /// b over its standard deviation.
    pub ratio: f64,
    /// 1 over the standard deviation of b: the ratio to be expected where the richer model is right.
    pub distance: f64,
    /// Degrees of freedom of Student's distribution that the ratio has where b = 0; need not be an integer.
    pub freedom: f64,
    /// Probability of such a ratio, or a larger one, where b = 0; of one test.
    pub p_value: f64,
}

impl Encompassing {
    /// Of models that do not differ.
    pub fn of_nothing() -> Self {
        Self {
            slope: 0.0,
            ratio: 0.0,
            distance: 0.0,
            freedom: 1.0,
            p_value: 1.0,
        }
    }

    /// Probability that parameters which a recording has for itself lower the residual as much by chance: each recording is fitted anew, at
    /// whatever time serves best, and noise that remembers is alike in the rows that are fitted and in those between.
    ///
    /// The square of the ratio is that of so many parameters over a variance with the test's degrees of freedom (Fisher's F) at a given
    /// beginning and end, of which n rows have n²/2.
    pub fn of_own_parameters(&self, parameters: usize, rows: usize) -> f64 {
        let parameters = parameters.max(1) as f64;
        let distribution = Distribution::FisherF {
            numerator: parameters,
            denominator: self.freedom,
        };
        let one = distribution.upper_tail(self.ratio.max(0.0).powi(2) / parameters);
        (one * 0.5 * (rows * rows) as f64).min(1.0)
    }

    /// ln Λ, of the likelihoods of the richer model and of the poorer.
    pub fn log_likelihood_ratio(&self) -> f64 {
        let log_density = |x: f64| -0.5 * (self.freedom + 1.0) * (x * x / self.freedom).ln_1p();
        log_density(self.ratio - self.distance) - log_density(self.ratio)
    }
}

/// What the rows of residuals are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResidualRows {
    /// Each with noise of its own.
    Recorded,
    /// Behind a low-pass, which has emptied the frequencies that innovations would count most.
    Filtered,
}

/// Rows of a block at least.
const LEAST_BLOCK: usize = 8;

/// Blocks of a recording at least.
const LEAST_BLOCKS: usize = 24;

/// With fewer than one and a half effective blocks there is nothing between which they could vary.
const LEAST_FREEDOM: f64 = 0.5;

/// Sizes at which instruments are clipped, each half of the one before: from the largest difference down to thousandths of it.
const CLIPS: usize = 11;

/// Blocks are this many times longer than the residual's correlation time.
const CORRELATION_TIMES: f64 = 4.0;

/// What is known of the variance apart from blocks.
#[derive(Clone, Copy, Default)]
pub struct Known<'a> {
    /// RMS noise of a row per channel.
    pub noise: Option<&'a [f64]>,
    /// Errors of the poorer model's parameters.
    pub estimates: Option<&'a EstimationError<'a>>,
}

/// Residuals of a poorer and of a richer model over the same rows, `[channel][row]`.
#[derive(Debug, Clone, Copy)]
pub struct ResidualPair<'a> {
    /// e, in the unit of the signal.
    pub poorer: &'a [Vec<f64>],
    /// e_h, over the same rows.
    pub richer: &'a [Vec<f64>],
}

impl ResidualPair<'_> {
    /// Whether the richer model forecasts what the poorer leaves.
    pub fn encompassing(self, known: Known<'_>, rows: ResidualRows) -> Encompassing {
        match rows {
            ResidualRows::Filtered => {
                let differences = Differences::of(self);
                let weights = || {
                    let instruments = differences.instruments();
                    differences.weights(&instruments)
                };
                let of_estimates = known.estimates.map_or(0.0, |e| e.variance(&weights()));
                let beside = Beside {
                    of_estimates,
                    of_colour: 0.0,
                };
                differences.encompassing(known.noise, beside)
            }
            ResidualRows::Recorded => {
                let white = self.whitened(known.noise);
                let differences = Differences::of(white.pair());
                let instruments = differences.instruments();
                let weights = || {
                    let pairs = white.models.iter().zip(differences.weights(&instruments));
                    pairs
                        .map(|(model, w)| model.adjoint(&w))
                        .collect::<Vec<_>>()
                };
                let of_estimates = known.estimates.map_or(0.0, |e| e.variance(&weights()));
                let of_colour = variance_of_log_variance(&white.models, &instruments);
                let beside = Beside {
                    of_estimates,
                    of_colour,
                };
                differences.encompassing(white.noise.as_deref(), beside)
            }
        }
    }

    /// Innovations of both residuals by the autoregression of the richer one, and the noise in the same units.
    fn whitened(self, noise: Option<&[f64]>) -> Whitened {
        let models: Vec<Autoregression> = self
            .richer
            .iter()
            .map(|e| {
                let most = largest_order(e.len());
                let covariance = with_floor(e, most);
                let model = Autoregression::of_autocovariance(&covariance, e.len());
                model.unwrap_or_else(|| Autoregression::white(1.0))
            })
            .collect();
        let of = |residuals: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let pairs = residuals.iter().zip(&models);
            pairs.map(|(e, model)| model.innovations(e)).collect()
        };
        let (poorer, richer) = (of(self.poorer), of(self.richer));
        let noise = noise.map(|noise| {
            let of = |c: usize| noise[c] * deviation(&richer[c]) / deviation(&self.richer[c]);
            (0..noise.len()).map(of).collect()
        });
        Whitened {
            poorer,
            richer,
            noise,
            models,
        }
    }
}

/// White noise that is added to a residual, as a share of its variance: frequencies at which there is nothing say nothing,
/// and would have all the weight.
const FLOOR: f64 = 1e-3;

/// Autocovariances of a residual up to a lag, with the floor.
fn with_floor(series: &[f64], most: usize) -> Vec<f64> {
    let n = series.len().max(1) as f64;
    let at = |lag: usize| {
        let pairs = series.iter().zip(series.get(lag..).unwrap_or_default());
        pairs.map(|(a, b)| a * b).sum::<f64>() / n
    };
    let mut covariance: Vec<f64> = (0..=most).map(at).collect();
    covariance[0] *= 1.0 + FLOOR;
    covariance
}

/// Two models' residuals per channel, the RMS noise of a row where it is known, and what they were whitened by.
struct Whitened {
    poorer: Vec<Vec<f64>>,
    richer: Vec<Vec<f64>>,
    noise: Option<Vec<f64>>,
    models: Vec<Autoregression>,
}

impl Whitened {
    fn pair(&self) -> ResidualPair<'_> {
        ResidualPair {
            poorer: &self.poorer,
            richer: &self.richer,
        }
    }
}

/// Two models over the channels with rows, each in units of what the richer leaves there.
struct Differences<'a> {
    pair: ResidualPair<'a>,
    scale: Vec<f64>,
    channels: Vec<usize>,
    /// What the models predict otherwise, `[channel][row]`.
    differences: Vec<Vec<f64>>,
    /// Rows of a block.
    block: usize,
    /// Largest size of the instrument.
    clip: f64,
}

impl<'a> Differences<'a> {
    fn of(pair: ResidualPair<'a>) -> Self {
        let channels = 0..pair.richer.len();
        let scale: Vec<f64> = pair.richer.iter().map(|e| deviation(e)).collect();
        let of = |c: usize| -> Vec<f64> {
            let rows = pair.poorer[c].iter().zip(&pair.richer[c]);
            rows.map(|(e, e_h)| (e - e_h) / scale[c]).collect()
        };
        let mut differences = Self {
            differences: channels.clone().map(of).collect(),
            scale,
            channels: channels.filter(|&c| !pair.richer[c].is_empty()).collect(),
            block: block_length(pair.richer),
            clip: f64::INFINITY,
            pair,
        };
        differences.clip = differences.best_clip();
        differences
    }

    /// The size at which the instrument is clipped: that with the largest likelihood ratio to be expected where the richer
    /// model is right, by what the models predict alone.
    fn best_clip(&self) -> f64 {
        let all = self.differences.iter().flatten();
        let largest = all.fold(0.0_f64, |largest, d| largest.max(d.abs()));
        let halved = std::iter::successors(Some(largest), |clip| Some(0.5 * clip));
        let expected = |clip: &f64| {
            let blocks = self.blocks(*clip);
            let total = Sums::of(&blocks);
            let freedom = Concentration::of(&blocks, total)
                .freedom()
                .max(LEAST_FREEDOM);
            let squared = total.difference * total.difference / total.instrument;
            0.5 * (freedom + 1.0) * (squared / freedom).ln_1p()
        };
        let clips = halved.take(CLIPS).filter(|clip| *clip > 0.0);
        clips
            .map(|clip| (clip, expected(&clip)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(largest, |(clip, _)| clip)
    }

    /// Sums of every block with an instrument that is clipped.
    fn blocks(&self, clip: f64) -> Vec<Sums> {
        let rows = self.pair.richer.iter().map(Vec::len).max().unwrap_or(0);
        let of = |start: usize| {
            let mut sums = Sums::default();
            for &c in &self.channels {
                let differences = &self.differences[c];
                for k in start..differences.len().min(start + self.block) {
                    let (d, z) = (differences[k], clipped(differences[k], clip));
                    sums.residual += z * (self.pair.poorer[c][k] / self.scale[c]);
                    sums.difference += z * d;
                    sums.instrument += z * z;
                }
            }
            sums
        };
        (0..rows).step_by(self.block).map(of).collect()
    }

    /// z of every row, `[channel][row]`.
    fn instruments(&self) -> Vec<Vec<f64>> {
        let of = |d: &Vec<f64>| d.iter().map(|d| clipped(*d, self.clip)).collect();
        self.differences.iter().map(of).collect()
    }

    /// Of rows of the poorer residual in Σ z e, `[channel][row]`.
    fn weights(&self, instruments: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let of = |(z, scale): (&Vec<f64>, &f64)| z.iter().map(|z| z / scale).collect();
        instruments.iter().zip(&self.scale).map(of).collect()
    }

    /// The test, with the RMS noise of a row where it is known, and what is uncertain beside it.
    fn encompassing(&self, noise: Option<&[f64]>, beside: Beside) -> Encompassing {
        let blocks = self.blocks(self.clip);
        let sums = Sums::of(&blocks);
        if sums.difference <= 0.0 {
            return Encompassing::of_nothing();
        }
        let blocks = variance_of_blocks(&blocks, sums);
        let of_noise = noise.map(|noise| self.variance_of_noise(noise));
        let variance = match (blocks, of_noise.filter(|known| known.value > 0.0)) {
            (Some(blocks), Some(noise)) => blocks.at_least(noise),
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => Variance {
                value: f64::INFINITY,
                freedom: 1.0,
            },
        };
        let variance = variance.of_estimated_colour(beside.of_colour);
        variance.with(beside.of_estimates).encompassing(sums)
    }

    /// `τ Σ σ² z²`, with the correlation time τ of what the richer model leaves.
    fn variance_of_noise(&self, noise: &[f64]) -> Variance {
        let of = |&c: &usize| {
            let time = correlation_time(&self.pair.richer[c]);
            let rows = self.differences[c].iter();
            let squares: f64 = rows.map(|d| clipped(*d, self.clip).powi(2)).sum();
            time * squares * (noise[c] / self.scale[c]).powi(2)
        };
        let lengths = self.channels.iter().map(|&c| self.pair.richer[c].len());
        let rows: usize = lengths.sum();
        Variance {
            value: self.channels.iter().map(of).sum(),
            freedom: rows as f64,
        }
    }
}

/// Variance of the logarithm of that of Σ z ε, with innovations ε of variance one in every channel, over errors of the models that they
/// are by.
fn variance_of_log_variance(models: &[Autoregression], instruments: &[Vec<f64>]) -> f64 {
    let (mut total, mut uncertain) = (0.0, 0.0);
    for (model, z) in models.iter().zip(instruments) {
        let variance: f64 = z.iter().map(|z| z * z).sum();
        total += variance;
        uncertain += variance * variance * model.variance_of_log_variance(z, z.len());
    }
    if total > 0.0 {
        uncertain / (total * total)
    } else {
        0.0
    }
}

/// The instrument of a row: the difference, of a size at most.
fn clipped(difference: f64, size: f64) -> f64 {
    difference.max(-size).min(size)
}

/// As blocks show it; `None` where the models differ in too few of them.
fn variance_of_blocks(blocks: &[Sums], total: Sums) -> Option<Variance> {
    let slope = total.slope();
    let score = |block: &Sums| (block.residual - slope * block.difference).powi(2);
    let concentration = Concentration::of(blocks, total);
    let freedom = concentration.freedom();
    (freedom >= LEAST_FREEDOM).then(|| Variance {
        // Blocks to which the slope was fitted show less than there is.
        value: blocks.iter().map(score).sum::<f64>() / concentration.shown,
        freedom: freedom.max(1.0),
    })
}

/// What makes Σ z e uncertain beside the noise of the rows.
#[derive(Debug, Clone, Copy)]
struct Beside {
    /// Variance by the errors of the poorer model's parameters.
    of_estimates: f64,
    /// Variance of the logarithm of that of the noise, by the error of what whitened it.
    of_colour: f64,
}

/// A variance of `Σ z ε` and its degrees of freedom.
#[derive(Debug, Clone, Copy)]
struct Variance {
    value: f64,
    freedom: f64,
}

impl Variance {
    /// Of which a part is known, and the rest is what blocks show beyond it.
    fn at_least(self, known: Self) -> Self {
        let beyond = (self.value - known.value).max(0.0);
        let value = known.value + beyond;
        let uncertain = known.value * known.value / known.freedom + beyond * beyond / self.freedom;
        Self {
            value,
            freedom: value * value / uncertain,
        }
    }

    /// The same as an estimate whose logarithm varies by so much more.
    fn of_estimated_colour(self, of_logarithm: f64) -> Self {
        Self {
            freedom: 1.0 / (1.0 / self.freedom + 0.5 * of_logarithm),
            ..self
        }
    }

    /// With a part that is known.
    fn with(self, known: f64) -> Self {
        let value = self.value + known;
        match known > 0.0 {
            true => Self {
                value,
                freedom: self.freedom * (value / self.value).powi(2),
            },
            false => self,
        }
    }

    fn encompassing(self, sums: Sums) -> Encompassing {
        let over_deviation = |sum: f64| match self.value > 0.0 {
            true => sum / self.value.sqrt(),
            false => 0.0,
        };
        let (ratio, freedom) = (over_deviation(sums.residual), self.freedom);
        Encompassing {
            slope: sums.slope(),
            ratio,
            distance: over_deviation(sums.difference),
            freedom,
            p_value: Distribution::StudentT { freedom }.upper_tail(ratio),
        }
    }
}

/// Rows of a block: four correlation times of the residual that remembers longest.
pub fn block_length(residuals: &[Vec<f64>]) -> usize {
    let rows = residuals.iter().map(Vec::len).max().unwrap_or(0);
    let longest = residuals
        .iter()
        .map(|e| correlation_time(e))
        .fold(1.0, f64::max);
    let most = (rows / LEAST_BLOCKS).max(LEAST_BLOCK);
    ((CORRELATION_TIMES * longest) as usize)
        .max(LEAST_BLOCK)
        .min(most)
}

/// `1 + 2 Σ ρ_l` rows up to the first lag at which the autocorrelation ρ falls below two standard deviations
/// of that of white noise.
pub fn correlation_time(series: &[f64]) -> f64 {
    let n = series.len();
    let total: f64 = series.iter().map(|x| x * x).sum();
    if n < 2 || total <= 0.0 {
        return 1.0;
    }
    let noise = 2.0 / (n as f64).sqrt();
    let mut time = 1.0;
    for lag in 1..n / 4 {
        let pairs = series.iter().zip(&series[lag..]);
        let correlation = pairs.map(|(a, b)| a * b).sum::<f64>() / total;
        if correlation < noise {
            break;
        }
        time += 2.0 * correlation;
    }
    time
}

#[cfg(test)]
mod tests;
