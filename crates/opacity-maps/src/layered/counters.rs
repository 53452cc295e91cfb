//! What a frame of the processor's form reads and writes, counted from the storage layout.

use super::{LayeredCode, placement::Place, unit::Unit, write::Cover};
use crate::{
    Blend, Format, Fragments, Layered, Layout, Packing, Receiver, Settings, cpu,
    taps::{self, MOST, Tap},
};

/// Work of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Fragments looked at, over all passes.
    pub fragments_read: u64,
    /// Channels that fragments are blended into, masked ones included, and sums of layers.
    pub additions: u64,
    /// Words of maps and bounds.
    pub words_written: u64,
    /// Words of maps and bounds that receivers read.
    pub texels_fetched: u64,
}

/// Work of [`cpu::Maps::build`].
pub fn building(layered: &Layered, settings: &Settings, fragments: &Fragments) -> Counters {
    let texels = fragments.texels() as u64;
    let translucent = fragments.items.len() as u64;
    let weighted = |&&z: &&f32| cpu::weighted(settings.opaque, z).is_some();
    let drawn = translucent + fragments.opaque.iter().filter(weighted).count() as u64;
    let layers = u64::from(layered.layers);
    let cumulative = Cover::of(layered) == Cover::Cumulative;
    let unit = Unit { blend: layered.blend, format: layered.format };
    let in_any_order = unit.is_exact() || (unit.blend, unit.format) == (Blend::Add, Format::F32);
    let (passes, additions) = match layered.packing {
        Packing::Sorted if cumulative && in_any_order => (1, drawn + texels * layers),
        // Counted, put in order, then blended.
        Packing::Sorted if cumulative => (2, drawn),
        Packing::Sorted => (1, drawn * layers),
        Packing::Single => (layers, drawn * layers),
        // Clipped to its slab, a fragment is blended into one texture.
        Packing::Slabs => (layers.div_ceil(4), drawn * 4),
        Packing::Targets(targets) => {
            (layers.div_ceil(4 * u64::from(targets)), drawn * layers.next_multiple_of(4))
        }
    };
    let (bound_words, bounding) = match layered.layout {
        Layout::Planes(_) => (0, translucent),
        Layout::Deep { .. } => (1, translucent),
        Layout::Bounded { .. } => (2, translucent),
    };
    Counters {
        fragments_read: bounding + passes * drawn,
        additions,
        words_written: texels * (bound_words + layers),
        texels_fetched: 0,
    }
}

/// Words that a receiver reads: as many as its place among the layers needs. `code` must have been
/// prepared for the fragments that `maps` are built of.
pub fn shading(
    code: &LayeredCode,
    settings: &Settings,
    maps: &cpu::Maps,
    size: (u32, u32),
    receiver: &Receiver,
) -> u64 {
    if !receiver.in_map() {
        return 0;
    }
    let mut found = [Tap { texel: 0, du: 0.0, dv: 0.0 }; MOST];
    let n = taps::taps(settings.taps, receiver, size.0, size.1, &mut found);
    let depth = receiver.depth - settings.bias;
    let bounds = code.placement.bound_words() as u64;
    match settings.blur {
        crate::Blur::Transmittance => {
            found[..n].iter().map(|tap| bounds + code.maps_read(maps.texel(tap.texel), depth)).sum()
        }
        crate::Blur::Stored => {
            let own = maps.texel(taps::own(receiver, size.0, size.1));
            let soft = if code.settings.soft_start { n as u64 * bounds } else { 0 };
            bounds + soft + n as u64 * code.maps_read(own, depth)
        }
    }
}

impl LayeredCode {
    /// Maps that a lookup at `depth` reads.
    pub fn maps_read(&self, words: &[f32], depth: f32) -> u64 {
        let place: Place = self.placement.place(self.placement.read(words), self.layers(), depth);
        let read = std::cell::Cell::new(0);
        self.thickness(place, |_| {
            read.set(read.get() + 1);
            0.0
        });
        read.get()
    }
}
