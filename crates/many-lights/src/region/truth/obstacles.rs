//! What rays may meet.

use crate::{Light, World, region::Cuboid};
use glam::DVec3;

/// What hides lights.
#[derive(Clone, Copy)]
pub enum Obstacles<'a> {
    /// The triangles of the world ([`World::sees_from`]).
    Triangles(&'a World),
    /// The occluders themselves, closed boxes.
    Boxes,
}

/// Whether a segment meets a closed box, in the space of a direction (u, w, h).
pub(super) fn meets(from: [f64; 3], to: [f64; 3], b: &Cuboid) -> bool {
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for (axis, [low, high]) in [b.u, b.w, b.h].into_iter().enumerate() {
        let (start, way) = (from[axis], to[axis] - from[axis]);
        if way == 0.0 {
            if start < low || start > high {
                return false;
            }
            continue;
        }
        let (a, z) = ((low - start) / way, (high - start) / way);
        first = first.max(a.min(z));
        last = last.min(a.max(z));
    }
    first <= last
}

/// Whether a ray between a point and a light arrives: `local` in local space, `from` and `to` the same
/// two places in the space of the occluders' direction.
pub(super) fn arrives(
    obstacles: &Obstacles<'_>,
    light: &Light,
    local: DVec3,
    (from, to): ([f64; 3], [f64; 3]),
    occluders: &[Cuboid],
) -> bool {
    match obstacles {
        Obstacles::Triangles(world) => world.sees_from(local, light),
        Obstacles::Boxes => !occluders.iter().any(|b| meets(from, to, b)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_meet_what_they_touch_and_not_what_they_pass() {
        let b = Cuboid { u: [0.0, 1.0], w: [2.0, 3.0], h: [f64::NEG_INFINITY, 5.0] };
        let flat = Cuboid { w: [2.0, 2.0], ..b };
        for b in [b, flat] {
            assert!(meets([0.5, 0.0, 1.0], [0.5, 9.0, 1.0], &b), "through");
            assert!(meets([1.0, 0.0, 1.0], [1.0, 9.0, 1.0], &b), "along a side");
            assert!(meets([0.5, 0.0, 5.0], [0.5, 9.0, 5.0], &b), "along the roof");
            assert!(meets([0.5, 0.0, 1.0], [0.5, 2.0, 1.0], &b), "up to the front");
            assert!(!meets([0.5, 0.0, 1.0], [0.5, 1.9, 1.0], &b), "before it");
            assert!(!meets([1.1, 0.0, 1.0], [1.1, 9.0, 1.0], &b), "beside it");
            assert!(!meets([0.5, 0.0, 5.1], [0.5, 9.0, 5.1], &b), "above it");
            assert!(meets([0.5, 0.0, -1e9], [0.5, 9.0, -1e9], &b), "nothing passes below");
            assert!(meets([0.5, 2.0, 1.0], [0.5, 2.0, 1.0], &b), "a point of it");
        }
    }
}
