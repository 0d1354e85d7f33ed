//! Reversal mask: rows at which a joint moves, away from its reversals.
//!
//! Around a reversal a joint sticks, and a speed that is differentiated from encoders with a bandwidth f changes sign
//! at another instant than friction does, and is smeared over 1/f. That shift, of some tenths of a millisecond, looks
//! like a delay of the signal; a delay shows while the joint moves too.

use crate::chain::dataset::Prepared;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::covariates::turns;
use crate::recording::split::Split;
use crate::stats::deviation::rms;

/// Beyond this share of its RMS speed a joint is under way, however near a reversal is.
const FAST: f64 = 0.5;

/// Up to this share of its RMS speed a joint creeps, and friction is as uncertain as at a reversal.
const CREEPS: f64 = 0.03;

/// The rows of the held-out recordings that count for a channel, and whether its joint and all to which that is coupled are fast
/// there, or further than half a period of their bandwidth from any reversal; `None` where it is that of no joint.
pub fn rows(context: &Context<'_>, fit: &ModelFit, channel: usize) -> Option<Vec<bool>> {
    let joint = fit.model.channels()[channel].joint?;
    let coupling = fit.model.coupling(&fit.values);
    let coupled = |k: &usize| coupling[(joint, *k)] != 0.0 || coupling[(*k, joint)] != 0.0;
    let joints: Vec<usize> = (0..coupling.nrows()).filter(coupled).collect();
    let held_out = context.recordings(Split::Validation);
    let of = |r: &&Prepared| {
        let away: Vec<Vec<bool>> = joints.iter().map(|&k| away(r, k)).collect();
        let counting = r.counting_for(channel);
        counting
            .map(|row| away.iter().all(|of| of[row]))
            .collect::<Vec<bool>>()
    };
    Some(held_out.iter().flat_map(of).collect())
}

fn away(recording: &Prepared, joint: usize) -> Vec<bool> {
    let speed = &recording.segment().motors.dq[joint];
    let bandwidth = recording.experiment.bandwidth[joint].cutoff_hz;
    let usual = rms(speed);
    let (fast, slow) = (FAST * usual, CREEPS * usual);
    let mut away = vec![true; speed.len()];
    let rate = recording.experiment.rate_hz / recording.stride as f64;
    let reach = (0.5 * rate / bandwidth).ceil().max(1.0) as usize;
    let is_near = |k: &usize| turns(speed, *k) || speed[*k].abs() <= slow;
    for k in (0..speed.len()).filter(is_near) {
        let end = (k + reach).min(speed.len());
        for near in k.saturating_sub(reach)..end {
            away[near] = speed[near].abs() > fast;
        }
    }
    away
}

/// A residual of a channel of the held-out recordings where its joint is under way; all of it where it has no joint.
pub fn residual(
    context: &Context<'_>,
    fit: &ModelFit,
    channel: usize,
    residual: &[f64],
) -> Vec<f64> {
    match rows(context, fit, channel) {
        Some(rows) => kept(residual, &rows),
        None => residual.to_vec(),
    }
}

/// A series at some of its rows.
pub fn kept(series: &[f64], rows: &[bool]) -> Vec<f64> {
    let kept = series.iter().zip(rows).filter(|(_, kept)| **kept);
    kept.map(|(x, _)| *x).collect()
}
