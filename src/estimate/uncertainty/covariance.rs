//! Covariance of the estimate when the residuals are coloured and correlated across channels:
//!
//! ```text
//! C = B (M + PᵀP) B,   B = (XᵀX + PᵀP)⁻¹,   M = Σ_f Z(f)ᴴ A⁻¹ S(f) A⁻ᴴ Z(f),   Z = WᵀW D
//! ```
//!
//! with the weighted derivatives X = W D, the prior's rows P, the autoregressions A of the residuals and the spectral
//! matrix S(f) of their innovations, which is smoothed: the sandwich of Newey and West (1987) with a prewhitened and
//! smoothed spectrum in place of a truncated autocovariance (Andrews and Monahan 1992). Residuals are smaller than noise
//! where the fit follows it; their power is divided by 1 − h(f), h the leverage `diag(X(f) B X(f)ᴴ)`, smoothed alike.

use crate::estimate::fit_problem::problem::{FitProblem, NoiseSource};
use crate::estimate::residual::noise::ResidualSeries;
use crate::estimate::uncertainty::coloured_noise::ColouredNoise;
use crate::estimate::uncertainty::counted_residuals::CountedResiduals;
use crate::estimate::uncertainty::segments::{Part, SegmentNoise, WholeSegment};
use crate::linalg::triangular::Triangular;
use nalgebra::{DMatrix, DVector};

/// Share of a column that is left where those before it are taken out, below which it is one of them.
const DEPENDENT: f64 = 1e-11;

/// Standard deviations of the residuals, of all rows together, that an unknown has to move them by when it changes by its own size, or
/// by what matters of it where that is more: one that does not could be thousands of times as large without a trace, and its
/// derivatives say nothing of what it then does, such as those of the force at which bristles break, where none ever bends that far.
const LEAST_TRACE: f64 = 1e-3;

/// Covariance of the unknowns at the optimum x; infinite variance of those that the derivatives do not determine
/// there, such as the shape of a law whose size has gone to zero.
pub fn of_unknowns(problem: &FitProblem<'_>, x: &DVector<f64>) -> Option<DMatrix<f64>> {
    let sensitivity = Sensitivity::of(problem, x)?;
    let residuals = problem.counted_residuals(x);
    Some(sensitivity.under(problem, &residuals).covariance())
}

/// What the covariance takes from the derivatives alone, whatever the noise.
#[derive(Debug, Clone)]
pub struct Sensitivity {
    values: DVector<f64>,
    /// Unknowns that the derivatives do not determine.
    open: Vec<usize>,
    /// R⁻¹ over the others, with `XᵀX + PᵀP = RᵀR`.
    inverse: DMatrix<f64>,
    /// Of each recording, where it is one segment and its derivatives are kept.
    segments: Vec<Option<WholeSegment>>,
}

impl Sensitivity {
    /// Of a problem at its optimum; `None` where the derivatives are not finite.
    pub fn of(problem: &FitProblem<'_>, x: &DVector<f64>) -> Option<Self> {
        let triangular = triangular(problem, x);
        let (open, kept) = open_and_kept(problem, x, &triangular);
        Some(Self {
            values: problem.parameters(x),
            open,
            inverse: inverse_over(&triangular, &kept)?,
            segments: vec![None; problem.recordings.len()],
        })
    }

    /// The same with the derivatives of recordings that are one segment, for several noises.
    pub fn with_derivatives(self, problem: &FitProblem<'_>) -> Self {
        let of = |index| self.part(problem, index).whole_segment();
        let segments = (0..problem.recordings.len()).map(of).collect();
        Self { segments, ..self }
    }

    fn part<'a>(&'a self, problem: &'a FitProblem<'a>, index: usize) -> Part<'a> {
        Part {
            problem,
            index,
            values: &self.values,
            inverse: &self.inverse,
            whole: self.segments[index].as_ref(),
        }
    }

    /// With residuals that are the noise, be they those of a model with more physics.
    pub fn under<'a>(
        &'a self,
        problem: &'a FitProblem<'a>,
        residuals: &ResidualSeries,
    ) -> Sandwich<'a> {
        let counted: Vec<CountedResiduals> = (0..problem.recordings.len())
            .map(|index| CountedResiduals::of(problem, index, &residuals[index]))
            .collect();
        let views: Vec<_> = counted.iter().map(CountedResiduals::view).collect();
        let colour = match problem.noise {
            NoiseSource::Periods => ColouredNoise::of_periods(problem.recordings),
            NoiseSource::Residuals => None,
        };
        let colour = colour.unwrap_or_else(|| ColouredNoise::of(&views));
        let parts = counted.iter().enumerate().map(|(index, counted)| {
            let part = self.part(problem, index);
            let noise = part.noise(counted, &colour);
            (part, noise)
        });
        Sandwich {
            parts: parts.collect(),
            problem,
            sensitivity: self,
        }
    }
}

/// The covariance of the unknowns under a noise, not multiplied out.
pub struct Sandwich<'a> {
    problem: &'a FitProblem<'a>,
    sensitivity: &'a Sensitivity,
    parts: Vec<(Part<'a>, SegmentNoise)>,
}

impl Sandwich<'_> {
    /// C; infinite variance of unknowns that the derivatives do not determine.
    pub fn covariance(&self) -> DMatrix<f64> {
        let Sensitivity { inverse, open, .. } = self.sensitivity;
        let bread = inverse * inverse.transpose();
        let known = self.known();
        let mut meat = known.tr_mul(&known);
        for (part, noise) in &self.parts {
            meat += part.middle(noise);
        }
        let covariance = &bread * meat * &bread;
        let mut covariance = (&covariance + covariance.transpose()) * 0.5;
        for &j in open {
            covariance[(j, j)] = f64::INFINITY;
        }
        covariance
    }

    /// `gᵀ C g` over the unknowns that the derivatives determine.
    pub fn variance(&self, g: &DVector<f64>) -> f64 {
        let inverse = &self.sensitivity.inverse;
        let along = inverse * inverse.tr_mul(g);
        let parts = self.parts.iter();
        let of_parts = parts.map(|(part, noise)| part.variance(noise, &along));
        of_parts.sum::<f64>() + (self.known() * &along).norm_squared()
    }

    /// P over the unknowns.
    fn known(&self) -> DMatrix<f64> {
        let positions = self.problem.unknowns.positions();
        self.problem.prior.rows().select_columns(&positions)
    }
}

/// R with `XᵀX + PᵀP = RᵀR` at x.
fn triangular(problem: &FitProblem<'_>, x: &DVector<f64>) -> DMatrix<f64> {
    let whole = problem.factor(x).matrix();
    whole.view((0, 0), (x.len(), x.len())).into_owned()
}

/// Unknowns that the derivatives do not determine, and the others.
fn open_and_kept(
    problem: &FitProblem<'_>,
    x: &DVector<f64>,
    triangular: &DMatrix<f64>,
) -> (Vec<usize>, Vec<usize>) {
    let positions = problem.unknowns.positions();
    let size = |j: usize| {
        x[j].abs()
            .max(problem.model.parameters()[positions[j]].scale)
    };
    let is_open = |j: usize| {
        let (own, all) = (triangular[(j, j)].abs(), triangular.column(j).norm());
        own.is_nan() || own <= DEPENDENT * all || all * size(j) <= LEAST_TRACE
    };
    (0..triangular.ncols()).partition(|&j| is_open(j))
}

/// R⁻¹ at x over the unknowns that the derivatives determine there, so that `R⁻¹ R⁻ᵀ` is the inverse of `XᵀX + PᵀP`.
pub(super) fn inverse_over_determined(
    problem: &FitProblem<'_>,
    x: &DVector<f64>,
) -> Option<DMatrix<f64>> {
    let triangular = triangular(problem, x);
    let (_, kept) = open_and_kept(problem, x, &triangular);
    inverse_over(&triangular, &kept)
}

/// R⁻¹ over some columns, with rows of zeros for the others.
fn inverse_over(triangular: &DMatrix<f64>, kept: &[usize]) -> Option<DMatrix<f64>> {
    let own = Triangular::of(&triangular.select_columns(kept)).matrix();
    let identity = DMatrix::identity(kept.len(), kept.len());
    let inverse = own.solve_upper_triangular(&identity)?;
    let mut whole = DMatrix::zeros(triangular.ncols(), kept.len());
    for (row, &j) in kept.iter().enumerate() {
        whole.row_mut(j).copy_from(&inverse.row(row));
    }
    Some(whole)
}
