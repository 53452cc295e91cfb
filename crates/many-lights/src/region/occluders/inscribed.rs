//! The largest upright boxes of a turn within a box that stands another way.

use super::block::{Block, is_upright, turned};
use crate::region::{Solid, Turn};
use glam::{DVec2, DVec3, Vec2Swizzles};

/// A box that is not upright may be cut into so many, each inscribed on its own ...
const MOST_PIECES: u32 = 4;
/// ... where every further piece adds this share of the box: few large occluders cost least.
const LEAST_GAIN: f64 = 0.05;
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
