//! Lines from a cell past an occluder, rounded to the safe side.

/// Four operations are in a place on a line: their roundings are some 6 half units in the last place
/// of the terms, and this is 8.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// How much farther a plane is than what is seen against it, as a share of that one's distance from
/// `cell`: 0 where it lies on the plane. (The thesis's k is 1 more; without that 1, nothing cancels.)
pub(super) fn beyond(cell: f64, at: f64, plane: f64) -> f64 {
    (plane - at) / (at - cell)
}

/// Where the line from `from` through `at` is, `beyond` times their distance farther: not below that
/// place by rounding. Exactly `at` where `beyond` is 0, and never past `at` towards `from`: umbrae of
/// walls that touch have to touch.
pub(super) fn raised(from: f64, at: f64, beyond: f64) -> f64 {
    if beyond == 0.0 || at.is_infinite() {
        return at;
    }
    let more = beyond * (at - from);
    let place = at + more + ROUNDING * (more.abs() + at.abs());
    if more <= 0.0 { place.min(at) } else { place }
}

/// The same, but not above that place by rounding.
pub(super) fn lowered(from: f64, at: f64, beyond: f64) -> f64 {
    -raised(-from, -at, beyond)
}

/// Height at `u` of the line through two points (u, h), of which the first is left of the second; not
/// above it by rounding. Outside of the two as well.
pub(super) fn between(a: [f64; 2], b: [f64; 2], u: f64) -> f64 {
    let width = b[0] - a[0];
    let share = (u - a[0]) / width;
    let rise = b[1] - a[1];
    // Where the share is near 1 it is taken from the other end: what cancels is small.
    let height = if share > 0.5 { b[1] - (b[0] - u) / width * rise } else { a[1] + share * rise };
    let size = share.abs().max(1.0) * (a[1].abs() + b[1].abs());
    height - ROUNDING * size
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roundings_go_the_safe_way_and_stay_small() {
        for (from, at) in [(0.0, 1.0), (3.5, -2.0), (1e6, 1e6 + 1e-4), (1e-4, -1e6), (2.0, 2.0)] {
            for beyond in [0.0, 1e-9, 0.3, 7.0, 1e9] {
                let (low, high) = (lowered(from, at, beyond), raised(from, at, beyond));
                assert!(low <= high);
                let size = (at - from).abs() * beyond + at.abs();
                assert!(high - low <= 2e-15 * size, "{from} {at} {beyond}: {low} {high}");
                if beyond == 0.0 || at == from {
                    assert_eq!((low <= at, high >= at), (true, true));
                }
            }
            assert_eq!(raised(from, at, 0.0), at);
            assert_eq!(lowered(from, at, 0.0), at);
        }
        assert_eq!(raised(0.0, f64::NEG_INFINITY, 2.0), f64::NEG_INFINITY);
        // Past the end towards the cell an umbra never draws back from the occluder's side.
        assert_eq!(raised(1.0, 1.0, 3.0), 1.0);
        assert_eq!(lowered(1.0, 1.0, 3.0), 1.0);
        assert!(raised(1.0 + 1e-15, 1.0, 3.0) <= 1.0);
    }

    #[test]
    fn a_line_between_points_holds_its_ends_from_below() {
        let (a, b) = ([1.0, -3.0], [4.0, 11.0]);
        for (u, h) in [(1.0, -3.0), (4.0, 11.0), (2.5, 4.0), (0.0, -3.0 - 14.0 / 3.0)] {
            let found = between(a, b, u);
            assert!(found <= h && found > h - 1e-13, "{u}: {found} {h}");
        }
    }
}
