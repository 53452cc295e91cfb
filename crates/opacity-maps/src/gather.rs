//! What the codes that are no layers share: a texel's fragments, their bounds, storage formats.

use crate::{Format, Fragment};
use half::f16;

/// Thickness beyond which nothing is told apart: e^-1e6 is 0 in any float, and sums of a million
/// such fragments stay finite.
pub const MOST_OMEGA: f32 = 1e6;

/// Least distance between the bounds of a ray that has an inside.
pub const LEAST_SPAN: f32 = 1e-6;

/// The translucent fragments in the order they are drawn, then the opaque one.
pub fn everything(
    fragments: &[Fragment],
    opaque: Option<Fragment>,
) -> impl Iterator<Item = Fragment> + Clone + '_ {
    let capped = |f: Fragment| Fragment { omega: f.omega.min(MOST_OMEGA), ..f };
    fragments.iter().copied().chain(opaque).map(capped)
}

/// The same by depth, and at one depth by thickness: whatever the order of drawing.
pub fn sorted(fragments: &[Fragment], opaque: Option<Fragment>, out: &mut Vec<Fragment>) {
    // The bits of a float as an integer of the same order.
    let ordered = |x: f32| {
        let bits = x.to_bits();
        if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
    };
    let key = |f: &Fragment| u64::from(ordered(f.depth)) << 32 | u64::from(f.omega.to_bits());
    out.clear();
    out.extend(everything(fragments, opaque));
    out.sort_unstable_by_key(key);
}

/// First and last depth of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// First.
    pub z0: f32,
    /// Last.
    pub z1: f32,
}

/// Where a depth lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Nothing lies strictly in front of it.
    Front,
    /// At this share of the way from the first to the last, 0..=1.
    Inside(f32),
    /// Everything lies strictly in front of it.
    Behind,
}

impl Bounds {
    /// The light's whole range.
    pub const WHOLE: Self = Self { z0: 0.0, z1: 1.0 };
    /// Of a ray that meets nothing.
    pub const EMPTY: Self = Self { z0: 1.0, z1: 0.0 };

    /// Of the translucent fragments, and of the opaque one where it counts.
    pub fn of(fragments: &[Fragment], opaque: Option<Fragment>, opaque_counts: bool) -> Self {
        let counted = everything(fragments, opaque.filter(|_| opaque_counts));
        let mut bounds: Option<Self> = None;
        for f in counted {
            let seen = bounds.unwrap_or(Self { z0: f.depth, z1: f.depth });
            bounds = Some(Self { z0: seen.z0.min(f.depth), z1: seen.z1.max(f.depth) });
        }
        bounds.unwrap_or(Self::EMPTY)
    }

    /// Share of the way at which a fragment is stored, 0..=1.
    pub fn share(self, depth: f32) -> f32 {
        let span = self.z1 - self.z0;
        if span < LEAST_SPAN {
            return if depth <= self.z1 { 0.0 } else { 1.0 };
        }
        ((depth - self.z0) / span).clamp(0.0, 1.0)
    }

    /// [`Bounds::share`] in f64, for references.
    pub fn share_exactly(self, depth: f32) -> f64 {
        if self.z1 - self.z0 < LEAST_SPAN {
            return if depth <= self.z1 { 0.0 } else { 1.0 };
        }
        let (z0, z1) = (f64::from(self.z0), f64::from(self.z1));
        ((f64::from(depth) - z0) / (z1 - z0)).clamp(0.0, 1.0)
    }

    /// Where a receiver lies. A ray that is thinner than [`LEAST_SPAN`] has no inside.
    pub fn place(self, depth: f32) -> Place {
        if depth <= self.z0 || (self.z1 - self.z0 < LEAST_SPAN && depth <= self.z1) {
            Place::Front
        } else if depth > self.z1 {
            Place::Behind
        } else {
            Place::Inside(self.share(depth))
        }
    }
}

/// A sum as a float format stores it; a half that would overflow stays at its largest. Sums are
/// rounded once, from f64: so the same terms give the same halves in every form.
pub fn stored(format: Format, sum: f64) -> f32 {
    match format {
        Format::F16 => f16::from_f64(sum.clamp(f16::MIN.to_f64(), f16::MAX.to_f64())).to_f32(),
        _ => sum as f32,
    }
}

/// The same without rounding where the format is 32 bits wide: for references.
pub fn stored_exactly(format: Format, sum: f64) -> f64 {
    match format {
        Format::F16 => f64::from(stored(format, sum)),
        _ => sum,
    }
}

/// Bytes of a stored number.
pub fn bytes(format: Format) -> u64 {
    match format {
        Format::F16 => 2,
        _ => 4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_follow_the_strict_order_of_depths() {
        let at = |depth| Fragment { depth, omega: 1.0 };
        let ray = Bounds::of(&[at(0.75), at(0.25)], Some(at(0.9)), false);
        assert_eq!(ray, Bounds { z0: 0.25, z1: 0.75 });
        assert_eq!(ray.place(0.25), Place::Front);
        assert_eq!(ray.place(0.5), Place::Inside(0.5));
        assert_eq!(ray.place(0.75), Place::Inside(1.0));
        assert_eq!(ray.place(0.7501), Place::Behind);
        assert_eq!(Bounds::of(&[at(0.75)], Some(at(0.9)), true).z1, 0.9);
        let thin = Bounds::of(&[at(0.5)], None, true);
        assert_eq!((thin.place(0.5), thin.place(0.50001)), (Place::Front, Place::Behind));
        assert_eq!(Bounds::of(&[], Some(at(0.5)), false), Bounds::EMPTY);
        assert_eq!(Bounds::EMPTY.place(1.0), Place::Front);
    }

    #[test]
    fn sorting_does_not_depend_on_the_order_of_drawing() {
        let at = |depth, omega| Fragment { depth, omega };
        let drawn = [at(0.5, 2.0), at(-0.25, 1.0), at(0.5, 1.0), at(-3.0, 0.0), at(0.0, 0.5)];
        let mut out = vec![at(9.0, 9.0)];
        sorted(&drawn, Some(at(0.25, f32::MAX)), &mut out);
        let expected = [
            at(-3.0, 0.0),
            at(-0.25, 1.0),
            at(0.0, 0.5),
            at(0.25, MOST_OMEGA),
            at(0.5, 1.0),
            at(0.5, 2.0),
        ];
        assert_eq!(out, expected);
    }

    #[test]
    fn halves_round_to_even_and_do_not_overflow() {
        assert_eq!(stored(Format::F16, 2049.0), 2048.0);
        assert_eq!(stored(Format::F16, 1e9), 65_504.0);
        assert_eq!(stored_exactly(Format::F16, -1e9), -65_504.0);
        assert_eq!(stored(Format::F32, 2049.0), 2049.0);
    }
}
