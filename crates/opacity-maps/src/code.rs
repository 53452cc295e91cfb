//! What each technique does to a texel.

use crate::{
    Code, Fragment, Settings, adaptive, binary, deep, fourier, layered, moments, stochastic,
};

/// A technique's stored numbers of one texel.
///
/// `decode` gives the transmittance in 0..=1 from the light to just before `depth`. Codes hold no
/// state of a frame but what `prepare` sets.
pub trait TexelCode: Send + Sync {
    /// Numbers a texel stores.
    fn words(&self) -> usize;

    /// Looks at all fragments once, before texels are encoded (planes of an OSM).
    fn prepare(&mut self, fragments: &crate::Fragments) {
        let _ = fragments;
    }

    /// Writes a texel from its translucent fragments, in the order they are drawn, and from its
    /// opaque one where opaque casters have a weight ([`crate::Opaque::Weight`]). `scratch` is for
    /// any use; `words` holds what an earlier frame left.
    fn encode(
        &self,
        texel: usize,
        fragments: &[Fragment],
        opaque: Option<Fragment>,
        scratch: &mut Vec<Fragment>,
        words: &mut [f32],
    );

    /// Reads a texel.
    fn decode(&self, texel: usize, words: &[f32], depth: f32) -> f32;

    /// Reads the mean of several texels at once. `own` is (texel, its words) of the texel the
    /// receiver lies in, whether or not it is among the `taps`: it says where layers lie. Codes that
    /// cannot be averaged decode each and average that.
    fn decode_mean(&self, own: (usize, &[f32]), taps: &[(usize, &[f32])], depth: f32) -> f32 {
        let _ = own;
        let sum: f32 = taps.iter().map(|(texel, words)| self.decode(*texel, words, depth)).sum();
        sum / taps.len().max(1) as f32
    }

    /// Bytes a texel takes as stored.
    fn bytes_per_texel(&self) -> u64;

    /// Bytes of what a texel uses of them, where codes are of variable length.
    fn used_bytes(&self, words: &[f32]) -> u64 {
        let _ = words;
        self.bytes_per_texel()
    }

    /// Passes over the geometry a frame needs.
    fn geometry_passes(&self) -> u64;
}

/// The code that settings ask for; they must have been checked.
pub fn of(settings: &Settings) -> Box<dyn TexelCode> {
    let opaque_in_bounds = settings.opaque_in_bounds();
    match &settings.code {
        Code::Unshadowed => Box::new(Unshadowed),
        Code::Layered(l) => Box::new(layered::LayeredCode::new(l, settings.opaque)),
        Code::Binary => Box::new(binary::Binary),
        Code::Fourier(f) => Box::new(fourier::Code { settings: *f, opaque_in_bounds }),
        Code::Adaptive(a) => Box::new(adaptive::Code(*a)),
        Code::Moments(m) => Box::new(moments::Code { settings: *m, opaque_in_bounds }),
        Code::Stochastic(s) => Box::new(stochastic::Code(*s)),
        Code::Deep(d) => Box::new(deep::Code(*d)),
    }
}

struct Unshadowed;

impl TexelCode for Unshadowed {
    fn words(&self) -> usize {
        0
    }
    fn encode(
        &self,
        _: usize,
        _: &[Fragment],
        _: Option<Fragment>,
        _: &mut Vec<Fragment>,
        _: &mut [f32],
    ) {
    }
    fn decode(&self, _: usize, _: &[f32], _: f32) -> f32 {
        1.0
    }
    fn bytes_per_texel(&self) -> u64 {
        0
    }
    fn geometry_passes(&self) -> u64 {
        0
    }
}
