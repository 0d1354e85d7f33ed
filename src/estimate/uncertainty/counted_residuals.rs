//! Residuals as they count in a fit: times the factors of their rows, without the rows that are left out.

use crate::estimate::fit_problem::problem::FitProblem;
use crate::estimate::uncertainty::coloured_noise::{ColouredNoise, Counted, Innovations};

/// Residuals of a recording times the factors of their rows, and which rows of them count: `[channel][row]`.
#[derive(Default)]
pub(super) struct CountedResiduals {
    pub residuals: Vec<Vec<f64>>,
    pub counts: Vec<Vec<bool>>,
}

impl CountedResiduals {
    pub fn of(problem: &FitProblem<'_>, index: usize, residuals: &[Vec<f64>]) -> Self {
        let mut counted = Self::default();
        for (channel, series) in residuals.iter().enumerate() {
            let own = row_factors(problem, index, channel);
            counted.counts.push(own.iter().map(|f| *f != 0.0).collect());
            let influence = influence(&own);
            let scaled = series.iter().zip(&own).map(|(e, f)| influence * e * f * f);
            counted.residuals.push(scaled.collect());
        }
        counted
    }

    pub fn view(&self) -> Counted<'_> {
        Counted {
            residuals: &self.residuals,
            counts: &self.counts,
        }
    }

    /// Innovations of all channels.
    pub fn innovations(&self, colour: &ColouredNoise, cyclic: bool) -> Self {
        let channels = self.residuals.iter().zip(&self.counts).enumerate();
        let of = |(c, (series, counts)): (usize, (&Vec<f64>, &Vec<bool>))| {
            colour.innovations(c, series, counts, cyclic)
        };
        let mut all = Self::default();
        for Innovations { values, known } in channels.map(of) {
            all.residuals.push(values);
            all.counts.push(known);
        }
        all
    }
}

/// Factors of the rows of a channel of a recording; 0 where a row does not count.
pub(super) fn row_factors(problem: &FitProblem<'_>, index: usize, channel: usize) -> Vec<f64> {
    let recording = problem.recordings[index];
    let factors = problem.factors.as_ref().map(|factors| &factors[index]);
    let factor = |row: usize| match (recording.counts(row), factors) {
        (false, _) => 0.0,
        (true, None) => 1.0,
        (true, Some(factors)) => factors[channel][row],
    };
    (0..recording.rows()).map(factor).collect()
}

/// `√(mean f²) / mean ψ′` over the rows that count: residuals f² e times this, beside derivatives times f, give the
/// covariance of an M-estimator, `mean ψ² / (mean ψ′)² (XᵀX)⁻¹` (Huber and Ronchetti 2009, section 7.6). Of Tukey's biweight with
/// f = 1 − (u/c)², ψ′ = f (5 f − 4); rows that are counted whole have f = 1, and all of them give 1.
fn influence(factors: &[f64]) -> f64 {
    let (mut weight, mut slope, mut rows) = (0.0, 0.0, 0.0);
    for f in factors.iter().filter(|f| **f != 0.0) {
        weight += f * f;
        slope += f * (5.0 * f - 4.0);
        rows += 1.0;
    }
    // More than half of the rows lie where ψ rises, by the scale that is their median deviation.
    if slope > 0.0 {
        (weight * rows).sqrt() / slope
    } else {
        1.0
    }
}
