//! What a hierarchy passes on: which planes a box may cross still, and whether it may touch the near
//! plane.
//!
//! A box within one that lies inside a plane lies inside it too, and a box within one that does not
//! touch the near plane does not touch it. So a walk down a hierarchy tests a plane only below nodes
//! that it cuts. This is exact, bit by bit: `n . p + w` is made of products and sums of rounded
//! numbers, each of which grows, or stays, as `p` moves along `n`. What holds for the corner of the
//! outer box that is least far along `n` holds for every corner of the inner one, and for the grown
//! box where it holds for the box. The guard band itself, a root and a division, is computed only
//! where a box as it is lies outside a plane, or where the eye may be near.

use super::View;
use crate::camera::Bounds;
use glam::{DVec3, DVec4};

/// The parts of the frustum's border that a box may cross: bits 0 to 4 the planes of
/// [`View::planes`], bit 5 the part of the near plane that the image shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing(u8);

const TOUCH: u8 = 1 << 5;

impl Crossing {
    /// Of a box of which nothing is known.
    pub const UNKNOWN: Self = Self(TOUCH | (TOUCH - 1));

    /// The same as a number in `0..64`.
    pub fn bits(self) -> u8 {
        self.0
    }

    /// Back from a number; bits above the sixth mean nothing.
    pub fn from_bits(bits: u8) -> Self {
        Self(bits & Self::UNKNOWN.0)
    }

    /// Whether the box may touch the near plane: where not, [`View::touches`] is false.
    pub fn may_touch(self) -> bool {
        self.0 & TOUCH != 0
    }

    /// Of a box that was found not to touch the near plane.
    #[must_use]
    pub fn without_touch(self) -> Self {
        Self(self.0 & !TOUCH)
    }
}

impl View {
    /// [`View::sees`] of a box within one that crosses `above`, and what it crosses itself; `None`
    /// where it is not seen.
    pub fn crossing(&self, bounds: &Bounds, above: Crossing) -> Option<Crossing> {
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        if bounds.is_empty() {
            return None;
        }
        let mut crossed = above.0 & TOUCH;
        let mut inside = true;
        for (i, plane) in self.planes.iter().enumerate() {
            let bit = 1 << i;
            if above.0 & bit == 0 {
                continue;
            }
            let [least, furthest] = along(plane, min, max);
            inside &= furthest >= 0.0;
            crossed |= if least >= 0.0 { 0 } else { bit };
        }
        (inside || self.sees_grown(bounds)).then_some(Crossing(crossed))
    }
}

/// Least and greatest signed distance of a box's corners from a plane, metres.
fn along(plane: &DVec4, min: DVec3, max: DVec3) -> [f64; 2] {
    let normal = plane.truncate();
    let ahead = normal.cmpge(DVec3::ZERO);
    let (least, furthest) = (DVec3::select(ahead, min, max), DVec3::select(ahead, max, min));
    [normal.dot(least) + plane.w, normal.dot(furthest) + plane.w]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::view::tests::{camera, perspective};
    use crate::camera::{Object, Objects};
    use dapple_scene::Projection;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;

    /// A view of things of about `scale`, and boxes each within the one before, down to a point.
    fn nested(seed: u64, scale: f64, parallel: bool) -> Option<(View, Vec<Bounds>)> {
        let mut rng = Pcg32::seed_from_u64(seed);
        let mut vector = || DVec3::new(rng.random(), rng.random(), rng.random()) * 2.0 - 1.0;
        // Some look along an axis, where planes, boxes and ties are aligned.
        let target = if seed.is_multiple_of(3) { DVec3::X * 2.0 } else { vector() };
        let eye = if seed.is_multiple_of(3) { DVec3::ZERO } else { vector() };
        let projection = match parallel {
            true => Projection::Orthographic { height_m: 3.0 * scale },
            false => perspective(1.2),
        };
        let mut bounds =
            vec![Bounds::around(DVec3::splat(-9.0 * scale), DVec3::splat(9.0 * scale))];
        for _ in 0..12 {
            let last = bounds[bounds.len() - 1];
            let size = (last.max - last.min).as_dvec3();
            let part = |v: DVec3| (v * 0.5 + 0.5) * size;
            let (a, b) = (vector(), vector());
            let (a, b) = (part(a), part(b));
            let at = |p: DVec3| (last.min.as_dvec3() + p).as_vec3().clamp(last.min, last.max);
            // Wide ones first: a third of each side is kept at least.
            let (low, high) = (at(a.min(b).min(size * 0.3)), at(a.max(b).max(size * 0.7)));
            bounds.push(Bounds { min: low, max: high });
        }
        let point = bounds[bounds.len() - 1].min;
        bounds.push(Bounds { min: point, max: point });
        let (linear, translation) = (glam::Mat3::IDENTITY, glam::Vec3::ZERO);
        let object = Object { template: 0, linear, translation, bounds: bounds[0] };
        let objects = Objects { objects: vec![object], ..Objects::default() };
        let camera = camera(eye * scale, target * scale, projection);
        Some((View::new(&camera, &objects, 64, 36, 0.1 * scale).ok()?, bounds))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn what_is_passed_on_changes_no_answer(
            seed: u64, parallel: bool, scale in prop::sample::select(vec![1e-6, 1.0, 1e6]),
        ) {
            let Some((view, bounds)) = nested(seed, scale, parallel) else { return Ok(()) };
            let mut above = Some(Crossing::UNKNOWN);
            for bounds in &bounds {
                let here = above.and_then(|above| view.crossing(bounds, above));
                prop_assert_eq!(here.is_some(), view.sees_grown(bounds));
                prop_assert!(here.is_some() || !view.sees(bounds));
                let touches = view.touches(bounds);
                prop_assert!(!touches || here.is_none_or(Crossing::may_touch));
                above = here.map(|here| if touches { here } else { here.without_touch() });
            }
        }
    }

    #[test]
    fn planes_are_left_out_where_all_corners_are_inside() {
        let (mut crossed, mut inside, mut wrong) = (0, 0, 0);
        for seed in 0..2000 {
            let Some((view, bounds)) = nested(seed, 1.0, false) else { continue };
            for b in &bounds {
                let Some(crossing) = view.crossing(b, Crossing::UNKNOWN) else { continue };
                for (i, plane) in view.planes.iter().enumerate() {
                    let least = b
                        .corners()
                        .map(|c| plane.truncate().dot(c.as_dvec3()) + plane.w)
                        .into_iter()
                        .fold(f64::INFINITY, f64::min);
                    assert_eq!(crossing.bits() >> i & 1 == 1, least < 0.0);
                    if least < 0.0 { crossed += 1 } else { inside += 1 }
                }
            }
            // What a box crosses says nothing of one that it does not hold.
            let smallest = &bounds[bounds.len() - 1];
            if let Some(crossing) = view.crossing(smallest, Crossing::UNKNOWN) {
                let moved = Bounds { min: smallest.min - 99.0, max: smallest.max - 99.0 };
                wrong +=
                    usize::from(view.crossing(&moved, crossing).is_some() != view.sees(&moved));
            }
        }
        assert!(crossed > 1000 && inside > 1000 && wrong > 10, "{crossed} {inside} {wrong}");
    }
}
