//! Stochastic shadow map: each of S samples of a texel keeps the nearest of the fragments that
//! survive a random test of their opacity.
//!
//! Based on: Eric Enderton, Erik Sintorn, Peter Shirley, David Luebke, "Stochastic transparency",
//! I3D 2010, §3 (a fragment covers a sample with probability α; the depth test keeps the nearest)
//! and §5 (shadow maps); Morgan McGuire, Eric Enderton, "Colored stochastic shadow maps", I3D
//! 2011, §3 (one light, one colour here).
//!
//! A sample is lit at d if none of the fragments in front of d covers it, which has probability
//! Π(1 - α) = e^-Σω: the share of lit samples is an estimate without bias, of variance T(1 - T)/S.
//! T falls monotonically with d, in steps of 1/S; it is 1 in front of everything.
//!
//! Deviations: samples are independent, not stratified over the fragment's α (that lowers the
//! variance and needs a random order of samples for each fragment). The random number is a hash of
//! seed, texel, depth and sample, so that any order of drawing and any form gives the same bits;
//! two fragments of one texel at exactly the same depth therefore share their random numbers, and
//! act as the more opaque of the two.

use crate::{Fragment, NO_OPAQUE, Stochastic, code::TexelCode, gather, taps::hash};

/// S depths a texel.
pub struct Code(pub Stochastic);

/// A random number in 0..2^24 for each sample of a fragment: [`random`] of this and of the sample.
fn of_fragment(seed: u32, texel: usize, depth: f32) -> u32 {
    // -0 and 0 are one depth.
    hash(hash(texel as u32 ^ hash(seed)) ^ (depth + 0.0).to_bits())
}

fn random(fragment: u32, sample: u32) -> u32 {
    hash(fragment.wrapping_add(sample.wrapping_mul(0x9e37_79b9))) >> 8
}

/// Random numbers below this survive: α = 1 - e^-ω of 2^24, rounded to nearest.
fn threshold(omega: f32) -> u32 {
    (-(-f64::from(omega)).exp_m1() * f64::from(1 << 24)).round() as u32
}

impl TexelCode for Code {
    fn words(&self) -> usize {
        self.0.samples as usize
    }

    fn encode(
        &self,
        texel: usize,
        fragments: &[Fragment],
        opaque: Option<Fragment>,
        _: &mut Vec<Fragment>,
        words: &mut [f32],
    ) {
        words.fill(NO_OPAQUE);
        for f in gather::everything(fragments, opaque) {
            let (fragment, below) = (of_fragment(self.0.seed, texel, f.depth), threshold(f.omega));
            for (sample, nearest) in (0..).zip(words.iter_mut()) {
                // Behind the nearest survivor nothing matters: most fragments draw few numbers.
                if f.depth < *nearest && random(fragment, sample) < below {
                    *nearest = f.depth;
                }
            }
        }
    }

    fn decode(&self, _: usize, words: &[f32], depth: f32) -> f32 {
        let depth = depth.min(NO_OPAQUE);
        let lit = words.iter().filter(|&&nearest| nearest >= depth).count();
        lit as f32 / words.len().max(1) as f32
    }

    fn bytes_per_texel(&self) -> u64 {
        4 * u64::from(self.0.samples)
    }

    fn geometry_passes(&self) -> u64 {
        1
    }
}

/// The share of samples that no fragment strictly in front of `depth` covers. The processor's form
/// equals it to the rounding of one division.
pub fn reference(
    settings: &Stochastic,
    texel: usize,
    fragments: &[Fragment],
    opaque: Option<Fragment>,
    depth: f32,
) -> f64 {
    let covers = |f: &Fragment, sample: u32| {
        let alpha = 1.0 - (-f64::from(f.omega)).exp();
        let of_2_24 = (alpha * f64::from(1 << 24)).round();
        f64::from(random(of_fragment(settings.seed, texel, f.depth), sample)) < of_2_24
    };
    let in_front = || fragments.iter().chain(&opaque).filter(|f| f.depth < depth);
    let lit = (0..settings.samples).filter(|&s| !in_front().any(|f| covers(f, s))).count();
    lit as f64 / f64::from(settings.samples)
}
