//! Deliberate faults of layered maps: what published listings get wrong, and what slips in when
//! they are written again. Each must be caught by a check; none is of any other use.

use crate::{
    Bins, Code, Fragment, Fragments, Layout, Packing, Settings, SplitKind,
    code::TexelCode,
    layered::{
        LayeredCode,
        placement::{Bounds, Placement},
        split::SplitFunction,
        write::Cover,
    },
};

/// How far [`Fault::MismatchedBias`] moves fragments towards the light.
pub const MISMATCH: f32 = 0.01;

/// A deliberate fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Printed masks of deep opacity maps (thesis, appendix 5), on any layout.
    Listing,
    /// The opacity pass tests and writes depth: fragments behind one drawn before are lost.
    DepthTested,
    /// Fragments are put into layers by another bias than they are read with.
    MismatchedBias,
    /// One bin fewer than layers (thesis, appendix 6): the last holds the last fragment alone.
    FewerBins,
    /// Layers lie between the next texel's bounds, but are read between the texel's own.
    NextTexelBounds,
    /// The lookup texture as printed in appendix 7: bytes wrap before they are scaled.
    WrappingTable,
    /// A layer's sum lacks what lies in it.
    LatePrefix,
}

impl Fault {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Listing,
        Self::DepthTested,
        Self::MismatchedBias,
        Self::FewerBins,
        Self::NextTexelBounds,
        Self::WrappingTable,
        Self::LatePrefix,
    ];

    /// A short name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Listing => "listing",
            Self::DepthTested => "depth-tested",
            Self::MismatchedBias => "mismatched-bias",
            Self::FewerBins => "fewer-bins",
            Self::NextTexelBounds => "next-texel-bounds",
            Self::WrappingTable => "wrapping-table",
            Self::LatePrefix => "late-prefix",
        }
    }

    /// The code with this fault, for [`crate::cpu::Maps::with_code`]; none where settings have no
    /// such thing to get wrong. Settings must have been checked.
    pub fn code(self, settings: &Settings) -> Option<Box<dyn TexelCode>> {
        let Code::Layered(layered) = &settings.code else { return None };
        let mut layered = layered.clone();
        match self {
            Self::Listing | Self::LatePrefix if layered.packing == Packing::Slabs => {
                layered.packing = Packing::Targets(8);
            }
            Self::MismatchedBias => layered.write_bias += MISMATCH,
            Self::FewerBins | Self::WrappingTable => match &mut layered.layout {
                Layout::Bounded { bins, .. } if self == Self::FewerBins => *bins = Bins::Thesis,
                Layout::Bounded { split, .. } => {
                    split.lambda = 1.0;
                    split.kind = SplitKind::Listing;
                }
                _ => return None,
            },
            Self::NextTexelBounds if matches!(layered.layout, Layout::Planes(_)) => return None,
            _ => {}
        }
        let mut code = LayeredCode::new(&layered, settings.opaque);
        match self {
            Self::Listing => code.cover = Cover::Listing,
            Self::LatePrefix => code.cover = Cover::Late,
            Self::WrappingTable => {
                if let (Layout::Bounded { split, .. }, Placement::Bounded { steps, .. }) =
                    (&layered.layout, &code.placement)
                {
                    let table = wrapping_table(split.width);
                    let texels = table.iter().map(|&byte| f32::from(byte) / 255.0).collect();
                    let function = SplitFunction::with_table(split, texels);
                    code.placement = Placement::split(function, *steps as usize);
                }
            }
            _ => {}
        }
        Some(match self {
            Self::DepthTested | Self::NextTexelBounds => {
                Box::new(Misdrawn { code, fault: self, bounds: Vec::new() })
            }
            _ => Box::new(code),
        })
    }
}

/// The table of appendix 7 as listed: a value above 255 is cut to its low byte, then scaled.
pub fn wrapping_table(width: u32) -> Vec<u8> {
    let end = f64::from(width - 1);
    let range = (end - 1.0).log2().floor().max(1.0);
    let texel = |i: u32| {
        if i == 0 {
            return 0;
        }
        let value = (f64::from(i).log2() * end / range).min(end);
        (f64::from((value as u32 & 0xff) as u8) * 255.0 / end) as u8
    };
    (0..width).map(texel).collect()
}

/// A code that is given the wrong fragments or bounds to draw.
struct Misdrawn {
    code: LayeredCode,
    fault: Fault,
    /// Every texel's bounds.
    bounds: Vec<Bounds>,
}

impl TexelCode for Misdrawn {
    fn words(&self) -> usize {
        self.code.words()
    }

    fn prepare(&mut self, fragments: &Fragments) {
        self.code.prepare(fragments);
        let of = |texel| self.code.bounds(fragments.texel(texel), None);
        self.bounds = (0..fragments.texels()).map(of).collect();
    }

    fn encode(
        &self,
        texel: usize,
        fragments: &[Fragment],
        opaque: Option<Fragment>,
        scratch: &mut Vec<Fragment>,
        words: &mut [f32],
    ) {
        let own = self.code.bounds(fragments, opaque);
        self.code.placement.write(own, words);
        if self.fault == Fault::NextTexelBounds {
            let next = self.bounds.get(texel + 1).copied().unwrap_or(own);
            return self.code.draw(next, fragments, opaque, scratch, words);
        }
        let mut nearest = f32::INFINITY;
        let passes = |f: &&Fragment| {
            let passed = f.depth < nearest;
            nearest = nearest.min(f.depth);
            passed
        };
        let kept: Vec<Fragment> = fragments.iter().filter(passes).copied().collect();
        self.code.draw(own, &kept, opaque, scratch, words);
    }

    fn decode(&self, texel: usize, words: &[f32], depth: f32) -> f32 {
        self.code.decode(texel, words, depth)
    }

    fn decode_mean(&self, own: (usize, &[f32]), taps: &[(usize, &[f32])], depth: f32) -> f32 {
        self.code.decode_mean(own, taps, depth)
    }

    fn bytes_per_texel(&self) -> u64 {
        self.code.bytes_per_texel()
    }

    fn geometry_passes(&self) -> u64 {
        self.code.geometry_passes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Split, layered::split::listing_table};

    #[test]
    fn the_wrapping_table_falls_and_has_no_entry_above_127() {
        let wrapping = wrapping_table(512);
        assert!(wrapping.iter().all(|&byte| byte <= 127));
        assert!(wrapping.windows(2).any(|w| w[0] > w[1]));
        let split = Split { lambda: 1.0, kind: SplitKind::Listing, width: 512 };
        assert!(listing_table(&split).windows(2).all(|w| w[0] <= w[1]));
    }
}
