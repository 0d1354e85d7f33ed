//! A stated rate of false discoveries among many groups of tests: groups by Benjamini and Hochberg (1995), tests within
//! them by Benjamini and Bogomolov (2014, "Selective inference on multiple families of hypotheses", J. R. Stat. Soc. B 76).
//!
//! With N groups of m tests each a group has the p-value `m · min p` (Bonferroni), which holds however its tests depend
//! on each other. The R groups of least p-values are listed with the largest R for which the R-th is at most q·R/N; within
//! a listed group, tests with `p ≤ q·R/(N·m)`.

/// What is listed among N groups at a rate q.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Listing {
    /// q.
    pub rate: f64,
    /// N.
    pub groups: usize,
    /// R.
    pub listed: usize,
}

impl Listing {
    /// Of the p-values of all groups.
    pub fn of(mut groups: Vec<f64>, rate: f64) -> Self {
        groups.sort_unstable_by(f64::total_cmp);
        let count = groups.len() as f64;
        let ranks = groups.iter().enumerate().rev();
        let last = ranks
            .map(|(index, p)| (index + 1, *p))
            .find(|(rank, p)| *p <= rate * *rank as f64 / count);
        Self {
            rate,
            groups: groups.len(),
            listed: last.map_or(0, |(rank, _)| rank),
        }
    }

    /// The rate at which a test of a group with so many tests would just be listed among as many groups; it is listed
    /// where this is at most [`Self::rate`].
    pub fn rate_of(&self, p: f64, tests: usize) -> f64 {
        let listed = self.listed.max(1) as f64;
        p * tests as f64 * self.groups as f64 / listed
    }

    /// Whether a group is listed whose test has this p-value, where so many tests were made within the group.
    pub fn lists(&self, p: f64, tests: usize) -> bool {
        self.listed > 0 && self.rate_of(p, tests) <= self.rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::distribution::Distribution;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution as _, StandardNormal};

    #[test]
    fn matches_the_published_example() {
        // Benjamini and Hochberg 1995, section 3.2: fifteen p-values, of which four are listed at 5 %.
        let p = vec![
            0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344, 0.0459, 0.3240, 0.4262,
            0.5719, 0.6528, 0.7590, 1.0,
        ];
        assert_eq!(Listing::of(p, 0.05).listed, 4);
        assert_eq!(Listing::of(vec![0.5, 0.9], 0.05).listed, 0);
        assert!(!Listing::of(vec![0.5], 0.05).lists(1e-9, 1));
    }

    /// 500 fleets of 200 robots of ten tests that depend on each other, one robot in twenty changed by four deviations:
    /// the mean share of false robots among those listed stays below the rate.
    #[test]
    fn invariant_share_of_false_groups_stays_below_the_rate() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let (mut share, mut found) = (0.0, 0);
        const FLEETS: usize = 500;
        for _ in 0..FLEETS {
            let robots: Vec<f64> = (0..200)
                .map(|robot| {
                    let common = draw();
                    let tests = (0..10).map(|test| {
                        let z = 0.6 * common + 0.8 * draw();
                        let change = if robot < 10 && test == 0 { 5.0 } else { 0.0 };
                        2.0 * Distribution::Normal.upper_tail((z + change).abs())
                    });
                    (10.0 * tests.fold(1.0, f64::min)).min(1.0)
                })
                .collect();
            let listing = Listing::of(robots.clone(), 0.05);
            let listed = |p: &f64| *p <= 0.05 * listing.listed as f64 / 200.0;
            let wrong = robots[10..].iter().filter(|p| listed(p)).count();
            found += listing.listed - wrong;
            share += wrong as f64 / listing.listed.max(1) as f64;
        }
        assert!(share / (FLEETS as f64) < 0.05, "{}", share / FLEETS as f64);
        assert!(found > 9 * FLEETS * 10 / 10 / 2, "{found}");
    }
}
