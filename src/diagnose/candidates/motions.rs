//! The motions along which hypotheses are looked at: as recorded, with what the bodies do along them, and as late as signals are.

use crate::chain::dataset::Prepared;
use crate::chain::evaluate::Evaluator;
use crate::diagnose::candidates::signal_path::SignalPath;
use crate::diagnose::fit::channel_series::ChannelSeries;
use crate::diagnose::fit::model_fit::ModelFit;
use std::sync::OnceLock;

/// Recordings beside the motions that looks at hypotheses ask for.
pub struct Motions<'a> {
    fit: &'a ModelFit,
    path: SignalPath,
    recorded: Vec<Prepared>,
    /// With what the bodies do, which laws of drives leave as it is; made when first needed.
    known: OnceLock<Vec<Prepared>>,
    /// Beside motions as late as the signal of a joint, by joint; made when first needed.
    late: Vec<OnceLock<Vec<Prepared>>>,
    all_late: Option<AllLate>,
}

/// Recordings beside motions as late as signals are on the average, along which the fitted model is on time.
pub struct AllLate {
    /// Without what the bodies do.
    pub recordings: Vec<Prepared>,
    /// With it.
    pub known: Vec<Prepared>,
    /// What the fitted model predicts along them, `[channel][row]`.
    pub predicted: Vec<Vec<f64>>,
}

impl<'a> Motions<'a> {
    /// Of recordings beside a model that was fitted, with the path of its signals.
    pub fn new(fit: &'a ModelFit, path: SignalPath, recorded: Vec<Prepared>) -> Self {
        let mut motions = Self {
            fit,
            path,
            recorded,
            known: OnceLock::new(),
            late: vec![OnceLock::new(); fit.model.joints().len()],
            all_late: None,
        };
        // Made here, not when first asked for: what it takes is worked out in parallel, as hypotheses are.
        motions.all_late = motions.beside_mean_delay();
        motions
    }

    /// As recorded.
    pub fn recorded(&self) -> &[Prepared] {
        &self.recorded
    }

    /// With what the bodies do.
    pub fn known(&self) -> &[Prepared] {
        let with_bodies = |r: &Prepared| self.with_bodies(r);
        let make = || self.recorded.iter().map(with_bodies).collect();
        self.known.get_or_init(make)
    }

    /// Beside motions as late as the signal of a joint, with what the bodies do.
    pub fn late(&self, joint: usize) -> &[Prepared] {
        let delay = self.delay(joint);
        let moved = |r: &Prepared| self.with_bodies(&r.late_by(delay));
        let make = || self.recorded.iter().map(moved).collect();
        self.late[joint].get_or_init(make)
    }

    /// Beside motions as late as all signals are on the average; `None` where they are not late alike: a look at a hypothesis asks
    /// for it within the time between two samples, in which derivatives change little.
    pub fn all_late(&self) -> Option<&AllLate> {
        self.all_late.as_ref()
    }

    fn beside_mean_delay(&self) -> Option<AllLate> {
        if self.path != SignalPath::Late {
            return None;
        }
        let channels = self.fit.model.channels().iter();
        let delay = |joint: Option<usize>| joint.map_or(0.0, |joint| self.delay(joint));
        let delays: Vec<f64> = channels.map(|channel| delay(channel.joint)).collect();
        let mean = delays.iter().sum::<f64>() / delays.len().max(1) as f64;
        let off = delays.iter().map(|delay| (delay - mean).abs());
        let off = off.fold(0.0, f64::max);
        let are_alike = |r: &Prepared| off <= 0.5 * r.segment().step();
        if !self.recorded.iter().all(are_alike) {
            return None;
        }
        let recordings: Vec<Prepared> = self.recorded.iter().map(|r| r.late_by(mean)).collect();
        let mut model = self.fit.model.clone();
        model.predict_on_time();
        let along: Vec<&Prepared> = recordings.iter().collect();
        Some(AllLate {
            known: recordings.iter().map(|r| self.with_bodies(r)).collect(),
            predicted: ChannelSeries::of(&model, &self.fit.values, &[], &along).predicted,
            recordings,
        })
    }

    /// By how much the signal of a joint is late, s.
    fn delay(&self, joint: usize) -> f64 {
        let delay = self.fit.model.joints()[joint].delay;
        delay.map_or(0.0, |at| self.fit.values[at])
    }

    /// A recording with what the bodies of the fitted model do along it.
    fn with_bodies(&self, recording: &Prepared) -> Prepared {
        let rows = recording.experiment.rows();
        let mut evaluator = Evaluator::along(&self.fit.model, &self.fit.values, &[], rows);
        let bodies = match self.path {
            SignalPath::Lagging => evaluator.settled_bodies(recording.whole()),
            SignalPath::Simple | SignalPath::Late | SignalPath::Other => {
                evaluator.known_bodies(recording.whole())
            }
        };
        recording.clone().with_bodies(bodies)
    }
}
