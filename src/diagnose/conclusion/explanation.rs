//! From a declared model to the findings that explain what it leaves: selection, pruning, rivals, exchanges, the
//! withdrawal of names that only resemble what is missing, confirmation, and more probable names.

use crate::diagnose::conclusion::confirmation;
use crate::diagnose::conclusion::confounding;
use crate::diagnose::conclusion::last_selection::LastSelection;
use crate::diagnose::conclusion::weak_findings;
use crate::diagnose::conclusion::zero_size;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::contexts::Contexts;
use crate::diagnose::fit::fitting::fit_model;
use crate::diagnose::fit::hypothesis::Hypothesis;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::noise_level::{self, NoiseLevel};
use crate::diagnose::selection::exact_fit::fit_without;
use crate::diagnose::selection::hypothesis_test::HypothesisTest;
use crate::diagnose::selection::rival_models::RivalComparison;
use crate::diagnose::selection::stepwise::{Rules, Selection, SelectionStep, Stepwise};
use crate::diagnose::stage::Stage;
use crate::stats::deviation::rms;

/// Rounds in which a finding may be exchanged for a better rival, and in which it may be called by a more probable name.
const EXCHANGES: usize = 3;

/// The selected model with the evidence for each finding.
pub struct Explanation {
    /// The declared model with all findings.
    pub full: ModelFit,
    /// Each finding on rows that no choice has seen.
    pub tests: Vec<HypothesisTest>,
    /// What could stand in the place of each finding.
    pub comparisons: Vec<RivalComparison>,
    /// Models with the first 0, 1, ... findings.
    pub prefixes: Vec<ModelFit>,
    /// Hypotheses that the declared model leaves open.
    pub examined: usize,
    /// Joints of names that explained less than they left, whose size may be none, or that rows which chose nothing do not
    /// confirm.
    pub withdrawn: Vec<usize>,
    /// Every hypothesis that was fitted while the model grew.
    pub tried: Vec<SelectionStep>,
}

impl Explanation {
    /// Of the models that a search accepted or might have, the one that leaves least of a channel.
    pub fn least_tried(&self, channel: usize, rules: Rules<'_>) -> Option<TriedModel<'_>> {
        let significance = rules.of_choice().significance;
        let tests = self.tried.iter().flat_map(|step| &step.tests);
        let needed = tests.filter(|test| test.is_needed(significance));
        let of = |fit: &ModelFit| rms(&fit.validation[channel]);
        let left = needed.map(|test| TriedModel {
            share: of(&test.fit) / of(&self.full),
            test,
        });
        left.min_by(|a, b| a.share.total_cmp(&b.share))
    }
}

/// A model that was tried, and what it leaves of a channel.
#[derive(Debug, Clone, Copy)]
pub struct TriedModel<'a> {
    /// Of its last hypothesis.
    pub test: &'a HypothesisTest,
    /// Its RMS residual over that of the selected model, on the rows that chose.
    pub share: f64,
}

/// A search for what explains the misfit of a model.
pub struct Explaining<'a> {
    /// The held-out rows that choose, those that test, and both.
    pub contexts: &'a Contexts<'a>,
    /// What is sought, and how sure a finding has to be.
    pub rules: Rules<'a>,
    /// Hears of every stage.
    pub on_stage: &'a (dyn Fn(Stage) + Sync),
    /// Keeps what was selected, should a defect end the search.
    pub reached: &'a LastSelection,
}

impl Explaining<'_> {
    /// Grows the declared model by what explains its misfit.
    pub fn select(&self, declared: ModelFit) -> Result<Selection, DiagnoseError> {
        let searching = |selection: &Selection| self.step(selection);
        self.stepwise(&searching).forward(declared)
    }

    fn step(&self, selection: &Selection) {
        self.reached.set(&selection.fit, selection.examined);
        let found = selection.steps.len();
        let open = self.rules.open(&self.contexts.selection, &selection.fit);
        (self.on_stage)(Stage::Searching {
            found,
            hypotheses: open.len(),
        });
    }

    fn stepwise<'b>(&'b self, progress: &'b (dyn Fn(&Selection) + Sync)) -> Stepwise<'b> {
        Stepwise {
            context: &self.contexts.selection,
            rules: self.rules.of_choice(),
            progress,
        }
    }

    /// Prunes a selected model, compares each finding with its rivals, exchanges what is bettered, withdraws names that
    /// explain less than they leave, are superfluous beside a smooth correction, or have a size that may be none, strikes out what
    /// fails on rows that chose nothing, puts what only lowers the error beside others behind them, and calls the rest by the
    /// names that those rows find more probable.
    pub fn conclude(&self, selection: Selection) -> Result<Explanation, DiagnoseError> {
        self.concluded(selection, 0, Vec::new())
    }

    /// An explanation without some of its findings, by their numbers in order, and without what rests on them.
    pub fn without(
        &self,
        explanation: &Explanation,
        findings: &[usize],
    ) -> Result<Explanation, DiagnoseError> {
        let mut fit = explanation.full.clone();
        let mut withdrawn = explanation.withdrawn.clone();
        for &k in findings.iter().rev() {
            fit = withdraw(&self.contexts.selection, &fit, k, &mut withdrawn)?;
        }
        let selection = Selection {
            fit,
            steps: explanation.tried.clone(),
            examined: explanation.examined,
        };
        self.concluded(selection, EXCHANGES, withdrawn)
    }

    /// After some rounds of exchanges, and beside names that were withdrawn.
    fn concluded(
        &self,
        mut selection: Selection,
        mut round: usize,
        mut withdrawn: Vec<usize>,
    ) -> Result<Explanation, DiagnoseError> {
        let context = &self.contexts.selection;
        let searching = |selection: &Selection| self.step(selection);
        let stepwise = self.stepwise(&searching);
        let examined = selection.examined;
        (self.on_stage)(Stage::Comparing);
        let mut tried = selection.steps.clone();
        let mut moved: Vec<Hypothesis> = Vec::new();
        let mut tested = 0;
        loop {
            let full = stepwise.prune(selection.fit.clone(), examined)?;
            let beside = self.beside_rivals(&stepwise, full)?;
            let mut exchanged = None;
            for (k, comparison) in beside.comparisons.iter().enumerate() {
                if exchanged.is_none() && round < EXCHANGES {
                    exchanged = stepwise.exchanged(comparison, k)?;
                }
            }
            if let Some(fit) = exchanged {
                selection = stepwise.forward(fit)?;
                tried.extend(selection.steps.iter().cloned());
                round += 1;
                continue;
            }
            tested = tested.max(beside.full.hypotheses.len());
            let confirmed = match self.judged(beside, tested)? {
                Judged::Objectionable(full, k) => {
                    selection.fit = withdraw(context, &full, k, &mut withdrawn)?;
                    round = EXCHANGES;
                    continue;
                }
                Judged::Misplaced(full, k) => {
                    let own = &full.hypotheses[k];
                    selection.fit = if k + 1 < full.hypotheses.len() && !moved.contains(own) {
                        moved.push(own.clone());
                        moved_last(context, &full, k)?
                    } else {
                        withdraw(context, &full, k, &mut withdrawn)?
                    };
                    round = EXCHANGES;
                    continue;
                }
                Judged::Confirmed(confirmed) => {
                    self.named(&stepwise, confirmed, examined, tested)?
                }
            };
            let BesideRivals {
                full, comparisons, ..
            } = confirmed.beside;
            return Ok(Explanation {
                prefixes: confirmed.prefixes,
                tests: confirmed.tests,
                full,
                comparisons,
                examined,
                withdrawn,
                tried,
            });
        }
    }

    fn beside_rivals(
        &self,
        stepwise: &Stepwise<'_>,
        full: ModelFit,
    ) -> Result<BesideRivals, DiagnoseError> {
        let noise_level = noise_level::of_rows(&self.contexts.selection, &full, &[]);
        let mut comparisons = (0..full.hypotheses.len())
            .map(|k| stepwise.rivals(&full, k, &noise_level))
            .collect::<Result<Vec<_>, _>>()?;
        stepwise.in_all_places(&full, &mut comparisons, &noise_level);
        Ok(BesideRivals {
            full,
            noise_level,
            comparisons,
        })
    }

    /// What rows and rivals say of the findings of a model, `tested` of which rows that chose nothing are asked about.
    fn judged(&self, beside: BesideRivals, tested: usize) -> Result<Judged, DiagnoseError> {
        let (context, significance) = (&self.contexts.selection, self.rules.significance);
        let BesideRivals {
            full,
            noise_level,
            comparisons,
        } = &beside;
        let objection = weak_findings::weakest(context, noise_level, full, comparisons)
            .or_else(|| confounding::first(context, full, comparisons, significance))
            .or_else(|| zero_size::least_certain(context, full));
        if let Some(k) = objection {
            return Ok(Judged::Objectionable(beside.full, k));
        }
        let prefixes = prefixes(context, full)?;
        let tests = confirmation::tests(self.contexts, full, tested)?;
        if let Some(k) = confirmation::failing(&tests, significance) {
            return Ok(Judged::Objectionable(beside.full, k));
        }
        Ok(match confirmation::misplaced(self.contexts, &prefixes) {
            Some(k) => Judged::Misplaced(beside.full, k),
            None => Judged::Confirmed(Confirmed {
                beside,
                prefixes,
                tests,
            }),
        })
    }

    /// The model with the names that rows which chose nothing find most probable, as far as nothing speaks against them. Each
    /// of these is one test more.
    fn named(
        &self,
        stepwise: &Stepwise<'_>,
        mut confirmed: Confirmed,
        examined: usize,
        tested: usize,
    ) -> Result<Confirmed, DiagnoseError> {
        for round in 1..=EXCHANGES {
            match self.renamed(stepwise, &confirmed.beside, examined, tested + round)? {
                Some(better) => confirmed = better,
                None => break,
            }
        }
        Ok(confirmed)
    }

    /// The model with a rival in the place of a finding that rows which chose nothing find less probable than it, if nothing
    /// speaks against that model and it makes those rows likelier, without what is superfluous beside the rival.
    fn renamed(
        &self,
        stepwise: &Stepwise<'_>,
        beside: &BesideRivals,
        examined: usize,
        tested: usize,
    ) -> Result<Option<Confirmed>, DiagnoseError> {
        for (k, comparison) in beside.comparisons.iter().enumerate() {
            let rows = self.contexts.testing(&beside.full.hypotheses[k]);
            let score = |fit: &ModelFit| fit.on(rows).held_out_score();
            for rival in comparison.more_probable(rows, &beside.full) {
                let fit = stepwise.prune(stepwise.in_place(rival, k)?, examined)?;
                if score(&fit) >= score(&beside.full) {
                    continue;
                }
                let as_renamed = self.beside_rivals(stepwise, fit)?;
                if let Judged::Confirmed(confirmed) = self.judged(as_renamed, tested)? {
                    return Ok(Some(confirmed));
                }
            }
        }
        Ok(None)
    }
}

/// A model with what could stand in the place of each of its findings.
struct BesideRivals {
    full: ModelFit,
    noise_level: NoiseLevel,
    comparisons: Vec<RivalComparison>,
}

/// What rows and rivals say of the findings of a model.
enum Judged {
    /// Something speaks against the k-th of the model.
    Objectionable(ModelFit, usize),
    /// The k-th of the model raises the error of its joints beside those before it alone.
    Misplaced(ModelFit, usize),
    /// Nothing speaks against any.
    Confirmed(Confirmed),
}

/// A model to which there is no objection, with its evidence.
struct Confirmed {
    beside: BesideRivals,
    /// Models with the first 0, 1, ... findings.
    prefixes: Vec<ModelFit>,
    /// Each finding on rows that no choice has seen.
    tests: Vec<HypothesisTest>,
}

/// A model without its k-th finding, whose joints join those of the others that were withdrawn.
fn withdraw(
    context: &Context<'_>,
    full: &ModelFit,
    k: usize,
    withdrawn: &mut Vec<usize>,
) -> Result<ModelFit, DiagnoseError> {
    withdrawn.extend(full.hypotheses[k].named_joints());
    fit_without(context, full, k)
}

/// A model with its k-th finding after all others.
fn moved_last(context: &Context<'_>, full: &ModelFit, k: usize) -> Result<ModelFit, DiagnoseError> {
    let mut hypotheses = full.hypotheses.clone();
    hypotheses[k..].rotate_left(1);
    let make = || fit_model(context, &hypotheses, &full.warm_start());
    context.cache.fit_model(&hypotheses, make)
}

/// Models with the first 0, 1, ... of the findings of a model.
fn prefixes(context: &Context<'_>, full: &ModelFit) -> Result<Vec<ModelFit>, DiagnoseError> {
    let mut prefixes = vec![full.clone()];
    for count in (0..full.hypotheses.len()).rev() {
        let shorter = fit_without(context, &prefixes[0], count)?;
        prefixes.insert(0, shorter);
    }
    Ok(prefixes)
}
