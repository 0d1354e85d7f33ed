//! Signals that are not what moved a joint: cut off at a limit of the sensor, or standing still while nothing else does.

use std::path::Path;

/// Why a signal is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Loss {
    /// It stands at its largest or its smallest value, beyond which nothing is recorded.
    Saturated,
    /// It does not change while the joint moves, as if the recorder had lost it.
    Stuck,
}

/// Samples at which one channel of a signal is lost.
#[derive(Debug, Clone, PartialEq)]
pub struct LostChannel {
    /// Index among the channels of the signal.
    pub channel: usize,
    /// Why.
    pub loss: Loss,
    /// The samples, in their order.
    pub samples: Vec<usize>,
    /// Values at which the signal stands there: limits, or that of the first sample.
    pub values: Vec<f64>,
    /// Whether the samples count for nothing. Where there are too many, nothing tells what is the fault and what is not.
    pub left_out: bool,
}

impl LostChannel {
    fn words(&self) -> String {
        let number = self.channel + 1;
        let count = self.samples.len();
        match self.loss {
            Loss::Saturated => format!("channel {number} stands at its limit in {count}"),
            Loss::Stuck => {
                format!("channel {number} does not change in {count} while the joint moves")
            }
        }
    }
}

/// Samples at which some channel of a signal is lost.
#[derive(Debug, Clone, PartialEq)]
pub struct LostSignal {
    /// Whether every channel is there, by sample.
    pub valid: Vec<bool>,
    /// The channels that are lost somewhere.
    pub channels: Vec<LostChannel>,
}

impl LostSignal {
    /// What a reader of any result should know; `None` where nothing is left out.
    pub fn words(&self, file: &Path) -> Option<String> {
        let left_out = self.channels.iter().filter(|lost| lost.left_out);
        let channels: Vec<String> = left_out.map(LostChannel::words).collect();
        let count = self.valid.iter().filter(|valid| !**valid).count();
        (count > 0).then(|| {
            format!(
                "{count} of the {} samples of {} are left out, as a signal does not say there what moves its joint: {}.",
                self.valid.len(),
                file.display(),
                channels.join("; ")
            )
        })
    }
}
