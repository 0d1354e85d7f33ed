//! The stages of a diagnosis, as progress shows them.

/// A step of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Before the robot, its simulator goes through the same steps.
    Simulator,
    /// Recordings are read, differentiated and averaged over periods.
    Reading,
    /// The declared model is fitted.
    Fitting,
    /// Hypotheses are screened and fitted beside what was found.
    Searching {
        /// Findings so far.
        found: usize,
        /// Hypotheses that are open beside them.
        hypotheses: usize,
    },
    /// Rivals are fitted in the place of findings.
    Comparing,
    /// Averages over periods are taken apart for what changes between them.
    Drift,
}

impl Stage {
    /// As progress shows it.
    pub fn words(self) -> String {
        match self {
            Self::Simulator => "identifying the simulator".to_string(),
            Self::Reading => "reading and differentiating the recordings".to_string(),
            Self::Fitting => "fitting the declared model".to_string(),
            Self::Searching { found, hypotheses } => {
                format!("trying {hypotheses} hypotheses of what is missing ({found} found so far)")
            }
            Self::Drift => "looking at what changes from period to period".to_string(),
            Self::Comparing => "comparing what was found with its rivals".to_string(),
        }
    }
}
