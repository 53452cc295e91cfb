//! Opacity in layers: opacity shadow maps (planes), deep opacity maps (from each ray's first
//! fragment on) and bounding opacity maps (between each ray's first and last).
//!
//! This work is based on: Voicu, Real-time volumetric shadows for dynamic rendering, MSc thesis,
//! Imperial College London, 2011 (bounds, splits, packings); Kim and Neumann, Opacity shadow maps,
//! Rendering Techniques 2001; Yuksel and Keyser, Deep opacity maps, Computer Graphics Forum 27(2),
//! 2008.
//!
//! A texel holds its bounds first (planes: none; deep: the first depth; bounding: first and last),
//! then one word a layer: the sum, in the format's own values, of what lies in the layers up to and
//! including it (with [`Packing::Slabs`]: in those of its own texture of four).
//!
//! # How near the forms come
//! Rounding may put a fragment or a receiver on the other side of a layer boundary. The reference
//! therefore gives an interval ([`crate::reference::Reference::interval`]), outside of which the
//! processor's `f32` form lies by no more than [`reference::tolerance`]. Where it is wider than
//! [`reference::TIE`] the receiver is a near tie ([`crate::reference::near_tie`]); elsewhere the
//! forms differ by no more than the sum of both.

pub mod boundaries;
pub mod cells;
pub mod counters;
pub mod placement;
pub mod planes;
pub mod reference;
pub mod split;
pub mod split_reference;
pub mod unit;
pub mod write;

use crate::{
    Bins, EndMap, Format, Fragment, Fragments, Layered, Layout, Lookup, Opaque, Packing, Storage,
    code::TexelCode,
};
use boundaries::{Boundaries, geometric};
use placement::{Bounds, Place, Placement};
use unit::Unit;
use write::{Cover, Drawn};

/// Layered opacity maps on the processor.
#[derive(Clone, Debug)]
pub struct LayeredCode {
    settings: Layered,
    opaque: Opaque,
    unit: Unit,
    /// Which maps hold a fragment.
    pub cover: Cover,
    /// Where layers lie; planes from `prepare` on.
    pub placement: Placement,
    /// Room to order opacities in.
    sorted: Vec<Fragment>,
}

impl LayeredCode {
    /// Settings must have been checked.
    pub fn new(settings: &Layered, opaque: Opaque) -> Self {
        let layers = settings.layers as usize;
        let placement = match &settings.layout {
            Layout::Planes(_) => {
                Placement::Planes { bounds: Bounds { first: 0.0, last: 1.0 }, uneven: None }
            }
            Layout::Deep { span, growth, .. } => {
                let grown = || geometric(0.0, f64::from(*span), layers, f64::from(*growth));
                let uneven = (*growth != 1.0).then(|| Boundaries(grown()));
                Placement::Deep { span: *span, uneven }
            }
            Layout::Bounded { split, bins: Bins::Full } => Placement::bounded(split, layers),
            Layout::Bounded { split, bins: Bins::Thesis } => Placement::bounded(split, layers - 1),
        };
        Self {
            settings: settings.clone(),
            opaque,
            unit: Unit { blend: settings.blend, format: settings.format },
            cover: Cover::of(settings),
            placement,
            sorted: Vec::new(),
        }
    }

    /// The bounds of a texel's fragments: the map's where layers are planes.
    pub fn bounds(&self, fragments: &[Fragment], opaque: Option<Fragment>) -> Bounds {
        match &self.placement {
            Placement::Planes { bounds, .. } => *bounds,
            _ => {
                let stretches = self.opaque.stretches_bounds();
                Bounds::of(fragments, opaque, stretches)
            }
        }
    }

    /// Draws fragments into layers between bounds that need not be theirs, which are not written.
    pub fn draw(
        &self,
        bounds: Bounds,
        fragments: &[Fragment],
        opaque: Option<Fragment>,
        scratch: &mut Vec<Fragment>,
        words: &mut [f32],
    ) {
        let drawn = Drawn {
            placement: &self.placement,
            bounds,
            layers: self.layers(),
            bias: self.settings.write_bias,
            fragments,
            opaque,
        };
        let sums = &mut words[self.placement.bound_words()..];
        write::write(&drawn, self.unit, self.settings.packing, self.cover, scratch, sums);
    }

    /// Layer of a receiver, for views of layers; none in front of and behind all of them.
    pub fn layer_at(&self, words: &[f32], depth: f32) -> Option<usize> {
        match self.placement.place(self.placement.read(words), self.layers(), depth) {
            Place::At(c) => Some((c as usize).min(self.layers() - 1)),
            Place::Before | Place::Behind => None,
        }
    }

    fn layers(&self) -> usize {
        self.settings.layers as usize
    }

    /// Thickness at a place; `stored` gives a map's value.
    fn thickness(&self, place: Place, stored: impl Fn(usize) -> f32) -> f32 {
        let decoded = |map: usize| self.unit.thickness(f64::from(stored(map))) as f32;
        let upto = |map: usize| {
            if self.cover == Cover::Slab {
                // Textures hold what lies in them alone: add those before.
                (0..map / 4).map(|t| decoded(4 * t + 3)).sum::<f32>() + decoded(map)
            } else {
                decoded(map)
            }
        };
        let before = |k: usize| if k == 0 { 0.0 } else { upto(k - 1) };
        let last = self.layers() - 1;
        match place {
            Place::Before => 0.0,
            Place::Behind => upto(last),
            Place::At(c) => {
                let k = (c as usize).min(last);
                match self.settings.lookup {
                    Lookup::Nearest => upto(k),
                    Lookup::Exclusive => before(k),
                    Lookup::Lerp => {
                        let share = c - k as f32;
                        before(k) * (1.0 - share) + upto(k) * share
                    }
                }
            }
        }
    }
}

impl TexelCode for LayeredCode {
    fn words(&self) -> usize {
        self.placement.bound_words() + self.layers()
    }

    fn prepare(&mut self, fragments: &Fragments) {
        if let Layout::Planes(slicing) = self.settings.layout {
            let layers = self.layers();
            self.placement =
                planes::place(slicing, layers, fragments, self.opaque, &mut self.sorted);
        }
    }

    fn encode(
        &self,
        _: usize,
        fragments: &[Fragment],
        opaque: Option<Fragment>,
        scratch: &mut Vec<Fragment>,
        words: &mut [f32],
    ) {
        let bounds = self.bounds(fragments, opaque);
        self.placement.write(bounds, words);
        self.draw(bounds, fragments, opaque, scratch, words);
    }

    fn decode(&self, _: usize, words: &[f32], depth: f32) -> f32 {
        let place = self.placement.place(self.placement.read(words), self.layers(), depth);
        let sums = &words[self.placement.bound_words()..];
        (-self.thickness(place, |map| sums[map])).exp()
    }

    fn decode_mean(&self, own: (usize, &[f32]), taps: &[(usize, &[f32])], depth: f32) -> f32 {
        let place = self.placement.place(self.placement.read(own.1), self.layers(), depth);
        let first = self.placement.bound_words();
        let count = taps.len().max(1) as f32;
        let mean = |map: usize| taps.iter().map(|tap| tap.1[first + map]).sum::<f32>() / count;
        let mut thickness = self.thickness(place, mean);
        if self.settings.soft_start {
            // An empty texel's first depth is 1: it hides nothing from those in front of it.
            let behind = taps.iter().filter(|tap| self.placement.read(tap.1).first < depth);
            thickness *= behind.count() as f32 / count;
        }
        (-thickness).exp()
    }

    fn bytes_per_texel(&self) -> u64 {
        bytes_per_texel(&self.settings)
    }

    fn geometry_passes(&self) -> u64 {
        geometry_passes(&self.settings)
    }
}

/// Bytes of a texel in textures: bounds in one 32-bit channel each; maps four to a texture, in
/// [`Packing::Single`] one with three channels unused, in atomic storage in a buffer of words.
pub fn bytes_per_texel(layered: &Layered) -> u64 {
    let bounds = match layered.layout {
        Layout::Planes(_) => 0,
        Layout::Deep { .. } => 4,
        Layout::Bounded { .. } => 8,
    };
    let layers = u64::from(layered.layers);
    let channels = match layered.packing {
        _ if layered.storage == Storage::Atomic || layered.format == Format::Fixed => layers,
        Packing::Single => 4 * layers,
        _ => layers.next_multiple_of(4),
    };
    bounds + channels * unit::bytes(layered.format)
}

/// Passes over the geometry of a frame: for bounds, then for opacity.
pub fn geometry_passes(layered: &Layered) -> u64 {
    let bounds = match (&layered.layout, layered.end_map) {
        (Layout::Planes(_), _) => 0,
        (Layout::Deep { .. }, _) | (_, EndMap::MaxBlend | EndMap::Atomic) => 1,
        (_, EndMap::Greater | EndMap::Swapped | EndMap::RangeFlip) => 2,
    };
    let layers = u64::from(layered.layers);
    let opacity = match layered.packing {
        _ if layered.storage == Storage::Atomic => 1,
        Packing::Single => layers,
        Packing::Slabs => layers.div_ceil(4),
        Packing::Targets(targets) => layers.div_ceil(4 * u64::from(targets)),
        Packing::Sorted => 1,
    };
    bounds + opacity
}
