//! The kernel of the streaming QR: Householder reflections of [R; B] that touch row k of R and a tile B.
//!
//! With alpha = R_kk and b the k-th column of B, the reflection I - gamma v vᵀ, v = (alpha - beta, b),
//! beta = -sign(alpha) sqrt(alpha² + bᵀb), gamma = 1 / (beta (beta - alpha)), takes (alpha, b) to (beta, 0).
//! Source: Golub and Van Loan (2013), section 5.1.

use crate::linalg::lanes::instructions::{self, InstructionSet, Kernel};
use crate::linalg::lanes::lane::{LANES, Lanes};
use std::array;

/// Octets per column of a tile: a column fits in a quarter of the AVX-512 registers.
const OCTETS: usize = 8;

/// Rows of a tile.
pub(super) const TILE_ROWS: usize = LANES * OCTETS;

/// Columns to which a reflection is applied together, so that their sums overlap.
const GROUP: usize = 4;

/// A square below this counts as zero: the factor gamma of its reflection would overflow.
const SMALLEST_SQUARE: f64 = 1e-290;

/// Eight doubles, aligned for every instruction set.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Octet(pub [f64; LANES]);

/// One column of a tile.
pub(super) type Column = [Octet; OCTETS];

/// A column of zeros.
pub(super) const ZERO_COLUMN: Column = [Octet([0.0; LANES]); OCTETS];

/// Updates R (p x p, row-major) so that RᵀR gains BᵀB; destroys the tile B (p columns).
pub(super) fn absorb_tile(r: &mut [f64], tile: &mut [Column]) {
    instructions::run(Absorption { r, tile }, InstructionSet::detect());
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
    let mut even = V::constant(0.0);
    let mut odd = V::constant(0.0);
    for pair in column.as_chunks::<2>().0 {
        let (a, b) = (V::from_array(pair[0].0), V::from_array(pair[1].0));
        even = a.mul_add(a, even);
        odd = b.mul_add(b, odd);
    }
    let square = even.mul_add(V::constant(1.0), odd).sum();
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
    let mut sums = [V::constant(0.0); N];
    for i in 0..OCTETS {
        for (sum, column) in sums.iter_mut().zip(columns.iter()) {
            *sum = V::from_array(column[i].0).mul_add(b[i], *sum);
        }
    }
    for ((sum, column), entry) in sums.iter().zip(columns.iter_mut()).zip(row.iter_mut()) {
        let c = of.gamma * (of.first * *entry + sum.sum());
        *entry -= c * of.first;
        let minus_c = V::constant(-c);
        for i in 0..OCTETS {
            column[i].0 = minus_c.mul_add(b[i], V::from_array(column[i].0)).to_array();
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

/// A tile B to be absorbed by R.
struct Absorption<'a> {
    r: &'a mut [f64],
    tile: &'a mut [Column],
}

impl Kernel for Absorption<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Lanes>(self) {
        let Self { r, tile } = self;
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
            let b: [V; OCTETS] = array::from_fn(|i| V::from_array(done[k][i].0));
            if let Some(current) = current {
                diagonal[0] = current.beta;
                apply_to_all(current, &b, near_row, near_columns);
            }
            // The next reflection needs its own column only: its root and quotient overlap with the far columns.
            // No closure: one that is not inlined is compiled without the kernel's instructions.
            next = match near_columns.first() {
                Some(column) => reflection::<V>(lower[k + 1], column),
                None => None,
            };
            if let Some(current) = current {
                apply_to_all(current, &b, far_row, far_columns);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_every_kernel_keeps_the_gram_matrix() {
        for set in [
            InstructionSet::Baseline,
            InstructionSet::Avx2,
            InstructionSet::Avx512,
        ] {
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
                    let absorption = Absorption {
                        r: &mut r,
                        tile: &mut tile,
                    };
                    instructions::run(absorption, set);
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
                            "{set:?} {order}"
                        );
                    }
                }
            }
        }
    }
}
