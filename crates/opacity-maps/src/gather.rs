//! What the codes that are no layers share: a texel's fragments, their bounds, storage formats.

use crate::{
    Format, Fragment,
    layered::placement::{Bounds, THINNEST},
};
use half::f16;

/// Thickness beyond which nothing is told apart: e^-1e6 is 0 in any float, and sums of a million
/// such fragments stay finite.
pub const MOST_OMEGA: f32 = 1e6;

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

/// The light's whole range.
pub const WHOLE: Bounds = Bounds { first: 0.0, last: 1.0 };

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

/// Where a receiver lies. A ray that is thinner than [`THINNEST`] has no inside.
pub fn place(bounds: Bounds, depth: f32) -> Place {
    let thin = bounds.last - bounds.first < THINNEST;
    if depth <= bounds.first || (thin && depth <= bounds.last) {
        Place::Front
    } else if depth > bounds.last {
        Place::Behind
    } else {
        Place::Inside(bounds.local(depth))
    }
}

/// Share of the way from the first to the last, 0..=1, at which a fragment is stored.
pub fn share(bounds: Bounds, depth: f32) -> f64 {
    if bounds.last - bounds.first < THINNEST {
        return f64::from(bounds.local(depth));
    }
    let (first, last) = (f64::from(bounds.first), f64::from(bounds.last));
    ((f64::from(depth) - first) / (last - first)).clamp(0.0, 1.0)
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
        assert_eq!(place(ray, 0.25), Place::Front);
        assert_eq!(place(ray, 0.5), Place::Inside(0.5));
        assert_eq!(place(ray, 0.75), Place::Inside(1.0));
        assert_eq!(place(ray, 0.7501), Place::Behind);
        let thin = Bounds::of(&[at(0.5)], None, true);
        assert_eq!((place(thin, 0.5), place(thin, 0.50001)), (Place::Front, Place::Behind));
        assert_eq!(place(Bounds::EMPTY, 1.0), Place::Front);
    }

    #[test]
    fn shares_of_the_way_stay_within_it() {
        let ray = Bounds { first: 0.25, last: 0.75 };
        let shares = [0.0, 0.25, 0.5, 0.75, 0.9].map(|depth| share(ray, depth));
        assert_eq!(shares, [0.0, 0.0, 0.5, 1.0, 1.0]);
        let thin = Bounds { first: 0.5, last: 0.5 };
        assert_eq!([0.4, 0.5, 0.6].map(|depth| share(thin, depth)), [0.0, 0.0, 1.0]);
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
