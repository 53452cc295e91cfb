//! Moment-based transmittance: 4 or 6 power moments of the absorption along a ray.
//!
//! Based on: Cedrick Münstermann, Stefan Krumpen, Reinhard Klein, Christoph Peters, "Moment-based
//! order-independent transparency", Proc. ACM Comput. Graph. Interact. Tech. 1(1) (I3D), 2018, §3
//! (absorbance ω, its moments b_j = Σ ω z^j over depths in -1..=1, bounds of the absorbance in front
//! of a depth, interpolation between them) and the supplement (biases); Christoph Peters, Cedrick
//! Münstermann, Nico Wetzstein, Reinhard Klein, "Improved moment shadow maps for translucent
//! occluders, soft shadows and single scattering", JCGT 6(1), 2017.
//!
//! Among all distributions of b_0 with the moments b_1 .. b_m, the one with a point at the
//! receiver's depth x and least others puts the least before x and the most up to x (Markov,
//! Krein). What lies before x, plus a share of the point's own weight, is Ω(x). Both bounds rise
//! with x, so T is monotone; m/2 different depths are met exactly, but for the bias.
//!
//! The bias moves the moments, divided by b_0, towards those of a distribution that is far from
//! any degenerate one. It costs sharpness, and pays for rounding: in f32 a ray of few depths has a
//! singular matrix of moments, and without bias its inverse is noise.
//!
//! The other points: with y = x + 1/s, the polynomial whose roots they are has, in s, the leading
//! coefficient v(x)' B^-1 v(x) > 0. So no root is at infinity, points before x are the roots s < 0,
//! and far points, which have next to no weight, have s near 0.
//!
//! Deviations: `overestimation` is that of T (the authors' is that of the absorbance, 1 - ours);
//! depths are linear in the light's range, or between each ray's own bounds (`bounded`; two more
//! words), where T is exactly 1 up to the first fragment and e^-b_0 behind the last; halves store
//! moments as they are (the authors' transform suits integers: a half keeps its relative precision
//! near 0), rounded after each addition; where rounding leaves a matrix that no distribution has,
//! its even moments are raised to the nearest that one could have after the bias (without that,
//! halves need more than ten times the bias).

mod reference;
mod share;

pub use reference::{reference, reference_mean};

use crate::{
    Format, Fragment, Moments,
    code::TexelCode,
    gather::{self, Place, WHOLE},
    layered::placement::Bounds,
};

/// Most moments, the zeroth included.
const MOST: usize = 7;

/// Bounds first where there are any, then b_0 .. b_m.
pub struct Code {
    /// Knobs.
    pub settings: Moments,
    /// Whether the opaque fragment stretches the bounds.
    pub opaque_in_bounds: bool,
}

/// Moments of the distribution that the bias moves towards, from the first on (Peters et al. 2017;
/// the supplement of Münstermann et al. 2018).
pub fn safe(moments: u32) -> &'static [f64] {
    if moments == 4 { &[0.0, 0.375, 0.0, 0.375] } else { &[0.0, 0.48, 0.0, 0.451, 0.0, 0.45] }
}

/// Pivots of the safe distribution's matrix after the first, which is 1. A matrix of moments has
/// none below 0, so a biased one has none below `bias` times these: where rounding says otherwise
/// the even moment is raised until it has.
fn safe_pivots(moments: u32) -> &'static [f64] {
    if moments == 4 { &[0.375, 0.234_375] } else { &[0.48, 0.2206, 0.026_247_917] }
}

/// The bias that settings ask for. The authors' are 5e-7 and 5e-6 in f32 for 4 and 6 moments; ours
/// are stronger, because sums here are of many fragments at few depths. Through hair that costs
/// less than 1 % of the error; on rays of one to four depths it keeps f32 within 0.01 of f64.
pub fn bias(settings: &Moments) -> f64 {
    if settings.bias > 0.0 {
        return f64::from(settings.bias);
    }
    match (settings.format, settings.moments) {
        (Format::F16, _) => 1e-3,
        (_, 4) => 5e-5,
        _ => 1e-4,
    }
}

impl Code {
    fn header(&self) -> usize {
        if self.settings.bounded { 2 } else { 0 }
    }

    fn count(&self) -> usize {
        1 + if self.settings.moments == 4 { 4 } else { 6 }
    }

    fn transmittance(&self, words: &[f32], depth: f32) -> f32 {
        let bounds = match self.settings.bounded {
            true => Bounds { first: words[0], last: words[1] },
            false => WHOLE,
        };
        let b = &words[self.header()..self.header() + self.count()];
        match gather::place(bounds, depth) {
            _ if b[0] <= 0.0 => 1.0,
            Place::Front => 1.0,
            Place::Behind => (-b[0]).exp(),
            Place::Inside(share) => {
                let own = 1.0 - self.settings.overestimation;
                let bias = bias(&self.settings) as f32;
                (-b[0] * share::share_before(b, 2.0 * share - 1.0, bias, own)).exp()
            }
        }
    }
}

impl TexelCode for Code {
    fn words(&self) -> usize {
        self.header() + self.count()
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
        let b = &mut words[self.header()..];
        b.fill(0.0);
        for f in gather::everything(fragments, opaque) {
            let z = 2.0 * gather::share(bounds, f.depth) - 1.0;
            let mut term = f64::from(f.omega);
            for sum in b.iter_mut() {
                *sum = gather::stored(self.settings.format, f64::from(*sum) + term);
                term *= z;
            }
        }
    }

    fn decode(&self, _: usize, words: &[f32], depth: f32) -> f32 {
        self.transmittance(words, depth)
    }

    /// Over the whole range moments are averaged, as of one ray of all their fragments.
    fn decode_mean(&self, _: (usize, &[f32]), taps: &[(usize, &[f32])], depth: f32) -> f32 {
        let n = taps.len().max(1) as f32;
        if self.settings.bounded {
            let decoded = taps.iter().map(|(_, words)| self.transmittance(words, depth));
            return decoded.sum::<f32>() / n;
        }
        let mut mean = [0.0; MOST];
        for (_, words) in taps {
            mean.iter_mut().zip(*words).for_each(|(sum, word)| *sum += word / n);
        }
        self.transmittance(&mean, depth)
    }

    fn bytes_per_texel(&self) -> u64 {
        4 * self.header() as u64 + self.count() as u64 * gather::bytes(self.settings.format)
    }

    /// One for all moments; one before it for both bounds.
    fn geometry_passes(&self) -> u64 {
        1 + u64::from(self.settings.bounded)
    }
}

/// Most that the processor's T may differ from the reference's. Sums carry the rounding of one
/// addition a fragment, and the inverse of the matrix of moments magnifies it by up to 1 / bias,
/// more for the larger matrix. Halves are rounded alike in both.
pub fn port_bound(settings: &Moments, fragments: &[Fragment], opaque: Option<Fragment>) -> f64 {
    let count = gather::everything(fragments, opaque).count() as f64;
    let size = if settings.moments == 4 { 1.0 } else { 4.0 };
    let sums = match settings.format {
        Format::F16 => size * 2f64.powi(-21),
        _ => size * 2f64.powi(-24) * (8.0 + count.sqrt()),
    };
    (1e-6 + sums / bias(settings)).min(1.0)
}
