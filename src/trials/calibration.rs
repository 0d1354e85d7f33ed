//! Calibration: whether stated probabilities are right as often as they say.
//!
//! ```text
//! (p̂ + z²/2n ∓ z √(p̂(1 − p̂)/n + z²/4n²)) / (1 + z²/n)      interval of a share p̂ of n cases (Wilson 1927), z = 1.96
//! ```
//!
//! Claims of one trial exclude each other, and the interval counts them as independent: it is a little too wide where
//! they share one probability among them, and too narrow where trials fail together.

use crate::outcome::finding::UNNAMED;
use crate::outcome::finding::{Finding, Rival};
use crate::outcome::trials::{Calibration, Hidden, Share, Stated, Trial, is_outside};
use crate::stats::distribution::Distribution;

/// Ranges of probability in the table.
const TENTHS: usize = 10;

/// What a diagnosis claims.
#[derive(Debug, Clone, Copy)]
pub enum Claim<'a> {
    /// A finding is what is there.
    Finding(&'a Finding),
    /// A rival is there in its place.
    Rival(&'a Rival),
}

impl Claim<'_> {
    fn effect(&self) -> &str {
        match self {
            Self::Finding(finding) => &finding.effect,
            Self::Rival(rival) => &rival.effect,
        }
    }

    fn joints(&self) -> &[String] {
        match self {
            Self::Finding(finding) => &finding.joints,
            Self::Rival(rival) => &rival.joints,
        }
    }

    /// Whether it is what was concealed.
    fn is_right(&self, concealed: &[Hidden]) -> bool {
        let same_effect = |hidden: &Hidden| match self.effect() {
            UNNAMED => is_outside(&hidden.effect),
            effect => effect == hidden.effect,
        };
        let mut concealed = concealed.iter();
        concealed.any(|hidden| same_effect(hidden) && self.joints() == hidden.joints)
    }
}

/// The probability that a diagnosis states for a claim; `None` where it states none.
fn stated_probability(claim: Claim<'_>) -> Option<f64> {
    let stated = match claim {
        Claim::Finding(finding) => finding.probability,
        Claim::Rival(rival) => rival.probability,
    };
    stated.is_finite().then_some(stated)
}

/// Every finding and every rival that is stated with a probability.
pub fn stated(findings: &[Finding], concealed: &[Hidden]) -> Vec<Stated> {
    let claims = findings.iter().flat_map(|finding| {
        let rivals = finding.rivals.iter().map(Claim::Rival);
        std::iter::once(Claim::Finding(finding)).chain(rivals)
    });
    let with_probability = claims.filter_map(|claim| {
        Some(Stated {
            effect: claim.effect().to_string(),
            joints: claim.joints().to_vec(),
            probability: stated_probability(claim)?,
            right: claim.is_right(concealed),
        })
    });
    with_probability.collect()
}

/// The table of all trials together, then that of each kind of motion; tenths without a claim are left out.
pub fn table(trials: &[Trial], motions: &[String]) -> Vec<Calibration> {
    let kinds = std::iter::once(None).chain(motions.iter().map(Some));
    let rows = kinds.flat_map(|motion| {
        let own = trials
            .iter()
            .filter(|t| motion.is_none_or(|m| t.motion == *m));
        of_kind(motion, own.flat_map(|t| &t.stated))
    });
    rows.collect()
}

fn of_kind<'a>(
    motion: Option<&String>,
    claims: impl Iterator<Item = &'a Stated>,
) -> Vec<Calibration> {
    let mut sums = [(0.0, Share::default()); TENTHS];
    for claim in claims.filter(|claim| claim.probability.is_finite()) {
        let tenth = (claim.probability.clamp(0.0, 1.0) * TENTHS as f64) as usize;
        let (sum, share) = &mut sums[tenth.min(TENTHS - 1)];
        *sum += claim.probability;
        share.count(claim.right);
    }
    let rows = sums
        .into_iter()
        .enumerate()
        .filter(|(_, (_, share))| share.of > 0);
    let rows = rows.map(|(tenth, (sum, share))| Calibration {
        motion: motion.cloned(),
        from: tenth as f64 / TENTHS as f64,
        claims: share.of,
        stated: sum / share.of as f64,
        right: share.are,
        ci95: wilson(share),
    });
    rows.collect()
}

/// 95 % interval of a share; all shares are possible where there are no cases.
pub fn wilson(share: Share) -> [f64; 2] {
    if share.of == 0 {
        return [0.0, 1.0];
    }
    let (n, z) = (share.of as f64, Distribution::Normal.two_sided(0.95));
    let p = share.value();
    let middle = p + z * z / (2.0 * n);
    let half = z * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + z * z / n;
    [middle - half, middle + half].map(|bound| (bound / scale).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claim(probability: f64, right: bool) -> Stated {
        Stated {
            effect: "joint_spring".to_string(),
            joints: vec!["j1".to_string()],
            probability,
            right,
        }
    }

    fn trial(motion: &str, stated: Vec<Stated>) -> Trial {
        Trial {
            motion: motion.to_string(),
            stated,
            ..Trial::default()
        }
    }

    #[test]
    fn matches_published_intervals() {
        // Newcombe 1998, Statistics in Medicine 17:857, table I, method 3.
        let published = [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
        ];
        for (are, of, low, high) in published {
            let found = wilson(Share { of, are });
            assert!(
                (found[0] - low).abs() < 6e-5 && (found[1] - high).abs() < 6e-5,
                "{found:?}"
            );
        }
    }

    #[test]
    fn counts_claims_in_their_tenths_by_motion_and_over_all() {
        let trials = [
            trial("moves", vec![claim(0.92, true), claim(0.04, false)]),
            trial("moves", vec![claim(1.0, true)]),
            trial("tones", vec![claim(0.96, false), claim(0.3, true)]),
        ];
        let motions = ["moves", "tones"].map(str::to_string);
        let table = table(&trials, &motions);
        let rows: Vec<(Option<&str>, f64, usize, usize)> = table
            .iter()
            .map(|row| (row.motion.as_deref(), row.from, row.claims, row.right))
            .collect();
        let expected = [
            (None, 0.0, 1, 0),
            (None, 0.3, 1, 1),
            (None, 0.9, 3, 2),
            (Some("moves"), 0.0, 1, 0),
            (Some("moves"), 0.9, 2, 2),
            (Some("tones"), 0.3, 1, 1),
            (Some("tones"), 0.9, 1, 0),
        ];
        assert_eq!(rows, expected);
        approx::assert_relative_eq!(table[2].stated, 0.96, epsilon = 1e-12);
    }

    /// Claims that are right as often as they say: about one tenth in twenty may lie outside of its interval.
    #[test]
    fn recovers_known_calibration() {
        use rand::RngExt;
        let mut rng = crate::robot::random::generator(8);
        let claims = |honest: &dyn Fn(f64) -> f64, rng: &mut rand_chacha::ChaCha8Rng| {
            let one = |_| {
                let probability = rng.random::<f64>();
                claim(probability, rng.random::<f64>() < honest(probability))
            };
            vec![trial("moves", (0..4000).map(one).collect())]
        };
        let outside = |trials: Vec<Trial>| {
            let rows = table(&trials, &[]);
            assert_eq!(rows.len(), TENTHS);
            let is_off = |row: &&Calibration| row.stated < row.ci95[0] || row.stated > row.ci95[1];
            rows.iter().filter(is_off).count()
        };
        // Four or more of ten with 5 % each: once in a thousand.
        assert!(outside(claims(&|p| p, &mut rng)) < 4);
        // Claims that are right as often as their square.
        assert!(outside(claims(&|p| p * p, &mut rng)) >= 6);
    }

    #[test]
    fn unnamed_is_right_of_what_has_no_name_and_names_of_themselves() {
        let hidden = |effect: &str, joint: &str| Hidden {
            effect: effect.to_string(),
            joints: vec![joint.to_string()],
            effect_over_noise: 5.0,
        };
        let rival = |effect: &str| Rival {
            effect: effect.to_string(),
            joints: vec!["j1".to_string()],
            explained_share: 0.5,
            separable: false,
            probability: 0.5,
            times_longer: None,
        };
        let right = |effect: &str, hidden: Hidden| Claim::Rival(&rival(effect)).is_right(&[hidden]);
        assert!(right("joint_spring", hidden("joint_spring", "j1")));
        assert!(!right("joint_spring", hidden("joint_spring", "j2")));
        assert!(!right("torque_ripple", hidden("joint_spring", "j1")));
        assert!(right(
            UNNAMED,
            hidden("outside: product of two speeds", "j1")
        ));
        assert!(!right(UNNAMED, hidden("joint_spring", "j1")));
    }
}
