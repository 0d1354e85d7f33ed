//! Joint-torque regressor of a seven-joint arm: one sample at a time, and samples in vector lanes.
//! Divide the times by [`SAMPLES`] for the time of one regressor.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use exid::robot::batch::{RegressorBatch, Trajectory};
use exid::robot::mdh;
use exid::robot::random::{generator, symmetric};
use exid::robot::regressor::Rows;
use exid::robot::sample_regressor::SampleRegressor;
use nalgebra::DMatrix;
use std::hint::black_box;
use std::path::Path;

/// States that stay in cache, as many as in the peers' measurements.
const SAMPLES: usize = 4096;

fn states(n: usize) -> [Vec<Vec<f64>>; 3] {
    let mut rng = generator(1);
    [3.0, 2.0, 10.0].map(|range| {
        (0..n)
            .map(|_| (0..SAMPLES).map(|_| symmetric(&mut rng, range)).collect())
            .collect()
    })
}

fn regressor(criterion: &mut Criterion) {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/panda_like/panda_like.mdh.toml");
    let tree = mdh::read(&path).expect("the shipped robot file is valid");
    let n = tree.len();
    let [q, dq, ddq] = states(n);
    let mut group = criterion.benchmark_group("joint torque regressor, 7 joints");
    group.throughput(Throughput::Elements(SAMPLES as u64));

    let by_sample = |series: &[Vec<f64>]| -> Vec<Vec<f64>> {
        (0..SAMPLES)
            .map(|k| series.iter().map(|s| s[k]).collect())
            .collect()
    };
    let (q1, dq1, ddq1) = (by_sample(&q), by_sample(&dq), by_sample(&ddq));
    let mut single = SampleRegressor::new(&tree, Rows::Torque);
    let mut matrix = DMatrix::zeros(n, 10 * n);
    group.bench_function("one sample at a time", |bencher| {
        bencher.iter(|| {
            for k in 0..SAMPLES {
                single.fill(&tree, [&q1[k], &dq1[k], &ddq1[k]], &mut matrix);
                black_box(&matrix);
            }
        });
    });

    let trajectory = Trajectory {
        q: &q,
        dq: &dq,
        ddq: &ddq,
    };
    const BLOCK: usize = 64;
    let mut batch = RegressorBatch::new(&tree, Rows::Torque, BLOCK);
    group.bench_function("in batches", |bencher| {
        bencher.iter(|| {
            for start in (0..SAMPLES).step_by(BLOCK) {
                batch.evaluate(&tree, trajectory, start..start + BLOCK);
                black_box(&batch);
            }
        });
    });
    group.finish();
}

criterion_group!(benches, regressor);
criterion_main!(benches);
