//! Sums over the blocks of rows between which the test of models sees its variance, and how they are concentrated.

/// Sums over rows of the instrument z, the poorer residual e and the difference d of what two models predict.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    /// Σ z e.
    pub residual: f64,
    /// Σ z d.
    pub difference: f64,
    /// Σ z².
    pub instrument: f64,
}

impl Sums {
    /// Over all blocks.
    pub fn of(blocks: &[Self]) -> Self {
        let sum = |of: &dyn Fn(&Self) -> f64| blocks.iter().map(of).sum();
        Self {
            residual: sum(&|block| block.residual),
            difference: sum(&|block| block.difference),
            instrument: sum(&|block| block.instrument),
        }
    }

    /// b.
    pub fn slope(self) -> f64 {
        self.residual / self.difference
    }
}

/// How what instruments tell is concentrated in blocks, with the share a of a block in Σ z² and s in Σ z d.
///
/// In noise that is alike in all rows the scores of blocks, `Σ z (e − b d)`, have the covariance `diag(a) − s aᵀ − a sᵀ + s sᵀ`, in units
/// of that of `Σ z e`, as the slope was fitted to them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Concentration {
    /// Σ a².
    instrument: f64,
    /// Trace of that covariance: what blocks show of the variance.
    pub shown: f64,
    /// Trace of its square.
    square: f64,
}

impl Concentration {
    pub fn of(blocks: &[Sums], total: Sums) -> Self {
        let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            let shares = blocks.iter().map(|block| {
                let instrument = block.instrument / total.instrument;
                of(instrument, block.difference / total.difference)
            });
            shares.sum()
        };
        let (aa, az, ss) = (sum(&|a, _| a * a), sum(&|a, s| a * s), sum(&|_, s| s * s));
        let mixed = sum(&|a, s| 2.0 * a * s * s - 4.0 * a * a * s);
        Self {
            instrument: aa,
            shown: 1.0 - 2.0 * az + ss,
            square: aa + mixed + 2.0 * az * az + ss * ss + 2.0 * aa * ss - 4.0 * az * ss,
        }
    }

    /// Degrees of freedom of the variance that blocks show: those of Satterthwaite (1946) in noise that is alike in all rows (Bell and
    /// McCaffrey 2002), and no more than the effective number of blocks but one, as noise may differ between blocks.
    pub fn freedom(self) -> f64 {
        (1.0 / self.instrument - 1.0).min(self.shown * self.shown / self.square)
    }
}
