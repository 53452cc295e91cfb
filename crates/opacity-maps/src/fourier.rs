//! Fourier opacity map: the absorption along a ray as a Fourier series.
//!
//! Based on: Jon Jansen, Louis Bavoil, "Fourier opacity mapping", I3D 2010, §3: coefficients
//! a_k = 2 Σ ω_i cos(2πk d_i), b_k = 2 Σ ω_i sin(2πk d_i) of the absorption Σ ω_i δ(d - d_i) are
//! added by blending, and integrated term by term,
//! Ω(d) = a_0 d / 2 + Σ_k a_k sin(2πkd) / (2πk) + b_k (1 - cos(2πkd)) / (2πk), T = e^-Ω.
//!
//! The series is cut off after n pairs: Ω rings (Gibbs) by up to 9 % of a fragment's ω at a
//! fragment, and is neither monotone nor kept above 0; T is clamped to 1. It blurs over about
//! 1/(2n) of the range. Ω is 0 at the near end and the total at the far end, exactly. Both ends
//! are one point of the circle, though: of a fragment at either end, half counts just inside
//! it and half just inside the other.
//!
//! Deviations: depths are linear in the light's range, or between each ray's own bounds
//! (`bounded`; two more words), where T is exactly 1 up to the first fragment and e^-a_0/2 behind
//! the last. So that these two do not meet on the circle, a ray's bounds are mapped to
//! 0 + p ..= 1 - p with the padding p = 1 / (4 (n + 1)): through hair that takes nearly
//! half off the error of 7 pairs.

use crate::{
    Format, Fourier, Fragment,
    code::TexelCode,
    gather::{self, Place, WHOLE},
    layered::placement::Bounds,
};
use std::f64::consts::TAU;

/// Most pairs of coefficients.
const MOST_PAIRS: usize = 15;

/// Bounds first where there are any, then a_0, then a_k and b_k in turn.
pub struct Code {
    /// Knobs.
    pub settings: Fourier,
    /// Whether the opaque fragment stretches the bounds.
    pub opaque_in_bounds: bool,
}

impl Code {
    fn pairs(&self) -> usize {
        (self.settings.pairs as usize).min(MOST_PAIRS)
    }

    /// Words before the coefficients.
    fn header(&self) -> usize {
        if self.settings.bounded { 2 } else { 0 }
    }

    fn bounds(&self, words: &[f32]) -> Bounds {
        if self.settings.bounded { Bounds { first: words[0], last: words[1] } } else { WHOLE }
    }

    /// Ω at a depth, neither clamped nor rounded.
    fn omega(&self, words: &[f32], depth: f32) -> f32 {
        let coefficients = &words[self.header()..];
        let total = 0.5 * coefficients[0];
        let angle = match gather::place(self.bounds(words), depth) {
            Place::Front => return 0.0,
            Place::Behind => return total,
            Place::Inside(share) => angle(&self.settings, f64::from(share)) as f32,
        };
        let (sin, cos) = angle.sin_cos();
        let (mut sin_k, mut cos_k) = (sin, cos);
        let mut sum = 0.0;
        for (k, pair) in (1u8..).zip(coefficients[1..].chunks_exact(2)) {
            sum += (pair[0] * sin_k + pair[1] * (1.0 - cos_k)) / f32::from(k);
            (sin_k, cos_k) = (sin_k * cos + cos_k * sin, cos_k * cos - sin_k * sin);
        }
        (total * angle + sum) / TAU as f32
    }
}

/// The place on the circle of a share of the way between the bounds.
fn angle(settings: &Fourier, share: f64) -> f64 {
    let padding = if settings.bounded { 0.25 / (f64::from(settings.pairs) + 1.0) } else { 0.0 };
    TAU * (padding + share * (1.0 - 2.0 * padding))
}

/// Adds a fragment's terms.
fn add(coefficients: &mut [f32], omega: f32, angle: f32) {
    let twice = 2.0 * omega;
    coefficients[0] += twice;
    let (sin, cos) = angle.sin_cos();
    let (mut sin_k, mut cos_k) = (twice * sin, twice * cos);
    for pair in coefficients[1..].chunks_exact_mut(2) {
        pair[0] += cos_k;
        pair[1] += sin_k;
        (sin_k, cos_k) = (sin_k * cos + cos_k * sin, cos_k * cos - sin_k * sin);
    }
}

/// The same rounded to halves. Terms are in f64, so that rounding falls the same way in every form.
fn add_halves(coefficients: &mut [f32], omega: f32, angle: f64) {
    let twice = 2.0 * f64::from(omega);
    let (sin, cos) = angle.sin_cos();
    let (mut sin_k, mut cos_k) = (twice * sin, twice * cos);
    let add = |sum: &mut f32, term: f64| {
        *sum = gather::stored(Format::F16, f64::from(*sum) + term);
    };
    add(&mut coefficients[0], twice);
    for pair in coefficients[1..].chunks_exact_mut(2) {
        add(&mut pair[0], cos_k);
        add(&mut pair[1], sin_k);
        (sin_k, cos_k) = (sin_k * cos + cos_k * sin, cos_k * cos - sin_k * sin);
    }
}

/// e^-Ω, at most 1.
fn clamped(omega: f32) -> f32 {
    (-omega.max(0.0)).exp()
}

impl TexelCode for Code {
    fn words(&self) -> usize {
        self.header() + 1 + 2 * self.pairs()
    }

    fn encode(
        &self,
        _: usize,
        fragments: &[Fragment],
        opaque: Option<Fragment>,
        _: &mut Vec<Fragment>,
        words: &mut [f32],
    ) {
        let mut bounds = WHOLE;
        if self.settings.bounded {
            bounds = Bounds::of(fragments, opaque, self.opaque_in_bounds);
            words[..2].copy_from_slice(&[bounds.first, bounds.last]);
        }
        let coefficients = &mut words[self.header()..];
        coefficients.fill(0.0);
        for f in gather::everything(fragments, opaque) {
            let angle = angle(&self.settings, gather::share(bounds, f.depth));
            match self.settings.format {
                Format::F16 => add_halves(coefficients, f.omega, angle),
                _ => add(coefficients, f.omega, angle as f32),
            }
        }
    }

    fn decode(&self, _: usize, words: &[f32], depth: f32) -> f32 {
        clamped(self.omega(words, depth))
    }

    /// Over the whole range coefficients are averaged: Ω is linear in them.
    fn decode_mean(&self, _: (usize, &[f32]), taps: &[(usize, &[f32])], depth: f32) -> f32 {
        let n = taps.len().max(1) as f32;
        if self.settings.bounded {
            return taps.iter().map(|(_, words)| clamped(self.omega(words, depth))).sum::<f32>()
                / n;
        }
        let mut mean = [0.0; 1 + 2 * MOST_PAIRS];
        let mean = &mut mean[..self.words()];
        for (_, words) in taps {
            mean.iter_mut().zip(*words).for_each(|(sum, word)| *sum += word / n);
        }
        clamped(self.omega(mean, depth))
    }

    fn bytes_per_texel(&self) -> u64 {
        let coefficients = 1 + 2 * u64::from(self.settings.pairs);
        4 * self.header() as u64 + coefficients * gather::bytes(self.settings.format)
    }

    /// One for all coefficients; one before it for both bounds.
    fn geometry_passes(&self) -> u64 {
        1 + u64::from(self.settings.bounded)
    }
}

/// Ω(d) of the cut-off series in f64, neither clamped nor by recurrences: each coefficient from its
/// definition, each term from its integral. Halves are rounded after each addition, 32-bit sums
/// are not.
pub fn reference_omega(
    settings: &Fourier,
    fragments: &[Fragment],
    opaque: Option<Fragment>,
    opaque_in_bounds: bool,
    depth: f32,
) -> f64 {
    let bounds =
        if settings.bounded { Bounds::of(fragments, opaque, opaque_in_bounds) } else { WHOLE };
    let place = |share| angle(settings, share);
    let coefficient = |of: &dyn Fn(f64) -> f64| {
        gather::everything(fragments, opaque).fold(0.0, |sum, f| {
            let term = 2.0 * f64::from(f.omega) * of(place(gather::share(bounds, f.depth)));
            gather::stored_exactly(settings.format, sum + term)
        })
    };
    let total = coefficient(&|_| 1.0) / 2.0;
    let end = match gather::place(bounds, depth) {
        Place::Front => return 0.0,
        Place::Behind => return total,
        Place::Inside(_) => place(gather::share(bounds, depth)),
    };
    let term = |k: u32| {
        let k = f64::from(k);
        let cosine = coefficient(&|angle| (k * angle).cos()) * (k * end).sin();
        let sine = coefficient(&|angle| (k * angle).sin()) * (1.0 - (k * end).cos());
        (cosine + sine) / k
    };
    (total * end + (1..=settings.pairs).map(term).sum::<f64>()) / TAU
}

/// T(d) = e^-Ω(d), at most 1. The processor's form follows it to [`port_bound`].
pub fn reference(
    settings: &Fourier,
    fragments: &[Fragment],
    opaque: Option<Fragment>,
    opaque_in_bounds: bool,
    depth: f32,
) -> f64 {
    (-reference_omega(settings, fragments, opaque, opaque_in_bounds, depth).max(0.0)).exp()
}

/// T(d) of coefficients averaged over several texels' fragments, over the light's whole range: Ω is
/// linear in them.
pub fn reference_mean<'a>(
    settings: &Fourier,
    texels: impl Iterator<Item = (&'a [Fragment], Option<Fragment>)>,
    depth: f32,
) -> f64 {
    let omega = |(fragments, opaque)| reference_omega(settings, fragments, opaque, false, depth);
    let (sum, n) = texels.map(omega).fold((0.0, 0.0), |(sum, n), omega| (sum + omega, n + 1.0));
    (-f64::max(sum / f64::max(n, 1.0), 0.0)).exp()
}

/// Most that the processor's T may differ from the reference's: Ω carries the rounding of one
/// addition a fragment and of its terms, relative to Σω, and T changes by no more than Ω does.
/// Halves are rounded alike in both.
pub fn port_bound(fragments: &[Fragment], opaque: Option<Fragment>) -> f64 {
    let all = gather::everything(fragments, opaque);
    let (total, count) =
        all.fold((0.0, 0.0), |(total, count), f| (total + f64::from(f.omega), count + 1.0));
    // Errors of additions are random: four standard deviations; terms of high order add theirs.
    let sums = (4.0 * f64::sqrt(count) + 64.0) * 2f64.powi(-24);
    (1e-7 + total * sums).min(1.0)
}
