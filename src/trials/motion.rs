//! How the robot of a trial moves and what noise its currents have.
//!
//! ```text
//! x_k = ρ x_{k−1} + √(1 − ρ²) e_k      noise of a current; ρ = 0 where it is white
//! f_c = (1 − ρ) f / 2π                 corner of its spectrum at the rate f
//! ```

use crate::robot::random::between;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A kind of motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// A Fourier series, several periods, the period declared.
    Fourier,
    /// The same with no period declared: it has to be found in the recordings.
    FourierUnstated,
    /// Sines that have no common period.
    Tones,
    /// From pose to pose with short rests.
    Moves,
    /// Sines of growing frequency.
    Sweeps,
}

impl Motion {
    /// All of them, in the order of results.
    pub const ALL: [Self; 5] = [
        Self::Fourier,
        Self::FourierUnstated,
        Self::Tones,
        Self::Moves,
        Self::Sweeps,
    ];

    /// The name on the command line and in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fourier => "fourier",
            Self::FourierUnstated => "fourier_unstated",
            Self::Tones => "tones",
            Self::Moves => "moves",
            Self::Sweeps => "sweeps",
        }
    }

    /// Whether a period comes again and again.
    pub fn repeats(self) -> bool {
        matches!(self, Self::Fourier | Self::FourierUnstated)
    }

    /// Whether the declared problem has a period.
    pub fn states_period(self) -> bool {
        self == Self::Fourier
    }

    /// `simulate.trajectory` of the motion.
    pub fn trajectory(self) -> &'static str {
        match self.repeats() {
            true => "random",
            false => self.name(),
        }
    }
}

/// A kind of noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Noise {
    /// Every sample has its own.
    White,
    /// Neighbouring samples are alike.
    Red,
}

/// Share of the trials whose noise is red, where both kinds are drawn: enough for a verdict on it in some hundred
/// trials; the rest is the noise that the counts of samples are right for.
const RED: f64 = 1.0 / 3.0;

/// Correlation of neighbouring samples of red noise. At 100 Hz its corner lies between 3.2 and 0.32 Hz: within the motions,
/// whose highest frequencies are 0.6 to 1 Hz, or shortly above.
const CORRELATIONS: (f64, f64) = (0.8, 0.98);

impl Noise {
    /// All of them, in the order of results.
    pub const ALL: [Self; 2] = [Self::White, Self::Red];

    /// The name on the command line and in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::White => "white",
            Self::Red => "red",
        }
    }

    /// One of the kinds.
    pub fn draw(rng: &mut ChaCha8Rng, kinds: &[Self]) -> Self {
        let red = rng.random::<f64>() < RED;
        match kinds {
            [one] => *one,
            _ if red => Self::Red,
            _ => Self::White,
        }
    }

    /// The correlation of neighbouring samples.
    pub fn correlation(self, rng: &mut ChaCha8Rng) -> f64 {
        match self {
            Self::White => 0.0,
            Self::Red => between(rng, CORRELATIONS.0, CORRELATIONS.1),
        }
    }
}
