//! The opacity pass: fragments into layers, by each packing's own way.
//!
//! [`Packing::Sorted`] touches every fragment once and sums layers up afterwards, O(N + K). The
//! others do what their passes do: each looks at every fragment again and adds it to every map of
//! the pass that it belongs to, O(N K).

use super::{
    placement::{Bounds, Placement},
    unit::Unit,
};
use crate::{Blend, Format, Fragment, Layered, Layout, Packing};

/// Most layers.
pub const MOST_LAYERS: usize = 256;

/// Most channels of a pass: eight textures of four.
const MOST_CHANNELS: usize = 32;

/// Fragments whose layers are found at once.
const BLOCK: usize = 64;

/// Which maps hold a fragment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cover {
    /// All from its layer's on.
    Cumulative,
    /// Those of its own texture from its layer's on: textures are added up at lookup.
    Slab,
    /// The thesis's printed masks for deep opacity maps (appendix 5): its channel's mask is used in
    /// every later texture too.
    Listing,
    /// A deliberate fault: all after its layer's.
    Late,
}

impl Cover {
    /// What settings ask for.
    pub fn of(layered: &Layered) -> Self {
        match (&layered.layout, layered.packing) {
            (Layout::Deep { listing: true, .. }, _) => Self::Listing,
            (_, Packing::Slabs) => Self::Slab,
            _ => Self::Cumulative,
        }
    }

    /// Whether map `map` holds the fragments of layer `layer`.
    #[inline]
    pub fn holds(self, layer: usize, map: usize) -> bool {
        let later = map >= layer;
        match self {
            Self::Cumulative => later,
            Self::Slab => later && map / 4 == layer / 4,
            Self::Listing => later && (map / 4 == layer / 4 || map % 4 >= layer % 4),
            Self::Late => map > layer,
        }
    }
}

/// A texel's fragments in the order they are drawn, and where its layers lie.
#[derive(Clone, Copy)]
pub struct Drawn<'a> {
    /// Where layers lie.
    pub placement: &'a Placement,
    /// The texel's bounds.
    pub bounds: Bounds,
    /// Number of layers.
    pub layers: usize,
    /// Taken from depths before they are put into layers.
    pub bias: f32,
    /// Translucent fragments.
    pub fragments: &'a [Fragment],
    /// Drawn after them.
    pub opaque: Option<Fragment>,
}

impl Drawn<'_> {
    /// Calls `each` with (layer, thickness) of every fragment in turn.
    #[inline]
    fn each(&self, mut each: impl FnMut(usize, f32)) {
        let mut layers = [0u32; BLOCK];
        let opaque = self.opaque.as_ref().map(std::slice::from_ref);
        for block in self.fragments.chunks(BLOCK).chain(opaque) {
            let layers = &mut layers[..block.len()];
            self.placement.layers_of(self.bounds, self.layers, self.bias, block, layers);
            for (f, &layer) in block.iter().zip(layers.iter()) {
                each(layer as usize, f.omega);
            }
        }
    }
}

/// Fills a texel's maps; `sums` has one word a layer. `scratch` keeps its room.
pub fn write(
    drawn: &Drawn,
    unit: Unit,
    packing: Packing,
    cover: Cover,
    scratch: &mut Vec<Fragment>,
    sums: &mut [f32],
) {
    let group = match packing {
        // Room is cleared for every texel: no more than is needed.
        Packing::Sorted if cover == Cover::Cumulative && sums.len() <= 32 => {
            return sorted::<32>(drawn, unit, scratch, sums);
        }
        Packing::Sorted if cover == Cover::Cumulative => {
            return sorted::<MOST_LAYERS>(drawn, unit, scratch, sums);
        }
        Packing::Sorted => MOST_CHANNELS,
        Packing::Single => 1,
        Packing::Slabs => 4,
        Packing::Targets(targets) => 4 * targets as usize,
    };
    for (pass, maps) in sums.chunks_mut(group.max(1)).enumerate() {
        let first = pass * group;
        match (unit.blend, unit.format) {
            (Blend::Add, Format::F32) if cover == Cover::Cumulative => {
                add_floats(drawn, first, maps, |_| true);
            }
            (Blend::Add, Format::F32) if cover == Cover::Slab => {
                add_floats(drawn, first, maps, |layer| layer / 4 == pass);
            }
            (Blend::Alpha | Blend::Premultiplied, _) => textures(drawn, unit, cover, first, maps),
            _ => blend(drawn, unit, cover, first, maps),
        }
    }
}

/// One pass over the fragments, then one over the layers.
fn sorted<const ROOM: usize>(
    drawn: &Drawn,
    unit: Unit,
    scratch: &mut Vec<Fragment>,
    sums: &mut [f32],
) {
    if unit.is_exact() {
        let mut raw = [0.0; ROOM];
        drawn.each(|k, omega| raw[k] = unit.sum(raw[k], unit.increment(omega)));
        let mut total = 0.0;
        for (word, raw) in sums.iter_mut().zip(raw) {
            total = unit.sum(total, raw);
            *word = unit.word(total);
        }
    } else if unit.blend == Blend::Add && unit.format == Format::F32 {
        sums.fill(0.0);
        drawn.each(|k, omega| sums[k] += omega);
        let mut total = 0.0;
        for word in sums {
            total += *word;
            *word = total;
        }
    } else {
        layer_by_layer::<ROOM>(drawn, unit, scratch, sums);
    }
}

/// Draws slab by slab, each map going on from the one before: what rounding depends on order.
fn layer_by_layer<const ROOM: usize>(
    drawn: &Drawn,
    unit: Unit,
    scratch: &mut Vec<Fragment>,
    sums: &mut [f32],
) {
    let mut ends = [0usize; ROOM];
    drawn.each(|k, _| ends[k] += 1);
    let mut start = 0;
    for end in &mut ends[..sums.len()] {
        (*end, start) = (start, start + *end);
    }
    scratch.clear();
    scratch.resize(start, Fragment::default());
    drawn.each(|k, omega| {
        scratch[ends[k]].omega = omega;
        ends[k] += 1;
    });
    let (mut raw, mut from) = (0.0, 0);
    for (word, &end) in sums.iter_mut().zip(&ends) {
        raw = scratch[from..end].iter().fold(raw, |raw, f| unit.step(raw, f.omega));
        *word = unit.word(raw);
        from = end;
    }
}

/// One pass of plain sums into the maps from `first` on, of fragments that are not clipped: every
/// map is written, masked by 0.
fn add_floats(drawn: &Drawn, first: usize, maps: &mut [f32], inside: impl Fn(usize) -> bool) {
    maps.fill(0.0);
    drawn.each(|k, omega| {
        if !inside(k) {
            return;
        }
        let layer = k.saturating_sub(first) as u32;
        for (m, sum) in (0u32..).zip(maps.iter_mut()) {
            *sum += if m >= layer { omega } else { 0.0 };
        }
    });
}

/// One pass in any format whose channels are independent.
fn blend(drawn: &Drawn, unit: Unit, cover: Cover, first: usize, maps: &mut [f32]) {
    let mut raw = [0.0; MOST_CHANNELS];
    drawn.each(|k, omega| {
        for (m, raw) in raw[..maps.len()].iter_mut().enumerate() {
            if cover.holds(k, first + m) {
                *raw = unit.step(*raw, omega);
            }
        }
    });
    maps.iter_mut().zip(raw).for_each(|(word, raw)| *word = unit.word(raw));
}

/// One pass where the channels of a texture are not independent.
fn textures(drawn: &Drawn, unit: Unit, cover: Cover, first: usize, maps: &mut [f32]) {
    let mut raw = [[0.0; 4]; MOST_CHANNELS / 4];
    let textures = maps.len().div_ceil(4);
    drawn.each(|k, omega| {
        for (t, raw) in raw[..textures].iter_mut().enumerate() {
            let mask = [0, 1, 2, 3].map(|c| cover.holds(k, first + 4 * t + c));
            if mask[3] {
                unit.step_group(raw, omega, mask);
            }
        }
    });
    let raw = raw.iter().flatten();
    maps.iter_mut().zip(raw).for_each(|(word, &raw)| *word = unit.word(raw));
}
