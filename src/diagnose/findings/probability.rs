//! Posterior probabilities of a finding, of its rivals, of an effect outside the vocabulary, and of none.
//!
//! Held-out rows that took no part in the choice give the ratio Λ of the likelihood of a finding to that of a rival in its place, or
//! of nothing (`stats/encompassing.rs`), and by the theorem of Bayes each of them has the probability `w_i / Σ w`, with
//! `w = prior / Λ` and 1 for the finding.

use crate::stats::encompassing::Encompassing;

/// Prior odds of nothing to a hypothesis that a search has accepted: the rate at which it accepts one of nothing.
const NOTHING: f64 = 0.05;

/// Prior odds of physics that the vocabulary lacks and of which a name takes the place: in `exid trials` 8 % of what is
/// concealed is outside of it, and some name fits a third of that.
const OUTSIDE: f64 = 0.08 / 3.0;

/// Odds of physics of the vocabulary that was not recognised to physics that it lacks, where something is there and no name
/// is given: in 2000 trials (`exid trials --motion M --count 500 --seed 864205` of four kinds of motion) 34 of 125 such findings
/// were of it.
const UNRECOGNISED: f64 = 34.0 / 91.0;

/// What a finding may be instead, on the rows that test it.
#[derive(Debug, Clone)]
pub struct Alternatives {
    /// ln Λ, of the likelihoods of the model with the finding and of the model with each rival in its place.
    pub rivals: Vec<f64>,
    /// Of the model with the finding against the model without it.
    pub nothing: Encompassing,
    /// Probability that noise alone leaves as much as the model with the finding does; 1 where noise is not measured.
    pub left: f64,
}

/// Probabilities that add up to one, but for what is no rival.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Probabilities {
    /// That the finding is what is there.
    pub finding: f64,
    /// That each of the rivals is, in their order.
    pub rivals: Vec<f64>,
    /// That something which the vocabulary has no name for is.
    pub unnamed: f64,
    /// That nothing is.
    pub nothing: f64,
}

impl Alternatives {
    /// By the theorem of Bayes, from the likelihoods on rows that took no part in the choice.
    pub fn probabilities(&self) -> Probabilities {
        let rivals: Vec<f64> = self.rivals.iter().map(|ratio| (-ratio).exp()).collect();
        let nothing = odds_of_nothing(&self.nothing);
        let unnamed = OUTSIDE / bayes_factor_bound(self.left);
        let sum = 1.0 + rivals.iter().sum::<f64>() + nothing + unnamed;
        Probabilities {
            finding: 1.0 / sum,
            rivals: rivals.into_iter().map(|w| w / sum).collect(),
            unnamed: unnamed / sum,
            nothing: nothing / sum,
        }
    }
}

/// Of a correction without a name: that it stands for something that the vocabulary lacks, or for nothing; the rest is that it
/// stands for something of the vocabulary that was not recognised.
pub fn of_unnamed(evidence: &Encompassing) -> Probabilities {
    without_name(odds_of_nothing(evidence))
}

/// The same of a residual that noise alone leaves with this probability.
pub fn of_unexplained(p_value: f64) -> Probabilities {
    without_name(NOTHING * bayes_factor_bound(p_value))
}

fn without_name(nothing: f64) -> Probabilities {
    let sum = 1.0 + UNRECOGNISED + nothing;
    Probabilities {
        finding: 1.0 / sum,
        nothing: nothing / sum,
        ..Probabilities::default()
    }
}

/// That a formula, and not what else takes the same misfit or nothing, is what is there. Before the rows that test them,
/// the two are alike.
pub fn of_formula(against: Option<&Encompassing>, nothing: &Encompassing) -> f64 {
    let rival = against.map_or(0.0, |evidence| (-evidence.log_likelihood_ratio()).exp());
    1.0 / (1.0 + rival + odds_of_nothing(nothing))
}

fn odds_of_nothing(evidence: &Encompassing) -> f64 {
    NOTHING * (-evidence.log_likelihood_ratio()).exp()
}

/// Least odds that a p-value leaves its null hypothesis, −e p ln p (Sellke, Bayarri and Berger 2001, equation 2).
fn bayes_factor_bound(p_value: f64) -> f64 {
    const LARGEST: f64 = 1.0 / std::f64::consts::E;
    match p_value {
        p if p >= LARGEST => 1.0,
        p => {
            let p = p.max(f64::MIN_POSITIVE);
            -std::f64::consts::E * p * p.ln()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evidence(slope: f64, distance: f64) -> Encompassing {
        Encompassing {
            slope,
            ratio: slope * distance,
            distance,
            freedom: 1e6,
            p_value: 0.5,
        }
    }

    #[test]
    fn invariant_a_rival_that_forecasts_as_well_is_as_probable() {
        let alike = Alternatives {
            rivals: vec![evidence(0.5, 3.0).log_likelihood_ratio()],
            nothing: evidence(1.0, 100.0),
            left: 1.0,
        };
        let found = alike.probabilities();
        assert!((found.finding - found.rivals[0]).abs() < 1e-12);
        let sum = found.finding + found.rivals[0] + found.unnamed + found.nothing;
        assert!((sum - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_has_no_name_may_still_be_of_the_vocabulary() {
        let sure = of_unexplained(1e-12);
        assert!((sure.finding - 91.0 / 125.0).abs() < 1e-6, "{sure:?}");
        assert!((of_unnamed(&evidence(1.0, 100.0)).finding - 91.0 / 125.0).abs() < 1e-6);
        let doubtful = of_unexplained(0.01);
        assert!(doubtful.nothing > 1e-3 && doubtful.finding < sure.finding);
    }

    #[test]
    fn what_leaves_more_than_noise_is_rather_without_a_name() {
        let left = |left| Alternatives {
            rivals: Vec::new(),
            nothing: evidence(1.0, 100.0),
            left,
        };
        assert!(left(0.5).probabilities().finding > 0.9);
        assert!(left(1e-6).probabilities().finding < 0.01);
    }

    /// Where the evidence is halfway between two, they have their prior odds.
    #[test]
    fn without_evidence_probabilities_are_prior_odds() {
        let halfway = evidence(0.5, 3.0);
        let open = Alternatives {
            rivals: Vec::new(),
            nothing: halfway,
            left: 1.0,
        };
        let found = open.probabilities();
        let sum = 1.0 + 0.05 + 0.08 / 3.0;
        assert!((found.finding - 1.0 / sum).abs() < 1e-12);
        assert!((found.nothing - 0.05 / sum).abs() < 1e-12);
        assert!((found.unnamed - 0.08 / 3.0 / sum).abs() < 1e-12);
        let found = of_unnamed(&halfway);
        let sum = 1.0 + 34.0 / 91.0 + 0.05;
        assert!((found.finding - 1.0 / sum).abs() < 1e-12);
        assert!((found.nothing - 0.05 / sum).abs() < 1e-12);
        assert!((of_formula(None, &halfway) - 1.0 / 1.05).abs() < 1e-12);
        assert!((of_formula(Some(&halfway), &halfway) - 1.0 / 2.05).abs() < 1e-12);
    }
}
