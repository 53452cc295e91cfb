//! A shadow map: the nearest depth of anything, and no light behind it.
//!
//! Based on: Lance Williams, "Casting curved shadows on curved surfaces", SIGGRAPH 1978 (depth
//! map); William T. Reeves, David H. Salesin, Robert L. Cook, "Rendering antialiased shadows with
//! depth maps", SIGGRAPH 1987 (its results, not its depths, are averaged over taps).
//!
//! A translucent surface casts the shadow of an opaque one, however thin it is: that is what the
//! other codes are measured against.

use crate::{Fragment, NO_OPAQUE, code::TexelCode, gather};

/// One depth a texel.
pub struct Binary;

impl TexelCode for Binary {
    fn words(&self) -> usize {
        1
    }

    fn encode(
        &self,
        _: usize,
        fragments: &[Fragment],
        opaque: Option<Fragment>,
        _: &mut Vec<Fragment>,
        words: &mut [f32],
    ) {
        let depths = gather::everything(fragments, opaque).map(|f| f.depth);
        words[0] = depths.fold(NO_OPAQUE, f32::min);
    }

    fn decode(&self, _: usize, words: &[f32], depth: f32) -> f32 {
        // Nothing lies at the cleared depth, so nothing hides a receiver beyond the far plane.
        if words[0] < depth.min(NO_OPAQUE) { 0.0 } else { 1.0 }
    }

    fn bytes_per_texel(&self) -> u64 {
        4
    }

    fn geometry_passes(&self) -> u64 {
        1
    }
}

/// 0 where anything lies strictly in front of `depth`, else 1.
pub fn reference(fragments: &[Fragment], opaque: Option<Fragment>, depth: f32) -> f64 {
    let hidden = fragments.iter().copied().chain(opaque).any(|f| f.depth < depth);
    if hidden { 0.0 } else { 1.0 }
}
