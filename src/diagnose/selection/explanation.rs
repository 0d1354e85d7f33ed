//! From a declared model to the findings that explain what it leaves: selection, pruning, rivals, exchanges, the
//! withdrawal of names that only resemble what is missing, and confirmation.

use crate::diagnose::error::DiagnoseError;
use crate::diagnose::fit::context::Context;
use crate::diagnose::fit::contexts::Contexts;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::residuals::noise_level;
use crate::diagnose::selection::confirmation;
use crate::diagnose::selection::confounding;
use crate::diagnose::selection::exact_fit::fit_without;
use crate::diagnose::selection::hypothesis_test::HypothesisTest;
use crate::diagnose::selection::reached::Reached;
use crate::diagnose::selection::rival_models::RivalComparison;
use crate::diagnose::selection::stepwise::{Rules, Selection, SelectionStep, Stepwise};
use crate::diagnose::selection::weak_findings;
use crate::diagnose::selection::zero_size;
use crate::diagnose::stage::Stage;

/// Rounds in which a finding may be exchanged for a better rival.
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

/// A search for what explains the misfit of a model.
pub struct Explaining<'a> {
    /// The held-out rows that choose, those that test, and both.
    pub contexts: &'a Contexts<'a>,
    /// What is sought, and how sure a finding has to be.
    pub rules: Rules<'a>,
    /// Hears of every stage.
    pub watch: &'a (dyn Fn(Stage) + Sync),
    /// Keeps what was selected, should a defect end the search.
    pub reached: &'a Reached,
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
        (self.watch)(Stage::Searching { found });
    }

    fn stepwise<'b>(&'b self, progress: &'b (dyn Fn(&Selection) + Sync)) -> Stepwise<'b> {
        Stepwise {
            context: &self.contexts.selection,
            rules: self.rules.of_choice(),
            progress,
        }
    }

    /// Prunes a selected model, compares each finding with its rivals, exchanges what is bettered, withdraws names that
    /// explain less than they leave, only resemble what another joint does, or have a size that may be none, and strikes out what fails on rows that
    /// chose nothing.
    pub fn conclude(&self, mut selection: Selection) -> Result<Explanation, DiagnoseError> {
        let context = &self.contexts.selection;
        let searching = |selection: &Selection| self.step(selection);
        let stepwise = self.stepwise(&searching);
        let examined = selection.examined;
        (self.watch)(Stage::Comparing);
        let mut tried = selection.steps.clone();
        let mut round = 0;
        let mut withdrawn = Vec::new();
        let mut tested = 0;
        loop {
            let full = stepwise.prune(selection.fit.clone(), examined)?;
            let noise_level = noise_level::of_rows(context, &full, &[]);
            let comparisons = (0..full.hypotheses.len())
                .map(|k| stepwise.rivals(&full, k, &noise_level))
                .collect::<Result<Vec<_>, _>>()?;
            let mut exchanged = None;
            for (k, comparison) in comparisons.iter().enumerate() {
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
            let confounded = || {
                let significance = self.rules.significance;
                confounding::first(context, &noise_level, &full, &comparisons, significance)
            };
            let weakest = weak_findings::weakest(&noise_level, &full, &comparisons);
            let uncertain = || zero_size::least_certain(context, &full);
            if let Some(k) = weakest.or_else(confounded).or_else(uncertain) {
                selection.fit = withdraw(context, &full, k, &mut withdrawn)?;
                round = EXCHANGES;
                continue;
            }
            tested = tested.max(full.hypotheses.len());
            let prefixes = prefixes(context, &full)?;
            let tests = confirmation::tests(self.contexts, &full, tested)?;
            let significance = self.rules.significance;
            let failing = confirmation::failing(self.contexts, &prefixes, &tests, significance);
            if let Some(k) = failing {
                selection.fit = withdraw(context, &full, k, &mut withdrawn)?;
                round = EXCHANGES;
                continue;
            }
            return Ok(Explanation {
                prefixes,
                full,
                tests,
                comparisons,
                examined,
                withdrawn,
                tried,
            });
        }
    }
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

/// Models with the first 0, 1, ... of the findings of a model.
fn prefixes(context: &Context<'_>, full: &ModelFit) -> Result<Vec<ModelFit>, DiagnoseError> {
    let mut prefixes = vec![full.clone()];
    for count in (0..full.hypotheses.len()).rev() {
        let shorter = fit_without(context, &prefixes[0], count)?;
        prefixes.insert(0, shorter);
    }
    Ok(prefixes)
}
