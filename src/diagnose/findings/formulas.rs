//! Formulas of what has no name: of findings that no effect of the vocabulary explains, of names that something without one is
//! more probable than, and of what is left without a finding and is not known to be noise.

use crate::chain::dataset::Dataset;
use crate::diagnose::error::DiagnoseError;
use crate::diagnose::findings::corrections::Corrections;
use crate::diagnose::findings::{probability, sentences};
use crate::diagnose::fit::contexts::Contexts;
use crate::diagnose::fit::fitting::fit_model;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::formula::proposal::{Proposal, Proposing, Rival, RivalKind};
use crate::diagnose::formula::seeking::Seeking;
use crate::diagnose::residuals::noise_level::{self, NoiseLevel};
use crate::diagnose::selection::exact_fit::fit_without;
use crate::outcome::diagnose::Unattested;
use crate::outcome::finding::{Finding, UNNAMED};
use crate::outcome::formula::{OtherFormula, ProposedFormula};
use crate::stats::deviation::rms;

/// What a smooth correction is called as the rival of a formula.
const SMOOTH: &str = "the smooth correction";

/// What formulas are proposed from.
pub struct Formulas<'a> {
    /// The rows that fit, choose and test.
    pub contexts: &'a Contexts<'a>,
    /// The final model.
    pub full: &'a ModelFit,
    /// The smooth corrections that a formula has to stand beside.
    pub corrections: &'a Corrections,
    /// The noise that shares are taken of.
    pub noise_level: &'a NoiseLevel,
    /// Probability of a formula where there is none.
    pub significance: f64,
}

/// A channel without a name, and the findings of it, if there are any: the first is given the formula.
struct Open {
    channel: usize,
    findings: Vec<usize>,
}

/// The model that has the formula of a channel.
#[derive(Debug, Clone)]
pub struct FormulaModel {
    /// The channel of the formula's joint.
    pub channel: usize,
    /// The final model with the formula, without the names that it takes the place of.
    pub fit: ModelFit,
    /// Numbers of the hypotheses of the final model beside which it has earned it: their names are none.
    pub instead_of: Vec<usize>,
}

impl Formulas<'_> {
    /// Gives findings the formulas that have earned it; those of the vocabulary come first, in the order of the hypotheses. A formula
    /// of what is left where there is no finding makes one.
    pub fn propose(
        &self,
        findings: &mut Vec<Finding>,
        unattested: &[Unattested],
    ) -> Result<Vec<FormulaModel>, DiagnoseError> {
        let open = self.open(findings, unattested);
        let mut models = Vec::new();
        for place in &open {
            let named = place.findings.iter().copied();
            let named: Vec<usize> = named.filter(|&k| !findings[k].has_no_name()).collect();
            let model = self.without(&named)?;
            let correction = self.corrections.of_channel(place.channel);
            let rows = self.rows(&model, place.channel);
            let context = &self.contexts.over(&rows);
            let model = fit_model(context, &model.hypotheses, &model.warm_start())?;
            let proposing = Proposing {
                seeking: Seeking {
                    context,
                    model: &model,
                    variables: correction.map_or(&[], |c| c.made_of.as_slice()),
                },
                noise_level: self.noise_level,
                significance: self.significance,
                channels: open.len(),
            };
            let rival = self.rival(place.channel, &named, findings);
            let proposal = proposing.propose(place.channel, rival.as_ref());
            // Nothing but what the formula leaves says that the rest was not noise.
            let is_earned = |proposal: &Proposal| {
                let left = &proposal.test.fit.validation[place.channel];
                !place.findings.is_empty() || noise_level::is_noise(left, 0.0)
            };
            if let Some(proposal) = proposal.filter(is_earned) {
                let fit = proposal.test.fit.clone();
                let k = place.findings.first().copied().unwrap_or_else(|| {
                    findings.push(self.nameless(place.channel, &proposal));
                    findings.len() - 1
                });
                let formula = formula(proposal, rival.map(|rival| rival.name));
                models.push(FormulaModel {
                    channel: place.channel,
                    fit,
                    instead_of: named,
                });
                let finding = &mut findings[k];
                finding.sentence = format!("{} {}", finding.sentence, sentences::formula(&formula));
                finding.formula = Some(formula);
            }
        }
        Ok(models)
    }

    /// Rows that fit formulas and rows that test them: as with smooth corrections, all but those which no choice has seen are fitted.
    /// Parameters that belong to one held-out recording are not fitted with the others.
    fn rows(&self, model: &ModelFit, channel: usize) -> Dataset {
        match model.own.is_empty() {
            true => {
                let memory = self.corrections.memory(self.contexts, channel);
                self.contexts.with_selection_fitted(memory)
            }
            false => self.contexts.test.data.clone(),
        }
    }

    /// The finding of a channel that had none before a formula took what is left of it.
    fn nameless(&self, channel: usize, proposal: &Proposal) -> Finding {
        let name = &self.full.model.channels()[channel].name;
        let error = rms(&self.full.on(&self.contexts.whole).validation[channel]);
        let odds = probability::of_unnamed(&proposal.test.evidence);
        Finding {
            effect: UNNAMED.to_string(),
            joints: vec![name.clone()],
            parameters: Vec::new(),
            rmse_validation_before: error,
            rmse_validation_after: error,
            explained_share: 0.0,
            p_value: proposal.test.p_value,
            sentence: sentences::nameless(name),
            rivals: Vec::new(),
            probability: odds.finding,
            probability_unnamed: odds.finding,
            probability_nothing: odds.nothing,
            formula: None,
        }
    }

    /// Channels of which a finding has no name, or a name of one joint that is less probable than none, and those without a finding of
    /// which something is left that is not known to be noise.
    fn open(&self, findings: &[Finding], unattested: &[Unattested]) -> Vec<Open> {
        let channels = self.full.model.channels().iter().enumerate();
        let of_channel = channels.filter_map(|(channel, own)| {
            let is_open = |k: &usize| {
                let finding = &findings[*k];
                let doubtful = finding.probability_unnamed > finding.probability;
                finding.joints == [own.name.clone()] && (finding.has_no_name() || doubtful)
            };
            let open: Vec<usize> = (0..findings.len()).filter(is_open).collect();
            let is_own = |left: &Unattested| left.joint == own.name;
            let is_bare = !findings.iter().any(|f| f.joints.contains(&own.name));
            let is_left = is_bare && unattested.iter().any(is_own);
            (is_left || !open.is_empty()).then_some(Open {
                channel,
                findings: open,
            })
        });
        of_channel.collect()
    }

    /// The final model without some of its hypotheses.
    fn without(&self, hypotheses: &[usize]) -> Result<ModelFit, DiagnoseError> {
        let mut model = self.full.clone();
        for &k in hypotheses.iter().rev() {
            model = fit_without(&self.contexts.selection, &model, k)?;
        }
        Ok(model)
    }

    /// What else takes the misfit of a channel on rows that no choice has seen.
    fn rival(&self, channel: usize, named: &[usize], findings: &[Finding]) -> Option<Rival> {
        let names: Vec<&str> = named.iter().map(|&k| findings[k].effect.as_str()).collect();
        let smooth = self.corrections.of_channel(channel).is_some();
        let (name, kind) = match (names.is_empty(), smooth) {
            (true, false) => return None,
            (true, true) => (SMOOTH.to_string(), RivalKind::Smooth),
            (false, _) => (names.join(" and "), RivalKind::Named),
        };
        let left = match smooth {
            true => self.corrections.left(),
            false => self.corrections.full.validation.clone(),
        };
        Some(Rival { name, kind, left })
    }
}

fn formula(proposal: Proposal, against: Option<String>) -> ProposedFormula {
    let probability = probability::of_formula(proposal.against.as_ref(), &proposal.test.evidence);
    let mut others: Vec<OtherFormula> = proposal
        .others
        .iter()
        .map(|other| OtherFormula {
            expression: other.formula.expression(),
            complexity: other.formula.parameters().count(),
            explains: other.explains,
        })
        .collect();
    others.sort_by(|a, b| b.explains.total_cmp(&a.explains));
    ProposedFormula {
        effect: proposal.formula.id.clone(),
        joint: proposal.formula.on.clone(),
        expression: proposal.formula.expression(),
        drives: proposal.drives,
        law: proposal.formula.table(),
        variables: proposal.formula.variables(),
        complexity: proposal.formula.parameters().count(),
        parameters: proposal.parameters,
        rmse_validation: proposal.rmse,
        explains: proposal.explains,
        p_value: proposal.test.p_value,
        probability,
        against,
        tried: proposal.tried,
        others,
    }
}
