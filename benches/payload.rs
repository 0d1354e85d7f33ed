//! The payload of a KR150-like arm, 22 unknowns and 4 x 1540 residuals: load regressor, linear start and
//! Levenberg-Marquardt with analytic derivatives.
//!
//! The data are those of a peer, so that both solve one problem: `kr150_nls.py --export` writes q, qd, qdd and tau
//! as .npy files to `$BENCH_DATA/kr150`, and prints the peers' times; the robot is
//! `$EXID_DATA/bench/problems/kr150_like.urdf`. Without them this bench says so and measures nothing.

use criterion::{Criterion, criterion_group, criterion_main};
use exid::chain::dataset::{Dataset, Prepared};
use exid::chain::effect;
use exid::chain::model::{Inertials, Model, ModelSettings, Payload, Signal};
use exid::chain::prior::Prior;
use exid::estimate::estimator::Training;
use exid::estimate::problem::FitProblem;
use exid::estimate::unknowns::Unknowns;
use exid::estimate::weights::Weights;
use exid::problem::Problem;
use exid::problem::solution::{Control, Solution};
use exid::problem::view::LeastSquares;
use exid::recording::preprocess::prepare;
use exid::recording::samples::Recording;
use exid::recording::settings::Preparation;
use exid::recording::split::Split;
use exid::robot::urdf;
use exid::solve::{levenberg_marquardt, linear};
use nalgebra::{DMatrix, Isometry3};
use std::env;
use std::fs;
use std::hint::black_box;
use std::path::{Path, PathBuf};

const SAMPLES: usize = 1540;
const RATE_HZ: f64 = 100.0;
/// N·m, axes 3 to 6.
const NOISE: [f64; 4] = [40.0, 12.0, 10.0, 8.0];
/// kg·m² at the joint, axes 3 to 6.
const ROTOR: [f64; 4] = [55.0, 18.0, 14.0, 9.0];
/// rad: axes 1 and 2 stand here.
const STANDING: [f64; 2] = [0.0, -1.0];
/// Motor 5 turns by q5 + k54 q4, motor 6 by q6 + k64 q4 + k65 q5.
const COUPLING: [(usize, usize, f64); 3] = [(4, 3, 0.012), (5, 3, -0.012), (5, 4, 0.06)];

/// Rows of a .npy file of little-endian doubles, by column.
fn columns(file: &Path, count: usize) -> Option<Vec<Vec<f64>>> {
    let bytes = fs::read(file).ok()?;
    let values: Vec<f64> = bytes[bytes.len() - 8 * count * SAMPLES..]
        .chunks_exact(8)
        .map(|b| f64::from_le_bytes(b.try_into().unwrap_or_default()))
        .collect();
    let column = |j: usize| values.iter().skip(j).step_by(count).copied().collect();
    Some((0..count).map(column).collect())
}

/// Motors per joint motion, `m = C q`.
fn to_motors() -> DMatrix<f64> {
    let mut matrix = DMatrix::identity(6, 6);
    for (i, j, k) in COUPLING {
        matrix[(i, j)] = k;
    }
    matrix
}

/// The robot with friction and these further effects.
fn model(file: &Path, further: &[&str]) -> Option<Model> {
    let ids = ["coulomb_friction", "viscous_friction"]
        .iter()
        .chain(further);
    let list: Vec<_> = ids.filter_map(|id| effect::find(id)).collect();
    let mut rotor = vec![0.0; 2];
    rotor.extend(ROTOR);
    let mut offset = STANDING.to_vec();
    offset.resize(6, 0.0);
    let mut model = Model::new(ModelSettings {
        tree: urdf::read(file).ok()?,
        signal: Signal::Torque,
        inertials: Inertials::Known,
        controllers: None,
        torque_constant: None,
        torque_constant_std: None,
        current_polynomial: None,
        rotor_inertia: Some(rotor),
        coupling: to_motors().try_inverse(),
        offset: Some(offset),
        catalogue: effect::Catalogue::known(),
        period: None,
        effects: vec![list; 6],
        payload: Some(Payload {
            link: 5,
            frame: Isometry3::identity(),
        }),
        locked: vec![true, true, false, false, false, false],
        crosstalk: Vec::new(),
        shared: Vec::new(),
    })
    .ok()?;
    let widths: Vec<usize> = model.joints().iter().filter_map(|j| j.width).collect();
    for width in widths {
        model.fix(width, 0.0).ok()?;
    }
    Some(model)
}

/// The exported recording in motor coordinates, differentiated by its Fourier series.
fn data(folder: &Path) -> Option<Dataset> {
    let q = columns(&folder.join("q.npy"), 6)?;
    let tau = columns(&folder.join("tau.npy"), 4)?;
    let matrix = to_motors();
    let motor = |i: usize| -> Vec<f64> {
        let at = |k: usize| (2..6).map(|j| matrix[(i, j)] * q[j][k]).sum();
        (0..SAMPLES).map(at).collect()
    };
    let still = vec![vec![0.0; SAMPLES]; 2];
    let recording = Recording::of_samples(
        "kr150",
        still.iter().cloned().chain((2..6).map(motor)).collect(),
        still.iter().cloned().chain(tau).collect(),
    );
    let preparation = Preparation {
        rate: Some(RATE_HZ),
        period: Some(SAMPLES as f64 / RATE_HZ),
        ..Preparation::default()
    };
    let experiment = prepare(recording, &preparation).ok()?;
    let prepared = Prepared::new("kr150".into(), Split::Train, true, experiment);
    Some(Dataset {
        recordings: vec![prepared],
    })
}

/// A model and what is unknown of it.
type Case = (Model, Unknowns);

/// The linear optimum with a lossless gear, then all unknowns from there.
fn fit((lossless, linear): &Case, (model, unknowns): &Case, data: &Dataset) -> Solution {
    let prior = Prior::none(model.parameters().len());
    let recordings: Vec<&Prepared> = data.recordings.iter().collect();
    let deviations: Vec<f64> = [1.0, 1.0].into_iter().chain(NOISE).collect();
    let weights = Weights::by_deviation(&deviations);
    let problem = FitProblem::new(
        model,
        unknowns,
        Training {
            recordings: &recordings,
            prior: &prior,
        },
        weights,
    );
    let lossless = problem.with_unknowns(lossless, linear);
    let view = LeastSquares::try_from(&lossless as &dyn Problem).expect("a sum of squares");
    let start = linear::solve(view, &lossless.start(), &linear::Settings::default())
        .expect("a start within bounds")
        .solution
        .x;
    let mut from = problem.start();
    from.rows_mut(0, start.len()).copy_from(&start);
    let settings = levenberg_marquardt::Settings {
        cost_tolerance: 1e-12,
        ..levenberg_marquardt::Settings::default()
    };
    let view = LeastSquares::try_from(&problem as &dyn Problem).expect("a sum of squares");
    levenberg_marquardt::minimize(view, &from, &settings, &Control::default())
        .expect("a start within bounds")
}

fn bench(criterion: &mut Criterion) {
    let shared = env::var_os("EXID_DATA").unwrap_or_else(|| "../shared".into());
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join(shared)
        .join("bench/problems/kr150_like.urdf");
    let folder = PathBuf::from(env::var_os("BENCH_DATA").unwrap_or_else(|| "bench_data".into()))
        .join("kr150");
    let models = [&[][..], &["transmission_efficiency"]].map(|further| model(&file, further));
    let ([Some(lossless), Some(model)], Some(data)) = (models, data(&folder)) else {
        eprintln!(
            "skipped: no {} or no q.npy and tau.npy in {}",
            file.display(),
            folder.display()
        );
        return;
    };
    let case = |model: Model| -> Case {
        let prior = Prior::none(model.parameters().len());
        let unknowns = Unknowns::find(&model, &data, &prior);
        (model, unknowns)
    };
    let (lossless, whole) = (case(lossless), case(model));
    let solution = fit(&lossless, &whole, &data);
    eprintln!(
        "{} unknowns, {} iterations, {} evaluations, cost {:.6}, mass {:.6} kg",
        solution.x.len(),
        solution.iterations,
        solution.evaluations,
        solution.cost,
        solution.x[0]
    );
    criterion.bench_function("payload, load regressor, start and fit", |b| {
        b.iter(|| fit(black_box(&lossless), black_box(&whole), black_box(&data)));
    });
}

criterion_group!(benches, bench);
criterion_main!(benches);
