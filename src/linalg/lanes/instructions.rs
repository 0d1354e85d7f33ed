//! Instruction sets of the processor, and running a kernel compiled for each.

#![allow(
    unsafe_code,
    reason = "vector instructions, which run where the processor has them"
)]

use crate::linalg::lanes::lane::Lanes;
use crate::linalg::lanes::registers::Portable;
use std::sync::OnceLock;

/// Instruction sets that the kernels are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum InstructionSet {
    /// What every processor of the architecture has: two lanes of 64 bits on x86-64.
    Baseline,
    /// AVX2 with fused multiply-add: four lanes of 64 bits.
    Avx2,
    /// AVX-512: eight lanes of 64 bits.
    Avx512,
}

impl InstructionSet {
    /// The widest that this processor has.
    pub fn detect() -> Self {
        static FOUND: OnceLock<InstructionSet> = OnceLock::new();
        *FOUND.get_or_init(Self::ask)
    }

    #[cfg(target_arch = "x86_64")]
    fn ask() -> Self {
        let fma = std::arch::is_x86_feature_detected!("fma")
            && std::arch::is_x86_feature_detected!("avx2");
        if fma && std::arch::is_x86_feature_detected!("avx512f") {
            Self::Avx512
        } else if fma {
            Self::Avx2
        } else {
            Self::Baseline
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn ask() -> Self {
        Self::Baseline
    }
}

/// A computation that is written once for any lanes. `run` must be `#[inline(always)]`.
pub(crate) trait Kernel {
    type Output;
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Runs a kernel with the lanes of `set`, or of the widest set below it that the processor has.
pub(crate) fn run<K: Kernel>(kernel: K, set: InstructionSet) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    match set.min(InstructionSet::detect()) {
        // SAFETY: at most the set that was detected.
        InstructionSet::Avx512 => return unsafe { run_avx512(kernel) },
        // SAFETY: as above.
        InstructionSet::Avx2 => return unsafe { run_avx2(kernel) },
        InstructionSet::Baseline => {}
    }
    kernel.run::<Portable>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<crate::linalg::lanes::registers::Avx512>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<crate::linalg::lanes::registers::Avx2>()
}
