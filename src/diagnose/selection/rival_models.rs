//! Rival models: other hypotheses that explain the same misfit, and whether the held-out recordings tell them apart.

use crate::diagnose::error::DiagnoseError;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::contexts::Contexts;
use crate::diagnose::fit::fitting::fit_model;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::fit::start::Start;
use crate::diagnose::residuals::effect_size::{MATTERS, error_excess};
use crate::diagnose::residuals::noise_level::NoiseLevel;
use crate::diagnose::selection::exact_fit::{fit_without, taken};
use crate::diagnose::selection::forecast::{ComparedRows, forecast};
use crate::diagnose::selection::hypothesis_test::{CONFIDENCE, HypothesisTest, fits_better};
use crate::diagnose::selection::stepwise::{AlreadyTried, Stepwise};
use crate::stats::distribution::Distribution;
use crate::stats::encompassing::Encompassing;
use rayon::prelude::*;

/// Share of what a finding takes: where a rival that takes so much is told from it, weaker ones are.
const HALF: f64 = 0.5;

/// Confidence with which two models are told apart.
const TOLD_APART: f64 = 0.95;

/// A hypothesis in the place of a finding.
#[derive(Debug, Clone)]
pub struct Alternative {
    /// The model that has the alternative, as the last of its hypotheses, against the one with neither.
    pub test: HypothesisTest,
    /// The rows on which the difference of it and the finding is not small beside what neither explains.
    pub clear: Option<ComparedRows>,
    /// The alternative forecasts what the finding leaves, and where it has more parameters that matters and it fits
    /// better too; where it has fewer, it loses no more of what was fitted than it gains.
    pub better: bool,
}

/// An alternative as rows show it that test the finding.
#[derive(Debug, Clone)]
pub struct TestedRival {
    /// The model that has it, over these rows.
    pub test: HypothesisTest,
    /// Whether these rows tell it from the finding.
    pub separation: Separation,
}

/// The rivals of a finding as rows show them that test it.
#[derive(Debug, Clone)]
pub struct TestedRivals {
    /// The model without the finding.
    pub without: ModelFit,
    /// The other hypotheses, each in its place.
    pub rivals: Vec<TestedRival>,
}

impl TestedRivals {
    /// The rivals that the recordings cannot set aside.
    pub fn open(&self) -> impl Iterator<Item = &TestedRival> {
        let rivals = self.rivals.iter();
        rivals.filter(|rival| !rival.separation.separable)
    }
}

/// How far recordings tell a rival from a finding.
#[derive(Debug, Clone, Copy)]
pub struct Separation {
    /// Whether the finding forecasts what the rival leaves.
    pub evidence: Encompassing,
    /// The difference of the two is not small beside what neither explains.
    pub is_clear: bool,
    /// The finding forecasts what the rival leaves, or the rival's error is larger by what matters, and the difference is
    /// clear.
    pub separable: bool,
    /// Recordings of fewer than so many times the length tell the two apart in one case of twenty at most, by
    /// chance: the ratio of the test grows with the root of the length. `None` where the recordings
    /// do, or the two are the same torque.
    pub times_longer: Option<f64>,
}

impl Separation {
    /// ln Λ, of the likelihoods of the finding and of the rival: alike where what neither explains decides between them.
    pub fn log_likelihood_ratio(&self) -> f64 {
        match self.is_clear {
            true => self.evidence.log_likelihood_ratio(),
            false => 0.0,
        }
    }
}

/// A finding with the model that lacks it and what could stand in its place.
#[derive(Debug, Clone)]
pub struct RivalComparison {
    /// The model without the finding.
    pub without: ModelFit,
    /// The other hypotheses, each in its place.
    pub alternatives: Vec<Alternative>,
    /// Number of hypotheses of which they are the foremost.
    pub tried: usize,
}

/// A finding with what its rivals are held against.
#[derive(Clone, Copy)]
pub struct Comparing<'a> {
    /// The model with the finding.
    pub full: &'a ModelFit,
    /// What was found.
    pub finding: &'a Hypothesis,
    /// Of the rows that choose.
    pub noise_level: &'a NoiseLevel,
    /// Number of hypotheses that are tried in its place.
    pub tests: usize,
}

impl RivalComparison {
    /// The same as the rows show it that test the finding; whether a rival can be set aside, as all rows do and those that
    /// chose nothing confirm: among the others are those by which the finding was preferred. `full` is the model with the
    /// finding over all rows.
    pub fn on(
        &self,
        contexts: &Contexts<'_>,
        noise_level: &NoiseLevel,
        full: &ModelFit,
        finding: &Hypothesis,
    ) -> TestedRivals {
        let (rows, joints) = (contexts.testing(finding), finding.named_joints());
        let tested = full.on(rows);
        let [neither_on_all, neither] = [&contexts.whole, rows].map(|rows| self.without.on(rows));
        let seen = |alternative: &Alternative| {
            let (test, whole) = (&alternative.test, &contexts.whole);
            let seen_on_all = test.fit.on(whole);
            let seen = test.fit.on(rows);
            let pair = FitPair {
                poorer: opponent(&seen_on_all, &neither_on_all),
                richer: full,
            };
            let unchosen = FitPair {
                poorer: opponent(&seen, &neither),
                richer: &tested,
            };
            let clear = ComparedRows::clear(whole, noise_level, pair, &joints);
            let evidence = clear.unwrap_or(ComparedRows::All).forecast(rows, unchosen);
            let is_confirmed = evidence.p_value < 1.0 - TOLD_APART;
            let is_far = clear.is_some() && error_excess(pair, &joints) > MATTERS;
            let separation = match is_far && is_confirmed {
                true => Separation {
                    evidence,
                    is_clear: true,
                    separable: true,
                    times_longer: None,
                },
                false => {
                    let of_all = separation_on(whole, clear, pair, &joints);
                    Separation {
                        evidence,
                        separable: of_all.separable && is_confirmed,
                        ..of_all
                    }
                }
            };
            TestedRival {
                separation,
                test: HypothesisTest {
                    fit: seen,
                    ..test.clone()
                },
            }
        };
        TestedRivals {
            rivals: self.alternatives.par_iter().map(seen).collect(),
            without: neither,
        }
    }

    /// Alternatives that rows clearly find more probable than the finding, the most probable first; before, all are alike.
    /// Simpler ones that lose more of what was fitted than they gain are not among them.
    pub fn more_probable(&self, rows: &Context<'_>, full: &ModelFit) -> Vec<&Alternative> {
        let found = full.on(rows);
        let odds = |alternative: &Alternative, compared: ComparedRows| {
            let rival = alternative.test.fit.on(rows);
            let pair = FitPair {
                poorer: &rival,
                richer: &found,
            };
            -compared.forecast(rows, pair).log_likelihood_ratio()
        };
        let is_open = |alternative: &Alternative| {
            let rival = &alternative.test.fit;
            let pair = FitPair {
                poorer: rival,
                richer: full,
            };
            let is_simpler = rival.freedom() < full.freedom();
            !(is_simpler && is_likelier(pair))
        };
        let all = self.alternatives.par_iter().filter_map(|a| {
            let compared = a.clear.filter(|_| is_open(a))?;
            Some((a, odds(a, compared)))
        });
        let mut likelier: Vec<_> = all.filter(|(_, odds)| *odds > 0.0).collect();
        likelier.sort_by(|a, b| b.1.total_cmp(&a.1));
        likelier.into_iter().map(|(a, _)| a).collect()
    }
}

/// A finding in whose place there could stand what the recordings cannot set aside.
#[derive(Debug, Clone)]
pub struct Ambiguity {
    /// Number of the finding.
    pub finding: usize,
    /// The model with it.
    pub found: StatedModel,
    /// The models with each rival in its place.
    pub rivals: Vec<StatedModel>,
}

/// A fitted model without what it was fitted to.
#[derive(Debug, Clone)]
pub struct StatedModel {
    /// What it has beyond the declared model.
    pub hypotheses: Vec<Hypothesis>,
    /// Values of its parameters by name.
    pub start: Start,
}

impl StatedModel {
    fn of(fit: &ModelFit) -> Self {
        Self {
            hypotheses: fit.hypotheses.clone(),
            start: fit.start(),
        }
    }
}

/// The findings of a model that have rivals which cannot be set aside.
pub fn ambiguities(full: &ModelFit, comparisons: &[TestedRivals]) -> Vec<Ambiguity> {
    let each = comparisons.iter().enumerate();
    let found = each.filter_map(|(finding, comparison)| {
        let open = comparison.open();
        let rivals: Vec<StatedModel> = open.map(|a| StatedModel::of(&a.test.fit)).collect();
        (!rivals.is_empty()).then(|| Ambiguity {
            finding,
            found: StatedModel::of(full),
            rivals,
        })
    });
    found.collect()
}

impl Stepwise<'_> {
    /// Tries the foremost hypotheses in the place of the k-th of a model.
    pub fn rivals(
        &self,
        full: &ModelFit,
        k: usize,
        noise_level: &NoiseLevel,
    ) -> Result<RivalComparison, DiagnoseError> {
        let without = fit_without(self.context, full, k)?;
        let own = &full.hypotheses[k];
        let mut open = self.rules.open(self.context, &without);
        open.retain(|h| h != own && !h.overlaps(own));
        let pair = FitPair {
            poorer: &without,
            richer: full,
        };
        let by_finding = taken(pair);
        let already = AlreadyTried {
            by_finding,
            told_apart: match self.tells_half(noise_level, pair, own, open.len()) {
                true => HALF * by_finding,
                false => 0.0,
            },
            ..AlreadyTried::default()
        };
        let tests = self.tests(&without, &open, already)?;
        let comparing = Comparing {
            full,
            finding: own,
            noise_level,
            tests: open.len(),
        };
        let alternatives = tests.into_par_iter();
        Ok(RivalComparison {
            alternatives: alternatives
                .map(|test| self.alternative(&comparing, test))
                .collect(),
            without,
            tried: open.len(),
        })
    }

    /// Whether one of some rivals that takes [`HALF`] of what a finding takes would be told from it by the rows that choose.
    fn tells_half(
        &self,
        noise_level: &NoiseLevel,
        pair: FitPair<'_>,
        finding: &Hypothesis,
        rivals: usize,
    ) -> bool {
        let weaker = taking(HALF, pair);
        let pair = FitPair {
            poorer: &weaker,
            ..pair
        };
        let told = separation(self.context, noise_level, pair, &finding.named_joints());
        told.is_clear && told.evidence.p_value * (rivals as f64) < 1.0 - TOLD_APART
    }

    /// What a model with a rival in the place of a finding is worth.
    pub fn alternative(&self, comparing: &Comparing<'_>, test: HypothesisTest) -> Alternative {
        let &Comparing {
            full,
            finding,
            noise_level,
            tests,
        } = comparing;
        let to_finding = FitPair {
            poorer: full,
            richer: &test.fit,
        };
        let from_finding = FitPair {
            poorer: &test.fit,
            richer: full,
        };
        let its_joints = test.hypothesis.named_joints();
        let is_no_richer = test.fit.freedom() <= full.freedom();
        let forecasts = || forecast(self.context, to_finding).p_value * (tests as f64);
        Alternative {
            clear: ComparedRows::clear(
                self.context,
                noise_level,
                from_finding,
                &finding.named_joints(),
            ),
            better: test.fit.held_out_score() < full.held_out_score()
                && (is_no_richer && !is_likelier(from_finding)
                    || error_excess(to_finding, &its_joints) > MATTERS && fits_better(to_finding))
                && forecasts() < self.rules.significance,
            test,
        }
    }

    /// The model with the best alternative in the place of the k-th hypothesis, if one is better.
    pub fn exchanged(
        &self,
        comparison: &RivalComparison,
        k: usize,
    ) -> Result<Option<ModelFit>, DiagnoseError> {
        let better = comparison.alternatives.iter().filter(|a| a.better);
        let score = |a: &&Alternative| a.test.fit.held_out_score();
        let Some(best) = better.min_by(|a, b| score(a).total_cmp(&score(b))) else {
            return Ok(None);
        };
        self.in_place(best, k).map(Some)
    }

    /// The model with an alternative in the place of the k-th hypothesis.
    pub fn in_place(&self, alternative: &Alternative, k: usize) -> Result<ModelFit, DiagnoseError> {
        let found = &alternative.test.fit;
        let mut hypotheses = found.hypotheses.clone();
        if let Some(last) = hypotheses.pop() {
            hypotheses.insert(k.min(hypotheses.len()), last);
        }
        fit_model(self.context, &hypotheses, &found.warm_start())
    }
}

/// What stands against a finding: its rival, or the model with neither where that forecasts as well. Parameters that do not help, be
/// they ever so uncertain, excuse nothing that the model without them leaves.
fn opponent<'a>(rival: &'a ModelFit, neither: &'a ModelFit) -> &'a ModelFit {
    match rival.held_out_score() < neither.held_out_score() {
        true => rival,
        false => neither,
    }
}

/// The poorer model of two, were it to take so large a share of the squares that the richer one takes from the held-out rows, and the
/// same rows.
fn taking(share: f64, pair: FitPair<'_>) -> ModelFit {
    let left = (1.0 - share).sqrt();
    let mut weaker = pair.poorer.clone();
    let channels = weaker.validation.iter_mut().zip(&pair.richer.validation);
    for (weaker, richer) in channels {
        for (e, least) in weaker.iter_mut().zip(richer) {
            *e = least + left * (*e - least);
        }
    }
    weaker
}

/// Whether a richer model fits better than by chance and makes all rows, fitted and held out, likelier: held-out rows of small
/// motions say little of what large ones show.
fn is_likelier(pair: FitPair<'_>) -> bool {
    let score = |fit: &ModelFit| fit.fitted_score() + fit.held_out_score();
    fits_better(pair) && score(pair.richer) < score(pair.poorer)
}

/// How far held-out rows tell a rival, which stands as the poorer model, from one whose finding acts on some joints.
pub fn separation(
    context: &Context<'_>,
    noise_level: &NoiseLevel,
    pair: FitPair<'_>,
    joints: &[usize],
) -> Separation {
    let clear = ComparedRows::clear(context, noise_level, pair, joints);
    separation_on(context, clear, pair, joints)
}

/// The same, where the rows are known on which the difference of the two is clear.
fn separation_on(
    context: &Context<'_>,
    clear: Option<ComparedRows>,
    pair: FitPair<'_>,
    joints: &[usize],
) -> Separation {
    let evidence = clear.unwrap_or(ComparedRows::All).forecast(context, pair);
    let differs = evidence.p_value < 1.0 - CONFIDENCE || error_excess(pair, joints) > MATTERS;
    let missed =
        Distribution::Normal.quantile(CONFIDENCE) - Distribution::Normal.quantile(TOLD_APART);
    let times = (missed / evidence.distance).powi(2);
    Separation {
        evidence,
        is_clear: clear.is_some(),
        separable: differs && clear.is_some(),
        times_longer: times.is_finite().then_some(times),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// However strong it is.
    #[test]
    fn evidence_that_hangs_on_what_neither_explains_says_nothing() {
        let of = |is_clear| Separation {
            evidence: Encompassing {
                slope: 1.0,
                ratio: 20.0,
                distance: 20.0,
                freedom: 1e6,
                p_value: 1e-80,
            },
            is_clear,
            separable: is_clear,
            times_longer: None,
        };
        assert_eq!(of(false).log_likelihood_ratio(), 0.0);
        // 20² / 2, of normal likelihoods.
        assert!((of(true).log_likelihood_ratio() - 200.0).abs() < 0.1);
    }
}
