//! The context of all fits of a diagnosis: what is declared, recordings, and models with further effects.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::transition_limits::TransitionLimits;
use crate::diagnose::fit::derivatives::DerivativesCache;
use crate::diagnose::fit::fit_cache::FitCache;
use crate::diagnose::fit::hypothesis::{Hypothesis, addition};
use crate::problem::solution::Control;
use crate::recording::split::Split;
use crate::setup::error::SetupError;
use crate::setup::model_spec::{ModelSpec, ModelWithPrior};
use crate::stats::deviation::rms;
use crate::stats::encompassing::ResidualRows;

/// What is declared, with its recordings.
pub struct Context<'a> {
    /// What is declared.
    pub declared: &'a ModelSpec,
    /// The recordings, prepared.
    pub data: &'a Dataset,
    /// Who may interrupt, and how long it may take.
    pub control: &'a Control<'a>,
    /// Rows are samples in the order of time, not averages over periods.
    pub in_time: bool,
    /// RMS noise of one row per channel, averages over periods where there are any; `None` where nothing repeats.
    pub noise: Option<Vec<f64>>,
    /// Of the transition speeds of all models.
    pub limits: TransitionLimits,
    /// Rows of the recordings that are held out to which parameters of one recording are fitted; none where rows are
    /// averages over periods.
    pub between: Vec<Prepared>,
    /// Fits that were made before, by their hypotheses.
    pub cache: FitCache,
    /// Derivatives of the fits that others were last compared with.
    pub derivatives: DerivativesCache,
}

/// Whether the rows of recordings are in the order of time, not averages over periods.
pub fn is_in_time(data: &Dataset) -> bool {
    let averaged = |r: &Prepared| r.experiment.periods.is_some();
    !data.recordings.iter().any(averaged)
}

impl<'a> Context<'a> {
    /// Of recordings whose noise is not known yet.
    pub fn new(declared: &'a ModelSpec, data: &'a Dataset, control: &'a Control<'a>) -> Self {
        Self {
            declared,
            data,
            control,
            in_time: is_in_time(data),
            noise: None,
            limits: TransitionLimits::of(data),
            between: Vec::new(),
            cache: FitCache::default(),
            derivatives: DerivativesCache::default(),
        }
    }

    /// RMS of the signal of each channel over the rows that count; not zero.
    pub fn signal_rms(&self, split: Split) -> Vec<f64> {
        let channels = self.data.recordings.first();
        let channels = channels.map_or(0, |r| r.experiment.signal.len());
        let of = |c: usize| {
            let counting = self.data.of(split).flat_map(|r| {
                let rows = r.counting_for(c);
                rows.map(move |row| r.signal(c)[row])
            });
            rms(&counting.collect::<Vec<f64>>()).max(f64::MIN_POSITIVE)
        };
        (0..channels).map(of).collect()
    }

    /// The declared model with the physics of hypotheses.
    pub fn model(&self, hypotheses: &[Hypothesis]) -> Result<ModelWithPrior, SetupError> {
        let mut built = self.declared.build_with(&addition(hypotheses))?;
        built.model.limit_transitions(&self.limits);
        Ok(built)
    }

    /// What the rows of its residuals are.
    pub fn residual_rows(&self) -> ResidualRows {
        let mut recordings = self.data.recordings.iter();
        match recordings.any(|r| r.experiment.parallel.is_some()) {
            true => ResidualRows::Filtered,
            false => ResidualRows::Recorded,
        }
    }

    /// The recordings that are fitted, or those that are held out.
    pub fn recordings(&self, split: Split) -> Vec<&Prepared> {
        self.data.of(split).collect()
    }
}
