//! How parameters follow from recordings, and which recordings and knowledge they follow from.

use crate::chain::dataset::Prepared;
use crate::chain::prior::Prior;

/// How parameters follow from recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Estimator {
    Ordinary,
    Weighted,
    Robust,
    MaximumLikelihood,
}

pub(crate) type Training<'a> = (&'a [&'a Prepared], &'a Prior);
