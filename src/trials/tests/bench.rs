//! A trial whose recordings repeat, opened for tests of single steps of a diagnosis.

use crate::chain::dataset::{Dataset, Prepared};
use crate::chain::effect::find;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::problem::solution::Control;
use crate::recording::experiment::Experiment;
use crate::recording::split::Split;
use crate::trials::files::{PROBLEM, prepare};
use crate::trials::plan::{Plan, Scope};
use crate::trials::reference_fits::DeclaredModel;
use std::sync::Arc;

pub(super) const SIGNIFICANCE: f64 = 0.001;

/// Trials in which nothing is concealed.
pub(super) const CONTROLS: [u64; 2] = [4, 9];

/// Robots of three joints in motions that repeat.
pub(super) fn scope(effects: &[&'static str]) -> Scope {
    Scope {
        effects: effects.to_vec(),
        robots: vec!["arm3"],
        ..Scope::periodic(2)
    }
}

/// A trial of which every recording repeats, with its declared model fitted.
pub(super) struct Bench {
    pub opened: DeclaredModel,
    pub control: Control<'static>,
    pub plan: Plan,
}

impl Bench {
    /// One of the effects is concealed.
    pub fn new(effects: &[&'static str]) -> Self {
        Self::numbered(effects, 0)
    }

    /// The same in another trial.
    pub fn numbered(effects: &[&'static str], number: u64) -> Self {
        Self::of(Plan::draw(&scope(effects), number, 0))
    }

    /// Nothing is concealed.
    pub fn control() -> Self {
        let plan = Plan::draw(&scope(&["torque_offset"]), CONTROLS[0], 0);
        assert!(plan.concealed.is_empty());
        Self::of(plan)
    }

    fn of(plan: Plan) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let control = Control::default();
        prepare(&plan, folder.path(), &control).unwrap();
        let path = folder.path().join(PROBLEM);
        Self {
            opened: DeclaredModel::read(&path, &control).unwrap(),
            control,
            plan,
        }
    }

    pub fn declared(&self, data: &Dataset) -> ModelFit {
        self.fit(data, &[])
    }

    /// A fit of hypotheses beside the declared model.
    pub fn fit(&self, data: &Dataset, hypotheses: &[Hypothesis]) -> ModelFit {
        let fit = self
            .opened
            .fit(data, hypotheses, &Vec::new(), &self.control);
        fit.unwrap()
    }

    pub fn context<'b>(&'b self, data: &'b Dataset) -> Context<'b> {
        self.opened.context(data, &self.control)
    }

    /// The same recordings, those of some splits changed.
    pub fn changed(&self, splits: &[Split], change: impl Fn(&mut Experiment)) -> Dataset {
        let of = |recording: &Prepared| {
            let mut recording = recording.clone();
            if splits.contains(&recording.split) {
                change(Arc::make_mut(&mut recording.experiment));
            }
            recording
        };
        Dataset {
            recordings: self.opened.data.recordings.iter().map(of).collect(),
        }
    }

    /// The same with other signals.
    pub fn with_signals(&self, splits: &[Split], other: impl Fn(f64) -> f64) -> Dataset {
        self.changed(splits, |experiment| {
            let series = experiment.signal.iter_mut().flatten();
            series.for_each(|s| *s = other(*s));
        })
    }

    /// The same with something more in the signal of the first channel, in every split.
    pub fn with_added(&self, of: &dyn Fn(&Experiment, usize) -> f64) -> Dataset {
        self.changed(&[Split::Train, Split::Validation], |experiment| {
            let added: Vec<f64> = (0..experiment.rows()).map(|k| of(experiment, k)).collect();
            let pairs = experiment.signal[0].iter_mut().zip(added);
            pairs.for_each(|(s, by)| *s += by);
        })
    }
}

/// An effect of one joint.
pub(super) fn effect_of(id: &str, joint: usize) -> Hypothesis {
    Hypothesis {
        effect: find(id).unwrap(),
        joints: vec![joint],
        other: None,
    }
}

pub(super) fn offset(joint: usize) -> Hypothesis {
    effect_of("torque_offset", joint)
}

/// A fit that leaves as much in every held-out row of a channel.
pub(super) fn leaving(fit: &ModelFit, left: &[f64]) -> ModelFit {
    let mut fit = fit.clone();
    for (series, left) in fit.validation.iter_mut().zip(left) {
        series.fill(*left);
    }
    fit
}
