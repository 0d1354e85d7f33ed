//! The kernel of the streaming QR: Householder reflections of [R; B] that touch row k of R and a tile B.
//!
//! With alpha = R_kk and b the k-th column of B, the reflection I - gamma v vᵀ, v = (alpha - beta, b),
//! beta = -sign(alpha) sqrt(alpha² + bᵀb), gamma = 1 / (beta (beta - alpha)), takes (alpha, b) to (beta, 0).
//! Source: Golub and Van Loan (2013), section 5.1.

#![allow(
    unsafe_code,
    reason = "vector instructions, which run where the processor has them"
)]

use std::array;

/// Doubles handled together: one AVX-512 register, two of AVX2.
pub(super) const WIDTH: usize = 8;

/// Octets per column of a tile: a column fits in a quarter of the AVX-512 registers.
const OCTETS: usize = 8;

/// Rows of a tile.
pub(super) const TILE_ROWS: usize = WIDTH * OCTETS;

/// Columns to which a reflection is applied together, so that their sums overlap.
const GROUP: usize = 4;

/// A square below this counts as zero: the factor gamma of its reflection would overflow.
const SMALLEST_SQUARE: f64 = 1e-290;

/// Eight doubles, aligned for every instruction set.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Octet(pub [f64; WIDTH]);

/// One column of a tile.
pub(super) type Column = [Octet; OCTETS];

/// A column of zeros.
pub(super) const ZERO_COLUMN: Column = [Octet([0.0; WIDTH]); OCTETS];

/// Updates R (p x p, row-major) so that RᵀR gains BᵀB; destroys the tile B (p columns).
pub(super) fn absorb_tile(r: &mut [f64], tile: &mut [Column]) {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") {
            // SAFETY: the processor has the instructions that the function is compiled for.
            return unsafe { x86::absorb_tile_avx512(r, tile) };
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            // SAFETY: as above.
            return unsafe { x86::absorb_tile_avx2(r, tile) };
        }
    }
    absorb_tile_with::<Octet>(r, tile);
}

/// Arithmetic on eight doubles.
trait Lanes: Copy {
    fn load(from: &Octet) -> Self;
    fn store(self, to: &mut Octet);
    fn splat(value: f64) -> Self;
    /// self * factor + term.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    fn sum(self) -> f64;
}

impl Lanes for Octet {
    #[inline(always)]
    fn load(from: &Octet) -> Self {
        *from
    }

    #[inline(always)]
    fn store(self, to: &mut Octet) {
        *to = self;
    }

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Octet([value; WIDTH])
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        let mut out = term;
        for i in 0..WIDTH {
            out.0[i] += self.0[i] * factor.0[i];
        }
        out
    }

    #[inline(always)]
    fn sum(self) -> f64 {
        let s = self.0;
        ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]))
    }
}

/// The scalars of one reflection; `None` where the column is zero already.
#[derive(Clone, Copy)]
struct Reflection {
    /// The new diagonal entry.
    beta: f64,
    /// First entry of v: alpha - beta.
    first: f64,
    gamma: f64,
}

#[inline(always)]
fn reflection<V: Lanes>(alpha: f64, column: &Column) -> Option<Reflection> {
    let mut even = V::splat(0.0);
    let mut odd = V::splat(0.0);
    for pair in column.as_chunks::<2>().0 {
        let (a, b) = (V::load(&pair[0]), V::load(&pair[1]));
        even = a.mul_add(a, even);
        odd = b.mul_add(b, odd);
    }
    let square = even.mul_add(V::splat(1.0), odd).sum();
    if square < SMALLEST_SQUARE {
        return None;
    }
    let beta = -(alpha * alpha + square).sqrt().copysign(alpha);
    let first = alpha - beta;
    Some(Reflection {
        beta,
        first,
        gamma: -1.0 / (beta * first),
    })
}

/// Applies a reflection to N columns and their entries in row k of R.
#[inline(always)]
fn apply<V: Lanes, const N: usize>(
    of: Reflection,
    b: &[V; OCTETS],
    row: &mut [f64; N],
    columns: &mut [Column; N],
) {
    let mut sums = [V::splat(0.0); N];
    for i in 0..OCTETS {
        for (sum, column) in sums.iter_mut().zip(columns.iter()) {
            *sum = V::load(&column[i]).mul_add(b[i], *sum);
        }
    }
    for ((sum, column), entry) in sums.iter().zip(columns.iter_mut()).zip(row.iter_mut()) {
        let c = of.gamma * (of.first * *entry + sum.sum());
        *entry -= c * of.first;
        let minus_c = V::splat(-c);
        for i in 0..OCTETS {
            minus_c
                .mul_add(b[i], V::load(&column[i]))
                .store(&mut column[i]);
        }
    }
}

/// Applies a reflection to any number of columns, in groups.
#[inline(always)]
fn apply_to_all<V: Lanes>(
    of: Reflection,
    b: &[V; OCTETS],
    row: &mut [f64],
    columns: &mut [Column],
) {
    let (row_groups, row_tail) = row.as_chunks_mut::<GROUP>();
    let (groups, tail) = columns.as_chunks_mut::<GROUP>();
    for (entries, columns) in row_groups.iter_mut().zip(groups) {
        apply(of, b, entries, columns);
    }
    for (entry, column) in row_tail.iter_mut().zip(tail) {
        apply(of, b, array::from_mut(entry), array::from_mut(column));
    }
}

#[inline(always)]
fn absorb_tile_with<V: Lanes>(r: &mut [f64], tile: &mut [Column]) {
    let order = tile.len();
    let mut next = match (tile.first(), r.first()) {
        (Some(column), Some(alpha)) => reflection::<V>(*alpha, column),
        _ => return,
    };
    for k in 0..order {
        let (done, columns) = tile.split_at_mut(k + 1);
        let (upper, lower) = r.split_at_mut((k + 1) * order);
        let (diagonal, row) = upper[k * order + k..].split_at_mut(1);
        let near = GROUP.min(row.len());
        let (near_row, far_row) = row.split_at_mut(near);
        let (near_columns, far_columns) = columns.split_at_mut(near);
        let current = next;
        let b: [V; OCTETS] = array::from_fn(|i| V::load(&done[k][i]));
        if let Some(current) = current {
            diagonal[0] = current.beta;
            apply_to_all(current, &b, near_row, near_columns);
        }
        // The next reflection needs its own column only: its root and quotient overlap with the far columns.
        next = near_columns
            .first()
            .and_then(|column| reflection::<V>(lower[k + 1], column));
        if let Some(current) = current {
            apply_to_all(current, &b, far_row, far_columns);
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    //! The same arithmetic in registers of 512 and 256 bits; callers have detected the instructions.

    use std::arch::x86_64::*;

    use super::{Column, Lanes, Octet, WIDTH, absorb_tile_with};

    #[target_feature(enable = "avx512f")]
    pub(super) fn absorb_tile_avx512(r: &mut [f64], tile: &mut [Column]) {
        absorb_tile_with::<Avx512>(r, tile);
    }

    #[target_feature(enable = "avx2,fma")]
    pub(super) fn absorb_tile_avx2(r: &mut [f64], tile: &mut [Column]) {
        absorb_tile_with::<Avx2>(r, tile);
    }

    #[derive(Clone, Copy)]
    struct Avx512(__m512d);

    #[derive(Clone, Copy)]
    struct Avx2(__m256d, __m256d);

    // SAFETY, for all methods below: the types are built in `absorb_tile_with` only, which is inlined into
    // the two functions above, and an `Octet` is eight doubles aligned to 64 bytes.
    impl Lanes for Avx512 {
        #[inline(always)]
        fn load(from: &Octet) -> Self {
            unsafe { Self(_mm512_load_pd(from.0.as_ptr())) }
        }

        #[inline(always)]
        fn store(self, to: &mut Octet) {
            unsafe { _mm512_store_pd(to.0.as_mut_ptr(), self.0) }
        }

        #[inline(always)]
        fn splat(value: f64) -> Self {
            unsafe { Self(_mm512_set1_pd(value)) }
        }

        #[inline(always)]
        fn mul_add(self, factor: Self, term: Self) -> Self {
            unsafe { Self(_mm512_fmadd_pd(self.0, factor.0, term.0)) }
        }

        #[inline(always)]
        fn sum(self) -> f64 {
            unsafe { _mm512_reduce_add_pd(self.0) }
        }
    }

    impl Lanes for Avx2 {
        #[inline(always)]
        fn load(from: &Octet) -> Self {
            let (low, high) = from.0.split_at(WIDTH / 2);
            unsafe { Self(_mm256_load_pd(low.as_ptr()), _mm256_load_pd(high.as_ptr())) }
        }

        #[inline(always)]
        fn store(self, to: &mut Octet) {
            let (low, high) = to.0.split_at_mut(WIDTH / 2);
            unsafe {
                _mm256_store_pd(low.as_mut_ptr(), self.0);
                _mm256_store_pd(high.as_mut_ptr(), self.1);
            }
        }

        #[inline(always)]
        fn splat(value: f64) -> Self {
            unsafe { Self(_mm256_set1_pd(value), _mm256_set1_pd(value)) }
        }

        #[inline(always)]
        fn mul_add(self, factor: Self, term: Self) -> Self {
            unsafe {
                Self(
                    _mm256_fmadd_pd(self.0, factor.0, term.0),
                    _mm256_fmadd_pd(self.1, factor.1, term.1),
                )
            }
        }

        #[inline(always)]
        fn sum(self) -> f64 {
            unsafe {
                let pairs = _mm256_add_pd(self.0, self.1);
                let low = _mm256_castpd256_pd128(pairs);
                let two = _mm_add_pd(low, _mm256_extractf128_pd::<1>(pairs));
                _mm_cvtsd_f64(_mm_add_sd(two, _mm_unpackhi_pd(two, two)))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Kernel = fn(&mut [f64], &mut [Column]);

    /// The kernels that this processor can run.
    fn kernels() -> Vec<(&'static str, Kernel)> {
        let mut kernels: Vec<(&'static str, Kernel)> = vec![
            ("detected", absorb_tile),
            ("baseline", absorb_tile_with::<Octet>),
        ];
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            // SAFETY: detected above.
            kernels.push(("avx2", |r, tile| unsafe { x86::absorb_tile_avx2(r, tile) }));
        }
        kernels
    }

    #[test]
    fn invariant_every_kernel_keeps_the_gram_matrix() {
        for (name, kernel) in kernels() {
            for order in 0..=13 {
                let mut r = vec![0.0; order * order];
                let mut gram = vec![0.0; order * order];
                for pass in 0..3 {
                    let mut tile = vec![ZERO_COLUMN; order];
                    for (j, column) in tile.iter_mut().enumerate() {
                        for (i, value) in column.iter_mut().flat_map(|o| &mut o.0).enumerate() {
                            *value = ((i * 7 + j * j * 3 + pass * 11) as f64).sin();
                        }
                    }
                    let flat = |c: &Column| c.iter().flat_map(|o| o.0).collect::<Vec<f64>>();
                    for i in 0..order {
                        for j in 0..order {
                            let (a, b) = (flat(&tile[i]), flat(&tile[j]));
                            gram[i * order + j] +=
                                a.iter().zip(&b).map(|(a, b)| a * b).sum::<f64>();
                        }
                    }
                    kernel(&mut r, &mut tile);
                }
                for i in 0..order {
                    for j in 0..order {
                        let found: f64 = (0..=i.min(j))
                            .map(|k| r[k * order + i] * r[k * order + j])
                            .sum();
                        // Rows absorbed times rounding, each entry at most one.
                        let bound = 192.0 * 192.0 * f64::EPSILON;
                        assert!(
                            (found - gram[i * order + j]).abs() <= bound,
                            "{name} {order}"
                        );
                    }
                }
            }
        }
    }
}
