//! The load of an industrial arm from its motor currents: honest intervals, convergence from anywhere, what
//! a motion of the wrist alone cannot tell, and one experiment as prior knowledge of the next.

mod bench;
mod noisy;
mod sequence;

use bench::{Bench, NAMES, Payload, SEEDS};
use exid::chain::prior::Prior;
use exid::estimate::estimator::{Estimator, Training};
use exid::estimate::fit::{Fitted, fit};
use exid::estimate::problem::FitProblem;
use exid::estimate::unknowns::Unknowns;
use exid::estimate::weights::Weights;
use exid::problem::Problem;
use exid::problem::solution::{Control, Solution};
use exid::problem::view::LeastSquares;
use exid::robot::random::{generator, symmetric};
use exid::solve::levenberg_marquardt::{self, Settings};
use nalgebra::DVector;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Iterations from the linear start, where the scatter of the periods gives the weights.
const MOST_ITERATIONS: u64 = 20;

/// Share of recordings whose optimum may lie on a kink: the losses of an axis have another slope on either side of the row in which
/// its load changes sign, no step of any length keeps its promise there, and the search halves them down to rounding.
const ON_A_KINK: f64 = 0.005;

fn estimate(bench: &Bench, seed: u64) -> Fitted {
    let data = bench.data(seed);
    let prior = Prior::none(bench.model.parameters().len());
    let estimator = Estimator::MaximumLikelihood;
    fit(&bench.model, &data, estimator, &prior, &Control::default()).unwrap()
}

#[test]
fn intervals_of_the_load_cover_the_truth() {
    let bench = Bench::new(&[]);
    let slow = AtomicU64::new(0);
    let covered: Vec<Vec<bool>> = (0..SEEDS)
        .into_par_iter()
        .map(|seed| {
            let fitted = estimate(&bench, seed);
            let solver = fitted.estimate.solver.as_ref().unwrap();
            assert!(solver.converged, "{solver:?}");
            // One recording in some hundred is doubted by chance and weighted again by its residuals.
            let of_periods = |note: &String| note.contains("from the scatter of the periods");
            let at_once = fitted.fit.notes.iter().any(of_periods);
            if at_once && solver.iterations > MOST_ITERATIONS {
                slow.fetch_add(1, Ordering::Relaxed);
            }
            let load = Payload::of(&fitted.estimate.parameters);
            let inside = |k: usize| {
                let [low, high] = load.ci95[k].unwrap();
                (low..=high).contains(&bench.truth.value[k])
            };
            (0..NAMES.len()).map(inside).collect()
        })
        .collect();
    let slow = slow.into_inner() as f64 / SEEDS as f64;
    assert!(
        slow <= ON_A_KINK,
        "{slow} needed more than {MOST_ITERATIONS} iterations"
    );
    let share = |k: usize| covered.iter().filter(|c| c[k]).count() as f64 / SEEDS as f64;
    let each: Vec<f64> = (0..NAMES.len()).map(share).collect();
    let together = each.iter().sum::<f64>() / each.len() as f64;
    eprintln!(
        "{SEEDS} seeds: 95 % intervals cover {:.2} % together",
        100.0 * together
    );
    for (name, share) in NAMES.iter().zip(&each) {
        eprintln!("  payload.{name}: {:.1} %", 100.0 * share);
        assert!((0.90..=0.99).contains(share), "{name}: {share}");
    }
    assert!((0.93..=0.97).contains(&together), "{together}");
}

/// Random starts, the share of them that has to reach the optimum, and the factors of the parameters.
const STARTS: u64 = 500;
const SHARE: f64 = 0.99;
const FACTOR: f64 = 3.0;
/// Efficiencies start within these limits.
const EFFICIENCY: (f64, f64) = (0.3, 1.0);

/// Two searches agree when their optima are closer than this, in standard deviations of the estimate.
const SAME: f64 = 0.01;

#[test]
fn random_starts_reach_the_optimum_of_the_linear_start() {
    let bench = Bench::new(&[]);
    let data = bench.data(1);
    let prior = Prior::none(bench.model.parameters().len());
    let unknowns = Unknowns::find(&bench.model, &data, &prior);
    let recordings: Vec<_> = data.recordings.iter().collect();
    let weights = Weights::by_deviation(&bench.deviation_of_means());
    let problem = FitProblem::new(
        &bench.model,
        &unknowns,
        Training {
            recordings: &recordings,
            prior: &prior,
        },
        weights,
    );
    let search = |start: &DVector<f64>| -> Solution {
        let view = LeastSquares::try_from(&problem as &dyn Problem).unwrap();
        let settings = Settings {
            cost_tolerance: 1e-9,
            ..Settings::default()
        };
        levenberg_marquardt::minimize(view, start, &settings, &Control::default()).unwrap()
    };
    let fitted = estimate(&bench, 1);
    let positions = unknowns.positions();
    let from_linear =
        DVector::from_iterator(positions.len(), positions.iter().map(|&p| fitted.values[p]));
    let optimum = search(&from_linear);
    let count = positions.len();
    let factor = problem.factor(&optimum.x).matrix();
    let distance =
        |x: &DVector<f64>| (factor.view((0, 0), (count, count)) * (x - &optimum.x)).amax();
    let efficiency = |p: usize| bench.model.parameters()[p].name.ends_with("efficiency.R");
    let reached: Vec<(bool, usize)> = (0..STARTS)
        .into_par_iter()
        .map(|seed| {
            let mut rng = generator(7000 + seed);
            let mut start = optimum.x.clone();
            for (x, &p) in start.iter_mut().zip(&positions) {
                *x *= symmetric(&mut rng, FACTOR.ln()).exp();
                if efficiency(p) {
                    *x = x.clamp(EFFICIENCY.0, EFFICIENCY.1);
                }
            }
            let found = search(&start);
            (
                found.stop.converged() && distance(&found.x) < SAME,
                found.iterations,
            )
        })
        .collect();
    let share = reached.iter().filter(|r| r.0).count() as f64 / STARTS as f64;
    let most = reached.iter().map(|r| r.1).max().unwrap();
    eprintln!(
        "{:.1} % of {STARTS} starts reach the optimum, in at most {most} iterations",
        100.0 * share
    );
    assert!(share >= SHARE, "{share}");
}

#[test]
fn a_motion_of_the_wrist_alone_leaves_one_direction_open_and_names_what_it_touches() {
    let locked = ["robot.locked={ a1 = 0.0, a2 = -1.57, a3 = 1.57 }".to_string()];
    let bench = Bench::new(&locked);
    let prior = Prior::none(bench.model.parameters().len());
    let data = bench.data(1);
    let estimator = Estimator::MaximumLikelihood;
    let fitted = fit(&bench.model, &data, estimator, &prior, &Control::default()).unwrap();
    assert_eq!((fitted.fit.rank, fitted.fit.unknowns), (18, 19));
    let load = exid::estimate::load::describe(&fitted.estimate).unwrap();
    let all: Vec<String> = NAMES.iter().map(|name| format!("payload.{name}")).collect();
    assert!(
        all.iter().all(|name| load.undetermined.contains(name)),
        "{:?}",
        load.undetermined
    );
    assert_eq!(load.possible, None);
    // The lost direction is a point mass at the centre of the wrist, 0.23 m behind the flange: it has no first
    // and second moments there.
    let lost = [
        ("m", 1.0),
        ("mcz", -0.23),
        ("Ixx", 0.23 * 0.23),
        ("Iyy", 0.23 * 0.23),
    ];
    for base in &fitted.fit.posterior.combinations {
        let sum: f64 = base
            .terms
            .iter()
            .filter_map(|term| {
                let name = term.parameter.strip_prefix("payload.")?;
                let (_, change) = lost.iter().find(|(entry, _)| *entry == name)?;
                Some(term.coefficient * change)
            })
            .sum();
        assert!(sum.abs() < 1e-7, "{base:?}: {sum}");
    }
}
