//! The evidence of a richer model against a poorer one on the rows that were held out.
//!
//! Models that differ in a few rows alone, at the impacts of a play or while something is touched, differ in so few
//! blocks that these do not tell the variance of what they leave. There the noise that is known from what repeats takes
//! its place, on rows under way: around reversals a few rows are off by more than noise in every model.

use crate::diagnose::bench::Bench;
use crate::diagnose::evidence::{Evidence, encompassing};
use crate::diagnose::floor;
use crate::diagnose::refit::Refit;
use crate::diagnose::underway;

/// Fewer degrees of freedom do not tell a variance: at 3 the upper bound of a standard deviation, at 95 %, is three times
/// its estimate.
const FEW: f64 = 3.0;

/// Whether `richer` forecasts what `poorer` leaves.
pub fn forecast(bench: &Bench<'_>, (poorer, richer): (&Refit, &Refit)) -> Evidence {
    let evidence = encompassing(
        (&poorer.validation, &richer.validation),
        None,
        bench.samples(),
    );
    if evidence.freedom >= FEW {
        return evidence;
    }
    let Some(noise) = floor::known(bench, richer) else {
        return evidence;
    };
    under_way(bench, (poorer, richer), Some(&noise))
}

/// The same on rows at which joints are under way.
pub fn under_way(
    bench: &Bench<'_>,
    (poorer, richer): (&Refit, &Refit),
    noise: Option<&[f64]>,
) -> Evidence {
    let of = |refit: &Refit| -> Vec<Vec<f64>> {
        let channels = refit.validation.iter().enumerate();
        let kept = channels.map(|(c, residual)| underway::residual(bench, richer, c, residual));
        kept.collect()
    };
    encompassing((&of(poorer), &of(richer)), noise, bench.samples())
}
