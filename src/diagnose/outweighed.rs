//! Names that explain less than they leave.
//!
//! A finding takes something of a channel's excess over the noise, L − 1 with the lack of fit L, and what is left no
//! name of the vocabulary explains. Where more is left than the finding takes, it may as well be the shadow that the
//! unexplained casts on what it is not: a torque constant that is off by as much as some other channel leaks into this
//! one on the average. Such a name is withdrawn, and the misfit reported without one.

use crate::diagnose::conclude::channels_of;
use crate::diagnose::floor::{Floor, UNEXPLAINED};
use crate::diagnose::refit::Refit;
use crate::diagnose::rivals::Contest;

/// The finding that explains the least share of what there would be without it, if that is less than half; only
/// where the noise is measured, and judged in the channel in which it explains most.
pub fn weakest(floor: &Floor, full: &Refit, contests: &[Contest]) -> Option<usize> {
    if !floor.measured {
        return None;
    }
    let shares = (0..contests.len()).filter_map(|k| {
        let share = share(floor, full, (&contests[k].without, k))?;
        (share < 0.5).then_some((k, share))
    });
    let least = shares.min_by(|a, b| a.1.total_cmp(&b.1));
    least.map(|(k, _)| k)
}

/// Share of the excess without the k-th finding that it explains, where what it leaves is unexplained.
fn share(floor: &Floor, full: &Refit, (without, k): (&Refit, usize)) -> Option<f64> {
    let channels = channels_of(&full.model, &full.hypotheses[k].named_joints());
    let lacks = channels.iter().map(|&c| {
        let of = |refit: &Refit| floor.lack_of_fit(&refit.validation, &[c]);
        (of(without), of(full))
    });
    let (before, after) = lacks.max_by(|a, b| (a.0 - a.1).total_cmp(&(b.0 - b.1)))?;
    (after > UNEXPLAINED).then(|| (before - after) / (before - 1.0))
}
