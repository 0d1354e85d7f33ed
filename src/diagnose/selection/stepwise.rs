//! Stepwise selection: the model grows by one hypothesis at a time, then each is dropped on trial.

use crate::chain::effect::Law;
use crate::diagnose::candidates::screening::screen;
use crate::diagnose::candidates::screening_reuse::Reusable;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::fit::candidate::{Candidate, Screening};
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::hypothesis::{self, Hypothesis, channels_of};
use crate::diagnose::fit::model_fit::{FitPair, ModelFit};
use crate::diagnose::residuals::effect_size::{self, MATTERS, error_excess};
use crate::diagnose::residuals::noise_level::{self, UNEXPLAINED};
use crate::diagnose::selection::common_delay;
use crate::diagnose::selection::exact_fit::{ExactFit, competes, fit_without, least_gain, taken};
use crate::diagnose::selection::forecast::forecast;
use crate::diagnose::selection::hypothesis_test::{CONFIDENCE, HypothesisTest, fits_better};
use crate::diagnose::selection::law_range;
use crate::diagnose::selection::search_bounds;
use rayon::prelude::*;
use std::collections::HashMap;

/// What a search looks for and how sure it has to be.
#[derive(Debug, Clone, Copy)]
pub struct Rules<'a> {
    /// Effects to look for; all if `None`.
    pub sought: Option<&'a [String]>,
    /// Probability of a false finding after correction.
    pub significance: f64,
}

impl Rules<'_> {
    /// The same for hypotheses that rows which no choice has seen are yet to test.
    pub fn of_choice(self) -> Self {
        Self {
            significance: self.significance.max(CHOICE),
            ..self
        }
    }

    /// Every hypothesis that a model leaves open.
    pub fn open(&self, context: &Context<'_>, fit: &ModelFit) -> Vec<Hypothesis> {
        hypothesis::open(&fit.model, &fit.prior, self.sought, context.in_time)
    }
}

/// A model grown and what was tried on the way.
#[derive(Debug, Clone)]
pub struct Selection {
    /// The model that it came to.
    pub fit: ModelFit,
    /// Tests of every step; the accepted one first, in all but the last.
    pub steps: Vec<SelectionStep>,
    /// Number of hypotheses of the first step.
    pub examined: usize,
}

impl Selection {
    /// A model before anything was tried beside it.
    pub fn of(fit: ModelFit) -> Self {
        Self {
            fit,
            steps: Vec::new(),
            examined: 0,
        }
    }
}

/// What was tried beside a model.
#[derive(Debug, Clone)]
pub struct SelectionStep {
    /// The hypotheses that were fitted exactly.
    pub tests: Vec<HypothesisTest>,
    /// Held-out score of the model as it was.
    pub score: f64,
    /// The first of them joined the model.
    pub accepted: bool,
    /// Nothing interrupted it.
    pub is_complete: bool,
}

/// Hypotheses fitted exactly in one step.
const FITTED: usize = 8;

/// Hypotheses of one effect among them, where others promise something too.
const OF_ONE_EFFECT: usize = 2;

/// Effects that a model can be given; more at once were never told apart.
const MOST_FINDINGS: usize = 8;

/// Times that a search begins a step again because the richer model led to a better fit of the poorer.
const SEARCHES_AGAIN: usize = 3;

/// Significance at which a search accepts a hypothesis, corrected for the number of those that are open, where other rows
/// test it afterwards: half of the rows and one test then find what all rows and hundreds of tests would.
pub const CHOICE: f64 = 0.05;

/// What is known where candidates are tried beside a model.
#[derive(Debug, Clone, Copy, Default)]
pub struct AlreadyTried<'a> {
    /// Hypotheses that were fitted beside a poorer model.
    pub earlier: &'a [HypothesisTest],
    /// Sum of squares that a finding takes for which rivals are sought, as [`taken`] counts it.
    pub by_finding: f64,
    /// Sum of squares that a rival takes which is told from the finding: what takes no more need not be tried.
    pub told_apart: f64,
}

/// Stepwise selection over the rows of a context.
pub struct Stepwise<'a> {
    /// The rows that choose.
    pub context: &'a Context<'a>,
    /// What is sought, and how sure a finding has to be.
    pub rules: Rules<'a>,
    /// Hears before every step what was selected so far.
    pub progress: &'a (dyn Fn(&Selection) + Sync),
}

impl Stepwise<'_> {
    /// Grows a model until no hypothesis is significant and matters.
    pub fn forward(&self, declared: ModelFit) -> Result<Selection, DiagnoseError> {
        let context = self.context;
        let mut selection = Selection::of(declared);
        let mut searched_again = 0;
        while selection.steps.len() < MOST_FINDINGS && !context.control.is_interrupted() {
            (self.progress)(&selection);
            // A law that later ones have left with a bend alone, or at a limit of its search, is theirs, and so is a delay of all
            // that is left to one.
            let is_theirs = |h: &Hypothesis| {
                let fit = &selection.fit;
                !law_range::are_reached(context, fit, h)
                    || !search_bounds::are_inside(fit, h)
                    || common_delay::is_of_one(context, fit, h)
            };
            if let Some(k) = selection.fit.hypotheses.iter().position(is_theirs) {
                selection.fit = fit_without(context, &selection.fit, k)?;
            }
            let open = self.rules.open(context, &selection.fit);
            if selection.steps.is_empty() {
                selection.examined = open.len();
            }
            let already = AlreadyTried {
                earlier: selection.steps.last().map_or(&[][..], |step| &step.tests),
                ..AlreadyTried::default()
            };
            let mut tests = self.tests(&selection.fit, &open, already)?;
            let mut best = self.choose(&tests);
            if best.is_none() {
                tests.extend(self.tests_of_gaps(&selection.fit, &open)?);
                best = self.choose(&tests);
            }
            if let Some(best) = best {
                let richer = &tests[best].fit;
                let poorer = fit_without(context, richer, richer.hypotheses.len() - 1)?;
                let gained = selection.fit.fitted_score() - poorer.fitted_score();
                if gained > least_gain(&selection.fit) && searched_again < SEARCHES_AGAIN {
                    selection.fit = poorer;
                    searched_again += 1;
                    continue;
                }
            }
            let score = selection.fit.held_out_score();
            if let Some(best) = best {
                tests.swap(0, best);
                selection.fit = tests[0].fit.clone();
            }
            selection.steps.push(SelectionStep {
                tests,
                score,
                accepted: best.is_some(),
                is_complete: !context.control.is_interrupted(),
            });
            if best.is_none() {
                break;
            }
        }
        Ok(selection)
    }

    /// Fits the foremost candidates among some open hypotheses exactly beside what a model has; those that did not
    /// matter beside a poorer one do not where the residuals of their joints have stayed, and are not fitted again. Those that cannot
    /// take as much as others have are not searched from every start, and those that cannot rival a finding are not fitted.
    pub fn tests(
        &self,
        fit: &ModelFit,
        open: &[Hypothesis],
        already: AlreadyTried<'_>,
    ) -> Result<Vec<HypothesisTest>, DiagnoseError> {
        let context = self.context;
        let least = least_gain(fit);
        let mut candidates = self.screened(fit)?.candidates;
        candidates.retain(|one| {
            one.gain >= least && competes(one, already.told_apart) && open.contains(&one.hypothesis)
        });
        let candidates = foremost(candidates);
        let reusable = Reusable::of(context, fit);
        let is_refuted = |test: &HypothesisTest| {
            let stands = |others: &[Hypothesis]| reusable.stands(others, &test.hypothesis);
            test.error_reduction < MATTERS
                && context.cache.is_fitted(&test.fit.hypotheses)
                && test
                    .fit
                    .hypotheses
                    .split_last()
                    .is_some_and(|(_, others)| stands(others))
        };
        let refuted: Vec<&HypothesisTest> =
            already.earlier.iter().filter(|t| is_refuted(t)).collect();
        let beside = Beside {
            context,
            fit,
            open: open.len(),
        };
        let count = context.control.counting(candidates.len());
        let first = candidates.par_iter().filter_map(|candidate| {
            let mut known = refuted.iter();
            let tried = match known.find(|t| t.hypothesis == candidate.hypothesis) {
                Some(&known) => Some(Tried::Settled(known.clone())),
                None => beside.first(candidate),
            };
            count.one();
            tried
        });
        let first: Vec<Tried<'_>> = first.collect();
        let taken = |tried: &Tried<'_>| match tried {
            Tried::Settled(test) if test.is_needed(self.rules.significance) => taken(FitPair {
                poorer: fit,
                richer: &test.fit,
            }),
            _ => 0.0,
        };
        let most = first.iter().map(taken).fold(already.by_finding, f64::max);
        let tests = first.into_par_iter().filter_map(|tried| match tried {
            Tried::Settled(test) => Some(test),
            Tried::Open(exact, _) if competes(exact.candidate, most) => {
                beside.test(&exact, exact.best().ok()?)
            }
            Tried::Open(exact, first) => beside.test(&exact, first),
        });
        Ok(tests.collect())
    }

    /// What the hypotheses that a model leaves open promise.
    fn screened(&self, fit: &ModelFit) -> Result<Screening, DiagnoseError> {
        let find = || screen(self.context, fit, self.rules.open(self.context, fit));
        self.context.cache.screening(&fit.hypotheses, find)
    }

    /// Tests of the play of gears in channels that a model does not explain, with the gap searched for: where other physics is missing
    /// beside it, one step of all other parameters, as a screening takes it, shows little of what a gap explains.
    fn tests_of_gaps(
        &self,
        fit: &ModelFit,
        open: &[Hypothesis],
    ) -> Result<Vec<HypothesisTest>, DiagnoseError> {
        let context = self.context;
        let noise_level = noise_level::of_rows(context, fit, &[]);
        if !noise_level.measured {
            return Ok(Vec::new());
        }
        let is_unexplained = |hypothesis: &Hypothesis| {
            let channels = channels_of(&fit.model, &hypothesis.joints);
            let mut lacks = channels
                .into_iter()
                .map(|c| noise_level.lack_of_channel(&fit.validation[c], c));
            lacks.any(|lack| lack > UNEXPLAINED)
        };
        let mut candidates = self.screened(fit)?.glance;
        candidates.retain(|Candidate { hypothesis, .. }| {
            let is_play = matches!(hypothesis.effect.law, Law::Play);
            is_play && open.contains(hypothesis) && is_unexplained(hypothesis)
        });
        candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        candidates.truncate(OF_ONE_EFFECT);
        let beside = Beside {
            context,
            fit,
            open: open.len(),
        };
        let tests = candidates.par_iter().filter_map(|candidate| {
            let exact = ExactFit {
                context,
                before: fit,
                candidate,
            };
            beside.test(&exact, exact.searching_gap().ok()?)
        });
        Ok(tests.collect())
    }

    /// The test to accept: of those that are significant and matter the one with the least held-out error, or
    /// one with fewer parameters that is not significantly worse, or not by what matters, or fits as well.
    fn choose(&self, tests: &[HypothesisTest]) -> Option<usize> {
        let accepted: Vec<usize> = (0..tests.len())
            .filter(|&k| tests[k].is_needed(self.rules.significance))
            .filter(|&k| {
                !common_delay::is_of_one(self.context, &tests[k].fit, &tests[k].hypothesis)
            })
            .collect();
        let score = |k: usize| tests[k].fit.held_out_score();
        let best = *accepted
            .iter()
            .min_by(|&&a, &&b| score(a).total_cmp(&score(b)))?;
        let as_good = accepted.iter().copied().filter(|&k| {
            k == best || {
                let pair = FitPair {
                    poorer: &tests[k].fit,
                    richer: &tests[best].fit,
                };
                let against = forecast(self.context, pair);
                let richest = &tests[best].hypothesis;
                let is_poorer = pair.poorer.freedom() < pair.richer.freedom();
                let reduction = || effect_size::error_reduction(self.context, richest, pair);
                against.p_value > 1.0 - CONFIDENCE
                    || is_poorer && error_excess(pair, &richest.named_joints()) <= MATTERS
                    || is_poorer && !fits_better(pair)
                    || tests[k].hypothesis.is_part_of(richest) && reduction() < MATTERS
            }
        });
        as_good.min_by(|&a, &b| {
            let size = |k: usize| (tests[k].fit.freedom(), tests[k].hypothesis.joints.len());
            size(a).cmp(&size(b)).then(score(a).total_cmp(&score(b)))
        })
    }

    /// Drops hypotheses that the others make superfluous, the weakest first; p-values are corrected for `tests`.
    pub fn prune(&self, mut fit: ModelFit, tests: usize) -> Result<ModelFit, DiagnoseError> {
        loop {
            let dropped: Vec<HypothesisTest> = (0..fit.hypotheses.len())
                .into_par_iter()
                .map(|k| Ok(self.without(&fit, k)?.corrected_for(tests)))
                .collect::<Result<_, DiagnoseError>>()?;
            let needed = |t: &HypothesisTest| t.is_needed(self.rules.significance);
            let ratio = |k: usize| dropped[k].evidence.ratio;
            let weakest = (0..dropped.len())
                .filter(|&k| !needed(&dropped[k]))
                .min_by(|&a, &b| ratio(a).total_cmp(&ratio(b)));
            match weakest {
                Some(k) => fit = fit_without(self.context, &fit, k)?,
                None => return Ok(fit),
            }
        }
    }

    /// The test of the k-th hypothesis of a model: the model against itself without it.
    fn without(&self, fit: &ModelFit, k: usize) -> Result<HypothesisTest, DiagnoseError> {
        let poorer = fit_without(self.context, fit, k)?;
        let hypothesis = fit.hypotheses[k].clone();
        Ok(HypothesisTest::of(
            self.context,
            &poorer,
            fit.clone(),
            hypothesis,
        ))
    }
}

/// A model beside which candidates are tried, with the number of hypotheses that it leaves open.
struct Beside<'a> {
    context: &'a Context<'a>,
    fit: &'a ModelFit,
    open: usize,
}

/// A candidate after the fit from its most promising start.
enum Tried<'a> {
    /// Searched to the end.
    Settled(HypothesisTest),
    /// Other starts may lead further, which is worth their time where the candidate competes with what others take.
    Open(ExactFit<'a>, ModelFit),
}

impl<'a> Beside<'a> {
    /// `None` for a hypothesis that cannot be fitted or is not possible, which is none.
    fn first(&self, candidate: &'a Candidate) -> Option<Tried<'a>> {
        let exact = ExactFit {
            context: self.context,
            before: self.fit,
            candidate,
        };
        let first = exact.first().ok()?;
        match exact.is_settled(&first) {
            true => self.test(&exact, exact.best().ok()?).map(Tried::Settled),
            false => Some(Tried::Open(exact, first)),
        }
    }

    fn test(&self, exact: &ExactFit<'_>, richer: ModelFit) -> Option<HypothesisTest> {
        exact.is_possible(&richer).then(|| {
            let hypothesis = exact.candidate.hypothesis.clone();
            HypothesisTest::of(self.context, self.fit, richer, hypothesis).corrected_for(self.open)
        })
    }
}

/// The candidates that are fitted: the most promising, of every effect two before a third of any.
fn foremost(candidates: Vec<Candidate>) -> Vec<Candidate> {
    let mut taken: HashMap<&str, usize> = HashMap::new();
    let (mut first, later): (Vec<Candidate>, Vec<Candidate>) =
        candidates.into_iter().partition(|candidate| {
            let of_effect = taken.entry(candidate.hypothesis.effect.id).or_default();
            *of_effect += 1;
            *of_effect <= OF_ONE_EFFECT
        });
    first.extend(later);
    first.truncate(FITTED);
    first
}
