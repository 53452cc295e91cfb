//! The largest upright boxes of a turn within a box that stands another way.

use super::block::{Block, is_upright, turned};
use crate::region::{Solid, Turn};
use glam::{DVec2, DVec3, Vec2Swizzles};

/// A box that is not upright may be cut into so many, each inscribed on its own ...
const MOST_PIECES: u32 = 4;
/// ... where every further piece adds this share of the box: each costs planes and shadows.
const LEAST_GAIN: f64 = 0.1;
/// What inscribed boxes keep from the sides, over the farthest coordinate: several roundings.
const MARGIN: f64 = 1e-14;

/// Upright boxes within `block`, in turned space; none within one that has no area unless it is
/// upright itself.
pub fn within(block: &Block, turn: Turn, solids: &mut Vec<Solid>) {
    let solid = |min: DVec2, max: DVec2| Solid {
        min: DVec3::new(min.x, block.foot, min.y),
        max: DVec3::new(max.x, block.top, max.y),
    };
    let plan = block.plan.map(|p| turned(turn, p));
    if is_upright(&plan) {
        let [a, _, b, _] = plan;
        solids.push(solid(a.min(b), a.max(b)));
        return;
    }
    // The long side comes first.
    let [a, b, c, d] = plan;
    let [a, b, d] = if a.distance(b) >= b.distance(c) { [a, b, d] } else { [b, c, a] };
    let (long, short) = (b - a, d - a);
    let (length, width) = (long.length(), short.length());
    let axis = long / length;
    // Sides of the largest within one of so many pieces.
    let largest = |pieces: u32| largest_within(DVec2::new(length / f64::from(pieces), width), axis);
    let area = |pieces: u32| {
        largest(pieces).map_or(0.0, |sides| f64::from(pieces) * sides.element_product())
    };
    let gained = |pieces: u32| area(pieces) - LEAST_GAIN * f64::from(pieces) * length * width;
    let more = |best: u32, pieces: u32| if gained(pieces) > gained(best) { pieces } else { best };
    let pieces = (2..=MOST_PIECES).fold(1, more);
    let Some(sides) = largest(pieces) else { return };
    let farthest = plan.map(|p| p.abs().max_element()).into_iter().fold(0.0, f64::max);
    let half = 0.5 * sides - MARGIN * farthest;
    if half.min_element() <= 0.0 {
        return;
    }
    for piece in 0..pieces {
        let along = (f64::from(piece) + 0.5) / f64::from(pieces);
        let centre = a + along * long + 0.5 * short;
        solids.push(solid(centre - half, centre + half));
    }
}

/// Sides of the largest upright rectangle within one of these sides, the first along `axis`.
fn largest_within(sides: DVec2, axis: DVec2) -> Option<DVec2> {
    let (cos, sin) = (axis.x.abs(), axis.y.abs());
    let (long, short) = (sides.max_element(), sides.min_element());
    let inscribed = if short <= 2.0 * sin * cos * long {
        // Two corners halfway across, on the long sides.
        let flat = 0.5 * short / DVec2::new(sin, cos);
        if sides.x >= sides.y { flat } else { flat.yx() }
    } else {
        // All four corners on sides.
        let double = cos * cos - sin * sin;
        DVec2::new(sides.x * cos - sides.y * sin, sides.y * cos - sides.x * sin) / double
    };
    (inscribed.is_finite() && inscribed.min_element() > 0.0).then_some(inscribed)
}

#[cfg(test)]
mod tests {
    use super::super::block::Block;
    use super::*;
    use dapple_scene::city::OrientedBox;
    use proptest::prelude::*;

    /// The greatest area of an upright rectangle in the middle of one of `sides` along `axis`, found by
    /// trying widths: its corners have to lie within.
    fn scanned(sides: DVec2, axis: DVec2) -> f64 {
        const STEPS: u32 = 4000;
        let diagonal = sides.length();
        let area = |step: u32| {
            let width = diagonal * f64::from(step) / f64::from(STEPS);
            // Along each side, a corner at (width, height) / 2 reaches so far.
            let height = |a: f64, b: f64, side: f64| match b > 0.0 {
                true => (side - a * width) / b,
                false if a * width <= side => f64::INFINITY,
                false => 0.0,
            };
            let (cos, sin) = (axis.x.abs(), axis.y.abs());
            let height = height(cos, sin, sides.x).min(height(sin, cos, sides.y));
            width * height.max(0.0)
        };
        (0..=STEPS).map(area).fold(0.0, f64::max)
    }

    proptest! {
        #[test]
        fn the_closed_form_is_the_largest(
            long in 0.1..300.0f64, share in 0.01..1.0f64, degrees in 0.01..89.99f64, exchange: bool,
        ) {
            let sides = DVec2::new(long, share * long);
            let sides = if exchange { sides.yx() } else { sides };
            let axis = DVec2::from_angle(degrees.to_radians());
            let best = largest_within(sides, axis).unwrap();
            // Its corners lie within, one of them on a side.
            let reach = |a: DVec2| best.dot(a.abs());
            let [along, across] = [reach(axis) / sides.x, reach(axis.perp()) / sides.y];
            prop_assert!(along < 1.0 + 1e-12 && across < 1.0 + 1e-12, "{along} {across}");
            prop_assert!(along.max(across) > 1.0 - 1e-12, "{along} {across}");
            let (area, scanned) = (best.element_product(), scanned(sides, axis));
            prop_assert!(scanned <= area * (1.0 + 1e-9) && scanned >= 0.97 * area, "{area} {scanned}");
        }

        #[test]
        fn pieces_lie_within_and_hold_what_one_box_would(
            half in prop::array::uniform3(0.01..100.0f64), centre in prop::array::uniform3(-1e4..1e4f64),
            own in 0.0..360.0f64, degrees in 0u32..90,
        ) {
            let axis = DVec2::from_angle(own.to_radians());
            let b = OrientedBox { centre: centre.into(), axis, half: half.into() };
            let (turn, mut solids) = (Turn::degrees(degrees), vec![]);
            within(&Block::new(&b).unwrap(), turn, &mut solids);
            prop_assert!((1..=MOST_PIECES as usize).contains(&solids.len()));
            let mut area = 0.0;
            for solid in &solids {
                for (x, z) in [(solid.min.x, solid.min.z), (solid.min.x, solid.max.z),
                               (solid.max.x, solid.min.z), (solid.max.x, solid.max.z)] {
                    let d = turn.from(DVec3::new(x, 0.0, z)) - b.centre;
                    let d = DVec2::new(d.x, d.z);
                    // Half a nanometre for the corners' own rounding, ten kilometres away.
                    prop_assert!(d.dot(axis).abs() <= half[0] + 5e-10, "{}", d.dot(axis));
                    prop_assert!(axis.perp_dot(d).abs() <= half[2] + 5e-10);
                }
                area += (solid.max - solid.min).with_y(1.0).element_product();
            }
            let relative = DVec2::from_angle((own - f64::from(degrees)).to_radians());
            let one = largest_within(2.0 * DVec2::new(half[0], half[2]), relative);
            let one = one.map_or(0.0, DVec2::element_product);
            prop_assert!(area > 0.999 * one - 1e-6, "{area} {one}");
        }
    }

    #[test]
    fn half_a_turn_aside_a_square_keeps_half_and_a_long_box_is_cut() {
        let square = largest_within(DVec2::splat(2.0), DVec2::from_angle(45f64.to_radians()));
        assert!((square.unwrap().element_product() - 2.0).abs() < 1e-12);
        let b = |x: f64| OrientedBox {
            centre: DVec3::ZERO,
            axis: DVec2::from_angle(45f64.to_radians()),
            half: DVec3::new(x, 5.0, 5.0),
        };
        let count = |x: f64, degrees: u32| {
            let mut solids = vec![];
            within(&Block::new(&b(x)).unwrap(), Turn::degrees(degrees), &mut solids);
            solids.len()
        };
        assert_eq!((count(5.0, 0), count(20.0, 0), count(20.0, 44)), (1, 4, 1));
    }

    #[test]
    fn walls_stand_only_in_turns_along_them() {
        let wall = OrientedBox {
            centre: DVec3::new(3.0, 1.0, 2.0),
            axis: DVec2::X,
            half: DVec3::new(4.0, 1.0, 0.0),
        };
        let block = Block::new(&wall).unwrap();
        let mut solids = vec![];
        within(&block, Turn::NONE, &mut solids);
        let expected = Solid { min: DVec3::new(-1.0, 0.0, 2.0), max: DVec3::new(7.0, 2.0, 2.0) };
        assert_eq!(solids, [expected]);
        solids.clear();
        within(&block, Turn::degrees(1), &mut solids);
        assert!(solids.is_empty());
    }
}
