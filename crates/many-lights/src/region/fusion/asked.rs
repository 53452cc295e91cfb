//! What of shadows matters to all that is still asked: most of a city's does not.
//!
//! All lines from a cell to what is still open cross a plane within [`around`] its projections. A shadow
//! beside them hides nothing that is asked now, nor on any farther plane, where the same lines would
//! have to cross it. One that is as high as the highest of them hides what it hides however high it
//! were: such tops are all one, and so are such feet, which makes joined shadows few and their order
//! plain.

use super::query::overlaps;
use super::{Fusion, Projection, Umbra};

/// Around no projection.
pub const NOTHING: Projection =
    Projection { u: [f64::INFINITY, f64::NEG_INFINITY], h: [f64::INFINITY, f64::NEG_INFINITY] };

/// Around every projection: nothing is dropped.
const EVERYTHING: Projection =
    Projection { u: [f64::NEG_INFINITY, f64::INFINITY], h: [f64::NEG_INFINITY, f64::INFINITY] };

/// What a rectangle around all that is asked begins with: the thesis's ways of joining keep all
/// shadows, as it does.
pub fn nothing_yet(fusion: Fusion) -> Projection {
    match fusion {
        Fusion::HeightOrdered => NOTHING,
        Fusion::None | Fusion::Insertion => EVERYTHING,
    }
}

/// The rectangle around two.
pub fn around(a: &Projection, b: &Projection) -> Projection {
    let joined = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
    Projection { u: joined(a.u, b.u), h: joined(a.h, b.h) }
}

/// What of a shadow matters where all that is asked lies within a rectangle: nothing of one beside it;
/// a top above it is infinitely high, where the edge is above it from end to end, and so is a foot
/// below it deep.
pub fn asked_part(shadow: &Umbra, asked: &Projection) -> Option<Umbra> {
    if !overlaps(shadow, asked) {
        return None;
    }
    let foot = if shadow.foot <= asked.h[0] { f64::NEG_INFINITY } else { shadow.foot };
    Some(match shadow.lowest() >= asked.h[1] {
        true => Umbra::flat(shadow.u, foot, f64::INFINITY),
        false => Umbra { foot, ..*shadow },
    })
}

/// Whether it hides all between its ends.
pub(super) fn is_endless(shadow: &Umbra) -> bool {
    shadow.foot == f64::NEG_INFINITY && shadow.lowest() == f64::INFINITY
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEEP: f64 = f64::NEG_INFINITY;
    const HIGH: f64 = f64::INFINITY;

    #[test]
    fn what_is_beside_all_that_is_asked_goes_and_what_is_beyond_it_has_no_end() {
        let asked = around(
            &Projection { u: [0.0, 1.0], h: [1.0, 2.0] },
            &Projection { u: [0.5, 4.0], h: [1.5, 3.0] },
        );
        assert_eq!(asked, Projection { u: [0.0, 4.0], h: [1.0, 3.0] });
        assert_eq!(around(&asked, &NOTHING), asked);
        let part = |u, foot, top| asked_part(&Umbra::flat(u, foot, top), &asked);
        // Borders belong to both.
        assert_eq!(part([4.1, 5.0], DEEP, 9.0), None);
        assert_eq!(part([-3.0, -0.1], DEEP, 9.0), None);
        assert_eq!(part([4.0, 5.0], DEEP, 0.9), None);
        assert_eq!(part([4.0, 5.0], 3.1, 9.0), None);
        assert_eq!(part([4.0, 5.0], 2.0, 2.9), Some(Umbra::flat([4.0, 5.0], 2.0, 2.9)));
        assert_eq!(part([4.0, 5.0], 1.0, 2.9), Some(Umbra::flat([4.0, 5.0], DEEP, 2.9)));
        assert_eq!(part([4.0, 5.0], 1.1, 3.0), Some(Umbra::flat([4.0, 5.0], 1.1, HIGH)));
        let endless = part([-9.0, 5.0], 1.0, 3.0).unwrap();
        assert!(is_endless(&endless) && endless == Umbra::flat([-9.0, 5.0], DEEP, HIGH));
        let single = Umbra::flat([7.0, 8.0], 2.0, 9.0);
        for fusion in [Fusion::None, Fusion::Insertion] {
            assert_eq!(asked_part(&single, &around(&nothing_yet(fusion), &asked)), Some(single));
        }
        assert_eq!(around(&nothing_yet(Fusion::HeightOrdered), &asked), asked);
        // An edge that falls below it keeps its form.
        let sloped = Umbra { top: [2.0, 9.0], ..Umbra::flat([0.0, 1.0], DEEP, 0.0) };
        assert_eq!(asked_part(&sloped, &asked), Some(sloped));
        let sloped = Umbra { top: [3.0, 9.0], ..sloped };
        assert_eq!(asked_part(&sloped, &asked), Some(Umbra::flat([0.0, 1.0], DEEP, HIGH)));
        assert_eq!(asked_part(&sloped, &NOTHING), None);
    }
}
