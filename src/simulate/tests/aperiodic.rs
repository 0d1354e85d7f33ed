//! Motions that do not repeat, and noise that is not white.

use super::{ALL_MOTION, FRICTION, code, columns, motion_of, panda, simulated};
use crate::problem_file::ProblemFile;
use crate::setup::limits::of_joints;
use crate::setup::robot;
use crate::simulate::aperiodic::{Move, Sweep, Tone, Waveform};

const KINDS: [&str; 3] = ["tones", "moves", "sweeps"];

fn free(kind: &str, rest: &str) -> ProblemFile {
    let recordings = ALL_MOTION.replace("period = 5.0\n", "");
    let simulate = format!("[simulate]\ntrajectory = \"{kind}\"\nperiods = 4\n{rest}");
    panda(
        FRICTION,
        &format!(
            "{recordings}[design]\nperiod = 5.0\n[design.limits]\nacceleration = 5.0\n{simulate}"
        ),
    )
}

#[test]
fn invariant_motions_that_do_not_repeat_stay_within_four_fifths_of_every_limit() {
    for kind in KINDS {
        let problem = free(kind, "");
        let robot = robot::open(&problem).unwrap();
        let limits = of_joints(&problem, &robot).unwrap();
        for seed in 0..4 {
            let simulated = simulated(&problem, seed);
            for recording in 0..2 {
                let [q, dq, ddq] = motion_of(&simulated, recording);
                let tau = columns(&simulated, recording, "tau");
                assert_eq!(q[0].len(), 20 * 200);
                for (j, limit) in limits.iter().enumerate() {
                    // Peaks between the instants that are looked at: 200 of a cycle.
                    let share = 0.8 * 1.01;
                    let peak = |x: &[f64]| x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                    let away: Vec<f64> = q[j].iter().map(|x| x - limit.middle()).collect();
                    assert!(peak(&away) <= share * limit.half_range(), "{kind} {j}");
                    assert!(peak(&dq[j]) <= share * limit.velocity, "{kind} {j}");
                    assert!(peak(&ddq[j]) <= share * 5.0, "{kind} {j}");
                    assert!(peak(tau[j]) <= share * limit.torque.unwrap(), "{kind} {j}");
                    assert!(peak(&dq[j]) >= 0.05 * limit.velocity, "{kind} {j}");
                }
            }
        }
    }
}

#[test]
fn invariant_derivatives_match_differences_of_every_course() {
    let tone = |frequency: f64| Tone {
        amplitude: 0.4,
        frequency,
        phase: 0.3,
    };
    let step = |start: f64, from: f64, to: f64| Move {
        start,
        duration: 0.9,
        from,
        to,
    };
    let waveforms = [
        Waveform::Tones(vec![tone(1.1), tone(4.7)]),
        Waveform::Moves(vec![step(0.2, 0.5, -0.8), step(1.4, -0.8, 0.1)]),
        Waveform::Sweep(Sweep {
            frequency: 0.5,
            growth: 1.5,
            phase: 0.2,
            bounds: [1.2, 2.0, 5.0],
        }),
    ];
    let h = 1e-4;
    for waveform in waveforms {
        for k in 1..300 {
            let t = 0.01 * k as f64 + 0.003;
            let [before, at, after] = [t - h, t, t + h].map(|t| waveform.at(t));
            // Third derivatives stay below 300 here and fourth ones below 3000, but where a move begins and ends.
            let slope = (after[0] - before[0]) / (2.0 * h);
            assert!((at[1] - slope).abs() < 300.0 * h * h, "{waveform:?} {t}");
            let bend = (after[1] - before[1]) / (2.0 * h);
            assert!((at[2] - bend).abs() < 3000.0 * h * h, "{waveform:?} {t}");
        }
    }
}

#[test]
fn matches_closed_form_of_the_peaks_of_a_move() {
    let waveform = Waveform::Moves(vec![Move {
        start: 0.0,
        duration: 1.0,
        from: 0.0,
        to: 1.0,
    }]);
    let mut peaks = [0.0_f64; 3];
    for k in 0..100_000 {
        let [before, at] = [k, k + 1].map(|k| waveform.at(k as f64 * 1e-5));
        let found = [at[1], at[2], (at[2] - before[2]) / 1e-5];
        let all = peaks.iter_mut().zip(found);
        all.for_each(|(peak, x)| *peak = peak.max(x.abs()));
    }
    for (found, stated) in peaks.iter().zip(Move::PEAKS) {
        assert!((found / stated - 1.0).abs() < 1e-3, "{found} {stated}");
    }
}

/// Of N samples the estimate of ρ has the standard deviation √((1 − ρ²)/N) (Bartlett 1946), that of the variance
/// √(2 (1 + ρ²)/((1 − ρ²) N)).
#[test]
fn recovers_known_correlation_and_deviation_of_red_noise() {
    for correlation in [0.0_f64, 0.8, 0.98] {
        let text = format!("noise = 0.3\nnoise_correlation = {correlation:?}");
        let result = simulated(&free("tones", &text), 3);
        for recording in &result.recordings {
            for noise in &recording.noise {
                let count = noise.len() as f64;
                let squares: f64 = noise.iter().map(|x| x * x).sum();
                let products: f64 = noise.windows(2).map(|x| x[0] * x[1]).sum();
                let square = correlation * correlation;
                let of_correlation = ((1.0 - square) / count).sqrt();
                let of_variance = (2.0 * (1.0 + square) / ((1.0 - square) * count)).sqrt();
                // The estimate is low by about 2ρ/N beside.
                let error = products / squares - correlation;
                assert!(error.abs() < 5.0 * of_correlation, "{correlation}: {error}");
                let ratio = squares / count / 0.09 - 1.0;
                assert!(ratio.abs() < 5.0 * of_variance, "{correlation}: {ratio}");
            }
        }
    }
}

#[test]
fn a_declared_period_of_a_motion_that_does_not_repeat_is_refused() {
    for kind in KINDS {
        let rest = format!("{ALL_MOTION}[simulate]\ntrajectory = \"{kind}\"");
        assert_eq!(code(&panda(FRICTION, &rest)), "period-of-free-motion");
    }
}
