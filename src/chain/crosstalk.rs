//! Pairs of joints of which the channel of one records a share of the signal of the other, `s = (1 + X) y`.

/// An entry of X.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Heard {
    /// The joint whose channel hears the other.
    pub channel: usize,
    /// The joint that is heard.
    pub source: usize,
}
