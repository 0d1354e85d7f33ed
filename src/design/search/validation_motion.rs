//! A motion for validation: within the same limits, and far from the designed one in the space of positions and velocities, so
//! that a model that only fits the training motion is found out.

use nalgebra::DVector;

use crate::design::problem::{Excitation, Experiment};
use crate::design::search::multistart::Search;
use crate::design::search::starts::Starts;
use crate::design::trajectory::fourier_series::Basis;
use crate::design::trajectory::motion::{Joints, Motion};
use crate::design::verify;
use crate::robot::random::generator;

/// Random motions among which the farthest is chosen.
const CANDIDATES: usize = 24;

/// Samples of each motion that are compared.
const COMPARED: usize = 60;

/// Share of the limits of torque and workspace that the candidates keep to between samples too.
const SHARE: f64 = 0.98;

/// The first stream of the generator; searches use low ones.
const STREAM: u64 = 1 << 40;

/// The farthest of many random motions that keep all limits; `None` where none does.
pub fn far_from(search: &Search<'_>, x: &DVector<f64>) -> Option<DVector<f64>> {
    let experiment = search.experiment;
    let problem = Excitation::new(experiment, 1.0, SHARE);
    let starts = Starts::of(experiment, &problem, search.rows);
    let states = states(experiment, &experiment.joints, x);
    let mut best: Option<(f64, DVector<f64>)> = None;
    for number in 0..CANDIDATES {
        let mut rng = generator(search.settings.seed);
        rng.set_stream(STREAM + number as u64);
        let candidate = starts.random(&mut rng);
        let margins = verify::margins(experiment, &candidate);
        if verify::violation(&margins) > 0.0 {
            continue;
        }
        let own = candidate
            .rows(0, experiment.joints.of_trajectory())
            .into_owned();
        let distance = distance(
            &self::states(experiment, &experiment.joints.single(), &own),
            &states,
        );
        if best.as_ref().is_none_or(|(d, _)| distance > *d) {
            best = Some((distance, own));
        }
    }
    best.map(|(_, own)| own)
}

/// Positions and velocities as shares of their limits, sample after sample.
fn states(experiment: &Experiment<'_>, joints: &Joints, x: &DVector<f64>) -> Vec<Vec<f64>> {
    let basis = Basis::new(joints.series, COMPARED);
    let motion = Motion::of(joints, &basis, x);
    (0..motion.len())
        .map(|k| {
            let of = |j: &usize| {
                let limits = &experiment.bounds[*j];
                [
                    (motion.values[0][*j][k] - limits.middle()) / limits.half_range(),
                    motion.values[1][*j][k] / limits.velocity,
                ]
            };
            joints.moving.iter().flat_map(of).collect()
        })
        .collect()
}

/// Mean distance from the states of one motion to the nearest of another.
fn distance(from: &[Vec<f64>], to: &[Vec<f64>]) -> f64 {
    let between = |a: &Vec<f64>, b: &Vec<f64>| -> f64 {
        let squares = a.iter().zip(b).map(|(x, y)| (x - y).powi(2));
        squares.sum::<f64>().sqrt()
    };
    let nearest = |a| {
        to.iter()
            .map(|b| between(a, b))
            .fold(f64::INFINITY, f64::min)
    };
    from.iter().map(nearest).sum::<f64>() / from.len() as f64
}
