//! What two shadows on one plane hide together.

use super::Umbra;
use std::cmp::Ordering;

/// Whether the intervals of two shadows have a point in common.
pub(super) fn meet(a: &Umbra, b: &Umbra) -> bool {
    a.u[0] <= b.u[1] && b.u[0] <= a.u[1]
}

/// Whether `a` hides nothing that the level part of `b` does not hide.
pub(super) fn within(a: &Umbra, b: &Umbra) -> bool {
    let beside = b.u[0] <= a.u[0] && a.u[1] <= b.u[1];
    beside && b.foot <= a.foot && a.highest() <= b.lowest()
}

/// The rectangle from end to end of two shadows whose intervals meet: as low as the lower, above both
/// feet. `None` where they do not meet, or one ends below the other's foot.
pub fn join(a: &Umbra, b: &Umbra) -> Option<Umbra> {
    let u = [a.u[0].min(b.u[0]), a.u[1].max(b.u[1])];
    let top = a.lowest().min(b.lowest());
    let foot = a.foot.max(b.foot);
    (meet(a, b) && foot < top).then_some(Umbra::flat(u, foot, top))
}

/// Whether it hides anything, and all its numbers are numbers; a level top may be infinitely
/// high.
pub(super) fn is_real(shadow: &Umbra) -> bool {
    let has_top = shadow.highest() < f64::INFINITY || shadow.is_flat();
    shadow.u[0] < shadow.u[1] && shadow.foot < shadow.highest() && has_top
}

/// From left to right.
pub(super) fn by_left(a: &Umbra, b: &Umbra) -> Ordering {
    a.u[0]
        .total_cmp(&b.u[0])
        .then_with(|| b.u[1].total_cmp(&a.u[1]))
        .then_with(|| b.lowest().total_cmp(&a.lowest()))
        .then_with(|| a.foot.total_cmp(&b.foot))
        .then_with(|| b.highest().total_cmp(&a.highest()))
}

/// Those that reach farthest down first: what they join loses least.
pub(super) fn by_foot(a: &Umbra, b: &Umbra) -> Ordering {
    a.foot.total_cmp(&b.foot).then_with(|| by_left(a, b))
}

/// The tallest first, by their level parts.
pub(super) fn by_height(a: &Umbra, b: &Umbra) -> Ordering {
    b.lowest().total_cmp(&a.lowest()).then_with(|| by_left(a, b))
}
