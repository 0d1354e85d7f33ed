//! Formulas of what has no name: of findings that no effect of the vocabulary explains, and of names that something without one is
//! more probable than.

use crate::diagnose::error::DiagnoseError;
use crate::diagnose::findings::corrections::Corrections;
use crate::diagnose::findings::{probability, sentences};
use crate::diagnose::fit::contexts::Contexts;
use crate::diagnose::fit::model_fit::ModelFit;
use crate::diagnose::formula::proposal::{Proposal, Proposing};
use crate::diagnose::residuals::additive_model;
use crate::diagnose::residuals::noise_level::NoiseLevel;
use crate::diagnose::selection::exact_fit::fit_without;
use crate::outcome::finding::Finding;
use crate::outcome::formula::{OtherFormula, ProposedFormula};

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

/// A channel without a name, and the findings of it: the first is given the formula.
struct Open {
    channel: usize,
    findings: Vec<usize>,
}

/// What else takes the misfit of a channel, and the residuals that it leaves.
struct Rival {
    name: String,
    left: Vec<Vec<f64>>,
}

/// The model that has the formula of a channel.
#[derive(Debug, Clone)]
pub struct FormulaModel {
    /// The channel of the formula's joint.
    pub channel: usize,
    /// The final model with the formula, without the names that it takes the place of.
    pub fit: ModelFit,
}

impl Formulas<'_> {
    /// Gives findings the formulas that have earned it; those of the vocabulary come first, in the order of the hypotheses.
    pub fn propose(&self, findings: &mut [Finding]) -> Result<Vec<FormulaModel>, DiagnoseError> {
        let open = self.open(findings);
        let mut models = Vec::new();
        for place in &open {
            let named = place.findings.iter().copied();
            let named: Vec<usize> = named.filter(|&k| !findings[k].has_no_name()).collect();
            let model = self.without(&named)?;
            let correction = self.corrections.of_channel(place.channel);
            let proposing = Proposing {
                variables: correction.map_or(&[], |c| c.made_of.as_slice()),
                contexts: self.contexts,
                model: &model,
                noise_level: self.noise_level,
                significance: self.significance,
                channels: open.len(),
            };
            let rival = self.rival(place.channel, &named, findings);
            let left = rival.as_ref().map(|rival| rival.left.as_slice());
            if let Some(proposal) = proposing.propose(place.channel, left)? {
                models.push(FormulaModel {
                    channel: place.channel,
                    fit: proposal.test.fit.clone(),
                });
                let formula = formula(proposal, rival.map(|rival| rival.name));
                let finding = &mut findings[place.findings[0]];
                finding.sentence = format!("{} {}", finding.sentence, sentences::formula(&formula));
                finding.formula = Some(formula);
            }
        }
        Ok(models)
    }

    /// Channels of which a finding has no name, or a name of one joint that is less probable than none.
    fn open(&self, findings: &[Finding]) -> Vec<Open> {
        let channels = self.full.model.channels().iter().enumerate();
        let of_channel = channels.filter_map(|(channel, own)| {
            let is_open = |k: &usize| {
                let finding = &findings[*k];
                let doubtful = finding.probability_unnamed > finding.probability;
                finding.joints == [own.name.clone()] && (finding.has_no_name() || doubtful)
            };
            let findings: Vec<usize> = (0..findings.len()).filter(is_open).collect();
            (!findings.is_empty()).then_some(Open { channel, findings })
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
        let smooth: Vec<_> = self.corrections.of_channel(channel).into_iter().collect();
        let name = match (names.is_empty(), smooth.is_empty()) {
            (true, true) => return None,
            (true, false) => SMOOTH.to_string(),
            (false, _) => names.join(" and "),
        };
        let full = self.full.on(&self.contexts.test);
        Some(Rival {
            name,
            left: additive_model::left(&full, &smooth),
        })
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
