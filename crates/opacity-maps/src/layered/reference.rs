//! Layered opacity maps by definition, in `f64`: a map's content is worked out from the fragments
//! each time it is asked for.

use super::{
    boundaries::Boundaries,
    placement::{Placement, THINNEST},
    planes,
    split_reference::SplitReference,
    unit::Unit,
    write::Cover,
};
use crate::{
    Bins, Blend, Format, Fragment, Fragments, Layered, Layout, Lookup, Opaque, Packing, Slicing,
    SplitKind, cpu, taps::Tap,
};

/// Width of an interval of transmittance ([`crate::reference::Reference::interval`]) from which on a
/// receiver is a near tie: rounding decides on which side of a layer boundary something lies.
pub const TIE: f64 = 1e-4;

/// How far rounding may move a layer coordinate of the `f32` form, as a share of all layers.
pub fn rounding(layered: &Layered) -> f64 {
    match &layered.layout {
        Layout::Bounded { split, .. } if split.kind == SplitKind::Positions => 8e-5,
        Layout::Bounded { split, .. } if split.lambda != 0.0 => 4e-6,
        _ => 1e-6,
    }
}

/// How far the `f32` form's transmittance may lie outside of its interval where a texel has
/// `fragments` of them: each addition rounds by 2^-24 of the sum, and Ω e^-Ω <= 1 / e.
pub fn tolerance(fragments: usize) -> f64 {
    1e-6 + fragments as f64 * 2f64.powi(-24) / std::f64::consts::E
}

/// The technique over fragments at hand.
pub struct LayeredReference<'a> {
    layered: &'a Layered,
    opaque: Opaque,
    fragments: &'a Fragments,
    split: Option<SplitReference>,
    /// First and last plane.
    range: (f64, f64),
    /// Uneven planes or growing layers, as they are uploaded.
    boundaries: Option<Boundaries>,
}

/// A texel's fragments, with their layers.
struct Texel {
    bounds: (f64, f64),
    /// (layer, thickness) in the order they are drawn.
    drawn: Vec<(usize, f32)>,
}

impl<'a> LayeredReference<'a> {
    /// Settings and fragments must have been checked.
    pub fn new(layered: &'a Layered, opaque: Opaque, fragments: &'a Fragments) -> Self {
        let layers = layered.layers as usize;
        let (mut split, mut boundaries) = (None, None);
        match &layered.layout {
            Layout::Planes(Slicing::Uniform) => {}
            Layout::Planes(slicing) => {
                let placed = planes::place(*slicing, layers, fragments, opaque, &mut Vec::new());
                if let Placement::Planes { uneven, .. } = placed {
                    boundaries = uneven;
                }
            }
            Layout::Deep { span, growth, .. } if *growth != 1.0 => {
                let (span, growth) = (f64::from(*span), f64::from(*growth));
                boundaries = Some(Boundaries(super::geometric(0.0, span, layers, growth)));
            }
            Layout::Deep { .. } => {}
            Layout::Bounded { split: given, .. } => split = Some(SplitReference::new(given)),
        }
        let range = range_of_map(fragments, opaque);
        Self { layered, opaque, fragments, split, range, boundaries }
    }

    /// Transmittance of a texel just before `depth`.
    pub fn at(&self, texel: usize, depth: f32) -> f64 {
        self.shifted(texel, depth, 0.0)
    }

    /// Least and greatest transmittance of a texel where layer coordinates may be off by
    /// [`rounding`]. States whose channels are not independent, and printed masks, are not monotone:
    /// the answer is 0..=1 where any of their fragments may change its layer.
    pub fn interval(&self, texel: usize, depth: f32) -> (f64, f64) {
        let shift = self.shift();
        if self.is_open(texel, shift) {
            return (0.0, 1.0);
        }
        ordered(self.shifted(texel, depth, -shift), self.shifted(texel, depth, shift))
    }

    /// The same where maps are averaged over taps at the layer of a receiver's `own` texel.
    pub fn stored_interval(&self, own: usize, taps: &[Tap], depth: f32) -> (f64, f64) {
        let shift = self.shift();
        if taps.iter().any(|tap| self.is_open(tap.texel, shift)) {
            return (0.0, 1.0);
        }
        let at = |shift| self.stored_shifted(own, taps, depth, shift);
        ordered(at(-shift), at(shift))
    }

    fn shift(&self) -> f64 {
        rounding(self.layered) * f64::from(self.layered.layers)
    }

    /// Whether a change of any fragment's layer by `shift` has no bounded effect, and there is one.
    fn is_open(&self, texel: usize, shift: f64) -> bool {
        let monotone = matches!(self.layered.blend, Blend::Add | Blend::Over)
            && !matches!(self.layered.layout, Layout::Deep { listing: true, .. });
        !monotone && self.texel(texel, -shift).drawn != self.texel(texel, shift).drawn
    }

    /// Transmittance where maps are averaged over taps at the layer of a receiver's `own` texel.
    pub fn stored(&self, own: usize, taps: &[Tap], depth: f32) -> f64 {
        self.stored_shifted(own, taps, depth, 0.0)
    }

    fn stored_shifted(&self, own: usize, taps: &[Tap], depth: f32, shift: f64) -> f64 {
        let texels: Vec<Texel> = taps.iter().map(|tap| self.texel(tap.texel, shift)).collect();
        let count = taps.len().max(1) as f64;
        let mean = |map| texels.iter().map(|texel| self.value(texel, map)).sum::<f64>() / count;
        let mut thickness = self.thickness(self.texel(own, 0.0).bounds, depth, -shift, &mean);
        if self.layered.soft_start {
            let behind = texels.iter().filter(|texel| texel.bounds.0 < f64::from(depth));
            thickness *= behind.count() as f64 / count;
        }
        (-thickness).exp()
    }

    /// Fragments' coordinates moved back by `shift`, the receiver's forward.
    fn shifted(&self, texel: usize, depth: f32, shift: f64) -> f64 {
        let texel = self.texel(texel, shift);
        let value = |map| self.value(&texel, map);
        (-self.thickness(texel.bounds, depth, -shift, &value)).exp()
    }

    fn texel(&self, texel: usize, shift: f64) -> Texel {
        let opaque = cpu::weighted(self.opaque, self.fragments.opaque[texel]);
        let translucent = self.fragments.texel(texel);
        let all: Vec<Fragment> = translucent.iter().copied().chain(opaque).collect();
        let stretches = self.opaque.stretches_bounds();
        let bounding = if stretches || translucent.is_empty() { &all } else { translucent };
        let depths = || bounding.iter().map(|f| f64::from(f.depth));
        let bounds = match self.layered.layout {
            Layout::Planes(_) => self.range,
            _ if bounding.is_empty() => (1.0, 0.0),
            _ => (depths().fold(f64::INFINITY, f64::min), depths().fold(-1e300, f64::max)),
        };
        let last = self.layered.layers as usize - 1;
        let layer = |f: &Fragment| {
            let biased = f64::from(f.depth - self.layered.write_bias);
            let c = self.moved(self.coordinate(bounds, biased), shift);
            if c <= 0.0 { 0 } else { (c.floor() as usize).min(last) }
        };
        let mut drawn: Vec<(usize, f32)> = all.iter().map(|f| (layer(f), f.omega)).collect();
        if self.layered.packing == Packing::Sorted && Cover::of(self.layered) == Cover::Cumulative {
            drawn.sort_by_key(|&(layer, _)| layer);
        }
        Texel { bounds, drawn }
    }

    /// Layer coordinate of a depth, not clamped where layers are even.
    fn coordinate(&self, bounds: (f64, f64), depth: f64) -> f64 {
        let (first, last) = bounds;
        let layers = f64::from(self.layered.layers);
        let local = if ((last - first) as f32) < THINNEST {
            if depth <= last { 0.0 } else { 1.0 }
        } else {
            (depth - first) / (last - first)
        };
        match (&self.layered.layout, &self.boundaries) {
            (Layout::Planes(_), None) => local * layers,
            (Layout::Planes(_), Some(planes)) => planes.coordinate_f64(depth),
            (Layout::Deep { span, .. }, None) => (depth - first) / f64::from(*span) * layers,
            (Layout::Deep { .. }, Some(growing)) => growing.coordinate_f64(depth - first),
            (Layout::Bounded { bins, .. }, _) => {
                let steps = if *bins == Bins::Full { layers } else { layers - 1.0 };
                let split = self.split.as_ref();
                steps * split.map_or(local, |split| split.coordinate(local))
            }
        }
    }

    /// A layer coordinate after rounding by `shift`. The ends of bounds are exact in every form, and
    /// with K - 1 bins the last of them is a boundary.
    fn moved(&self, c: f64, shift: f64) -> f64 {
        let fewer = matches!(self.layered.layout, Layout::Bounded { bins: Bins::Thesis, .. });
        let end = f64::from(self.layered.layers) - 1.0;
        if fewer && c == end { c } else { c + shift }
    }

    /// What map `map` stores, in its format.
    fn value(&self, texel: &Texel, map: usize) -> f64 {
        let unit = Unit { blend: self.layered.blend, format: self.layered.format };
        let cover = Cover::of(self.layered);
        let inside = texel.drawn.iter().filter(|&&(layer, _)| cover.holds(layer, map));
        match (unit.blend, unit.format) {
            (Blend::Add, Format::F32) => inside.map(|&(_, omega)| f64::from(omega)).sum(),
            (Blend::Add | Blend::Over, _) => {
                let raw = inside.fold(0.0, |raw, &(_, omega)| unit.step(raw, omega));
                f64::from(unit.word(raw))
            }
            _ => {
                let texture = map / 4 * 4;
                let mut raw = [0.0; 4];
                for &(layer, omega) in &texel.drawn {
                    if cover.holds(layer, texture + 3) {
                        let mask = [0, 1, 2, 3].map(|c| cover.holds(layer, texture + c));
                        unit.step_group(&mut raw, omega, mask);
                    }
                }
                f64::from(unit.word(raw[map % 4]))
            }
        }
    }

    /// Thickness in front of a receiver; `value` gives what a map stores.
    fn thickness(
        &self,
        bounds: (f64, f64),
        depth: f32,
        shift: f64,
        value: &dyn Fn(usize) -> f64,
    ) -> f64 {
        let unit = Unit { blend: self.layered.blend, format: self.layered.format };
        let upto = |map: usize| {
            let slabs = self.layered.packing == Packing::Slabs;
            let before = if slabs { map / 4 } else { 0 };
            let earlier: f64 = (0..before).map(|t| unit.thickness(value(4 * t + 3))).sum();
            earlier + unit.thickness(value(map))
        };
        let before = |layer: usize| layer.checked_sub(1).map_or(0.0, upto);
        let depth = f64::from(depth);
        let last = self.layered.layers as usize - 1;
        let open = matches!(self.layered.layout, Layout::Deep { .. });
        if depth < bounds.0 {
            return 0.0;
        }
        if depth > bounds.1 && !open {
            return upto(last);
        }
        let c = self.moved(self.coordinate(bounds, depth), shift).clamp(0.0, last as f64 + 1.0);
        let layer = (c.floor() as usize).min(last);
        match self.layered.lookup {
            Lookup::Nearest => upto(layer),
            Lookup::Exclusive => before(layer),
            Lookup::Lerp => {
                let share = c - layer as f64;
                (1.0 - share) * before(layer) + share * upto(layer)
            }
        }
    }
}

fn range_of_map(fragments: &Fragments, opaque: Opaque) -> (f64, f64) {
    let stretches = opaque.stretches_bounds();
    let mut depths: Vec<f32> = fragments.items.iter().map(|f| f.depth).collect();
    if stretches || depths.is_empty() {
        let weights = fragments.opaque.iter().filter_map(|&z| cpu::weighted(opaque, z));
        depths.extend(weights.map(|f| f.depth));
    }
    depths.sort_by(f32::total_cmp);
    match (depths.first(), depths.last()) {
        (Some(&first), Some(&last)) => (f64::from(first), f64::from(last)),
        _ => (0.0, 1.0),
    }
}

fn ordered(a: f64, b: f64) -> (f64, f64) {
    (a.min(b), a.max(b))
}
