//! From a motion to the triangular factor of its least squares problem: regressor, friction, weighting and
//! compression by QR of 100 000 samples of a seven-joint arm, in memory that does not grow with them.

use criterion::{Criterion, criterion_group, criterion_main};
use exid::chain::dataset::{Dataset, Prepared};
use exid::chain::effect;
use exid::chain::model::Model;
use exid::chain::prior::Prior;
use exid::estimate::compress::{Request, factor};
use exid::estimate::unknowns::Unknowns;
use exid::estimate::weights::Weights;
use exid::problem_file::ProblemFile;
use exid::recording::preprocess::prepare;
use exid::recording::samples::Recording;
use exid::recording::settings::{Differentiation, Preparation};
use exid::recording::split::Split;
use exid::robot::random::{generator, symmetric};
use exid::setup;
use exid::setup::model_spec::ModelSpec;
use std::hint::black_box;
use std::path::Path;

const SAMPLES: usize = 100_000;
const JOINTS: usize = 7;
const RATE_HZ: f64 = 1000.0;
/// High enough for every row to be used.
const CUTOFF_HZ: f64 = 400.0;

/// The shipped seven-joint arm with friction, w known, so that the columns do not depend on values.
fn model() -> Model {
    let widths: String = (1..=JOINTS)
        .map(|j| format!("\"joint{j}.coulomb_friction.w\" = 0.0\n"))
        .collect();
    let text = format!(
        "name = \"arm\"\n[robot]\nmdh = \"panda_like.mdh.toml\"\n\
         [drive]\neffects = [\"coulomb_friction\", \"viscous_friction\"]\n[drive.values]\n{widths}"
    );
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/panda_like");
    let problem = ProblemFile::parse(&folder.join("arm.toml"), &text, &[], &effect::ids())
        .expect("the problem is complete");
    let robot = setup::robot::open(&problem).expect("the shipped robot file is valid");
    let declared = ModelSpec::without_prior(&problem, &robot);
    let built = declared.and_then(|declared| declared.build());
    built.expect("the model is valid").model
}

/// States at random.
fn data() -> Dataset {
    let mut rng = generator(4);
    let mut series = |range: f64| -> Vec<Vec<f64>> {
        (0..JOINTS)
            .map(|_| (0..SAMPLES).map(|_| symmetric(&mut rng, range)).collect())
            .collect()
    };
    let recording = Recording {
        velocity: Some(series(2.0)),
        acceleration: Some(series(10.0)),
        ..Recording::of_samples("random", series(2.5), series(20.0))
    };
    let preparation = Preparation {
        rate: Some(RATE_HZ),
        period: None,
        differentiation: Differentiation {
            cutoff_hz: Some(CUTOFF_HZ),
            ..Differentiation::default()
        },
    };
    let experiment = prepare(recording, &preparation).expect("an even recording");
    Dataset {
        recordings: vec![Prepared::new(
            "random".into(),
            Split::Train,
            false,
            experiment,
        )],
    }
}

fn recording_to_factor(criterion: &mut Criterion) {
    // One thread, as the peers are measured.
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build_global()
        .expect("no pool has been built before");
    let (model, data) = (model(), data());
    let prior = Prior::none(model.parameters().len());
    let unknowns = Unknowns::find(&model, &data, &prior);
    let columns = unknowns.positions();
    let weights = Weights::by_deviation(&[2.0, 3.0, 2.0, 2.0, 0.5, 0.4, 0.3]);
    let values = model.values();
    let request = Request {
        model: &model,
        values: &values,
        columns: &columns,
        weights: &weights,
        factors: None,
        bodies: &[],
    };
    let recordings: Vec<&Prepared> = data.recordings.iter().collect();
    let rows = recordings[0].rows();
    let mut group = criterion.benchmark_group("recording to factor");
    group.sample_size(20);
    group.bench_function(
        format!("{rows} samples, {} columns", columns.len()),
        |bencher| {
            bencher.iter(|| black_box(factor(&request, &recordings)));
        },
    );
    group.finish();
}

criterion_group!(benches, recording_to_factor);
criterion_main!(benches);
