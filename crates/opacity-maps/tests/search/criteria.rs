//! Scores against brute force, their algebra, and what they say of maps that say nothing.

use crate::rays::{random, sums, volume};
use dapple_opacity_maps::{
    Criterion,
    search::{
        Layers, Precision, Region, Scorer, Scoring,
        correlation::{bytes, one_pass, one_pass_cancelling, two_pass},
        criteria::{is_better, score_region},
        information::{LEVELS, mutual_information},
    },
};
use proptest::prelude::*;
use rand::RngExt;

const CRITERIA: [Criterion; 4] =
    [Criterion::Sad, Criterion::Correlation, Criterion::MutualInformation, Criterion::EqualOpacity];

fn score(scoring: Scoring, side: u32, layers: usize, sums: &[f32]) -> f64 {
    let layers = Layers::new((side, side), layers, layers, 0, sums).unwrap();
    Scorer::new(scoring).score(&layers).unwrap()
}

/// Map k as a series of what is scored.
fn map(layers: usize, sums: &[f32], k: usize, precision: Precision) -> Vec<f64> {
    sums.chunks(layers).map(|t| f64::from(precision.value(t[k]))).collect()
}

#[test]
fn scores_are_what_their_definitions_say_over_separate_maps() {
    let fragments = volume(37, 1, 12.0, 0.4);
    for layers in [2, 3, 5, 33] {
        let sums = sums(&fragments, 0.4, layers);
        for precision in [Precision::Float, Precision::Bytes] {
            let maps: Vec<Vec<f64>> =
                (0..layers).map(|k| map(layers, &sums, k, precision)).collect();
            let pairs = || maps.windows(2).map(|w| (&w[0], &w[1]));
            let sad: f64 =
                pairs().flat_map(|(a, b)| a.iter().zip(b)).map(|(x, y)| (y - x).abs()).sum();
            let correlation: f64 = pairs().map(|(a, b)| two_pass(a, b)).sum();
            let steps = pairs().flat_map(|(a, b)| a.iter().zip(b)).map(|(x, y)| (y - x).powi(2));
            let equal = steps.sum::<f64>() + maps[0].iter().map(|x| x * x).sum::<f64>();
            let unit = if precision == Precision::Bytes { 255.0 } else { 1.0 };
            let through = |k: usize, t: usize| (-maps[k][t] / unit).exp();
            let steps = (0..37 * 37).flat_map(|t| {
                (0..layers).map(move |k| (if k == 0 { 1.0 } else { through(k - 1, t) }, k, t))
            });
            let light: f64 = steps.map(|(before, k, t)| (before - through(k, t)).powi(2)).sum();
            for (criterion, expected, bound) in [
                (Criterion::Sad, sad, 1e-9),
                // Exponentials are 32-bit.
                (Criterion::EqualTransmittance, light, 1e-5),
                (Criterion::Correlation, correlation, 1e-9),
                (Criterion::EqualOpacity, equal, 1e-9),
            ] {
                let scoring = Scoring { precision, ..Scoring::plain(criterion) };
                let actual = score(scoring, 37, layers, &sums);
                let off = (actual - expected).abs() / expected.abs().max(1.0);
                assert!(off < bound, "{criterion:?} {precision:?} K {layers}: {actual} {expected}");
                let map = Layers::new((37, 37), layers, layers, 0, &sums).unwrap();
                let whole = score_region(&scoring, &map, Region::whole(&map, 0)).unwrap();
                assert!((whole - expected).abs() / expected.abs().max(1.0) < bound);
            }
        }
    }
}

#[test]
fn absolute_differences_of_cumulative_maps_telescope_exactly_in_integers() {
    let fragments = volume(64, 2, 9.0, 0.3);
    for (lambda, layers) in [(0.0, 4), (0.5, 7), (1.0, 32)] {
        let sums = sums(&fragments, lambda, layers);
        let byte = |x: f32| Precision::Bytes.value(x) as u64;
        let ends: u64 = sums.chunks(layers).map(|t| byte(t[layers - 1]) - byte(t[0])).sum();
        let sad = score(Scoring::thesis(Criterion::Sad), 64, layers, &sums);
        assert_eq!(sad, ends as f64);
        // A map that falls breaks the identity: the sum is then larger than its ends say.
        let mut fallen = sums.clone();
        fallen.chunks_mut(layers).for_each(|t| t[1] = 0.0);
        let ends: f64 = fallen.chunks(layers).map(|t| byte(t[layers - 1]) as f64).sum::<f64>()
            - fallen.chunks(layers).map(|t| byte(t[0]) as f64).sum::<f64>();
        assert!(score(Scoring::thesis(Criterion::Sad), 64, layers, &fallen) > ends);
    }
}

#[test]
fn differences_ask_for_the_thinnest_first_layer_and_nothing_else() {
    let fragments = volume(48, 3, 20.0, 0.2);
    for layers in [4, 8, 16, 32] {
        let at = |step: u32| {
            let sums = sums(&fragments, f64::from(step) / 10.0, layers);
            let first: f64 = sums.chunks(layers).map(|t| f64::from(t[0])).sum();
            (score(Scoring::plain(Criterion::Sad), 48, layers, &sums), first)
        };
        let scores: Vec<(f64, f64)> = (0..=10).map(at).collect();
        let best = (0..=10)
            .reduce(|a, b| if is_better(Criterion::Sad, scores[b].0, scores[a].0) { b } else { a });
        let thinnest = (0..=10).reduce(|a, b| if scores[b].1 < scores[a].1 { b } else { a });
        assert_eq!((best, best), (thinnest, Some(10)), "K {layers}");
    }
}

#[test]
fn constant_and_empty_and_saturated_maps_have_defined_scores() {
    let constant = vec![0.25f32; 8 * 8 * 4];
    let saturated: Vec<f32> = (0..8 * 8 * 4).map(|i| 2.0 + i as f32).collect();
    for (name, sums, precision) in [
        ("empty", vec![0.0; 8 * 8 * 4], Precision::Float),
        ("constant", constant, Precision::Float),
        ("saturated", saturated, Precision::Bytes),
    ] {
        let of = |criterion| score(Scoring { precision, ..Scoring::plain(criterion) }, 8, 4, &sums);
        assert_eq!(of(Criterion::Correlation), 3.0, "{name}");
        assert_eq!(of(Criterion::Sad), 0.0, "{name}");
        assert_eq!(of(Criterion::MutualInformation), 0.0, "{name}");
        assert!(of(Criterion::EqualOpacity).is_finite(), "{name}");
    }
    // All masked out; and one map has no neighbour.
    for criterion in CRITERIA {
        let masked = Scoring { mask: true, ..Scoring::plain(criterion) };
        assert!(score(masked, 8, 4, &vec![0.0; 8 * 8 * 4]).is_finite(), "{criterion:?}");
        let alone = score(Scoring::plain(criterion), 2, 1, &[0.5; 4]);
        let light = 4.0 * (1.0 - (-0.5f64).exp()).powi(2);
        match criterion {
            Criterion::EqualOpacity => assert_eq!(alone, 1.0),
            Criterion::EqualTransmittance => assert!((alone - light).abs() < 1e-6),
            _ => assert_eq!(alone, 0.0),
        }
    }
    // One constant map beside one that varies tells nothing of it.
    let half: Vec<f32> = (0..64).flat_map(|i| [0.5, i as f32]).collect();
    assert_eq!(score(Scoring::plain(Criterion::Correlation), 8, 2, &half), 0.0);
    assert_eq!(two_pass(&[], &[]), 1.0);
    assert_eq!(one_pass(&[], &[]), 1.0);
    assert_eq!(bytes(&[], &[]), 1.0);
}

#[test]
fn background_raises_correlation_and_the_mask_takes_it_away() {
    let fragments = volume(32, 4, 8.0, 0.4);
    let full = sums(&fragments, 0.3, 6);
    let mut padded = full.clone();
    padded.resize(4 * full.len(), 0.0);
    let scoring = Scoring::plain(Criterion::Correlation);
    let masked = Scoring { mask: true, ..scoring };
    let (plain, spread) = (score(scoring, 32, 6, &full), score(scoring, 64, 6, &padded));
    assert!(spread > plain + 0.05, "{plain} {spread}");
    assert!((score(masked, 64, 6, &padded) - score(masked, 32, 6, &full)).abs() < 1e-9);
    let information = Scoring::plain(Criterion::MutualInformation);
    let masked = Scoring { mask: true, ..information };
    assert_eq!(score(masked, 64, 6, &padded), score(masked, 32, 6, &full));
    assert_ne!(score(information, 64, 6, &padded), score(information, 32, 6, &full));
}

#[test]
fn one_pass_in_32_bits_cancels_where_the_shifted_sums_do_not() {
    let mut random = random(5);
    let a: Vec<f32> = (0..4096).map(|_| 1000.0 + random.random::<f32>()).collect();
    let b: Vec<f32> = a.iter().map(|x| 0.5 * x + 0.5 * random.random::<f32>()).collect();
    let wide = |s: &[f32]| s.iter().map(|&x| f64::from(x)).collect::<Vec<_>>();
    let truth = two_pass(&wide(&a), &wide(&b));
    assert!((one_pass(&wide(&a), &wide(&b)) - truth).abs() < 1e-12);
    let cancelled = f64::from(one_pass_cancelling(&a, &b));
    assert!(cancelled.is_nan() || (cancelled - truth).abs() > 0.05, "{cancelled} {truth}");
    // The scorer's sums stand the same test.
    let sums: Vec<f32> = a.iter().zip(&b).flat_map(|(&x, &y)| [x, y]).collect();
    let scored = score(Scoring::plain(Criterion::Correlation), 64, 2, &sums);
    assert!((scored - truth).abs() < 1e-10, "{scored} {truth}");
}

#[test]
fn mutual_information_is_entropy_of_a_copy_and_nothing_of_a_stranger() {
    let mut copy = vec![0u32; LEVELS * LEVELS];
    (0..8).for_each(|i| copy[i * LEVELS + i] = 100);
    assert!((mutual_information(&copy) - 8f64.ln()).abs() < 1e-12);
    let mut stranger = vec![0u32; LEVELS * LEVELS];
    (0..8).for_each(|i| (0..8).for_each(|j| stranger[i * LEVELS + j] = 5));
    assert!(mutual_information(&stranger).abs() < 1e-12);
    assert_eq!(mutual_information(&vec![0; LEVELS * LEVELS]), 0.0);
    // Correlation sees straight lines alone: y = x² about 0 has none, but is known from x.
    let x: Vec<f64> = (-20..=20).map(f64::from).collect();
    let y: Vec<f64> = x.iter().map(|x| x * x).collect();
    assert!(two_pass(&x, &y).abs() < 1e-12);
    let mut joint = vec![0u32; LEVELS * LEVELS];
    x.iter().for_each(|x| {
        joint[(x + 20.0) as usize * LEVELS + (x * x / 400.0 * 63.0) as usize] += 1;
    });
    assert!(mutual_information(&joint) > 2.0);
}

#[test]
fn mutual_information_of_maps_agrees_with_a_histogram_of_each_pair() {
    let fragments = volume(40, 6, 10.0, 0.05);
    let layers = 11;
    let sums = sums(&fragments, 0.5, layers);
    let most = sums.iter().copied().fold(0.0, f32::max);
    for (precision, most) in [(Precision::Float, most), (Precision::Bytes, 256.0)] {
        let level = |x: f32| ((precision.value(x) / most * 64.0) as usize).min(63);
        let pair = |k: usize| {
            let mut joint = vec![0u32; LEVELS * LEVELS];
            sums.chunks(layers).for_each(|t| joint[level(t[k]) * 64 + level(t[k + 1])] += 1);
            mutual_information(&joint)
        };
        let expected: f64 = (0..layers - 1).map(pair).sum();
        let scoring = Scoring { precision, ..Scoring::plain(Criterion::MutualInformation) };
        assert!((score(scoring, 40, layers, &sums) - expected).abs() < 1e-12);
        assert!(expected > 1.0);
    }
    // The greatest value has the highest level to itself.
    let ends: Vec<f32> = (0..64).flat_map(|i| [0.98 + 0.02 * (i % 2) as f32; 2]).collect();
    let copied = score(Scoring::plain(Criterion::MutualInformation), 8, 2, &ends);
    assert!((copied - 2f64.ln()).abs() < 1e-12);
}

#[test]
fn equal_opacity_is_least_where_layers_hold_the_same() {
    let even: Vec<f32> = (1..=8).map(|k| k as f32 / 8.0).collect();
    let of = |sums: &[f32]| score(Scoring::plain(Criterion::EqualOpacity), 1, 8, sums);
    let least = of(&even);
    assert!((least - 1.0 / 8.0).abs() < 1e-7);
    let mut random = random(7);
    for _ in 0..100 {
        let mut other: Vec<f32> = (0..7).map(|_| random.random()).collect();
        other.push(1.0);
        other.sort_by(f32::total_cmp);
        assert!(of(&other) >= least - 1e-7, "{other:?}");
    }
}

#[test]
fn correlation_of_unclipped_sums_cannot_tell_dense_from_sparse_and_equal_transmittance_can() {
    let thin = volume(48, 19, 40.0, 0.0625);
    let mut thick = thin.clone();
    thick.items.iter_mut().for_each(|f| f.omega *= 16.0);
    let best = |fragments, scoring: Scoring| {
        let at = |step: usize| score(scoring, 48, 8, &sums(fragments, step as f64 / 10.0, 8));
        let scores: Vec<f64> = (0..11).map(at).collect();
        let best = (0..11)
            .reduce(|a, b| if is_better(scoring.criterion, scores[b], scores[a]) { b } else { a });
        (best.unwrap(), scores)
    };
    let plain = Scoring::plain(Criterion::Correlation);
    let (a, b) = (best(&thin, plain), best(&thick, plain));
    assert_eq!(a.0, b.0);
    assert!(a.1.iter().zip(&b.1).all(|(x, y)| (x - y).abs() < 1e-5));
    let bytes = Scoring::thesis(Criterion::Correlation);
    assert_ne!(best(&thin, bytes).1, best(&thick, bytes).1);
    let light = Scoring::plain(Criterion::EqualTransmittance);
    assert!(best(&thin, light).0 + 2 < best(&thick, light).0);
}

#[test]
fn a_smaller_scoring_size_looks_at_the_texels_of_a_grid() {
    let fragments = volume(64, 8, 10.0, 0.3);
    let (layers, sums) = (5, sums(&fragments, 0.2, 5));
    let grid = |x: usize| (x % 64).is_multiple_of(4) && (x / 64).is_multiple_of(4);
    let thinned: Vec<f32> = sums
        .chunks(layers)
        .enumerate()
        .filter(|(t, _)| grid(*t))
        .flat_map(|(_, s)| s.to_vec())
        .collect();
    for criterion in [Criterion::Sad, Criterion::Correlation, Criterion::EqualOpacity] {
        let small = Scoring { side: 16, ..Scoring::plain(criterion) };
        let (a, b) = (
            score(small, 64, layers, &sums),
            score(Scoring::plain(criterion), 16, layers, &thinned),
        );
        assert!((a - b).abs() < 1e-9 * b.abs(), "{criterion:?}: {a} {b}");
    }
    // A side that is no whole part of the map's is still the most.
    let wide = vec![0.0; 100 * 60];
    let layers = Layers::new((100, 60), 1, 1, 0, &wide).unwrap();
    for (side, columns, rows) in [(64, 50, 30), (0, 100, 60), (100, 100, 60), (1, 1, 1)] {
        let texels = Region::whole(&layers, side).texels(100).count();
        assert_eq!(texels, columns * rows, "side {side}");
    }
}

#[test]
fn scores_do_not_depend_on_threads_or_on_what_was_scored_before() {
    let fragments = volume(100, 9, 10.0, 0.3);
    let sums = sums(&fragments, 0.2, 16);
    let layers = Layers::new((100, 100), 16, 16, 0, &sums).unwrap();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let many = rayon::ThreadPoolBuilder::new().num_threads(7).build().unwrap();
    for criterion in CRITERIA {
        let mut scorer = Scorer::new(Scoring::plain(criterion));
        let first = one.install(|| scorer.score(&layers).unwrap());
        let again = many.install(|| scorer.score(&layers).unwrap());
        assert_eq!(first.to_bits(), again.to_bits(), "{criterion:?}");
        assert_eq!(scorer.terms().iter().sum::<f64>(), again);
    }
}

#[test]
fn words_around_the_sums_are_not_scored_and_bad_shapes_are_refused() {
    let fragments = volume(16, 10, 10.0, 0.3);
    let sums = sums(&fragments, 0.2, 4);
    let padded: Vec<f32> =
        sums.chunks(4).flat_map(|s| [f32::NAN, 9.0, s[0], s[1], s[2], s[3], -1.0]).collect();
    let layers = Layers::new((16, 16), 4, 7, 2, &padded).unwrap();
    for criterion in CRITERIA {
        let scoring = Scoring::plain(criterion);
        let padded = Scorer::new(scoring).score(&layers).unwrap();
        assert_eq!(padded, score(scoring, 16, 4, &sums));
    }
    for (size, layers, stride, offset, named) in [
        ((0, 4), 4, 4, 0, "0 x 4"),
        ((4, 4), 0, 4, 0, "layers = 0"),
        ((4, 4), 257, 300, 0, "layers = 257"),
        ((4, 4), 4, 5, 2, "words of a texel"),
        ((4, 4), 4, 4, 0, "expected 64 elements, got 1024"),
    ] {
        let error = Layers::new(size, layers, stride, offset, &sums).unwrap_err().to_string();
        assert!(error.contains(named), "{error}");
    }
    let oracle = Scorer::new(Scoring::plain(Criterion::Oracle)).score(&layers);
    assert!(oracle.unwrap_err().to_string().contains("oracle"));
}

#[test]
fn nan_is_never_better() {
    for criterion in CRITERIA {
        assert!(!is_better(criterion, f64::NAN, 0.0) && !is_better(criterion, 0.0, f64::NAN));
        assert!(!is_better(criterion, 1.0, 1.0));
        assert_ne!(is_better(criterion, 1.0, 2.0), is_better(criterion, 2.0, 1.0));
    }
}

proptest! {
    #[test]
    fn correlation_is_a_cosine(
        pairs in prop::collection::vec((-100.0f64..100.0, -100.0f64..100.0), 0..60),
        scale in prop_oneof![-50.0f64..-0.1, 0.1f64..50.0],
        offset in -1e3f64..1e3,
    ) {
        let (a, b): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
        let c = two_pass(&a, &b);
        prop_assert!((-1.0..=1.0).contains(&c));
        prop_assert!((c - two_pass(&b, &a)).abs() < 1e-12);
        prop_assert!((c - one_pass(&a, &b)).abs() < 1e-9);
        prop_assert!((two_pass(&a, &a) - 1.0).abs() < 1e-9);
        let line: Vec<f64> = a.iter().map(|x| scale * x + offset).collect();
        if a.len() > 1 {
            prop_assert!((two_pass(&a, &line) - scale.signum()).abs() < 1e-9);
            prop_assert!((two_pass(&line, &b) - scale.signum() * c).abs() < 1e-9);
        }
    }

    #[test]
    fn bytes_agree_with_two_passes(
        pairs in prop::collection::vec((0u8..=255, 0u8..=255), 0..80),
    ) {
        let (a, b): (Vec<u8>, Vec<u8>) = pairs.into_iter().unzip();
        let wide = |s: &[u8]| s.iter().map(|&x| f64::from(x)).collect::<Vec<_>>();
        prop_assert!((bytes(&a, &b) - two_pass(&wide(&a), &wide(&b))).abs() < 1e-9);
    }
}
