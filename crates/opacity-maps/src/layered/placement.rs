//! Where a depth lies among a texel's layers.

use super::{boundaries::Boundaries, cells::Cells, split::SplitFunction};
use crate::{Fragment, Split};

/// Bounds nearer to each other than this hold one layer.
pub const THINNEST: f32 = 1e-6;

/// A texel's first and last translucent fragment; `first > last` where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Light depth of the first.
    pub first: f32,
    /// Light depth of the last.
    pub last: f32,
}

impl Bounds {
    /// No fragment: what an empty texel stores.
    pub const EMPTY: Self = Self { first: 1.0, last: 0.0 };

    /// The bounds of fragments; of `opaque` too where `stretches`, or where there is nothing else.
    pub fn of(fragments: &[Fragment], opaque: Option<Fragment>, stretches: bool) -> Self {
        let joined = opaque.filter(|_| stretches || fragments.is_empty());
        let start = match joined.as_ref().or(fragments.first()) {
            Some(f) => Self { first: f.depth, last: f.depth },
            None => return Self::EMPTY,
        };
        fragments
            .iter()
            .fold(start, |b, f| Self { first: b.first.min(f.depth), last: b.last.max(f.depth) })
    }

    /// Depth from the first (0) to the last (1).
    #[inline]
    pub fn local(self, depth: f32) -> f32 {
        if self.last - self.first < THINNEST {
            return if depth <= self.last { 0.0 } else { 1.0 };
        }
        (depth - self.first) / (self.last - self.first)
    }
}

/// A receiver's place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// In front of everything: lit.
    Before,
    /// At this layer coordinate, 0..=K.
    At(f32),
    /// Behind everything: the total counts.
    Behind,
}

/// Where layers lie, ready to be evaluated.
#[derive(Clone, Debug)]
pub enum Placement {
    /// Planes shared by all rays.
    Planes {
        /// First and last plane.
        bounds: Bounds,
        /// All planes, where they are not even.
        uneven: Option<Boundaries>,
    },
    /// From each ray's first fragment on.
    Deep {
        /// Depth of all layers together.
        span: f32,
        /// Depths behind the first fragment, where layers grow.
        uneven: Option<Boundaries>,
    },
    /// Between each ray's bounds.
    Bounded {
        /// The split, none where it is uniform.
        split: Option<(SplitFunction, Cells)>,
        /// What u = 1 is multiplied by: K or K - 1.
        steps: f32,
    },
}

impl Placement {
    /// Layers between each ray's bounds.
    pub fn bounded(split: &Split, steps: usize) -> Self {
        use crate::SplitKind::{Normalised, Positions};
        // These two are the identity to the bit.
        let uniform = split.lambda == 0.0 && matches!(split.kind, Normalised | Positions);
        if uniform {
            return Self::Bounded { split: None, steps: steps as f32 };
        }
        Self::split(SplitFunction::new(split), steps)
    }

    /// The same by a function at hand.
    pub fn split(function: SplitFunction, steps: usize) -> Self {
        let cells = Cells::new(&function, steps as f32);
        Self::Bounded { split: Some((function, cells)), steps: steps as f32 }
    }

    /// Words of a texel that hold bounds.
    pub fn bound_words(&self) -> usize {
        match self {
            Self::Planes { .. } => 0,
            Self::Deep { .. } => 1,
            Self::Bounded { .. } => 2,
        }
    }

    /// Writes a texel's bounds.
    pub fn write(&self, bounds: Bounds, words: &mut [f32]) {
        for (word, bound) in words[..self.bound_words()].iter_mut().zip([bounds.first, bounds.last])
        {
            *word = bound;
        }
    }

    /// Reads a texel's bounds, as far as they are stored.
    #[inline]
    pub fn read(&self, words: &[f32]) -> Bounds {
        match self {
            Self::Planes { bounds, .. } => *bounds,
            Self::Deep { .. } => Bounds { first: words[0], last: f32::INFINITY },
            Self::Bounded { .. } => Bounds { first: words[0], last: words[1] },
        }
    }

    /// Place of a receiver.
    #[inline]
    pub fn place(&self, bounds: Bounds, layers: usize, depth: f32) -> Place {
        if depth < bounds.first {
            Place::Before
        } else if depth > bounds.last {
            Place::Behind
        } else {
            Place::At(self.coordinate(bounds, layers, depth).clamp(0.0, layers as f32))
        }
    }

    /// Layers of fragments, as many as `out` is long; those beyond an end go to the layer there.
    #[inline]
    pub fn layers_of(
        &self,
        bounds: Bounds,
        layers: usize,
        bias: f32,
        fragments: &[Fragment],
        out: &mut [u32],
    ) {
        let last = layers as f32 - 1.0;
        // A NaN and what lies in front count as 0.
        let layer = |c: f32| c.max(0.0).min(last) as i32 as u32;
        let pairs = out.iter_mut().zip(fragments);
        // The choice is made outside the loop, so that the common cases are vectorised.
        match self {
            Self::Planes { uneven: None, .. } if bounds.last - bounds.first >= THINNEST => {
                let (depth, n) = (bounds.last - bounds.first, layers as f32);
                pairs.for_each(|(k, f)| *k = layer((f.depth - bias - bounds.first) / depth * n));
            }
            Self::Deep { span, uneven: None } => {
                let (span, n) = (*span, layers as f32);
                pairs.for_each(|(k, f)| *k = layer((f.depth - bias - bounds.first) / span * n));
            }
            Self::Bounded { split: None, steps } if bounds.last - bounds.first >= THINNEST => {
                let (depth, n) = (bounds.last - bounds.first, *steps);
                let local = |f: &Fragment| (f.depth - bias - bounds.first) / depth;
                pairs.for_each(|(k, f)| *k = layer(local(f).min(1.0) * n));
            }
            Self::Bounded { split: Some((split, cells)), steps } => pairs.for_each(|(k, f)| {
                let t = bounds.local(f.depth - bias);
                let coordinate = || split.coordinate(t) * steps;
                *k = cells.layer(t).unwrap_or_else(|| layer(coordinate())).min(layers as u32 - 1);
            }),
            _ => pairs.for_each(|(k, f)| {
                *k = layer(self.coordinate(bounds, layers, f.depth - bias));
            }),
        }
    }

    /// Layer coordinate of a depth, not clamped.
    #[inline]
    fn coordinate(&self, bounds: Bounds, layers: usize, depth: f32) -> f32 {
        let n = layers as f32;
        match self {
            Self::Planes { uneven: None, .. } => bounds.local(depth) * n,
            Self::Planes { uneven: Some(planes), .. } => planes.coordinate(depth),
            Self::Deep { span, uneven: None } => (depth - bounds.first) / span * n,
            Self::Deep { uneven: Some(growing), .. } => growing.coordinate(depth - bounds.first),
            Self::Bounded { split: None, steps } => bounds.local(depth).min(1.0) * steps,
            Self::Bounded { split: Some((split, _)), steps } => {
                split.coordinate(bounds.local(depth)) * steps
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SplitKind;

    fn fragments(depths: &[f32]) -> Vec<Fragment> {
        depths.iter().map(|&depth| Fragment { depth, omega: 0.5 }).collect()
    }

    #[test]
    fn bounds_hold_translucent_fragments_and_opaque_ones_where_asked_or_alone() {
        let some = fragments(&[0.5, 0.2, 0.4]);
        let opaque = Some(Fragment { depth: 0.9, omega: 3.0 });
        let of = |first, last| Bounds { first, last };
        assert_eq!(Bounds::of(&some, None, true), of(0.2, 0.5));
        assert_eq!(Bounds::of(&some, opaque, false), of(0.2, 0.5));
        assert_eq!(Bounds::of(&some, opaque, true), of(0.2, 0.9));
        assert_eq!(Bounds::of(&[], opaque, false), of(0.9, 0.9));
        assert_eq!(Bounds::of(&[], None, true), Bounds::EMPTY);
    }

    #[test]
    fn one_depth_is_the_first_layer_and_behind_it_is_behind() {
        let split = Split { lambda: 0.0, kind: SplitKind::Normalised, width: 512 };
        let placement = Placement::bounded(&split, 8);
        let bounds = Bounds { first: 0.5, last: 0.5 };
        let next = 0.5f32.next_up();
        assert_eq!(placement.place(bounds, 8, 0.5f32.next_down()), Place::Before);
        assert_eq!(placement.place(bounds, 8, 0.5), Place::At(0.0));
        assert_eq!(placement.place(bounds, 8, next), Place::Behind);
        let mut layer = [9; 3];
        let depths = fragments(&[0.4, 0.5, 0.7]);
        placement.layers_of(bounds, 8, 0.0, &depths, &mut layer);
        assert_eq!(layer, [0, 0, 7]);
    }

    #[test]
    fn the_vectorised_cases_agree_with_the_coordinate() {
        let split = Split { lambda: 0.0, kind: SplitKind::Normalised, width: 512 };
        let bounds = Bounds { first: 0.1, last: 0.7 };
        let placements = [
            Placement::Planes { bounds, uneven: None },
            Placement::Deep { span: 0.5, uneven: None },
            Placement::bounded(&split, 16),
            Placement::bounded(&split, 15),
        ];
        let depths: Vec<f32> = (0..2000).map(|i| i as f32 / 2000.0).collect();
        let mut layers = vec![0; depths.len()];
        for placement in placements {
            placement.layers_of(bounds, 16, 1e-3, &fragments(&depths), &mut layers);
            for (&depth, &layer) in depths.iter().zip(&layers) {
                let c = placement.coordinate(bounds, 16, depth - 1e-3).clamp(0.0, 15.0);
                assert_eq!(layer, c as u32, "{placement:?} {depth}");
            }
            assert!((0..15).all(|k| layers.contains(&k)));
        }
    }
}
