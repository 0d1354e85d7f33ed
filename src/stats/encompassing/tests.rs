//! Levels, slopes and degrees of freedom of the test of one model against another.

use super::*;
use rand::SeedableRng;
use rand_distr::{Distribution as _, StandardNormal};

fn noise(rows: usize, seed: u64) -> Vec<f64> {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    (0..rows)
        .map(|_| StandardNormal.sample(&mut random))
        .collect()
}

/// The residuals of two models of one channel.
fn test(poorer: &[f64], richer: &[f64], noise: Option<&[f64]>) -> Encompassing {
    let pair = ResidualPair {
        poorer: &[poorer.to_vec()],
        richer: &[richer.to_vec()],
    };
    pair.encompassing(
        Known {
            noise,
            ..Known::default()
        },
        ResidualRows::Recorded,
    )
}

#[test]
fn recovers_the_ratio_of_normal_likelihoods() {
    // b = 0.8 with s = 0.25: ((0.8)² − (0.2)²) / (2 · 0.0625).
    let evidence = Encompassing {
        slope: 0.8,
        ratio: 3.2,
        distance: 4.0,
        freedom: 1e6,
        p_value: 0.5,
    };
    let expected = (0.64 - 0.04) / 0.125;
    assert!((evidence.log_likelihood_ratio() - expected).abs() < 1e-4);
}

/// Of 400 true null hypotheses about 0.05 · 400 = 20 are rejected at 5 %; the standard deviation of
/// the count is 4.4.
#[test]
fn matches_the_stated_level_where_nothing_is_missing() {
    let rows = 1000;
    let mut rejected = 0;
    for seed in 0..400 {
        let e = noise(rows, seed);
        let spurious: Vec<f64> = (0..rows).map(|k| 0.1 * (k as f64 * 0.013).sin()).collect();
        let richer: Vec<f64> = e.iter().zip(&spurious).map(|(e, s)| e - s).collect();
        let evidence = test(&e, &richer, None);
        rejected += usize::from(evidence.p_value < 0.05);
    }
    let expected = 20.0;
    assert!(
        (f64::from(rejected as u32) - expected).abs() < 3.0 * 4.4,
        "{rejected}"
    );
}

#[test]
fn recovers_a_slope_of_one_where_the_richer_model_is_right() {
    let e = noise(1000, 7);
    let effect: Vec<f64> = (0..1000).map(|k| (k as f64 * 0.02).sin()).collect();
    let poorer: Vec<f64> = e.iter().zip(&effect).map(|(e, s)| e + s).collect();
    let evidence = test(&poorer, &e, None);
    // The slope has a standard deviation of 1/√(Σ s²) = 1/√500.
    assert!((evidence.slope - 1.0).abs() < 4.0 / 500.0_f64.sqrt());
    assert!(evidence.p_value < 1e-6);
}

/// A difference of a few rows in one place, as an impact is: one block does not tell its variance, noise that is
/// known does.
fn impact(rows: usize) -> Vec<f64> {
    let mut effect = vec![0.0; rows];
    for (k, height) in [3.0, -5.0, 4.0, 2.0].into_iter().enumerate() {
        effect[400 + k] = height;
    }
    effect
}

#[test]
fn impacts_count_where_the_noise_is_known() {
    let e = noise(1000, 3);
    let poorer: Vec<f64> = e.iter().zip(impact(1000)).map(|(e, s)| e + s).collect();
    let of_blocks = test(&poorer, &e, None);
    assert!(of_blocks.p_value > 0.1, "{of_blocks:?}");
    let known = test(&poorer, &e, Some(&[1.0]));
    assert!(known.p_value < 1e-6, "{known:?}");
}

#[test]
fn known_noise_keeps_the_level_where_models_differ_in_one_place() {
    let mut rejected = 0;
    for seed in 0..400 {
        let e = noise(1000, seed);
        let richer: Vec<f64> = e
            .iter()
            .zip(impact(1000))
            .map(|(e, s)| e - 0.2 * s)
            .collect();
        let evidence = test(&e, &richer, Some(&[1.0]));
        rejected += usize::from(evidence.p_value < 0.05);
    }
    // 20 are expected with a standard deviation of 4.4.
    assert!((rejected as f64 - 20.0).abs() < 3.0 * 4.4, "{rejected}");
}

/// Where models differ equally in three blocks, the ratio is Student's t of the three means, of two degrees of freedom,
/// whose upper tail is 1/2 − t/(2 √(2 + t²)).
#[test]
fn matches_the_t_test_of_block_means() {
    const BLOCKS: usize = 24;
    let means = [0.9, 2.1, 1.2];
    let mut poorer = noise(BLOCKS * LEAST_BLOCK, 5);
    let mut richer = poorer.clone();
    for (block, mean) in means.into_iter().enumerate() {
        let rows = 8 * block * LEAST_BLOCK..(8 * block + 1) * LEAST_BLOCK;
        let off = mean - poorer[rows.clone()].iter().sum::<f64>() / LEAST_BLOCK as f64;
        for row in rows {
            poorer[row] += off;
            richer[row] = poorer[row] - 1.0;
        }
    }
    assert_eq!(block_length(&[richer.clone()]), LEAST_BLOCK);
    let pair = ResidualPair {
        poorer: &[poorer],
        richer: &[richer],
    };
    let found = pair.encompassing(Known::default(), ResidualRows::Filtered);
    let mean = means.iter().sum::<f64>() / 3.0;
    let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / 2.0;
    let t = mean / (variance / 3.0).sqrt();
    let tail = 0.5 - t / (2.0 * (2.0 + t * t).sqrt());
    assert!((found.slope - mean).abs() < 1e-12, "{found:?}");
    assert!((found.freedom - 2.0).abs() < 1e-12, "{found:?}");
    assert!((found.ratio - t).abs() < 1e-12, "{found:?}, {t}");
    assert!((found.p_value - tail).abs() < 1e-9, "{found:?}, {tail}");
}
/// A poorer model y = θ x that was fitted to rows with x of size 1 and judged where x is three times as large, beside
/// one that also has the regressor x³, of which there is nothing: of 400 true null hypotheses 20 are rejected at 5 %,
/// with a standard deviation of 4.4, and many more where the error of θ is forgotten. Over whole periods of a sine
/// that error adds 7.9 times the variance of the rest.
#[test]
fn errors_of_parameters_keep_the_level_beyond_the_fitted_range() {
    const ROWS: usize = 400;
    let regressor = |size: f64| -> [Vec<f64>; 2] {
        let x = (0..ROWS).map(|k| size * (k as f64 * 0.05).sin());
        [x.clone().collect(), x.map(|x| x.powi(3)).collect()]
    };
    let (fitted, judged) = (regressor(1.0), regressor(3.0));
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let [xx, xz, zz] = [(0, 0), (0, 1), (1, 1)].map(|(i, j)| dot(&fitted[i], &fitted[j]));
    let estimates = EstimationError {
        derivatives: &[vec![Some(judged[0].clone())]],
        kept: &[None],
        variance: &|g| g.norm_squared() / xx,
    };
    let (mut rejected, mut forgetful) = (0, 0);
    for seed in 0..400 {
        let (seen, unseen) = (noise(ROWS, seed), noise(ROWS, 1000 + seed));
        let (xe, ze) = (dot(&fitted[0], &seen), dot(&fitted[1], &seen));
        let alone = xe / xx;
        let determinant = xx * zz - xz * xz;
        let both = [
            (zz * xe - xz * ze) / determinant,
            (xx * ze - xz * xe) / determinant,
        ];
        let rows = 0..ROWS;
        let left = |by: [f64; 2]| -> Vec<f64> {
            let of = |k: usize| unseen[k] - by[0] * judged[0][k] - by[1] * judged[1][k];
            rows.clone().map(of).collect()
        };
        let (poorer, richer) = ([left([alone, 0.0])], [left(both)]);
        let pair = ResidualPair {
            poorer: &poorer,
            richer: &richer,
        };
        let p_value = |estimates| {
            let known = Known {
                estimates,
                ..Known::default()
            };
            pair.encompassing(known, ResidualRows::Recorded).p_value
        };
        rejected += usize::from(p_value(Some(&estimates)) < 0.05);
        forgetful += usize::from(p_value(None) < 0.05);
    }
    assert!((rejected as f64 - 20.0).abs() < 3.0 * 4.4, "{rejected}");
    assert!(forgetful > 2 * rejected, "{forgetful}");
}

/// Where blocks say nothing and the noise σ of a row is known, the ratio is `Σ d e / (σ √Σ d²)`, whatever the residual's own
/// scale, and has as many degrees of freedom as there are rows.
#[test]
fn matches_the_z_test_where_the_noise_is_known() {
    const ROWS: usize = 1000;
    // Neighbours that differ in sign remember nothing that lengthens blocks.
    let richer: Vec<f64> = (0..ROWS).map(|k| [2.5, -2.5][k % 2]).collect();
    let d = impact(ROWS);
    let poorer: Vec<f64> = richer.iter().zip(&d).map(|(e, d)| e + d).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let expected = dot(&d, &poorer) / (0.4 * dot(&d, &d).sqrt());
    let pair = ResidualPair {
        poorer: &[poorer],
        richer: &[richer],
    };
    let known = Known {
        noise: Some(&[0.4]),
        ..Known::default()
    };
    let found = pair.encompassing(known, ResidualRows::Filtered);
    assert!((found.ratio / expected - 1.0).abs() < 1e-12, "{found:?}");
    assert!((found.freedom / ROWS as f64 - 1.0).abs() < 1e-12);
}

/// Satterthwaite's degrees of freedom of a sum, of which those that are known are many.
#[test]
fn matches_the_freedom_of_a_sum_of_variances() {
    let known = Variance {
        value: 1.0,
        freedom: 100.0,
    };
    let shown = |value: f64| Variance {
        value,
        freedom: 10.0,
    };
    let both = shown(3.0).at_least(known);
    assert_eq!(both.value, 3.0);
    assert!((both.freedom - 9.0 / (0.01 + 0.4)).abs() < 1e-12);
    let both = shown(0.5).at_least(known);
    assert_eq!(both.value, 1.0);
    assert!((both.freedom - 100.0).abs() < 1e-9);
    let both = shown(3.0).with(1.0);
    assert_eq!(both.value, 4.0);
    assert!((both.freedom - 10.0 * (4.0_f64 / 3.0).powi(2)).abs() < 1e-12);
}

/// Noise of which each row keeps a share of the row before it.
fn red_noise(rows: usize, kept: f64, seed: u64) -> Vec<f64> {
    let mut last = 0.0;
    let fresh = noise(rows + 1000, seed);
    let all = fresh.iter().map(|e| {
        last = kept * last + e;
        last
    });
    all.skip(1000).collect()
}

/// Models that differ in the mean alone, in noise that forgets twenty times in the recording: of 20 000 true null hypotheses
/// 2 are rejected at one in ten thousand, give or take 1.4; many more if the colour of the noise were known.
#[test]
fn red_noise_keeps_the_level_where_models_differ_slowly() {
    let rows = 800;
    let (mut rejected, mut of_known_colour) = (0, 0);
    for seed in 0..20_000 {
        let e = red_noise(rows, 0.95, seed);
        let richer: Vec<f64> = e.iter().map(|e| e - 1.0).collect();
        let evidence = test(&e, &richer, None);
        rejected += usize::from(evidence.p_value < 1e-4);
        let known = Distribution::Normal.upper_tail(evidence.ratio);
        of_known_colour += usize::from(known < 1e-4);
    }
    assert!(rejected <= 6, "{rejected}");
    assert!(of_known_colour > 12, "{of_known_colour}");
}

/// A residual of the same shape, only smaller, varies by nothing between blocks, which is no evidence.
#[test]
fn without_a_variance_there_is_no_evidence() {
    let richer = noise(500, 4);
    let poorer = richer.iter().map(|e| 2.0 * e).collect();
    let pair = ResidualPair {
        poorer: &[poorer],
        richer: &[richer],
    };
    let found = pair.encompassing(Known::default(), ResidualRows::Filtered);
    assert_eq!((found.slope, found.ratio, found.distance), (2.0, 0.0, 0.0));
    assert!((found.p_value - 0.5).abs() < 1e-12);
}

/// A run of L equal rows among zeros has the autocorrelation (L − l)/L at lag l, and 1 + 2 Σ ρ = L while ρ is no smaller
/// than 2/√n.
#[test]
fn blocks_are_four_correlation_times_long() {
    let run = |rows: usize, length: usize| {
        let series = (0..rows).map(|k| if k < length { 3.0 } else { 0.0 });
        vec![series.collect::<Vec<f64>>()]
    };
    assert_eq!(block_length(&run(1024, 10)), 40);
    // At the lag 31 the autocorrelation is 2/√n.
    assert_eq!(block_length(&run(4096, 32)), 128);
    // Eight rows at least, and twenty-four blocks.
    assert_eq!(block_length(&run(1024, 1)), 8);
    assert_eq!(block_length(&run(1000, 1000)), 41);
    assert_eq!(block_length(&[vec![0.0; 1000]]), 8);
}

/// Impacts in forty places, of sizes so different that one of them has most of the squares.
fn impacts(rows: usize, seed: u64) -> Vec<f64> {
    let mut effect = vec![0.0; rows];
    let places = (rows / 80..rows).step_by(rows / 40);
    for (place, size) in places.zip(noise(40, seed)) {
        for k in 0..3 {
            effect[place + k] = (2.0 * size).exp() * [1.0, -1.4, 0.8][k];
        }
    }
    effect
}

/// Of 400 true null hypotheses about 20 are rejected at 5 %, with a standard deviation of 4.4: in noise that is alike
/// everywhere, and in noise that is five times larger about the impacts.
#[test]
fn impacts_of_many_sizes_keep_the_level() {
    let rows = 1600;
    for louder in [1.0, 5.0] {
        let mut rejected = 0;
        for seed in 0..400 {
            let effect = impacts(rows, 1000 + seed);
            let e = noise(rows, seed);
            let level = |k: usize| match effect[k] == 0.0 {
                true => 1.0,
                false => louder,
            };
            let poorer: Vec<f64> = (0..rows).map(|k| level(k) * e[k]).collect();
            let richer: Vec<f64> = (0..rows).map(|k| poorer[k] - effect[k]).collect();
            rejected += usize::from(test(&poorer, &richer, None).p_value < 0.05);
        }
        assert!(
            (rejected as f64 - 20.0).abs() < 3.0 * 4.4,
            "{rejected}, noise {louder}"
        );
    }
}

#[test]
fn impacts_of_many_sizes_are_evidence_where_the_richer_model_is_right() {
    for seed in 0..20 {
        let (e, effect) = (noise(1600, seed), impacts(1600, 1000 + seed));
        let poorer: Vec<f64> = e.iter().zip(&effect).map(|(e, s)| e + s).collect();
        let evidence = test(&poorer, &e, None);
        // Student's t of one degree of freedom, which the largest impact alone has, is beyond 100 in one of 300 cases.
        assert!(evidence.p_value < 1e-4, "{seed}: {evidence:?}");
    }
}
