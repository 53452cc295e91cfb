//! The largest upright box of a turn within a box that stands another way.

use super::Solid;
use crate::region::Turn;
use dapple_scene::city::OrientedBox;
use glam::{DVec2, DVec3, Vec2Swizzles};

/// The upright box of greatest plan area within `b`, in turned space; `None` for a box without any.
pub fn largest(b: &OrientedBox, turn: Turn) -> Option<Solid> {
    let (axis, sides) = (turn.axis(), DVec2::new(b.half.x, b.half.z));
    let half = half_sides(sides, axis.dot(b.axis).abs(), axis.perp_dot(b.axis).abs())?;
    let (centre, half) = (turn.to(b.centre), DVec3::new(half.x, b.half.y, half.y));
    Some(Solid { min: centre - half, max: centre + half })
}

/// Half sides of the largest upright rectangle within one of half sides `sides`, whose first side lies
/// at an angle of that cosine and sine, both at least 0.
fn half_sides(sides: DVec2, cos: f64, sin: f64) -> Option<DVec2> {
    if sin == 0.0 {
        return Some(sides);
    }
    if cos == 0.0 {
        return Some(sides.yx());
    }
    let (long, short) = (sides.max_element(), sides.min_element());
    let half = if short <= 2.0 * sin * cos * long {
        // Two corners on the long sides.
        let x = 0.5 * short;
        if sides.x >= sides.y { DVec2::new(x / sin, x / cos) } else { DVec2::new(x / cos, x / sin) }
    } else {
        // All four corners on sides.
        let double = cos * cos - sin * sin;
        DVec2::new(sides.x * cos - sides.y * sin, sides.y * cos - sides.x * sin) / double
    };
    (half.is_finite() && half.min_element() > 0.0).then_some(half)
}
