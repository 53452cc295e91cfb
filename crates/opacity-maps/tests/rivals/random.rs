//! The stochastic map estimates without bias.

use crate::support::{self, Texel, at};
use dapple_opacity_maps::{Fragment, code, reference};

/// Mean of T over texels, its standard error by the binomial, and the truth.
fn estimate(
    fragments: &[Fragment],
    samples: u32,
    depth: f32,
    texel: fn(usize) -> usize,
) -> [f64; 3] {
    let n = 4000;
    let settings = support::stochastic(samples, 11);
    let t = |i: usize| {
        f64::from(Texel::with_code(code::of(&settings), texel(i), fragments, None).t(depth))
    };
    let mean = (0..n).map(t).sum::<f64>() / f64::from(n as u32);
    let truth = reference::exact(fragments, depth);
    [mean, (truth * (1.0 - truth) / f64::from(n as u32 * samples)).sqrt(), truth]
}

fn deviations([mean, error, truth]: [f64; 3]) -> f64 {
    (mean - truth).abs() / error
}

#[test]
fn its_mean_over_texels_is_the_product_of_what_fragments_let_through() {
    let rays = [
        vec![at(0.3, 0.5)],
        vec![at(0.3, 0.02), at(0.4, 0.03), at(0.5, 1.5)],
        support::hair(5, 12),
    ];
    for ray in &rays {
        for samples in [1, 16] {
            for depth in [0.45, 1.0] {
                // 12 tests: each at 4 standard deviations is one of 1 % in all.
                let found = estimate(ray, samples, depth, |i| i);
                assert!(deviations(found) < 4.0, "{found:?}");
            }
        }
    }
    // Control: without the texel in the hash, every texel draws the same samples.
    let same = estimate(&rays[0], 1, 1.0, |_| 0);
    assert!(deviations(same) > 20.0, "{same:?}");
}

#[test]
fn its_mean_over_seeds_is_too() {
    let ray = support::hair(9, 8);
    let truth = reference::exact(&ray, 0.6);
    let n = 2000;
    let t = |seed| f64::from(Texel::new(&support::stochastic(4, seed), &ray).t(0.6));
    let mean = (0..n).map(t).sum::<f64>() / f64::from(n);
    let error = (truth * (1.0 - truth) / f64::from(4 * n)).sqrt();
    assert!((mean - truth).abs() < 4.0 * error, "{mean} {truth} {error}");
}

#[test]
fn samples_of_a_texel_are_independent() {
    // The variance over texels is T(1 - T)/S, not that of fewer samples.
    let ray = [at(0.3, 0.7)];
    let truth = reference::exact(&ray, 1.0);
    for samples in [4, 64] {
        let settings = support::stochastic(samples, 3);
        let n = 4000;
        let square = |i| {
            let t = Texel::with_code(code::of(&settings), i, &ray, None).t(1.0);
            (f64::from(t) - truth).powi(2)
        };
        let variance = (0..n).map(square).sum::<f64>() / n as f64;
        let ratio = variance / (truth * (1.0 - truth) / f64::from(samples));
        // The sample variance of 4000 has a standard error of 2.2 %.
        assert!((0.9..1.1).contains(&ratio), "{samples}: {ratio}");
    }
}

#[test]
fn fragments_at_one_depth_share_their_samples() {
    // A stated limit, so that nobody meets it unawares: the more opaque of the two counts.
    let both = Texel::new(&support::stochastic(64, 3), &[at(0.5, 0.4), at(0.5, 0.9)]);
    let one = Texel::new(&support::stochastic(64, 3), &[at(0.5, 0.9)]);
    assert_eq!(both.words, one.words);
}
