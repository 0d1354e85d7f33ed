//! A rival in the place of every finding of one effect at once.
//!
//! A gear that loses a share of its load differs from friction that grows with the load by a share that has no direction:
//!
//! ```text
//! τ/R where the motor drives, τ R where it is driven  =  m τ ± c |τ|,   m = (1/R + R)/2,   c = (1/R − R)/2
//! ```
//!
//! and links that are m times as heavy take that share. They cannot where one joint alone is called by the other name, for the other
//! joints have weighed them too; where all joints are, they can, and no recording tells the two names apart.

use crate::diagnose::fit::fitting::fit_model;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::fit::start::Start;
use crate::diagnose::residuals::noise_level::NoiseLevel;
use crate::diagnose::selection::exact_fit::{is_possible, taken};
use crate::diagnose::selection::hypothesis_test::HypothesisTest;
use crate::diagnose::selection::rival_models::{Alternative, Comparing, RivalComparison};
use crate::diagnose::selection::stepwise::Stepwise;

/// A rival is tried in the place of all findings of one effect where in the place of each it takes this share of what the
/// finding takes: one of another shape gains nothing by the others.
const ALIKE: f64 = 0.5;

/// Findings of one effect, by their numbers.
struct SameEffect<'a> {
    full: &'a ModelFit,
    members: Vec<usize>,
}

impl<'a> SameEffect<'a> {
    /// Those of two findings or more.
    fn all(full: &'a ModelFit) -> Vec<Self> {
        let mut groups: Vec<Self> = Vec::new();
        for (k, found) in full.hypotheses.iter().enumerate() {
            let of =
                |other: &&mut Self| full.hypotheses[other.members[0]].effect.id == found.effect.id;
            match groups.iter_mut().find(of) {
                Some(group) => group.members.push(k),
                None => groups.push(Self {
                    full,
                    members: vec![k],
                }),
            }
        }
        groups.retain(|group| group.members.len() > 1);
        groups
    }

    /// Effects that come close in the place of each, with the number of the alternative that has it there.
    fn rivals(&self, comparisons: &[RivalComparison]) -> Vec<Vec<usize>> {
        let first = comparisons[self.members[0]].alternatives.iter();
        let places = first.filter_map(|rival| {
            let id = rival.test.hypothesis.effect.id;
            let of = |k: &usize| {
                let mut alternatives = comparisons[*k].alternatives.iter();
                alternatives.position(|other| {
                    other.test.hypothesis.effect.id == id
                        && self.is_alike(*k, &comparisons[*k], other)
                })
            };
            self.members.iter().map(of).collect()
        });
        places.collect()
    }

    /// Whether an alternative stands where the k-th finding does and takes about as much.
    fn is_alike(&self, k: usize, comparison: &RivalComparison, rival: &Alternative) -> bool {
        let (found, instead) = (&self.full.hypotheses[k], &rival.test.hypothesis);
        let takes = |richer: &ModelFit| {
            taken(FitPair {
                poorer: &comparison.without,
                richer,
            })
        };
        found.joints == instead.joints
            && found.other == instead.other
            && takes(&rival.test.fit) >= ALIKE * takes(self.full)
    }

    /// The hypotheses of the model with rivals in all places, and where their parameters begin.
    fn exchanged(&self, rivals: &[&Alternative]) -> (Vec<Hypothesis>, Start) {
        let mut hypotheses = self.full.hypotheses.clone();
        let mut start = Start::new();
        for (&k, rival) in self.members.iter().zip(rivals) {
            hypotheses[k] = rival.test.hypothesis.clone();
            let own = rival.test.fit.start().into_iter();
            start.extend(own.filter(|(name, _)| self.full.model.position(name).is_none()));
        }
        (hypotheses, start)
    }
}

impl Stepwise<'_> {
    /// Puts the model with a rival in the place of all findings of one effect where it fits better than the one that has the
    /// rival in one place alone.
    pub fn in_all_places(
        &self,
        full: &ModelFit,
        comparisons: &mut [RivalComparison],
        noise_level: &NoiseLevel,
    ) {
        for group in SameEffect::all(full) {
            for places in group.rivals(comparisons) {
                let of = |(&k, &at): (&usize, &usize)| &comparisons[k].alternatives[at];
                let rivals: Vec<&Alternative> = group.members.iter().zip(&places).map(of).collect();
                let (hypotheses, start) = group.exchanged(&rivals);
                let make = || fit_model(self.context, &hypotheses, &full.warm_start().with(&start));
                // A model that cannot be fitted is none.
                let Ok(fit) = self.context.cache.fit_model(&hypotheses, make) else {
                    continue;
                };
                let is_possible =
                    |&k: &usize| is_possible(self.context, &fit, &hypotheses[k], &start);
                if !group.members.iter().all(is_possible) {
                    continue;
                }
                for (&k, &at) in group.members.iter().zip(&places) {
                    let comparison = &mut comparisons[k];
                    if fit.fitted_score() >= comparison.alternatives[at].test.fit.fitted_score() {
                        continue;
                    }
                    let comparing = Comparing {
                        full,
                        finding: &full.hypotheses[k],
                        noise_level,
                        tests: comparison.tried,
                    };
                    let mut fit = fit.clone();
                    let rival = fit.hypotheses.remove(k);
                    fit.hypotheses.push(rival.clone());
                    let test = HypothesisTest::of(self.context, &comparison.without, fit, rival);
                    let test = test.corrected_for(comparison.tried);
                    comparison.alternatives[at] = self.alternative(&comparing, test);
                }
            }
        }
    }
}
