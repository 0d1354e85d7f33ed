//! Compression of a tall matrix to its R: the streaming QR against faer's QR in chunks of 4096 rows.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use exid::linalg::triangular::Triangular;
use faer::{Mat, MatRef, Par};

const ROWS: usize = 100_000;
/// Base parameters of a robot of six joints with friction.
const COLUMNS: usize = 46;
const CHUNK: usize = 4096;

/// Column-major, p columns of `rows` entries.
fn matrix(rows: usize) -> Vec<f64> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut uniform = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    (0..rows * COLUMNS).map(|_| uniform()).collect()
}

fn streaming(data: &[f64], rows_of_block: usize) -> Triangular {
    let mut r = Triangular::new(COLUMNS);
    let columns: Vec<&[f64]> = data.chunks_exact(ROWS).collect();
    for first in (0..ROWS).step_by(rows_of_block) {
        let last = ROWS.min(first + rows_of_block);
        let block: Vec<&[f64]> = columns.iter().map(|c| &c[first..last]).collect();
        r.absorb_columns(&block);
    }
    r
}

fn chunked_faer(data: &[f64]) -> Mat<f64> {
    let whole = MatRef::from_column_major_slice(data, ROWS, COLUMNS);
    let mut r = Mat::<f64>::zeros(COLUMNS, COLUMNS);
    for first in (0..ROWS).step_by(CHUNK) {
        let count = CHUNK.min(ROWS - first);
        let mut stack = Mat::<f64>::zeros(COLUMNS + count, COLUMNS);
        stack.as_mut().subrows_mut(0, COLUMNS).copy_from(&r);
        stack
            .as_mut()
            .subrows_mut(COLUMNS, count)
            .copy_from(whole.subrows(first, count));
        r.copy_from(stack.qr().thin_R());
    }
    r
}

fn compress(c: &mut Criterion) {
    faer::set_global_parallelism(Par::Seq);
    let data = matrix(ROWS);
    let mut group = c.benchmark_group("compress 100000 x 46");
    // Throughput in floating-point operations: 2 m p².
    group.throughput(Throughput::Elements((2 * ROWS * COLUMNS * COLUMNS) as u64));
    group.sample_size(20);
    group.bench_function("streaming", |b| {
        b.iter(|| streaming(black_box(&data), CHUNK))
    });
    group.bench_function("faer, 4096 rows", |b| {
        b.iter(|| chunked_faer(black_box(&data)))
    });
    group.finish();
}

criterion_group!(benches, compress);
criterion_main!(benches);
